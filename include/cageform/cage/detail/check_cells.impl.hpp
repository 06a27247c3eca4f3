// Checks that the interior cells of a cage lie inside and meet only where allowed.
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/detail/bones.hpp>
#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/detail/primitives.hpp>
#include <cageform/cage/types/interior_cells.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/types/buffer.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Checks that vertices are finite, that facets have valid indices, and that bones have a positive radius.
template <Scalar T, std::size_t D>
void check_cells(const CellComplex<T, D>& cage, CageReport& report) {
    for (std::size_t i = cage.boundary().size(); i < cage.size(); ++i) {
        if (!is_finite(cage[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    const auto& [facets, bones] = cage.cells();
    for (std::size_t n = 0; n < facets.size(); ++n) {
        if (has_missing_vertex(facets[n])) report.add(CageFaultKind::face_without_vertex, n);
    }
    for (const auto& bone : bones) {
        if (!(bone.radius > 0) || !is_finite(bone.radius))
            report.add(CageFaultKind::radius_not_positive, bone.i);
    }
}

/// The steps of `check` after `check_cells` found no fault. Each step adds to the report.
template <Scalar T, std::size_t D>
class ComplexCheck {
public:
    ComplexCheck(const CellComplex<T, D>& cage, CageReport& report)
        : cage_(cage)
        , report_(report)
        , rounding_(coincidence_tolerance(bounds_of(cage.vertices())))
        , tolerance_(double(rounding_)) {
        for (const auto& facet : cage.cells().facets) facets_.push_back({facet, cage.vertices()});
        for (const auto& bone : cage.cells().bones) bones_.push_back(placed_bone(cage, bone));
        inner_ = facets_.size();
        for_each_facet(cage.boundary(),
                       [&](const auto& facet) { facets_.push_back({facet, cage.vertices()}); });
    }

    /// Checks the vertices of cells that are not vertices of the boundary: they must be apart from all other
    /// vertices and lie inside. Unused vertices get a warning.
    void check_vertices() {
        std::vector<bool> used(cage_.size());
        for (const auto& facet : cells()) {
            for (const auto i : facet.vertex) used[i] = true;
        }
        for (const auto& bone : bones_) used[bone.i] = used[bone.j] = true;
        std::vector<std::size_t> inner;
        std::erase_if(report_.faults, [&](const CageFault& fault) {
            const bool by_cells = fault.kind == CageFaultKind::vertex_unused && used[fault.a];
            if (by_cells) inner.push_back(fault.a);
            return by_cells;
        });
        for (std::size_t i = cage_.boundary().size(); i < cage_.size(); ++i) {
            if (used[i]) inner.push_back(i);
            if (!used[i]) report_.add(CageFaultKind::vertex_unused, i);
        }
        for (const auto i : inner) {
            for (std::size_t j = 0; j < i; ++j) {
                if (length(vec_cast<double>(cage_[i]) - vec_cast<double>(cage_[j])) <= tolerance_)
                    report_.add(CageFaultKind::duplicate_vertices, j, i);
            }
            check_inside(cage_[i], i);
        }
    }

    void check_areas() {
        for (std::size_t n = 0; n < inner_; ++n) {
            const auto& [vertex, corner] = facets_[n];
            if constexpr (D == 2) {
                if (vertex[0] == vertex[1])
                    report_.add(CageFaultKind::duplicate_vertices, vertex[0], vertex[1]);
            } else {
                if (is_flat(corner, tolerance_)) report_.add(CageFaultKind::face_without_area, n);
            }
        }
    }

    /// Checks that facets lie inside, and meet the boundary and each other only in common vertices and edges.
    void check_facets() {
        for (const auto& facet : cells()) {
            std::array<double, D> middle;
            middle.fill(1.0 / double(D));
            check_inside(vec_cast<T>(point_on_facet(middle, facet.corner)), facet.vertex[0]);
        }
        for (std::size_t n = 0; n < inner_; ++n) {
            for (std::size_t m = n + 1; m < facets_.size(); ++m) {
                if (facets_touch(facets_[n], facets_[m], tolerance_))
                    touch(facets_[n].vertex[0], facets_[m].vertex[0]);
            }
        }
    }

    /// Checks that bones do not touch facets, or bones without a common joint. A bone includes all points
    /// within its radius.
    void check_bones() {
        for (std::size_t n = 0; n < bones_.size(); ++n) {
            const auto& bone = bones_[n];
            for (const auto& facet : facets_) {
                if (segment_to_facet(bone.a, bone.b, facet.corner) <= bone.radius + tolerance_)
                    touch(bone.i, facet.vertex[0]);
            }
            for (std::size_t m = 0; m < n; ++m) {
                const auto& other = bones_[m];
                const bool joined = bone.has(other.i) || bone.has(other.j);
                const double apart = segment_distance(bone.a, bone.b, other.a, other.b);
                if (joined ? contains_far_end(bone, other) || contains_far_end(other, bone)
                           : apart <= bone.radius + other.radius + tolerance_)
                    touch(other.i, bone.i);
            }
        }
    }

private:
    std::span<const Facet<D>> cells() const noexcept { return std::span(facets_).first(inner_); }
    void check_inside(const Vec<T, D>& position, std::size_t handle) {
        if (locate(cage_.boundary(), position, rounding_) != PointState::inside)
            report_.add(CageFaultKind::interior_cell_outside, handle);
    }
    void touch(std::size_t a, std::size_t b) { report_.add(CageFaultKind::interior_cells_touch, a, b); }
    /// Whether an end of bone `b`, other than a joint shared with bone `a`, lies inside bone `a`.
    bool contains_far_end(const PlacedBone<D>& a, const PlacedBone<D>& b) const noexcept {
        return (!a.has(b.i) && a.distance(b.a) <= tolerance_) ||
               (!a.has(b.j) && a.distance(b.b) <= tolerance_);
    }

    const CellComplex<T, D>& cage_;
    CageReport& report_;
    T rounding_;
    double tolerance_;
    Buffer<Facet<D>> facets_; ///< of the cells first, then of the boundary
    std::size_t inner_ = 0;   ///< number of facets of cells
    Buffer<PlacedBone<D>> bones_;
};

} // namespace detail

template <class T, std::size_t D>
CageReport check(const CellComplex<T, D>& cage) {
    return detail::report_on(cage.status(), [&](CageReport& report) {
        report = check(cage.boundary());
        if (report.status != Status::ok) return;
        detail::check_cells(cage, report);
        if (report.status != Status::ok) return;
        detail::ComplexCheck<T, D> steps(cage, report);
        steps.check_vertices();
        steps.check_areas();
        if (report.status != Status::ok) return;
        steps.check_facets();
        steps.check_bones();
    });
}

} // namespace cageform::inline CAGEFORM_ABI
