#include "pictures/mesh_picture.hpp"

#include "pictures/camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace cageform_support {

namespace detail {

/// A supersampled part of the picture with a depth buffer.
class MeshCanvas {
public:
    static constexpr std::size_t samples = 3; // along each side of a pixel

    MeshCanvas(std::size_t width, std::size_t height, const Colour& paper = mesh_background)
        : width_(width * samples)
        , height_(height * samples)
        , colour_(width_ * height_, paper)
        , nearness_(width_ * height_, std::numeric_limits<float>::lowest())
        , ink_(width_ * height_, 0) {}

    void draw_figure(const MeshView& figure, const Camera& camera) {
        std::vector<Point3> normals(figure.vertices.size()), places(figure.vertices.size());
        for (const auto& [a, b, c] : figure.triangles) {
            const Point3 normal =
                cross(figure.vertices[b] - figure.vertices[a], figure.vertices[c] - figure.vertices[a]);
            for (const auto i : {a, b, c}) normals[i] = normals[i] + normal;
        }
        for (std::size_t i = 0; i < places.size(); ++i) {
            normals[i] = unit(camera.seen(normals[i]));
            places[i] = on_canvas(camera, figure.vertices[i]);
        }
        static const Point3 clay{0.78, 0.36, 0.17};
        const auto linear_list = [](std::span<const Colour> colours) {
            std::vector<Point3> list;
            for (const Colour& colour : colours) list.push_back(linear(colour));
            return list;
        };
        const std::vector<Point3> fronts = linear_list(figure.colours), backs = linear_list(figure.backs);
        for (const auto& [a, b, c] : figure.triangles) {
            const bool behind = !backs.empty() && turn(places[a], places[b], places[c]) > 0;
            const auto& colours = behind ? backs : fronts;
            const auto own = [&](std::uint32_t i) { return colours.empty() ? clay : colours[i]; };
            fill({places[a], places[b], places[c]}, {normals[a], normals[b], normals[c]},
                 {own(a), own(b), own(c)}, shade);
        }
    }

    /// Draws a coloured surface with flat shading, light from above and the left.
    void draw_plot(const MeshView& surface, const Camera& camera) {
        const Point3 light = unit({-0.45, 0.75, 0.7});
        const auto lit = [&](const Point3& normal, const Point3& own) {
            const double share = 0.62 + 0.38 * std::max(0.0, dot(normal, light)); // of its colour
            return Colour{float(share * own[0]), float(share * own[1]), float(share * own[2])};
        };
        const auto own = [&](std::uint32_t i) {
            const Colour& colour = surface.colours[i];
            return Point3{colour.r, colour.g, colour.b};
        };
        for (const auto& [a, b, c] : surface.triangles) {
            const auto &va = surface.vertices[a], &vb = surface.vertices[b], &vc = surface.vertices[c];
            const Point3 normal = unit(camera.seen(cross(vb - va, vc - va)));
            fill({on_canvas(camera, va), on_canvas(camera, vb), on_canvas(camera, vc)},
                 {normal, normal, normal}, {own(a), own(b), own(c)}, lit);
        }
    }

    /// Draws a line with depth test, unless on top. A bias of half a pixel plus the thickness keeps lines on
    /// surfaces visible.
    void draw_line(const SpaceLine& line, const Camera& camera) {
        for (std::size_t k = 1; k < line.points.size(); ++k) {
            for_each_sample(on_canvas(camera, line.points[k - 1]), on_canvas(camera, line.points[k]),
                            line.thickness * samples,
                            [&](std::size_t i, std::size_t middle, double nearness) {
                                const double by = camera.nearer(0.5 + line.thickness, nearness);
                                if (line.on_top || nearness + by >= double(nearness_[middle]))
                                    colour_[i] = line.colour;
                            });
        }
    }

