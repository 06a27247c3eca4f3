#include "bound_hand.hpp"

#include "pictures/surface_nets.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/clone/clone_rational.hpp>

namespace cageform_sources {

using namespace cageform_support;

BoundHand::BoundHand(const char* type)
    : hand(make_hand(hand_cell)) {
    auto bound = bind_to_sites<double>(type, hand.sites(), hand.skin.vertices);
    report = std::move(bound.report);
    if (report.status != cageform::Status::ok) return;
    dense = std::move(bound.value);
    packed = cageform::pack(dense, {.threshold = 1e-30}).value;
}

std::vector<Point3> BoundHand::clone(const std::vector<Point3>& pose,
                                     const std::vector<double>& weights) const {
    std::vector<Point3> out(hand.skin.vertices.size());
    if (cageform::clone_rational(packed, pose, weights, out) != cageform::Status::ok) out.clear();
    return out;
}

ImplicitMesh cage_of(const Hand& hand) {
    for (const double beside : {0.008, 0.012, 0.016}) { // coarse surface nets are not always manifold
        const auto cage = surface_nets([&](const Point3& p) { return skin_function(hand, p) - beside; },
                                       {-0.7, -0.4, -0.4}, {0.56, 1.2, 0.3}, 0.03);
        const cageform::TriangleMesh<double> checked(cage.vertices, cage.faces);
        if (cageform::check(checked).status == cageform::Status::ok) return cage;
    }
    throw std::runtime_error("no cage of the hand is a manifold");
}

} // namespace cageform_sources
