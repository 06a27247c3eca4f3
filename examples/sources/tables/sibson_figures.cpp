// Pictures and numbers of natural neighbour coordinates:
//
//     sibson_figures FOLDER
//
// sibson_cells.svg   the Voronoi cell of a point and those of its neighbours, and inner Bézier points: figure
//                    1 of Moccozet, Magnenat-Thalmann, Dirichlet free-form deformations (Computer
//                    Animation '97)
// sibson_types.png   the influence of one control point, and a pose: degree 1, degree 3, harmonic in a cage
// sibson_legs.png    weights depend on distance alone: a control point on one leg moves the other
//
// Prints the amplification of unit displacements for each gradient rule, and the interpolation error of a
// wave.

#include "cli/command_line.hpp"
#include "files/cage_file.hpp"
#include "io/messages.hpp"
#include "pictures/level_lines.hpp"
#include "pictures/picture.hpp"
#include "pictures/render.hpp"

#include <cageform/cageform.hpp>

#include <numbers>
#include <random>

namespace {

using namespace cageform_support;
using Vec2 = cageform::Vec<double, 2>;
using cageform::SiteGradients;

// ---- Voronoi cells --------------------------------------------------------------------------------

using Cell = std::vector<Vec2>; // a convex polygon

/// The part of a cell closer to `site` than to `other`.
Cell clip(const Cell& cell, const Vec2& site, const Vec2& other) {
    const Vec2 normal = other - site;
    const double offset = 0.5 * (dot(other, other) - dot(site, site));
    Cell kept;
    for (std::size_t i = 0; i < cell.size(); ++i) {
        const Vec2 &a = cell[i], &b = cell[(i + 1) % cell.size()];
        const double at_a = dot(normal, a) - offset, at_b = dot(normal, b) - offset;
        if (at_a <= 0) kept.push_back(a);
        if ((at_a < 0) != (at_b < 0) && at_a != 0 && at_b != 0)
            kept.push_back(a + (at_a / (at_a - at_b)) * (b - a));
    }
    return kept;
}
/// The cell of site `i` in a window.
Cell cell_of(std::size_t i, const std::vector<Vec2>& sites, Cell window) {
    for (std::size_t j = 0; j < sites.size(); ++j) {
        if (j != i) window = clip(window, sites[i], sites[j]);
    }
    return window;
}
double area(const Cell& cell) {
    double twice = 0;
    for (std::size_t i = 0; i < cell.size(); ++i) twice += cross(cell[i], cell[(i + 1) % cell.size()]);
    return 0.5 * std::fabs(twice);
}

// ---- figure 1 of the source -----------------------------------------------------------------------

/// A row of panels as an SVG, all with the same window, y up.
class Panels {
public:
    static constexpr double size = 300, gap = 16;

    explicit Panels(std::size_t count)
        : count_(count) {}

    void begin(const std::string& caption) {
        const double x = double(next_ % 4) * (size + gap), y = double(next_ / 4) * (size + gap + 24);
        text_ += "<g transform=\"translate(" + number(x) + " " + number(y) + ")\"><text x=\"4\" y=\"16\">" +
                 caption +
                 "</text><svg y=\"24\" width=\"300\" height=\"300\" viewBox=\"-5 -5 10 10\"><rect x=\"-5\" "
                 "y=\"-5\" width=\"10\" "
                 "height=\"10\" fill=\"#fbfbf7\"/>\n";
        ++next_;
    }
    void end() { text_ += "</svg></g>\n"; }
    void polygon(const Cell& cell, const std::string& style) {
        text_ += "<polygon points=\"";
        for (const Vec2& p : cell) text_ += place(p) + " ";
        text_ += "\" " + style + "/>\n";
    }
    void circle(const Vec2& centre, double radius, const std::string& style) {
        text_ += "<circle cx=\"" + number(centre[0]) + "\" cy=\"" + number(-centre[1]) + "\" r=\"" +
                 number(radius) + "\" " + style + "/>\n";
    }
    void line(const Vec2& a, const Vec2& b, const std::string& style) {
        polygon({a, b}, "fill=\"none\" " + style);
    }
    void words(const Vec2& at, const std::string& text, const std::string& style = "") {
        text_ += "<text x=\"" + number(at[0]) + "\" y=\"" + number(-at[1]) + "\" font-size=\"0.55\" " +
                 style + ">" + text + "</text>\n";
    }
    std::string svg() const {
        const double width = 4 * (size + gap) - gap,
                     height = double((count_ + 3) / 4) * (size + gap + 24) - gap;
        return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-8 -4 " + number(width + 16) + " " +
               number(height + 12) +
               "\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"15\">\n<rect x=\"-8\" y=\"-4\" "
               "width=\"100%\" "
               "height=\"100%\" fill=\"white\"/>\n" +
               text_ + "</svg>\n";
    }

private:
    static std::string number(double x) { return format_number(x, 4); }
    static std::string place(const Vec2& p) { return number(p[0]) + "," + number(-p[1]); }

