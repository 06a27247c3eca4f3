// Drops keys of a skeleton's motion within a distance tolerance.
#pragma once

#include <cageform/parallel/running.hpp>
#include <cageform/skeleton/detail/transform_path.hpp>

#include <algorithm>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Processes bones in order, parents first, channel by channel. The tolerance of a vertex is the distance
/// times (the sum of its weights of finished bones + share · its weight of the current bone). The share grows
/// from channel to channel. Keys are as far apart as this tolerance allows. Local transforms are relative to
/// the motion that the parent's keys reproduce, so errors do not accumulate along a chain. Rotations without
/// tangents stay within the distance with slerp and, per bone, also with nlerp. Neighbouring keys are at most
/// 90° apart. Keys are added between neighbouring frames where slerp and nlerp differ by more than the
/// distance.
class KeyFitter {
public:
    using Map = FittedSkeleton<double>::Map;
    using Keys = SkeletonKeys<double>;
    static constexpr std::uint32_t no_parent = FittedSkeleton<double>::no_parent;

    KeyFitter(const FittedSkeleton<double>& skeleton, const std::vector<Vec<double, 3>>& rest,
              const std::vector<double>& times, const SkeletonKeyOptions& options, double size)
        : skeleton_(skeleton)
        , rest_(rest)
        , times_(times)
        , distance_(options.max_distance * (1 - 1e-6))
        , share_(1 / size)
        , tangents_(options.tangents)
        , errors_(rest.size() * skeleton.frames)
        , used_weight_(rest.size(), 0)
        , influences_(skeleton.bones)
        , nodes_(skeleton.bones * skeleton.frames) {
        const std::size_t most = skeleton.skin.influences;
        for (std::size_t i = 0; i < rest.size(); ++i) {
            for (std::size_t k = i * most; k < (i + 1) * most; ++k) {
                const auto weight = double(skeleton.skin.weights[k]);
                if (weight > 0) influences_[skeleton.skin.joints[k]].push_back({i, weight});
            }
        }
    }

    Status run(const Running& running) {
        keys.bones.resize(skeleton_.bones);
        for (std::size_t bone = 0; bone < skeleton_.bones; ++bone) {
            if (!running.keep_going(double(bone) / double(skeleton_.bones))) return Status::cancelled;
            if (!begin(bone)) return Status::value_not_finite;
            fit_bone(keys.bones[bone]);
            end();
        }
        return Status::ok;
    }

    Keys keys;

private:
    struct Influence {
        std::size_t vertex;
        double weight;
    };
    /// A range of transform values with common key times.
    struct Range {
        std::size_t begin, end;
    };
    /// A segment between two frames, with tangents.
    struct Segment {
        std::size_t from, to;
        std::array<double, NodeTransform::size> out{}, in{};
    };
    struct Key {
        double time;
        const NodeTransform& value;
        const double *in = nullptr, *out = nullptr; ///< tangents; null in linear channels
    };
    struct Segments {
        bool cubic = false;
        std::vector<Segment> list;
        std::vector<NodeTransform> played; ///< #frames

        std::size_t numbers(const Range& range) const {
            return (list.size() + 1) * ((cubic ? 3 : 1) * (range.end - range.begin) + 1);
        }
    };

