#include "hand_pictures.hpp"

#include "cli/coordinates.hpp"
#include "io/csv.hpp"
#include "model_sheet.hpp"

#include <stdexcept>

namespace cageform_sources {

using namespace cageform_support;

namespace {

constexpr Colour clay{0.9f, 0.65f, 0.47f}, bone{0.93f, 0.9f, 0.8f}, steel{0.5f, 0.62f, 0.75f},
    ink{0.13f, 0.18f, 0.33f};

// Views: the camera looks along -z.
Point3 from_back(const Point3& p) {
    return p;
}
Point3 from_palm(const Point3& p) {
    return {-p[0], p[1], -p[2]};
}
Point3 from_thumb(const Point3& p) {
    return {-p[2], p[1], p[0]};
}

// ---- the skin ----

using Skin = std::vector<Point3>;

/// The part of a mesh whose vertices satisfy `which`.
template <class Which>
Model part_of(const Model& whole, const Which& which) {
    Model part;
    std::vector<std::uint32_t> number(whole.vertices.size());
    for (std::size_t i = 0; i < number.size(); ++i) {
        number[i] = std::uint32_t(part.vertices.size());
        if (!which(i)) continue;
        part.vertices.push_back(whole.vertices[i]);
        part.colours.push_back(whole.colours[i]);
    }
    for (const auto& [a, b, c] : whole.faces) {
        if (which(a) && which(b) && which(c)) part.faces.push_back({number[a], number[b], number[c]});
    }
    return part;
}

Model skin_model(const BoundHand& bound, const Skin& skin, const Colour& colour = clay) {
    Model model;
    model.add(skin, bound.hand.skin.faces, colour);
    return model;
}

bool is_of_ray(const Hand& hand, std::size_t joint, std::size_t ray) {
    const auto& joints = hand.rays[ray];
    return std::find(joints.begin(), joints.end(), joint) != joints.end();
}

/// Whether a vertex belongs to a finger, from the first joint on.
bool is_of_finger(const Hand& hand, std::size_t vertex, std::size_t ray) {
    const std::size_t joint = hand.vertex_joint[vertex];
    return is_of_ray(hand, joint, ray) && (ray == 4 || joint != hand.rays[ray][0]);
}

HandPose with(std::initializer_list<std::pair<HandAngle, double>> angles) {
    HandPose pose{};
    for (const auto& [angle, degrees] : angles) pose[std::size_t(angle)] = degrees;
    return pose;
}

/// A position on the skin, which moves with it.
struct OnSkin {
    Face face{};
    Point3 weights{1, 0, 0};

