#pragma once

// A hand bound to its control points, and how the programs move it.

#include "hand_model.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone_rational.hpp>
#include <cageform/coordinates/sibson.hpp>

namespace cageform_examples {

/// Some 7,000 vertices. Surface nets are manifold but where two sheets share a cell, between fingers or in a line: not
/// every size will do, and make_hand checks.
inline constexpr double hand_cell = 1.0 / 62;
inline constexpr double hand_kappa = 3; ///< of inflation

struct BoundHand {
    Hand hand;
    cageform::Binding<double, 3> dense;
    cageform::BindReport report;
    cageform::PackedBinding<double, 3> packed; ///< zeros left out: what a game would ship

    explicit BoundHand(const cageform::SibsonOptions& options = {})
        : hand(make_hand(hand_cell)) {
        auto bound =
            cageform::bind(cageform::SibsonCoordinates<double, 3>(hand.sites(), options), hand.skin.vertices);
        report = std::move(bound.report);
        if (report.status != cageform::Status::ok) return;
        dense = std::move(bound.binding);
        packed = cageform::pack(dense, {.threshold = 1e-30}).binding;
    }

    /// One of hand_poses(), closed about what it grasps.
    HandPose closed(const NamedHandPose& pose) const {
        if (pose.name == std::string_view("ball")) return grasp(hand, pose.angles, hand_ball());
        if (pose.name == std::string_view("rod")) return grasp(hand, pose.angles, hand_rod());
        return pose.angles;
    }

    /// The skin in a pose of the control points; empty where it cannot be had.
    std::vector<Point3> clone(const std::vector<Point3>& pose, const std::vector<double>& weights) const {
        std::vector<Point3> out(hand.skin.vertices.size());
        if (cageform::clone_rational(packed, pose, weights, out) != cageform::Status::ok) out.clear();
        return out;
    }
    std::vector<Point3> clone(const HandPose& angles, double kappa = hand_kappa) const {
        return clone(hand.pose(angles), hand.weights(angles, kappa));
    }
};

/// Seen from the inner side.
inline std::vector<Point3> turned_over(std::vector<Point3> points) {
    for (Point3& p : points) p = {-p[0], p[1], -p[2]};
    return points;
}

} // namespace cageform_examples
