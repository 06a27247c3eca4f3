// Stores the points of a clone in blocks, to any range; fast for contiguous numbers.
#pragma once

#include <cageform/clone/types/clone_options.hpp>
#include <cageform/core/detail/simd.hpp>
#include <cageform/figure/packed_binding.hpp>

#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

#if CAGEFORM_REGISTER_BYTES != 0
/// Registers for shuffles. Registers of 32 bytes shuffle only within halves, so halves are used.
template <class T>
struct ShuffledOf {
    typedef T type __attribute__((vector_size(register_bytes == 64 ? 64 : 16)));
};

/// Returns register `O` of D · N numbers x y z x y z …, from D registers with N numbers of one axis each.
template <std::size_t D, std::size_t N, std::size_t O, class Register, std::size_t... L>
Register interleaved_register(const Register* axis, std::index_sequence<L...>) noexcept {
    // Number O·N + L belongs to point (O·N + L) / D and axis (O·N + L) % D.
    if constexpr (D == 2) {
        return __builtin_shufflevector(axis[0], axis[1], int((O * N + L) % 2 * N + (O * N + L) / 2)...);
    } else {
        const Register first_two = __builtin_shufflevector(
            axis[0], axis[1], int(((O * N + L) % 3 == 1 ? N : 0) + (O * N + L) / 3)...);
        return __builtin_shufflevector(first_two, axis[2],
                                       int((O * N + L) % 3 == 2 ? N + (O * N + L) / 3 : L)...);
    }
}
#endif

/// Stores a block's D rows as points x y z x y z ….
template <Scalar T, std::size_t D>
void interleave(const Simd<T>* rows, T* points) noexcept {
#if CAGEFORM_REGISTER_BYTES != 0
    if constexpr (D == 2 || D == 3) {
        using Register = typename ShuffledOf<T>::type;
        constexpr std::size_t n = sizeof(Register) / sizeof(T);
        Register axis[D][lane_count<T> / n];
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < D; ++k) {
            Lanes<T> row;
            rows[k].store(row);
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t r = 0; r < lane_count<T> / n; ++r)
                std::memcpy(&axis[k][r], row.v + r * n, sizeof(Register));
        }
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t r = 0; r < lane_count<T> / n; ++r) {
            Register chunk[D];
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < D; ++k) chunk[k] = axis[k][r];
            [&]<std::size_t... O>(std::index_sequence<O...>) {
                const auto put = [&](std::size_t o, const Register& mixed) {
                    std::memcpy(points + (r * D + o) * n, &mixed, sizeof(mixed));
                };
                (put(O, interleaved_register<D, n, O>(chunk, std::make_index_sequence<n>{})), ...);
            }(std::make_index_sequence<D>{});
        }
        return;
    }
#endif
    CAGEFORM_DETAIL_UNROLL
    for (std::size_t k = 0; k < D; ++k) {
        Lanes<T> row;
        rows[k].store(row);
        for (std::size_t lane = 0; lane < lane_count<T>; ++lane) points[lane * D + k] = row[lane];
    }
}

template <class P, class T, std::size_t D>
inline constexpr bool is_plain_point =
    std::is_same_v<P, Vec<T, D>> || std::is_same_v<P, std::array<T, D>> || std::is_same_v<P, T[D]>;

/// Returns a range as a clone reads it (`Number` is const) or writes it. Contiguous numbers of any type
/// become StridedPoints and share code.
template <class Number, std::size_t D, class Points>
decltype(auto) as_strided(Points& points) noexcept {
    if constexpr (requires {
                      requires is_plain_point<
                          std::remove_const_t<std::remove_pointer_t<decltype(std::data(points))>>,
                          std::remove_const_t<Number>, D>;
                  }) {
        return StridedPoints<Number, D>(reinterpret_cast<Number*>(std::data(points)), std::size(points));
    } else if constexpr (std::is_same_v<const Points, const StridedPoints<Number, D>>) {
        return StridedPoints<Number, D>(points);
    } else {
        return (points);
    }
}

/// Stores the points of a clone.
template <Scalar T, std::size_t D, class Out>
class CloneTarget {
public:
    static constexpr std::size_t columns = D; ///< numbers per point passed to `write`

