#pragma once

// Where a moved mesh folds, and how far it may go from rest until it does.

#include "files/obj_file.hpp"

#include <cageform/clone/types/fold_report.hpp>
#include <cageform/figure/binding.hpp>

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Folds of the tetrahedra of a mesh, or around its vertices where it has none.
struct MeshFolds {
    bool of_cells = false;
    std::size_t places = 0; ///< tetrahedra or vertices that were looked at
    cageform::FoldReport report;
    cageform::StepReport step{.step = 1}; ///< from rest
    std::string unknown;                  ///< why nothing could be found; empty if it could

    /// Adds what is found around vertices, by the Jacobians of the deformation there.
    ///
    ///   columns      as bind_jacobians() binds the vertices from number `first` on
    ///   rest, pose   of all handles
    void add(const std::array<cageform::Binding<double, 3>, 3>& columns, std::span<const Point3> rest,
             std::span<const Point3> pose, std::size_t first, const cageform::FoldOptions& options);

    /// Returns why nothing is known; empty if all is.
    std::string fault() const;
    /// "tetrahedron 15", "v 15": counted from 1, as in the file.
    std::string name_of(std::size_t place) const;
};

/// Finds the folds of a mesh's tetrahedra.
MeshFolds folds_of_cells(const ObjFile& mesh, std::span<const Point3> moved,
                         const cageform::FoldOptions& options);

/// The folds for people, in four lines.
///
///   stops   whether the mesh goes no farther than the largest step
std::string describe(const MeshFolds& folds, bool stops);

/// The point that lies a step of the way from rest.
Point3 on_the_way(const Point3& rest, const Point3& moved, double step);

} // namespace cageform_support
