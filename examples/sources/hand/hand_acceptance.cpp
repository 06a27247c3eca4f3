#include "hand_acceptance.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone_rational.hpp>

#include <algorithm>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numbers>

namespace cageform_sources {

using namespace cageform_support;

namespace {

using Face = std::array<std::uint32_t, 3>;
constexpr double eps = cageform::epsilon<double>;

/// Prints lines, and counts them.
class Lines {
public:
    /// Sets the subject of the next lines.
    void set_subject(std::string subject) { subject_ = std::move(subject); }

    [[gnu::format(printf, 3, 4)]] void line(bool good, const char* format, ...) {
        std::printf("%-7s%s", good ? "ok" : "missed", subject_.c_str());
        std::va_list values;
        va_start(values, format);
        std::vprintf(format, values);
        va_end(values);
        std::printf("\n");
        ++count_.lines;
        if (!good) ++count_.missed;
    }
    AcceptanceCount count() const { return count_; }

private:
    std::string subject_;
    AcceptanceCount count_;
};

double most_of(const Hand& hand, std::size_t joint) {
    return hand_angle_ranges[hand.joints[joint].bend].most;
}

/// One bent joint, within its limits.
HandPose bent(const Hand& hand, std::size_t joint, double degrees) {
    HandPose pose{};
    pose[hand.joints[joint].bend] = std::min(degrees, most_of(hand, joint));
    return pose;
}

/// Joints of the phalanges of a finger, and all of the thumb.
std::vector<std::size_t> phalanges(const Hand& hand, std::size_t ray) {
    return {hand.rays[ray].begin() + (ray == 4 ? 0 : 1), hand.rays[ray].end()};
}

bool contains(const std::vector<std::size_t>& all, std::size_t x) {
    return std::find(all.begin(), all.end(), x) != all.end();
}

std::vector<HandPose> all_poses(const BoundHand& bound) {
    std::vector<HandPose> poses;
    for (const NamedHandPose& pose : hand_poses()) {
        poses.push_back(pose.angles);
        poses.push_back(bound.closed(pose));
    }
    return poses;
}

bool same_bits(const std::vector<Point3>& a, const std::vector<Point3>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}

Point3 turned_about_wrist(const Point3& p) {
    return {p[0], 0.8 * p[1] - 0.6 * p[2], 0.6 * p[1] + 0.8 * p[2]};
}

// 1.
void print_rest(const BoundHand& bound, Lines& lines) {
    const auto& rest = bound.hand.skin.vertices;
    lines.line(same_bits(bound.clone(HandPose{}, 0), rest) && same_bits(bound.clone(HandPose{}), rest),
               "1. the rest pose gives the bound points bit for bit, without inflation and with it");
    auto sites = bound.hand.sites();
    for (Point3& p : sites) p = turned_about_wrist(p);
    const auto turned = bound.clone(sites, std::vector<double>(sites.size(), 1));
    double error = 0;
    for (std::size_t i = 0; i < rest.size(); ++i)
        error = std::max(error, length(turned[i] - turned_about_wrist(rest[i])));
    lines.line(error <= 16 * eps, "1. the hand rotated about the wrist: exact within %.1f eps (16)",
               error / eps);
}

/// 1., without the sites around the hand.
void print_without_surround(const BoundHand& bound, Lines& lines) {
    std::vector<Point3> sites;
    for (const HandPoint& point : bound.hand.points) {
        if (point.kind != HandPointKind::surround) sites.push_back(point.place);
    }
    const auto& skin = bound.hand.skin.vertices;
    const auto alone = bind_to_sites<double>("sibson", sites, skin);
    std::vector<Point3> out(skin.size());
    for (Point3& p : sites) p = turned_about_wrist(p);
    const bool cloned = cageform::clone(alone.value, sites, out) == cageform::Status::ok;
    double error = 0;
    std::size_t within = 0;
    for (std::size_t i = 0; i < skin.size(); ++i) {
        if (contains(alone.report.outside, i)) continue;
        ++within;
        error = std::max(error, length(out[i] - turned_about_wrist(skin[i])));
    }
    lines.line(
        cloned && within > 0 && error <= 16 * eps,
        "1. the same without `surround`: exact within %.1f eps (16), for the %zu of %zu vertices in the "
        "hull of the other sites",
        error / eps, within, skin.size());
}

// 2., and the end of 4.
void print_constraints(const BoundHand& bound, const std::vector<HandPose>& poses, Lines& lines) {
    double error = 0;
    std::size_t bad = 0;
    for (const HandPose& pose : poses) {
        const auto sites = bound.hand.pose(pose);
        const auto skin = bound.clone(pose);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const std::size_t vertex = bound.hand.points[i].vertex;
            if (vertex != HandJoint::none) error = std::max(error, length(skin[vertex] - sites[i]));
        }
        for (const Point3& p : skin) bad += cageform::is_finite(p) ? 0 : 1;
    }
    lines.line(error <= 4 * eps, "2. constraint vertices follow their control points within %.1f eps (4)",
               error / eps);
    lines.line(bad == 0, "4. vertices that are NaN or infinite in any pose: %zu (0)", bad);
}

/// The position along a bone, from the joint at which it begins.
double beyond(const Hand& hand, std::size_t joint, const Point3& p) {
    const HandJoint& j = hand.joints[joint];
    return dot(p - j.place, j.end - j.place) / length(j.end - j.place);
}

// 3.
void print_locality(const BoundHand& bound, Lines& lines) {
    const Hand& hand = bound.hand;
    const auto& rest = hand.skin.vertices;
    double worst = 0, past_web = 0, wrist = 0;
    for (std::size_t ray = 0; ray < 4; ++ray) {
        for (const std::size_t joint : phalanges(hand, ray)) {
            const auto skin = bound.clone(bent(hand, joint, 90));
            for (std::size_t i = 0; i < skin.size(); ++i) {
                const double moved = length(skin[i] - rest[i]);
                if (rest[i][1] < -0.04) wrist = std::max(wrist, moved);
                for (std::size_t other = 0; other < 5; ++other) {
                    const auto bones = phalanges(hand, other);
                    if (other == ray || !contains(bones, hand.vertex_joint[i])) continue;
                    const double along = beyond(hand, bones[0], rest[i]);
                    if (along > 0) worst = std::max(worst, moved);
                    if (along > 1.5 * hand.joints[bones[0]].radius) past_web = std::max(past_web, moved);
                }
            }
        }
    }
    lines.line(worst <= 0.01,
               "3. a finger bent by 90 degrees moves the others beyond their MCP joints by %.2f %% of the "
               "hand's length (1), beyond the webs by %.2f %%",
               100 * worst, 100 * past_web);
    lines.line(wrist <= eps, "3. it moves vertices at the wrist by %.1f eps (1: rounding)", wrist / eps);
}

struct Flipped {
    std::size_t count = 0;
    double farthest = 0; ///< from the plane of the joint, in radii of the finger
};

Flipped worse(const Flipped& a, const Flipped& b) {
    return {std::max(a.count, b.count), std::max(a.farthest, b.farthest)};
}

/// Counts triangles whose normals deviate by more than 90 degrees from the rotation of their bone. A triangle
/// over a joint, with corners on two bones, may follow either.
Flipped flipped(const BoundHand& bound, std::size_t joint, double degrees) {
    const Hand& hand = bound.hand;
    const HandPose angles = bent(hand, joint, degrees);
    const auto skin = bound.clone(angles);
    const auto bones = hand.bones(angles);
    const auto& rest = hand.skin.vertices;
    Flipped found;
    for (const auto& [a, b, c] : hand.skin.faces) {
        const Point3 before = cross(rest[b] - rest[a], rest[c] - rest[a]);
        const Point3 after = cross(skin[b] - skin[a], skin[c] - skin[a]);
        const auto turned_over = [&](std::uint32_t vertex) {
            const auto& rows = bones[hand.vertex_joint[vertex]].rows;
            return dot(after, Point3{dot(rows[0], before), dot(rows[1], before), dot(rows[2], before)}) < 0;
        };
        if (!(turned_over(a) && turned_over(b) && turned_over(c))) continue;
        const Point3 middle = (1.0 / 3) * (rest[a] + rest[b] + rest[c]);
        const double away = std::fabs(beyond(hand, joint, middle)) / hand.joints[joint].radius;
        found = {found.count + 1, std::max(found.farthest, away)};
    }
    return found;
}

// 4.
void print_surface(const BoundHand& bound, Lines& lines) {
    const Hand& hand = bound.hand;
    Flipped at_60, at_90, thumb;
    for (std::size_t ray = 0; ray < 5; ++ray) {
        for (const std::size_t joint : phalanges(hand, ray)) {
            if (most_of(hand, joint) >= 60) {
                at_60 = worse(at_60, flipped(bound, joint, 60));
                at_90 = worse(at_90, flipped(bound, joint, 90));
            } else {
                thumb = worse(thumb, flipped(bound, joint, 60));
            }
        }
    }
    const double share = 100.0 * double(at_90.count) / double(hand.skin.faces.size());
    lines.line(at_60.count == 0, "4. triangles that a joint at 60 degrees turns over: %zu (0)", at_60.count);
    lines.line(share <= 0.5, "4. the same at 90 degrees or at the joint's limit: %zu, %.2f %% (0.5)",
               at_90.count, share);
    lines.line(at_90.farthest <= 1, "4. the farthest of these from the joint: %.2f radii of the finger (1)",
               at_90.farthest);
    lines.line(thumb.count == 0,
               "4. the same for the thumb's first two joints at their limits below 60 degrees: %zu (0)",
               thumb.count);
}

double volume(const std::vector<Point3>& p, const std::vector<Face>& faces) {
    double sum = 0;
    for (const auto& [a, b, c] : faces) sum += dot(p[a], cross(p[b], p[c])) / 6;
    return sum;
}

/// The skin of a finger beyond its first joint.
std::vector<Face> faces_of_finger(const Hand& hand, std::size_t ray) {
    const auto bones = phalanges(hand, ray);
    const auto of_finger = [&](std::uint32_t i) {
        return contains(bones, hand.vertex_joint[i]) && beyond(hand, bones[0], hand.skin.vertices[i]) > 0;
    };
    std::vector<Face> finger;
    for (const Face& face : hand.skin.faces) {
        if (std::all_of(face.begin(), face.end(), of_finger)) finger.push_back(face);
    }
    return finger;
}

// 5. A cone from the first joint, which is fixed, closes the volume of a finger.
void print_volume(const BoundHand& bound, Lines& lines) {
    const Hand& hand = bound.hand;
    const std::vector<double> ones(hand.points.size(), 1);
    struct Worst {
        double half = 0, whole = 0, skin = 0; ///< changes in percent of the finger
    };
    Worst base, others;
    for (std::size_t ray = 0; ray < 4; ++ray) {
        const auto finger = faces_of_finger(hand, ray);
        const auto bones = phalanges(hand, ray);
        const auto held = [&](std::vector<Point3> skin, const std::vector<Face>& faces) {
            for (Point3& p : skin) p = p - hand.joints[bones[0]].place;
            return volume(skin, faces);
        };
        const auto& rest = hand.skin.vertices;
        const double of_finger = held(rest, finger), of_skin = held(rest, hand.skin.faces);
        for (const std::size_t joint : bones) {
            const HandPose angles = bent(hand, joint, 90);
            const auto half = bound.clone(hand.pose(angles), ones),
                       whole = bound.clone(hand.pose(angles, false), ones);
            Worst& worst = joint == bones[0] ? base : others;
            const auto take = [&](double& most, double change) {
                change *= 100 / of_finger;
                if (std::fabs(change) > std::fabs(most)) most = change;
            };
            take(worst.half, held(half, finger) - of_finger);
            take(worst.whole, held(whole, finger) - of_finger);
            take(worst.skin, held(half, hand.skin.faces) - of_skin);
        }
    }
    for (const auto& [worst, joints] : {std::pair{others, "PIP or DIP"}, {base, "MCP"}}) {
        lines.line(std::fabs(worst.half) <= 10,
                   "5. change of a finger's volume, %s at 90 degrees: %+.1f %% with half-turned rings (10), "
                   "%+.1f %% without. Of the whole hand: %+.1f %% of a finger's volume",
                   joints, worst.half, worst.whole, worst.skin);
    }
}

/// The centre of a pad: the vertex nearest to the bone's inflation point, except constraint vertices.
std::size_t pad_of(const Hand& hand, std::size_t joint) {
    const auto inflation = std::find_if(hand.points.begin(), hand.points.end(), [&](const HandPoint& p) {
        return p.kind == HandPointKind::inflation && p.joint == joint;
    });
    std::size_t best = 0;
    double least = 1e9;
    for (std::size_t i = 0; i < hand.skin.vertices.size(); ++i) {
        const double distance = length(hand.skin.vertices[i] - inflation->place);
        const auto is_vertex = [&](const HandPoint& p) { return p.vertex == i; };
        if (distance >= least || std::any_of(hand.points.begin(), hand.points.end(), is_vertex)) continue;
        least = distance;
        best = i;
    }
    return best;
}

/// Whether the volume of the skin increases with kappa and with the angle.
bool pad_grows(const BoundHand& bound, std::size_t joint) {
    const auto held = [&](double share, double kappa) {
        const HandPose pose = bent(bound.hand, joint, share * most_of(bound.hand, joint));
        return volume(bound.clone(pose, kappa), bound.hand.skin.faces);
    };
    const double none = held(1, 0), all = held(1, hand_kappa) - none;
    const std::array by_kappa{0.0, held(1, 1) - none, all, held(1, 2 * hand_kappa) - none};
    const std::array by_angle{0.0, held(0.3, hand_kappa) - held(0.3, 0), held(0.6, hand_kappa) - held(0.6, 0),
                              all};
    const auto grows = [](const std::array<double, 4>& values) {
        return std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end();
    };
    return grows(by_kappa) && grows(by_angle);
}

// 5.
void print_inflation(const BoundHand& bound, Lines& lines) {
    const Hand& hand = bound.hand;
    std::size_t pads = 0, grow = 0;
    double least_swell = 1, past_line = 0;
    for (std::size_t ray = 0; ray < 5; ++ray) {
        const auto bones = phalanges(hand, ray);
        for (std::size_t k = 0; k < bones.size(); ++k) {
            ++pads;
            if (pad_grows(bound, bones[k])) ++grow;
            const HandPose pose = bent(hand, bones[k], 90);
            const auto on = bound.clone(pose), off = bound.clone(pose, 0);
            const std::size_t pad = pad_of(hand, bones[k]);
            const double swell = length(on[pad] - off[pad]);
            least_swell = std::min(least_swell, swell);
            const std::vector<std::size_t> next(bones.begin() + std::ptrdiff_t(k) + 1, bones.end());
            for (std::size_t i = 0; i < on.size(); ++i) {
                if (contains(next, hand.vertex_joint[i]) && beyond(hand, next[0], hand.skin.vertices[i]) > 0)
                    past_line = std::max(past_line, length(on[i] - off[i]) / swell);
            }
        }
    }
    lines.line(grow == pads, "5. pads that gain volume with kappa and with the angle: %zu (%zu)", grow, pads);
    lines.line(past_line <= 0.1,
               "5. beyond the next joint the skin swells by at most %.1f %% of the pad's centre (10). The "
               "centre swells by at least %.2f %% of the hand's length",
               100 * past_line, 100 * least_swell);
}

/// A ring's bisecting plane: through its joint, between the bone before it and its own.
struct Bisector {
    Point3 place, normal;