    CloneTarget(const PackedBindingView<T, D>& binding, const CloneOptions<T>& options, Out& out) noexcept
        : rest_(binding.rest)
        , index_of_{binding.order}
        , points_(binding.points)
        , options_(options)
        , out_(out) {
        if constexpr (is_strided) {
            numbers_ = out.plain_numbers();
            by_axes_ = index_of_.order == nullptr && out.plain_axis(0) != nullptr;
        }
    }

    /// Stores the points of a block, displaced by `sums`.
    void write(std::size_t block, Lanes<T>* sums) const noexcept {
        const std::size_t first = block * lanes;
        if (points_ - first >= lanes) {
            write(block, std::integral_constant<std::size_t, lanes>{}, sums);
        } else {
            write(block, points_ - first, sums);
        }
    }

private:
    static constexpr std::size_t lanes = lane_count<T>;
    static constexpr bool is_strided = std::is_same_v<Out, StridedPoints<T, D>>;

    /// `used` is a constant for full blocks, so that loops are unrolled.
    template <class Count>
    void write(std::size_t block, Count used, Lanes<T>* sums) const noexcept {
        const std::size_t first = block * lanes;
        if (options_.mask.size() != 0) {
            for (std::size_t lane = 0; lane < used; ++lane) {
                const T m = options_.mask[index_of_(first + lane)][0];
                CAGEFORM_DETAIL_UNROLL
                for (std::size_t k = 0; k < D; ++k) sums[k][lane] = product(sums[k][lane], m);
            }
        }
        Lanes<T> base[D];
        if (options_.mode == CloneMode::add) {
            load(first, used, base);
        } else {
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < D; ++k) base[k] = rest_[block * D + k];
        }
        Simd<T> moved[D];
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < D; ++k) {
            const Simd<T> from = Simd<T>::load(base[k]), to = from + Simd<T>::load(sums[k]);
            // Keeps the bits of unmoved points: −0 + 0 would be +0.
            moved[k] = select<T>((to <= from) & (from <= to), from, to);
        }
        store(first, used, moved);
    }

    /// Loads the `used` points of a block from the output. Other lanes get the first point.
    template <class Count>
    void load(std::size_t first, Count used, Lanes<T>* rows) const noexcept {
        const auto take = [&](const auto& point_at) {
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const auto& p = point_at(index_of_(first + (lane < used ? lane : 0)));
                CAGEFORM_DETAIL_UNROLL
                for (std::size_t k = 0; k < D; ++k) rows[k][lane] = p[k];
            }
        };
        if (numbers_ != nullptr) {
            take([numbers = numbers_](std::size_t i) { return numbers + i * D; });
        } else {
            take([this](std::size_t i) { return to_vec<T>(out_[i]); });
        }
    }

    template <class Count>
    void store(std::size_t first, Count used, const Simd<T>* moved) const noexcept {
        if constexpr (is_strided) {
            if (by_axes_) {
                Lanes<T> row;
                CAGEFORM_DETAIL_UNROLL
                for (std::size_t k = 0; k < D; ++k) {
                    moved[k].store(row);
                    std::memcpy(out_.plain_axis(k) + first, row.v, used * sizeof(T));
                }
                return;
            }
        }
        if (numbers_ != nullptr && index_of_.order == nullptr && used == lanes)
            return interleave<T, D>(moved, numbers_ + first * D);
        alignas(64) T numbers[lanes * D];
        interleave<T, D>(moved, numbers);
        // A copy, because the output could alias this object.
        const PointIndices index_of = index_of_;
        if (T* const to = numbers_; to != nullptr) {
            for (std::size_t lane = 0; lane < used; ++lane)
                std::memcpy(to + index_of(first + lane) * D, numbers + lane * D, D * sizeof(T));
            return;
        }
        for (std::size_t lane = 0; lane < used; ++lane) {
            Vec<T, D> p{};
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < D; ++k) p[k] = numbers[lane * D + k];
            store_point(out_, index_of(first + lane), p);
        }
    }

    /// Maps a position in the binding to an index of the output.
    struct PointIndices {
        const std::uint32_t* order; ///< null: in order

        std::size_t operator()(std::size_t i) const noexcept { return order != nullptr ? order[i] : i; }
    };

    const Lanes<T>* rest_; ///< D rows a block
    PointIndices index_of_;
    std::size_t points_;
    const CloneOptions<T>& options_;
    Out& out_;
    T* numbers_ = nullptr; ///< set if all numbers of the output are contiguous
    bool by_axes_ = false; ///< set if the numbers of each axis are contiguous and in order
};

} // namespace cageform::inline CAGEFORM_ABI::detail
