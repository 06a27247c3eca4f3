#pragma once

// A hand bound to its control points, and how the programs move it.

#include "cli/coordinates.hpp"
#include "hand_model.hpp"

#include <cageform/figure/packed_binding.hpp>

#include <string_view>

namespace cageform_sources {

using namespace cageform_support;

/// The grid cell for the skin, in hand lengths; gives about 7,000 vertices. Surface nets are not manifold
/// where two sheets share a cell, between fingers or in a crease. So some sizes fail; make_hand checks the
/// mesh.
inline constexpr double hand_cell = 1.0 / 62;
inline constexpr double hand_kappa = 3; ///< the default strength of inflation

/// Binds `places` to `sites`. `type` is a type of --coordinates: sibson, or sibson-c1 for degree 3.
template <class T>
cageform::Result<cageform::Binding<T, 3>, cageform::BindReport>
bind_to_sites(const char* type, std::vector<Point3> sites, const std::vector<Point3>& places) {
    CoordinatesChoice choice;
    choice.name = type;
    SiteFile<3> file;
    file.points = std::move(sites);
    return make_coordinates<T, 3>(choice, file).bind(places);
}

struct BoundHand {
    Hand hand;
    cageform::Binding<double, 3> dense;
    cageform::BindReport report;
    cageform::PackedBinding<double, 3> packed; ///< without zero weights, as a game would store it

    ///   type   of bind_to_sites()
    explicit BoundHand(const char* type = "sibson");

    /// The angles of one of hand_poses(); ball and rod are closed around their object.
    HandPose closed(const NamedHandPose& pose) const {
        if (pose.name == std::string_view("ball")) return grasp(hand, pose.angles, hand_ball());
        if (pose.name == std::string_view("rod")) return grasp(hand, pose.angles, hand_rod());
        return pose.angles;
    }

    /// The skin in a pose of the control points; empty if the clone fails.
    std::vector<Point3> clone(const std::vector<Point3>& pose, const std::vector<double>& weights) const;
    std::vector<Point3> clone(const HandPose& angles, double kappa = hand_kappa) const {
        return clone(hand.pose(angles), hand.weights(angles, kappa));
    }
};

/// A cage of about 2,300 vertices around the hand, so tight that fingers are separate. Throws if no valid
/// cage is found.
ImplicitMesh cage_of(const Hand& hand);

/// Rotates points by 180 degrees about the y axis, to show the palm.
inline std::vector<Point3> turned_over(std::vector<Point3> points) {
    for (Point3& p : points) p = {-p[0], p[1], -p[2]};
    return points;
}

} // namespace cageform_sources