    Bisector(const Hand& hand, std::size_t joint, const std::vector<RigidMotion3>& bones) {
        const std::size_t before = hand.joints[joint].parent;
        const auto direction = [&](std::size_t k) {
            const Point3 d = bones[k](hand.joints[k].end) - bones[k](hand.joints[k].place);
            return (1 / length(d)) * d;
        };
        place = bones[before](hand.joints[before].end);
        const Point3 sum = direction(before) + direction(joint);
        normal = (1 / length(sum)) * sum;
    }
    double height(const Point3& p) const { return dot(p - place, normal); }
};

// 6.
void print_rings(const BoundHand& bound, const std::vector<HandPose>& poses, Lines& lines) {
    const Hand& hand = bound.hand;
    const auto rest = hand.sites();
    const auto rest_bones = hand.bones(HandPose{});
    double off_at_rest = 0, change = 0;
    for (const HandPose& pose : poses) {
        const auto sites = hand.pose(pose);
        const auto bones = hand.bones(pose);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const HandPoint& point = hand.points[i];
            if (point.kind != HandPointKind::ring) continue;
            const double before = Bisector(hand, point.joint, rest_bones).height(rest[i]);
            const double after = Bisector(hand, point.joint, bones).height(sites[i]);
            off_at_rest = std::max(off_at_rest, std::fabs(before));
            change = std::max(change, std::fabs(after - before));
        }
    }
    lines.line(change <= 16 * eps,
               "6. distances of rings from their bisecting planes change by at most %.1f eps (16), all poses",
               change / eps);
    lines.line(off_at_rest <= 16 * eps, "6. rings lie in their bisecting planes within %.1e (%.1e)",
               off_at_rest, 16 * eps);
}