    Point3 at(const Skin& skin) const {
        return weights[0] * skin[face[0]] + weights[1] * skin[face[1]] + weights[2] * skin[face[2]];
    }
};

/// The intersection of the skin and a line through `p` that is nearest to `p`; without one, the nearest
/// vertex.
OnSkin onto_skin(const ImplicitMesh& skin, const Point3& p, const Point3& direction) {
    OnSkin found;
    double least = 0.05;
    for (const Face& face : skin.faces) { // Möller and Trumbore 1997
        const Point3 a = skin.vertices[face[0]], ab = skin.vertices[face[1]] - a,
                     ac = skin.vertices[face[2]] - a, ap = p - a;
        if (dot(ap, ap) > 0.01) continue;
        const Point3 h = cross(direction, ac), q = cross(ap, ab);
        const double area = dot(ab, h);
        if (!(std::fabs(area) > 0)) continue;
        const double u = dot(ap, h) / area, v = dot(direction, q) / area, t = dot(ac, q) / area;
        if (u < 0 || v < 0 || u + v > 1 || std::fabs(t) >= least) continue;
        least = std::fabs(t);
        found = {face, {1 - u - v, u, v}};
    }
    if (least < 0.05) return found;
    std::uint32_t nearest = 0;
    for (std::uint32_t i = 0; i < skin.vertices.size(); ++i) {
        if (length(skin.vertices[i] - p) < length(skin.vertices[nearest] - p)) nearest = i;
    }
    return {{nearest, nearest, nearest}, {1, 0, 0}};
}

/// Constraint points in their order along a line of the skin.
struct Line {
    std::vector<std::size_t> points;
    bool closed = true;
};

/// Returns the chosen points in their order about an axis.
template <class Which>
Line around(const Hand& hand, const Point3& axis, const Which& which) {
    Line line;
    Point3 middle{};
    for (std::size_t i = 0; i < hand.points.size(); ++i) {
        if (!which(hand.points[i])) continue;
        line.points.push_back(i);
        middle = middle + hand.points[i].place;
    }
    if (line.points.empty()) return line;
    middle = (1 / double(line.points.size())) * middle;
    const Point3 first = hand.points[line.points[0]].place - middle;
    const Point3 u = first - (dot(first, axis) / dot(axis, axis)) * axis,
                 v = cross((1 / length(axis)) * axis, u);
    const auto angle = [&](std::size_t i) {
        const Point3 d = hand.points[i].place - middle;
        return std::atan2(dot(d, v), dot(d, u));
    };
    std::sort(line.points.begin(), line.points.end(),
              [&](std::size_t a, std::size_t b) { return angle(a) < angle(b); });
    return line;
}

std::vector<Line> lines_of(const Hand& hand) {
    std::vector<Line> lines;
    for (std::size_t j = 0; j < hand.joints.size(); ++j) {
        lines.push_back(around(hand, hand.joints[j].end - hand.joints[j].place, [&](const HandPoint& p) {
            return p.kind == HandPointKind::ring && p.joint == j;
        }));
    }
    Line base; // across the palm and back over the knuckles; points in the webs are not on it
    for (const double side : {-1.0, 1.0}) {
        const auto first = std::ptrdiff_t(base.points.size());
        for (std::size_t i = 0; i < hand.points.size(); ++i) {
            const HandPoint& p = hand.points[i];
            const bool in_web = p.other != HandJoint::none && std::fabs(p.place[2]) < 0.02;
            if (p.kind == HandPointKind::base && !in_web && (p.place[2] < 0) == (side < 0))
                base.points.push_back(i);
        }
        std::sort(base.points.begin() + first, base.points.end(), [&](std::size_t a, std::size_t b) {
            return side * hand.points[a].place[0] > side * hand.points[b].place[0];
        });
    }
    lines.push_back(base);
    lines.push_back(
        around(hand, {0, 1, 0}, [](const HandPoint& p) { return p.kind == HandPointKind::wrist; }));
    Line thenar{{}, false};
    for (std::size_t i = 0; i < hand.points.size(); ++i) {
        if (hand.points[i].kind == HandPointKind::thenar && hand.points[i].vertex != HandJoint::none)
            thenar.points.push_back(i);
    }
    lines.push_back(thenar);
    return lines;
}

/// The lines on the skin, in short steps.
std::vector<std::vector<OnSkin>> drawn_lines(const Hand& hand) {
    const ImplicitMesh& skin = hand.skin;
    std::vector<Point3> normals(skin.vertices.size());
    for (const auto& [a, b, c] : skin.faces) {
        const Point3 normal = cross(skin.vertices[b] - skin.vertices[a], skin.vertices[c] - skin.vertices[a]);
        for (const auto i : {a, b, c}) normals[i] = normals[i] + (1 / (length(normal) + 1e-30)) * normal;
    }
    std::vector<std::vector<OnSkin>> drawn;
    for (const auto& [points, closed] : lines_of(hand)) {
        auto& line = drawn.emplace_back();
        for (std::size_t n = 0; n + (closed ? 0 : 1) < points.size(); ++n) {
            const HandPoint &a = hand.points[points[n]], &b = hand.points[points[(n + 1) % points.size()]];
            constexpr int steps = 4;
            for (int k = 0; k <= steps; ++k) {
                const double t = double(k) / steps;
                line.push_back(onto_skin(skin, (1 - t) * a.place + t * b.place,
                                         (1 - t) * normals[a.vertex] + t * normals[b.vertex]));
            }
        }
    }
    return drawn;
}

constexpr std::array<Colour, 10> kind_colours{{{0.85f, 0.1f, 0.1f},  // ring
                                               {1.0f, 0.5f, 0.0f},   // base
                                               {0.95f, 0.85f, 0.1f}, // thenar
                                               {0.15f, 0.6f, 0.2f},  // middle
                                               {0.45f, 0.75f, 1.0f}, // shield
                                               {0.55f, 0.2f, 0.75f}, // tip
                                               {1.0f, 0.3f, 0.75f},  // inflation
                                               {0.1f, 0.25f, 0.75f}, // metacarpal
                                               {0.35f, 0.25f, 0.2f}, // wrist
                                               {0.6f, 0.6f, 0.6f}}}; // surround

/// The control points without those that surround the hand.
void add_points(Model& model, const Hand& hand, const std::vector<Point3>& sites) {
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const HandPointKind kind = hand.points[i].kind;
        if (kind != HandPointKind::surround)
            model.add_ball(sites[i], 0.0085, kind_colours.at(std::size_t(kind)));
    }
}

void add_lines(Model& model, const std::vector<std::vector<OnSkin>>& lines, const Skin& skin) {
    for (const auto& line : lines) {
        for (std::size_t n = 0; n + 1 < line.size(); ++n)
            model.add_rod(line[n].at(skin), line[n + 1].at(skin), 0.004, 0.004, ink);
    }
}

void add_bones(Model& model, const Hand& hand, const HandPose& angles) {
    const auto motions = hand.bones(angles);
    for (std::size_t j = 0; j < hand.joints.size(); ++j) {
        const HandJoint& joint = hand.joints[j];
        const Point3 a = motions[j](joint.place), b = motions[j](joint.end);
        const Point3 gap = 0.04 * (b - a);
        model.add_rod(a + gap, b - gap, 0.4 * joint.radius, 0.35 * joint.end_radius, bone, 16);
        model.add_ball(a, 0.45 * std::min(joint.radius, 0.06), steel);
    }
    const Point3 wrist{0.01, -0.04, 0};
    for (const auto& ray : hand.rays) model.add_rod(wrist, hand.joints[ray[0]].place, 0.012, 0.012, bone);
}

// ---- the pictures ----

Picture layers(const BoundHand& bound, const std::vector<std::vector<OnSkin>>& lines) {
    const Hand& hand = bound.hand;
    std::vector<Tile> tiles;
    for (const NamedHandPose& pose : {hand_poses()[0], hand_poses()[2]}) {
        const HandPose angles = bound.closed(pose);
        const Skin skin = bound.clone(angles);
        Model bones, points;
        add_bones(bones, hand, angles);
        add_points(points, hand, hand.pose(angles));
        add_lines(points, lines, skin);
        tiles.push_back(
            {bones, formatted("%zu bones, %zu angles: %s", hand.joints.size(), hand_angle_count, pose.name)});
        tiles.push_back(
            {points, formatted("%zu control points, and lines\nthrough some of them", hand.points.size())});
        tiles.push_back({skin_model(bound, skin), formatted("skin: %zu vertices", skin.size())});
    }
    for (Tile& tile : tiles) tile.model = tile.model.mapped(from_palm);
    return with_title("Three layers: angles turn bones, bones move control points, points move the skin",
                      {draw_tiles(tiles, 3, 560, 640)});
}

Picture points_by_kind(const BoundHand& bound, const std::vector<std::vector<OnSkin>>& lines) {
    const Hand& hand = bound.hand;
    Model model = skin_model(bound, hand.skin.vertices, {0.86f, 0.8f, 0.74f});
    add_points(model, hand, hand.sites());
    add_lines(model, lines, hand.skin.vertices);
    const Picture drawn =
        draw_tiles({{model.mapped(from_palm), "the inner side"}, {model, "the back"}}, 2, 900, 1100);
    Picture legend(380, drawn.height(), drawn.at(0, 0));
    const double left = 20;
    double y = 200;
    for (std::size_t kind = 0; kind < kind_colours.size(); ++kind) {
        std::size_t count = 0, on = 0;
        for (const HandPoint& p : hand.points) {
            if (p.kind != HandPointKind(kind)) continue;
            ++count;
            if (p.vertex != HandJoint::none) ++on;
        }
        if (count == 0) continue;
        const bool shown = HandPointKind(kind) != HandPointKind::surround;
        legend.line({left, y}, {left, y}, 16, kind_colours[kind]);
        write_caption(legend, {left + 20, y},
                      formatted("%zu %s%s", count, to_string(HandPointKind(kind)),
                                !shown        ? ", not shown"
                                : on == count ? ", on the skin"
                                : on == 0     ? ", off the skin"
                                              : formatted(", %zu on the skin", on).c_str()));
        y += 34;
    }
    legend.line({left - 8, y}, {left + 8, y}, 4, ink);
    write_caption(legend, {left + 20, y}, "a line of the skin");
    return with_title(formatted("The %zu control points by kind", hand.points.size()),
                      {beside({drawn, legend})});
}

Picture poses(const BoundHand& bound) {
    std::vector<Tile> tiles;
    for (const NamedHandPose& pose : hand_poses()) {
        Model model = skin_model(bound, bound.clone(bound.closed(pose)));
        std::string name = pose.name;
        for (const auto& [word, object] : {std::pair{"ball", &hand_ball()}, {"rod", &hand_rod()}}) {
            if (pose.name != std::string_view(word)) continue;
            model.add_rod(object->from, object->to, object->radius, object->radius, steel, 48);
            name = std::string("grasp of a ") + word;
        }
        if (name == "pinch") name = "thumb to little finger";
        tiles.push_back({std::move(model), name});
    }
    const std::size_t count = tiles.size();
    for (std::size_t n = 0; n < count; ++n) tiles.push_back({tiles[n].model.mapped(from_palm), ""});
    return with_title("Poses of 22 angles, from the back and from the inner side",
                      {draw_tiles(tiles, count, 400, 560)});
}

/// Weights of a vertex for nearby bones: the inverse sixth power of distances.
Point3 blended(const Hand& hand, const std::vector<RigidMotion3>& motions, std::size_t joint,
               const Point3& p) {
    const auto& ray = *std::find_if(hand.rays.begin(), hand.rays.end(), [&](const auto& joints) {
        return std::find(joints.begin(), joints.end(), joint) != joints.end();
    });
    const auto own = std::size_t(std::find(ray.begin(), ray.end(), joint) - ray.begin());
    Point3 sum{};
    double total = 0;
    for (std::size_t k = own == 0 ? 0 : own - 1; k < std::min(own + 2, ray.size()); ++k) {
        const HandJoint& j = hand.joints[ray[k]];
        const double distance = limb(p, j.place, j.end, 0, 0), weight = 1 / (std::pow(distance, 6) + 1e-18);
        sum = sum + weight * motions[ray[k]](p);
        total += weight;
    }
    return (1 / total) * sum;
}

/// Returns the volume of the middle finger from its first joint on, closed at the base.
double finger_volume(const Hand& hand, const Skin& skin) {
    const Point3 joint = hand.joints[hand.rays[1][1]].place;
    double sum = 0;
    for (const auto& [a, b, c] : hand.skin.faces) {
        if (is_of_finger(hand, a, 1) && is_of_finger(hand, b, 1) && is_of_finger(hand, c, 1))
            sum += dot(skin[a] - joint, cross(skin[b] - joint, skin[c] - joint)) / 6;
    }
    return sum;
}

Picture bends(const BoundHand& bound) {
    const Hand& hand = bound.hand;
    const auto angles = with({{HandAngle::middle_pip, 90}});
    const std::vector<double> ones(hand.points.size(), 1);
    const auto motions = hand.bones(angles);
    Skin blend;
    for (std::size_t i = 0; i < hand.skin.vertices.size(); ++i)
        blend.push_back(blended(hand, motions, hand.vertex_joint[i], hand.skin.vertices[i]));
    // Degree 3 for the finger alone.
    const auto in_finger = [&](std::size_t i) { return is_of_finger(hand, i, 1); };
    std::vector<Point3> finger;
    for (std::size_t i = 0; i < hand.skin.vertices.size(); ++i) {
        if (in_finger(i)) finger.push_back(hand.skin.vertices[i]);
    }
    const auto smooth = bind_to_sites<double>("sibson-c1", hand.sites(), finger);
    if (!smooth || cageform::clone(smooth.value, hand.pose(angles), finger) != cageform::Status::ok)
        throw std::runtime_error("the finger at degree 3 cannot be bound");
    Skin cubic = hand.skin.vertices;
    for (std::size_t i = 0, n = 0; i < cubic.size(); ++i) {
        if (in_finger(i)) cubic[i] = finger[n++];
    }

    const double rest = finger_volume(hand, hand.skin.vertices);
    std::vector<Tile> tiles;
    const auto add = [&](const Skin& skin, const char* name) {
        tiles.push_back(
            {part_of(skin_model(bound, skin), in_finger).mapped(from_thumb),
             formatted("%s\nvolume %+.1f %%", name, 100 * (finger_volume(hand, skin) / rest - 1))});
    };
    add(blend, "linear blend of bones");
    add(bound.clone(hand.pose(angles, false), ones), "degree 1, rings turn with their bones");
    add(bound.clone(hand.pose(angles), ones), "degree 1, rings turn by half");
    add(cubic, "degree 3, rings turn by half");
    return with_title("The middle finger bent by 90 degrees, without inflation; change of its volume",
                      {draw_tiles(tiles, 4, 500, 640)});
}

std::vector<double> distances(const Skin& a, const Skin& b) { // in percent of the hand's length
    std::vector<double> all;
    for (std::size_t i = 0; i < a.size(); ++i) all.push_back(100 * length(a[i] - b[i]));
    return all;
}

Picture inflation(const BoundHand& bound) {
    const Hand& hand = bound.hand;
    // A finger from its side.
    const auto bent =
        with({{HandAngle::middle_mcp, 30}, {HandAngle::middle_pip, 90}, {HandAngle::middle_dip, 60}});
    const double rest = finger_volume(hand, hand.skin.vertices);
    const auto in_finger = [&](std::size_t i) { return is_of_finger(hand, i, 1); };
    std::vector<Tile> fingers;
    for (const double kappa : {0.0, hand_kappa, 4 * hand_kappa}) {
        const Skin skin = bound.clone(bent, kappa);
        fingers.push_back({part_of(skin_model(bound, skin), in_finger).mapped(from_thumb),
                           formatted("kappa = %g%s\nvolume %+.1f %% relative to rest", kappa,
                                     kappa == 0            ? ": no inflation"
                                     : kappa == hand_kappa ? ", as everywhere else"
                                                           : "",
                                     100 * (finger_volume(hand, skin) / rest - 1))});
    }
    // The swelling of a fist, drawn on the hand at rest, where it is visible.
    const HandPose fist = hand_poses()[1].angles;
    const Skin off = bound.clone(fist, 0), on = bound.clone(fist);
    const auto moved = distances(off, on);
    const double most = *std::max_element(moved.begin(), moved.end());
    Model difference;
    difference.add(hand.skin.vertices, hand.skin.faces, heat_of(moved, most));
    const Picture fists =
        draw_tiles({{skin_model(bound, off).mapped(from_palm), "a fist without inflation"},
                    {skin_model(bound, on).mapped(from_palm), formatted("with it, kappa = %g", hand_kappa)}},
                   2, 560, 640);
    const Picture shown = draw_tiles(
        {{difference.mapped(from_palm),
          formatted("displacement of the skin of the fist,\nshown at rest: at most %.2f %%", most)}},
        1, 560, 640);
    return with_title("Inflation: weights of the points over the pads rise as joints bend",
                      {draw_tiles(fingers, 3, 560, 480),
                       beside({fists, with_bar(shown, most, "% of the\nhand's length")})});
}

Picture build_sheet(const BoundHand& bound, const HandBuilder& builder) {
    const HandPose grasp = bound.closed(hand_poses()[3]);
    const std::vector<double> ones(bound.hand.points.size(), 1);
    std::vector<Tile> tiles{{skin_model(bound, bound.hand.skin.vertices), "the original hand"}};
    std::vector<Tile> posed{{skin_model(bound, bound.clone(grasp)).mapped(from_palm), ""}};
    for (const HandBuild& build : hand_builds(bound.hand, builder)) {
        const Hand hand = builder.built(bound.hand, build.handles);
        const Skin skin = bound.clone(hand.pose(grasp), hand.weights(grasp, hand_kappa));
        tiles.push_back({skin_model(bound, bound.clone(hand.sites(), ones)), build.name});
        posed.push_back({skin_model(bound, skin).mapped(from_palm), ""});
    }
    return with_title(
        "Hands of other proportions by the same binding, at rest and by the angles that grasp a ball",
        {draw_tiles(tiles, tiles.size(), 500, 600), draw_tiles(posed, posed.size(), 500, 500)});
}

Picture influence(const BoundHand& bound) {
    const Hand& hand = bound.hand;
    std::vector<Picture> parts;
    const auto add = [&](HandPointKind kind, double side, const auto& view, const char* name) {
        // Chooses the point of the middle finger's second joint that faces the viewer most.
        std::size_t chosen = hand.points.size();
        for (std::size_t i = 0; i < hand.points.size(); ++i) {
            if (hand.points[i].kind != kind || hand.points[i].joint != hand.rays[1][2]) continue;
            if (chosen == hand.points.size() ||
                side * hand.points[i].place[2] > side * hand.points[chosen].place[2])
                chosen = i;
        }
        if (chosen == hand.points.size()) throw std::runtime_error(std::string("no point to draw: ") + name);
        std::vector<double> values;
        for (std::size_t i = 0; i < hand.skin.vertices.size(); ++i)
            values.push_back(bound.dense.weight(i, chosen));
        const double most = *std::max_element(values.begin(), values.end());
        Model model;
        model.add(hand.skin.vertices, hand.skin.faces, heat_of(values, most));
        model.add_ball(hand.points[chosen].place, 0.006, {0.1f, 0.35f, 0.9f});
        const auto reached =
            std::size_t(std::count_if(values.begin(), values.end(), [](double w) { return w > 0; }));
        parts.push_back(with_bar(
            draw_tiles({{model.mapped(view), formatted("%s\n%zu of %zu vertices follow it, by %.2g at most",
                                                       name, reached, values.size(), most)}},
                       1, 700, 860),
            most, "u"));
    };
    add(HandPointKind::ring, 1, from_back, "a point of a ring (blue)");
    add(HandPointKind::inflation, -1, from_palm, "an inflation point (blue)");
    return with_title("Influence: natural neighbour coordinates u of two control points on the skin",
                      {beside(parts)});
}

std::size_t nearest_joint(const Hand& hand, const Point3& p) {
    const auto distance = [&](const HandJoint& j) { return limb(p, j.place, j.end, j.radius, j.end_radius); };
    const auto nearest =
        std::min_element(hand.joints.begin(), hand.joints.end(),
                         [&](const HandJoint& a, const HandJoint& b) { return distance(a) < distance(b); });
    return std::size_t(nearest - hand.joints.begin());
}

/// The maximum of `values` over the skin of all fingers except `ray`, from `radii` radii beyond the first
/// joint on.
double largest_on_other_fingers(const Hand& hand, const std::vector<double>& values, std::size_t ray,
                                double radii) {
    double most = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        for (std::size_t other = 0; other < 5; ++other) {
            const HandJoint& base = hand.joints[hand.rays[other][other == 4 ? 0 : 1]];
            const Point3 along = base.end - base.place;
            if (other != ray && is_of_finger(hand, i, other) &&
                dot(hand.skin.vertices[i] - base.place, along) > radii * base.radius * length(along))
                most = std::max(most, values[i]);
        }
    }
    return most;
}

