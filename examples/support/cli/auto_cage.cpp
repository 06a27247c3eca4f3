#include "cli/auto_cage_model.hpp"

#include "cli/pose_operations.hpp"
#include "io/csv.hpp"
#include "svg/drawn_figure.hpp"

#include <cageform/enclose/make_cage.hpp>

#include <algorithm>
#include <cmath>
#include <span>

namespace cageform_support {

namespace {

std::string percent(double part) {
    return detail::short_number(std::round(part * 1000) / 10) + " %";
}

} // namespace

void add_cage(CommandLine& line, std::string& cage, CageFiles files) {
    const bool is_mesh = files == CageFiles::mesh || files == CageFiles::mesh_or_sites;
    std::string help =
        is_mesh ? "the cage: a closed mesh, faces counter-clockwise seen from outside"
                : "the cage: the first closed polygon of an SVG, for curved-green the first closed outline, "
                  "or a CSV "
                  "file of loops, chains and points";
    if (files == CageFiles::drawing_or_sites || files == CageFiles::mesh_or_sites)
        help += "; for sibson and sibson-c1 a file of points";
    line.add("--cage", cage, help + auto_cage_help).required();
}

CageChoice CageChoice::of(const std::string& word) {
    using Shape = cageform::CageShape;
    if (word.starts_with(lattice_prefix)) return {true, true, 0, 0, Shape::figure};
    const std::string name = word.substr(0, word.find(':'));
    CageChoice found{name == "auto" || name == "hull" || word == "box", false, 0, 0,
                     name == "hull"  ? Shape::hull
                     : name == "box" ? Shape::box
                                     : Shape::figure};
    if (!found.is_auto || word.size() == name.size()) return found;
    const std::string number = word.substr(name.size() + 1);
    if (number.ends_with('%')) {
        found.is_auto = parse_looseness(number, found.looseness).empty();
        return found;
    }
    double count = 0;
    found.is_auto = detail::parse_number(number, count).empty() && count >= 3 && count <= 1e6 &&
                    count == std::floor(count);
    found.vertices = found.is_auto ? std::size_t(count) : 0;
    return found;
}

AutoCage<CageFile> make_cage_for(const SvgDocument& figure, const cageform::MakeCageOptions& options) {
    const auto drawn = value_or_fail(drawn_figure(figure));
    const auto made = cageform::make_cage(cageform::Drawing(drawn.segments, drawn.areas), options);
    if (!made) {
        double farthest = 0;
        for (const auto& segment : drawn.segments) farthest = farthest_coordinate(segment.a.v, farthest);
        throw Failure(figure.name + ": " + no_cage(made.report, options, farthest));
    }
    std::vector<CageBlock> blocks;
    for (const auto& loop : made.value.loops()) {
        CageBlock block;
        for (std::size_t i = loop.begin; i < loop.end; ++i)
            block.points.push_back({rounded(made.value[i][0], made.report.clearance),
                                    rounded(made.value[i][1], made.report.clearance)});
        blocks.push_back(std::move(block));
    }
    return {make_cage("the cage of " + figure.name, std::move(blocks)), made.report};
}

CageFile make_lattice_for(const SvgDocument& figure, const LatticeWord& word, double margin) {
    const auto drawn = value_or_fail(drawn_figure(figure));
    std::vector<cageform::Vec<double, 2>> corners; // of boxes around the strokes
    for (const auto& segment : drawn.segments) {
        for (const auto& p : {segment.a, segment.b}) {
            for (const double r : {-segment.radius, segment.radius})
                corners.insert(corners.end(), {{p[0] + r, p[1] + r}, {p[0] + r, p[1] - r}});
        }
    }
    auto lattice = value_or_fail(lattice_about<2>(word, corners, margin, figure.name));
    return make_cage("the lattice about " + figure.name, std::move(lattice));
}

CageFile load_or_make_cage(const std::string& word, const SvgDocument& figure, CageEdges edges) {
    const CageChoice wanted = CageChoice::of(word);
    if (wanted.is_lattice) return lattice_by_word(word, figure);
    if (!wanted.is_auto) {
        auto cage = load_cage(word, edges);
        return value_or_fail(cage ? std::move(cage) : with_words(cage.error(), word));
    }
    auto made = made_by_word(wanted, figure);
    return edges == CageEdges::curves ? value_or_fail(with_curves(std::move(made.cage)))
                                      : std::move(made.cage);
}

std::string parse_looseness(const std::string& word, double& looseness) {
    const bool is_share = word.ends_with('%');
    const std::string number = is_share ? word.substr(0, word.size() - 1) : word;
    if (const std::string why = detail::parse_number(number, looseness); !why.empty()) return why;
    if (is_share) looseness /= 100;
    if (looseness > 0 && looseness < (is_share ? 100 : 1)) return {};
    return "a cage exceeds the tightest by a share above 0, such as 25% or 0.25";
}

namespace {

/// A table of cages by number of vertices, in roughly geometric steps below and above the cage that was made.
std::string doublings_of(const cageform::MakeCageReport& report, bool in_plane) {
    const auto& all = report.attempts;
    const auto made = std::find_if(all.begin(), all.end(),
                                   [&](const auto& attempt) { return attempt.vertices == report.vertices; });
    std::vector<cageform::MakeCageReport::Attempt> kept;
    std::size_t last = report.vertices;
    for (auto below = std::make_reverse_iterator(made); below != all.rend(); ++below) {
        if (5 * below->vertices > 4 * last) continue;
        kept.insert(kept.begin(), *below);
        last = below->vertices;
    }
    last = 0;
    for (auto above = made; above != all.end(); ++above) {
        if (5 * last > 4 * above->vertices) continue;
        kept.push_back(*above);
        last = above->vertices;
    }
    std::string table = in_plane ? "vertices  area over the tightest  deepest hollow spanned\n"
                                 : "vertices  volume over the tightest  deepest hollow spanned\n";
    for (const auto& attempt : kept) {
        table += formatted("%8zu  %*s  %22.3g%s\n", attempt.vertices, in_plane ? 22 : 24,
                           percent(attempt.excess).c_str(), attempt.hollow,
                           attempt.vertices == report.vertices ? "  <- made" : "");
    }
    return table;
}

} // namespace

std::string describe(const cageform::MakeCageReport& report, std::size_t dimension) {
    const bool in_plane = dimension == 2;
    const double looser = report.area / report.tightest_area - 1;
    return "cage: " + std::to_string(report.vertices) + " vertices, " +
           (report.tunnels > 0 ? detail::counted(report.tunnels, "tunnel") + ", " : "") +
           percent(std::fabs(looser)) + (looser < 0 ? " less " : " more ") + (in_plane ? "area" : "volume") +
           " than the tightest, least angle " + detail::short_number(std::round(report.least_angle)) +
           " degrees\nfigure: " +
           (report.components > 0 ? detail::counted(report.components, "part") + ", " +
                                        detail::counted(report.bridges, "bridge") + "; "
                                  : "") +
           detail::short_number(report.clearance) + " from the cage (" +
           percent(report.clearance / report.margin) + " of the margin)\n" +
           (report.attempts.empty() ? "" : doublings_of(report, in_plane));
}

std::string describe_quads(const cageform::MakeCageReport& report) {
    const double paired = 2 * double(report.quads), share = paired / (paired + double(report.triangles));
    return "faces: " + std::to_string(report.quads) + " quads and " + std::to_string(report.triangles) +
           " triangles; " + percent(share) + " of the triangles were paired; the diagonals of the most " +
           "warped quad are " + percent(report.worst_warp) + " of its mean edge apart\n";
}

std::string describe_rings(const cageform::MakeCageReport& report) {
    std::string text;
    for (const auto& part : report.parts.parts) {
        if (part.parent == 0) continue;
        text += (text.empty() ? "rings: about " : ", ") + std::to_string(part.number) + " (" +
                std::to_string(part.joint.size()) + (text.empty() ? " vertices)" : ")");
    }
    return text.empty() ? text : text + '\n';
}

std::vector<std::string> warnings_of(const cageform::MakeCageReport& report,
                                     const cageform::MakeCageOptions& options) {
    std::vector<std::string> warnings;
    const std::size_t wanted = options.vertices;
    const double excess = report.area / report.tightest_area - 1;
    const bool is_loose =
        options.looseness > 0 && !report.attempts.empty() && excess > options.looseness * (1 + 1e-9);
    if (is_loose && options.rings)
        warnings.push_back("the cage with rings has " + percent(excess) + " more volume than the tightest; " +
                           "for less, give a larger --vertices without --volume");
    else if (is_loose)
        warnings.push_back("no cage of up to " + std::to_string(report.attempts.back().vertices) +
                           " vertices is within " + detail::short_number(100 * options.looseness) + " %" +
                           " of the tightest; this one of " + std::to_string(report.vertices) + " has " +
                           percent(excess) + " more");
    else if (wanted != 0 && report.vertices > wanted + (options.mirror ? wanted % 2 : 0))
        warnings.push_back("the cage has " + std::to_string(report.vertices) +
                           " vertices; fewer are not enough");
    if (options.rings && describe_rings(report).empty())
        warnings.push_back("--rings: no limb was found, or every ring would take more than a "
                           "quarter of the vertices: the cage has no rings");
    return warnings;
}

template <std::size_t D>
std::vector<cageform::Vec<double, D>> first_pose(const std::vector<cageform::Vec<double, D>>& rest) {
    const auto box = cageform::bounds_of(std::span<const cageform::Vec<double, D>>(rest));
    const auto size = box.upper - box.lower;
    const auto axis = std::size_t(std::max_element(size.v, size.v + D) - size.v);
    const std::array<char, 3> names{'x', 'y', 'z'};
    const std::string word = formatted("all:%c%c,%.17g,%.17g,30", names[axis], names[(axis + 1) % D],
                                       0.5 * (box.lower[axis] + box.upper[axis]), box.lower[axis]);
    auto pose = rest;
    const std::string why = apply_operation<D>(PoseOperation::bend, word, std::span(rest), std::span(pose));
    return why.empty() ? pose : rest;
}

template std::vector<cageform::Vec<double, 2>> first_pose(const std::vector<cageform::Vec<double, 2>>&);
template std::vector<cageform::Vec<double, 3>> first_pose(const std::vector<cageform::Vec<double, 3>>&);

} // namespace cageform_support
