// Segments a 3D cage by shape alone: trunk, head, limbs, fingers.
//
// A part is a surface region with a short border, its joint. The compactness of a region, 4π·area/border², is
// 2 for a hemisphere and grows with the length of a limb. Steps:
//   1  space/part_surface.hpp   refines the faces and computes geodesic distances
//   2  space/part_sweep.hpp     finds extremities, the local maxima of the mean geodesic distance; sweeps a
//                               front from each. A joint is where the compactness of the swept area peaks
//   3  space/part_cut.hpp       moves the joint to nearby edges by a minimum cut; concave edges cost less
//                               (the minima rule)
//   4  space/part_finder.hpp    keeps compatible joints and numbers the parts
#pragma once

#include <cageform/enclose/detail/make_cage_into.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Assigns the faces and vertices of a 3D cage to parts.
///
///   cage     a valid cage, with any number of shells and tunnels
///   returns  a part for each face and each vertex. The faces of a part are connected; each part has a
///            vertex. Part 1 is the trunk of the largest shell; the others are numbered by decreasing area. A
///            shape without limbs, such as a sphere, is one part
///   mirror   if the cage is symmetric about an axis-aligned plane, so are the parts. Mirrored parts are
///            numbered n and -n; n has the larger coordinate
///   limits   a limb has a compactness of at least 2.6, so the fingers of a mitten are no limbs. If the cage
///            merges limbs (legs closer than two margins), the trunk extends to the place where the limbs
///            separate
///   cost     O(#faces log #faces): 10 ms for 60 vertices, 40 ms for 1,000
///   fails    the errors of `check`; out_of_memory
///
/// Deterministic.
template <Scalar T>
Result<CageParts, CageReport> find_parts(const TriangleMesh<T>& cage) {
    Result<CageParts, CageReport> found;
    found.report = check(cage);
    if (!found) return found;
    const Status status =
        detail::guard_memory([&] { found.value = detail::parts_of_cage(cage.vertices(), cage.faces()); });
    if (status != Status::ok) found = {{}, {status, {}, 0, {}}};
    return found;
}

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/enclose/space/part_finder.hpp>
#endif
