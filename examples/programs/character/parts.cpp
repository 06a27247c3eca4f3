#include "character/parts.hpp"

#include <cmath>
#include <map>
#include <numbers>

namespace cageform_programs {

namespace {

using Level = std::function<double(const Point3&)>; // positive in the part that remains
using Face = std::array<std::uint32_t, 3>;

constexpr double pi = std::numbers::pi;

Point3 outward(const Point3& p) {
    const Point3 g = cageform_support::slope(puppet, p);
    return (1 / cageform_support::length(g)) * g;
}

std::size_t bones_of(const PuppetPart& part) {
    return part.weights.size() / part.places.size();
}

/// Appends the weights of a vertex of another part.
void copy_weights(const PuppetPart& from, std::size_t vertex, PuppetPart& to) {
    const std::size_t bones = bones_of(from);
    const auto row = from.weights.begin() + std::ptrdiff_t(vertex * bones);
    to.weights.insert(to.weights.end(), row, row + std::ptrdiff_t(bones));
}

/// Cuts a mesh along the surface where a function is 0.
class Cutter {
public:
    Cutter(const PuppetPart& part, const Level& level)
        : mesh_(part)
        , bones_(bones_of(part)) {
        for (const Point3& p : mesh_.places) values_.push_back(level(p));
        snap();
    }

    PuppetPart run() {
        std::vector<Face> kept;
        for (const Face& face : std::vector(mesh_.faces)) {
            std::vector<std::uint32_t> corners;
            bool is_inside = false;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = face[k], b = face[(k + 1) % 3];
                if (values_[a] >= 0) corners.push_back(a);
                if (values_[a] * values_[b] < 0) corners.push_back(crossing(a, b));
                is_inside = is_inside || values_[a] > 0;
            }
            for (std::size_t k = 2; is_inside && k < corners.size(); ++k)
                kept.push_back({corners[0], corners[k - 1], corners[k]});
        }
        mesh_.faces = std::move(kept);
        return used_vertices();
    }

private:
    struct Vertex {
        Point3 place;
        std::vector<double> weights;
    };

    /// The part of the way from `a` to `b` where the function is 0.
    double part_of(std::uint32_t a, std::uint32_t b) const { return values_[a] / (values_[a] - values_[b]); }

    /// A vertex on the way from `a` to `b`.
    Vertex between(std::uint32_t a, std::uint32_t b, double t) const {
        Vertex vertex{(1 - t) * mesh_.places[a] + t * mesh_.places[b], std::vector<double>(bones_)};
        for (std::size_t k = 0; k < bones_; ++k)
            vertex.weights[k] = (1 - t) * mesh_.weights[a * bones_ + k] + t * mesh_.weights[b * bones_ + k];
        return vertex;
    }

    /// Moves vertices that are close to the cut along an edge onto the cut, to avoid narrow faces.
    void snap() {
        struct Move {
            std::uint32_t to = 0;
            double part = 0.25;
        };
        std::map<std::uint32_t, Move> moves;
        for (const Face& face : mesh_.faces) {
            for (std::size_t k = 0; k < 3; ++k) {
                for (const auto& [a, b] :
                     {std::pair{face[k], face[(k + 1) % 3]}, std::pair{face[(k + 1) % 3], face[k]}}) {
                    if (values_[a] * values_[b] >= 0) continue;
                    const double t = part_of(a, b);
                    if (auto& move = moves[a]; t < move.part) move = {b, t};
                }
            }
        }
        std::vector<std::pair<std::uint32_t, Vertex>> moved;
        for (const auto& [a, move] : moves) {
            if (move.part < Move{}.part) moved.push_back({a, between(a, move.to, move.part)});
        }
        for (const auto& [a, vertex] : moved) {
            mesh_.places[a] = vertex.place;
            std::copy(vertex.weights.begin(), vertex.weights.end(),
                      mesh_.weights.begin() + std::ptrdiff_t(a * bones_));
            values_[a] = 0;
        }
    }

