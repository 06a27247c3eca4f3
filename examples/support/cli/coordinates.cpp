#include "cli/coordinates.hpp"

#include "cli/mesh_cage.hpp"

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>

namespace cageform_support {

std::string word_of(std::string name) {
    std::replace(name.begin(), name.end(), '_', '-');
    return name;
}

std::vector<cageform::CoordinateType> CoordinatesChoice::types() const {
    using namespace cageform::cage_kinds;
    const std::uint32_t cages = (in_plane ? polygon | curves : mesh) | (in_space ? mesh : 0u) | // NOLINT
                                (with_sites ? sites : 0u);
    std::vector<cageform::CoordinateType> taken;
    for (std::size_t n = 0; n < cageform::coordinate_facts.size(); ++n) {
        const cageform::CoordinateFacts& its = cageform::coordinate_facts[n];
        if ((its.cages & cages) != 0 && (with_normals || !its.with_normals))
            taken.push_back(cageform::CoordinateType(n));
    }
    return taken;
}

std::vector<std::string> CoordinatesChoice::names() const {
    std::vector<std::string> words;
    for (const cageform::CoordinateType its : types()) words.push_back(word_of(cageform::facts_of(its).name));
    return words;
}

cageform::CoordinateType CoordinatesChoice::type() const {
    for (std::size_t n = 0; n < cageform::coordinate_facts.size(); ++n) {
        if (word_of(cageform::coordinate_facts[n].name) == name) return cageform::CoordinateType(n);
    }
    std::abort(); // names come from the list
}

void SiteChoice::add_options(CommandLine& line) {
    if (with_weights)
        line.add("--weights", weights,
                 "sibson: a text file with a weight for each point; heavier points attract the figure more");
    line.add("--surround", surround,
             "sibson and sibson-c1: add the corners of a box around everything as points that do not move, "
             "so that nothing is outside; the value is the box's margin, in diagonals of figure and points; "
             "0 adds no box")
        .range(0.0, 1e6)
        .show_default();
}

std::string SiteChoice::fault(const CoordinatesChoice& choice) const {
    if (!choice.takes_sites() && (!weights.empty() || surround > 0))
        return "--weights and --surround apply to points without a cage: use --coordinates sibson";
    if (choice.name == "sibson-c1" && !weights.empty())
        return "--weights: sibson-c1 has negative weights; use --coordinates sibson, which has none";
    return {};
}

namespace {

void add_faces(CommandLine& line, CoordinatesChoice& choice) {
    line.add("--faces", choice.faces,
             "faces of more than three corners in space: planar keeps planar faces, with 2D coordinates "
             "in each (mean-value, harmonic), and divides the others into fans about the mean of their "
             "corners; fan divides all into fans; triangles cuts them into triangles")
        .one_of({"planar", "fan", "triangles"})
        .show_default();
    line.add("--divisions", choice.divisions,
             "mean-value, harmonic: divide faces of four corners in space into N x N cells, each a fan, "
             "so that weights on them are nearly bilinear; a bind takes about 2 N^2 times as long, and "
             "above 1 all faces of more than three corners are fans")
        .range(1, 64)
        .show_default();
}

void add_disk(CommandLine& line, CoordinatesChoice& choice) {
    line.add_flag(
        "--disk", choice.in_disk,
        "curved-green: use Green's function of the smallest disk around the cage; the figure follows "
        "a round cage more closely, and angles change a little");
    line.add_number(
            "--disk-radius",
            [&choice](double radius) {
                choice.in_disk = true;
                choice.disk_radius = radius;
            },
            "curved-green: use Green's function of a disk of this radius instead of the smallest")
        .range(1e-100, 1e100)
        .rarely_needed();
}

void add_harmonic(CommandLine& line, CoordinatesChoice& choice) {
    const CommandOption accuracy = line.add("--accuracy", choice.harmonic.accuracy,
                                            "harmonic: the target for the largest error of a weight, 1e-5 to "
                                            "0.1; the grid adapts to the cage's narrow parts")
                                       .range(1e-5, 0.1)
                                       .show_default();
    line.add("--locality", choice.harmonic.locality,
             "harmonic: weights decrease faster with the distance from a vertex, so that each point has "
             "fewer; 20 leaves out a tenth of the weights above 1 %, 40 a fifth")
        .range(0.0, double{cageform::HarmonicOptions::most_locality})
        .show_default();
    if (choice.limits_memory) {
        line.add_number(
                "--memory",
                [&choice](double megabytes) { choice.memory = std::size_t(megabytes * (1 << 20)); },
                "harmonic: the most memory for the grid and its solver, in MB; if they need more, the "
                "program stops before it solves")
            .range(1.0, 1e8)
            .show_default("half of what is free");
    }
    line.add("--resolution", choice.resolution,
             "harmonic: use a uniform grid with this many cells along the cage's longest side")
        .range(8, 16384)
        .excludes(accuracy)
        .show_default("none; if --tolerance is given, 128 in the plane, 64 in space")
        .rarely_needed();
    line.add_number(
            "--tolerance",
            [&choice](double t) {
                choice.harmonic.multigrid.tolerance = t;
                choice.is_uniform = true;
            },
            "harmonic: the solver of the uniform grid stops below this error")
        .excludes(accuracy)
        .show_default("1e-06")
        .rarely_needed();
}

} // namespace

void CoordinatesChoice::add_options(CommandLine& line) {
    std::string help;
    for (const cageform::CoordinateType its : types()) {
        const cageform::CoordinateFacts& facts = cageform::facts_of(its);
        help += (help.empty() ? "" : ", ") + word_of(facts.name) + " (" + facts.description +
                (facts.has_extension ? "; defined outside too)" : ")");
    }
    line.add_text(
            "--coordinates",
            [this](const std::string& given) {
                name = given;
                is_named = true;
            },
            help)
        .one_of(names())
        .show_default(name);
    if (in_space) add_faces(line, *this);
    if (with_sites) {
        line.add("--gradients", gradients,
                 "sibson-c1: the estimate of the gradients at the points: facets, gentle (less negative "
                 "weights) or mirrored (for rings of points)")
            .one_of({"facets", "gentle", "mirrored"})
            .show_default()
            .rarely_needed();
    }
    if (in_plane && with_normals) add_disk(line, *this);
    add_harmonic(line, *this);
}

/// Returns the available memory in bytes, if the system reports it (Linux).
std::optional<std::size_t> available_memory() {
    std::ifstream file("/proc/meminfo");
    std::string line;
    std::size_t kilobytes = 0;
    while (std::getline(file, line)) {
        if (std::sscanf(line.c_str(), "MemAvailable: %zu kB", &kilobytes) == 1) return kilobytes * 1024;
    }
    return std::nullopt;
}

cageform::HarmonicOptions CoordinatesChoice::harmonic_options(std::size_t dimension) const {
    cageform::HarmonicOptions options = harmonic;
    if (memory != 0)
        options.memory_limit = memory;
    else if (const auto free = available_memory())
        options.memory_limit = *free / 2;
    options.resolution = resolution;
    if (resolution == 0 && is_uniform) options.resolution = dimension == 2 ? 128 : 64;
    return options;
}

std::vector<std::string> outside_words() {
    return {
#define CAGEFORM_EXAMPLES_WORD(name, ...) word_of(#name),
        CAGEFORM_OUTSIDE_POINTS(CAGEFORM_EXAMPLES_WORD)
#undef CAGEFORM_EXAMPLES_WORD
    };
}

void OutsideChoice::add_options(CommandLine& line) {
    std::vector<std::string> words = outside_words();
    if (!can_extend) std::erase(words, "extend");
    words.insert(words.end(), {"auto", "refuse"});
    line.add("--outside", word,
             std::string("what points outside the cage do: keep-in-place, nearest-boundary (follow the "
                         "nearest boundary point), refuse (an error)") +
                 (can_extend ? ", extend (use the coordinates, if they are defined outside) or auto (extend "
                               "if possible, else nearest-boundary"
                             : " or auto (nearest-boundary") +
                 (with_sites ? "; keep-in-place with sibson; with a warning)" : ", with a warning)"))
        .one_of(words)
        .show_default();
    if (can_fade) add_falloff(line, falloff);
}

void OutsideChoice::add_falloff(CommandLine& line, double& falloff) {
    line.add("--falloff", falloff,
             "the distance from the cage, in its units, at which the displacements of points outside have "
             "faded to 0, so that a cage can enclose a part of the figure; below 1.5 times the largest "
             "displacement, the figure may fold there; 0: no fading")
        .range(0.0, 1e100)
        .show_default();
}

std::string OutsideChoice::fault() const {
    if (falloff > 0 && (word == "keep-in-place" || word == "refuse"))
        return "--falloff: with --outside " + word + " no point outside moves";
    return {};
}

template <cageform::Scalar T, std::size_t D>
cageform::BindOptions OutsideChoice::bind_options(const ChosenCoordinates<T, D>& coordinates) const {
    cageform::BindOptions options;
    if (word == "extend" || (word == "auto" && can_extend && coordinates.has_extension())) {
        options.outside = cageform::OutsidePoints::extend;
        options.falloff = coordinates.has_extension() ? falloff : 0; // otherwise judge() refuses the options
    } else if (word == "nearest-boundary" || (word == "auto" && falloff > 0) ||
               ((word == "auto" || word == "refuse") &&
                !coordinates.takes_sites)) { // for points just outside, within the tolerance
        options.outside = cageform::OutsidePoints::nearest_boundary;
        options.falloff = falloff;
    } else {
        options.outside = cageform::OutsidePoints::keep_in_place;
    }
    return options;
}

template <cageform::Scalar T, std::size_t D>
OutsideChoice::Verdict
OutsideChoice::judge(const ChosenCoordinates<T, D>& coordinates, const cageform::BindReport& report,
                     std::span<const std::conditional_t<D == 2, Point2, Point3>> points,
                     const std::string& figure, const std::string& cage) const {
    const std::string what = D == 2 ? " points of " : has_splats ? " splats of " : " vertices of ";
    const auto names_of = [&](const std::vector<std::size_t>& listed) {
        return has_splats && !listed.empty() ? "splat " + std::to_string(listed[0]) + " (counted from 0)"
                                             : name_points(points, listed);
    };
    const std::string found = std::to_string(report.outside.size()) + " of " + std::to_string(report.points) +
                              what + figure + " lie outside the " +
                              (coordinates.takes_sites ? "convex hull of " : "cage ") + cage + ", first " +
                              names_of(report.outside);
    // Finding the nearest boundary points of many points is slow, so it is done only for messages.
    double largest = 0;
    const bool needs_message = word == "refuse" || (word == "auto" && !cage_is_made && falloff == 0);
    for (std::size_t n = 0; needs_message && n < report.outside.size(); ++n) {
        const std::size_t i = report.outside[n];
        cageform::Vec<T, D> p{};
        if constexpr (D == 2)
            p = {T(points[i].x), T(points[i].y)};
        else
            p = cageform::vec_cast<T>(points[i] - origin);
        if (cageform::is_finite(p)) largest = std::max(largest, coordinates.distance_from_boundary(p));
    }
    const bool some = !report.outside.empty() && (!needs_message || coordinates.takes_sites ||
                                                  largest > coordinates.boundary_tolerance());
    std::ostringstream distance;
    distance.precision(2);
    distance << "; the largest distance from the boundary is " << largest;
    if (!coordinates.takes_sites) distance << ", and the tolerance " << coordinates.boundary_tolerance();
    if (some && word == "refuse")
        return {found + "; use --outside to choose their treatment" + distance.str(), {}};
    if (some && word == "extend" && !coordinates.has_extension())
        return {found + "; these coordinates are not defined outside" +
                    (coordinates.takes_sites ? "" : " the cage"),
                {}};
    if (!report.unreached.empty()) {
        return {figure + ": no weights can be computed for " + names_of(report.unreached) +
                    (coordinates.takes_sites     ? ": their weights exceed the range of numbers"
                     : coordinates.closed_form() ? ": they are too far from the cage"
                                                 : ": the grid is too coarse; raise --resolution"),
                {}};
    }
    if (!some || word != "auto" || cage_is_made || falloff > 0) return {};
    if (!of_part && 2 * report.outside.size() > report.points && !coordinates.takes_sites)
        return {found + ": does this cage belong to another figure? Use --outside to choose their treatment" +
                    distance.str(),
                {}};
    const auto done = bind_options(coordinates).outside;
    return {
        {},
        found + "; they " +
            (done == cageform::OutsidePoints::extend ? "follow the extension of the coordinates"
             : done == cageform::OutsidePoints::keep_in_place
                 ? coordinates.takes_sites ? "stay in place, and the figure may tear there" : "stay in place"
                 : "follow the nearest points of the boundary") +
            (coordinates.takes_sites ? " (--surround, --outside)" : " (--outside)") + distance.str()};
}

template cageform::BindOptions OutsideChoice::bind_options(const ChosenCoordinates<double, 2>&) const;
template cageform::BindOptions OutsideChoice::bind_options(const ChosenCoordinates<double, 3>&) const;
template cageform::BindOptions OutsideChoice::bind_options(const ChosenCoordinates<float, 3>&) const;
template OutsideChoice::Verdict OutsideChoice::judge(const ChosenCoordinates<double, 2>&,
                                                     const cageform::BindReport&, std::span<const Point2>,
                                                     const std::string&, const std::string&) const;
template OutsideChoice::Verdict OutsideChoice::judge(const ChosenCoordinates<double, 3>&,
                                                     const cageform::BindReport&, std::span<const Point3>,
                                                     const std::string&, const std::string&) const;
template OutsideChoice::Verdict OutsideChoice::judge(const ChosenCoordinates<float, 3>&,
                                                     const cageform::BindReport&, std::span<const Point3>,
                                                     const std::string&, const std::string&) const;

} // namespace cageform_support