/// The rotation of a point about an axis, in degrees.
double angle_about(const Point3& place, const Point3& axis, const Point3& from, const Point3& to) {
    const auto flat = [&](const Point3& p) { return p - place - dot(p - place, axis) * axis; };
    const Point3 a = flat(from), b = flat(to);
    return std::atan2(dot(axis, cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

// 6.
void print_shared(const BoundHand& bound, Lines& lines) {
    const Hand& hand = bound.hand;
    const auto rest = hand.sites();
    double worst = 0;
    std::size_t shared = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        const HandPoint& point = hand.points[i];
        if (point.other == HandJoint::none) continue;
        ++shared;
        const HandJoint &a = hand.joints[point.joint], &b = hand.joints[point.other];
        const Point3 sum = a.bend_axis + b.bend_axis, axis = (1 / length(sum)) * sum;
        for (const auto& [x, y] : {std::pair{1.0, 0.0}, {0.0, 1.0}, {0.3, 0.9}, {1.0, 1.0}}) {
            HandPose pose{};
            double mean = 0;
            for (const auto& [joint, share] : {std::pair{&a, x}, {&b, y}}) {
                if (joint->bend == HandJoint::none) continue;
                pose[joint->bend] = share * hand_angle_ranges[joint->bend].most;
                mean += pose[joint->bend] / 2;
            }
            const Point3 p = hand.pose(pose)[i];
            const double turned = angle_about(0.5 * (a.place + b.place), axis, rest[i], p);
            worst = std::max(worst, std::fabs(turned - point.part * mean));
            worst = std::max(worst, std::fabs(dot(p - rest[i], axis)));
        }
    }
    lines.line(shared > 0 && worst <= 1e-12,
               "6. the %zu shared points turn by the mean of both angles about the mean axis within %.1e "
               "degrees (1e-12)",
               shared, worst);
}

/// The control points of the line at the fingers' bases, in order around the hand; without those in the webs.
std::vector<std::size_t> base_line(const Hand& hand) {
    std::vector<std::pair<double, std::size_t>> found;
    Point3 middle{};
    for (std::size_t ray = 0; ray < 4; ++ray) middle = middle + 0.25 * hand.joints[hand.rays[ray][1]].place;
    for (std::size_t i = 0; i < hand.points.size(); ++i) {
        const HandPoint& point = hand.points[i];
        if (point.kind != HandPointKind::base) continue;
        const Point3 d = point.place - middle;
        const bool in_web =
            point.other != HandJoint::none && std::fabs(d[2]) < 0.5 * hand.joints[point.joint].radius;
        if (!in_web) found.emplace_back(std::atan2(d[2], -d[0]), i);
    }
    std::sort(found.begin(), found.end());
    std::vector<std::size_t> loop;
    for (const auto& [angle, i] : found) loop.push_back(i);
    return loop;
}

// 6.
void print_base_line(const BoundHand& bound, const std::vector<HandPose>& poses, Lines& lines) {
    const Hand& hand = bound.hand;
    const auto loop = base_line(hand);
    const auto next = [&](std::size_t n) { return loop[(n + 1) % loop.size()]; };
    // Neighbouring points that belong to a common finger leave no gap in any pose.
    const auto share_a_finger = [&](const HandPoint& a, const HandPoint& b) {
        const auto has = [&](std::size_t joint) {
            return joint != HandJoint::none && (b.joint == joint || b.other == joint);
        };
        return has(a.joint) || has(a.other);
    };
    std::size_t gaps = 0;
    const auto rest = hand.sites();
    double longest_rest = 0, longest = 0, off_skin = 0;
    for (std::size_t n = 0; n < loop.size(); ++n) {
        if (!share_a_finger(hand.points[loop[n]], hand.points[next(n)])) ++gaps;
        longest_rest = std::max(longest_rest, length(rest[loop[n]] - rest[next(n)]));
    }
    for (const HandPose& pose : poses) {
        const auto sites = hand.pose(pose);
        const auto skin = bound.clone(pose);
        for (std::size_t n = 0; n < loop.size(); ++n) {
            longest = std::max(longest, length(sites[loop[n]] - sites[next(n)]));
            off_skin = std::max(off_skin, length(skin[hand.points[loop[n]].vertex] - sites[loop[n]]));
        }
    }
    lines.line(loop.size() >= 20 && gaps == 0 && off_skin <= 4 * eps,
               "6. the line at the fingers' bases: %zu points, %zu gaps (0), on the skin in all poses within "
               "%.1f eps (4). Longest step %.3f at rest, %.3f in a pose",
               loop.size(), gaps, off_skin / eps, longest_rest, longest);
}

void print_laws(const BoundHand& bound, Lines& lines) {
    const auto poses = all_poses(bound);
    print_rest(bound, lines);
    print_constraints(bound, poses, lines);
    print_locality(bound, lines);
    print_surface(bound, lines);
    print_volume(bound, lines);
    print_inflation(bound, lines);
    print_rings(bound, poses, lines);
    print_shared(bound, lines);
    print_base_line(bound, poses, lines);
}

// 7.
void print_builds(const BoundHand& bound, const HandBuilder& builder, Lines& lines) {
    lines.line(builder.skin.report.still.empty(),
               "7. skin and control points are bound to %zu handles by one composed binding; %zu never move "
               "(0)",
               builder.rest.size(), builder.skin.report.still.size());
    for (const HandBuild& build : hand_builds(bound.hand, builder)) {
        lines.set_subject(std::string("7. ") + build.name + ": ");
        BoundHand other = bound;
        other.hand = builder.built(bound.hand, build.handles);
        auto& skin = other.hand.skin.vertices;
        skin = bound.clone(other.hand.sites(), std::vector<double>(bound.hand.points.size(), 1));
        std::vector<Point3> composed(skin.size());
        const auto status = cageform::clone(builder.skin.value, build.handles, composed);
        double error = 0;
        for (std::size_t i = 0; i < skin.size(); ++i) error = std::max(error, length(skin[i] - composed[i]));
        lines.line(status == cageform::Status::ok && error <= 16 * eps,
                   "the composed binding equals both bindings in sequence within %.1f eps (16)", error / eps);
        print_laws(other, lines);
    }
    lines.set_subject({});
}

// 8.
void print_report(const BoundHand& bound, Lines& lines) {
    const auto& report = bound.report;
    lines.line(report.outside.empty() && report.unreached.empty() && report.not_finite.empty() &&
                   report.not_restored.empty() && report.cage.faults.empty(),
               "8. vertices outside %zu, unreached %zu, not finite %zu, not restored %zu; faults of the "
               "control points, including duplicates, %zu (all 0)",
               report.outside.size(), report.unreached.size(), report.not_finite.size(),
               report.not_restored.size(), report.cage.faults.size());
    const BoundHand smooth("sibson-c1");
    lines.line(smooth.report.status == cageform::Status::ok, "8. amplification at degree 3: %.2f",
               smooth.report.amplification.value);
}

/// The least time of many runs, in microseconds.
template <class Work>
double fastest(const Work& work) {
    double best = 1e9;
    for (int k = 0; k < 300; ++k) {
        const auto start = std::chrono::steady_clock::now();
        work();
        const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
        best = std::min(best, time.count());
    }
    return best;
}

/// 9. The configuration of a game: float, without zero weights, vertices in the order of the binding.
/// bench_clone measures reading the weights alone.
void print_time(const Hand& hand, Lines& lines) {
    const auto bound = bind_to_sites<float>("sibson", hand.sites(), hand.skin.vertices);
    const auto packed = cageform::pack(bound.value, {.threshold = 1e-30}).value;
    const auto view = packed.view().in_order();
    const auto fit = cageform::rational_view(view);
    const auto& angles = hand_poses()[1].angles;
    std::vector<cageform::Vec<float, 3>> pose, out(hand.skin.vertices.size());
    std::vector<float> weights;
    for (const Point3& p : hand.pose(angles)) pose.push_back(cageform::vec_cast<float>(p));
    for (const double w : hand.weights(angles, hand_kappa)) weights.push_back(float(w));
    auto status = fit.status();
    const double clone = fastest([&] {
        if (status == cageform::Status::ok) status = cageform::clone_rational(fit.value, pose, weights, out);
    });
    lines.line(status == cageform::Status::ok && clone <= 200,
               "9. %zu vertices by %zu control points (5000 by 300): %.0f us a frame on one thread (200)",
               out.size(), pose.size(), clone);
}

} // namespace

AcceptanceCount print_acceptance(const BoundHand& bound, const HandBuilder& builder) {
    Lines lines;
    print_laws(bound, lines);
    print_without_surround(bound, lines);
    print_builds(bound, builder, lines);
    print_report(bound, lines);
    print_time(bound.hand, lines);
    return lines.count();
}

} // namespace cageform_sources