    std::uint32_t crossing(std::uint32_t a, std::uint32_t b) {
        if (a > b) std::swap(a, b);
        const auto [at, is_new] = crossings_.insert({{a, b}, std::uint32_t(mesh_.places.size())});
        if (is_new) {
            const Vertex vertex = between(a, b, part_of(a, b));
            mesh_.places.push_back(vertex.place);
            mesh_.weights.insert(mesh_.weights.end(), vertex.weights.begin(), vertex.weights.end());
            values_.push_back(0);
        }
        return at->second;
    }

    PuppetPart used_vertices() const {
        PuppetPart part;
        std::map<std::uint32_t, std::uint32_t> index;
        for (Face face : mesh_.faces) {
            for (std::uint32_t& corner : face) {
                const auto [at, is_new] = index.insert({corner, std::uint32_t(part.places.size())});
                if (is_new) {
                    part.places.push_back(mesh_.places[corner]);
                    copy_weights(mesh_, corner, part);
                }
                corner = at->second;
            }
            part.faces.push_back(face);
        }
        return part;
    }

    PuppetPart mesh_;
    std::size_t bones_;
    std::vector<double> values_;
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> crossings_;
};

PuppetPart cut(PuppetPart part, const std::vector<Level>& levels) {
    for (const Level& level : levels) part = Cutter(part, level).run();
    return part;
}

/// Appends the vertices and faces of another part.
void append(PuppetPart& part, const PuppetPart& other) {
    const auto first = std::uint32_t(part.places.size());
    const auto add = [](auto& list, const auto& more) { list.insert(list.end(), more.begin(), more.end()); };
    add(part.places, other.places);
    add(part.normals, other.normals);
    add(part.weights, other.weights);
    add(part.texture, other.texture);
    add(part.colours, other.colours);
    for (const auto& [a, b, c] : other.faces) part.faces.push_back({first + a, first + b, first + c});
}

/// Moves the vertices outwards, and adds normals and texture coordinates. A vertex where u jumps is doubled.
PuppetPart finished(const PuppetPart& cut_part, double thickness, const Cylinder& chart) {
    const std::size_t right = (chart.axis + 2) % 3, up = (chart.axis + 1) % 3;
    PuppetPart part;
    std::map<std::pair<std::uint32_t, bool>, std::uint32_t>
        index; // by vertex, and whether its angle is one turn later
    for (const Face& face : cut_part.faces) {
        std::array<double, 3> turns; // of the corners, about the axis
        for (std::size_t k = 0; k < 3; ++k) {
            const Point3 d = cut_part.places[face[k]] - chart.centre;
            turns[k] = std::atan2(d[right], d[up]) / (2 * pi);
        }
        const double most = *std::max_element(turns.begin(), turns.end());
        Face corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const bool is_next = turns[k] < most - 0.5;
            const auto [at, is_new] = index.insert({{face[k], is_next}, std::uint32_t(part.places.size())});
            corners[k] = at->second;
            if (!is_new) continue;
            const Point3& p = cut_part.places[face[k]];
            part.normals.push_back(outward(p));
            part.places.push_back(p + thickness * part.normals.back());
            copy_weights(cut_part, face[k], part);
            part.texture.push_back({float(chart.around * (turns[k] + (is_next ? 1.5 : 0.5))),
                                    float(-chart.along * (p[chart.axis] - chart.centre[chart.axis]))});
        }
        part.faces.push_back(corners);
    }
    return part;
}

std::uint8_t byte_of(double x) { // 0 to 1
    return std::uint8_t(std::lround(255 * std::clamp(x, 0.0, 1.0)));
}

void paint_cheeks(PuppetPart& face) {
    for (const Point3& p : face.places) {
        const double cheek =
            cageform_support::length(Point3{std::fabs(p[0]), p[1], p[2]} - Point3{0.108, 1.68, 0.13});
        const double share = 0.45 * ramp(0.06, 0, cheek);
        face.colours.push_back({255, byte_of(1 - share), byte_of(1 - 0.9 * share), 255});
    }
}

