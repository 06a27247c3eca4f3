#include "pictures/field_plot.hpp"

#include "io/csv.hpp"

#include <cmath>
#include <iterator>
#include <map>
#include <utility>

namespace cageform_support {

Colour sign_root(double value) {
    const float s = std::sqrt(float(std::min(std::fabs(value), 1.0)));
    return value >= 0 ? Colour{s, s, 0} : Colour{0, s, 0};
}

void FieldStyle::set_range(double from, double to) {
    zero = from;
    one = to;
    step = levels == 0 ? 0 : (to - from) / double(levels);
}

std::optional<PlaneBox> parse_box(const std::string& text) {
    std::array<double, 4> number{}; // x, y, width, height
    std::string_view rest = text;
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t end = std::min(rest.find(','), rest.size());
        if ((end == rest.size()) != (k == 3)) return {};
        if (!detail::parse_number(detail::trim(rest.substr(0, end)), number[k]).empty()) return {};
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    const auto& [x, y, width, height] = number;
    const PlaneBox box{{x, y}, {x + width, y + height}};
    const bool is_finite =
        std::isfinite(x) && std::isfinite(y) && std::isfinite(width) && std::isfinite(height);
    return is_finite && box.width() > 0 && box.height() > 0 ? std::optional(box) : std::nullopt;
}

std::string box_fault(const std::string& text) {
    return parse_box(text) ? ""
                           : detail::quoted(text) + " is not a part of the plane: write x,y,width,height";
}

std::optional<std::array<double, 2>> clip_segment(const Point2& a, const Point2& b, const PlaneBox& box) {
    double from = 0, to = 1;
    const auto keep = [&](double start, double step, double low, double high) {
        if (step == 0) return start >= low && start <= high;
        const double s = (low - start) / step, t = (high - start) / step;
        from = std::max(from, std::min(s, t));
        to = std::min(to, std::max(s, t));
        return from < to;
    };
    if (!keep(a.x, b.x - a.x, box.low.x, box.high.x) || !keep(a.y, b.y - a.y, box.low.y, box.high.y))
        return {};
    return std::array{from, to};
}

std::array<double, 2> least_and_largest(std::span<const double> values) {
    std::array<double, 2> range{0, 0};
    bool is_first = true;
    for (const double value : values) {
        if (std::isnan(value)) continue;
        range = {is_first ? value : std::min(range[0], value), is_first ? value : std::max(range[1], value)};
        is_first = false;
    }
    return range;
}

Picture draw_field(std::span<const double> values, std::size_t width, const FieldStyle& style) {
    const std::size_t height = values.size() / width;
    Picture picture(width, height, style.outside());
    const double step = style.step;
    const auto differ = [&](double a, double b) { // false for NaN
        const auto level = [&](double value) { return std::floor((value - style.zero) / step + 1e-9); };
        return step > 0 && !std::isnan(a) && !std::isnan(b) && level(a) != level(b);
    };
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t i = y * width + x;
            if (std::isnan(values[i])) continue;
            picture.at(x, y) = style.colour(values[i]);
            if ((x + 1 < width && differ(values[i], values[i + 1])) ||
                (y + 1 < height && differ(values[i], values[i + width]))) {
                picture.at(x, y) = mix(picture.at(x, y), style.ink(), 0.75f);
            }
        }
    }
    return picture;
}

Picture with_colour_bar(const Picture& picture, double from, double to, const FieldStyle& style) {
    if (!style.colour_bar) return picture;
    const double letter = std::max(1.5, double(style.size) / 450); // 1/7 of a letter's height
    Picture wide(picture.width() + std::size_t(56 * letter), picture.height());
    wide.place(picture, 0);
    const Axis bar{from, to, 0.96 * double(picture.height()), 0.04 * double(picture.height())};
    const int most_marks = std::clamp(int((bar.begin - bar.end) / (16 * letter)), 1, 10);
    draw_colour_bar(wide, bar, marks_of(bar, most_marks), double(picture.width()) + 4 * letter, 12 * letter,
                    letter, [&](double value) { return style.colour(value); });
    return wide;
}

namespace {

/// Appends the end of a side to a polygon, preceded by its crossings with columns. Both adjacent pieces share
/// these points exactly.
void append_cut(std::vector<Point2>& polygon, const Point2& end, const std::vector<double>& columns) {
    const Point2 start = polygon.back();
    const auto append = [&](double x) {
        if ((start.x < x) == (x < end.x) && x != start.x && x != end.x)
            polygon.push_back({x, start.y + (x - start.x) / (end.x - start.x) * (end.y - start.y)});
    };
    if (start.x < end.x)
        std::for_each(columns.begin(), columns.end(), append);
    else
        std::for_each(columns.rbegin(), columns.rend(), append);
    polygon.push_back(end);
}

/// Triangulates convex polygons; equal points are merged.
class MeshBuilder {
public:
    PlaneMesh mesh;

