// Random points inside any cage.
#pragma once

#include "cages.hpp"

#include <cageform/cage/polyhedral_mesh.hpp>

#include <cmath>
#include <vector>

namespace cageform_tests {

/// Random points inside a cage. Every second try is next to a facet or an interior cell.
template <class Cage>
auto points_inside(const Cage& cage, std::size_t count, Random& random) {
    using T = typename Cage::scalar;
    constexpr std::size_t D = Cage::dimension;
    const auto bounds = cageform::bounds_of(cage.vertices());
    std::vector<Vec<T, D>> points;
    for (int tries = 0; points.size() < count && tries < 200000; ++tries) {
        Vec<T, D> p;
        for (std::size_t k = 0; k < D; ++k) p[k] = T(random.uniform(bounds.lower[k], bounds.upper[k]));
        if (tries % 2 == 0) {
            Vec<T, D> place;
            (void)cageform::nearest_boundary_value(cage, p, place);
            const double step = std::pow(10.0, random.uniform(-12, -1)); // of the way
            p = place + T(step) * (p - place);
        }
        if (locate(cage, p, cageform::coincidence_tolerance(bounds)) == cageform::PointState::inside)
            points.push_back(p);
    }
    return points;
}

} // namespace cageform_tests