/// A circle of a surface of revolution about y.
struct Ring {
    double radius, height;
    double normal_radius, normal_height;
    double v;
    Colour8 colour;
};

constexpr Colour8 white{255, 255, 255, 255};

/// A surface of revolution. `rings` go from bottom to top; rings of radius 0 are poles.
PuppetPart revolved(const std::vector<Ring>& rings, std::uint32_t sides, double repeats) {
    PuppetPart part;
    const auto vertex = [&](std::size_t ring, std::uint32_t k) {
        return std::uint32_t(ring) * (sides + 1) + k;
    };
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const Ring& ring = rings[r];
        for (std::uint32_t k = 0; k <= sides; ++k) {
            const double share = double(k % sides) / sides, angle = 2 * pi * share;
            const double c = std::cos(angle), s = std::sin(angle);
            part.places.push_back({ring.radius * s, ring.height, ring.radius * c});
            part.normals.push_back({ring.normal_radius * s, ring.normal_height, ring.normal_radius * c});
            part.texture.push_back({float(repeats * k / sides), float(ring.v)});
            part.colours.push_back(ring.colour);
            if (r == 0 || k == sides) continue;
            if (rings[r - 1].radius > 0)
                part.faces.push_back({vertex(r - 1, k), vertex(r - 1, k + 1), vertex(r, k)});
            if (ring.radius > 0) part.faces.push_back({vertex(r - 1, k + 1), vertex(r, k + 1), vertex(r, k)});
        }
    }
    return part;
}

} // namespace

PuppetParts puppet_parts(const cageform_support::ImplicitMesh& mesh, std::span<const double> weights) {
    PuppetPart all;
    all.places = mesh.vertices;
    all.weights.assign(weights.begin(), weights.end());
    all.faces = mesh.faces;
    const auto above = [](double height) { return [=](const Point3& p) { return p[1] - height; }; };
    const auto below = [](double height) { return [=](const Point3& p) { return height - p[1]; }; };
    const auto beyond = [](double out) { return [=](const Point3& p) { return std::fabs(p[0]) - out; }; };
    const auto within = [](double out) { return [=](const Point3& p) { return out - std::fabs(p[0]); }; };
    const Level at_button = [](const Point3& p) {
        double distance = 1;
        for (const double height : {1.31, 1.185, 1.06})
            distance = std::min(distance, std::hypot(p[0], p[1] - height));
        return p[2] > 0 ? 0.036 - distance : -1;
    };
    const Cylinder upright{1, {0, 1, 0}, 1, 1}, sideways{0, {0, 1.325, 0}, 1, 1};
    const Level shoe = [](const Point3& p) { return 0.115 + 0.4 * p[2] - p[1]; };
    const Level leg = [](const Point3& p) { return p[1] - 0.4 * p[2] - 0.095; };
    constexpr double cloth = 0.005, armhole = 0.215, cuff = 0.775, collar = 1.47, waist = 0.945;
    PuppetParts parts;
    parts.face = finished(cut(all, {above(collar - 0.03)}), 0, face_chart);
    paint_cheeks(parts.face);
    parts.hands = finished(cut(all, {beyond(cuff - 0.03)}), 0, sideways);
    parts.shirt =
        finished(cut(all, {below(collar), above(waist), within(armhole)}), cloth, {1, {0, 1, 0}, 6, 5});
    const Level is_arm = above(1.1);
    append(parts.shirt,
           finished(cut(all, {is_arm, beyond(armhole), within(cuff)}), cloth, {0, {0, 1.325, 0}, 2, 5}));
    parts.buttons = finished(cut(all, {at_button}), cloth + 0.003, upright);
    parts.trousers = finished(cut(all, {below(waist + 0.02), leg}), cloth - 0.002, upright);
    parts.shoes = finished(cut(all, {shoe}), cloth, upright);
    for (Point3& p : parts.shoes.places) p[1] = std::max(p[1], 0.0); // a flat sole
    return parts;
}

