// Decomposes maps into translation, rotation and scale.
#pragma once

#include <cageform/skeleton/types/skeleton_keys.hpp>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A local transform as one array: translation, rotation, scale, axes.
struct NodeTransform {
    static constexpr std::size_t rotation = 3, scale = 7, axes = 10, size = 14; ///< first index of each

    std::array<double, size> values{0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1};

    Vec<double, 3> vector(std::size_t at) const noexcept {
        return {values[at], values[at + 1], values[at + 2]};
    }
    Quaternion<double> turn(std::size_t at) const noexcept {
        return {values[at], values[at + 1], values[at + 2], values[at + 3]};
    }
    void set_turn(std::size_t at, const Quaternion<double>& q) noexcept {
        for (std::size_t k = 0; k < 4; ++k) values[at + k] = q[k];
    }
    SkeletonKeys<double>::Map map() const noexcept {
        return SkeletonKeys<double>::composed(vector(0), turn(rotation), vector(scale), turn(axes));
    }
};

/// Decomposes a sequence of maps; successive transforms are as similar as possible.
class TransformPath {
public:
    NodeTransform next(const SkeletonKeys<double>::Map& map) {
        Eigen::Matrix3d a;
        for (Eigen::Index c = 0; c < 3; ++c) {
            for (Eigen::Index r = 0; r < 3; ++r) a(r, c) = map.axes[std::size_t(c)][std::size_t(r)];
        }
        NodeTransform result;
        for (std::size_t k = 0; k < 3; ++k) result.values[k] = map.shift[k];
        const double determinant = a.determinant(), scale = std::cbrt(determinant);
        constexpr double rounding = 1e-6; // rounding of single-precision maps
        const Eigen::Matrix3d square = a.transpose() * a / (scale * scale);
        const bool is_similar = determinant > 0 && (square - Eigen::Matrix3d::Identity()).norm() < rounding;
        if (is_similar) {
            const double kept = std::fabs(scale - 1) < rounding ? 1 : scale;
            for (std::size_t k = 0; k < 3; ++k) result.values[NodeTransform::scale + k] = kept;
            // Equal scales leave the axes undetermined: keep the last ones.
            const Quaternion<double> axes = last_.turn(NodeTransform::axes);
            result.set_turn(NodeTransform::axes, axes);
            set(result, NodeTransform::rotation, a / scale * matrix(axes).transpose());
        } else {
            stretch(a, result);
        }
        return last_ = result;
    }

private:
    static Eigen::Matrix3d matrix(const Quaternion<double>& q) {
        return Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
    }
    /// Sets a rotation with the sign nearer to the last one. After a half turn both signs are equally near
    /// and the axis decides, so repeated half turns about one axis have the same direction.
    void set(NodeTransform& to, std::size_t at, const Eigen::Matrix3d& rotation) const {
        const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
        const Quaternion<double> last = last_.turn(at);
        const double along = q.x() * last[0] + q.y() * last[1] + q.z() * last[2] + q.w() * last[3];
        const Eigen::Quaterniond step =
            q * Eigen::Quaterniond(last[3], last[0], last[1], last[2]).conjugate();
        constexpr double half_turn = 1e-6;
        const double side =
            step.vec().dot(Eigen::Vector3d(1, 0.61, 0.37)); // normal of a plane without a coordinate axis
        const double sign = (std::fabs(along) < half_turn ? side : along) < 0 ? -1 : 1;
        to.set_turn(at, {sign * q.x(), sign * q.y(), sign * q.z(), sign * q.w()});
    }
    /// Decomposes a matrix into U S Vᵀ with rotations U and V. The order and the signs of the columns make V
    /// nearest to V of the last frame.
    void stretch(const Eigen::Matrix3d& a, NodeTransform& result) const {
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
        Eigen::Vector3d s = svd.singularValues();
        if (v.determinant() < 0) {
            v.col(2) *= -1;
            u.col(2) *= -1;
        }
        if (u.determinant() < 0) {
            u.col(2) *= -1;
            s[2] *= -1;
        }
        const Eigen::Matrix3d along = matrix(last_.turn(NodeTransform::axes)) * v; // rows: the last axes
        Eigen::Matrix3d best = Eigen::Matrix3d::Identity();
        double most = -4;
        constexpr std::array<std::array<Eigen::Index, 3>, 6> orders{
            {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
        for (const auto& order : orders) {
            for (unsigned signs = 0; signs < 8; ++signs) {
                Eigen::Matrix3d change = Eigen::Matrix3d::Zero();
                double trace = 0;
                for (Eigen::Index k = 0; k < 3; ++k) {
                    const Eigen::Index from = order[std::size_t(k)];
                    change(from, k) = (signs >> k & 1) != 0 ? -1 : 1;
                    trace += along(k, from) * change(from, k);
                }
                if (!(change.determinant() > 0) || !(trace > most)) continue;
                most = trace;
                best = change;
            }
        }
        s = best.cwiseAbs().transpose() * s;
        for (std::size_t k = 0; k < 3; ++k) result.values[NodeTransform::scale + k] = s[Eigen::Index(k)];
        set(result, NodeTransform::rotation, u * best);
        set(result, NodeTransform::axes, (v * best).transpose());
    }

    NodeTransform last_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
