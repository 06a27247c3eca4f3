// The results of importers and exporters of keyframe curves.
#pragma once

#include <cageform/animate/curves/key.hpp>
#include <cageform/core/status.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// Which handles of a key have an explicit length. The numbers match Unity's WeightedMode and
/// Unreal's ERichCurveTangentWeightMode, which call `in` arrive and `out` leave.
enum class WeightedHandles : std::uint8_t { none = 0, in = 1, out = 2, both = 3 };

/// An interval between two keys of another program. The curve passes `check`. For a held key the curve is
/// constant at the first key's value; the second key's value starts the next interval.
struct KeyInterval {
    KeyKind kind = KeyKind::bezier;
    BezierCurve curve{};
};

/// How the import or the export of a curve went.
struct ExchangeReport {
    Status status = Status::ok;
    std::size_t culprit = 0; ///< the refused key or curve: the first key of a refused interval
};

} // namespace cageform::inline CAGEFORM_ABI
