// Computes two published coordinates in space, MEC-1 and MLC, from their definitions. The library does not
// have them in space, and the printed numbers show why: MEC-1 depends on the unit of length, and MLC has no
// solution at many points. Also counts the passes of the solver of maximum entropy coordinates.
//
//     bench_published [POINTS]
//
// POINTS is the number of random points inside each cage, 2,000 unless given.
#include "../tests/support/walk_on_spheres.hpp"
#include "../tests/support/weights.hpp"
#include "named_cages.hpp"

#include <cageform/coordinates/maximum_entropy.hpp>
#include <cageform/coordinates/project.hpp>

namespace {

using namespace cageform_bench;
using cageform::cross, cageform::dot, cageform::detail::length;
using cageform::Status, cageform_tests::larger;
using Point = cageform::Vec<double, 3>;
using Points = std::vector<Point>;
using Mesh = cageform::TriangleMesh<double>;
using Entropy = cageform::MaximumEntropyCoordinates<double, 3>;

/// Returns the weights of MEC-1 as extended to space; empty if the solver finds none. The prior of a vertex
/// is the product of 1/(A₁ + A₂ + A₃ − A) over its faces. A is the area of the face, A₁ to A₃ are those of
/// the triangles from p to its edges.
std::vector<double> mec1(const Mesh& cage, const Point& p) {
    std::vector<double> prior(cage.size()), weights(cage.size());
    for (const auto& face : cage.faces()) {
        double gap = -length(cross(cage[face[1]] - cage[face[0]], cage[face[2]] - cage[face[0]]));
        for (std::size_t k = 0; k < 3; ++k)
            gap += length(cross(cage[face[k]] - p, cage[face[(k + 1) % 3]] - p));
        for (const auto k : face) prior[k] -= std::log(0.5 * gap);
    }
    const double most = *std::max_element(prior.begin(), prior.end());
    for (double& q : prior) q = std::exp(q - most);
    if (cageform::project<double, 3>(prior, cage.vertices(), p, weights) != Status::ok) weights.clear();
    return weights;
}

/// Returns whether maximum likelihood coordinates exist. A face has the integral of the unit vectors from p
/// to the face. A vertex has the sum of the unit vectors along the integrals of its faces. The coordinates
/// exist if the origin is inside the hull of these sums.
bool has_likelihood(const Mesh& cage, const Point& p) {
    Points directions(cage.size());
    for (const auto& face : cage.faces()) {
        Point integral{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Point a = cage[face[k]] - p, b = cage[face[(k + 1) % 3]] - p, normal = cross(a, b);
            const double sine = length(normal);
            integral = integral + (std::atan2(sine, dot(a, b)) / sine) * normal;
        }
        for (const auto k : face) directions[k] = directions[k] + (1 / length(integral)) * integral;
    }
    std::vector<double> ones(cage.size(), 1), weights(cage.size());
    return cageform::project<double, 3>(ones, directions, Point{}, weights) == Status::ok;
}

/// Prints the mean and the largest number of passes of the solver, the least weight, and the number of points
/// without weights.
void print_passes(const Mesh& cage, const Points& points) {
    using cageform::PointState;
    namespace detail = cageform::detail;
    const detail::MeanValueTopology<3> topology(cage);
    const double scale = cageform::unit_scale(cageform::bounds_of(cage.vertices()));
    cageform::Buffer<Point> at;
    for (const auto& v : cage.vertices()) at.push_back(scale * (v - cage[0]));
    const detail::MeanValueFrame<double, 3> frame(topology, at);
    detail::WeightRows<double> rows(topology, cage.size());
    std::vector<double> weights(cage.size());
    double passes = 0, most = 0;
    for (const auto& point : points) {
        const Point p = scale * (point - cage[0]);
        (void)detail::compute_facing<double, double>(frame, {0, 1e30, 5e-4}, p, rows);
        const auto u = [&](std::size_t k) { return at[k] - p; };
        detail::EntropySolver<double, 3, decltype(u)> solver(rows.weights, u, weights);
        (void)solver.solve(0, false);
        passes += solver.passes();
        most = larger(most, solver.passes());
    }
    const auto evaluated = cageform_tests::evaluate_all(Entropy(cage), points);
    double least = 1;
    std::size_t unreached = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        unreached += evaluated.states[i] == PointState::unreached ? 1 : 0;
        least = std::fmin(least, *std::min_element(evaluated.rows[i].begin(), evaluated.rows[i].end()));
    }
    std::printf("passes: mean %.1f, most %.0f; least weight %.2g; unreached %zu\n",
                passes / double(points.size()), most, least, unreached);
}

} // namespace

int main(int argc, char** argv) {
    const long count = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 2000;
    if (argc > 2 || count < 1) {
        std::fprintf(stderr, "bench_published: expected a positive number of points\n");
        return 2;
    }
    for (const auto& [name, cage] : named_cages()) {
        const auto points = cageform_tests::points_anywhere(cage, std::size_t(count), 1);
        Points larger_vertices;
        for (const auto& v : cage.vertices()) larger_vertices.push_back(100.0 * v);
        const Mesh larger_cage(larger_vertices, cage.faces());
        const Entropy ours(cage), ours_larger(larger_cage);
        double change = 0, our_change = 0, before = 0, after = 0;
        std::size_t without = 0;
        for (const auto& p : points) {
            without += has_likelihood(cage, p) ? 0 : 1;
            const auto small_row = mec1(cage, p), large_row = mec1(larger_cage, 100.0 * p);
            if (large_row.empty()) continue;
            for (std::size_t k = 0; k < small_row.size(); ++k) {
                if (std::fabs(small_row[k] - large_row[k]) <= change) continue;
                change = std::fabs(small_row[k] - large_row[k]);
                before = small_row[k];
                after = large_row[k];
            }
        }
        Points larger_points;
        for (const auto& p : points) larger_points.push_back(100.0 * p);
        const auto rows = cageform_tests::evaluate_all(ours, points),
                   larger_rows = cageform_tests::evaluate_all(ours_larger, larger_points);
        for (std::size_t i = 0; i < points.size(); ++i)
            our_change = larger(our_change, cageform_tests::difference(rows.rows[i], larger_rows.rows[i]));
        std::printf("%s, %zu points\n"
                    "  MEC-1, from metres to centimetres: a weight changes from %.3f to %.3f\n"
                    "  maximum entropy: by %.1g\n"
                    "  MLC has no solution at %.1f %%\n"
                    "  maximum entropy, ",
                    name.c_str(), points.size(), before, after, our_change,
                    100 * double(without) / double(points.size()));
        print_passes(cage, points);
    }
}
