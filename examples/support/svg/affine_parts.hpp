#pragma once

// Parts of a drawing that move affinely. In an animation they need a transform only, no paths.

#include "svg/curves.hpp"
#include "svg/style.hpp"
#include "svg/walk.hpp"

#include <vector>

namespace cageform_support::detail {

/// An element that moves by a transform; it contains the shapes [first, end).
struct AffinePart {
    pugi::xml_node node;
    Affine2 to_root;
    std::size_t first = 0, end = 0;
    std::vector<Affine2> maps = {}; // #frames, in root user space
    Box box = {};                   // at rest, in its own user space
};

/// Finds the largest groups and shapes that move affinely in every frame. `tolerance`, in root user units,
/// holds for paths and strokes. Parts are not in a clip path or mask, and contain no markers, dashed strokes,
/// clip path, mask, filter or text on a path. A single shape is skipped if its path takes fewer bytes than a
/// transform.
std::vector<AffinePart> affine_parts(const Drawing& rest, const CurveDeformer& curves, std::size_t frames,
                                     double tolerance);

} // namespace cageform_support::detail
