#include "splats/harmonics.hpp"

#include <Eigen/LU>

namespace cageform_support {

namespace {

/// Directions. Values at the first 2l + 1 of them determine a function of degree l, 1 to 3, with a small
/// condition number.
const std::array<Point3, 7>& directions() {
    static const std::array<Point3, 7> units = [] {
        std::array<Point3, 7> all{Point3{0, 1, -1}, Point3{1, 0, -1}, Point3{1, 1, 1}, Point3{1, -2, -2},
                                  Point3{0, 1, 0},  Point3{2, 0, 1},  Point3{1, 0, 0}};
        for (Point3& p : all) p = (1 / length_of(p)) * p;
        return all;
    }();
    return units;
}

/// The matrix from values at the directions to coefficients of a degree, row-major.
template <std::size_t Degree>
std::array<double, (2 * Degree + 1) * (2 * Degree + 1)> solved_system() {
    constexpr int count = 2 * Degree + 1;
    Eigen::Matrix<double, count, count, Eigen::RowMajor> values;
    for (int i = 0; i < count; ++i) {
        std::array<double, most_harmonics> all{};
        harmonics_at(directions()[std::size_t(i)], all);
        for (int j = 0; j < count; ++j) values(i, j) = all[harmonics_of(Degree - 1) + std::size_t(j)];
    }
    std::array<double, std::size_t(count * count)> solved{};
    Eigen::Map<decltype(values)>(solved.data()) = values.inverse();
    return solved;
}

template <std::size_t Degree>
void turn_degree(const std::array<std::array<double, most_harmonics>, 7>& turned, std::span<double> all) {
    constexpr std::size_t count = 2 * Degree + 1, first = harmonics_of(Degree - 1);
    static const auto solved = solved_system<Degree>();
    const auto coefficients = all.subspan<first, count>();
    std::array<double, count> values{};
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j) values[i] += turned[i][first + j] * coefficients[j];
    }
    for (std::size_t j = 0; j < count; ++j) {
        double sum = 0;
        for (std::size_t i = 0; i < count; ++i) sum += solved[j * count + i] * values[i];
        coefficients[j] = sum;
    }
}

} // namespace

// Orthonormal, with the Condon-Shortley phase: Sloan, Stupid Spherical Harmonics Tricks, GDC 2008, appendix
// A2.
void harmonics_at(const Point3& d, std::span<double, most_harmonics> values) {
    const double x = d[0], y = d[1], z = d[2], xx = x * x, yy = y * y, zz = z * z;
    constexpr double one = 0.4886025119029199, two = 1.0925484305920792, round = 0.31539156525252005,
                     half = 0.5462742152960396, three = 0.5900435899266435, all = 2.890611442640554,
                     side = 0.4570457994644658, up = 0.3731763325901154, lobes = 1.445305721320277;
    values[0] = -one * y;
    values[1] = one * z;
    values[2] = -one * x;
    values[3] = two * x * y;
    values[4] = -two * y * z;
    values[5] = round * (2 * zz - xx - yy);
    values[6] = -two * x * z;
    values[7] = half * (xx - yy);
    values[8] = -three * y * (3 * xx - yy);
    values[9] = all * x * y * z;
    values[10] = -side * y * (4 * zz - xx - yy);
    values[11] = up * z * (2 * zz - 3 * xx - 3 * yy);
    values[12] = -side * x * (4 * zz - xx - yy);
    values[13] = lobes * z * (xx - yy);
    values[14] = -three * x * (xx - 3 * yy);
}

TurnedHarmonics::TurnedHarmonics(const Matrix3& orthogonal) {
    const Matrix3 back = transposed(orthogonal);
    for (std::size_t i = 0; i < turned_.size(); ++i) harmonics_at(product(back, directions()[i]), turned_[i]);
}

void TurnedHarmonics::turn(std::span<double> coefficients) const {
    if (coefficients.size() >= harmonics_of(1)) turn_degree<1>(turned_, coefficients);
    if (coefficients.size() >= harmonics_of(2)) turn_degree<2>(turned_, coefficients);
    if (coefficients.size() >= harmonics_of(3)) turn_degree<3>(turned_, coefficients);
}

} // namespace cageform_support
