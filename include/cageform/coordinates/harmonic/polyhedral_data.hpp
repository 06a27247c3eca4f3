// Harmonic functions of a polyhedral mesh: their boundary data is solved in the plane of each face.
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/coordinates/detail/boundary_data.hpp>
#include <cageform/coordinates/detail/face_coordinates.hpp>
#include <cageform/coordinates/harmonic/options.hpp>
#include <cageform/core/detail/buffer.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/grid/lattice/simplex_boundary.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

template <class C>
struct HarmonicSolverChoice; // in coordinates/harmonic.hpp
template <Scalar T, std::size_t D, class C, class Solvers>
    requires(D == 2 || D == 3)
class HarmonicCoordinates; // there too

namespace grid {

template <Scalar T>
struct GridBoundaryOf<PolyhedralMesh<T>> {
    using type = SimplexBoundary<3>;
};

} // namespace grid

namespace detail {

/// The boundary data of a polyhedral mesh. On a face with more than three corners it is the
/// harmonic coordinates of the face's polygon (Joshi et al., Harmonic Coordinates for Character
/// Articulation, sec. 4). They are solved once, when the problem is posed: to a quarter of the
/// accuracy, or on a lattice twice as fine as the cage's.
///
///   Plane  HarmonicPlane, as a parameter because that type is still incomplete here
template <Scalar T, class Plane>
class PolyhedralData {
public:
    using Value = BoundaryValue<3>;

    PolyhedralData() = default;
    template <class Options>
    PolyhedralData(const PolyhedralMesh<T>& mesh, const Options& options) {
        status_ = guard_memory([&] {
            Status solved = Status::ok; // the first failure
            const auto extent = bounds_of(mesh.vertices()).upper - bounds_of(mesh.vertices()).lower;
            const double longest = double(std::fmax(extent[0], std::fmax(extent[1], extent[2])));
            const auto make = [&](const Polygon<double>& polygon, double size) {
                HarmonicOptions in_plane;
                in_plane.accuracy = std::fmax(0.25 * options.accuracy, 1e-5);
                if (options.resolution != 0) {
                    in_plane.resolution = std::size_t(
                        std::clamp(std::ceil(2 * double(options.resolution) * size / longest), 32.0, 2048.0));
                }
                in_plane.multigrid.tolerance = 0.1 * options.multigrid.tolerance;
                in_plane.memory_limit = options.memory_limit;
                Plane plane(polygon, in_plane);
                const Status status = plane.solve().status;
                if (solved == Status::ok) solved = status;
                return plane;
            };
            faces_ = FaceCoordinates<Plane>(mesh, make);
            return solved;
        });
    }

    Status status() const noexcept { return status_; }
    template <class F>
    void for_each_weight(const Value& value, F&& f) const {
        faces_.for_each_weight(value, f);
    }

    template <class F>
    void for_each_handle(const Value& value, F&& f) const {
        faces_.for_each_handle(value, f);
    }

    /// Stores the weights at many boundary points, point after point.
    class Table {
    public:
        Table() = default;
        Table(const PolyhedralData& data, std::span<const Value> values) {
            for (const Value& value : values) {
                data.for_each_weight(value, [&](std::uint32_t handle, double weight) {
                    entries_.push_back({handle, weight});
                });
                ends_.push_back(entries_.size());
            }
        }
        template <class F>
        void for_each_weight(std::size_t place, F&& f) const {
            for (std::size_t n = place == 0 ? 0 : ends_[place - 1]; n < ends_[place]; ++n)
                f(entries_[n].handle, entries_[n].weight);
        }

    private:
        struct Entry {
            std::uint32_t handle;
            double weight;
        };
        Buffer<Entry> entries_;
        Buffer<std::size_t> ends_;
    };

private:
    FaceCoordinates<Plane> faces_;
    Status status_ = Status::ok;
};

using HarmonicPlane = HarmonicCoordinates<double, 2, Polygon<double>, HarmonicSolverChoice<Polygon<double>>>;

template <Scalar T>
class BoundaryData<PolyhedralMesh<T>> : public PolyhedralData<T, HarmonicPlane> {
public:
    using PolyhedralData<T, HarmonicPlane>::PolyhedralData;
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
