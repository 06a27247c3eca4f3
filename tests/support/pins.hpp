// Figures with pins: the cat, a bar in space, and the energy of their poses by its definition.
#pragma once

#include "../catch.hpp"
#include "effort.hpp"
#include "meshes.hpp"
#include "oracle.hpp"

#include <cageform/binding/pose_samples.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <Eigen/Dense>

namespace cageform_tests {

using cageform::PoseOptions;
using cageform::PoseSampleOptions;
using cageform::PoseSamples;
using cageform::PoseSolver;
using cageform::PoseSolverReport;
using cageform::Status;

template <std::size_t D>
using Places = std::vector<Vec<double, D>>;

inline Places<2> cat_cage() {
    return read_oracle("meanvalue2d_cat").vertices;
}
/// Two feet, an ear, the end of the tail, the back, the rump.
inline Places<2> cat_pins() {
    return {{1.37, 0.5}, {5.65, 0.5}, {1.25, 5.5}, {8.4, 5.85}, {3.75, 3.2}, {6.25, 3.5}};
}
/// The tail forward and the head down, so that both bend.
inline Places<2> cat_targets() {
    auto targets = cat_pins();
    targets[2] = {0.4, 4.6};
    targets[3] = {6.6, 6.7};
    return targets;
}
/// A bar of 2 × 2 × 6 squares, and seven pins in it.
inline MeshData bar() {
    return divided_box({2, 2, 6}, 0.5);
}
inline Places<3> bar_pins() {
    return {{-0.3, -0.2, -1.3}, {0.3, -0.2, -1.3}, {0, 0.3, -1.2}, {0.1, 0, 0.1},
            {-0.3, 0.3, 1.3},   {0.3, 0.3, 1.3},   {0, -0.3, 1.35}};
}
/// One end of the bar moved to the side and turned.
inline Places<3> bar_targets() {
    auto targets = bar_pins();
    for (std::size_t n = 4; n < 7; ++n) {
        const auto& [x, y, z] = targets[n].v;
        targets[n] = {x * std::cos(0.9) + (z - 0.2) * std::sin(0.9) + 0.3, y + 0.1,
                      (z - 0.2) * std::cos(0.9) - x * std::sin(0.9) + 0.2};
    }
    return targets;
}

/// Makes samples, or fails the test.
template <class C>
auto sampled(const C& coordinates, const PoseSampleOptions& options = {}) {
    auto [samples, report] = pose_samples(coordinates, options);
    CAPTURE(to_string(report.status));
    REQUIRE(report.status == Status::ok);
    return std::move(samples);
}
template <class C, class Points>
auto bound(const C& coordinates, const Points& points) {
    auto [binding, report] = cageform::bind(coordinates, points);
    REQUIRE(report.status == Status::ok);
    return std::move(binding);
}

/// A figure's pins, bound, and a solver that has them.
template <class C>
struct Pinned {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

    PoseSampleOptions sampling;
    PoseOptions options;
    C coordinates;
    Places<D> pins;
    cageform::Binding<T, D> binding;
    PoseSolver<T, D> solver;
    std::vector<Vec<T, D>> rest, pose;

    Pinned(const C& of, const Places<D>& at, const PoseSampleOptions& how = {},
           const PoseOptions& solving = {})
        : sampling(how)
        , options(solving)
        , coordinates(of)
        , pins(at)
        , binding(bound(of, at))
        , solver(sampled(of, how), solving)
        , rest(of.handles().begin(), of.handles().end())
        , pose(rest) {
        REQUIRE(solver.status() == Status::ok);
        set_pins();
    }
    void set_pins(std::span<const double> weights = {}) {
        REQUIRE(solver.set_pins({.binding = binding.view(), .weights = weights}) == Status::ok);
    }
    double size() const { return solver.samples().size; }

    PoseSolverReport solve(const Places<D>& targets, std::size_t frames = 1) {
        PoseSolverReport report;
        for (std::size_t n = 0; n < frames; ++n) {
            report = solver.solve(targets, pose);
            CAPTURE(to_string(report.status));
            REQUIRE(report.status == Status::ok);
        }
        return report;
    }
    /// Returns the largest distance of a handle from where f takes it from rest.
    template <class F>
    double distance_from(const F& f) const {
        double largest = 0;
        for (std::size_t i = 0; i < rest.size(); ++i) {
            const auto d = cageform::vec_cast<double>(pose[i]) -
                           f(cageform::vec_cast<double>(rest[i]), handle_view(coordinates).is_point(i));
            largest = std::fmax(largest, std::sqrt(dot(d, d)));
        }
        return largest / size();
    }
    double distance_from_rest() const {
        return distance_from([](const auto& h, bool) { return h; });
    }
    double distance_from_pose(const std::vector<Vec<T, D>>& other) const {
        double largest = 0;
        for (std::size_t i = 0; i < pose.size(); ++i) {
            const auto d = cageform::vec_cast<double>(pose[i] - other[i]);
            largest = std::fmax(largest, std::sqrt(dot(d, d)));
        }
        return largest / size();
    }
};
template <class C>
Pinned(const C&, const Places<C::dimension>&) -> Pinned<C>;
template <class C>
Pinned(const C&, const Places<C::dimension>&, const PoseSampleOptions&) -> Pinned<C>;
template <class C>
Pinned(const C&, const Places<C::dimension>&, const PoseSampleOptions&, const PoseOptions&) -> Pinned<C>;

/// A rotation about a fixed axis, and a shift.
template <std::size_t D>
struct Motion {
    double angle;
    Vec<double, D> shift;

