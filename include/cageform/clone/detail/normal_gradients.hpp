// Gradients of moved tangents from the gradients of the normals that they span.
#pragma once

#include <cageform/clone/detail/frames.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The gradients of the tangents of one point; 0 if its normal is the normal at rest.
template <Scalar T, std::size_t D>
using TangentGradients = std::array<Vec<T, D>, D - 1>;

/// n = (−t_y, t_x) / |t|, so ∂f/∂t is the part of (g_y, −g_x) across t, divided by |t|.
template <Scalar T>
TangentGradients<T, 2> tangent_gradients(const Vec<T, 2>& g, const Direction<T, 2>& t) noexcept {
    if (!t.exists()) return {};
    const Vec<T, 2> unit = t.unit(), turned{g[1], -g[0]};
    const T shrink = dot(unit, t.along) * t.size; // |t|
    return {(1 / shrink) * (turned - dot(unit, turned) * unit)};
}

/// n = c / |c|, c = cross(t, b), so ∂f/∂c = (g − n (n·g)) / |c|, ∂f/∂t = cross(b, ∂f/∂c) and
/// ∂f/∂b = cross(∂f/∂c, t).
template <Scalar T>
TangentGradients<T, 3> tangent_gradients(const Vec<T, 3>& g, const Direction<T, 3>& t,
                                         const Direction<T, 3>& b) noexcept {
    Frame<T, 3> frame;
    if (!set_frame(frame, t, b)) return {};
    const Vec<T, 3>& n = frame.normal;
    const T length = dot(n, cross(t.along, b.along));
    const Vec<T, 3> across = (1 / length) * (g - dot(n, g) * n);
    return {(1 / t.size) * cross(b.along, across), (1 / b.size) * cross(across, t.along)};
}

/// The input of a transposed clone of normals: gradients of tangents, computed a few blocks at a time from
/// the moved tangents. `Rows` reads the gradients of normals.
template <class View, class Pose, class Rows>
struct NormalGradients {
    using T = typename View::scalar;
    static constexpr std::size_t D = View::dimension, K = D - 1, bindings = K;
    static constexpr std::size_t blocks_at_once = VectorTile<T, D>::blocks;
    static constexpr std::size_t bytes_of_sums = 16384; ///< on the stack, beside the tiles

    const std::array<View, K>& tangents;
    const Pose& pose;
    Rows rows;

    class Reader {
    public:
        explicit Reader(const NormalGradients& of) noexcept
            : of_(of) {}

        void load(std::size_t n, std::size_t block, Lanes<T>* to) noexcept {
            if (block < begin_ || block >= end_) fill(block - block % blocks_at_once);
            for (std::size_t k = 0; k < D; ++k) to[k] = tiles_[n].moved(block, k);
        }

    private:
        /// Replaces the moved tangents of the blocks from `begin` on by their gradients.
        void fill(std::size_t begin) noexcept {
            const std::size_t blocks = block_count<T>(of_.tangents[0].point_count());
            begin_ = begin;
            end_ = blocks - begin < blocks_at_once ? blocks : begin + blocks_at_once;
            for (std::size_t k = 0; k < K; ++k) tiles_[k].load(of_.tangents[k], of_.pose, begin_, end_);
            for (std::size_t b = begin_; b < end_; ++b) fill_block(b);
        }

        void fill_block(std::size_t b) noexcept {
            TangentBlocks<T, D> blocks;
            for (std::size_t k = 0; k < K; ++k) blocks[k] = tiles_[k].block(b);
            Lanes<T> g[D], result[K][D];
            of_.rows.load(b, g);
            const std::size_t left = of_.tangents[0].point_count() - b * lane_count<T>;
            if constexpr (D == 3) {
                const FrameRows<T> frames = frame_rows(blocks);
                set_rows(blocks, frames, g, result);
                for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
                    if (frames.certain[lane] == T(0) || lane >= left) set_lane(blocks, g, lane, left, result);
                }
            } else {
                for (std::size_t lane = 0; lane < lane_count<T>; ++lane)
                    set_lane(blocks, g, lane, left, result);
            }
            for (std::size_t n = 0; n < K; ++n) {
                for (std::size_t k = 0; k < D; ++k) tiles_[n].moved(b, k) = result[n][k];
            }
        }

        /// Sets all lanes; the result is valid where frames are certain.
        static void set_rows(const TangentBlocks<T, 3>& blocks, const FrameRows<T>& frames,
                             const Lanes<T>* gradients, Lanes<T> (*result)[3]) noexcept {
            using P = Simd<T>;
            P t[3], b[3], n[3], g[3];
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < 3; ++k) {
                t[k] = P::load(*blocks[0].moved[k]);
                b[k] = P::load(*blocks[1].moved[k]);
                n[k] = P::load(frames.normal[k]);
                g[k] = P::load(gradients[k]);
            }
            const P along = n[0] * g[0] + n[1] * g[1] + n[2] * g[2], shrink = P::load(frames.shrink);
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < 3; ++k) g[k] = shrink * (g[k] - along * n[k]);
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
                (b[i] * g[j] - b[j] * g[i]).store(result[0][k]);
                (g[i] * t[j] - g[j] * t[i]).store(result[1][k]);
            }
        }

        static void set_lane(const TangentBlocks<T, D>& blocks, const Lanes<T>* gradients, std::size_t lane,
                             std::size_t left, Lanes<T> (*result)[D]) noexcept {
            TangentGradients<T, D> of_lane{};
            if (lane < left) {
                const auto direction = [&](const VectorBlock<T, D>& block) {
                    return Direction<T, D>(block.at(block.moved, lane), block.at(block.rest, lane));
                };
                Vec<T, D> g{};
                for (std::size_t k = 0; k < D; ++k) g[k] = gradients[k][lane];
                if constexpr (D == 2) {
                    of_lane = tangent_gradients(g, direction(blocks[0]));
                } else {
                    of_lane = tangent_gradients(g, direction(blocks[0]), direction(blocks[1]));
                }
            }
            for (std::size_t n = 0; n < K; ++n) {
                for (std::size_t k = 0; k < D; ++k) result[n][k][lane] = of_lane[n][k];
            }
        }

        const NormalGradients& of_;
        std::size_t begin_ = 0, end_ = 0;
        std::array<VectorTile<T, D>, K> tiles_;
    };

    Reader reader() const noexcept { return Reader(*this); }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
