#pragma once

// Detects folds of deformed meshes, and the largest step without a fold.

#include "files/mesh_file.hpp"

#include <cageform/clone/types/fold_report.hpp>
#include <cageform/figure/binding.hpp>

#include <array>
#include <cstddef>
#include <span>
#include <string>

namespace cageform_support {

/// Folds of the tetrahedra of a mesh, or at its vertices if it has none.
struct MeshFolds {
    bool of_cells = false;
    std::size_t places = 0; ///< number of tetrahedra or vertices checked
    cageform::FoldReport report;
    cageform::StepReport step{.step = 1}; ///< from rest
    std::string unknown;                  ///< error if folds cannot be determined; else empty

    /// Adds folds at vertices, from the Jacobians of the deformation.
    ///
    ///   columns      bind_jacobians() of the vertices from index `first` on
    ///   rest, pose   of all handles
    void add(const std::array<cageform::Binding<double, 3>, 3>& columns, std::span<const Point3> rest,
             std::span<const Point3> pose, std::size_t first, const cageform::FoldOptions& options);

    /// The error, if any; else empty.
    std::string fault() const;
    /// "tetrahedron 15" or "v 15", from 1 as in the file.
    std::string name_of(std::size_t place) const;
};

/// Finds the folds of a mesh's tetrahedra.
MeshFolds folds_of_cells(const MeshFile& mesh, std::span<const Point3> moved,
                         const cageform::FoldOptions& options);

/// Formats the folds in four lines.
///
///   stops   whether the mesh is limited to the largest step
std::string describe(const MeshFolds& folds, bool stops);

/// Interpolates between rest and moved position.
Point3 on_the_way(const Point3& rest, const Point3& moved, double step);

} // namespace cageform_support
