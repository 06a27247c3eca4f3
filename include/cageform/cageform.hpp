// Includes binding, all coordinate types, clones of bindings, poses from pins, and fields. The other
// folders have headers of their own, for example enclose/ (cages for a figure) and animate/ (key frames).
// A tool that exports figures needs only cageform/binding/bind.hpp, a game only cageform/runtime.hpp.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/binding/compose.hpp>
#include <cageform/binding/make_coordinates.hpp>
#include <cageform/binding/pose_samples.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/cage/control_points.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_rational.hpp>
#include <cageform/clone/clone_transposed.hpp>
#include <cageform/clone/folds.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/lattice/refine.hpp>
#include <cageform/coordinates/types.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/fields/dirichlet.hpp>
#include <cageform/fields/strokes.hpp>
#include <cageform/pose/pose_solver.hpp>
#include <cageform/version.hpp>
