// Constructors of coordinate types that use only the boundary of a cage.
#pragma once

#include <cageform/cage/detail/refuse_interior_cells.hpp>
#include <cageform/core/detail/deleted_functions.hpp>

#include <concepts>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Stores and checks a cage. Base of MeanValueCoordinates and GreenCoordinates.
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

    /// Constructs the cage from vertices, and faces in 3D.
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

    /// Takes the boundary of a cell complex. Interior cells are the fault interior_cells_not_supported.
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
