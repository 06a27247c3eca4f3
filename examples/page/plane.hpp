// A figure in the plane: coordinates of any type, and the points bound to them.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/sibson.hpp>

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace cageform_page {

using cageform::Status;
using Point2 = cageform::Vec<double, 2>;

/// Two batches of points from one solve: the figure's, and the nodes where weights are shown.
constexpr std::size_t batches = 2;

/// A cage and the points bound to it.
class Plane {
public:
    virtual ~Plane() = default;
    Plane() = default;
    Plane(const Plane&) = delete;
    Plane& operator=(const Plane&) = delete;

    virtual Status solve() = 0;
    virtual cageform::BindReport bind(std::size_t batch, std::span<const Point2> points) = 0;

    // The parts of the concept GradientCoordinates, for solved coordinates.
    virtual cageform::HandleView<double, 2> handles() const = 0;
    virtual const cageform::CageReport& cage_report() const = 0;
    virtual cageform::Evaluation evaluate(cageform::BlockView<const double> points,
                                          cageform::BlockView<double> weights,
                                          std::span<cageform::PointState> states,
                                          const cageform::Running& running, bool gradients) const = 0;
    virtual Point2 nearest_boundary(const Point2& p, std::span<double> row) const = 0;

    /// Moves a batch by a pose of all points but the still ones.
    Status clone(std::size_t batch, std::span<const Point2> pose) {
        const auto& binding = bindings[batch];
        const auto all = binding.handle_view();
        pose_.assign(pose.begin(), pose.end());
        for (std::size_t i = all.count - still_handles; i < all.count; ++i) pose_.push_back(all.rest[i]);
        handles_.resize(binding.handle_count());
        places_.resize(binding.point_count());
        const auto posed = pose_handles(binding, pose_, handles_);
        return posed.status == Status::ok ? cageform::clone(binding, handles_, places_) : posed.status;
    }
    const Point2* places() const { return places_.data(); }

    std::array<cageform::Binding<double, 2>, batches> bindings;
    std::size_t still_handles = 0; // the last ones, which poses leave at rest

private:
    std::vector<Point2> pose_, handles_, places_;
};

template <cageform::GradientCoordinates C>
class PlaneOf : public Plane {
public:
    explicit PlaneOf(C coordinates)
        : coordinates_(std::move(coordinates)) {}

    Status solve() override {
        const Status status = coordinates_.cage_report().status;
        if constexpr (requires { coordinates_.solve(); })
            return status == Status::ok ? coordinates_.solve().status : status;
        else
            return status;
    }
    cageform::BindReport bind(std::size_t batch, std::span<const Point2> points) override {
        cageform::BindOptions options;
        if (!C::has_extension) // the default of the programs
            options.outside = is_sites && batch == 0 ? cageform::OutsidePoints::keep_in_place
                                                     : cageform::OutsidePoints::nearest_boundary;
        auto [binding, report] = cageform::bind(coordinates_, points, options);
        bindings[batch] = std::move(binding);
        return report;
    }

    cageform::HandleView<double, 2> handles() const override { return handle_view(coordinates_); }
    const cageform::CageReport& cage_report() const override { return coordinates_.cage_report(); }
    cageform::Evaluation evaluate(cageform::BlockView<const double> points,
                                  cageform::BlockView<double> weights, std::span<cageform::PointState> states,
                                  const cageform::Running& running, bool gradients) const override {
        return gradients ? coordinates_.evaluate_gradients(points, weights, states, running)
                         : coordinates_.evaluate(points, weights, states, running);
    }
    Point2 nearest_boundary(const Point2& p, std::span<double> row) const override {
        return coordinates_.nearest_boundary(p, row);
    }

private:
    static constexpr bool is_sites = std::is_same_v<C, cageform::SibsonCoordinates<double, 2>>;
    C coordinates_;
};

/// Solved coordinates of any type behind one type, so that what samples and binds pins is compiled once.
/// Pins are inside of the cage, so there is no extension.
class PlaneCoordinates {
public:
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = true; // solved: a few points at a time

    explicit PlaneCoordinates(const Plane& plane)
        : plane_(plane)
        , view_(plane.handles()) {}

    std::span<const Point2> handles() const { return {view_.rest, view_.count}; }
    std::span<const cageform::HandleKind> handle_kinds() const {
        return {view_.kinds, view_.kinds == nullptr ? 0 : view_.count};
    }
    std::span<const cageform::HandleFace<2>> handle_faces() const {
        return {view_.faces, view_.faces == nullptr ? 0 : view_.vector_count()};
    }
    std::span<const std::uint32_t> handle_loops() const { return {view_.loops, view_.loop_numbers()}; }
    const cageform::CageReport& cage_report() const { return plane_.cage_report(); }
    cageform::Evaluation evaluate(cageform::BlockView<const double> points,
                                  cageform::BlockView<double> weights, std::span<cageform::PointState> states,
                                  const cageform::Running& running) const {
        return plane_.evaluate(points, weights, states, running, false);
    }
    cageform::Evaluation evaluate_gradients(cageform::BlockView<const double> points,
                                            cageform::BlockView<double> gradients,
                                            std::span<cageform::PointState> states,
                                            const cageform::Running& running) const {
        return plane_.evaluate(points, gradients, states, running, true);
    }
    Point2 nearest_boundary(const Point2& p, std::span<double> row) const {
        return plane_.nearest_boundary(p, row);
    }

private:
    const Plane& plane_;
    cageform::HandleView<double, 2> view_;
};

} // namespace cageform_page