    Vec<double, D> operator()(const Vec<double, D>& p, bool is_point) const {
        Vec<double, D> turned;
        if constexpr (D == 2) {
            turned = {std::cos(angle) * p[0] - std::sin(angle) * p[1],
                      std::sin(angle) * p[0] + std::cos(angle) * p[1]};
        } else {
            const double s = std::sqrt(1.0 / 14); // about (1, 2, 3)
            const Vec<double, 3> axis{s, 2 * s, 3 * s};
            turned = std::cos(angle) * p + std::sin(angle) * cross(axis, p) +
                     (1 - std::cos(angle)) * dot(axis, p) * axis;
        }
        return is_point ? turned + shift : turned;
    }
    Places<D> of(const Places<D>& places) const {
        Places<D> moved;
        for (const auto& p : places) moved.push_back((*this)(p, true));
        return moved;
    }
};

/// The energy of a pose by its definition, term after term, with rotations by singular values: what does not
/// depend on the type of coordinates.
template <std::size_t Dimension>
class EnergyTerms {
public:
    static constexpr std::size_t D = Dimension;
    using Matrix = Eigen::Matrix<double, int(D), int(D)>;
    using Handles = Eigen::Matrix<double, int(D), Eigen::Dynamic>;

    EnergyTerms(double size, double pin_weight, const Places<D>& rest, std::size_t clusters)
        : size_(size)
        , weight_(pin_weight)
        , rest_(handles_of(rest))
        , clusters_(clusters) {}

    /// A sample, or a spoke with its gradient as the first column.
    struct Term {
        Eigen::MatrixXd slope; ///< #handles × D
        Matrix rest;           ///< the rotation's factor
        double weight;
    };
    struct Pin {
        Eigen::VectorXd row;
        Eigen::Matrix<double, int(D), 1> offset;
    };
    Term term(const Matrix& rest, double weight) const {
        return {Eigen::MatrixXd::Zero(rest_.cols(), Eigen::Index(D)), rest, weight};
    }
    void add(std::size_t cluster, Term term) { clusters_[cluster].push_back(std::move(term)); }
    void add(Pin pin) { pins_.push_back(std::move(pin)); }

    static Handles handles_of(const Places<D>& pose) {
        Handles h(Eigen::Index(D), Eigen::Index(pose.size()));
        for (std::size_t i = 0; i < pose.size(); ++i) {
            for (std::size_t k = 0; k < D; ++k) h(Eigen::Index(k), Eigen::Index(i)) = pose[i][k];
        }
        return h;
    }
    double operator()(const Handles& h) const { return evaluate(h, nullptr); }
    /// The gradient, times the cage's size.
    Handles gradient(const Handles& h) const {
        Handles g = Handles::Zero(h.rows(), h.cols());
        evaluate(h, &g);
        return size_ * g;
    }
    /// The best rotation of each cluster.
    std::vector<Matrix> rotations(const Handles& h) const {
        std::vector<Matrix> turns;
        for (const auto& cluster : clusters_) turns.push_back(rotation(cluster, h));
        return turns;
    }

private:
    static Matrix rotation(const std::vector<Term>& cluster, const Handles& h) {
        Matrix sum = Matrix::Zero();
        for (const Term& term : cluster) sum += term.weight * (h * term.slope) * term.rest.transpose();
        const Eigen::JacobiSVD<Matrix> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Matrix signs = Matrix::Identity();
        if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) signs(D - 1, D - 1) = -1;
        return svd.matrixU() * signs * svd.matrixV().transpose();
    }
    double evaluate(const Handles& h, Handles* gradient) const {
        double energy = 0;
        for (const auto& cluster : clusters_) {
            const Matrix turn = rotation(cluster, h);
            for (const Term& term : cluster) {
                const Matrix off = h * term.slope - turn * term.rest;
                energy += term.weight * off.squaredNorm();
                if (gradient != nullptr) *gradient += 2 * term.weight * off * term.slope.transpose();
            }
        }
        for (const Pin& pin : pins_) {
            const auto miss = ((h - rest_) * pin.row - pin.offset).eval();
            const double factor = weight_ / (size_ * size_);
            energy += factor * miss.squaredNorm();
            if (gradient != nullptr) *gradient += 2 * factor * miss * pin.row.transpose();
        }
        return energy;
    }

