#include "cli/pinned_figure.hpp"

#include "cli/progress_bar.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support {

namespace {

using Targets = PinnedCage<double, 2>::Targets;
using Turns = PinnedCage<double, 2>::Turns;

/// Targets and turns of pins during a motion.
class PinMotion {
public:
    /// Animates pins as vertices, each with a second point at distance 1, whose motion gives the turn.
    static Expected<PinMotion> make(const ClipFile& motion) {
        ClipFile as_vertices = motion;
        std::vector<Point2> places;
        const std::size_t count = motion.controls.size();
        for (std::size_t n = 0; n < count; ++n) {
            ClipControl& control = as_vertices.controls[n];
            control.pivot = control.pin->place;
            control.shares = {{n, 1}, {count + n, 1}};
            places.push_back(control.pivot);
        }
        for (std::size_t n = 0; n < count; ++n) places.push_back({places[n].x + 1, places[n].y});
        auto clip = make_clip(as_vertices, places);
        if (!clip) return clip.error();
        return PinMotion(std::move(*clip), count);
    }

    /// Samples the motion at a time; `turns` stays empty if none turns.
    void sample(double time, Targets& targets, Turns& turns) {
        clip_.sample(time, cursor_, places_);
        for (std::size_t n = 0; n < targets.size(); ++n) targets[n] = places_[n];
        for (std::size_t n = 0; n < turns.size(); ++n)
            turns[n] = {places_[targets.size() + n][1] - places_[n][1]};
    }

private:
    PinMotion(cageform::CageClip<double, 2> clip, std::size_t count)
        : clip_(std::move(clip))
        , cursor_(clip_.make_cursor())
        , places_(2 * count) {}

    cageform::CageClip<double, 2> clip_;
    cageform::CageClip<double, 2>::Cursor cursor_;
    std::vector<cageform::Vec<double, 2>> places_;
};

/// A clip with automatic keys of all vertices at some poses.
ClipFile clip_of(const ClipFile& motion, const std::vector<Point2>& rest,
                 const std::vector<std::vector<Point2>>& poses, const std::vector<std::size_t>& keys) {
    ClipFile clip{motion.name, motion.length, motion.late, motion.ground, {}};
    for (std::size_t i = 0; i < rest.size(); ++i) {
        ClipControl control{"vertex " + std::to_string(i), {{i, 1}}, rest[i], {}, {}};
        for (const std::size_t k : keys) {
            const Point2& p = poses[k % (poses.size() - 1)][i];
            control.rows.push_back({motion.length * double(k) / double(poses.size() - 1),
                                    {p.x - rest[i].x, p.y - rest[i].y, 0},
                                    cageform::KeyKind::automatic});
        }
        clip.controls.push_back(std::move(control));
    }
    return clip;
}

/// Fits keys to poses: repeatedly adds the pose with the largest error between two keys, until all errors are
/// within the tolerance.
Expected<ClipFile> fitted(const ClipFile& motion, const std::vector<Point2>& rest,
                          const std::vector<std::vector<Point2>>& poses, double tolerance) {
    const std::size_t last = poses.size() - 1;
    std::vector<std::size_t> keys{0, last / 2, last};
    for (;;) {
        ClipFile file = clip_of(motion, rest, poses, keys);
        const auto clip = make_clip(file, rest);
        if (!clip) return clip.error();
        auto cursor = clip->make_cursor();
        std::vector<cageform::Vec<double, 2>> pose(rest.size());
        std::vector<std::size_t> finer;
        for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
            double largest = tolerance;
            std::size_t worst = 0;
            for (std::size_t n = keys[k] + 1; n < keys[k + 1]; ++n) {
                clip->sample(motion.length * double(n) / double(last), cursor, pose);
                for (std::size_t i = 0; i < rest.size(); ++i) {
                    const double miss = std::hypot(pose[i][0] - poses[n][i].x, pose[i][1] - poses[n][i].y);
                    if (!(miss > largest)) continue;
                    largest = miss;
                    worst = n;
                }
            }
            finer.push_back(keys[k]);
            if (worst != 0) finer.push_back(worst);
        }
        finer.push_back(last);
        if (finer.size() == keys.size()) return file;
        keys = std::move(finer);
    }
}

} // namespace

