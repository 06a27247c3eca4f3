#include "pictures/skeleton_picture.hpp"

#include "pictures/field_plot.hpp"

#include <cmath>

namespace cageform_support {

namespace {

/// Lines of the bones in a frame, from each joint to its children, or to the centre of its vertices; thick at
/// the start.
std::vector<SpaceLine> bones_of(const FigureFrames& frames, const FittedMotion& motion, std::size_t frame) {
    const auto& skeleton = motion.skeleton;
    const auto maps = motion.keys.maps(skeleton, frames.times[frame]);
    std::vector<Point3> middles(skeleton.bones);
    std::vector<double> sums(skeleton.bones, 0.0);
    const std::size_t most = skeleton.skin.influences;
    for (std::size_t n = 0; n < skeleton.skin.weights.size(); ++n) {
        const auto weight = double(skeleton.skin.weights[n]);
        Point3& middle = middles[skeleton.skin.joints[n]];
        middle = middle + weight * frames.rest[n / most];
        sums[skeleton.skin.joints[n]] += weight;
    }
    std::vector<SpaceLine> lines;
    std::vector<bool> has_children(skeleton.bones, false);
    const auto draw = [&](std::size_t bone, const Point3& to) {
        const Point3 from = maps[bone](skeleton.joints[bone]);
        constexpr Colour ink{0.08f, 0.16f, 0.45f};
        lines.push_back({{from, to}, 2, ink, true});
        lines.push_back({{from, from + 0.25 * (to - from)}, 6, ink, true});
    };
    for (std::size_t b = skeleton.bones; b-- > 0;) {
        const std::uint32_t parent = skeleton.parents[b];
        if (parent != cageform::FittedSkeleton<double>::no_parent) {
            has_children[parent] = true;
            draw(parent, maps[b](skeleton.joints[b]));
        }
        if (!has_children[b] && sums[b] > 0) draw(b, maps[b]((1 / sums[b]) * middles[b]));
    }
    return lines;
}

} // namespace

Picture draw_skeleton(const FigureFrames& frames, const FittedMotion& motion, const ViewAngles& sight) {
    const std::size_t count = std::min<std::size_t>(frames.places.size(), 5);
    constexpr std::size_t width = 320, height = 400;
    constexpr Colour pale{0.86f, 0.84f, 0.8f};
    const std::vector<Colour> paint(frames.rest.size(), pale);
    std::vector<std::vector<Colour>> errors(count);
    std::vector<std::vector<SpaceLine>> bones(count);
    std::vector<MeshScene> scenes; // in one row, for the same camera
    const double largest = motion.loss.largest > 0 ? motion.loss.largest : 1;
    const auto frame_of = [&](std::size_t n) {
        return count == 1 ? 0 : n * (frames.places.size() - 1) / (count - 1);
    };
    for (std::size_t n = 0; n < count; ++n)
        scenes.push_back({{frames.places[frame_of(n)], frames.triangles}, {}});
    for (std::size_t n = 0; n < count; ++n) {
        const auto &right = frames.places[frame_of(n)], &played = motion.played[frame_of(n)];
        for (std::size_t i = 0; i < played.size(); ++i) {
            const Point3 d = played[i] - right[i];
            errors[n].push_back(heat(std::hypot(d[0], d[1], d[2]) / largest));
        }
        scenes.push_back({{played, frames.triangles, errors[n]}, {}});
    }
    for (std::size_t n = 0; n < count; ++n) {
        bones[n] = bones_of(frames, motion, frame_of(n));
        scenes.push_back({{motion.played[frame_of(n)], frames.triangles, paint}, {}, bones[n]});
    }
    const Picture row = draw_meshes(scenes, width * scenes.size(), height, sight);
    Picture sheet(width * count, 3 * height, mesh_background);
    for (std::size_t y = 0; y < sheet.height(); ++y) {
        for (std::size_t x = 0; x < sheet.width(); ++x)
            sheet.at(x, y) = row.at(y / height * sheet.width() + x, y % height);
    }
    const double most = motion.loss.size > 0 ? largest / motion.loss.size : 1;
    FieldStyle style;
    style.size = sheet.height();
    style.one = most;
    return with_colour_bar(sheet, 0, most, style);
}

} // namespace cageform_support