    bool begin(std::size_t bone) {
        bone_ = bone;
        TransformPath path;
        exact_.clear();
        for (std::size_t t = 0; t < skeleton_.frames; ++t) {
            Map own = skeleton_.map(t, bone);
            own.shift = own(skeleton_.joints[bone]);
            if (skeleton_.parents[bone] != no_parent) own = parent(t).inverse().after(own);
            for (const auto& v : {own.axes[0], own.axes[1], own.axes[2], own.shift}) {
                if (!is_finite(v)) return false;
            }
            exact_.push_back(path.next(own));
        }
        played_ = exact_;
        double reach = 0, scale = 0; // largest distance from the joint, and scale
        for (const auto& p : rest_) {
            const auto d = p - skeleton_.joints[bone];
            reach = (std::max)(reach, share_ * std::sqrt(dot(d, d)));
        }
        for (std::size_t t = 0; t < exact_.size(); ++t) {
            double of_parent = 1;
            if (skeleton_.parents[bone] != no_parent) {
                const auto& axes = parent(t).axes;
                of_parent = std::sqrt(
                    (std::max)({dot(axes[0], axes[0]), dot(axes[1], axes[1]), dot(axes[2], axes[2])}));
            }
            for (const double x : exact_[t].vector(NodeTransform::scale).v)
                scale = (std::max)(scale, of_parent * std::fabs(x));
        }
        cosine_of_half_step_ = std::cos(0.5 * largest_step(distance_, reach * scale));
        return true;
    }
    const Map& parent(std::size_t t) const { return nodes_[t * skeleton_.bones + skeleton_.parents[bone_]]; }
    Map node(std::size_t t, const NodeTransform& local) const {
        return skeleton_.parents[bone_] == no_parent ? local.map() : parent(t).after(local.map());
    }
    /// Returns the difference of the played and the exact map.
    Map difference(std::size_t t, const Map& played) const {
        const Map& exact = skeleton_.map(t, bone_);
        Map result;
        for (std::size_t c = 0; c < 3; ++c) result.axes[c] = played.axes[c] - exact.axes[c];
        result.shift = played(-1.0 * skeleton_.joints[bone_]) - exact.shift;
        return result;
    }
    Vec<double, 3> error(std::size_t t, const Influence& influence, const Map& difference) const {
        return vec_cast<double>(errors_[t * rest_.size() + influence.vertex]) +
               share_ * influence.weight * difference(rest_[influence.vertex]);
    }
    /// True if a local transform is within tolerance. `share` is the fraction of the bone's part of the
    /// distance that may be used.
    bool is_within(std::size_t t, const NodeTransform& local, double share) const {
        const Map by = difference(t, node(t, local));
        for (const Influence& influence : influences_[bone_]) {
            const auto e = error(t, influence, by);
            const double most = distance_ * (used_weight_[influence.vertex] + share * influence.weight);
            if (!(dot(e, e) <= most * most)) return false;
        }
        return true;
    }

    template <class Visit>
    static void for_each_rotation(const Range& range, const Visit& visit) {
        for (const std::size_t at : {NodeTransform::rotation, NodeTransform::axes}) {
            if (at >= range.begin && at < range.end) visit(at);
        }
    }
    static void normalise(NodeTransform& local, const Range& range) {
        for_each_rotation(range, [&](std::size_t at) {
            double square = 0;
            for (std::size_t k = 0; k < 4; ++k) square += local.values[at + k] * local.values[at + k];
            for (std::size_t k = 0; k < 4; ++k) local.values[at + k] /= std::sqrt(square);
        });
    }
    /// Cubic segment through its end frames. Its tangents are a least-squares fit to the frames in between,
    /// with finite differences as regularisation.
    Segment segment(std::size_t from, std::size_t to, const Range& range) const {
        const double length = times_[to] - times_[from];
        double aa = 0, ab = 0, bb = 0;
        Segment result{from, to};
        std::array<double, NodeTransform::size> right_a{}, right_b{};
        const auto add = [&](double a, double b, std::size_t c, double value) {
            right_a[c] += a * value;
            right_b[c] += b * value;
        };
        for (std::size_t t = from + 1; t < to; ++t) {
            const double u = (times_[t] - times_[from]) / length, v = 1 - u;
            const double a = length * v * v * u, b = -length * v * u * u;
            aa += a * a;
            ab += a * b;
            bb += b * b;
            for (std::size_t c = range.begin; c < range.end; ++c)
                add(a, b, c,
                    exact_[t].values[c] - v * v * (1 + 2 * u) * exact_[from].values[c] -
                        u * u * (3 - 2 * u) * exact_[to].values[c]);
        }
        const double hold = 1e-4 * length * length;
        for (std::size_t c = range.begin; c < range.end; ++c) {
            add(hold, 0, c, slope(from, c));
            add(0, hold, c, slope(to, c));
        }
        aa += hold;
        bb += hold;
        const double determinant = aa * bb - ab * ab;
        for (std::size_t c = range.begin; c < range.end; ++c) {
            result.out[c] = (bb * right_a[c] - ab * right_b[c]) / determinant;
            result.in[c] = (aa * right_b[c] - ab * right_a[c]) / determinant;
        }
        return result;
    }
    double slope(std::size_t t, std::size_t c) const {
        const std::size_t a = t == 0 ? 0 : t - 1, b = t + 1 == exact_.size() ? t : t + 1;
        return (exact_[b].values[c] - exact_[a].values[c]) / (times_[b] - times_[a]);
    }
    /// Interpolation of a segment: slerp, nlerp, or cubic.
    enum class Play : std::uint8_t { linear, nlerp, cubic };

