#pragma once

// Hands of other proportions by the same binding: a few handles move the control points and the skin of a
// hand at rest.

#include "bound_hand.hpp"

#include <cageform/binding/compose.hpp>
#include <cageform/cage/control_points.hpp>
#include <cageform/clone/clone.hpp>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

struct HandBuild {
    const char* name;
    std::vector<Point3> handles; ///< their new positions
};

/// Handles of a build: the joints, the tips, then the corners of a box.
struct HandBuilder {
    std::vector<Point3> rest;
    cageform::Result<cageform::Binding<double, 3>, cageform::ComposeReport> skin;
    cageform::Binding<double, 3> sites;

    explicit HandBuilder(const BoundHand& bound) {
        for (const HandJoint& joint : bound.hand.joints) rest.push_back(joint.place);
        for (const auto& ray : bound.hand.rays) rest.push_back(bound.hand.joints[ray.back()].end);
        // A joint that two bones share is one handle.
        const auto all = bound.hand.sites();
        for (const Point3& p : cageform::surround(all, {.margin = 0.05}).value) rest.push_back(p);
        sites = bind_to_sites<double>("sibson", rest, all).value;
        skin = cageform::compose(bound.dense, sites);
    }

    /// The hand with its joints at the new positions of their handles.
    Hand built(const Hand& hand, const std::vector<Point3>& handles) const {
        Hand other = hand;
        for (std::size_t j = 0; j < other.joints.size(); ++j) other.joints[j].place = handles[j];
        for (std::size_t ray = 0; ray < 5; ++ray) {
            const auto& joints = other.rays[ray];
            for (std::size_t k = 0; k < joints.size(); ++k)
                other.joints[joints[k]].end = k + 1 < joints.size() ? other.joints[joints[k + 1]].place
                                                                    : handles[other.joints.size() + ray];
        }
        // Axes of the phalanges and of the thumb stay at right angles to their bones.
        for (std::size_t j = 0; j < other.joints.size(); ++j) {
            const HandJoint& was = hand.joints[j];
            if (std::fabs(dot(was.bend_axis, was.end - was.place)) > 1e-9) continue;
            HandJoint& joint = other.joints[j];
            const Point3 bone = joint.end - joint.place;
            const Point3 axis = was.bend_axis - (dot(was.bend_axis, bone) / dot(bone, bone)) * bone;
            joint.bend_axis = (1 / length(axis)) * axis;
        }
        std::vector<Point3> places(hand.points.size());
        const auto status = cageform::clone(sites, handles, places);
        if (status != cageform::Status::ok) throw std::runtime_error(cageform::to_string(status));
        for (std::size_t i = 0; i < places.size(); ++i) other.points[i].place = places[i];
        return other;
    }
};

inline std::vector<HandBuild> hand_builds(const Hand& hand, const HandBuilder& builder) {
    std::vector<HandBuild> made{{"a longer middle finger", builder.rest},
                                {"a thumb apart, and larger", builder.rest},
                                {"a thicker hand", builder.rest}};
    const auto& middle = hand.rays[1];
    const Point3 base = hand.joints[middle[1]].place;
    auto& longer = made[0].handles;
    for (const std::size_t k : {middle[2], middle[3], hand.joints.size() + 1})
        longer[k] = base + 1.2 * (longer[k] - base);
    const auto& thumb = hand.rays[4];
    const Point3 root = hand.joints[thumb[0]].place;
    auto& apart = made[1].handles;
    for (const std::size_t k : {thumb[1], thumb[2], hand.joints.size() + 4}) {
        const Point3 d = 1.15 * (apart[k] - root);
        const double c = std::cos(0.2), s = std::sin(0.2);
        apart[k] = root + Point3{c * d[0] - s * d[1], s * d[0] + c * d[1], d[2]};
    }
    for (Point3& p : made[2].handles) p[2] *= 1.3;
    return made;
}

} // namespace cageform_sources
