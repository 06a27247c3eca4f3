// The boundary values of harmonic coordinates on a PolyhedralMesh. Included at the end of harmonic.hpp.
#pragma once

#include <cageform/coordinates/detail/face_coordinates.hpp>
#include <cageform/coordinates/harmonic.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The functions of one face in its plane: bilinear on a rectangle, which is exact, else harmonic
/// coordinates. A template, so that only users of polyhedral meshes compile a 2D solver.
template <class Plane>
class HarmonicFace {
public:
    HarmonicFace(const Polygon<double>& polygon, const HarmonicOptions& options) {
        if (is_rectangle(polygon)) {
            const auto u = polygon[1] - polygon[0], v = polygon[3] - polygon[0];
            origin_ = polygon[0];
            sides_ = {(1 / dot(u, u)) * u, (1 / dot(v, v)) * v};
        } else {
            coordinates_.emplace(polygon, options);
        }
    }
    /// Solves the functions and keeps them.
    Status solve() { return coordinates_ ? coordinates_->solve().status : Status::ok; }

    friend void face_weights(const HarmonicFace& face, const Vec<double, 2>& p, std::span<double> row) {
        if (face.coordinates_) return face_weights(*face.coordinates_, p, row);
        const double s = std::clamp(dot(p - face.origin_, face.sides_[0]), 0.0, 1.0);
        const double t = std::clamp(dot(p - face.origin_, face.sides_[1]), 0.0, 1.0);
        row[0] = (1 - s) * (1 - t);
        row[1] = s * (1 - t);
        row[2] = s * t;
        row[3] = (1 - s) * t;
    }

private:
    /// Whether a polygon is a rectangle, to 1e-12 of its sides.
    static bool is_rectangle(const Polygon<double>& polygon) noexcept {
        if (polygon.size() != 4) return false;
        const auto u = polygon[1] - polygon[0], v = polygon[3] - polygon[0];
        const auto missed = polygon[2] - polygon[1] - v;
        const double squares = dot(u, u) + dot(v, v);
        return dot(missed, missed) <= 1e-24 * squares && std::fabs(dot(u, v)) <= 1e-12 * squares;
    }

    std::optional<Plane> coordinates_; ///< none for a rectangle, which uses the following members
    Vec<double, 2> origin_{};
    std::array<Vec<double, 2>, 2> sides_{}; ///< divided by their squared lengths
};

/// On a planar face with more than three corners, the boundary values are harmonic coordinates of the face
/// (Joshi et al., Harmonic Coordinates for Character Articulation, sec. 4). They are solved once, to a
/// quarter of the accuracy, or to the least accuracy for a uniform grid.
template <Scalar T>
struct HarmonicData<PolyhedralMesh<T>> {
    static Status make(const PolyhedralMesh<T>& mesh, const HarmonicOptions& options, BoundaryData<3>& data) {
        return guard_memory([&] {
            Status solved = Status::ok; // the first failure
            const HarmonicOptions in_plane{
                .accuracy = options.resolution != 0 ? 1e-5 : (std::max)(0.25 * options.accuracy, 1e-5),
                .memory_limit = options.memory_limit};
            using Face = HarmonicFace<HarmonicCoordinates<double, 2>>;
            data = BoundaryData<3>(
                std::make_shared<const FaceCoordinates<Face>>(mesh, [&](const Polygon<double>& polygon) {
                    Face face(polygon, in_plane);
                    const Status status = face.solve();
                    if (solved == Status::ok) solved = status;
                    return face;
                }));
            return solved;
        });
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