    std::size_t count_, next_ = 0;
    std::string text_;
};

constexpr const char* tints[] = {"#f4a582", "#92c5de", "#a6dba0", "#d9c2e9"};

class CellFigure {
public:
    std::string draw() {
        weights_ = weights_at(sites_);
        circles("(a) Delaunay circles that contain p");
        cells("(b) Voronoi cells before", sites_, false);
        auto with_p = sites_;
        with_p.push_back(p_);
        cells("(c) and with p", with_p, false);
        overlap("(d) area taken by p; u: its shares");
        cells("(e) both laid over each other", with_p, true);
        simplex("(f) degree 2: one inner point moved", false);
        simplex("(g) the corners moved too", true);
        return panels_.svg();
    }
    /// The largest difference of an area and the library's weight.
    double largest_difference() const { return largest_difference_; }

private:
    std::vector<double> weights_at(const std::vector<Vec2>& sites) const {
        const cageform::SibsonCoordinates<double, 2> coordinates(sites);
        const auto bound = cageform::bind(coordinates, std::vector<Vec2>{p_});
        std::vector<double> weights;
        for (std::size_t i = 0; i < sites.size(); ++i) weights.push_back(bound.value.weight(0, i));
        return weights;
    }
    void dots(const std::vector<Vec2>& sites) {
        for (std::size_t i = 0; i < sites.size(); ++i)
            panels_.circle(sites[i], 0.13, i < 4 ? "fill=\"#222\"" : "fill=\"#aaa\"");
    }
    void dot_of_p(const Vec2& p, const std::string& name = "p") {
        panels_.circle(p, 0.13, "fill=\"#c22\"");
        panels_.words(p + Vec2{0.2, 0.15}, name, "fill=\"#c22\"");
    }
    void circles(const std::string& caption) {
        panels_.begin(caption);
        for (std::size_t a = 0; a < sites_.size(); ++a) {
            for (std::size_t b = 0; b < a; ++b) {
                for (std::size_t c = 0; c < b; ++c) draw_triangle(sites_[a], sites_[b], sites_[c]);
            }
        }
        dots(sites_);
        dot_of_p(p_);
        panels_.end();
    }
    /// A Delaunay triangle: no other site in its circle.
    void draw_triangle(const Vec2& a, const Vec2& b, const Vec2& c) {
        const Vec2 u = b - a, v = c - a;
        const double twice = 2 * cross(u, v);
        if (twice == 0) return;
        const Vec2 centre = a + Vec2{(v[1] * dot(u, u) - u[1] * dot(v, v)) / twice,
                                     (u[0] * dot(v, v) - v[0] * dot(u, u)) / twice};
        const auto distance = [&](const Vec2& q) { return std::sqrt(dot(q - centre, q - centre)); };
        for (const Vec2& site : sites_) {
            if (distance(site) < distance(a) * (1 - 1e-9)) return;
        }
        panels_.polygon({a, b, c}, "fill=\"none\" stroke=\"#bbb\" stroke-width=\"0.04\"");
        if (distance(p_) < distance(a))
            panels_.circle(centre, distance(a),
                           "fill=\"#3a7ca5\" fill-opacity=\"0.08\" stroke=\"#3a7ca5\" stroke-width=\"0.05\"");
    }
    void cells(const std::string& caption, const std::vector<Vec2>& sites, bool both) {
        panels_.begin(caption);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const bool is_p = i == sites_.size();
            panels_.polygon(cell_of(i, sites, window_),
                            std::string(is_p ? "fill=\"#c22\" fill-opacity=\"0.15\"" : "fill=\"none\"") +
                                " stroke=\"#444\" stroke-width=\"0.06\"");
            if (both && !is_p)
                panels_.polygon(
                    cell_of(i, sites_, window_),
                    "fill=\"none\" stroke=\"#3a7ca5\" stroke-width=\"0.05\" stroke-dasharray=\"0.25 0.15\"");
        }
        dots(sites_);
        if (sites.size() > sites_.size()) dot_of_p(p_);
        panels_.end();
    }
    void overlap(const std::string& caption) {
        panels_.begin(caption);
        auto with_p = sites_;
        with_p.push_back(p_);
        const Cell of_p = cell_of(sites_.size(), with_p, window_);
        for (std::size_t i = 0; i < sites_.size(); ++i) {
            const Cell part = cell_of(i, sites_, of_p);
            const double share = part.size() < 3 ? 0.0 : area(part) / area(of_p);
            largest_difference_ = std::max(largest_difference_, std::fabs(share - weights_[i]));
            if (share == 0) continue;
            panels_.polygon(part, "fill=\"" + std::string(tints[i % 4]) +
                                      "\" stroke=\"#444\" stroke-width=\"0.05\"");
            panels_.line(sites_[i], p_,
                         "stroke=\"#999\" stroke-width=\"0.04\" stroke-dasharray=\"0.15 0.15\"");
            panels_.words(sites_[i] + Vec2{sites_[i][0] > 0 ? -0.6 : -0.9, sites_[i][1] > 0 ? 0.35 : -0.7},
                          "u = " + text_of("%.3f", weights_[i]));
        }
        dots(sites_);
        dot_of_p(p_);
        panels_.end();
    }
    /// The Bézier simplex of degree 2 over the neighbours: corners, and b_ij half-way between two of them,
    /// which has the weight 2 u_i u_j.
    void simplex(const std::string& caption, bool corners_moved) {
        panels_.begin(caption);
        const Vec2 inner_move{0.6, 2.2};
        auto corners = sites_;
        if (corners_moved) {
            corners[0] = corners[0] + Vec2{-0.8, -0.6};
            corners[2] = corners[2] + Vec2{0.5, 1.2};
        }
        Vec2 moved = p_;
        for (std::size_t i = 0; i < 4; ++i) moved = moved + weights_[i] * (corners[i] - sites_[i]);
        moved = moved + 2 * weights_[2] * weights_[3] * inner_move;
        const auto inner = [&](std::size_t i, std::size_t j) {
            return 0.5 * (corners[i] + corners[j]) + (i == 3 && j == 2 ? inner_move : Vec2{0, 0});
        };
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                panels_.line(corners[i], inner(i, j), "stroke=\"#3a7ca5\" stroke-width=\"0.05\"");
                panels_.line(inner(i, j), corners[j], "stroke=\"#3a7ca5\" stroke-width=\"0.05\"");
            }
        }
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                const bool is_moved = i == 3 && j == 2;
                panels_.circle(inner(i, j), 0.12,
                               is_moved ? "fill=\"#f90\" stroke=\"#333\" stroke-width=\"0.04\""
                                        : "fill=\"white\" stroke=\"#3a7ca5\" stroke-width=\"0.05\"");
            }
            panels_.circle(corners[i], 0.15, "fill=\"#222\"");
        }
        panels_.circle(p_, 0.1, "fill=\"none\" stroke=\"#c22\" stroke-width=\"0.05\"");
        panels_.line(p_, moved, "stroke=\"#c22\" stroke-width=\"0.07\"");
        dot_of_p(moved, "p'");
        panels_.end();
    }

    // Four neighbours of p, and others around.
    std::vector<Vec2> sites_{{-2.2, -1.7}, {2.1, -2.0}, {2.6, 1.6},  {-1.6, 2.2}, {-4.6, 0.6}, {0.2, -4.7},
                             {4.7, -0.4},  {0.9, 4.6},  {-4.2, 4.4}, {4.4, 4.5},  {4.3, -4.4}, {-4.4, -4.3}};
    Vec2 p_{0.35, -0.05};
    Cell window_{{-5, -5}, {5, -5}, {5, 5}, {-5, 5}};
    std::vector<double> weights_;
    double largest_difference_ = 0;
    Panels panels_{7};
};