    /// Draws cage edges: strong on front faces, paler on back faces, palest behind the figure.
    void draw_cage(const MeshView& cage, const Camera& camera) {
        struct CageEdge {
            bool here = false;                  // whether an adjacent face is towards the camera
            std::size_t face = ~std::size_t{0}; // last adjacent face
            bool is_inside = false;             // inside a face
        };
        std::map<std::pair<std::uint32_t, std::uint32_t>, CageEdge> edges;
        std::vector<Point3> places;
        for (const Point3& v : cage.vertices) places.push_back(on_canvas(camera, v));
        for (std::size_t t = 0; t < cage.triangles.size(); ++t) {
            const auto& triangle = cage.triangles[t];
            const std::size_t face = cage.triangle_faces.empty() ? t : cage.triangle_faces[t];
            const bool here = turn(places[triangle[0]], places[triangle[1]], places[triangle[2]]) < 0;
            for (std::size_t k = 0; k < 3; ++k) {
                CageEdge& edge = edges[std::minmax(triangle[k], triangle[(k + 1) % 3])];
                edge = {edge.here || here, face, edge.is_inside || edge.face == face};
            }
        }
        for (const auto& [ends, edge] : edges) {
            if (!edge.is_inside) line(places[ends.first], places[ends.second], edge.here ? 0.8f : 0.3f);
        }
    }

    /// Averages the samples of each pixel.
    void copy_to(Picture& picture, std::size_t left) const {
        static constexpr Colour line_colour{0.13f, 0.18f, 0.33f};
        constexpr float share = 1.0f / (samples * samples);
        for (std::size_t y = 0; y < height_ / samples; ++y) {
            for (std::size_t x = 0; x < width_ / samples; ++x) {
                Colour sum;
                for (std::size_t s = 0; s < samples * samples; ++s) {
                    const std::size_t i = (y * samples + s / samples) * width_ + x * samples + s % samples;
                    const Colour sample = mix(colour_[i], line_colour, ink_[i]);
                    sum = {sum.r + share * sample.r, sum.g + share * sample.g, sum.b + share * sample.b};
                }
                picture.at(left + x, y) = sum;
            }
        }
    }

private:
    static Point3 on_canvas(const Camera& camera, const Point3& v) {
        const Point3 p = camera.project(v);
        return {samples * p[0], samples * p[1], p[2]};
    }

    /// Twice the signed area of a triangle in the picture; negative for front faces, since y is downwards.
    static double turn(const Point3& a, const Point3& b, const Point3& c) {
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    }

    /// The range of samples whose centres are between two positions.
    static std::pair<std::size_t, std::size_t> range(double low, double high, std::size_t size) {
        // NaN, for huge meshes, gives an empty range.
        const auto inside = [&](double x) { return x > 0 ? std::size_t(std::min(x, double(size))) : 0; };
        return {inside(std::ceil(low - 0.5)), inside(std::floor(high - 0.5) + 1)};
    }

    /// Linear reflectance of a surface of a displayed colour.
    static Point3 linear(const Colour& colour) {
        return {std::pow(colour.r, 2.2), std::pow(colour.g, 2.2), std::pow(colour.b, 2.2)};
    }

    /// Rasterises a triangle; shade(normal, own) is the colour from interpolated values.
    template <class Shade>
    void fill(const std::array<Point3, 3>& p, const std::array<Point3, 3>& normals,
              const std::array<Point3, 3>& own, Shade&& shade) {
        const double area = turn(p[0], p[1], p[2]);
        if (!(std::fabs(area) > 0)) return;
        const double side = area < 0 ? 1 : -1; // -1: back face
        const auto [left, right] =
            range(std::min({p[0][0], p[1][0], p[2][0]}), std::max({p[0][0], p[1][0], p[2][0]}), width_);
        const auto [top, bottom] =
            range(std::min({p[0][1], p[1][1], p[2][1]}), std::max({p[0][1], p[1][1], p[2][1]}), height_);
        for (std::size_t y = top; y < bottom; ++y) {
            for (std::size_t x = left; x < right; ++x) {
                const Point3 at{double(x) + 0.5, double(y) + 0.5, 0};
                const double u = turn(p[1], p[2], at) / area, v = turn(p[2], p[0], at) / area, w = 1 - u - v;
                if (u < 0 || v < 0 || w < 0) continue;
                const auto nearness = float(u * p[0][2] + v * p[1][2] + w * p[2][2]);
                const std::size_t i = y * width_ + x;
                if (nearness <= nearness_[i]) continue;
                nearness_[i] = nearness;
                const Point3 normal = u * normals[0] + v * normals[1] + w * normals[2];
                colour_[i] = shade((side / std::sqrt(std::max(dot(normal, normal), 1e-30))) * normal,
                                   u * own[0] + v * own[1] + w * own[2]);
            }
        }
    }