    /// `corners`: loop vertices on the polygon's horizontal sides, which become corners.
    void add(const std::vector<Point2>& polygon, const std::vector<Point2>& corners) {
        std::vector<std::uint32_t> ring;
        std::size_t added = 0;
        for (std::size_t k = 0; k < polygon.size(); ++k) {
            const Point2 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
            push(ring, index(a));
            std::vector<Point2> between;
            for (const Point2& c : corners) {
                if (a.y == b.y && c.y == a.y && (c.x - a.x) * (c.x - b.x) < 0) between.push_back(c);
            }
            std::sort(between.begin(), between.end(), [&](const Point2& c, const Point2& d) {
                return (c.x < d.x) == (a.x < b.x) && c.x != d.x;
            });
            for (const Point2& c : between) push(ring, index(c));
            added += between.size();
        }
        while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
        if (ring.size() < 3) return;
        std::uint32_t apex = ring[0];
        if (added != 0) { // corners on a line: fan from the centre
            Point2 middle{};
            for (const std::uint32_t i : ring) {
                middle.x += mesh.places[i].x / double(ring.size());
                middle.y += mesh.places[i].y / double(ring.size());
            }
            apex = index(middle);
        }
        for (std::size_t k = 0; k < ring.size(); ++k) {
            const std::uint32_t a = ring[k], b = ring[(k + 1) % ring.size()];
            if (a != apex && b != apex) mesh.triangles.push_back({apex, a, b});
        }
    }

private:
    static void push(std::vector<std::uint32_t>& ring, std::uint32_t i) {
        if (ring.empty() || ring.back() != i) ring.push_back(i);
    }
    std::uint32_t index(const Point2& p) {
        const auto [at, is_new] = known_.try_emplace({p.x, p.y}, std::uint32_t(mesh.places.size()));
        if (is_new) mesh.places.push_back(p);
        return at->second;
    }

    std::map<std::pair<double, double>, std::uint32_t> known_;
};

/// An edge of a loop, oriented upwards.
struct RisingEdge {
    Point2 low, high;

    double at(double y) const {
        if (y == low.y) return low.x;
        if (y == high.y) return high.x;
        return low.x + (y - low.y) / (high.y - low.y) * (high.x - low.x);
    }
};

} // namespace

PlaneMesh cut_by_lattice(std::span<const std::vector<Point2>> loops, const PlaneBox& box, std::size_t cells) {
    const double spacing = box.extent() / double(cells);
    const auto ticks = [&](double low, double high) {
        const double count = std::max(1.0, std::ceil((high - low) / spacing - 1e-9));
        std::vector<double> list;
        for (double k = 0; k < count; ++k) list.push_back(low + k / count * (high - low));
        list.push_back(high);
        return list;
    };
    std::vector<double> rows = ticks(box.low.y, box.high.y);
    const std::vector<double> columns = ticks(box.low.x, box.high.x);
    std::vector<RisingEdge> edges;
    std::vector<Point2> corners;
    for (const auto& loop : loops) {
        for (std::size_t k = 0; k < loop.size(); ++k) {
            const Point2 &a = loop[k], &b = loop[(k + 1) % loop.size()];
            if (a.y > box.low.y && a.y < box.high.y) rows.push_back(a.y);
            corners.push_back(a);
            if (a.y != b.y) edges.push_back(a.y < b.y ? RisingEdge{a, b} : RisingEdge{b, a});
        }
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());

    MeshBuilder builder;
    for (std::size_t r = 0; r + 1 < rows.size(); ++r) { // between two rows the inside consists of trapezoids
        const double low = rows[r], high = rows[r + 1];
        std::vector<std::array<double, 2>> crossings; // x on the lower and the upper row
        for (const RisingEdge& edge : edges) {
            if (edge.low.y <= low && edge.high.y >= high) crossings.push_back({edge.at(low), edge.at(high)});
        }
        std::sort(crossings.begin(), crossings.end(),
                  [](const auto& a, const auto& b) { return a[0] + a[1] < b[0] + b[1]; });
        std::vector<Point2> here;
        for (const Point2& c : corners) {
            if (c.y == low || c.y == high) here.push_back(c);
        }
        for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
            const auto &left = crossings[k], &right = crossings[k + 1];
            std::vector<Point2> trapezoid{{left[0], low}};
            append_cut(trapezoid, {right[0], low}, columns);
            append_cut(trapezoid, {right[1], high}, columns);
            append_cut(trapezoid, {left[1], high}, columns);
            append_cut(trapezoid, {left[0], low}, columns);
            trapezoid.pop_back();
            const double first = std::min(left[0], left[1]), last = std::max(right[0], right[1]);
            for (std::size_t c = 0; c + 1 < columns.size(); ++c) {
                if (columns[c + 1] <= first || columns[c] >= last) continue;
                std::vector<Point2> piece; // convex, so its corners stay in order
                std::copy_if(trapezoid.begin(), trapezoid.end(), std::back_inserter(piece),
                             [&](const Point2& p) { return p.x >= columns[c] && p.x <= columns[c + 1]; });
                builder.add(piece, here);
            }
        }
    }
    return std::move(builder.mesh);
}

