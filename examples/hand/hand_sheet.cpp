// The hand in all its poses, its control points, inflation on and off, three builds of it, and what is measured of them.
//
//     hand_sheet out
//
// writes the pictures that hand_pictures.hpp names, and prints one line a property: MISS where one is not what it should
// be. Two are not: a bent finger moves the web beside it by more than 1 % of the hand's length, and two triangles in the
// fold of a joint at 60 degrees turn over.

#include "atomic_file.hpp"
#include "bound_hand.hpp"
#include "command_line.hpp"
#include "guard.hpp"
#include "hand_pictures.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone_rational.hpp>

#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <numbers>

namespace {

using namespace cageform_examples;
using Face = std::array<std::uint32_t, 3>;

/// Counts what is not as it should be.
class Findings {
public:
    [[gnu::format(printf, 3, 4)]] void line(bool good, const char* format, ...) {
        std::printf(good ? "ok   " : "MISS ");
        std::va_list values;
        va_start(values, format);
        std::vprintf(format, values);
        va_end(values);
        std::printf("\n");
        if (!good) ++misses_;
    }
    int misses() const { return misses_; }

private:
    int misses_ = 0;
};

double volume(const std::vector<Point3>& p, const std::vector<Face>& faces) {
    double sum = 0;
    for (const auto& [a, b, c] : faces) sum += dot(p[a], cross(p[b], p[c])) / 6;
    return sum;
}

bool is_of_ray(const Hand& hand, std::size_t joint, std::size_t ray) {
    const auto& joints = hand.rays[ray];
    return std::find(joints.begin() + (ray == 4 ? 0 : 1), joints.end(), joint) != joints.end();
}

HandPose with(std::initializer_list<std::pair<HandAngle, double>> angles) {
    HandPose pose{};
    for (const auto& [angle, degrees] : angles) pose[std::size_t(angle)] = degrees;
    return pose;
}
HandAngle finger_angle(std::size_t ray, std::size_t which) {
    return HandAngle(4 * ray + which);
}

/// How far vertices of a kind move.
template <class Which>
double farthest(const BoundHand& bound, const std::vector<Point3>& moved, const Which& which) {
    double most = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) {
        if (which(i)) most = std::max(most, length(moved[i] - bound.hand.skin.vertices[i]));
    }
    return most;
}

void judge_rest(const BoundHand& bound, Findings& findings) {
    const auto& rest = bound.hand.skin.vertices;
    const auto at_rest = bound.clone(HandPose{});
    findings.line(std::memcmp(at_rest.data(), rest.data(), rest.size() * sizeof(rest[0])) == 0,
                  "1. the rest pose with inflation gives the bound points, bit for bit");
    auto sites = bound.hand.sites();
    const auto turn = [](const Point3& p) {
        return Point3{0.8 * p[0] - 0.6 * p[2] + 1, p[1] - 2, 0.6 * p[0] + 0.8 * p[2]};
    };
    for (Point3& p : sites) p = turn(p);
    const auto turned = bound.clone(sites, std::vector<double>(sites.size(), 1));
    double error = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) error = std::max(error, length(turned[i] - turn(rest[i])));
    findings.line(error < 1e-14, "1. all control points turned as one: the skin within %.1e", error);
}

void judge_constraints(const BoundHand& bound, Findings& findings) {
    double error = 0;
    bool sound = true;
    for (const NamedHandPose& pose : hand_poses()) {
        const auto sites = bound.hand.pose(pose.angles);
        const auto skin = bound.clone(pose.angles);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const HandPoint& point = bound.hand.points[i];
            if (point.vertex != HandJoint::none)
                error = std::max(error, length(skin[point.vertex] - sites[i]));
        }
        for (const Point3& p : skin) sound = sound && cageform::is_finite(p);
    }
    findings.line(error <= 4 * cageform::epsilon<double>,
                  "2. constraint vertices follow their control points in all poses within %.1f eps",
                  error / cageform::epsilon<double>);
    findings.line(sound, "4. no vertex of any pose is NaN or infinite");
}

