// The exact clearance of 3D cages, compared with brute force.

#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/effort.hpp"

#include <cageform/enclose/space/clearance.hpp>
#include <cageform/parallel/threads.hpp>

namespace clearance_tests {

using namespace cageform;
using namespace cageform_tests;
using detail::Corners;

/// A random face near a position; some are needles, some have equal corners.
Corners<3> random_face(Random& random, const Vec<double, 3>& middle, double size) {
    Corners<3> corner;
    for (auto& p : corner) {
        for (std::size_t k = 0; k < 3; ++k) p[k] = middle[k] + size * random.uniform(-1, 1);
    }
    const std::size_t kind = random.below(8);
    if (kind == 0) corner[1] = corner[0];
    if (kind == 1) corner[1] = corner[0] + 1e-7 * (corner[2] - corner[0]);
    if (kind == 2) corner[2] = 0.3 * corner[0] + 0.7 * corner[1];
    return corner;
}
Vec<double, 3> random_place(Random& random) {
    return {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
}

TEST_CASE("the clearance is the minimum distance over all pairs of faces", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < effort<std::uint64_t>(100, 10); ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const double size = std::pow(10.0, random.uniform(-3, -0.5));
        std::vector<Vec<double, 3>> vertices;
        std::vector<std::array<std::uint32_t, 3>> faces;
        for (std::uint32_t n = 0; n < 12; ++n) {
            for (const auto& p : random_face(random, random_place(random), size)) vertices.push_back(p);
            faces.push_back({3 * n, 3 * n + 1, 3 * n + 2});
        }
        const TriangleMesh<double> cage(vertices, faces);
        std::vector<Corners<3>> figure;
        for (std::size_t n = 1 + random.below(300); n > 0; --n)
            figure.push_back(random_face(random, random_place(random), 0.3 * size));
        if (random.below(4) == 0)
            figure.back() = {vertices[0], vertices[1], vertices[2]}; // a face of the cage
        const double reach = random.uniform(0.01, 1);
        double least = reach;
        for (const auto& face : faces) {
            const Facet<3> facet(face, cage.vertices());
            for (const auto& corner : figure)
                least = std::min(least, detail::facet_distance(corner, facet.corner));
        }
        const std::span<const Corners<3>> all(figure);
        const double found = detail::exact_clearance(cage, all, reach);
        CHECK(std::fabs(found - least) <= 1e-15);
        for (const unsigned threads : {2U, 3U, 7U})
            CHECK(detail::exact_clearance(cage, all, reach, {.parallel = ThreadedFor{threads}}) == found);
    }
}

} // namespace clearance_tests
