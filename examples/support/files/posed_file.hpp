#pragma once

// Posed points as the bytes of a file: OBJ, PLY as text or as bytes, or an array of NumPy.

#include "files/obj_file.hpp"

#include <cageform/core/vec.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

enum class PosedFormat { obj, ply, ply_text, npy };

/// Writes pose after pose of one figure. All that does not move is made ready once.
///
///   OBJ       the mesh's file with its vertices moved and its normals turned (files/obj_file.hpp), or lines
///             `v` and `f`
///   PLY       x, y, z (0 in the plane) as float or double, and faces as lists of vertices
///   NumPy     an array of #points × D, of float32 or float64, in C's order
///
/// Bytes are in the order of this machine, which the files tell. A number as text has the fewest digits that
/// restore it in its own precision.
class PosedFile {
public:
    using Triangles = std::span<const std::array<std::uint32_t, 3>>;

    /// Points with triangles, or none.
    ///
    ///   scalar_bytes   4 or 8: of a number
    PosedFile(PosedFormat format, std::size_t dimension, std::size_t scalar_bytes, std::size_t points,
              Triangles triangles);

    /// Points that are the vertices of a mesh in space, which must outlive this object.
    PosedFile(PosedFormat format, std::size_t scalar_bytes, const ObjFile& mesh);

    /// Whether the file has normals, which Jacobians move.
    bool has_normals() const { return mesh_ != nullptr && !mesh_->normals.empty(); }

    /// The bytes of a pose. Threads may call it together.
    ///
    ///   points      as many as were said, of the scalar and dimension that were said
    ///   jacobians   of the deformation at the points; none where the normals turn with the faces
    template <cageform::Scalar T, std::size_t D>
    std::string contents(std::span<const cageform::Vec<T, D>> points,
                         std::span<const Jacobian3> jacobians = {}) const;

private:
    void begin(std::size_t dimension, std::size_t scalar_bytes, std::size_t points, std::size_t faces,
               std::size_t corners); // the head; corners: the most of a face
    void add_face(std::span<const std::uint32_t> corners);

    PosedFormat format_;
    const ObjFile* mesh_ = nullptr;
    std::string head_, tail_;   // before and after the points
    bool many_corners_ = false; // a face with more than 255
};

} // namespace cageform_support
