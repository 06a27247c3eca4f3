#include "splats/splat.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support {

namespace {

/// A unit vector perpendicular to another.
Point3 perpendicular(const Point3& v) {
    const Point3 w = std::fabs(v[0]) < 0.6 ? cross(v, {1, 0, 0}) : cross(v, {0, 1, 0});
    return (1 / length_of(w)) * w;
}

/// Makes the columns p and q of `a` orthogonal by a Jacobi rotation, and rotates those of `right` alike.
/// Returns false if they were orthogonal before.
bool turn_columns(Matrix3& a, Matrix3& right, std::size_t p, std::size_t q) {
    const double aa = dot(a[p], a[p]), bb = dot(a[q], a[q]), ab = dot(a[p], a[q]);
    constexpr double rounding = 1e-15;
    if (!(std::fabs(ab) > rounding * std::sqrt(aa) * std::sqrt(bb))) return false;
    const double zeta = (bb - aa) / (2 * ab);
    const double t = std::copysign(1 / (std::fabs(zeta) + std::sqrt(1 + zeta * zeta)), zeta);
    const double c = 1 / std::sqrt(1 + t * t), s = c * t;
    for (Matrix3* m : {&a, &right}) {
        const Point3 x = (*m)[p], y = (*m)[q];
        (*m)[p] = c * x - s * y;
        (*m)[q] = s * x + c * y;
    }
    return true;
}

/// The quaternion of a rotation, computed from its largest component to avoid cancellation.
std::array<double, 4> quaternion_of(const Matrix3& r) {
    const double xx = r[0][0], yy = r[1][1], zz = r[2][2];
    const std::array<double, 4> squares{1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz,
                                        1 - xx - yy + zz};
    const auto most = std::size_t(std::max_element(squares.begin(), squares.end()) - squares.begin());
    const double x = r[1][2] - r[2][1], y = r[2][0] - r[0][2], z = r[0][1] - r[1][0], xy = r[0][1] + r[1][0],
                 yz = r[1][2] + r[2][1], zx = r[2][0] + r[0][2];
    const std::array<std::array<double, 4>, 4> rows{
        {{squares[0], x, y, z}, {x, squares[1], xy, zx}, {y, xy, squares[2], yz}, {z, zx, yz, squares[3]}}};
    std::array<double, 4> q = rows[most];
    double sum = 0;
    for (const double part : q) sum += part * part;
    for (double& part : q) part /= std::sqrt(sum);
    return q;
}

} // namespace

Point3 product(const Matrix3& a, const Point3& x) {
    return x[0] * a[0] + x[1] * a[1] + x[2] * a[2];
}

Matrix3 product(const Matrix3& a, const Matrix3& b) {
    return {product(a, b[0]), product(a, b[1]), product(a, b[2])};
}

Matrix3 transposed(const Matrix3& a) {
    return {{{a[0][0], a[1][0], a[2][0]}, {a[0][1], a[1][1], a[2][1]}, {a[0][2], a[1][2], a[2][2]}}};
}

double length_of(const Point3& v) {
    return std::sqrt(dot(v, v));
}

double determinant(const Matrix3& a) {
    return dot(a[0], cross(a[1], a[2]));
}

std::size_t SingularValues::largest() const {
    return std::size_t(std::max_element(sizes.v, sizes.v + 3) - sizes.v);
}

SingularValues singular_values(const Matrix3& a) {
    double scale = 0; // avoids overflow and underflow of squares
    for (const Point3& column : a) {
        for (const double x : column.v) scale = std::max(scale, std::fabs(x));
    }
    SingularValues values;
    if (!(scale > 0)) return values;
    Matrix3 turned = a;
    for (Point3& column : turned) {
        for (double& x : column.v) x /= scale;
    }
    constexpr int most_sweeps = 30; // usually at most six are needed
    bool turns = true;
    for (int sweep = 0; sweep < most_sweeps && turns; ++sweep) {
        turns = false;
        for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}})
            turns |= turn_columns(turned, values.right, std::size_t(p), std::size_t(q));
    }
    std::array<std::size_t, 3> order{0, 1, 2};
    for (std::size_t k = 0; k < 3; ++k) values.sizes[k] = length_of(turned[k]);
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return values.sizes[i] > values.sizes[j]; });
    constexpr double flat = 1e-14;
    const auto [first, second, third] = order;
    auto& left = values.left;
    const auto is_flat = [&](std::size_t k) { return values.sizes[k] <= flat * values.sizes[first]; };
    const auto unit = [&](std::size_t k) { return (1 / values.sizes[k]) * turned[k]; };
    left[first] = unit(first);
    left[second] = is_flat(second) ? perpendicular(left[first]) : unit(second);
    const bool even = (second + 3 - first) % 3 == 1; // first, second, third in the order of the axes
    left[third] = is_flat(third) ? (even ? 1.0 : -1.0) * cross(left[first], left[second]) : unit(third);
    values.sizes = scale * values.sizes;
    return values;
}

Matrix3 nearest_orthogonal(const Matrix3& jacobian) {
    const SingularValues values = singular_values(jacobian);
    return product(values.left, transposed(values.right));
}

Matrix3 factor_of(const SplatShape& shape) {
    auto [w, x, y, z] = shape.rotation;
    const double size = std::sqrt(w * w + x * x + y * y + z * z);
    if (size > 0) {
        w /= size, x /= size, y /= size, z /= size;
    } else {
        w = 1;
    }
    const Matrix3 rotation{{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                            {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                            {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}};
    Matrix3 factor;
    for (std::size_t k = 0; k < 3; ++k) factor[k] = std::exp(shape.log_scales[k]) * rotation[k];
    return factor;
}

SplatShape shape_of(SingularValues values) {
    if (determinant(values.left) < 0) values.left[2] = -1.0 * values.left[2];
    SplatShape shape{quaternion_of(values.left), {}};
    for (std::size_t k = 0; k < 3; ++k)
        shape.log_scales[k] = std::max(std::log(values.sizes[k]), least_log_scale);
    return shape;
}

HalfSplat half_of(const Matrix3& factor, const SingularValues& posed) {
    const Point3 axis = posed.right[posed.largest()]; // in the coordinates of the factor's columns
    const Point3 along = product(factor, axis);
    HalfSplat half{HalfSplat::opacity * along, factor};
    for (std::size_t k = 0; k < 3; ++k)
        half.factor[k] = factor[k] - ((1 - HalfSplat::opacity) * axis[k]) * along;
    return half;
}

} // namespace cageform_support
