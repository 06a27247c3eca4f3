#include "files/cage_file.hpp"

#include "io/atomic_file.hpp"
#include "svg/document.hpp"

#include <numeric>
#include <sstream>

namespace cageform_support {

namespace {

using detail::counted, detail::digits_of;

std::string digits_of(const Point2& p) {
    return digits_of(p.x) + ',' + digits_of(p.y);
}

} // namespace

CageFile make_cage(std::string name, std::vector<CageBlock> blocks) {
    CageFile cage{std::move(name), std::move(blocks), {}, {}};
    cageform::CellComplex<double, 2> complex(cage.polygon<double>());
    std::size_t first = 0;
    for (const CageBlock& block : cage.blocks) {
        auto& handles = cage.handles.emplace_back(CageFile::add_cells(complex, block));
        if (block.kind != CageBlock::Kind::loop) continue;
        handles.resize(block.points.size());
        std::iota(handles.begin(), handles.end(), first);
        first += handles.size();
    }
    for (const auto& v : complex.vertices()) cage.vertices.push_back({v[0], v[1]});
    return cage;
}

CageFile make_cage(std::string name, LatticeBox<2> lattice) {
    CageFile cage{std::move(name), {}, {}, {}};
    cage.lattice = std::move(lattice);
    const auto coordinates = cage.lattice->coordinates<double>();
    for (const auto& handle : coordinates.handles()) cage.vertices.push_back({handle[0], handle[1]});
    const std::array counts{coordinates.points(0), coordinates.points(1)}, strides{std::size_t{1}, counts[0]};
    for (std::size_t k = 0; k < 2; ++k) { // rows, then columns
        for (std::size_t n = 0; n < counts[1 - k]; ++n) {
            CageBlock line{CageBlock::Kind::chain, 0, {}};
            auto& handles = cage.handles.emplace_back();
            for (std::size_t i = 0; i < counts[k]; ++i) {
                handles.push_back(n * strides[1 - k] + i * strides[k]);
                line.points.push_back(cage.vertices[handles.back()]);
            }
            cage.blocks.push_back(std::move(line));
        }
    }
    return cage;
}

namespace {

bool has_curves(const std::vector<Subpath>& outline) {
    return std::any_of(outline.begin(), outline.end(), [](const Subpath& loop) {
        return !std::all_of(loop.segments.begin(), loop.segments.end(),
                            [](const Segment& s) { return s.is_line(); });
    });
}

/// Path data of closed loops that restores every bit.
std::string path_data_of(const std::vector<Subpath>& outline) {
    std::string path;
    for (const Subpath& loop : outline) {
        path += 'M' + digits_of(loop.start);
        Point2 from = loop.start;
        for (const Segment& s : loop.segments) {
            path += s.degree == 1 ? "L" : s.degree == 2 ? "Q" : "C";
            if (s.degree == 2) path += digits_of(quadratic_control(from, s.p1)) + ' ';
            if (s.degree == 3) path += digits_of(s.p1) + ' ' + digits_of(s.p2) + ' ';
            path += digits_of(s.p3);
            from = s.p3;
        }
        path += 'Z';
    }
    return path;
}

} // namespace

Expected<CageFile> load_cage(const std::string& path, CageEdges edges) {
    if (is_lattice_path(path)) {
        auto lattice = load_lattice<2>(path);
        if (!lattice) return lattice.error();
        return make_cage(path, std::move(*lattice));
    }
    if (path.ends_with(".csv")) {
        auto blocks = read_cage_csv(path);
        if (!blocks) return blocks.error();
        CageFile cage = make_cage(path, std::move(*blocks));
        return edges == CageEdges::curves ? with_curves(std::move(cage)) : cage;
    }
    const auto document = load_svg(path);
    if (!document) return document.error();
    auto loops = first_polygon(*document);
    if (!loops || edges == CageEdges::curves) {
        const auto outline = first_outline(*document);
        if (outline && edges != CageEdges::lines) return make_curved_cage(path, *outline);
        if (edges != CageEdges::lines) return outline.error();
        if (outline && has_curves(*outline))
            return FileError{loops.error().message + "; --coordinates curved-green takes curves"};
        return loops.error();
    }
    std::vector<CageBlock> blocks;
    for (auto& loop : *loops) blocks.push_back({CageBlock::Kind::loop, 0, std::move(loop)});
    return make_cage(path, std::move(blocks));
}

Expected<std::string> to_svg(const CageFile& cage, const ViewBox& view) {
    std::string path = cage.curves ? path_data_of(cage.outline()) : "", lines;
    for (const CageBlock& block : cage.curves ? std::vector<CageBlock>() : cage.blocks) {
        if (cage.lattice) {
            lines += "<polyline points=\"";
            for (const Point2& p : block.points) lines += (lines.back() == '"' ? "" : " ") + digits_of(p);
            lines += "\"/>\n";
            continue;
        }
        if (block.points.front() == block.points.back())
            return FileError{cage.name + ": two vertices lie at the same position, " +
                             name_points(block.points, {0}) +
                             ", which an SVG file cannot store; a CSV file can"};
        for (const Point2& p : block.points)
            path += (path.empty() || path.back() == 'Z' ? "M" : " ") + digits_of(p);
        path += 'Z';
    }
    const auto numbers = [](double x, double y) { return digits_of(x) + ' ' + digits_of(y); };
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" + numbers(view.x, view.y) + ' ' +
           numbers(view.width, view.height) + "\">\n<" + (cage.lattice ? "g" : "path") +
           " fill=\"none\" stroke=\"#c2377a\" stroke-width=\"" +
           detail::short_number(std::hypot(view.width, view.height) / 400) + "\" stroke-linejoin=\"round\"" +
           (cage.lattice ? ">\n" + lines + "</g>" : " d=\"" + path + "\"/>") + "\n</svg>\n";
}

std::string to_csv(const CageFile& cage) {
    std::string text;
    for (std::size_t i = 0; cage.lattice && i < cage.lattice->points(); ++i)
        text +=
            (i > 0 && i % cage.lattice->axes[0].points == 0 ? "\n" : "") + digits_of(cage.vertices[i]) + '\n';
    if (cage.lattice) return text;
    for (const CageBlock& block : cage.blocks) {
        if (!text.empty()) text += '\n';
        if (block.kind == CageBlock::Kind::chain) text += "# chain\n";
        if (block.kind == CageBlock::Kind::point) text += "# point " + digits_of(block.radius) + '\n';
        for (const Point2& p : block.points) text += digits_of(p) + '\n';
    }
    return text;
}

Expected<std::string> pose_text(const CageFile& pose, const std::string& path, const ViewBox& view) {
    const bool is_csv = lowercase_extension(path) == ".csv";
    if (!is_csv && pose.has_cells() && !pose.lattice)
        return FileError{path + ": " + pose.name + " has chains or points, which need a .csv file"};
    if (is_csv && pose.curves)
        return FileError{path + ": " + pose.name + " has curves, which need an .svg file"};
    if (is_csv) return to_csv(pose);
    const auto text = to_svg(pose, view);
    return text ? text : FileError{path + ": " + to_string(text.error())};
}

namespace {

/// Draws ends of edges as squares, and inner control points as circles connected by thin lines.
void draw_curve_handles(pugi::xml_node group, const CageFile& cage, double diagonal) {
    const double size = diagonal / 120;
    auto marks = group.append_child("g");
    marks.append_attribute("stroke-width") = diagonal / 1000;
    marks.append_attribute("stroke-dasharray") = "none";
    marks.append_attribute("fill") = "white";
    std::string lines;
    const auto add = [&](const Point2& end, const Point2& control) {
        lines += write_path_data({{end, {{control, control, control, 1}}}}, 3);
        auto circle = marks.append_child("circle");
        circle.append_attribute("cx") = control.x;
        circle.append_attribute("cy") = control.y;
        circle.append_attribute("r") = size / 2;
    };
    for (const Subpath& loop : cage.outline()) {
        Point2 from = loop.start;
        for (const Segment& s : loop.segments) {
            if (!s.is_line()) {
                add(from, s.p1);
                add(s.p3, s.p2);
            }
            auto square = marks.append_child("rect");
            square.append_attribute("x") = from.x - size / 2;
            square.append_attribute("y") = from.y - size / 2;
            for (const char* side : {"width", "height"}) square.append_attribute(side) = size;
            from = s.p3;
        }
    }
    if (!lines.empty()) marks.prepend_child("path").append_attribute("d") = lines.c_str();
}

} // namespace

void draw_cage(SvgDocument& document, const CageFile& cage, double diagonal, const std::string& colour) {
    auto group = document.xml.document_element().append_child("g");
    group.append_attribute("fill") = "none";
    group.append_attribute("stroke") = colour.c_str();
    group.append_attribute("stroke-width") = diagonal / 400;
    group.append_attribute("stroke-linejoin") = "round";
    group.append_attribute("stroke-dasharray") = diagonal / 100;
    if (cage.curves) {
        const auto outline = cage.outline();
        group.append_child("path").append_attribute("d") = write_path_data(outline, 3).c_str();
        return draw_curve_handles(group, cage, diagonal);
    }
    for (const CageBlock& block : cage.blocks) {
        const Point2& first = block.points.front();
        if (block.kind == CageBlock::Kind::point) {
            auto circle = group.append_child("circle");
            circle.append_attribute("cx") = first.x;
            circle.append_attribute("cy") = first.y;
            if (block.radius > 0) {
                circle.append_attribute("r") = block.radius;
            } else { // a site: a dot
                circle.append_attribute("r") = diagonal / 120;
                circle.append_attribute("fill") = colour.c_str();
                circle.append_attribute("stroke") = "none";
            }
            continue;
        }
        Subpath line;
        line.start = first;
        line.closed = block.kind == CageBlock::Kind::loop;
        for (std::size_t k = 1; k < block.points.size() + (line.closed ? 1 : 0); ++k) {
            const Point2& p = block.points[k % block.points.size()];
            line.segments.push_back({p, p, p, 1});
        }
        group.append_child("path").append_attribute("d") = write_path_data({line}, 3).c_str();
    }
}

std::vector<cageform::Vec<double, 2>> CageFile::places() const {
    std::vector<cageform::Vec<double, 2>> places;
    places.reserve(vertices.size());
    for (const Point2& p : vertices) places.push_back({p.x, p.y});
    return places;
}

CageFile moved_cage(CageFile cage, std::span<const cageform::Vec<double, 2>> places) {
    if (cage.curves) {
        for (auto& degrees : cage.curves->degrees) std::fill(degrees.begin(), degrees.end(), 3U);
    }
    for (std::size_t i = 0; i < places.size(); ++i) cage.vertices[i] = {places[i][0], places[i][1]};
    for (std::size_t b = 0; b < cage.blocks.size(); ++b) {
        for (std::size_t k = 0; k < cage.handles[b].size(); ++k)
            cage.blocks[b].points[k] = cage.vertices[cage.handles[b][k]];
    }
    return cage;
}

std::string name_points(std::span<const Point2> points, const std::vector<std::size_t>& indices) {
    std::ostringstream text;
    for (std::size_t n = 0; n < std::min<std::size_t>(indices.size(), 3); ++n) {
        const Point2& p = points[indices[n]];
        text << (n == 0 ? "" : ", ") << '(' << p.x << ", " << p.y << ')';
    }
    if (indices.size() > 3) text << ", …";
    return text.str();
}

std::string describe(const CageBlock& block) {
    std::ostringstream text;
    switch (block.kind) {
    case CageBlock::Kind::loop: text << "a loop of " << block.points.size() << " vertices"; break;
    case CageBlock::Kind::chain: text << "a chain of " << block.points.size() << " points"; break;
    case CageBlock::Kind::point: text << "a point of radius " << block.radius; break;
    }
    return text.str();
}

Expected<CageFile> make_pose(CageFile pose, const CageFile& cage) {
    if (cage.curves) return make_curved_pose(std::move(pose), cage);
    const auto differ = [&](const std::string& where, const std::string& has, const std::string& expected) {
        return FileError{pose.name + ": " + where + "the pose has " + has + ", the cage " + cage.name + " " +
                         expected};
    };
    const std::size_t count = cage.blocks.size();
    for (std::size_t b = 0; b < std::min(pose.blocks.size(), count); ++b) {
        const CageBlock &is = pose.blocks[b], &was = cage.blocks[b];
        if (is.kind == was.kind && is.points.size() == was.points.size() && is.radius == was.radius) continue;
        return differ(count > 1 ? "block " + std::to_string(b + 1) + ": " : "", describe(is), describe(was));
    }
    if (pose.blocks.size() != count)
        return differ("", counted(pose.blocks.size(), "block"), counted(count, "block"));

    pose.handles = cage.handles;
    pose.vertices.resize(cage.vertices.size());
    std::vector<bool> known(cage.vertices.size());
    for (std::size_t b = 0; b < count; ++b) {
        for (std::size_t k = 0; k < pose.handles[b].size(); ++k) {
            const std::size_t i = pose.handles[b][k];
            const Point2& p = pose.blocks[b].points[k];
            if (known[i] && !(p == pose.vertices[i])) {
                std::ostringstream text;
                text << pose.name << ": vertex " << i << " of the cage " << cage.name << " is at ("
                     << pose.vertices[i].x << ", " << pose.vertices[i].y << ") and, in block " << b + 1
                     << ", at (" << p.x << ", " << p.y << ')';
                return FileError{text.str()};
            }
            pose.vertices[i] = p;
            known[i] = true;
        }
    }
    return pose;
}

Expected<CageFile> make_lattice_pose(const std::string& name, const std::vector<std::vector<Point2>>& lines,
                                     const CageFile& cage) {
    const auto& axes = cage.lattice->axes;
    if (lines.size() != cage.blocks.size())
        return FileError{name + ": holds " + counted(lines.size(), "line") + ", and the lattice " +
                         cage.name + " has " + counted(axes[1].points, "row") + " and " +
                         counted(axes[0].points, "column")};
    CageFile pose = cage;
    pose.name = name;
    const auto rest = cage.places();
    const double rounding = 1e-6 * cageform::bounds_of(std::span(rest)).diagonal(); // by editors
    const auto differ = [&](const Point2& p, const Point2& q) {
        return !(std::hypot(p.x - q.x, p.y - q.y) <= rounding);
    };
    std::vector<char> moved(cage.vertices.size());
    for (std::size_t b = 0; b < lines.size(); ++b) {
        const bool is_row = b < axes[1].points;
        const std::string line =
            is_row ? "row " + std::to_string(b) : "column " + std::to_string(b - axes[1].points);
        if (lines[b].size() != cage.blocks[b].points.size())
            return FileError{name + ": line " + std::to_string(b + 1) + ", " + line +
                             " of the lattice, has " + counted(lines[b].size(), "point") + " in place of " +
                             std::to_string(cage.blocks[b].points.size())};
        for (std::size_t k = 0; k < lines[b].size(); ++k) {
            const std::size_t i = cage.handles[b][k];
            const Point2& p = lines[b][k];
            const bool has_moved = differ(p, cage.vertices[i]);
            if (is_row || (has_moved && moved[i] == 0)) {
                pose.vertices[i] = p;
                moved[i] = has_moved ? 1 : 0;
            } else if (has_moved && differ(p, pose.vertices[i])) {
                return FileError{name + ": point " + std::to_string(i) + " of the lattice " + cage.name +
                                 " is at " + name_points(pose.vertices, {i}) + " in its row and at " +
                                 name_points(lines[b], {k}) + " in " + line + "; move it in both, or in one"};
            }
        }
    }
    return moved_cage(pose, pose.places());
}

namespace {

Expected<CageFile> load_lattice_pose(const std::string& path, const CageFile& cage) {
    if (!path.ends_with(".csv")) {
        const auto document = load_svg(path);
        if (!document) return document.error();
        const auto lines = straight_lines(*document);
        if (!lines) return lines.error();
        return make_lattice_pose(path, *lines, cage);
    }
    auto places = cage.places();
    std::size_t count = 0;
    PointReader<2> reader(path);
    for (std::vector<std::array<double, 2>> next; reader.read(next, 1); ++count) {
        if (count < cage.lattice->points()) places[count] = {next.front()[0], next.front()[1]};
    }
    if (!reader.error().empty()) return FileError{reader.error()};
    if (count != cage.lattice->points())
        return FileError{path + ": holds " + std::to_string(count) + " points, and the lattice " + cage.name +
                         " has " + std::to_string(cage.lattice->points())};
    CageFile pose = moved_cage(cage, places);
    pose.name = path;
    return pose;
}

} // namespace

Expected<CageFile> load_pose(const std::string& path, const CageFile& cage) {
    if (cage.lattice) return load_lattice_pose(path, cage);
    auto pose = load_cage(path, cage.curves ? CageEdges::curves : CageEdges::lines);
    return pose ? make_pose(std::move(*pose), cage) : pose;
}

} // namespace cageform_support
