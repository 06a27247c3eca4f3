// Sectors between faces at an edge: the data of the handles next to it.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/grid/corners/edge_errors.hpp>

namespace edge_errors_tests {

using cageform::Vec;
using cageform_tests::Random;

TEST_CASE("the weights of the handles at an edge sum to one and agree with the faces",
          "[grid][edges][property]") {
    Random random(1);
    const std::vector<std::array<std::uint32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    for (int n = 0; n < 100; ++n) {
        CAPTURE(n);
        std::vector<Vec<double, 3>> vertices(4);
        for (auto& v : vertices)
            v = {random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)};
        std::size_t sectors = 0;
        cageform::detail::for_each_edge_sector(vertices, faces, [&](const auto& sector) {
            ++sectors;
            const auto shared_by = [&](const std::array<double, 4>& weights) {
                Vec<double, 3> p{};
                for (std::size_t k = 0; k < 4; ++k) p = p + weights[k] * vertices[sector.handles[k]];
                return p;
            };
            const double a = random.uniform(0, 1), b = random.uniform(0, 1 - a);
            for (const std::array<double, 4>& weights :
                 {std::array<double, 4>{a, 1 - a - b, b, 0}, std::array<double, 4>{a, 1 - a - b, 0, b}}) {
                const auto shares = sector.shares(shared_by(weights));
                for (std::size_t k = 0; k < 4; ++k)
                    CHECK(shares[k] == Approx(weights[k]).epsilon(0).margin(1e-9));
            }
            double sum = 0;
            const Vec<double, 3> anywhere{random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4),
                                          random.uniform(-0.4, 0.4)};
            for (const double share : sector.shares(anywhere)) sum += share;
            CHECK(sum == Approx(1).epsilon(0).margin(1e-9));
        });
        CHECK(sectors == 12);
    }
}

} // namespace edge_errors_tests