// ---- maps -----------------------------------------------------------------------------------------

/// A picture of square tiles with captions above; every tile shows the square [−1, 1]².
class Tiles {
public:
    static constexpr std::size_t size = 360, gap = 14, head = 30;

    Tiles(std::size_t columns, std::size_t rows)
        : picture(columns * (size + gap) + gap, rows * (size + head + gap) + gap) {}

    Picture picture;

    void caption(std::size_t column, std::size_t row, const std::string& words) {
        picture.text({left(column), top(row) - 12}, words, 1.7, {0.15f, 0.15f, 0.15f});
    }
    /// Draws values at the centres of the tile's pixels; NaN: not drawn.
    void map(std::size_t column, std::size_t row, const std::vector<double>& values) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!std::isnan(values[i]))
                picture.at(std::size_t(left(column)) + i % size, std::size_t(top(row)) + i / size) =
                    heat(values[i]);
        }
        for (int n = -4; n < 10; ++n) {
            if (n == 0) continue;
            for (const auto& line : level_lines(values, size, 0.1 * n)) {
                for (std::size_t k = 1; k < line.size(); ++k) {
                    const Point2 a{left(column) + line[k - 1].x + 0.5, top(row) + line[k - 1].y + 0.5};
                    const Point2 b{left(column) + line[k].x + 0.5, top(row) + line[k].y + 0.5};
                    picture.line(a, b, 0.7, {0.3f, 0.2f, 0.2f});
                }
            }
        }
    }
    void line(std::size_t column, std::size_t row, const Vec2& a, const Vec2& b, double thickness,
              const Colour& colour) {
        picture.line(place(column, row, a), place(column, row, b), thickness, colour);
    }
    static std::vector<Vec2> pixels() {
        std::vector<Vec2> all;
        for (std::size_t i = 0; i < size * size; ++i)
            all.push_back({(double(i % size) + 0.5) / half - 1, 1 - (double(i / size) + 0.5) / half});
        return all;
    }

