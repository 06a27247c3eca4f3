// Reads vectors of points in blocks, into one row per axis: the inverse of target.hpp.
#pragma once

#include <cageform/clone/detail/target.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#if CAGEFORM_REGISTER_BYTES != 0
/// Returns one axis of N points from D registers with N numbers x y z x y z … each.
template <std::size_t D, std::size_t N, std::size_t Axis, class Register, std::size_t... L>
Register axis_register(const Register* numbers, std::index_sequence<L...>) noexcept {
    // Point L has this axis in number D·L + Axis.
    if constexpr (D == 2) {
        return __builtin_shufflevector(numbers[0], numbers[1], int(D * L + Axis)...);
    } else {
        const Register first_two =
            __builtin_shufflevector(numbers[0], numbers[1], int(D * L + Axis < 2 * N ? D * L + Axis : 0)...);
        return __builtin_shufflevector(first_two, numbers[2],
                                       int(D * L + Axis < 2 * N ? L : D * L + Axis - N)...);
    }
}
#endif

/// Reads a block's points x y z x y z … into D rows.
template <Scalar T, std::size_t D>
void deinterleave(const T* points, Lanes<T>* rows) noexcept {
#if CAGEFORM_REGISTER_BYTES != 0
    if constexpr (D == 2 || D == 3) {
        using Register = typename ShuffledOf<T>::type;
        constexpr std::size_t n = sizeof(Register) / sizeof(T);
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t r = 0; r < lane_count<T> / n; ++r) {
            Register numbers[D];
            std::memcpy(numbers, points + r * D * n, sizeof(numbers));
            [&]<std::size_t... Axis>(std::index_sequence<Axis...>) {
                const auto put = [&](std::size_t axis, const Register& row) {
                    std::memcpy(rows[axis].v + r * n, &row, sizeof(row));
                };
                (put(Axis, axis_register<D, n, Axis>(numbers, std::make_index_sequence<n>{})), ...);
            }(std::make_index_sequence<D>{});
        }
        return;
    }
#endif
    for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
        for (std::size_t k = 0; k < D; ++k) rows[k][lane] = points[lane * D + k];
    }
}

/// The vectors of a binding's points, multiplied by a mask. `Source` is the result of `as_strided`.
template <Scalar T, std::size_t D, class Source>
class PointRows {
public:
    PointRows(const PackedBindingView<T, D>& binding, const Source& source,
              const StridedPoints<const T, 1>& mask) noexcept
        : order_(binding.order)
        , points_(binding.points)
        , source_(&source)
        , mask_(mask) {
        if constexpr (requires { source.plain_numbers(); }) {
            if constexpr (std::is_same_v<decltype(source.plain_numbers()), const T*>)
                numbers_ = source.plain_numbers();
        }
    }

    /// Reads a block. Lanes without a point become 0.
    void load(std::size_t block, Lanes<T>* rows) const noexcept {
        constexpr std::size_t lanes = lane_count<T>;
        const std::size_t first = block * lanes, left = points_ - first, used = left < lanes ? left : lanes;
        const auto take = [&](const auto& vector_at) {
            for (std::size_t lane = 0; lane < used; ++lane) {
                const auto& v = vector_at(index(first + lane));
                CAGEFORM_DETAIL_UNROLL
                for (std::size_t k = 0; k < D; ++k) rows[k][lane] = v[k];
            }
            for (std::size_t lane = used; lane < lanes; ++lane) {
                for (std::size_t k = 0; k < D; ++k) rows[k][lane] = 0;
            }
        };
        if (numbers_ == nullptr) {
            take([this](std::size_t i) { return to_vec<T>((*source_)[i]); });
        } else if (order_ == nullptr && used == lanes) {
            deinterleave<T, D>(numbers_ + first * D, rows);
        } else {
            take([this](std::size_t i) { return numbers_ + i * D; });
        }
        if (mask_.size() == 0) return;
        for (std::size_t lane = 0; lane < used; ++lane) {
            const T m = mask_[index(first + lane)][0];
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < D; ++k) rows[k][lane] = product(rows[k][lane], m);
        }
    }

private:
    std::size_t index(std::size_t position) const noexcept {
        return order_ != nullptr ? order_[position] : position;
    }

    const std::uint32_t* order_;
    std::size_t points_;
    const Source* source_;
    StridedPoints<const T, 1> mask_;
    const T* numbers_ = nullptr; ///< set if all numbers are contiguous
};

} // namespace cageform::inline CAGEFORM_ABI::detail
