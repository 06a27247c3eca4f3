#pragma once

// Writes posed points: OBJ, ASCII and binary PLY, NumPy arrays, and files of meshes.

#include "files/mesh_file.hpp"

#include <cageform/core/vec.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace cageform_support {

enum class PosedFormat : std::uint8_t { obj, ply, ply_text, npy, mesh };

/// Writes poses of a figure. Everything that does not move is formatted once.
///
///   mesh    the mesh's file with moved vertices and normals
///   OBJ     lines `v` and `f`
///   PLY     x, y, z (0 in the plane) as float or double, and faces as lists of vertices
///   NumPy   an array of #points × D, float32 or float64, in C order
///
/// Byte order is that of the machine, as declared in the files. Numbers in text have the fewest digits that
/// restore them in their own precision.
class PosedFile {
public:
    using Triangles = std::span<const std::array<std::uint32_t, 3>>;

    /// Points, optionally with triangles.
    ///
    ///   scalar_bytes   4 or 8 per number
    PosedFile(PosedFormat format, std::size_t dimension, std::size_t scalar_bytes, std::size_t points,
              Triangles triangles);

    /// The vertices of a mesh in space, which must outlive this object.
    PosedFile(PosedFormat format, std::size_t scalar_bytes, const MeshFile& mesh);

    /// Whether the file has normals, for which Jacobians are useful.
    bool has_normals() const { return mesh_ != nullptr && !mesh_->normals.empty(); }

    /// The contents of the file of a pose. Thread-safe.
    ///
    ///   points      number, scalar and dimension as passed to the constructor
    ///   jacobians   of the deformation at the points; if empty, normals rotate with the faces
    ///   fails       if the format of the mesh cannot store the pose
    template <cageform::Scalar T, std::size_t D>
    Expected<std::string> contents(std::span<const cageform::Vec<T, D>> points,
                                   std::span<const Jacobian3> jacobians = {}) const;

private:
    void begin(std::size_t dimension, std::size_t scalar_bytes, std::size_t points, std::size_t faces,
               std::size_t corners); // writes the head; corners: maximum per face
    void add_face(std::span<const std::uint32_t> corners);

    PosedFormat format_;
    const MeshFile* mesh_ = nullptr;
    std::string head_, tail_;   // before and after the points
    bool many_corners_ = false; // a face has more than 255 corners
};

} // namespace cageform_support