private:
    static constexpr double half = double(size) / 2;
    static double left(std::size_t column) { return double(gap + column * (size + gap)); }
    static double top(std::size_t row) { return double(gap + head + row * (size + head + gap)); }
    static Point2 place(std::size_t column, std::size_t row, const Vec2& p) {
        return {left(column) + (p[0] + 1) * half, top(row) + (1 - p[1]) * half};
    }
};

/// A binding of any type, and which of its points lie outside.
struct Bound {
    cageform::Binding<double, 2> binding;
    std::vector<bool> inside;
};
template <class Coordinates>
Bound bind_inside(const Coordinates& coordinates, const std::vector<Vec2>& points) {
    auto [binding, report] =
        cageform::bind(coordinates, points, {.linear_precision = cageform::LinearPrecision::leave});
    if (report.status != cageform::Status::ok) throw std::runtime_error(to_string(report.status));
    Bound bound{std::move(binding), std::vector<bool>(points.size(), true)};
    for (const auto* list : {&report.outside, &report.unreached}) {
        for (const std::size_t i : *list) bound.inside[i] = false;
    }
    return bound;
}

/// Lines of a lattice, each of many points.
std::vector<std::vector<Vec2>> lattice_lines(std::size_t count) {
    std::vector<std::vector<Vec2>> lines;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        for (std::size_t n = 0; n < count; ++n) {
            auto& line = lines.emplace_back();
            for (int k = 0; k <= 240; ++k) {
                Vec2 p{2 * (double(n) + 0.5) / double(count) - 1, double(k) / 120 - 1};
                if (axis == 1) std::swap(p[0], p[1]);
                line.push_back(p);
            }
        }
    }
    return lines;
}

