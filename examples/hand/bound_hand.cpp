#include "bound_hand.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone_rational.hpp>

namespace cageform_examples {

BoundHand::BoundHand(const char* type)
    : hand(make_hand(hand_cell)) {
    auto bound = bind_to_sites<double>(type, hand.sites(), hand.skin.vertices);
    report = std::move(bound.report);
    if (report.status != cageform::Status::ok) return;
    dense = std::move(bound.binding);
    packed = cageform::pack(dense, {.threshold = 1e-30}).binding;
}

std::vector<Point3> BoundHand::clone(const std::vector<Point3>& pose,
                                     const std::vector<double>& weights) const {
    std::vector<Point3> out(hand.skin.vertices.size());
    if (cageform::clone_rational(packed, pose, weights, out) != cageform::Status::ok) out.clear();
    return out;
}

} // namespace cageform_examples