    /// Largest angle between rotations at which slerp and nlerp agree within a distance; at most 90°.
    static double largest_step(double distance, double radius) {
        constexpr double right_angle = 1.5707963267948966, least = 1e-4;
        constexpr double of_cube = 0.00405; // slerp and nlerp differ by at most of_cube · angle³
        return (std::min)(right_angle, std::cbrt((std::max)(distance, least) / (of_cube * radius)));
    }
    static double cosine_of_half(const Quaternion<double>& a, const Quaternion<double>& b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    }
    static constexpr double cosine_of_45 = 0.70710678118654752;

    /// True if the rotations in a range differ by more than an angle (default 90°). For larger angles, slerp
    /// and nlerp differ too much.
    static bool exceeds_angle(const NodeTransform& a, const NodeTransform& b, const Range& range,
                              double cosine = cosine_of_45) {
        bool exceeds = false;
        for_each_rotation(range, [&](std::size_t at) {
            exceeds = exceeds || std::fabs(cosine_of_half(a.turn(at), b.turn(at))) < cosine;
        });
        return exceeds;
    }
    /// Bisects between two frames until slerp and nlerp agree, and stores the midpoints. Both interpolations
    /// have the same midpoint.
    template <class Store>
    void bisect(const Key& a, const Key& b, const Range& range, const Store& store) const {
        const auto time = double(float(0.5 * (a.time + b.time))); // files have single precision
        if (!(a.time < time && time < b.time) ||
            !exceeds_angle(a.value, b.value, range, cosine_of_half_step_))
            return;
        NodeTransform middle;
        for (std::size_t c = range.begin; c < range.end; ++c)
            middle.values[c] = 0.5 * (a.value.values[c] + b.value.values[c]);
        normalise(middle, range);
        const Key between{time, middle};
        bisect(a, between, range, store);
        store(between);
        bisect(between, b, range, store);
    }
    /// Evaluates a segment at a frame.
    void play(const Segment& of, Play how, std::size_t t, const Range& range, NodeTransform& local) const {
        const bool cubic = how == Play::cubic;
        const NodeTransform &a = exact_[of.from], &b = exact_[of.to];
        const double length = times_[of.to] - times_[of.from];
        const double u = (times_[t] - times_[of.from]) / length, v = 1 - u;
        for (std::size_t c = range.begin; c < range.end; ++c) {
            local.values[c] = v * v * (1 + 2 * u) * a.values[c] + u * u * (3 - 2 * u) * b.values[c] +
                              length * u * v * (v * of.out[c] - u * of.in[c]);
            if (!cubic) local.values[c] = a.values[c] + u * (b.values[c] - a.values[c]);
        }
        if (cubic) return normalise(local, range);
        for_each_rotation(range, [&](std::size_t at) {
            const Quaternion<double> begin = a.turn(at), end = b.turn(at);
            Quaternion<double> turn = slerp(begin, end, u);
            const double sign = cosine_of_half(begin, end) < 0 ? -1 : 1;
            for (std::size_t k = 0; how == Play::nlerp && k < 4; ++k)
                turn[k] = v * begin[k] + u * sign * end[k];
            local.set_turn(at, turn);
        });
        if (how == Play::nlerp) normalise(local, range);
    }
    /// Finds segments that begin and end at frames and are as long as possible.
    Segments segments(bool cubic, const Range& range, double share) const {
        const bool turns = range.end > NodeTransform::rotation && range.begin != NodeTransform::scale;
        std::vector<Play> ways{cubic ? Play::cubic : Play::linear};
        if (!cubic && turns) ways.push_back(Play::nlerp);
        Segments result{cubic, {}, played_};
        const std::size_t frames = exact_.size();
        Segment last{0, 0};
        const auto reaches = [&](std::size_t from, std::size_t to) {
            const Segment next = cubic ? segment(from, to, range) : Segment{from, to};
            const std::size_t between = to - from - 1;
            if (!cubic && between > 0 && exceeds_angle(exact_[from], exact_[to], range)) return false;
            for (std::size_t n = 0; n < between; ++n) { // starts in the middle, where errors are largest
                const std::size_t t = from + 1 + (between / 2 + n) % between;
                for (const Play how : ways) {
                    NodeTransform local = played_[t];
                    play(next, how, t, range, local);
                    if (!is_within(t, local, share)) return false;
                }
            }
            last = next;
            return true;
        };
        for (std::size_t from = 0; from + 1 < frames; from = last.to) {
            (void)reaches(from, from + 1);
            std::size_t bad = frames;
            for (std::size_t step = 2; bad == frames && last.to + 1 < frames; step *= 2) {
                const std::size_t to = (std::min)(from + step, frames - 1);
                if (!reaches(from, to)) bad = to;
            }
            while (bad < frames && bad - last.to > 1) {
                const std::size_t middle = (last.to + bad) / 2;
                if (!reaches(from, middle)) bad = middle;
            }
            for (std::size_t t = from + 1; t < last.to; ++t) play(last, ways[0], t, range, result.played[t]);
            result.list.push_back(last);
        }
        return result;
    }
    /// Computes the mean over the frames of a range of values; returns true if it is within tolerance.
    bool is_constant(const Range& range, double share, NodeTransform& mean) const {
        mean = exact_[0];
        bool are_alike = true;
        for (std::size_t c = range.begin; c < range.end; ++c) {
            double change = 0;
            for (const NodeTransform& local : exact_) change += local.values[c] - exact_[0].values[c];
            mean.values[c] += change / double(exact_.size());
            for (const NodeTransform& local : exact_)
                are_alike = are_alike && local.values[c] == exact_[0].values[c];
        }
        if (are_alike) return true;
        normalise(mean, range);
        return may_be_constant(range, share, mean);
    }
    /// True if the constant values `one` of a range are within tolerance in all frames.
    bool may_be_constant(const Range& range, double share, const NodeTransform& one) const {
        for (std::size_t t = 0; t < exact_.size(); ++t) {
            if (!is_within(t, replaced(played_[t], one, range), share)) return false;
        }
        return true;
    }
    void set_constant(const Range& range, const NodeTransform& one) {
        for (NodeTransform& local : played_) local = replaced(local, one, range);
    }
    static NodeTransform replaced(NodeTransform local, const NodeTransform& by, const Range& range) {
        for (std::size_t c = range.begin; c < range.end; ++c) local.values[c] = by.values[c];
        return local;
    }
    /// Makes keys of a range of values, and computes the motion that they reproduce. store(key) receives
    /// each Key.
    template <class Store>
    void fit(const Range& range, double share, const Store& store) {
        if (NodeTransform mean; is_constant(range, share, mean)) {
            set_constant(range, mean);
            return store({times_[0], mean});
        }
        Segments best = segments(false, range, share);
        if (tangents_) {
            if (Segments other = segments(true, range, share); other.numbers(range) <= best.numbers(range))
                best = std::move(other);
        }
        constexpr std::array<double, NodeTransform::size> none{};
        NodeTransform last = exact_[0];
        const auto store_near = [&](const Key& key) { // with the sign of the last key
            NodeTransform value = key.value;
            for (const std::size_t at : {NodeTransform::rotation, NodeTransform::axes}) {
                Quaternion<double> q = value.turn(at);
                if (cosine_of_half(q, last.turn(at)) >= 0) continue;
                for (double& x : q) x = -x;
                value.set_turn(at, q);
            }
            last = value;
            store({key.time, value});
        };
        for (std::size_t k = 0; k <= best.list.size(); ++k) {
            const std::size_t t = k == 0 ? 0 : best.list[k - 1].to, from = k == 0 ? 0 : best.list[k - 1].from;
            if (best.cubic) { // signs follow the path
                store({times_[t], exact_[t], k == 0 ? none.data() : best.list[k - 1].in.data(),
                       k == best.list.size() ? none.data() : best.list[k].out.data()});
                continue;
            }
            if (t == from + 1)
                bisect({times_[from], exact_[from]}, {times_[t], exact_[t]}, range, store_near);
            store_near({times_[t], exact_[t]});
        }
        played_ = std::move(best.played);
    }
    template <class V>
    void append(Keys::Channel<V>& to, std::size_t at, const Key& key) const {
        constexpr std::size_t size = std::is_same_v<V, Quaternion<double>> ? 4 : 3;
        const auto slice = [&](const double* all) {
            V result{};
            for (std::size_t k = 0; k < size; ++k) result[k] = all[at + k];
            return result;
        };
        to.times.push_back(key.time);
        to.values.push_back(slice(key.value.values.data()));
        if (key.in == nullptr) return;
        to.in_tangents.push_back(slice(key.in));
        to.out_tangents.push_back(slice(key.out));
    }
    void fit_bone(Keys::Bone& to) {
        // Cumulative shares of the distance.
        constexpr double of_translation = 0.4, of_axes = 0.5, of_scale = 0.7;
        using Node = NodeTransform;
        fit({0, Node::rotation}, of_translation, [&](const Key& key) { append(to.translation, 0, key); });
        const auto take_scale = [&](const Key& key) { append(to.scale, Node::scale, key); };
        const auto take_rotation = [&](const Key& key) { append(to.rotation, Node::rotation, key); };
        const auto take_axes = [&](const Key& key) { append(to.axes, Node::axes, key); };
        const Range axes{Node::axes, Node::size};
        NodeTransform standing;
        if (!may_be_constant(axes, of_axes, standing) && !is_constant(axes, of_axes, standing)) {
            fit({Node::rotation, Node::size}, 1, [&](const Key& key) {
                take_rotation(key);
                take_scale(key);
                take_axes(key);
            });
            return;
        }
        set_constant(axes, standing);
        take_axes({times_[0], standing});
        fit({Node::scale, Node::axes}, of_scale, take_scale);
        fit({Node::rotation, Node::scale}, 1, take_rotation);
    }
    /// Adds the errors of the bone's channels to the vertices and stores its played transforms.
    void end() {
        for (std::size_t t = 0; t < skeleton_.frames; ++t) {
            const Map own = node(t, played_[t]), by = difference(t, own);
            for (const Influence& influence : influences_[bone_])
                errors_[t * rest_.size() + influence.vertex] = vec_cast<float>(error(t, influence, by));
            nodes_[t * skeleton_.bones + bone_] = own;
        }
        for (const Influence& influence : influences_[bone_])
            used_weight_[influence.vertex] += influence.weight;
    }

    const FittedSkeleton<double>& skeleton_;
    const std::vector<Vec<double, 3>>& rest_;
    const std::vector<double>& times_;
    double distance_, share_, cosine_of_half_step_ = 0; ///< cosine_of_half_step_: of the current bone
    bool tangents_;
    std::vector<Vec<float, 3>> errors_; ///< #frames · #vertices: by finished bones, relative to the size
    std::vector<double> used_weight_;   ///< #vertices: sum of the weights of finished bones
    std::vector<std::vector<Influence>> influences_;
    std::vector<Map> nodes_; ///< #frames · #bones, as the keys reproduce them
    std::size_t bone_ = 0;
    std::vector<NodeTransform> exact_, played_; ///< #frames, of the current bone
};

} // namespace cageform::inline CAGEFORM_ABI::detail
