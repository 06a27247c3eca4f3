// The options of a fit of a Bézier curve: the norm that is minimised, and conditions on the pieces.
#pragma once

#include <cageform/config.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// Exact conditions on the pieces f_i of a curve C (the columns of Table 6.1 in Izdebski 2019, see
/// sobolev_fit.hpp). Flags: `FitCondition::end_value | FitCondition::knot_c0`.
enum class FitCondition : std::uint16_t {
    none = 0,
    end_value = 1,  ///< f = C at both keys
    knot_c0 = 2,    ///< continuous at inner knots
    knot_value = 4, ///< f = C at inner knots
    end_d1 = 8,     ///< f' = C' at both keys
    knot_c1 = 16,   ///< f' is continuous at inner knots
    knot_d1 = 32,   ///< f' = C' at inner knots
    end_d2 = 64,    ///< f'' = C'' at both keys
    knot_c2 = 128,  ///< f'' is continuous at inner knots
    knot_d2 = 256,  ///< f'' = C'' at inner knots
};
constexpr FitCondition operator|(FitCondition a, FitCondition b) noexcept {
    // NOLINTNEXTLINE(clang-analyzer-optin.core.EnumCastOutOfRange): flags may be combined
    return FitCondition(unsigned(a) | unsigned(b));
}
/// Whether two sets have a flag in common.
constexpr bool contains(FitCondition set, FitCondition one) noexcept {
    return (unsigned(set) & unsigned(one)) != 0;
}

namespace detail {

/// The conditions, sorted by the order of the derivative.
inline constexpr std::array at_keys{FitCondition::end_value, FitCondition::end_d1, FitCondition::end_d2};
inline constexpr std::array neighbours_agree{FitCondition::knot_c0, FitCondition::knot_c1,
                                             FitCondition::knot_c2};
inline constexpr std::array at_knots{FitCondition::knot_value, FitCondition::knot_d1, FitCondition::knot_d2};

/// Whether pieces are independent: each is determined by its own interval.
constexpr bool decoupled(FitCondition set) noexcept {
    using enum FitCondition;
    return contains(set, end_value) && contains(set, knot_value) &&
           !contains(set, knot_c0 | knot_c1 | knot_c2) && (contains(set, end_d1) || !contains(set, end_d2)) &&
           (contains(set, knot_d1) || !contains(set, knot_d2));
}

/// The number of equations in the conditions, for a number of pieces.
constexpr std::size_t condition_count(FitCondition set, std::size_t pieces) noexcept {
    std::size_t at_ends = 0, at_each_knot = 0;
    for (std::size_t order = 0; order < 3; ++order) {
        at_ends += contains(set, at_keys[order]) ? 2 : 0;
        at_each_knot += (contains(set, neighbours_agree[order]) ? 1 : 0) + //
                        (contains(set, at_knots[order]) ? 2 : 0);
    }
    return at_ends + (pieces - 1) * at_each_knot;
}

} // namespace detail

/// The norm of the error C − f that a fit minimises.
enum class FitNorm : std::uint8_t {
    sobolev, ///< value_weight ∫ (C − f)² + slope_weight ∫ (C' − f')²
    /// max |C − f|, starting from the Sobolev fit; for independent pieces only. The knot search uses
    /// the Sobolev norm.
    sup,
};

/// The default tolerance: one pixel of a screen 1920 pixels wide, relative to the extent of the animation
/// (Izdebski 2019, sec. 5.2).
inline constexpr double screen_tolerance = 1.0 / 1920;

struct FitOptions {
    FitNorm norm = FitNorm::sobolev;
    std::size_t degree = 3; ///< of the pieces: 3, 4 or 5
    FitCondition conditions = FitCondition::end_value | FitCondition::knot_value;
    double value_weight = 1; ///< of ∫ (C − f)²
    double slope_weight = 1; ///< of ∫ (C' − f')²; 0 is the L² norm
    /// Whether the weights apply after scaling the interval to one unit of time, so that the unit of
    /// time does not matter. Otherwise they apply in the curve's units.
    bool scale_free = true;
    std::size_t max_pieces = 64; ///< of `fit`: the maximum number of pieces
};

} // namespace cageform::inline CAGEFORM_ABI