    double size_, weight_;
    Handles rest_;
    std::vector<std::vector<Term>> clusters_;
    std::vector<Pin> pins_;
};

/// The energy of a pose by its definition, of a figure and its pins.
template <class C>
class SampledEnergy : public EnergyTerms<C::dimension> {
public:
    static constexpr std::size_t D = C::dimension;
    using Terms = EnergyTerms<D>;
    using typename Terms::Matrix, typename Terms::Handles;

    SampledEnergy(const Pinned<C>& figure, const Places<D>& targets)
        : Terms(figure.size(), figure.options.pin_weight,
                {figure.solver.samples().rest_handles.begin(), figure.solver.samples().rest_handles.end()},
                figure.solver.samples().cluster_count) {
        const auto& samples = figure.solver.samples();
        const auto axes = bind_jacobians(figure.coordinates, samples.points);
        REQUIRE(axes);
        const std::size_t handles = samples.handle_count();
        for (std::size_t s = 0; s < samples.points.size(); ++s) {
            auto sample = Terms::term(Matrix::Identity(), 1 / double(samples.points.size()));
            for (std::size_t i = 0; i < handles; ++i) {
                for (std::size_t k = 0; k < D; ++k)
                    sample.slope(Eigen::Index(i), Eigen::Index(k)) = axes.value[k].weight(s, i);
            }
            Terms::add(samples.clusters[s], sample);
        }
        add_spokes(figure);
        for (std::size_t n = 0; n < targets.size(); ++n) {
            typename Terms::Pin pin{Eigen::VectorXd::Zero(Eigen::Index(handles)), {}};
            for (std::size_t i = 0; i < handles; ++i) pin.row(Eigen::Index(i)) = figure.binding.weight(n, i);
            for (std::size_t k = 0; k < D; ++k)
                pin.offset(Eigen::Index(k)) = targets[n][k] - figure.pins[n][k];
            Terms::add(pin);
        }
    }

    /// The tie of a handle to its cluster: weight |(h − the cluster's centre, for points) / length − R u|².
    struct Spoke {
        std::size_t handle, cluster;
        bool is_point;
        double length, weight;
        Vec<double, D> direction; ///< u
    };
    const std::vector<Spoke>& spokes() const { return spokes_; }

private:
    void add_spokes(const Pinned<C>& figure) {
        const auto& samples = figure.solver.samples();
        const auto handles = handle_view(figure.coordinates);
        const double spokes = figure.sampling.spokes >= 0  ? figure.sampling.spokes
                              : handles.vector_count() > 0 ? 1e-2
                                                           : 1e-3;
        const auto away = [](const Vec<double, D>& a, const Vec<double, D>& b) { return dot(a - b, a - b); };
        Places<D> centres;
        for (const std::uint32_t centre : samples.centres) centres.push_back(samples.points[centre]);
        const auto at = bound(figure.coordinates, centres);
        std::size_t vectors = 0;
        for (std::size_t i = 0; i < handles.count; ++i) {
            auto place = handles.rest[i], direction = handles.rest[i];
            const bool is_point = handles.is_point(i);
            if (!is_point) {
                place = {};
                for (const auto corner : handles.faces[vectors])
                    place = place + (1.0 / D) * handles.rest[corner];
                ++vectors;
            }
            std::size_t c = 0;
            for (std::size_t n = 1; n < centres.size(); ++n) { // roundings decide no tie
                if (away(centres[n], place) < (1 - 1e-9) * away(centres[c], place)) c = n;
            }
            if (is_point) direction = direction - centres[c];
            const double length = std::sqrt(dot(direction, direction));
            auto spoke = Terms::term(Matrix::Zero(), spokes / double(handles.count));
            for (std::size_t h = 0; is_point && h < handles.count; ++h)
                spoke.slope(Eigen::Index(h), 0) = -at.weight(c, h) / length;
            spoke.slope(Eigen::Index(i), 0) += 1 / length;
            for (std::size_t k = 0; k < D; ++k) spoke.rest(Eigen::Index(k), 0) = direction[k] / length;
            Terms::add(c, spoke);
            spokes_.push_back({i, c, is_point, length, spoke.weight, (1 / length) * direction});
        }
    }

    std::vector<Spoke> spokes_;
};

} // namespace cageform_tests
