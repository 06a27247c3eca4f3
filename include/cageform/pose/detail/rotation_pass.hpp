// One pass over the clusters of samples: their matrices, their rotations, and the right-hand side.
#pragma once

#include <cageform/clone/detail/row_sums.hpp>
#include <cageform/pose/detail/nearest_rotation.hpp>
#include <cageform/pose/detail/stretches.hpp>
#include <cageform/pose/types/pose_samples.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Rotates each cluster to fit the displacements d of the handles best, and sums up Σ_c (R_c − 1) G_c.
///
///   cost  4 #clusters #handles D² operations and the rotations; reads G once; no allocation
template <Scalar T, std::size_t D>
class RotationPass {
    using Register = typename Simd<T>::Register;
    static constexpr std::size_t lanes = lane_count<T>;
    static constexpr std::size_t step = lanes / Simd<T>::count; ///< numbers per register

public:
    /// Allocates the rotations and sets them to the identity. May throw std::bad_alloc.
    void reset(const PoseSamples<T, D>& samples) {
        turns_.resize(block_count<T>(samples.cluster_count) * D * D);
        sums_.resize(samples.handle_count() * D);
        forget();
    }
    /// Sets all rotations to the identity.
    void forget() noexcept {
        for (auto& row : turns_) Simd<T>(T(0)).store(row);
    }

    /// Computes the rotations and the right-hand side.
    ///
    ///   displacements  of the handles, d
    ///   right          out, D vectors of #handles: Σ_c (R_c − 1) G_c
    ///   stretches      out: the stretches of the clusters; null if not wanted
    ///   returns        Σ_c 2 ⟨d G_cᵀ, 1 − R_c⟩ + |(1 − R_c) M_c^½|²: the energy without the term of K
    double run(const PoseSamples<T, D>& samples, const Vec<T, D>* displacements,
               Lanes<double>* const (&right)[D], Stretches* stretches) noexcept {
        const std::size_t handles = samples.handle_count();
        for (auto& sum : sums_) Simd<T>(T(0)).store(sum);
        double energy = 0;
        for (std::size_t b = 0; b < block_count<T>(samples.cluster_count); ++b) {
            const Lanes<T>* const gradients = &samples.gradients[b * handles * D];
            const Lanes<T>* const moments = &samples.moments[b * D * D];
            Lanes<T>* const turns = &turns_[b * D * D];
            Lanes<T> change[D * D]; // d G_cᵀ
            sum_changes(gradients, displacements, handles, change);
            for (std::size_t first = 0; first < lanes; first += lane_count<double>)
                energy += turn(change, moments, turns, first);
            if (stretches != nullptr) {
                const std::size_t left = samples.cluster_count - b * lanes;
                measure(change, moments, left < lanes ? left : lanes, *stretches);
            }
            add_turns(gradients, turns, handles);
        }
        for (std::size_t i = 0; i < handles; ++i) {
            for (std::size_t k = 0; k < D; ++k) {
                double sum = 0; // lane by lane, so that the bits do not depend on the register width
                for (const T x : sums_[i * D + k].v) sum += double(x);
                right[k][i / lane_count<double>][i % lane_count<double>] = sum;
            }
        }
        return energy;
    }

private:
    static void sum_changes(const Lanes<T>* gradients, const Vec<T, D>* d, std::size_t handles,
                            Lanes<T>* change) noexcept {
        for (std::size_t group = 0; group < Simd<T>::count; ++group) {
            Register sum[D][D] = {};
            const T* g = gradients->v + group * step;
            for (std::size_t i = 0; i < handles; ++i, g += D * lanes) {
                Register slope[D];
                unroll<D>([&](auto c)
                              CAGEFORM_DETAIL_INLINE { slope[c] = load_bytes<Register>(g + c * lanes); });
                unroll<D>([&](auto r) CAGEFORM_DETAIL_INLINE {
                    const Register x = d[i].v[r] - Register{};
                    unroll<D>([&](auto c) CAGEFORM_DETAIL_INLINE {
                        sum[r][c] = multiply_add(x, slope[c], sum[r][c]);
                    });
                });
            }
            for (std::size_t n = 0; n < D * D; ++n)
                store_bytes(change[n].v + group * step, sum[n / D][n % D]);
        }
    }

    void add_turns(const Lanes<T>* gradients, const Lanes<T>* turns, std::size_t handles) noexcept {
        for (std::size_t group = 0; group < Simd<T>::count; ++group) {
            Register turn[D][D];
            for (std::size_t n = 0; n < D * D; ++n)
                turn[n / D][n % D] = load_bytes<Register>(turns[n].v + group * step);
            const T* g = gradients->v + group * step;
            T* sum = sums_.data()->v + group * step;
            for (std::size_t i = 0; i < handles; ++i, g += D * lanes, sum += D * lanes) {
                Register slope[D];
                unroll<D>([&](auto c)
                              CAGEFORM_DETAIL_INLINE { slope[c] = load_bytes<Register>(g + c * lanes); });
                unroll<D>([&](auto r) CAGEFORM_DETAIL_INLINE {
                    Register x = load_bytes<Register>(sum + r * lanes);
                    unroll<D>([&](auto c)
                                  CAGEFORM_DETAIL_INLINE { x = multiply_add(turn[r][c], slope[c], x); });
                    store_bytes(sum + r * lanes, x);
                });
            }
        }
    }

    /// Rotates eight clusters. Returns their energy.
    static double turn(const Lanes<T>* change, const Lanes<T>* moments, Lanes<T>* turns,
                       std::size_t first) noexcept {
        LinearMap<DoubleLanes, D> d, m, j, r;
        for (std::size_t n = 0; n < D * D; ++n) {
            d.at[n / D][n % D] = load_lanes<double>(change[n], first);
            m.at[n / D][n % D] = load_lanes<double>(moments[n], first);
            r.at[n / D][n % D] = load_lanes<double>(turns[n], first);
            j.at[n / D][n % D] = m.at[n / D][n % D] + d.at[n / D][n % D];
        }
        nearest_rotation(j, r);
        DoubleLanes energy(0);
        for (std::size_t a = 0; a < D; ++a) {
            for (std::size_t b = 0; b < D; ++b) {
                store_lanes(r.at[a][b], turns[a * D + b], first);
                DoubleLanes stressed = DoubleLanes(-2) * d.at[a][b]; // row a of (R − 1) M − 2 d Gᵀ
                for (std::size_t c = 0; c < D; ++c) stressed = multiply_add(r.at[a][c], m.at[c][b], stressed);
                energy = multiply_add(stressed, r.at[a][b], energy);
            }
        }
        return ordered_sum(energy);
    }

    static void measure(const Lanes<T>* change, const Lanes<T>* moments, std::size_t count,
                        Stretches& stretches) noexcept {
        for (std::size_t lane = 0; lane < count; ++lane) {
            LinearMap<double, D> d, m;
            for (std::size_t n = 0; n < D * D; ++n) {
                d.at[n / D][n % D] = double(change[n][lane]);
                m.at[n / D][n % D] = double(moments[n][lane]);
            }
            stretches.add(d, m);
        }
    }

    std::vector<Lanes<T>> turns_; ///< R − 1 in blocks of clusters, row D · row + column
    std::vector<Lanes<T>> sums_;  ///< row handle · D + axis: partial sums of the right-hand side by lane
};

} // namespace cageform::inline CAGEFORM_ABI::detail
