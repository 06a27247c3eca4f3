// Coordinate types whose handles are not all points: what a newcomer adds, by adding a file.
#pragma once

#include "meshes.hpp"

#include <cageform/coordinates/mean_value_3d.hpp>
#include <cageform/core/face_handles.hpp>

namespace cageform_tests {

using cageform::BlockView;
using cageform::Evaluation;
using cageform::HandleFace;
using cageform::HandleKind;
using cageform::PointState;

/// Green coordinates of a polygon without holes, number by number: p = Σ φ_i c_i + Σ ψ_j n_j, n_j the edges' normals.
/// Lipman, Levin, Cohen-Or: Green Coordinates (2008).
template <class T>
class PlaneGreen {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = true;

    explicit PlaneGreen(cageform::Polygon<T> cage)
        : cage_(std::move(cage))
        , report_(check(cage_)) {
        const auto vertices = cage_.vertices();
        double area = 0;
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            const auto& b = vertices[(i + 1) % vertices.size()];
            area += cageform::cross(cageform::vec_cast<double>(vertices[i]), cageform::vec_cast<double>(b));
        }
        handles_.assign(vertices.begin(), vertices.end());
        kinds_.assign(2 * vertices.size(), HandleKind::vector);
        std::fill_n(kinds_.begin(), vertices.size(), HandleKind::point);
        for (std::size_t i = 0; i < vertices.size(); ++i) { // the inside on the left
            HandleFace<2> face{std::uint32_t(i), std::uint32_t((i + 1) % vertices.size())};
            if (area < 0) std::swap(face[0], face[1]);
            faces_.push_back(face);
            handles_.push_back(cageform::edge_handle(vertices[face[0]], vertices[face[1]]));
        }
    }

    const cageform::Polygon<T>& cage() const noexcept { return cage_; }
    std::span<const Vec<T, 2>> handles() const noexcept { return handles_; }
    std::span<const HandleKind> handle_kinds() const noexcept { return kinds_; }
    std::span<const HandleFace<2>> handle_faces() const noexcept { return faces_; }
    const cageform::CageReport& cage_report() const noexcept { return report_; }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const cageform::Running& = {}) const {
        for (std::size_t i = 0; i < points.blocks() * BlockView<T>::lanes; ++i) {
            const auto row = weights_of(cageform::block_point<2>(points, i));
            double sum = 0;
            for (std::size_t h = 0; h < row.size(); ++h) {
                weights(i, h) = T(row[h]);
                if (kinds_[h] == HandleKind::point) sum += row[h];
            }
            if (i >= states.size() || states[i] == PointState::not_finite) continue;
            states[i] = sum > 0.5 ? PointState::inside : PointState::outside;
        }
        return {report_.status, {}};
    }
    Vec<T, 2> nearest_boundary(const Vec<T, 2>& p, std::span<T> row) const {
        return cageform::nearest_boundary_weights(cage_, p, row);
    }

private:
    std::vector<double> weights_of(const Vec<T, 2>& at) const {
        const auto p = cageform::vec_cast<double>(at);
        std::vector<double> row(handles_.size(), 0.0);
        for (std::size_t j = 0; j < faces_.size(); ++j) {
            const auto a = cageform::vec_cast<double>(handles_[faces_[j][0]]) - p;
            const auto b = cageform::vec_cast<double>(handles_[faces_[j][1]]) - p;
            const double length = std::hypot(b[0] - a[0], b[1] - a[1]), ra = std::hypot(a[0], a[1]),
                         rb = std::hypot(b[0], b[1]), size = 2 * std::numbers::pi * length;
            const auto along = (1 / length) * (b - a);
            const double d = cross(a, along), s1 = dot(a, along), s2 = dot(b, along);
            const double theta = std::atan2(cross(a, b), dot(a, b)), ratio = std::log(rb / ra);
            row[faces_[j][0]] += (s2 * theta - d * ratio) / size;
            row[faces_[j][1]] += (d * ratio - s1 * theta) / size;
            row[faces_.size() + j] = -(s2 * std::log(rb) - s1 * std::log(ra) - length + d * theta) / size;
        }
        return row;
    }

    cageform::Polygon<T> cage_;
    cageform::CageReport report_;
    std::vector<Vec<T, 2>> handles_;
    std::vector<HandleKind> kinds_;
    std::vector<HandleFace<2>> faces_;
};