void judge_locality(const BoundHand& bound, Findings& findings) {
    const Hand& hand = bound.hand;
    double worst = 0, wrist = 0;
    for (std::size_t ray = 0; ray < 4; ++ray) {
        const auto skin = bound.clone(with({{finger_angle(ray, 1), 90}}));
        for (std::size_t other = 0; other < 5; ++other) {
            if (other == ray) continue;
            worst = std::max(worst, farthest(bound, skin, [&](std::size_t i) {
                                 if (!is_of_ray(hand, hand.vertex_joint[i], other)) return false;
                                 const HandJoint& base = hand.joints[hand.rays[other][other == 4 ? 0 : 1]];
                                 const Point3 along = base.end - base.place;
                                 return dot(hand.skin.vertices[i] - base.place, along) / length(along) > 0;
                             }));
        }
        wrist = std::max(
            wrist, farthest(bound, skin, [&](std::size_t i) { return hand.skin.vertices[i][1] < -0.04; }));
    }
    findings.line(worst <= 0.01,
                  "3. a finger bent by 90 degrees moves others beyond their first joint by %.2f %% of the "
                  "hand's length (1)",
                  100 * worst);
    findings.line(wrist <= 1e-3, "3. and the wrist by %.3f %%", 100 * wrist);
}

/// Triangles whose normals turn past 90 degrees from where their bone turns them.
std::size_t flipped(const BoundHand& bound, const HandPose& angles) {
    const Hand& hand = bound.hand;
    const auto skin = bound.clone(angles);
    const auto bones = hand.bones(angles);
    std::size_t count = 0;
    for (const auto& [a, b, c] : hand.skin.faces) {
        const auto normal = [&](const std::vector<Point3>& p) { return cross(p[b] - p[a], p[c] - p[a]); };
        const Point3 rest = normal(hand.skin.vertices);
        const auto& rows = bones[hand.vertex_joint[a]].rows;
        const Point3 expected{dot(rows[0], rest), dot(rows[1], rest), dot(rows[2], rest)};
        if (dot(normal(skin), expected) < 0) ++count;
    }
    return count;
}

void judge_surface(const BoundHand& bound, Findings& findings) {
    std::size_t at_60 = 0, at_90 = 0;
    for (std::size_t ray = 0; ray < 4; ++ray) {
        for (std::size_t joint = 1; joint < 4; ++joint) {
            at_60 = std::max(at_60, flipped(bound, with({{finger_angle(ray, joint), 60}})));
            at_90 = std::max(at_90, flipped(bound, with({{finger_angle(ray, joint), 90}})));
        }
    }
    const double share = 100.0 * double(at_90) / double(bound.hand.skin.faces.size());
    findings.line(at_60 == 0, "4. triangles turned past 90 degrees by a joint at 60 degrees: %zu (0)", at_60);
    findings.line(share <= 0.5, "4. by a joint at 90 degrees: %zu at most, %.2f %% (0.5)", at_90, share);
}

/// What a finger of rods would hold.
double finger_volume(const Hand& hand, std::size_t ray) {
    double sum = 0;
    for (std::size_t k = 1; k < 4; ++k) {
        const HandJoint& j = hand.joints[hand.rays[ray][k]];
        const double a = j.radius, b = j.end_radius;
        sum += std::numbers::pi / 3 * length(j.end - j.place) * (a * a + a * b + b * b);
    }
    return sum;
}