/// The influence of a handle, and the lines of a lattice under a pose that moves it.
template <class Coordinates>
void draw_type(Tiles& tiles, std::size_t column, const Coordinates& coordinates, std::size_t handle,
               const Vec2& move) {
    const auto on_pixels = bind_inside(coordinates, Tiles::pixels());
    std::vector<double> values;
    for (std::size_t i = 0; i < on_pixels.inside.size(); ++i)
        values.push_back(on_pixels.inside[i] ? on_pixels.binding.weight(i, handle) : std::nan(""));
    tiles.map(column, 0, values);

    std::vector<Vec2> pose(coordinates.handles().begin(), coordinates.handles().end());
    pose[handle] = pose[handle] + move;
    for (const auto& line : lattice_lines(20)) {
        const auto bound = bind_inside(coordinates, line);
        std::vector<Vec2> moved(line.size());
        if (clone(bound.binding, pose, moved) != cageform::Status::ok) throw std::runtime_error("clone");
        for (std::size_t k = 1; k < line.size(); ++k) {
            if (bound.inside[k - 1] && bound.inside[k])
                tiles.line(column, 1, moved[k - 1], moved[k], 1.2, {0.25f, 0.35f, 0.5f});
        }
    }
    for (const Vec2& p : pose) tiles.line(column, 1, p, p, 9, {0.75f, 0.15f, 0.1f});
    for (const auto& p : coordinates.handles()) tiles.line(column, 0, p, p, 7, {0.1f, 0.1f, 0.1f});
}

Picture draw_types() {
    std::vector<Vec2> rim;
    for (int k = 0; k < 8; ++k) {
        const double turn = 2 * std::numbers::pi * (k + 0.5) / 8;
        rim.push_back({0.95 * std::cos(turn), 0.95 * std::sin(turn)});
    }
    auto sites = rim;
    sites.push_back({-0.15, -0.1});
    sites.push_back({0.4, 0.35});
    cageform::CellComplex<double, 2> cage{cageform::Polygon<double>(rim)};
    for (std::size_t i = 8; i < sites.size(); ++i) (void)cage.add_point(sites[i], 0.03);
    Tiles tiles(3, 2);
    const std::array<const char*, 3> names{"Sibson, degree 1", "Sibson, degree 3", "harmonic in a cage"};
    for (std::size_t column = 0; column < 3; ++column) {
        tiles.caption(column, 0, std::string(names[column]) + ": influence of a point");
        tiles.caption(column, 1, std::string(names[column]) + ": the point moved");
    }
    const Vec2 move{0.25, -0.3};
    draw_type(tiles, 0, cageform::SibsonCoordinates<double, 2>(sites), 8, move);
    draw_type(tiles, 1, cageform::SibsonCoordinates<double, 2>(sites, {.degree = 3}), 8, move);
    cageform::HarmonicCoordinates harmonic(cage, {.resolution = 256}, cageform::UniformGrid{});
    if (harmonic.solve().status != cageform::Status::ok) throw std::runtime_error("not solved");
    draw_type(tiles, 2, harmonic, 8, move);
    return tiles.picture;
}

