#pragma once

// The parts of the puppet as triangle meshes: skin, clothes, eyes and a cap.

#include "character/puppet.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace cageform_programs {

using Colour8 = std::array<std::uint8_t, 4>; // RGBA, linear

/// Texture coordinates on a cylinder: u about an axis, v along it and downwards.
struct Cylinder {
    std::size_t axis;
    Point3 centre;
    double around, along; // repeats of the image: around the axis, and per metre
};

inline constexpr Cylinder face_chart{1, {0, 1.95, 0}, 1, 2};

/// A mesh of one material. All lists but `faces` are per vertex, or empty.
struct PuppetPart {
    std::vector<Point3> places, normals;
    std::vector<double> weights; ///< #vertices · #bones
    std::vector<std::array<float, 2>> texture;
    std::vector<Colour8> colours;
    std::vector<std::array<std::uint32_t, 3>> faces;
};

/// The skin and the clothes, which follow the bones.
struct PuppetParts {
    PuppetPart face, hands, shirt, buttons, trousers, shoes;
};

/// Divides the puppet's mesh. Clothes cover the skin at their ends.
///
///   weights   of the mesh, #vertices · #bones
PuppetParts puppet_parts(const cageform_support::ImplicitMesh& mesh, std::span<const double> weights);

/// A ball of radius 1 about the origin: an eye that looks along y.
PuppetPart eye_part();

/// A knitted cap about the y axis. Its origin is the middle of the head; units are metres.
PuppetPart cap_part();

/// Shifts of vertices and of their normals.
struct MorphTarget {
    std::vector<Point3> shifts, turns;
};

/// The target of a deformation.
///
///   shift   of a point in space
MorphTarget morph_target(const PuppetPart& part, const std::function<Point3(const Point3&)>& shift);

/// Shifts of the face: raised corners of the mouth, and a long chin.
Point3 smile(const Point3& p);
Point3 surprise(const Point3& p);
/// A shift of the chest and the belly that breathe in.
Point3 breath(const Point3& p);

} // namespace cageform_programs
