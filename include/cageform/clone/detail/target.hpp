// Where the points of a clone go, a block at a time: to any range, at once where its numbers lie
// one after the other.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/core/view.hpp>

#include <utility>

namespace cageform::inline CAGEFORM_ABI {

/// What a clone adds its displacements to.
enum class CloneOnto : std::uint8_t {
    rest,   ///< the bound points
    output, ///< what stands in the output: clones by several bindings of the same points add up
};

template <Scalar T>
struct CloneOptions {
    /// A number a point, by which its displacement is multiplied; none where empty. May lie in a
    /// vertex buffer.
    StridedPoints<const T, 1> mask{nullptr, 0};
    CloneOnto onto = CloneOnto::rest;
};

namespace detail {

#if CAGEFORM_REGISTER_BYTES != 0
/// Registers whose lanes are shuffled: those of 32 bytes shuffle within their halves only, so
/// halves it is.
template <class T>
struct ShuffledOf {
    typedef T type __attribute__((vector_size(register_bytes == 64 ? 64 : 16)));
};

/// Register `O` of D · N numbers x y z x y z …, taken from D registers of N numbers, one an axis.
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

/// A block's points, x y z x y z …, from its D rows.
template <Scalar T, std::size_t D>
void interleave(const Simd<T>* rows, T* points) noexcept {
#if CAGEFORM_REGISTER_BYTES != 0
    if constexpr (D == 2 || D == 3) {
        using Register = typename ShuffledOf<T>::type;
        constexpr std::size_t n = sizeof(Register) / sizeof(T);
        Register axis[D][lane_count<T> / n];
        for (std::size_t k = 0; k < D; ++k) {
            Lanes<T> row;
            rows[k].store(row);
            for (std::size_t r = 0; r < lane_count<T> / n; ++r)
                std::memcpy(&axis[k][r], row.v + r * n, sizeof(Register));
        }
        for (std::size_t r = 0; r < lane_count<T> / n; ++r) {
            Register part[D];
            for (std::size_t k = 0; k < D; ++k) part[k] = axis[k][r];
            [&]<std::size_t... O>(std::index_sequence<O...>) {
                const auto put = [&](std::size_t o, const Register& mixed) {
                    std::memcpy(points + (r * D + o) * n, &mixed, sizeof(mixed));
                };
                (put(O, interleaved_register<D, n, O>(part, std::make_index_sequence<n>{})), ...);
            }
            (std::make_index_sequence<D>{});
        }
        return;
    }
#endif
    for (std::size_t k = 0; k < D; ++k) {
        Lanes<T> row;
        rows[k].store(row);
        for (std::size_t lane = 0; lane < lane_count<T>; ++lane) points[lane * D + k] = row[lane];
    }
}

template <class P, class T, std::size_t D>
inline constexpr bool is_plain_point =
    std::is_same_v<P, Vec<T, D>> || std::is_same_v<P, std::array<T, D>> || std::is_same_v<P, T[D]>;

/// Where the numbers of a range's points lie one after the other, its first; else null.
template <class T, std::size_t D, class R>
T* plain_numbers(R& range) noexcept {
    if constexpr (requires {
                      { range.plain_numbers() } -> std::same_as<T*>;
                  }) {
        return range.plain_numbers();
    } else if constexpr (requires {
                             requires is_plain_point<std::remove_pointer_t<decltype(std::data(range))>, T, D>;
                         }) {
        return reinterpret_cast<T*>(std::data(range));
    } else {
        return nullptr;
    }
}

/// Where the points of a clone go.
template <Scalar T, std::size_t D, class Out>
struct CloneTarget {
    const Lanes<T>* rest;       ///< D rows a block
    const std::uint32_t* order; ///< null: in order
    std::size_t points;
    const CloneOptions<T>& options;
    Out& out;

    /// Writes the points of a block, displaced by `sums`.
    void write(std::size_t block, Lanes<T>* sums) const noexcept {
        const std::size_t first = block * lanes;
        if (points - first >= lanes) {
            write(block, first, std::integral_constant<std::size_t, lanes>{}, sums);
        } else {
            write(block, first, points - first, sums);
        }
    }

private:
    static constexpr std::size_t lanes = lane_count<T>;

    /// `used` is a constant for full blocks, whose loops unroll.
    template <class Count>
    void write(std::size_t block, std::size_t first, Count used, Lanes<T>* sums) const noexcept {
        if (options.mask.size() != 0) {
            for (std::size_t lane = 0; lane < used; ++lane) {
                const T m = options.mask[place(first + lane)][0];
                for (std::size_t k = 0; k < D; ++k) sums[k][lane] = product(sums[k][lane], m);
            }
        }
        Lanes<T> onto[D];
        if (options.onto == CloneOnto::output) {
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const auto p = to_vec<T>(out[place(first + (lane < used ? lane : 0))]);
                for (std::size_t k = 0; k < D; ++k) onto[k][lane] = p[k];
            }
        } else {
            for (std::size_t k = 0; k < D; ++k) onto[k] = rest[block * D + k];
        }
        Simd<T> moved[D];
        for (std::size_t k = 0; k < D; ++k) {
            const Simd<T> from = Simd<T>::load(onto[k]), to = from + Simd<T>::load(sums[k]);
            // An unmoved point keeps its bits: −0 plus nothing would be +0.
            moved[k] = select<T>((to <= from) & (from <= to), from, to);
        }
        if constexpr (requires {
                          { out.plain_axis(0) } -> std::same_as<T*>;
                      }) {
            if (order == nullptr && out.plain_axis(0) != nullptr) {
                for (std::size_t k = 0; k < D; ++k) {
                    moved[k].store(sums[k]);
                    std::memcpy(out.plain_axis(k) + first, sums[k].v, used * sizeof(T));
                }
                return;
            }
        }
        T* const plain = plain_numbers<T, D>(out);
        if (plain != nullptr && order == nullptr && used == lanes)
            return interleave<T, D>(moved, plain + first * D);
        alignas(64) T numbers[lanes * D];
        interleave<T, D>(moved, numbers);
        if (plain != nullptr) {
            for (std::size_t lane = 0; lane < used; ++lane)
                std::memcpy(plain + place(first + lane) * D, numbers + lane * D, D * sizeof(T));
            return;
        }
        for (std::size_t lane = 0; lane < used; ++lane) {
            Vec<T, D> p{};
            for (std::size_t k = 0; k < D; ++k) p[k] = numbers[lane * D + k];
            store_point(out, place(first + lane), p);
        }
    }

    std::size_t place(std::size_t i) const noexcept { return order != nullptr ? order[i] : i; }
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
