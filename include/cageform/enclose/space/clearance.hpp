// make_cage in 3D: the exact distance between cage and figure, independent of the code that makes the cage.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/enclose/space/shell.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Distance between two triangles; 0 if they intersect.
inline double facet_distance(const Corners<3>& a, const Corners<3>& b) noexcept {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3 && least > 0; ++k) {
        least = (std::min)(least, segment_to_facet(a[k], a[(k + 1) % 3], b));
        least = (std::min)(least, segment_to_facet(b[k], b[(k + 1) % 3], a));
    }
    return least;
}

/// Measures distances between the faces of a figure and a cage.
template <Scalar T>
class ClearanceSearch {
public:
    ///   reach  upper bound of the distances searched
    ClearanceSearch(const TriangleMesh<T>& cage, double reach) {
        double edges = 0;
        for (const auto& face : cage.faces()) {
            facets_.push_back(Facet<3>(face, cage.vertices()).corner);
            edges += length(facets_.back()[1] - facets_.back()[0]);
        }
        hash_ = FaceHash((std::max)(edges / double(facets_.size()), reach), facets_.size());
        for (std::uint32_t f = 0; f < facets_.size(); ++f) hash_.add(f, facets_[f]);
    }

    /// Returns min(least, distance between a triangle and the cage); `least` is at most the reach.
    double within(double least, const Corners<3>& corner) const {
        const auto middle = (1.0 / 3) * (corner[0] + corner[1] + corner[2]);
        (void)hash_.any(box_of(corner).widened(least), [&](std::uint32_t f) {
            // The vector from the facet's nearest point to the centroid is a separating axis of most pairs.
            const auto nearest = point_on_facet(nearest_on_facet(middle, facets_[f]), facets_[f]);
            const auto normal = middle - nearest;
            double above = std::numeric_limits<double>::infinity(), below = -above;
            for (std::size_t k = 0; k < 3; ++k) {
                above = (std::min)(above, dot(normal, corner[k] - nearest));
                below = (std::max)(below, dot(normal, facets_[f][k] - nearest));
            }
            if (!(above - below > least * length(normal)))
                least = (std::min)(least, facet_distance(corner, facets_[f]));
            return false;
        });
        return least;
    }

private:
    std::vector<Corners<3>> facets_;
    FaceHash hash_{1, 0};
};

/// Minimum distance between the faces of a cage and of a figure, or `reach` if that is smaller.
template <Scalar T>
double exact_clearance(const TriangleMesh<T>& cage, std::span<const Corners<3>> figure, double reach,
                       const Running& running = {}) {
    const ClearanceSearch<T> search(cage, reach);
    // A few faces spread over the figure give a first bound; a low bound speeds up the search.
    double first = reach;
    for (std::size_t f = 0; f < figure.size(); f += 1 + figure.size() / 64)
        first = search.within(first, figure[f]);
    const auto runs = in_runs<double>(running, figure.size(), 64, [&] {
        return [&](std::size_t begin, std::size_t end, double& least) {
            least = first;
            for (std::size_t f = begin; f < end; ++f) least = search.within(least, figure[f]);
        };
    });
    double least = first;
    for (const double of_run : runs) least = (std::min)(least, of_run);
    return least;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
