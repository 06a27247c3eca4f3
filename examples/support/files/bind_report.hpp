#pragma once

// The library's reports in words.

#include <cageform/binding/bind.hpp>

#include <optional>
#include <span>
#include <string>

namespace cageform_support {

constexpr std::size_t most_listed = 10; // faults or warnings

/// Returns how many of its two numbers a kind of fault uses.
int numbers_of(cageform::CageFaultKind kind);

/// "edges cross or touch (3, 7)", with only the numbers that mean something.
std::string describe_fault(const cageform::CageFault& fault);

/// One line per fault of the cage that prevents a bind: "cat_cage.svg: edges cross or touch (3, 7)".
std::string describe_faults(const std::string& name, const cageform::BindReport& report);
std::string describe_faults(const std::string& name, const cageform::CageReport& report);

/// An adaptive grid: its finest cells, where they are and why, and once it is solved what errors it leaves.
std::string describe_grid(const cageform::SolverReport& solver);

/// "the grid is coarse for the edge between vertices 3 and 9 and 11 more, …": of what no grid that was used
/// is fine enough for; empty where all errors are below CornerError::notable. Vertices are counted from 0
/// in the plane, from 1 in space, as OBJ files do.
std::string describe_corners(const cageform::SolverReport& solver);

/// Warns of that on stderr.
void warn_of_coarse_grid(const std::string& cage, const cageform::SolverReport& solver);

/// Adds the report of a batch of points to that of those before it; `first` is the number of its first
/// point.
void add_batch(cageform::BindReport& total, const cageform::BindReport& part, std::size_t first);

/// The report of a bind for people.
std::string describe(const cageform::BindReport& report);

/// The distance between a figure as it is stored and as it was bound.
struct StoredLoss {
    static constexpr double worth_a_warning = 0.01; // share of the figure's size

    double largest = 0, mean = 0;
    std::size_t vertex = 0; // of the largest
    double size = 0;        // what the share is of: the figure's diagonal, the length of vectors
    const char* size_of = "the figure's size";
    std::size_t poses = 0;      // that were looked at; 0: all in which no handle bends farther than `reach`
    std::optional<double> time; // of the pose of the largest, in seconds
    double reach = 0;
    bool has_vectors = false; // whether faces are handles too

    double share() const { return size > 0 ? largest / size : 0; }
};

/// "at most 0.0041 (0.099 % of the figure's size), at v 18 after 0.5 s, 0.0013 in the mean, in 52 poses of
/// the motion".
std::string describe(const StoredLoss& loss);

/// Says warnings on stderr. Those that say the same thing of several elements are one line, with the first
/// of them and how many more there are; of lines the first ten.
void print_warnings(std::span<const std::string> warnings);

} // namespace cageform_support