/// The skin deformed by harmonic coordinates in a cage whose vertices move with the nearest joints.
Skin in_posed_cage(const Hand& hand, const ImplicitMesh& cage, const HandPose& angles) {
    MeshFile file;
    file.vertices = cage.vertices;
    file.triangles = cage.faces;
    CoordinatesChoice choice;
    choice.name = "harmonic";
    choice.harmonic.accuracy = 0.005; // a uniform grid of 128 cells is too coarse for the cage
    const auto [binding, report] = make_coordinates<double>(choice, file).bind(hand.skin.vertices);
    if (report.status != cageform::Status::ok || !report.outside.empty())
        throw std::runtime_error(std::string("the cage of the hand: ") + cageform::to_string(report.status));
    const auto motions = hand.bones(angles);
    Skin pose, skin(hand.skin.vertices.size());
    for (const Point3& p : cage.vertices) pose.push_back(blended(hand, motions, nearest_joint(hand, p), p));
    if (cageform::clone(binding, pose, skin) != cageform::Status::ok)
        throw std::runtime_error("the hand in its cage cannot be cloned");
    return skin;
}

Picture locality(const BoundHand& bound) {
    const Hand& hand = bound.hand;
    const std::array<const char*, 4> names{"index", "middle", "ring", "little"};
    std::size_t ray = 0; // of the finger that moves the others most
    double worst = -1;
    const auto pose_of = [](std::size_t finger) { return with({{HandAngle(4 * finger + 1), 90}}); };
    for (std::size_t finger = 0; finger < names.size(); ++finger) {
        const double most = largest_on_other_fingers(
            hand, distances(bound.clone(pose_of(finger)), hand.skin.vertices), finger, 0);
        if (most > worst) ray = finger;
        worst = std::max(worst, most);
    }
    const HandPose angles = pose_of(ray);
    const ImplicitMesh cage = cage_of(hand);
    const std::array<Skin, 2> skins{bound.clone(angles), in_posed_cage(hand, cage, angles)};
    std::array<std::vector<double>, 2> moved;
    std::array<double, 2> most{}, past_web{};
    for (std::size_t n = 0; n < 2; ++n) {
        moved[n] = distances(skins[n], hand.skin.vertices);
        most[n] = largest_on_other_fingers(hand, moved[n], ray, 0);
        past_web[n] = largest_on_other_fingers(hand, moved[n], ray, 1.5);
    }
    const double scale = std::ceil(std::max({most[0], most[1], 1.0}));
    std::vector<Tile> tiles;
    for (const auto& view : {from_back, from_palm}) {
        tiles.push_back({skin_model(bound, hand.skin.vertices).mapped(view),
                         formatted("a cage of %zu vertices", cage.vertices.size())});
        for (std::size_t n = 0; n < 2; ++n) {
            auto colours = heat_of(moved[n], scale);
            for (std::size_t i = 0; i < colours.size(); ++i) {
                if (is_of_finger(hand, i, ray)) colours[i] = {0.7f, 0.7f, 0.7f};
            }
            Model model;
            model.add(skins[n], hand.skin.faces, colours);
            tiles.push_back({model.mapped(view),
                             formatted("%s\nothers move by %.2f %%, beyond the web %.2f",
                                       n == 0 ? "natural neighbours" : "harmonic coordinates in the cage",
                                       most[n], past_web[n])});
        }
    }
    std::array<Skin, 2> cages{cage.vertices, cage.vertices};
    for (Point3& p : cages[1]) p = from_palm(p);
    for (std::size_t n = 0; n < 2; ++n) tiles[3 * n].cage = {cages[n], cage.faces};
    return with_title(
        formatted("The %s finger (grey), bent by 90 degrees at its first joint, moves the others most",
                  names[ray]),
        {with_bar(draw_tiles(tiles, 3, 560, 640), scale, "% of the\nhand's length")});
}

} // namespace

void draw_hand(const BoundHand& bound, const HandBuilder& builder, const std::filesystem::path& folder,
               OutputFiles& outputs) {
    const auto lines = drawn_lines(bound.hand);
    layers(bound, lines).write_png(outputs.add(folder / "hand_layers.png"));
    points_by_kind(bound, lines).write_png(outputs.add(folder / "hand_points.png"));
    poses(bound).write_png(outputs.add(folder / "hand_poses.png"));
    bends(bound).write_png(outputs.add(folder / "hand_bend.png"));
    inflation(bound).write_png(outputs.add(folder / "hand_inflation.png"));
    build_sheet(bound, builder).write_png(outputs.add(folder / "hand_builds.png"));
    influence(bound).write_png(outputs.add(folder / "hand_influence.png"));
    locality(bound).write_png(outputs.add(folder / "hand_locality.png"));
}

} // namespace cageform_sources
