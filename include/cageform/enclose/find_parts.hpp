// Finds the parts of a cage in space by its shape alone: trunk, head, limbs, fingers.
//
// A part is an area with a short border, its joint: 4π·area/border² is 2 for half a sphere and grows with the
// length of a limb. The steps:
//   1  space/part_surface.hpp   refines the faces, and measures ways along the surface
//   2  space/part_sweep.hpp     finds extremities: places that are on average farther from all others than
//                               their neighbourhood is. From each of them a front sweeps over the surface. A
//                               joint is where the front has swept much and is short, and then grows fast
//   3  space/part_cut.hpp       moves the joint to the edges nearby that cut most cheaply; hollow edges cost
//                               less (the minima rule)
//   4  space/part_finder.hpp    keeps the joints that fit together, and numbers the parts
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/result.hpp>
#include <cageform/enclose/detail/parts_of_cage.hpp>
#include <cageform/enclose/types/cage_parts.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Divides the faces and vertices of a cage among parts.
///
///   cage     a sound cage, such as make_cage returns; of any number of shells and tunnels
///   returns  a part for each of cage.faces() and each vertex. The faces of a part are connected. Part 1 is
///            the largest shell without its limbs; the others are numbered by decreasing area. A shape that
///            has no limbs, such as a sphere, is one part. Every part has a vertex
///   mirror   where the cage is its own image by a mirror across an axis, the parts are too. The parts of a
///            pair have numbers n and -n; n lies where the coordinate is larger
///   limits   a limb counts from 4π·area/border² = 2.6: mittens, whose fingers are not longer than wide, have
///            none. Where a cage joins limbs, such as legs that are closer together than two margins, the
///            trunk reaches to where they part
///   cost     some 10 ms for 60 vertices and 40 ms for 1,000; grows as O(#faces log #faces)
///   fails    as `check` does, and out_of_memory
///
/// Equal input gives equal parts.
template <Scalar T>
Result<CageParts, CageReport> find_parts(const TriangleMesh<T>& cage) {
    Result<CageParts, CageReport> found;
    found.report = check(cage);
    if (!found) return found;
    const Status status = detail::guard_memory([&] {
        found.value = detail::parts_of_cage(cage.vertices(), cage.faces());
        return Status::ok;
    });
    if (status != Status::ok) found = {{}, {status, {}, 0, {}}};
    return found;
}

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/enclose/space/part_finder.hpp>
#endif