    /// x^(1/2.2) from a table, with an error below 1/3 of 1/255 for x above 1/1000.
    static float displayed(double x) {
        constexpr std::size_t steps = 4096;
        static const std::vector<float> table = [] {
            std::vector<float> values;
            for (std::size_t i = 0; i <= steps; ++i)
                values.push_back(float(std::pow(double(i) / steps, 1 / 2.2)));
            return values;
        }();
        const double at = std::clamp(x, 0.0, 1.0) * steps;
        const std::size_t i = std::min(std::size_t(at), steps - 1);
        return table[i] + float(at - double(i)) * (table[i + 1] - table[i]);
    }

    /// Sum of a warm light from above and the left, a cool light from the right, and ambient light.
    static Colour shade(const Point3& normal, const Point3& own) {
        static const Point3 key = unit({-0.45, 0.75, 0.7}), cool = unit({0.9, 0.1, 0.35}),
                            half = unit(key + Point3{0, 0, 1}); // between the light and the eye
        const auto lit = [&](const Point3& light) { return std::max(0.0, dot(normal, light)); };
        const double sky = 0.5 + 0.5 * normal[1];
        const double l = lit(half), l2 = l * l, l4 = l2 * l2, l8 = l4 * l4;
        const double gloss = 0.16 * l8 * l8 * l8 * l4 * l2; // the 30th power
        const double rim =
            0.75 + 0.25 * std::sqrt(std::clamp(normal[2], 0.0, 1.0)); // darker near the silhouette
        const auto channel = [&](std::size_t k, double warmth, double coolness) {
            const double light = 0.14 + 0.20 * sky + warmth * lit(key) + coolness * lit(cool);
            return displayed(rim * own[k] * light + gloss);
        };
        return {channel(0, 0.86, 0.16), channel(1, 0.82, 0.20), channel(2, 0.76, 0.28)};
    }

    void line(const Point3& a, const Point3& b, float ink) {
        for_each_sample(a, b, 1.3 * samples, [&](std::size_t i, std::size_t, double nearness) {
            const float covered = float(nearness) >= nearness_[i] ? ink : 0.13f;
            ink_[i] = std::max(ink_[i], covered); // crossings of lines are not darker
        });
    }

    /// Calls body(sample, nearest sample on the centre line, nearness there).
    template <class Body>
    void for_each_sample(Point3 a, Point3 b, double thickness, Body&& body) {
        const bool steep = std::fabs(b[1] - a[1]) > std::fabs(b[0] - a[0]);
        const std::size_t along = steep ? 1 : 0, across = 1 - along;
        if (a[along] > b[along]) std::swap(a, b);
        const double length = b[along] - a[along];
        if (!(length > 0)) return;
        const double reach =
            thickness / 2 * std::hypot(b[0] - a[0], b[1] - a[1]) / length; // half width along the other axis
        const auto [first, last] = range(a[along], b[along], steep ? height_ : width_);
        for (std::size_t s = first; s < last; ++s) {
            const double t = (double(s) + 0.5 - a[along]) / length;
            const double centre = a[across] + t * (b[across] - a[across]);
            const double nearness = a[2] + t * (b[2] - a[2]);
            const std::size_t size = steep ? width_ : height_;
            const auto place = [&](std::size_t o) { return steep ? s * width_ + o : o * width_ + s; };
            const std::size_t middle = place(std::size_t(std::clamp(centre, 0.0, double(size - 1))));
            const auto [low, high] = range(centre - reach, centre + reach, size);
            for (std::size_t o = low; o < high; ++o) body(place(o), middle, nearness);
        }
    }

