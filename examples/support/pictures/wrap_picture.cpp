#include "pictures/wrap_picture.hpp"

#include "io/csv.hpp"
#include "pictures/camera.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace cageform_support {

namespace {

constexpr std::size_t part_width = 400, part_height = 640, heading = 40, bar_width = 110;
constexpr double letter = 2; // 1/7 of its height
constexpr Colour ink{0.2f, 0.2f, 0.2f};

/// The target and its followers as one mesh, and lines.
struct Dressed {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Colour> colours;
    std::vector<SpaceLine> lines;

    void add(std::span<const Point3> places, std::span<const std::array<std::uint32_t, 3>> faces,
             const Colour& colour) {
        const auto first = std::uint32_t(vertices.size());
        vertices.insert(vertices.end(), places.begin(), places.end());
        colours.insert(colours.end(), places.size(), colour);
        for (const auto& [a, b, c] : faces) triangles.push_back({first + a, first + b, first + c});
    }
};

void add_crosses(std::span<const Point3> places, double radius, const Colour& colour, Dressed& dressed) {
    for (const Point3& p : places) {
        for (std::size_t k = 0; k < 3; ++k) {
            Point3 arm{};
            arm[k] = radius;
            dressed.lines.push_back({{p - arm, p + arm}, 2, colour, true});
        }
    }
}

Dressed dressed_target(const WrapScene& scene) {
    constexpr Colour pale{0.86f, 0.84f, 0.8f};
    constexpr std::array<Colour, 5> paints{{{0.25f, 0.42f, 0.68f},
                                            {0.72f, 0.33f, 0.28f},
                                            {0.35f, 0.56f, 0.32f},
                                            {0.62f, 0.48f, 0.2f},
                                            {0.5f, 0.36f, 0.62f}}};
    Dressed dressed;
    dressed.add(scene.target.vertices, scene.target.triangles, pale);
    const double size = cageform::bounds_of(scene.target.vertices).diagonal();
    // Followers far away would make the target too small to see.
    const auto box = cageform::bounds_of(scene.target.vertices).widened(size);
    for (std::size_t n = 0; n < scene.followers.size(); ++n) {
        const WrapFollower& follower = scene.followers[n];
        const Colour& paint = paints[n % paints.size()];
        std::vector<Point3> places(follower.places.begin(), follower.places.end());
        for (Point3& p : places) {
            for (std::size_t k = 0; k < 3; ++k) p[k] = std::clamp(p[k], box.lower[k], box.upper[k]);
        }
        dressed.add(places, follower.triangles, paint);
        for (const auto& [from, to] : follower.segments)
            dressed.lines.push_back({{places[from], places[to]}, 3, paint, true});
        if (follower.triangles.empty() && follower.segments.empty())
            add_crosses(places, 0.008 * size, paint, dressed);
    }
    return dressed;
}

} // namespace

double scale_of_distances(std::span<const double> distances) {
    std::vector<double> sorted(distances.begin(), distances.end());
    const auto upper = sorted.begin() + std::ptrdiff_t(sorted.size() * 95 / 100);
    if (upper == sorted.end()) return 1;
    std::nth_element(sorted.begin(), upper, sorted.end());
    const double least = std::max(*upper, 1e-3), power = std::pow(10, std::floor(std::log10(least)));
    for (const double digit : {1, 2, 5}) {
        if (least <= digit * power) return digit * power;
    }
    return 10 * power;
}

Picture draw_wrap(const WrapScene& scene, const ViewAngles& sight) {
    std::vector<Colour> heats;
    for (const double distance : scene.distances) heats.push_back(heat(distance / scene.most));
    const Dressed dressed = dressed_target(scene);
    MeshView coloured = scene.wrapped;
    coloured.colours = heats;
    std::vector<MeshScene> scenes{{scene.target, {}}, {scene.wrapped, {}}};
    std::vector<std::string> names{"source (own scale)", "target", "wrapped source"};
    if (!scene.followers.empty()) {
        scenes.push_back({{dressed.vertices, dressed.triangles, dressed.colours}, {}, dressed.lines, {}});
        names.emplace_back("followers on the target");
    }
    scenes.push_back({coloured, {}});
    const bool exceeds = std::any_of(scene.distances.begin(), scene.distances.end(),
                                     [&](double distance) { return distance > scene.most; });
    names.push_back("distance, %" +
                    (exceeds ? " (darkest: over " + detail::short_number(scene.most) + ')' : ""));
    const MeshScene source{scene.source, {}};

    const std::size_t parts = 1 + scenes.size();
    Picture picture(parts * part_width + bar_width, heading + part_height, mesh_background);
    picture.place(draw_meshes({&source, 1}, part_width, part_height, sight), 0, heading);
    const Picture others = draw_meshes(scenes, scenes.size() * part_width, part_height, sight);
    picture.place(others, part_width, heading);
    for (std::size_t n = 0; n < parts; ++n)
        picture.text({double(n * part_width) + 20, 0.5 * heading}, names[n], letter, ink);
    const Axis bar{0, scene.most, 0.96 * double(heading + part_height), 1.5 * heading};
    draw_colour_bar(picture, bar, marks_of(bar, 10), double(parts * part_width) + 8, 24, letter,
                    [&](double value) { return heat(value / scene.most); });
    return picture;
}

} // namespace cageform_support
