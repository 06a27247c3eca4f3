// Harmonic coordinates in cages whose faces are planar polygons.
#pragma once

#include <cageform/coordinates/detail/face_coordinates.hpp>
#include <cageform/coordinates/harmonic.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace grid {

template <Scalar T>
struct GridBoundaryOf<PolyhedralMesh<T>> {
    using type = SimplexBoundary<3>;
};

} // namespace grid

namespace detail {

/// On a face of more than three corners the harmonic coordinates of its polygon (Joshi et al.,
/// Harmonic Coordinates for Character Articulation, sec. 4), solved when the problem is posed, to a
/// quarter of the accuracy or on a lattice twice as fine as the cage's; kept.
template <Scalar T>
class BoundaryData<PolyhedralMesh<T>> {
    using Plane = HarmonicCoordinates<double, 2>;

public:
    using Value = BoundaryValue<3>;

    BoundaryData() = default;
    template <class Options>
    BoundaryData(const PolyhedralMesh<T>& mesh, const Options& options) {
        status_ = guard_memory([&] {
            Status solved = Status::ok; // the first that is not
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

    /// Weights one after the other, of place after place.
    class Table {
    public:
        Table() = default;
        Table(const BoundaryData& data, std::span<const Value> values) {
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

} // namespace detail

/// Deduced from the cage: `HarmonicCoordinates coordinates(mesh)`.
template <Scalar T>
HarmonicCoordinates(PolyhedralMesh<T>, const HarmonicOptions& = {})
    -> HarmonicCoordinates<T, 3, PolyhedralMesh<T>>;

} // namespace cageform::inline CAGEFORM_ABI