void judge_volume(const BoundHand& bound, Findings& findings) {
    const Hand& hand = bound.hand;
    const auto angles = with({{HandAngle::middle_pip, 90}});
    const std::vector<double> ones(hand.points.size(), 1);
    const double rest = volume(hand.skin.vertices, hand.skin.faces), finger = finger_volume(hand, 1);
    const auto change = [&](bool half) {
        return 100 * (volume(bound.clone(hand.pose(angles, half), ones), hand.skin.faces) - rest) / finger;
    };
    findings.line(std::fabs(change(true)) <= 10,
                  "5. the middle finger's volume, bent by 90 degrees: %+.1f %% with half-turned rings (10), "
                  "%+.1f %% without",
                  change(true), change(false));
    // The skin under an inflation point, towards the inner side.
    const std::size_t joint = hand.rays[1][2];
    const HandJoint& j = hand.joints[joint];
    const Point3 middle = 0.5 * (j.place + j.end),
                 inner = cross(j.bend_axis, (1 / length(j.end - j.place)) * (j.end - j.place));
    std::size_t pad = 0;
    double most = -1;
    for (std::size_t i = 0; i < hand.skin.vertices.size(); ++i) {
        const Point3 d = hand.skin.vertices[i] - middle;
        const double score = dot(d, inner) - 3 * length(d - dot(d, inner) * inner);
        if (hand.vertex_joint[i] == joint && score > most) {
            most = score;
            pad = i;
        }
    }
    const auto swelling = [&](double degrees, double kappa, std::size_t i) {
        const auto pose = with({{HandAngle::middle_pip, degrees}});
        return length(bound.clone(pose, kappa)[i] - bound.clone(pose, 0)[i]);
    };
    bool monotone = true;
    double before = 0;
    for (const double kappa : {1.0, 2.0, 3.0, 6.0})
        monotone = monotone && swelling(90, kappa, pad) > std::exchange(before, swelling(90, kappa, pad));
    before = 0;
    for (const double degrees : {20.0, 45.0, 70.0, 90.0})
        monotone = monotone && swelling(degrees, 3, pad) > std::exchange(before, swelling(degrees, 3, pad));
    findings.line(monotone && before > 0,
                  "5. the pad swells with the angle and with kappa, to %.2f %% of the hand's length",
                  100 * before);
    const auto on = bound.clone(angles), off = bound.clone(angles, 0);
    double beyond = 0;
    for (std::size_t i = 0; i < on.size(); ++i) {
        if (hand.vertex_joint[i] == hand.rays[1][3]) beyond = std::max(beyond, length(on[i] - off[i]));
    }
    findings.line(beyond <= 0.1 * before, "5. beyond the next line it moves %.1f %% of that (10)",
                  100 * beyond / before);
}

void judge_rings(const Hand& hand, Findings& findings) {
    double error = 0;
    for (const NamedHandPose& pose : hand_poses()) {
        const auto sites = hand.pose(pose.angles), rest = hand.sites();
        for (std::size_t i = 0; i < sites.size(); ++i) { // rings keep their shape: they turn as one
            for (std::size_t k = 0; k < i; ++k) {
                if (hand.points[i].kind != HandPointKind::ring ||
                    hand.points[k].kind != HandPointKind::ring ||
                    hand.points[i].joint != hand.points[k].joint)
                    continue;
                error = std::max(error, std::fabs(length(sites[i] - sites[k]) - length(rest[i] - rest[k])));
            }
        }
    }
    findings.line(error < 1e-15 * 8, "6. rings keep their shape in all poses within %.1e", error);
}

void judge_builds(const BoundHand& bound, const HandBuilder& builder, Findings& findings) {
    findings.line(builder.skin.status == cageform::Status::ok && builder.skin.still.empty(),
                  "7. skin and control points are bound to %zu handles by one composed binding",
                  builder.rest.size());
    if (builder.skin.status != cageform::Status::ok) return;
    double error = 0, constraints = 0;
    for (const HandBuild& build : hand_builds(bound.hand, builder)) {
        const Hand hand = builder.built(bound.hand, build.handles);
        std::vector<Point3> skin(bound.hand.skin.vertices.size());
        if (cageform::clone(builder.skin.binding, build.handles, skin) != cageform::Status::ok) return;
        const auto twice = bound.clone(hand.sites(), std::vector<double>(hand.points.size(), 1));
        for (std::size_t i = 0; i < skin.size(); ++i) error = std::max(error, length(skin[i] - twice[i]));
        for (const NamedHandPose& pose : hand_poses()) {
            const auto sites = hand.pose(pose.angles);
            const auto posed = bound.clone(sites, hand.weights(pose.angles, hand_kappa));
            for (std::size_t i = 0; i < sites.size(); ++i) {
                const std::size_t v = hand.points[i].vertex;
                if (v != HandJoint::none) constraints = std::max(constraints, length(posed[v] - sites[i]));
            }
        }
    }
    findings.line(error <= 1e-14, "7. it moves the skin as both bindings one after the other, within %.1e",
                  error);
    findings.line(constraints <= 8 * cageform::epsilon<double>,
                  "7. the builds' constraint vertices follow in all poses within %.1f eps",
                  constraints / cageform::epsilon<double>);
}

