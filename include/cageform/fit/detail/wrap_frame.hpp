// The first alignment of a wrap, and the frame of its units.
#pragma once

#include <cageform/binding/detail/symmetric_matrix.hpp>
#include <cageform/fit/types/wrap.hpp>
#include <cageform/pose/detail/rigid_frame.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// x ↦ scale · Q x + shift.
struct Similarity {
    double scale = 1;
    LinearMap<double, 3> turn{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Vec<double, 3> shift{};

    /// Returns scale · Q v.
    Vec<double, 3> linear(const Vec<double, 3>& v) const noexcept {
        Vec<double, 3> to;
        for (std::size_t r = 0; r < 3; ++r)
            to[r] = scale * (turn.at[r][0] * v[0] + turn.at[r][1] * v[1] + turn.at[r][2] * v[2]);
        return to;
    }
    Vec<double, 3> operator()(const Vec<double, 3>& x) const noexcept { return linear(x) + shift; }
    Similarity inverse() const noexcept {
        Similarity to{1 / scale, {}, {}};
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) to.turn.at[r][c] = turn.at[c][r];
        }
        to.shift = -1.0 * to.linear(shift);
        return to;
    }
    /// Returns the composition x ↦ this(inner(x)).
    Similarity after(const Similarity& inner) const noexcept {
        Similarity to{scale * inner.scale, {}, (*this)(inner.shift)};
        for (std::size_t r = 0; r < 3; ++r) {
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t k = 0; k < 3; ++k) to.turn.at[r][c] += turn.at[r][k] * inner.turn.at[k][c];
            }
        }
        return to;
    }
    Transform<double, 3> transform() const noexcept {
        Transform<double, 3> to{{}, shift};
        for (std::size_t k = 0; k < 3; ++k) {
            Vec<double, 3> axis{};
            axis[k] = 1;
            to.columns[k] = linear(axis);
        }
        return to;
    }
};

/// Returns the principal axes of a surface as the rows of a rotation, the longest first. The signs make the
/// third moments positive.
inline LinearMap<double, 3> axes_of_surface(std::span<const Vec<double, 3>> vertices,
                                            std::span<const SurfaceMesh::Face> faces) {
    Vec<double, 3> centre{};
    double area = 0;
    const auto area_of = [&](const SurfaceMesh::Face& f) {
        const auto n = cross(vertices[f[1]] - vertices[f[0]], vertices[f[2]] - vertices[f[0]]);
        return std::sqrt(dot(n, n));
    };
    for (const auto& f : faces) {
        const double part = area_of(f);
        area += part;
        centre = centre + (part / 3) * (vertices[f[0]] + vertices[f[1]] + vertices[f[2]]);
    }
    centre = (1 / area) * centre;
    SquareMatrix<3> moments{};
    for (const auto& f : faces) {
        const auto sum = vertices[f[0]] + vertices[f[1]] + vertices[f[2]] - 3.0 * centre;
        const double part = area_of(f) / area / 12;
        add_outer_product(moments, part * sum, sum);
        for (const std::uint32_t i : f)
            add_outer_product(moments, part * (vertices[i] - centre), vertices[i] - centre);
    }
    const PrincipalAxes<3> axes = principal_axes(moments);
    std::array<Vec<double, 3>, 3> row{axes.vectors[2], axes.vectors[1], {}};
    for (std::size_t k = 0; k < 2; ++k) {
        double third = 0;
        for (const auto& f : faces) {
            const double x = dot(row[k], vertices[f[0]] + vertices[f[1]] + vertices[f[2]] - 3.0 * centre);
            third += area_of(f) * x * x * x;
        }
        if (third < 0) row[k] = -1.0 * row[k];
    }
    row[2] = cross(row[0], row[1]);
    LinearMap<double, 3> turn;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) turn.at[r][c] = row[r][c];
    }
    return turn;
}

/// Returns the bounds of points in rotated axes.
inline Bounds<double, 3> turned_bounds(std::span<const Vec<double, 3>> points,
                                       const LinearMap<double, 3>& turn) {
    const Similarity rotate{1, turn, {}};
    std::vector<Vec<double, 3>> turned;
    for (const auto& p : points) turned.push_back(rotate(p));
    return bounds_of(std::span<const Vec<double, 3>>(turned));
}

/// Returns the similarity that fits landmarks best (Umeyama, IEEE Trans. Pattern Anal. Mach. Intell. 13
/// (1991)), without a rotation if the landmarks are nearly on a line; or nothing for fewer than three.
inline std::optional<Similarity> similarity_of(std::span<const Landmark> landmarks) {
    if (landmarks.size() < 3) return std::nullopt;
    Vec<double, 3> from{}, to{};
    double weight = 0;
    for (const Landmark& mark : landmarks) {
        from = from + mark.weight * mark.from;
        to = to + mark.weight * mark.to;
        weight += mark.weight;
    }
    from = (1 / weight) * from;
    to = (1 / weight) * to;
    RigidFit<3> fit;
    SquareMatrix<3> spread{};
    double square = 0;
    for (const Landmark& mark : landmarks) {
        fit.add_vector(mark.from - from, mark.to - to, mark.weight);
        add_outer_product(spread, mark.weight * (mark.from - from), mark.from - from);
        square += mark.weight * dot(mark.from - from, mark.from - from);
    }
    if (!(square > 0)) return std::nullopt;
    const PrincipalAxes<3> axes = principal_axes(spread);
    RigidFrame<3> frame;
    if (axes.values[1] > 1e-4 * axes.largest()) fit.set(frame);
    Similarity found;
    double along = 0;
    for (const Landmark& mark : landmarks)
        along += mark.weight * dot(mark.to - to, frame.rotate(mark.from - from));
    if (!(along > 0)) return std::nullopt;
    found.scale = along / square;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) found.turn.at[r][c] = frame.turn.at[r][c] + (r == c ? 1 : 0);
    }
    found.shift = to - found.linear(from);
    return found;
}

/// The alignment of the source, and the units of a wrap: the target's height is 1 along the longest principal
/// axis of the source, and the centre of the target's box is the origin.
struct WrapFrame {
    Similarity first; ///< from the source to the space of the target
    Similarity unit;  ///< from the space of the target to the units
    double height = 1;

    WrapFrame(std::span<const Vec<double, 3>> source, std::span<const SurfaceMesh::Face> faces,
              std::span<const Vec<double, 3>> target, const WrapOptions& options) {
        LinearMap<double, 3> axes = axes_of_surface(source, faces);
        const auto by_landmarks = options.align ? similarity_of(options.landmarks) : std::nullopt;
        if (by_landmarks) {
            first = *by_landmarks;
            axes = Similarity{1, axes, {}}.after({1, first.inverse().turn, {}}).turn;
        }
        const auto box = turned_bounds(target, axes);
        height = box.upper[0] - box.lower[0];
        if (options.align && !by_landmarks) {
            const auto own = turned_bounds(source, axes);
            first.scale = height / (own.upper[0] - own.lower[0]);
            const Similarity back = Similarity{1, axes, {}}.inverse();
            first.shift =
                back(0.5 * (box.lower + box.upper)) - first.scale * back(0.5 * (own.lower + own.upper));
        }
        unit = {1 / height, axes, (-0.5 / height) * (box.lower + box.upper)};
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail
