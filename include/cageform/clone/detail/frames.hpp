// Unit normals and tangents from moved tangents. Degenerate frames fall back to those at rest.
#pragma once

#include <cageform/clone/detail/vector_tile.hpp>

#include <cmath>
#include <limits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The direction of a vector that a pose moved. Rounding errors are relative to the size of `rest`; a vector
/// smaller than these errors has no direction.
template <Scalar T, std::size_t D>
struct Direction {
    static constexpr T some_roundings = 64 * epsilon<T>;

    /// Scaled to a largest component of ±1, so that squares neither underflow nor overflow.
    Vec<T, D> along{};
    T size = 0;        ///< the vector is `size` times `along`
    T uncertainty = 1; ///< size of the errors of `along`

    Direction(const Vec<T, D>& v, const Vec<T, D>& rest) noexcept {
        const T before = largest_component(rest);
        size = largest_component(v);
        if (!is_finite(v) || !(size > some_roundings * before) || !(size > 0)) return;
        for (std::size_t k = 0; k < D; ++k) along[k] = v[k] / size;
        uncertainty = some_roundings * (before > size ? before / size : T(1));
    }
    bool exists() const noexcept { return uncertainty < 1; }
    Vec<T, D> unit() const noexcept { return (1 / std::sqrt(dot(along, along))) * along; }

private:
    static T largest_component(const Vec<T, D>& v) noexcept {
        T largest = 0;
        for (std::size_t k = 0; k < D; ++k) {
            const T component = v[k] < 0 ? -v[k] : v[k];
            largest = component > largest ? component : largest;
        }
        return largest;
    }
};

template <Scalar T, std::size_t D>
struct Frame {
    Vec<T, D> normal{}, tangent{};
};

/// Sets the frame from one tangent in 2D. Returns false if the tangent has no direction.
template <Scalar T>
bool set_frame(Frame<T, 2>& frame, const Direction<T, 2>& t) noexcept {
    if (!t.exists()) return false;
    frame.tangent = t.unit();
    frame.normal = {-frame.tangent[1], frame.tangent[0]};
    return true;
}

/// Sets the frame from two tangents in 3D. Returns false if they are parallel to rounding.
template <Scalar T>
bool set_frame(Frame<T, 3>& frame, const Direction<T, 3>& t, const Direction<T, 3>& b) noexcept {
    if (!t.exists() || !b.exists()) return false;
    const auto across = cross(t.along, b.along);
    const T length2 = dot(across, across), uncertainty = t.uncertainty + b.uncertainty;
    if (!(length2 > uncertainty * uncertainty)) return false;
    frame.normal = (1 / std::sqrt(length2)) * across;
    frame.tangent = t.unit();
    return true;
}

/// The tangents of a block of points.
template <Scalar T, std::size_t D>
using TangentBlocks = std::array<VectorBlock<T, D>, D - 1>;

/// Returns the moved frame of a lane; if it is degenerate, the frame at rest; if that is degenerate too,
/// zero.
template <Scalar T, std::size_t D>
Frame<T, D> frame_of_lane(const TangentBlocks<T, D>& tangents, std::size_t lane) noexcept {
    const auto set = [&](Frame<T, D>& frame, auto rows) {
        const auto direction = [&](const VectorBlock<T, D>& block) {
            return Direction<T, D>(block.at(block.*rows, lane), block.at(block.rest, lane));
        };
        if constexpr (D == 2) {
            return set_frame(frame, direction(tangents[0]));
        } else {
            return set_frame(frame, direction(tangents[0]), direction(tangents[1]));
        }
    };
    Frame<T, D> frame;
    if (!set(frame, &VectorBlock<T, D>::moved)) (void)set(frame, &VectorBlock<T, D>::rest);
    return frame;
}

/// The frames of a block, one row per axis.
template <Scalar T>
struct FrameRows {
    Lanes<T> normal[3], tangent[3];
    Lanes<T> shrink;  ///< 1 / |cross(t', b')|
    Lanes<T> certain; ///< 0 if the frame must be computed by `frame_of_lane`
};

