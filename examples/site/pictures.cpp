// Usage: pictures FOLDER
// Draws the pictures for the site's pages of coordinate types: weights as colours, poses as grids.
#include <cageform/cageform.hpp>

#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

namespace {

using Point = std::array<double, 2>;
using Points = std::vector<Point>;
using Binding = cageform::Binding<double, 2>;

/// An SVG file of panels side by side. Each panel is 300 units wide and shows the same square of the plane.
class Sheet {
public:
    Sheet(Point lower, double side, std::size_t panels)
        : lower_(lower)
        , scale_(280 / side)
        , side_(side) {
        print("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %zu 330\" width=\"%zu\" "
              "height=\"330\">\n"
              "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
              panels * 310, panels * 310);
    }

    void panel(const char* title) {
        ++panel_;
        print(
            "<text x=\"%d\" y=\"318\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#333\">%s</text>\n",
            310 * panel_ + 15, title);
    }

    /// Draws `value` at the centres of small squares, -1 in blue and 1 in orange; NaN stays white.
    template <class Value>
    void field(const Value& value) {
        constexpr int count = 100;
        std::map<int, std::string> paths; // by tenths
        for (int row = 0; row < count; ++row) {
            for (int begin = 0; begin < count;) {
                const int first = tenth(value(std::size_t(row * count + begin)));
                int end = begin + 1;
                while (end < count && tenth(value(std::size_t(row * count + end))) == first) ++end;
                char text[64];
                std::snprintf(text, sizeof(text), "M%.1f %.1fh%.1fv2.9h-%.1fz", x(0) + 2.8 * begin,
                              290 - 2.8 * (row + 1), 2.8 * (end - begin) + 0.1, 2.8 * (end - begin) + 0.1);
                if (first != none) paths[first] += text;
                begin = end;
            }
        }
        for (const auto& [level, path] : paths) {
            const double share = std::fmin(1, std::fabs(level) / 10.0);
            const auto mix = [&](double end) { return int(std::lround(255 + share * (end - 255))); };
            print("<path fill=\"rgb(%d,%d,%d)\" d=\"%s\"/>\n", mix(level < 0 ? 25 : 214),
                  mix(level < 0 ? 90 : 92), mix(level < 0 ? 190 : 20), path.c_str());
        }
    }
    /// Returns the points at which `field` draws values, row by row.
    Points places() const {
        Points result;
        for (int n = 0; n < 10000; ++n)
            result.push_back(
                {lower_[0] + side_ * (n % 100 + 0.5) / 100, lower_[1] + side_ * (n / 100 + 0.5) / 100});
        return result;
    }

    /// Draws a line through the points; points that are not finite interrupt it.
    void line(const Points& points, const char* style, bool closed = false) {
        std::string path;
        bool drawing = false;
        for (const Point& p : points) {
            char text[48];
            std::snprintf(text, sizeof(text), "%s%.1f %.1f", drawing ? "L" : "M", at_x(p), at_y(p));
            drawing = std::isfinite(p[0]);
            if (drawing) path += text;
        }
        print("<path fill=\"none\" %s d=\"%s%s\"/>\n", style, path.c_str(), closed ? "z" : "");
    }
    void cage(const Points& points, bool is_dashed = false) {
        line(points,
             is_dashed ? "stroke=\"#777\" stroke-dasharray=\"4 3\"" : "stroke=\"#222\" stroke-width=\"1.6\"",
             true);
    }
    void dot(const Point& p, bool is_marked = false) {
        print("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%s\" fill=\"%s\"/>\n", at_x(p), at_y(p),
              is_marked ? "5" : "3", is_marked ? "#d65c14" : "#222");
    }

    void write(const std::string& path) {
        print("</svg>\n");
        std::FILE* const file = std::fopen(path.c_str(), "w");
        if (file == nullptr || std::fputs(text_.c_str(), file) < 0 || std::fclose(file) != 0)
            std::perror(path.c_str());
    }

private:
    static constexpr int none = 1000;

