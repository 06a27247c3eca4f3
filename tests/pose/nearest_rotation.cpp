// Nearest rotations of random, reflecting and degenerate matrices.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/pose/detail/rigid_frame.hpp>
#include <cageform/pose/detail/stretches.hpp>

#include <Eigen/Dense>

namespace nearest_rotation_tests {

using cageform::Vec;
using cageform::detail::LinearMap;

namespace {

template <std::size_t D>
Eigen::Matrix<double, int(D), int(D)> matrix(const LinearMap<double, D>& m, double diagonal = 0) {
    Eigen::Matrix<double, int(D), int(D)> to;
    for (std::size_t r = 0; r < D; ++r) {
        for (std::size_t c = 0; c < D; ++c)
            to(Eigen::Index(r), Eigen::Index(c)) = m.at[r][c] + (r == c ? diagonal : 0);
    }
    return to;
}

template <std::size_t D>
void check_random(std::uint64_t seed) {
    CAPTURE(D, seed);
    cageform_tests::Random random(seed);
    LinearMap<double, D> j{}, turn{};
    const double size = std::pow(10.0, random.uniform(-20, 20));
    for (auto& row : j.at) {
        for (double& x : row) x = size * random.uniform(-1, 1);
    }
    nearest_rotation(j, turn);
    const auto r = matrix(turn, 1);
    const auto given = matrix(j);
    const auto product = (r.transpose() * given / size).eval();
    CHECK(std::fabs(r.determinant() - 1) <= 1e-14);
    CHECK((r.transpose() * r - r.Identity()).norm() <= 1e-14);
    CHECK((product - product.transpose()).norm() <= 1e-13);
    // The trace is maximal: the sum of the singular values, the least with the sign of det J.
    const Eigen::JacobiSVD<Eigen::Matrix<double, int(D), int(D)>> svd(given / size);
    double best = svd.singularValues().sum();
    if (given.determinant() < 0) best -= 2 * svd.singularValues()(D - 1);
    CHECK(std::fabs(product.trace() - best) <= 1e-13);
}

} // namespace

TEST_CASE("the nearest rotation is proper and the best, for negative determinants too", "[pose]") {
    for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
        check_random<2>(seed);
        check_random<3>(seed);
    }
}

TEST_CASE("a symmetric matrix without negative eigenvalues gives exactly no rotation", "[pose]") {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        CAPTURE(seed);
        cageform_tests::Random random(seed);
        Eigen::Matrix3d a;
        for (Eigen::Index n = 0; n < 9; ++n) a(n) = random.uniform(-1, 1);
        const Eigen::Matrix3d square = a * a.transpose();
        LinearMap<double, 3> j{}, turn{};
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c <= r; ++c)
                j.at[r][c] = j.at[c][r] = square(Eigen::Index(r), Eigen::Index(c));
        }
        turn.at[0][1] = 0.5; // overwritten
        nearest_rotation(j, turn);
        CHECK(matrix(turn).norm() == 0);
    }
}

TEST_CASE("a matrix that determines no rotation keeps the previous one", "[pose]") {
    const LinearMap<double, 2> before = cageform::detail::rotation_of(Vec<double, 1>{0.3});
    for (const LinearMap<double, 2>& j :
         {LinearMap<double, 2>{{{0, 0}, {0, 0}}}, {{{1, 0}, {0, -1}}}, {{{0.6, 0.8}, {0.8, -0.6}}}}) {
        auto turn = before;
        nearest_rotation(j, turn);
        CHECK((matrix(turn) - matrix(before)).norm() == 0);
    }
    const LinearMap<double, 3> in_space = cageform::detail::rotation_of(Vec<double, 3>{0.3, -0.2, 0.5});
    for (const LinearMap<double, 3>& j :
         {LinearMap<double, 3>{}, LinearMap<double, 3>{{{1, 0, 0}, {0, 0, 0}, {0, 0, 0}}},
          LinearMap<double, 3>{{{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}}}) {
        auto turn = in_space;
        nearest_rotation(j, turn);
        CHECK((matrix(turn) - matrix(in_space)).norm() == 0);
    }
}

TEST_CASE("stretches are singular values", "[pose]") {
    for (std::uint64_t seed = 1; seed <= 500; ++seed) {
        CAPTURE(seed);
        cageform_tests::Random random(seed);
        LinearMap<double, 3> m{};
        LinearMap<double, 2> flat{};
        for (auto& row : m.at) {
            for (double& x : row) x = random.uniform(-1, 1);
        }
        for (auto& row : flat.at) {
            for (double& x : row) x = random.uniform(-1, 1);
        }
        const Eigen::Vector3d values = matrix(m).jacobiSvd().singularValues();
        const auto squares = cageform::detail::squared_stretches(m);
        CHECK(std::fabs(std::sqrt(squares[1]) - values(0)) <= 1e-12);
        CHECK(std::fabs(std::sqrt(squares[0]) - values(2)) <= 1e-6);
        const Eigen::Vector2d of_flat = matrix(flat).jacobiSvd().singularValues();
        const auto flat_squares = cageform::detail::squared_stretches(flat);
        CHECK(std::fabs(std::sqrt(flat_squares[1]) - of_flat(0)) <= 1e-14);
        CHECK(std::fabs(std::sqrt(flat_squares[0]) - of_flat(1)) <= 1e-14);
    }
}

} // namespace nearest_rotation_tests
