// Pins as rows of weights, from a binding in any format.
#pragma once

#include <cageform/clone/detail/weight_rows.hpp>
#include <cageform/core/status.hpp>
#include <cageform/pose/detail/cholesky.hpp>
#include <cageform/pose/types/pose_samples.hpp>
#include <cageform/pose/types/pose_solver.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns one stored weight of a packed binding, without its scale.
template <Scalar T, std::size_t D>
double stored_weight(const PackedBindingView<T, D>& view, std::size_t row, std::size_t lane) noexcept {
    using Register = typename Simd<T>::Register;
    constexpr std::size_t step = lane_count<T> / Simd<T>::count;
    return with_format(view.format, [&]<WeightFormat F>() {
        const std::size_t first = row * lane_count<T> + lane / step * step;
        T values[step];
        store_bytes<Register>(values, load_weights<F, T>(view.weights + first * weight_bytes<T>(F)));
        return double(values[lane % step]);
    });
}

/// Returns the position at which a point is stored. Linear in #points if points are reordered.
template <Scalar T, std::size_t D>
std::size_t stored_position(const PackedBindingView<T, D>& view, std::size_t point) noexcept {
    std::size_t position = point;
    if (view.order != nullptr) {
        position = 0;
        while (view.order[position] != point) ++position;
    }
    return position;
}

/// Adds `factor` times the weights of a stored point to a row of zeros. The weights are those of a clone,
/// including the residual of a packed binding.
template <Scalar T, std::size_t D>
void add_weights(const PackedBindingView<T, D>& view, std::size_t position, double factor,
                 Lanes<double>* to) noexcept {
    const std::size_t block = position / lane_count<T>, lane = position % lane_count<T>;
    const auto add = [&](std::size_t handle, double weight) {
        to[handle / lane_count<double>][handle % lane_count<double>] += factor * weight;
    };
    const double scale = view.scale != nullptr ? double(view.scale[block]) : 1;
    for (std::size_t row = view.first_row(block); row < view.first_row(block + 1); ++row)
        add(view.handle_of_row(block, row), scale * stored_weight(view, row, lane));
    for (std::size_t i = 0; view.residual != nullptr && i < view.handles; ++i) {
        for (std::size_t r = 0; r <= D; ++r)
            add(i, double(view.residual[block * (D + 1) + r][lane]) * double(view.affine_fit[i][r]));
    }
}

/// The rows of the pins: one for the point, D more for the axes of a pin that turns.
template <Scalar T, std::size_t D>
struct PinRows {
    struct Row {
        std::uint32_t pin;
        std::uint8_t axis;    ///< D for a point
        double weight;        ///< μ m
        double points;        ///< Σ w over the point handles: 1, or 0 for an axis
        Vec<double, D> place; ///< Σ w H, in units of the samples
        Vec<double, D> rest;  ///< the bound point, in units of the cage

        bool is_point() const noexcept { return axis == D; }
    };

    std::vector<Row> rows;
    std::vector<Lanes<double>> weights; ///< block_count<double>(#handles) blocks per row
    std::size_t pins = 0;
    bool has_turns = false;

    /// Reads the pins. `culprit` becomes the refused pin. May throw std::bad_alloc.
    Status read(const PoseSamples<T, D>& samples, const PosePins<T, D>& given, double pin_weight,
                std::size_t& culprit) {
        const auto& binding = given.binding;
        if (binding.points == 0) return Status::ok;
        Status status = check_bindings(samples, given);
        if (status != Status::ok) return status;
        pins = given.points.empty() ? binding.points : given.points.size();
        has_turns = given.axes[0].points != 0;
        if ((!given.weights.empty() && given.weights.size() != pins) ||
            (!given.turned.empty() && (given.turned.size() != pins || !has_turns)))
            return Status::pins_do_not_match;
        for (std::size_t pin = 0; pin < pins; ++pin) {
            culprit = pin;
            const std::size_t point = given.points.empty() ? pin : given.points[pin];
            if (point >= binding.points) return Status::index_out_of_range;
            const double weight = given.weights.empty() ? 1 : given.weights[pin];
            if (!(weight > 0) || !is_finite(pin_weight * weight)) return Status::weights_not_positive;
            const std::size_t position = stored_position(binding, point);
            Row row{std::uint32_t(pin), D, pin_weight * weight, 0, {}, {}};
            for (std::size_t k = 0; k < D; ++k)
                row.rest[k] =
                    double(binding.rest[position / lane_count<T> * D + k][position % lane_count<T>]);
            status = add(samples, row, binding, position, 1);
            const bool turns = has_turns && (given.turned.empty() || given.turned[pin] != 0);
            for (std::size_t axis = 0; axis < D && turns && status == Status::ok; ++axis) {
                row.axis = std::uint8_t(axis);
                status = add(samples, row, given.axes[axis], position, turn_lever * samples.size);
            }
            if (status != Status::ok) return status;
        }
        culprit = PoseSolverReport::none;
        return Status::ok;
    }

private:
    static Status check_bindings(const PoseSamples<T, D>& samples, const PosePins<T, D>& given) {
        if (given.binding.handles != samples.handle_count()) return Status::bindings_differ;
        for (std::size_t i = 0; i < samples.handle_count(); ++i) {
            if (!(given.binding.rest_handles[i] == samples.rest_handles[i])) return Status::bindings_differ;
        }
        for (const auto& axis : given.axes) {
            const bool matches =
                axis.points == 0 ? given.axes[0].points == 0 : bindings_match(given.binding, axis);
            if (!matches) return Status::bindings_differ;
        }
        return Status::ok;
    }

    Status add(const PoseSamples<T, D>& samples, Row row, const PackedBindingView<T, D>& binding,
               std::size_t position, double factor) {
        const std::size_t blocks = block_count<double>(samples.handle_count()), first = weights.size();
        weights.resize(first + blocks);
        for (std::size_t b = 0; b < blocks; ++b) Simd<double>(0).store(weights[first + b]);
        Lanes<double>* const to = weights.data() + first;
        add_weights(binding, position, factor, to);
        double sum = 0;
        row.points = 0;
        row.place = {};
        for (std::size_t i = 0; i < samples.handle_count(); ++i) {
            const double weight = to[i / lane_count<double>][i % lane_count<double>];
            const bool is_point = samples.handle_kinds[i] == HandleKind::point;
            sum += std::fabs(weight);
            row.points += is_point ? weight : 0;
            row.place = row.place + weight * unit_handle(samples, i);
        }
        if (!(sum > 0) || !is_finite(sum)) return Status::pin_without_weights;
        rows.push_back(row);
        return Status::ok;
    }

public:
    /// Returns a handle at rest, in units of the samples.
    static Vec<double, D> unit_handle(const PoseSamples<T, D>& samples, std::size_t i) noexcept {
        const auto h = vec_cast<double>(samples.rest_handles[i]);
        return (1 / samples.size) * (samples.handle_kinds[i] == HandleKind::point ? h - samples.centre : h);
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