    std::size_t width_;
    std::size_t height_;
    std::vector<Colour> colour_;
    std::vector<float> nearness_;
    std::vector<float> ink_;
};

} // namespace detail

ViewDirections view_from(double turn, double rise) {
    constexpr double radians_per_degree = 3.14159265358979323846 / 180;
    const double t = radians_per_degree * std::remainder(turn, 360),
                 r = radians_per_degree * std::remainder(rise, 360);
    return {{std::cos(t), -std::sin(t), 0},
            {std::sin(t) * std::sin(r), std::cos(t) * std::sin(r), std::cos(r)},
            {-std::sin(t) * std::cos(r), -std::cos(t) * std::cos(r), std::sin(r)}};
}

ViewDirections directions_of(const ViewAngles& sight) {
    constexpr double radians_per_degree = 3.14159265358979323846 / 180;
    const double turn = radians_per_degree * std::remainder(sight.turn, 360),
                 rise = radians_per_degree * sight.rise;
    Point3 towards{std::sin(turn) * std::cos(rise), std::sin(rise), std::cos(turn) * std::cos(rise)};
    Point3 right{std::cos(turn), 0, -std::sin(turn)};
    if (sight.z_is_up) {
        for (Point3* direction : {&towards, &right})
            *direction = {(*direction)[0], -(*direction)[2], (*direction)[1]};
    }
    return {right, cross(towards, right), towards};
}

Picture draw_meshes(std::span<const MeshScene> scenes, std::size_t width, std::size_t height,
                    const ViewAngles& sight) {
    Picture picture(width, height, mesh_background);
    const std::size_t part = width / scenes.size();
    std::vector<std::span<const Point3>> all; // every scene is seen at the same size from the same place
    for (const MeshScene& scene : scenes) {
        all.push_back(scene.figure.vertices);
        all.push_back(scene.cage.vertices);
    }
    const detail::Camera camera(directions_of(sight), detail::Camera::Rays::converging, all, double(part),
                                double(height));
    for (std::size_t n = 0; n < scenes.size(); ++n) {
        detail::MeshCanvas canvas(part, height);
        canvas.draw_figure(scenes[n].figure, camera);
        for (const SpaceLine& line : scenes[n].lines) canvas.draw_line(line, camera);
        canvas.draw_cage(scenes[n].cage, camera);
        canvas.copy_to(picture, n * part);
        for (const SpaceText& text : scenes[n].texts) {
            constexpr double letter = 2.5; // 1/7 of its height
            const Point3 at = camera.project(text.at);
            const double half = 3 * letter * double(text.words.size());
            const Point2 left{double(n * part) + at[0] - half, at[1]};
            picture.line(left, {left.x + 2 * half, left.y}, 9 * letter, mesh_background);
            picture.text({left.x + letter / 2, left.y}, text.words, letter, {0.1f, 0.1f, 0.1f});
        }
    }
    return picture;
}

Picture draw_plot(const SpacePlot& plot, const ViewDirections& view, std::size_t width, std::size_t height) {
    std::vector<Point3> places;
    for (const SpaceText& text : plot.texts) places.push_back(text.at);
    std::vector<std::span<const Point3>> all{plot.surface.vertices, places};
    for (const SpaceLine& line : plot.lines) all.push_back(line.points);
    const detail::Camera camera(view, detail::Camera::Rays::parallel, all, double(width), double(height));

    detail::MeshCanvas canvas(width, height, {1, 1, 1});
    canvas.draw_plot(plot.surface, camera);
    for (const SpaceLine& line : plot.lines) canvas.draw_line(line, camera);
    Picture picture(width, height);
    canvas.copy_to(picture, 0);
    for (const SpaceText& text : plot.texts) {
        const Point3 at = camera.project(text.at);
        picture.text({at[0] - 3 * plot.letter * double(text.words.size()), at[1]}, text.words, plot.letter,
                     {0.2f, 0.2f, 0.2f});
    }
    return picture;
}

} // namespace cageform_support