PuppetPart eye_part() {
    constexpr Colour8 black{4, 3, 3, 255}, blue{24, 74, 120, 255};
    std::vector<Ring> rings;
    const auto add = [&](double degrees, const Colour8& colour) {
        const double angle = degrees * pi / 180, r = degrees < 180 && degrees > 0 ? std::sin(angle) : 0;
        rings.push_back({r, std::cos(angle), r, std::cos(angle), degrees / 180, colour});
    };
    for (const double degrees : {180, 150, 125, 100, 80, 60, 45}) add(degrees, white);
    for (const double degrees : {45, 32, 20}) add(degrees, blue);
    for (const double degrees : {20, 10, 0}) add(degrees, black);
    return revolved(rings, 24, 1);
}

PuppetPart cap_part() {
    constexpr double radius = 0.188, height = 0.202, roll = 0.016, brim = 0.095;
    const double at_brim = radius * std::sqrt(1 - brim * brim / (height * height));
    std::vector<Ring> rings;
    for (int k = 0; k <= 8; ++k) { // the brim is rolled outwards
        const double angle = pi * (-0.75 + 1.5 * k / 8.0), c = std::cos(angle), s = std::sin(angle);
        rings.push_back({at_brim + roll * c, brim + roll * s, c, s, 1 - 0.03 * k, white});
    }
    for (int k = 0; k <= 8; ++k) {
        const double low = std::asin(brim / height), angle = low + (pi / 2 - low) * k / 8.0;
        const double c = k == 8 ? 0 : std::cos(angle), s = std::sin(angle);
        const double n = std::hypot(c / radius, s / height);
        rings.push_back({radius * c, height * s, c / radius / n, s / height / n, 0.75 - 0.09 * k, white});
    }
    PuppetPart cap = revolved(rings, 40, 10);
    cap.colours.clear();
    return cap;
}

MorphTarget morph_target(const PuppetPart& part, const std::function<Point3(const Point3&)>& shift) {
    constexpr double step = 1e-4;
    MorphTarget target;
    for (std::size_t i = 0; i < part.places.size(); ++i) {
        const Point3 &p = part.places[i], &n = part.normals[i];
        std::array<Point3, 3> j; // the Jacobian
        for (std::size_t k = 0; k < 3; ++k) {
            Point3 side{};
            side[k] = step;
            j[k] = side + 0.5 * (shift(p + side) - shift(p - side));
            j[k] = (1 / step) * j[k];
        }
        const Point3 turned = n[0] * cross(j[1], j[2]) + n[1] * cross(j[2], j[0]) + n[2] * cross(j[0], j[1]);
        target.shifts.push_back(shift(p));
        target.turns.push_back((1 / cageform_support::length(turned)) * turned - n);
    }
    return target;
}

Point3 smile(const Point3& p) {
    const double side = p[0] < 0 ? -1 : 1;
    const Point3 d = p - Point3{side * 0.078, 1.655, 0.15};
    const double near = std::exp(-dot(d, d) / (2 * 0.03 * 0.03));
    return near * Point3{side * 0.014, 0.022, -0.006};
}

Point3 surprise(const Point3& p) {
    const double low = ramp(1.66, 1.58, p[1]) * ramp(1.5, 1.56, p[1]), front = ramp(0.02, 0.12, p[2]);
    return low * front * Point3{0, -0.024, 0.006};
}

Point3 breath(const Point3& p) {
    const double near = ramp(0.98, 1.2, p[1]) * ramp(1.42, 1.26, p[1]) * ramp(0.3, 0.1, std::fabs(p[0]));
    return near * Point3{0.07 * p[0], 0.004, 0.02 * ramp(-0.05, 0.12, p[2])};
}

} // namespace cageform_programs