PlaneMesh mesh_of_grid(std::size_t width, std::size_t height) {
    PlaneMesh mesh;
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) mesh.places.push_back({double(x) + 0.5, double(y) + 0.5});
    }
    for (std::size_t y = 0; y + 1 < height; ++y) {
        for (std::size_t x = 0; x + 1 < width; ++x) {
            const auto i = std::uint32_t(y * width + x), below = std::uint32_t(i + width);
            mesh.triangles.push_back({i, i + 1, below + 1});
            mesh.triangles.push_back({i, below + 1, below});
        }
    }
    return mesh;
}

/// The triangles of a mesh without a NaN corner.
static std::vector<std::array<std::uint32_t, 3>> whole_triangles(const PlaneMesh& mesh,
                                                                 std::span<const double> values) {
    std::vector<std::array<std::uint32_t, 3>> whole;
    std::copy_if(mesh.triangles.begin(), mesh.triangles.end(), std::back_inserter(whole), [&](const auto& t) {
        return !std::isnan(values[t[0]]) && !std::isnan(values[t[1]]) && !std::isnan(values[t[2]]);
    });
    return whole;
}

std::vector<PlaneLine> rim_of(const PlaneMesh& mesh, std::span<const double> values) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> triangles_at;
    for (const auto& triangle : whole_triangles(mesh, values)) {
        for (std::size_t k = 0; k < 3; ++k) ++triangles_at[std::minmax(triangle[k], triangle[(k + 1) % 3])];
    }
    std::vector<PlaneLine> rim;
    for (const auto& [edge, count] : triangles_at) {
        const auto& [a, b] = edge;
        if (count == 1) rim.push_back({{mesh.places[a], mesh.places[b]}, {values[a], values[b]}});
    }
    return rim;
}

namespace {

/// Bounds of a surface: domain, range of values, and the scale from values to heights.
struct PlotBox {
    PlaneBox domain;
    double least = 0, largest = 0, floor = 0, scale = 1;
    bool y_up = false;

    PlotBox(const FieldSurface& surface, double height)
        : least(std::numeric_limits<double>::max())
        , largest(std::numeric_limits<double>::lowest())
        , y_up(surface.y_up) {
        const auto add = [&](const Point2& p, double value) {
            if (std::isnan(value)) return;
            domain.add(p);
            least = std::min(least, value);
            largest = std::max(largest, value);
        };
        for (std::size_t i = 0; i < surface.values.size(); ++i)
            add(surface.mesh.places[i], surface.values[i]);
        for (const PlaneLine& line : surface.boundary) {
            for (std::size_t i = 0; i < line.points.size(); ++i) add(line.points[i], line.values[i]);
        }
        if (least > largest) domain = {{0, 0}, {1, 1}}, least = largest = 0; // empty surface
        if (largest > least) scale = height * domain.extent() / (largest - least);
        floor = least - 0.15 * (largest - least);
    }
    Point3 at(const Point2& p, double value) const { return {p.x, y_up ? p.y : -p.y, scale * value}; }
};

/// Adds the surface's level lines.
void add_level_lines(const FieldSurface& surface, const PlotBox& box, const FieldStyle& style,
                     double thickness, SpacePlot& plot) {
    const double step = style.step;
    if (step == 0) return;
    for (const auto& triangle : plot.surface.triangles) {
        std::array<double, 3> value{};
        for (std::size_t k = 0; k < 3; ++k) value[k] = surface.values[triangle[k]];
        const auto [low, high] = std::minmax({value[0], value[1], value[2]});
        for (double n = std::ceil((low - style.zero) / step); style.zero + n * step < high; ++n) {
            const double level = style.zero + n * step;
            std::vector<Point3> ends;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t next = (k + 1) % 3;
                if ((value[k] > level) == (value[next] > level)) continue;
                const double t = (level - value[k]) / (value[next] - value[k]);
                const Point2 &a = surface.mesh.places[triangle[k]], &b = surface.mesh.places[triangle[next]];
                ends.push_back(box.at({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)}, level));
            }
            if (ends.size() == 2) plot.lines.push_back({std::move(ends), thickness, style.ink()});
        }
    }
}

