// Checks the arrays of a glTF sampler, and whether curves can be stored in one.
#pragma once

#include <cageform/exchange/detail/easing.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Checks that each key has `rows` values of each component, all numbers are finite, and times ascend.
inline ExchangeReport check_gltf(std::span<const float> times, std::span<const float> values,
                                 std::size_t components, std::size_t rows) noexcept {
    const std::size_t keys = times.size();
    if (keys == 0 || components == 0 || values.size() % (rows * keys) != 0 ||
        values.size() / (rows * keys) != components)
        return {Status::input_malformed, 0};
    for (std::size_t k = 0; k < keys; ++k) {
        const auto of_key = values.subspan(rows * components * k, rows * components);
        if (!is_finite(times[k]) || !std::all_of(of_key.begin(), of_key.end(), is_finite<float>))
            return {Status::value_not_finite, k};
        if (k > 0 && !(times[k] > times[k - 1])) return {Status::keys_not_ascending, k};
    }
    return {};
}

struct GltfInterval {
    Status status = Status::ok;
    float begin = 0, end = 0;
};

inline GltfInterval gltf_interval(const BezierCurve& curve) noexcept {
    const auto& p = curve.points;
    GltfInterval result;
    const auto refused = [&](Status status) {
        result.status = status;
        return result;
    };
    if (const Status status = check_curve(curve); status != Status::ok) return refused(status);
    for (const auto& point : p) {
        if (!fits_float(point[0]) || !fits_float(point[1])) return refused(Status::value_not_finite);
    }
    // The tolerance includes the rounding of the thirds if the interval is far from time zero.
    const double length = p[3][0] - p[0][0], third = length / 3;
    const double rounding = 4 * epsilon<double> * (std::max)(std::fabs(p[0][0]), std::fabs(p[3][0]));
    const double off =
        (std::max)(std::fabs(p[1][0] - (p[0][0] + third)), std::fabs(p[2][0] - (p[3][0] - third)));
    if (off > double(epsilon<float>) * length + rounding) return refused(Status::handle_not_allowed);
    result.begin = static_cast<float>(p[0][0]);
    result.end = static_cast<float>(p[3][0]);
    if (result.begin < 0) return refused(Status::input_malformed);
    if (!(result.end > result.begin)) return refused(Status::interval_empty);
    return result;
}

/// Whether a curve begins at the value at which the previous curve ends. The tolerance is epsilon<float>
/// times the largest absolute value of both curves.
inline bool values_meet(const BezierCurve& before, const BezierCurve& curve) noexcept {
    double size = 0;
    for (const auto* one : {&before, &curve}) {
        for (const auto& p : one->points) size = (std::max)(size, std::fabs(p[1]));
    }
    return std::fabs(before.points[3][1] - curve.points[0][1]) <= double(epsilon<float>) * size;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