void judge_report(const BoundHand& bound, Findings& findings) {
    const auto& report = bound.report;
    findings.line(report.outside.empty() && report.unreached.empty() && report.not_finite.empty(),
                  "8. no vertex outside, unreached or not finite; %zu control points",
                  bound.hand.points.size());
    const BoundHand smooth("sibson-c1");
    findings.line(smooth.report.status == cageform::Status::ok, "8. amplification at degree 3: %.1f",
                  smooth.report.amplification.value);
}

/// As a game would have it: in float, zeros left out, vertices in the binding's order.
void judge_time(const Hand& hand, Findings& findings) {
    const auto bound = bind_to_sites<float>("sibson", hand.sites(), hand.skin.vertices);
    const auto packed = cageform::pack(bound.binding, {.threshold = 1e-30}).binding;
    const auto fit = cageform::rational_view(packed.view().in_order());
    const auto& angles = hand_poses()[1].angles;
    std::vector<cageform::Vec<float, 3>> pose, out(hand.skin.vertices.size());
    std::vector<float> weights;
    for (const Point3& p : hand.pose(angles)) pose.push_back(cageform::vec_cast<float>(p));
    for (const double w : hand.weights(angles, hand_kappa)) weights.push_back(float(w));
    auto status = fit.status;
    double best = 1e9;
    for (int k = 0; k < 300 && status == cageform::Status::ok; ++k) {
        const auto start = std::chrono::steady_clock::now();
        status = cageform::clone_rational(fit.binding, pose, weights, out);
        const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
        best = std::min(best, time.count());
    }
    findings.line(status == cageform::Status::ok,
                  "9. %zu vertices by %zu control points: %.0f us a frame on one thread", out.size(),
                  pose.size(), best);
}

int fail(const std::string& message) {
    std::cerr << "hand_sheet: " << message << '\n';
    return 1;
}

int run_program(int argc, char** argv) {
    CommandLine line(
        "Draws a hand in all its poses and builds, and measures how its skin follows its control points.");
    std::string folder;
    line.add("folder", folder,
             "where hand_layers.png, hand_points.png, hand_poses.png, hand_bend.png, hand_inflation.png, "
             "hand_builds.png, hand_influence.png and hand_locality.png are written")
        .required();
    if (const auto code = line.parse(argc, argv)) return *code;

    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail("cannot make the folder " + folder + ": " + error.message());
    const BoundHand bound;
    if (bound.report.status != cageform::Status::ok) return fail(cageform::to_string(bound.report.status));
    const HandBuilder builder(bound);
    if (builder.skin.status != cageform::Status::ok)
        return fail(std::string("the builds: ") + cageform::to_string(builder.skin.status));
    Findings findings;
    judge_rest(bound, findings);
    judge_constraints(bound, findings);
    judge_locality(bound, findings);
    judge_surface(bound, findings);
    judge_volume(bound, findings);
    judge_rings(bound.hand, findings);
    judge_builds(bound, builder, findings);
    judge_report(bound, findings);
    judge_time(bound.hand, findings);

    OutputFiles outputs;
    draw_hand(bound, builder, folder, outputs);
    if (const auto failure = outputs.commit()) return fail(*failure);
    std::printf("%d properties are not what they should be\n", findings.misses());
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return cageform_examples::guarded("hand_sheet", [&] { return run_program(argc, argv); });
}