/// Two legs: control points along the outline, one knee moved.
Picture draw_legs() {
    const std::vector<Vec2> outline{{-0.75, 0.9},  {-0.75, 0.1}, {-0.7, -0.4}, {-0.7, -0.9}, {-0.15, -0.9},
                                    {-0.15, -0.4}, {-0.12, 0.1}, {0, 0.3},     {0.12, 0.1},  {0.15, -0.9},
                                    {0.7, -0.9},   {0.7, -0.4},  {0.75, 0.1},  {0.75, 0.9}};
    Tiles tiles(2, 2);
    const std::array<const char*, 2> names{"Sibson, degree 1", "harmonic in a cage"};
    for (std::size_t column = 0; column < 2; ++column) {
        tiles.caption(column, 0, std::string(names[column]) + ": influence of a knee");
        tiles.caption(column, 1, std::string(names[column]) + ": the knee raised");
    }
    cageform::HarmonicCoordinates<double, 2> harmonic{
        cageform::Polygon<double>(outline), {.resolution = 256}, cageform::UniformGrid{}};
    if (harmonic.solve().status != cageform::Status::ok) throw std::runtime_error("not solved");
    draw_type(tiles, 1, harmonic, 5, {-0.05, 0.3});
    // Binds the points of the figure inside the outline by control points alone.
    const auto inside = bind_inside(harmonic, Tiles::pixels()).inside;
    const cageform::SibsonCoordinates<double, 2> sibson(outline);
    const auto on_pixels = bind_inside(sibson, Tiles::pixels());
    std::vector<double> values;
    for (std::size_t i = 0; i < inside.size(); ++i)
        values.push_back(inside[i] && on_pixels.inside[i] ? on_pixels.binding.weight(i, 5) : std::nan(""));
    tiles.map(0, 0, values);
    auto pose = outline;
    pose[5] = pose[5] + Vec2{-0.05, 0.3};
    for (const auto& line : lattice_lines(20)) {
        const auto in_legs = bind_inside(harmonic, line).inside;
        const auto bound = bind_inside(sibson, line);
        std::vector<Vec2> moved(line.size());
        if (clone(bound.binding, pose, moved) != cageform::Status::ok) throw std::runtime_error("clone");
        for (std::size_t k = 1; k < line.size(); ++k) {
            if (in_legs[k - 1] && in_legs[k])
                tiles.line(0, 1, moved[k - 1], moved[k], 1.2, {0.25f, 0.35f, 0.5f});
        }
    }
    for (std::size_t i = 0; i < outline.size(); ++i) {
        tiles.line(0, 0, outline[i], outline[i], 7, {0.1f, 0.1f, 0.1f});
        tiles.line(0, 1, pose[i], pose[i], 9, {0.75f, 0.15f, 0.1f});
    }
    return tiles.picture;
}

// ---- the table of gradient rules ------------------------------------------------------------------

template <std::size_t D>
using Sites = std::vector<cageform::Vec<double, D>>;

template <std::size_t D>
Sites<D> random_sites(std::size_t count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    Sites<D> sites(count);
    for (auto& p : sites) {
        for (std::size_t k = 0; k < D; ++k) p[k] = uniform(random);
    }
    return sites;
}
Sites<2> jittered_lattice() {
    auto sites = random_sites<2>(49, 2);
    for (std::size_t i = 0; i < 49; ++i)
        sites[i] = {(double(i % 7) + 0.6 * sites[i][0]) / 7, (double(i / 7) + 0.6 * sites[i][1]) / 7};
    return sites;
}
Sites<2> three_rings() {
    Sites<2> sites;
    for (const double radius : {0.2, 0.45, 0.5}) {
        for (int k = 0; k < 12; ++k) {
            const double turn = 2 * std::numbers::pi * (k + radius) / 12;
            sites.push_back({0.5 + radius * std::cos(turn), 0.5 + radius * std::sin(turn)});
        }
    }
    return sites;
}
/// Close pairs of rings around an axis, a single ring, and a point at the end.
Sites<3> finger() {
    Sites<3> sites{{0.5, 0.5, 1}};
    for (const double z : {0.0, 0.05, 0.3, 0.35, 0.6, 0.65, 0.9}) {
        for (int k = 0; k < 8; ++k) {
            const double turn = 2 * std::numbers::pi * (k + 2 * z) / 8;
            sites.push_back({0.5 + 0.15 * std::cos(turn), 0.5 + 0.15 * std::sin(turn), z});
        }
    }
    return sites;
}

