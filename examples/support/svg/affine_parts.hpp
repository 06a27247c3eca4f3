#pragma once

// Parts of a drawing that one affine map moves: in an animation they need no paths.

#include "svg/curves.hpp"
#include "svg/style.hpp"
#include "svg/walk.hpp"

#include <vector>

namespace cageform_support::detail {

/// An element that is moved as a whole: shapes [first, end).
struct AffinePart {
    pugi::xml_node node;
    Affine2 to_root;
    std::size_t first = 0, end = 0;
    std::vector<Affine2> maps = {}; // in every frame, in root user space
    Box box = {};                   // at rest, in its own user space
};

/// The largest groups and shapes for which one affine map is right in every frame, up to the tolerance,
/// strokes included. No part lies in a clip path or mask. No part has markers, a clip path, a mask, a filter
/// or text on a path. A shape alone is left out where its path takes fewer bytes than a transform.
std::vector<AffinePart> affine_parts(const Drawing& rest, const CurveDeformer& curves, std::size_t frames,
                                     double tolerance);

} // namespace cageform_support::detail
