// What a game needs: packed figures and bindings, clones of them, and clips that move a cage. Poses from
// pins are in pose/. No dependency, no exceptions, no RTTI, no allocation per frame.
#pragma once

#include <cageform/clip/clip.hpp>
#include <cageform/clip/clip_blob.hpp>
#include <cageform/clip/curves/track.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_figure.hpp>
#include <cageform/clone/clone_rational.hpp>
#include <cageform/clone/glsl.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/version.hpp>