/// A line of the table: mean and maximum of Σ|w|, the least weight, the interpolation error of a wave.
template <std::size_t D>
void print_rules(const char* name, const Sites<D>& sites) {
    const auto wave = [](const cageform::Vec<double, D>& p) {
        double phase = 0;
        for (std::size_t k = 0; k < D; ++k) phase += (5.0 - double(k)) * p[k];
        return std::sin(phase);
    };
    const auto places = random_sites<D>(400, 7);
    std::printf("%-34s", name);
    for (const int rule : {-1, 0, 1, 2}) {
        cageform::SibsonOptions options;
        if (rule >= 0) {
            options.degree = 3;
            options.gradients = std::array{SiteGradients::facets, SiteGradients::gentle,
                                           SiteGradients::mirrored}[std::size_t(rule)];
        }
        const auto [binding, report] =
            cageform::bind(cageform::SibsonCoordinates<double, D>(sites, options), places);
        if (report.status != cageform::Status::ok) throw std::runtime_error(to_string(report.status));
        std::vector<bool> inside(places.size(), true);
        for (const std::size_t i : report.outside) inside[i] = false;
        double sum = 0, worst = 0, least = 0, squares = 0, count = 0;
        for (std::size_t i = 0; i < places.size(); ++i) {
            if (!inside[i]) continue;
            double absolute = 0, value = 0;
            for (std::size_t k = 0; k < sites.size(); ++k) {
                const double w = binding.weight(i, k);
                absolute += std::fabs(w);
                least = std::min(least, w);
                value += w * wave(sites[k]);
            }
            sum += absolute;
            worst = std::max(worst, absolute);
            squares += (value - wave(places[i])) * (value - wave(places[i]));
            ++count;
        }
        if (rule < 0) {
            std::printf(" | %.1e", std::sqrt(squares / count));
        } else {
            std::printf(" | %5.2f %5.2f %5.2f %.1e", sum / count, worst, least, std::sqrt(squares / count));
        }
    }
    std::printf("\n");
}
void print_table() {
    std::printf("Degree 3 by rule of gradients: sum |w| (mean, worst), least w, rms error of a wave that the "
                "sites follow\n");
    std::printf("%-34s | %-7s | %-25s | %-25s | %-25s\n", "400 places among", "degree 1", "facets", "gentle",
                "mirrored");
    print_rules<2>("40 random sites", random_sites<2>(40, 1));
    print_rules<2>("a jittered 7 x 7 lattice", jittered_lattice());
    print_rules<2>("three rings, two of them close", three_rings());
    print_rules<3>("40 random sites in space", random_sites<3>(40, 3));
    print_rules<3>("a finger of close pairs of rings", finger());
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Draws how natural neighbour coordinates are defined and how they behave, and prints "
                     "measurements of their degrees.");
    line.set_examples({"out", "pictures"});
    std::string folder;
    line.add("folder", folder,
             "the folder to write sibson_cells.svg and .png, sibson_types.png, sibson_legs.png to")
        .required();
    if (const auto code = line.parse(argc, argv)) return *code;

    OutputFiles outputs;
    CellFigure figure;
    add_svg(outputs, folder + "/sibson_cells.svg", figure.draw(), 1280);
    draw_types().write_png(outputs.add(folder + "/sibson_types.png"));
    draw_legs().write_png(outputs.add(folder + "/sibson_legs.png"));
    fail_if(outputs.commit());
    std::printf("areas of cells and the library's weights differ by at most %.1e\n\n",
                figure.largest_difference());
    print_table();
    return 0;
}