/// Adds the floor, the rear edges, and axis marks along the floor's near edges and the leftmost vertical
/// edge.
void add_box(const PlotBox& box, const ViewDirections& view, SpacePlot& plot) {
    static constexpr Colour grey{0.62f, 0.62f, 0.62f}, dark{0.35f, 0.35f, 0.35f};
    const double reach = 0.02 * box.domain.extent(); // length of a mark
    const auto corner = [&](std::size_t k, double value) {
        return box.at({k == 1 || k == 2 ? box.domain.high.x : box.domain.low.x,
                       k >= 2 ? box.domain.high.y : box.domain.low.y},
                      value);
    };
    const Point3 middle = 0.5 * corner(0, box.floor) + 0.5 * corner(2, box.floor);
    std::size_t near = 0, left = 0;
    for (std::size_t k = 1; k < 4; ++k) {
        const auto farther = [&](const Point3& direction, std::size_t than) {
            return dot(direction, corner(k, 0) - corner(than, 0));
        };
        if (farther(view.towards, near) > 1e-9 * box.domain.extent()) near = k;
        if (farther(view.right, left) < -1e-9 * box.domain.extent()) left = k;
    }
    const auto add_mark = [&](const Point3& at, const Point3& away, const std::string& number) {
        const double length = std::sqrt(std::max(dot(away, away), 1e-300));
        plot.lines.push_back({{at, at + (reach / length) * away}, 1.2, dark});
        plot.texts.push_back({at + (3.5 * reach / length) * away, number});
    };
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t next = (k + 1) % 4;
        plot.lines.push_back({{corner(k, box.floor), corner(next, box.floor)}, 1.2, grey});
        if (k != near) {
            plot.lines.push_back({{corner(k, box.floor), corner(k, box.largest)}, 1.2, grey});
        }
        if (k != near && next != near) {
            plot.lines.push_back({{corner(k, box.largest), corner(next, box.largest)}, 1.2, grey});
            continue;
        }
        const bool along_x = k % 2 == 0;
        const double from = along_x ? box.domain.low.x : box.domain.low.y;
        const double to = along_x ? box.domain.high.x : box.domain.high.y;
        const Point3 away = 0.5 * corner(k, box.floor) + 0.5 * corner(next, box.floor) - middle;
        for (const auto& [value, number] : marks_of({from, to, 0, 1}, 5)) {
            add_mark(box.at(along_x ? Point2{value, k == 0 ? box.domain.low.y : box.domain.high.y}
                                    : Point2{k == 1 ? box.domain.high.x : box.domain.low.x, value},
                            box.floor),
                     away, number);
        }
    }
    if (!(box.largest > box.least)) return;
    for (const auto& [value, number] : marks_of({box.least, box.largest, 0, 1}, 5))
        add_mark(corner(left, value), -1.0 * view.right, number);
}

} // namespace

Picture draw_surface(const FieldSurface& surface, const SurfaceView& view, const FieldStyle& style) {
    const PlotBox box(surface, view.height);
    const double thin = std::max(0.6, double(style.size) / 900);
    std::vector<Point3> vertices;
    std::vector<Colour> colours;
    for (std::size_t i = 0; i < surface.values.size(); ++i) {
        const double value = std::isnan(surface.values[i]) ? 0 : surface.values[i]; // in no triangle
        vertices.push_back(box.at(surface.mesh.places[i], value));
        colours.push_back(style.colour(value));
    }
    const auto triangles = whole_triangles(surface.mesh, surface.values);
    SpacePlot base{{vertices, triangles, colours}, {}, {}, std::max(1.5, double(style.size) / 450)};
    add_level_lines(surface, box, style, thin, base);
    for (const PlaneLine& line : surface.boundary) {
        SpaceLine above{{}, 2.5 * thin, style.ink()}, below{{}, 1.5 * thin, {0.45f, 0.5f, 0.6f}};
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            above.points.push_back(box.at(line.points[i], line.values[i]));
            below.points.push_back(box.at(line.points[i], box.floor));
        }
        base.lines.push_back(std::move(below));
        base.lines.push_back(std::move(above));
    }
    Picture sheet(style.size * view.turns.size(), style.size);
    for (std::size_t n = 0; n < view.turns.size(); ++n) {
        const ViewDirections from = view_from(view.turns[n], view.rise);
        SpacePlot plot = base;
        add_box(box, from, plot);
        sheet.place(draw_plot(plot, from, style.size, style.size), n * style.size);
    }
    return with_colour_bar(sheet, box.least, box.largest, style);
}

} // namespace cageform_support
