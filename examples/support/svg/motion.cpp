#include "svg/motion.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_support::detail {

void Motion::merge(const Point2& rest, const Point2& moved, double weight) {
    if (!(weight > 0)) return;
    const double sum = weight_ + weight;
    const Point2 r{rest.x - rest_mean_.x, rest.y - rest_mean_.y};
    const Point2 m{moved.x - moved_mean_.x, moved.y - moved_mean_.y};
    const double part = weight / sum;
    rest_mean_ = {rest_mean_.x + part * r.x, rest_mean_.y + part * r.y};
    moved_mean_ = {moved_mean_.x + part * m.x, moved_mean_.y + part * m.y};
    const double f = weight_ * part;
    xx_ += f * r.x * r.x;
    xy_ += f * r.x * r.y;
    yy_ += f * r.y * r.y;
    mixed_xx_ += f * m.x * r.x;
    mixed_xy_ += f * m.x * r.y;
    mixed_yx_ += f * m.y * r.x;
    mixed_yy_ += f * m.y * r.y;
    square_ += f * (m.x * m.x + m.y * m.y);
    weight_ = sum;
}

void Motion::add(const Point2& rest, const Point2& moved, double weight) {
    moved_ = moved_ || !(rest == moved);
    merge(rest, moved, weight);
}

void Motion::add(const Motion& other) {
    moved_ = moved_ || other.moved_;
    merge(other.rest_mean_, other.moved_mean_, other.weight_);
    xx_ += other.xx_;
    xy_ += other.xy_;
    yy_ += other.yy_;
    mixed_xx_ += other.mixed_xx_;
    mixed_xy_ += other.mixed_xy_;
    mixed_yx_ += other.mixed_yx_;
    mixed_yy_ += other.mixed_yy_;
    square_ += other.square_;
}

std::optional<Affine2> Motion::best_map() const {
    if (!moved_) return Affine2();
    const auto about_means = [&](double a, double b, double c, double d) -> std::optional<Affine2> {
        const double determinant = a * d - b * c;
        const double square = a * a + b * b + c * c + d * d;
        if (!(std::abs(determinant) > 1e-6 * square) || !std::isfinite(square)) return std::nullopt;
        return Affine2{a,
                       b,
                       c,
                       d,
                       moved_mean_.x - a * rest_mean_.x - c * rest_mean_.y,
                       moved_mean_.y - b * rest_mean_.x - d * rest_mean_.y};
    };
    const double spread = xx_ + yy_;
    if (!(spread > 0)) return about_means(1, 0, 0, 1);

    // the best similarity: columns (a, b) and (-b, a)
    const double a = (mixed_xx_ + mixed_yy_) / spread;
    const double b = (mixed_yx_ - mixed_xy_) / spread;
    // its residual times the points at rest, M; the best map adds D, with D (second moments + ridge) = M
    const double miss_xx = mixed_xx_ - (a * xx_ - b * xy_);
    const double miss_xy = mixed_xy_ - (a * xy_ - b * yy_);
    const double miss_yx = mixed_yx_ - (b * xx_ + a * xy_);
    const double miss_yy = mixed_yy_ - (b * xy_ + a * yy_);
    struct Difference {
        double a, b, c, d;
    };
    const auto with_ridge = [&](double ridge) {
        const double p = xx_ + ridge;
        const double q = yy_ + ridge;
        const double determinant = p * q - xy_ * xy_;
        return Difference{
            (miss_xx * q - miss_xy * xy_) / determinant, (miss_yx * q - miss_yy * xy_) / determinant,
            (miss_xy * p - miss_xx * xy_) / determinant, (miss_yy * p - miss_yx * xy_) / determinant};
    };
    constexpr double rounding = 1e-14; // relative error of the second moments
    const Difference plain = with_ridge(rounding * spread);
    const double explained = (a + plain.a) * mixed_xx_ + (b + plain.b) * mixed_yx_ +
                             (plain.c - b) * mixed_xy_ + (a + plain.d) * mixed_yy_;
    const double missed = std::max(0.0, square_ - explained);
    const double ridge = square_ > 0 ? missed / square_ * spread : 0;
    const Difference d = with_ridge(ridge + rounding * spread);
    const auto best = about_means(a + d.a, b + d.b, d.c - b, a + d.d);
    return best ? best : about_means(a, b, -b, a);
}

} // namespace cageform_support::detail