    static int tenth(double value) { return std::isfinite(value) ? int(std::lround(10 * value)) : none; }
    double x(double units) const { return 310 * panel_ + 15 + scale_ * units; }
    double at_x(const Point& p) const { return x(p[0] - lower_[0]); }
    double at_y(const Point& p) const { return 290 - scale_ * (p[1] - lower_[1]); }

    template <class... Values>
    void print(const char* format, const Values&... values) {
        std::vector<char> line(std::size_t(std::snprintf(nullptr, 0, format, values...)) + 1);
        std::snprintf(line.data(), line.size(), format, values...);
        text_ += line.data();
    }

    Point lower_;
    double scale_, side_;
    int panel_ = -1;
    std::string text_;
};

/// A binding of points, with flags for the points that have weights.
struct Bound {
    Binding binding;
    std::vector<bool> is_there;
};
enum class Shown { inside, everywhere };
template <class Coordinates>
Bound bind_points(const Coordinates& coordinates, const Points& points, Shown shown) {
    auto [binding, report] = cageform::bind(coordinates, points);
    if (report.status != cageform::Status::ok) std::puts(to_string(report.status));
    Bound bound{std::move(binding), std::vector<bool>(points.size(), report.status == cageform::Status::ok)};
    for (const auto* list : {&report.outside, &report.unreached}) {
        if (list == &report.outside && shown == Shown::everywhere) continue;
        for (const std::size_t i : *list) bound.is_there[i] = false;
    }
    return bound;
}

/// Draws the sum of the weights of handles first … last − 1.
template <class Coordinates>
void draw_weights(Sheet& sheet, const Coordinates& coordinates, std::size_t first, std::size_t last) {
    const auto [binding, is_there] = bind_points(coordinates, sheet.places(), Shown::inside);
    sheet.field([&](std::size_t n) {
        if (!is_there[n]) return std::nan("");
        double sum = 0;
        for (std::size_t h = first; h < last; ++h) sum += binding.weight(n, h);
        return sum;
    });
}

/// Draws a grid of lines over the square, moved by a pose of all handles; omits parts without weights.
template <class Coordinates>
void draw_grid(Sheet& sheet, const Coordinates& coordinates, const Points& pose,
               Shown shown = Shown::inside) {
    constexpr int lines = 21, steps = 200;
    const Points places = sheet.places();
    const Point lower = places.front(), upper = places.back();
    for (int n = 0; n < 2 * lines; ++n) {
        Points points;
        for (int k = 0; k <= steps; ++k) {
            const double along = double(k) / steps, across = double(n / 2) / (lines - 1);
            const double u = n % 2 == 0 ? along : across, v = n % 2 == 0 ? across : along;
            points.push_back({std::lerp(lower[0], upper[0], u), std::lerp(lower[1], upper[1], v)});
        }
        const auto [binding, is_there] = bind_points(coordinates, points, shown);
        Points handles(binding.handle_count()), moved(points.size());
        if (pose_handles(binding, pose, handles).status != cageform::Status::ok) handles = pose;
        if (clone(binding, handles, moved) != cageform::Status::ok) continue;
        for (std::size_t k = 0; k < moved.size(); ++k) {
            if (!is_there[k]) moved[k] = {std::nan(""), 0};
        }
        sheet.line(moved, "stroke=\"#2b6cb0\" stroke-width=\"0.9\"");
    }
}

const Points legs{{0, 0}, {1.9, 0}, {1.9, 3.4}, {2.6, 3.4}, {2.6, 0}, {4.5, 0}, {4.5, 5}, {0, 5}};

void draw_barycentric(const std::string& folder) {
    const Points triangle{{0.3, 0.4}, {4.6, 0.9}, {1.9, 4.5}}, pose{{0.3, 0.4}, {4.2, 0.2}, {3.7, 4.6}};
    const cageform::BarycentricCoordinates<double, 2> coordinates(triangle);
    Sheet sheet({0, 0}, 5, 2);
    sheet.panel("the weight of one vertex: affine");
    draw_weights(sheet, coordinates, 2, 3);
    sheet.cage(triangle);
    sheet.dot(triangle[2], true);
    sheet.panel("a pose: straight lines stay straight");
    draw_grid(sheet, coordinates, pose);
    sheet.cage(pose);
    sheet.write(folder + "/coordinates_barycentric.svg");
}

/// Draws the weight of a toe of two legs, and a pose of the other leg.
template <class Coordinates>
void draw_legs(const Coordinates& coordinates, const char* of_weight, const char* of_pose,
               const std::string& path) {
    Points pose = legs;
    pose[4] = {3.4, 0.5};
    pose[5] = {5.3, 0.3};
    Sheet sheet({-0.4, -0.4}, 5.8, 2);
    sheet.panel(of_weight);
    draw_weights(sheet, coordinates, 1, 2);
    sheet.cage(legs);
    sheet.dot(legs[1], true);
    sheet.panel(of_pose);
    draw_grid(sheet, coordinates, pose);
    sheet.cage(pose);
    sheet.write(path);
}

/// Draws weights in a plane below the twisted lid of a cube: for the fan around the mean of the lid's
/// corners, and for cuts along both diagonals.
void draw_fans(const std::string& folder) {
    std::vector<std::array<double, 3>> vertices;
    for (const double z : {-1.0, 1.0}) {
        for (const Point& p : Points{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) vertices.push_back({p[0], p[1], z});
    }
    vertices[4][2] = vertices[6][2] = 1.5;
    using Loops = std::vector<std::vector<int>>;
    const Loops sides{{0, 3, 2, 1}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    Sheet sheet({-1.15, -1.15}, 2.3, 3);
    const auto draw = [&](const char* title, const Loops& lid, const std::vector<Points>& edges) {
        Loops faces = sides;
        faces.insert(faces.end(), lid.begin(), lid.end());
        const cageform::MeanValueCoordinates coordinates(cageform::PolyhedralMesh(
            vertices, faces, {.non_planar = cageform::PolyhedralOptions::NonPlanar::fan}));
        sheet.panel(title);
        const Points places = sheet.places();
        sheet.field([&](std::size_t n) {
            std::array<double, 8> weights{};
            const std::array<double, 3> p{places[n][0], places[n][1], 0.9};
            const auto state = weights_at(coordinates, p, std::span(weights));
            return state == cageform::PointState::inside ? weights[4] + weights[6] : std::nan("");
        });
        for (const Points& edge : edges) sheet.line(edge, "stroke=\"#222\" stroke-dasharray=\"4 3\"");
        sheet.cage({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}});
        sheet.dot({-1, -1}, true);
        sheet.dot({1, 1}, true);
    };
    const Points rising{{-1, -1}, {1, 1}}, falling{{1, -1}, {-1, 1}};
    draw("by the fan", {{4, 5, 6, 7}}, {rising, falling});
    draw("cut by the diagonal of the two corners", {{4, 5, 6}, {4, 6, 7}}, {rising});
    draw("cut by the other diagonal", {{4, 5, 7}, {5, 6, 7}}, {falling});
    sheet.write(folder + "/coordinates_fans.svg");
}

void draw_harmonic(const std::string& folder) {
    const cageform::HarmonicCoordinates<double, 2> coordinates(legs);
    Points pose = legs;
    pose[4] = {3.4, 0.5};
    pose[5] = {5.3, 0.3};
    Sheet sheet({-0.4, -0.4}, 5.8, 3);
    sheet.panel("the weight of one toe: never negative");
    draw_weights(sheet, coordinates, 1, 2);
    sheet.cage(legs);
    sheet.dot(legs[1], true);
    sheet.panel("a pose: the other leg stays");
    draw_grid(sheet, coordinates, pose);
    sheet.cage(pose);
    sheet.panel("the cells of the adaptive grid, accuracy 0.01");
    const cageform::HarmonicCoordinates<double, 2> coarse(legs, {.accuracy = 0.01});
    (void)coarse.for_each_cell([&](const auto& cell) {
        const double x = cell.low[0], y = cell.low[1], size = cell.size;
        sheet.line({{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}},
                   "stroke=\"#2b6cb0\" stroke-width=\"0.5\"", true);
    });
    sheet.cage(legs);
    sheet.write(folder + "/coordinates_harmonic.svg");
}

/// Draws the weight of one vertex with several localities, in a cage with many vertices.
void draw_local_harmonic(const std::string& folder) {
    Points cage;
    for (std::size_t k = 0; k < legs.size(); ++k) {
        const Point &a = legs[k], &b = legs[(k + 1) % legs.size()];
        const double parts = std::ceil(std::hypot(b[0] - a[0], b[1] - a[1]));
        for (double n = 0; n < parts; ++n)
            cage.push_back({std::lerp(a[0], b[0], n / parts), std::lerp(a[1], b[1], n / parts)});
    }
    const std::size_t marked = 12;
    Sheet sheet({-0.4, -0.4}, 5.8, 3);
    for (const double locality : {0.0, 20.0, 40.0}) {
        sheet.panel(locality == 0 ? "harmonic: locality 0" : locality == 20 ? "locality 20" : "locality 40");
        draw_weights(sheet, cageform::HarmonicCoordinates<double, 2>(cage, {.locality = locality}), marked,
                     marked + 1);
        sheet.cage(cage);
        for (const Point& p : cage) sheet.dot(p);
        sheet.dot(cage[marked], true);
    }
    sheet.write(folder + "/coordinates_local_harmonic.svg");
}

void draw_three_point(const std::string& folder) {
    const Points heptagon{{0.6, 1.2}, {1.7, 0.3}, {4.4, 0.6}, {4.8, 2.1}, {4.0, 4.1}, {2.2, 4.8}, {0.4, 3.2}};
    Sheet sheet({0, 0}, 5.2, 3);
    const auto draw = [&](const char* title, const auto& coordinates) {
        sheet.panel(title);
        draw_weights(sheet, coordinates, 4, 5);
        sheet.cage(heptagon);
        sheet.dot(heptagon[4], true);
    };
    draw("Wachspress, f = 1", cageform::WachspressCoordinates<double>(heptagon));
    draw("mean value, f = r", cageform::MeanValueCoordinates<double, 2>(heptagon));
    draw("discrete harmonic, f = r²", cageform::DiscreteHarmonicCoordinates<double>(heptagon));
    sheet.write(folder + "/coordinates_three_point.svg");
}

void draw_green(const std::string& folder) {
    const Points square{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, pose{{0, 0}, {5, 0.6}, {5.8, 4.4}, {0.8, 3.4}};
    Sheet sheet({-0.5, -0.7}, 6.4, 2);
    const auto draw = [&](const char* title, const auto& coordinates) {
        sheet.panel(title);
        draw_grid(sheet, coordinates, pose);
        sheet.cage(square, true);
        sheet.cage(pose);
    };
    draw("mean value: the grid shears", cageform::MeanValueCoordinates<double, 2>(square));
    draw("Green: right angles stay right", cageform::GreenCoordinates<double, 2>(square));
    sheet.write(folder + "/coordinates_green.svg");
}

void draw_curved_green(const std::string& folder) {
    using Curves = cageform::CurvedPolygon<double>;
    const auto draw_cage = [](Sheet& sheet, const Points& control) { // three control points an edge
        Points curve;
        for (std::size_t k = 0; k < control.size(); k += 3) {
            const Point &a = control[k], &d = control[(k + 3) % control.size()];
            for (const std::size_t inner : {k + 1, k + 2}) {
                sheet.line({inner == k + 1 ? a : d, control[inner]}, "stroke=\"#777\" stroke-width=\"0.7\"");
                sheet.dot(control[inner]);
            }
            for (int n = 0; n < 40; ++n) {
                const double t = n / 40.0, u = 1 - t;
                Point& p = curve.emplace_back();
                for (std::size_t axis = 0; axis < 2; ++axis)
                    p[axis] = u * u * u * a[axis] + 3 * u * u * t * control[k + 1][axis] +
                              3 * u * t * t * control[k + 2][axis] + t * t * t * d[axis];
            }
        }
        sheet.cage(curve);
        for (std::size_t k = 0; k < control.size(); k += 3) sheet.dot(control[k]);
    };
    const auto control_points = [](const auto& coordinates) {
        Points points;
        const auto handles = coordinates.handles();
        for (std::size_t i = 0; i < handles.size() / 2; ++i) points.push_back({handles[i][0], handles[i][1]});
        return points;
    };
    const cageform::CurvedGreenCoordinates<double> leaf(Curves(
        {{{{0.4, 2.6}, {1, 0.4}, {3.8, 0.4}, {5, 2.6}}, {{5, 2.6}, {3.8, 4.8}, {1, 4.8}, {0.4, 2.6}}}}));
    Sheet sheet({0, 0}, 5.4, 3);
    sheet.panel("the weight of one control point");
    Points pose = control_points(leaf);
    draw_weights(sheet, leaf, 1, 2);
    draw_cage(sheet, pose);
    sheet.dot(pose[1], true);
    sheet.panel("an end rotated with its control points");
    pose[2] = {2.6, 1.2};
    pose[3] = {4.6, 4.4};
    pose[4] = {2.4, 5.2};
    draw_grid(sheet, leaf, pose);
    draw_cage(sheet, pose);
    const Points square{{1, 1}, {4.4, 1}, {4.4, 4.4}, {1, 4.4}};
    const cageform::CurvedGreenCoordinates<double> lines{Curves(cageform::Polygon<double>(square))};
    sheet.panel("straight edges bent");
    pose = control_points(lines);
    pose[1][1] = pose[2][1] = 0.2;
    pose[7][1] = 5;
    pose[8][1] = 3.8;
    draw_grid(sheet, lines, pose);
    draw_cage(sheet, pose);
    sheet.write(folder + "/coordinates_curved_green.svg");
}

void draw_sibson(const std::string& folder) {
    const Points sites{{0.1, 0.2}, {4.9, 0.1}, {4.8, 4.9}, {0.2, 4.8}, {1.3, 1.6},
                       {2.9, 1.2}, {3.7, 2.6}, {2.4, 2.7}, {1.2, 3.3}, {3.2, 3.9}};
    Points pose = sites;
    pose[7] = {2.9, 2.2};
    Sheet sheet({0, 0}, 5, 3);
    const auto draw_sites = [&](const Points& points) {
        for (std::size_t k = 0; k < points.size(); ++k) sheet.dot(points[k], k == 7);
    };
    const cageform::SibsonCoordinates<double, 2> once(sites), smooth(sites, {.degree = 3});
    sheet.panel("the weight of one point, degree 1");
    draw_weights(sheet, once, 7, 8);
    draw_sites(sites);
    sheet.panel("a pose, degree 1: a crease at the points");
    draw_grid(sheet, once, pose);
    draw_sites(pose);
    sheet.panel("a pose, degree 3: smooth at the points, too");
    draw_grid(sheet, smooth, pose);
    draw_sites(pose);
    sheet.write(folder + "/coordinates_sibson.svg");
}

void draw_lattice(const std::string& folder) {
    const cageform::LatticeAxis axis{.points = 6};
    const cageform::Transform<double, 2> box{{{{3.2, 0}, {0, 3.2}}}, {1, 1}};
    const cageform::LatticeCoordinates<double, 2> lattice({axis, axis}, box), fading({axis, axis}, box, 0.9);
    const auto handles_of = [](const auto& coordinates) {
        Points handles;
        for (const auto& h : coordinates.handles()) handles.push_back({h[0], h[1]});
        return handles;
    };
    const auto draw_lines = [&](Sheet& sheet, const Points& handles) { // rows, and columns
        for (std::size_t n = 0; n < 6; ++n) {
            Points row, column;
            for (std::size_t i = 0; i < 6; ++i) {
                row.push_back(handles[6 * n + i]);
                column.push_back(handles[6 * i + n]);
            }
            for (const Points& points : {row, column})
                sheet.line(points, "stroke=\"#777\" stroke-dasharray=\"4 3\"");
            for (const Point& p : row) sheet.dot(p);
        }
    };
    const Points rest = handles_of(lattice);
    Sheet sheet({0, 0}, 5.2, 3);
    sheet.panel("the weight of one point, cubic");
    draw_weights(sheet, lattice, 21, 22);
    draw_lines(sheet, rest);
    sheet.dot(rest[21], true);
    sheet.panel("a corner moves: displacements fade outside");
    Points pose = handles_of(fading);
    for (const std::size_t i : {28u, 29u, 34u, 35u}) pose[i] = {pose[i][0] + 0.3, pose[i][1] + 0.4};
    draw_grid(sheet, fading, pose, Shown::everywhere);
    draw_lines(sheet, pose);
    sheet.panel("two outer layers are frozen");
    pose = rest;
    for (const std::size_t i : {14u, 15u, 20u, 21u}) pose[i] = {pose[i][0] + 0.6, pose[i][1] + 0.4};
    draw_grid(sheet, lattice, pose, Shown::everywhere);
    draw_lines(sheet, pose);
    sheet.write(folder + "/coordinates_lattice.svg");
}

void draw_blended(const std::string& folder) {
    using Mean = cageform::MeanValueCoordinates<double, 2>;
    const Points body{{0.6, 0.3}, {4.6, 0.3}, {4.6, 3}, {0.6, 3}},
        head{{1.6, 2}, {3.6, 2}, {3.6, 5}, {1.6, 5}};
    const cageform::BlendedCoordinates<Mean> coordinates({Mean(body), Mean(head)});
    Points posed = head, pose = body;
    for (Point& p : posed) p[0] += 0.5 * (p[1] - 2);
    pose.insert(pose.end(), posed.begin(), posed.end());
    Sheet sheet({0, 0}, 5.4, 2);
    sheet.panel("the head's share of the weights");
    draw_weights(sheet, coordinates, coordinates.first_handle(1), coordinates.first_handle(2));
    sheet.cage(body);
    sheet.cage(head);
    sheet.panel("a pose of the head alone");
    draw_grid(sheet, coordinates, pose);
    sheet.cage(body);
    sheet.cage(posed);
    sheet.write(folder + "/coordinates_blended.svg");
}

} // namespace

int main(int count, char** arguments) {
    if (count != 2) return std::puts("usage: pictures FOLDER");
    const std::string folder = arguments[1];
    draw_barycentric(folder);
    draw_legs(cageform::MeanValueCoordinates<double, 2>(legs), "the weight of one toe: blue is negative",
              "a pose: the other leg bends a little", folder + "/coordinates_mean_value.svg");
    draw_legs(cageform::MaximumEntropyCoordinates<double, 2>(legs), "the weight of one toe: never negative",
              "a pose: the other leg hardly moves", folder + "/coordinates_maximum_entropy.svg");
    draw_fans(folder);
    draw_harmonic(folder);
    draw_local_harmonic(folder);
    draw_three_point(folder);
    draw_green(folder);
    draw_curved_green(folder);
    draw_sibson(folder);
    draw_lattice(folder);
    draw_blended(folder);
    return 0;
}