Expected<PinnedFigure> PinnedFigure::make(FigureControl& control, const PinnedControl& by,
                                          std::vector<Pin<2>> pins) {
    auto cage = PinnedCage<double, 2>::make(control.coordinates,
                                            {control.name, by.coordinates.name, control.describe_faults},
                                            {std::move(pins), by.held}, by.pins, by.outside);
    if (!cage) return cage.error();
    PinnedFigure made(std::move(*cage));
    made.pose_ = made.cage_.rest();
    const bool has_vectors = control.coordinates.handles().vector_count() > 0;
    control.poses_all_handles = has_vectors;
    const std::size_t count = has_vectors ? made.pose_.size() : by.start.size();
    for (std::size_t i = 0; i < count; ++i) made.rest_.push_back({made.pose_[i][0], made.pose_[i][1]});
    for (std::size_t i = 0; i < by.start.size(); ++i) made.pose_[i] = {by.start[i].x, by.start[i].y};
    if (const auto started = made.cage_.start(made.pose_); !started)
        return FileError{control.pose_name + ": " + to_string(started.error())};
    return made;
}

Expected<std::vector<Point2>> PinnedFigure::settled() {
    return pose_at(cage_.targets(), cage_.turns());
}

Expected<std::vector<Point2>> PinnedFigure::pose_at(const Targets& targets, const Turns& turns) {
    if (const auto done = cage_.settle(targets, turns, pose_); !done) return done.error();
    std::vector<Point2> pose;
    for (std::size_t i = 0; i < rest_.size(); ++i) pose.push_back({pose_[i][0], pose_[i][1]});
    return pose;
}

Expected<ClipFile> PinnedFigure::keys_of(const ClipFile& motion) {
    auto moving = PinMotion::make(motion);
    if (!moving) return moving.error();
    const double wished = std::round(60 * motion.length);
    if (!(wished <= 1e5))
        return FileError{motion.name + ": its length needs " + std::to_string(wished) +
                         " poses by pins; at most 100000 are allowed"};
    const std::size_t steps = std::max<std::size_t>(std::size_t(wished), 8);
    ProgressBar bar("posing");
    const auto tell = bar.callback();
    Targets targets = cage_.targets();
    Turns turns = cage_.turns();
    std::vector<std::vector<Point2>> poses;
    for (std::size_t n = 0; n <= steps; ++n) {
        moving->sample(motion.length * double(n) / double(steps), targets, turns);
        auto pose = pose_at(targets, turns);
        if (!pose) return FileError{motion.name + ": " + to_string(pose.error())};
        poses.push_back(std::move(*pose));
        if (tell) tell(double(n) / double(steps));
    }
    return fitted(motion, rest_, poses, cage_.size() / 1920);
}

std::vector<Pin<2>> pins_of(const ClipFile& motion) {
    std::vector<Pin<2>> pins;
    for (const ClipControl& control : motion.controls) {
        const Point2& place = control.pin->place;
        const bool turns = std::any_of(control.rows.begin(), control.rows.end(),
                                       [](const ClipControl::Row& row) { return row.move[2] != 0; });
        Pin<2> pin{motion.name + ": " + control.name, {place.x, place.y}, {place.x, place.y}};
        if (turns) pin.turn.emplace();
        pin.weight = control.pin->weight;
        pins.push_back(std::move(pin));
    }
    return pins;
}

ClipFile motion_to(const std::vector<Pin<2>>& pins, double seconds) {
    ClipFile clip{"pins", seconds, {}, {}, {}};
    constexpr auto ease = cageform::KeyKind::bezier;
    for (const Pin<2>& pin : pins) {
        const auto way = pin.target - pin.place;
        const double turn = pin.turn ? (*pin.turn)[0] : 0;
        const Point2 place{pin.place[0], pin.place[1]};
        clip.controls.push_back(
            {pin.name,
             {},
             place,
             {{0, {}, ease}, {seconds / 2, {way[0], way[1], turn}, ease}, {seconds, {}, ease}},
             ClipControl::Pin{place, pin.weight}});
    }
    return clip;
}

} // namespace cageform_support
