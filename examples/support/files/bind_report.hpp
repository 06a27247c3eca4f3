#pragma once

// Formats the library's reports for people.

#include <cageform/binding/bind.hpp>
#include <cageform/core/vec.hpp>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

constexpr std::size_t most_listed = 10; // faults or warnings in a message

/// Number of indices that a kind of fault uses, 0 to 2.
int numbers_of(cageform::CageFaultKind kind);

/// "edges cross or touch (3, 7)", with the indices that the kind uses.
std::string describe_fault(const cageform::CageFault& fault);

/// One line per error of the cage: "cat_cage.svg: edges cross or touch (3, 7)".
std::string describe_faults(const std::string& name, const cageform::BindReport& report);
std::string describe_faults(const std::string& name, const cageform::CageReport& report);

/// Describes an adaptive grid: size, position and cause of the smallest cells; after a solve, also the error
/// estimates.
std::string describe_grid(const cageform::SolverReport& solver);

/// "the grid is coarse for the edge between vertices 3 and 9 and 11 more, …": edges and corners with an error
/// above CornerError::notable; empty if there are none. Vertices count from 0 in the plane, from 1 in space,
/// as in OBJ files.
std::string describe_corners(const cageform::SolverReport& solver);

/// Prints describe_corners() as a warning.
void warn_of_coarse_grid(const std::string& cage, const cageform::SolverReport& solver);

/// Merges the report of a batch of points into the total; `first` is the index of the batch's first point.
void add_batch(cageform::BindReport& total, const cageform::BindReport& part, std::size_t first);

/// Formats the report of a bind.
std::string describe(const cageform::BindReport& report);

/// The distance of the figure's vertices, as a file stores them, from their exact positions.
struct PackingLoss {
    static constexpr double worth_a_warning = 0.01; // relative to the figure's size

    double largest = 0, mean = 0;
    std::size_t vertex = 0; // with the largest distance
    double size = 0;        // reference of share(): the figure's diagonal, or the length of vectors
    const char* size_of = "the figure's size";
    std::size_t poses = 0;      // number of measured poses; 0: upper bounds for all poses within `reach`
    std::optional<double> time; // of the pose with the largest distance, in seconds
    double reach = 0;           // as PackReport::reach, in units of the figure
    bool has_vectors = false;   // whether vectors of faces are handles

    double share() const { return size > 0 ? largest / size : 0; }
};

/// "at most 0.0041 (0.099 % of the figure's size), at v 18 after 0.5 s, 0.0013 in the mean, in 52 poses of
/// the motion".
std::string describe(const PackingLoss& loss);

/// Prints warnings. Equal warnings on several elements become one line with the first element and a count. At
/// most 100 lines.
void print_warnings(std::span<const std::string> warnings);

/// "v 1 (0.1, 0.2, 0.3), …": the first three points of a list, with vertex numbers of the file.
std::string name_points(std::span<const cageform::Vec<double, 3>> points,
                        const std::vector<std::size_t>& indices);

} // namespace cageform_support
