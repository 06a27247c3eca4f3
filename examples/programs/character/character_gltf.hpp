#pragma once

// The puppet as a character of a game, in glTF 2.0.
//
// In world space the puppet is that of character.obj. The vertices and the joints are in centimetres with z
// up, as in many modelling programs. A node "character" above them rotates and scales them.

#include "character/parts.hpp"
#include "files/gltf_document.hpp"

namespace cageform_programs {

/// The character: joints, skinned meshes, eyes and a cap on the head, materials, morph targets, two
/// animations, a camera and a light.
///
///   mesh     the puppet, closed
///   throws   Failure if the bones have no weights
cageform_support::GltfDocument character_gltf(const cageform_support::ImplicitMesh& mesh);

} // namespace cageform_programs