template <Scalar T>
FrameRows<T> frame_rows(const TangentBlocks<T, 3>& tangents) noexcept {
    using P = Simd<T>;
    P t[3], b[3], t_rest[3], b_rest[3];
    CAGEFORM_DETAIL_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
        t[k] = P::load(*tangents[0].moved[k]);
        b[k] = P::load(*tangents[1].moved[k]);
        t_rest[k] = P::load(*tangents[0].rest[k]);
        b_rest[k] = P::load(*tangents[1].rest[k]);
    }
    const P n[3] = {t[1] * b[2] - t[2] * b[1], t[2] * b[0] - t[0] * b[2], t[0] * b[1] - t[1] * b[0]};
    const auto square = [](const P* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
    const P nn = square(n), tt = square(t), bb = square(b);
    // A frame is certain if three conditions hold: no vector is shorter than a hundredth of itself at rest;
    // the angle is at least half a degree; no product of squares overflows or underflows.
    const P some(T(1e-4)), least((std::numeric_limits<T>::min)() * T(1e12)),
        most((std::numeric_limits<T>::max)() * T(1e-12));
    const auto certain = (some * square(t_rest) <= tt) & (some * square(b_rest) <= bb) &
                         (some * (tt * bb) <= nn) & (least <= nn) & (nn <= most) & (least <= tt) &
                         (tt <= most) & (least <= bb) & (bb <= most);
    FrameRows<T> frames;
    select<T>(certain, P(T(1)), P(T(0))).store(frames.certain);
    Lanes<T> of_t;
    select<T>(certain, nn, P(T(1))).store(frames.shrink);
    select<T>(certain, tt, P(T(1))).store(of_t);
    for (T& x : frames.shrink.v) x = 1 / std::sqrt(x);
    for (T& x : of_t.v) x = 1 / std::sqrt(x);
    CAGEFORM_DETAIL_UNROLL
    for (std::size_t k = 0; k < 3; ++k) {
        (n[k] * P::load(frames.shrink)).store(frames.normal[k]);
        (t[k] * P::load(of_t)).store(frames.tangent[k]);
    }
    return frames;
}

/// Calls body(lane, frame) for the first `used` lanes of a block.
template <Scalar T, std::size_t D, class Body>
void for_frames_of_block(const TangentBlocks<T, D>& tangents, std::size_t used, const Body& body) noexcept {
    if constexpr (D == 2) {
        for (std::size_t lane = 0; lane < used; ++lane) body(lane, frame_of_lane(tangents, lane));
    } else {
        const FrameRows<T> rows = frame_rows(tangents);
        for (std::size_t lane = 0; lane < used; ++lane) {
            if (rows.certain[lane] == T(0)) {
                body(lane, frame_of_lane(tangents, lane));
                continue;
            }
            Frame<T, 3> frame;
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < 3; ++k) {
                frame.normal[k] = rows.normal[k][lane];
                frame.tangent[k] = rows.tangent[k][lane];
            }
            body(lane, frame);
        }
    }
}

/// Calls body(i, frame) for all points i.
template <class View, std::size_t K, class Pose, class Parallel, class Body>
void for_moved_frames(const std::array<View, K>& tangents, const Pose& pose, const Parallel& parallel_for,
                      const Body& body) noexcept {
    using T = typename View::scalar;
    constexpr std::size_t D = View::dimension, step = VectorTile<T, D>::blocks, lanes = lane_count<T>;
    const PackedBindingView<T, D> layout(tangents[0]);
    const auto run_block = [&](const TangentBlocks<T, D>& blocks, std::size_t b) {
        const std::size_t first = b * lanes, left = layout.points - first;
        for_frames_of_block<T, D>(
            blocks, left < lanes ? left : lanes, [&](std::size_t lane, const Frame<T, D>& frame) {
                body(layout.order != nullptr ? layout.order[first + lane] : first + lane, frame);
            });
    };
    parallel_for(block_count<T>(layout.points), clone_grain, [&](std::size_t begin, std::size_t end) {
        std::array<VectorTile<T, D>, K> tiles{}; // zeroed, because lanes after the last point are read
        for (std::size_t from = begin; from < end; from += step) {
            const std::size_t to = end - from < step ? end : from + step;
            for (std::size_t k = 0; k < K; ++k) tiles[k].load(tangents[k], pose, from, to);
            for (std::size_t b = from; b < to; ++b) {
                TangentBlocks<T, D> blocks;
                for (std::size_t k = 0; k < K; ++k) blocks[k] = tiles[k].block(b);
                run_block(blocks, b);
            }
        }
    });
}

} // namespace cageform::inline CAGEFORM_ABI::detail
