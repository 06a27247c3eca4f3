// The results of importers and exporters of keyframe curves.
#pragma once

#include <cageform/animate/curves/key.hpp>
#include <cageform/core/status.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// Which handles of a key have an explicit length. The numbers match Unity's WeightedMode and Unreal's
/// ERichCurveTangentWeightMode. Unreal calls `in` arrive and `out` leave.
enum class WeightedHandles : std::uint8_t { none = 0, in = 1, out = 2, both = 3 };

/// An interval between two keys. The curve passes `check`. For a hold the curve is constant at the first
/// key's value.
struct KeyInterval {
    KeyKind kind = KeyKind::bezier;
    BezierCurve curve{};
};

/// The result of an import or export of a curve.
struct ExchangeReport {
    Status status = Status::ok;
    std::size_t culprit = 0; ///< index of the key or curve that failed; of an interval, its first key
};

} // namespace cageform::inline CAGEFORM_ABI
