// The cage of a coordinate type that uses only the boundary of cages: its constructors and its check.
#pragma once

#include <cageform/cage/detail/refuse_interior_cells.hpp>
#include <cageform/core/detail/deleted_functions.hpp>

#include <concepts>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Copies a cage and checks it; the base of MeanValueCoordinates and GreenCoordinates.
template <class Cage>
class CheckedCage {
public:
    using scalar = typename Cage::scalar;
    static constexpr std::size_t dimension = Cage::dimension;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    explicit CheckedCage(Cage cage)
        : cage_(std::move(cage))
        , report_(check(cage_)) {}

    /// Makes the cage from the arguments of its constructor: vertices, in space with faces.
    template <PointRange R, class... More>
        requires std::constructible_from<Cage, const R&, const More&...>
    explicit(sizeof...(More) == 0) CheckedCage(const R& vertices, const More&... more)
        : CheckedCage(Cage(vertices, more...)) {}
    template <UnknownPointRange R>
    explicit CheckedCage(const R&, PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;
    template <UnknownPointRange R, class F>
    CheckedCage(const R&, const F&,
                PointTraitsNotSpecialisedForThesePoints = {}) = CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Uses only the boundary of a cell complex: interior_cells_not_supported if there are cells inside.
    explicit CheckedCage(const CellComplex<scalar, dimension>& complex) {
        report_.status = guard_memory([&] {
            cage_ = complex.boundary();
            return complex.status();
        });
        if (report_.status != Status::ok) return;
        report_ = check(cage_);
        refuse_interior_cells(complex, report_);
    }

    const Cage& cage() const noexcept { return cage_; }
    const CageReport& cage_report() const noexcept { return report_; }

protected:
    Cage cage_;
    CageReport report_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