/// Normals of a mesh with any small weights ψ; the vertices have the mean value weights of p − Σ ψ_j n_j.
template <class T>
class MeanValueWithNormals {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    explicit MeanValueWithNormals(cageform::TriangleMesh<T> mesh)
        : vertices_(std::move(mesh)) {
        const auto corners = vertices_.handles();
        handles_.assign(corners.begin(), corners.end());
        kinds_.assign(handles_.size(), HandleKind::point);
        for (const auto& face : vertices_.cage().faces()) {
            const HandleFace<3> named{std::uint32_t(face[0]), std::uint32_t(face[1]), std::uint32_t(face[2])};
            const std::array<Vec<T, 3>, 3> at{corners[named[0]], corners[named[1]], corners[named[2]]};
            faces_.push_back(named);
            handles_.push_back(cageform::face_handle(at, at));
            kinds_.push_back(HandleKind::vector);
        }
    }

    std::span<const Vec<T, 3>> handles() const noexcept { return handles_; }
    std::span<const HandleKind> handle_kinds() const noexcept { return kinds_; }
    std::span<const HandleFace<3>> handle_faces() const noexcept { return faces_; }
    const cageform::CageReport& cage_report() const noexcept { return vertices_.cage_report(); }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const cageform::Running& running = {}) const {
        const std::size_t count = vertices_.handles().size();
        std::vector<cageform::Lanes<T>> places(points.blocks() * 3), rows(points.blocks() * count);
        const BlockView<T> shifted{places.data(), 3, points.points}, row{rows.data(), count, points.points};
        for (std::size_t i = 0; i < points.blocks() * BlockView<T>::lanes; ++i) {
            auto p = cageform::block_point<3>(points, i);
            for (std::size_t j = 0; j < faces_.size(); ++j) {
                const T psi = T(0.01) * std::sin(T(j) + points(i, j % 3));
                weights(i, count + j) = psi;
                p = p - psi * handles_[count + j];
            }
            for (std::size_t k = 0; k < 3; ++k) shifted(i, k) = p[k];
        }
        const Evaluation evaluation = vertices_.evaluate(shifted, row, states, running);
        for (std::size_t i = 0; i < points.blocks() * BlockView<T>::lanes; ++i) {
            for (std::size_t h = 0; h < count; ++h) weights(i, h) = row(i, h);
        }
        return evaluation;
    }
    Vec<T, 3> nearest_boundary(const Vec<T, 3>& p, std::span<T> row) const {
        std::fill(row.begin(), row.end(), T(0));
        return vertices_.nearest_boundary(p, row.first(vertices_.handles().size()));
    }

private:
    cageform::MeanValueCoordinates<T, 3> vertices_;
    std::vector<Vec<T, 3>> handles_;
    std::vector<HandleKind> kinds_;
    std::vector<HandleFace<3>> faces_;
};

/// Bones without a cage, whose shares fall with the distance of their origins.
template <class T, std::size_t D>
class BoneCoordinates {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    explicit BoneCoordinates(const std::vector<Vec<T, D>>& origins) {
        for (const auto& origin : origins) {
            handles_.push_back(origin);
            kinds_.push_back(HandleKind::point);
            for (std::size_t k = 0; k < D; ++k) {
                handles_.push_back({});
                handles_.back()[k] = 1;
                kinds_.push_back(HandleKind::vector);
            }
        }
    }

    std::span<const Vec<T, D>> handles() const noexcept { return handles_; }
    std::span<const HandleKind> handle_kinds() const noexcept { return kinds_; }
    const cageform::CageReport& cage_report() const noexcept { return report_; }

    /// ω of every bone at a place.
    std::vector<double> shares(const Vec<T, D>& p) const {
        std::vector<double> result;
        double sum = 0;
        for (std::size_t h = 0; h < handles_.size(); h += D + 1) {
            const auto away = cageform::vec_cast<double>(handles_[h] - p);
            result.push_back(1 / (0.1 + dot(away, away)));
            sum += result.back();
        }
        for (double& share : result) share /= sum;
        return result;
    }
    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const cageform::Running& = {}) const {
        for (std::size_t i = 0; i < points.blocks() * BlockView<T>::lanes; ++i) {
            if (i < states.size() && states[i] != PointState::not_finite) states[i] = PointState::inside;
            fill(cageform::block_point<D>(points, i), [&](std::size_t h, T w) { weights(i, h) = w; });
        }
        return {};
    }
    Vec<T, D> nearest_boundary(const Vec<T, D>& p, std::span<T> row) const {
        fill(p, [&](std::size_t h, T w) { row[h] = w; });
        return p;
    }

private:
    template <class Set>
    void fill(const Vec<T, D>& p, const Set& set) const {
        const auto share = shares(p);
        for (std::size_t bone = 0; bone < share.size(); ++bone) {
            const std::size_t h = bone * (D + 1);
            set(h, T(share[bone]));
            for (std::size_t k = 0; k < D; ++k)
                set(h + 1 + k, T(share[bone] * double(p[k] - handles_[h][k])));
        }
    }

    std::vector<Vec<T, D>> handles_;
    std::vector<HandleKind> kinds_;
    cageform::CageReport report_;
};

} // namespace cageform_tests
