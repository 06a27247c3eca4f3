// make_cage in 3D, between steps 3 and 4 with options.rings: cuts the mesh along a plane across each limb.
// Edge collapses and relaxation keep these cuts as planar closed paths of edges, the rings.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/enclose/space/part_finder.hpp>
#include <cageform/enclose/space/shell.hpp>

#include <map>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A shell as one mesh: the faces of a half are followed by their images in the same order.
struct WholeShell {
    std::vector<Vec<double, 3>> points;
    std::vector<MeshFace> faces;
    std::vector<std::uint32_t> image; ///< image of each point; the point itself if it has no other image

    explicit WholeShell(const Shell& shell)
        : points(shell.points)
        , image(points.size()) {
        for (std::uint32_t v = 0; v < image.size(); ++v) {
            image[v] = v;
            if (!shell.half || shell.on_rim[v]) continue;
            image[v] = static_cast<std::uint32_t>(points.size());
            const auto& p = shell.points[v];
            points.push_back({-p[0], p[1], p[2]});
        }
        for (std::size_t f = 0; f < shell.faces.size(); ++f) {
            if (shell.is_face(f)) faces.push_back(shell.faces[f]);
        }
        for (std::size_t f = 0, own = faces.size(); shell.half && f < own; ++f)
            faces.push_back({image[faces[f][0]], image[faces[f][2]], image[faces[f][1]]});
    }
    double area(std::size_t f) const noexcept { return 0.5 * length(area_normal(points, faces[f])); }
};

/// Cuts a shell along rings around limbs. Each plane is searched near the joint that find_parts returns, for
/// a short cut.
class LimbRings {
public:
    using Point = Vec<double, 3>;

    LimbRings(Shell& shell, double spacing)
        : shell_(shell)
        , spacing_(spacing) {
        shell_.ring.assign(shell_.points.size(), Shell::none);
    }

    /// Finds limbs on a coarser shell of the same figure; keeps them if there are more than before.
    void find_limbs(const Shell& coarse) {
        const WholeShell whole(coarse);
        const CageParts parts = PartFinder(whole.points, whole.faces).find();
        std::vector<Limb> limbs;
        for (const CagePart& part : parts.parts) {
            const bool is_pair = parts.find(-part.number) != nullptr;
            if (part.parent == 0 || (coarse.half && is_pair && part.number < 0)) continue;
            limbs.emplace_back(parts, part.number, whole, coarse.half && !is_pair);
        }
        if (limbs.size() > limbs_.size()) limbs_ = std::move(limbs);
    }

    /// Cuts around the limbs, largest first. A ring needs four vertices; all rings together get at most a
    /// quarter of `vertices`.
    void cut(std::size_t vertices) {
        std::stable_sort(limbs_.begin(), limbs_.end(),
                         [](const Limb& a, const Limb& b) { return a.area > b.area; });
        std::size_t needed = 0;
        for (const Limb& limb : limbs_) {
            const std::size_t more = shell_.half && !limb.crosses_mirror ? 8 : 4;
            if (4 * (needed + more) <= vertices && cut_about(limb)) needed += more;
        }
    }

private:
    struct Limb {
        Point middle{}, axis{}; ///< mean of the joint, and unit direction from it towards the limb
        Point tip{};            ///< vertex farthest from the middle
        double area = 0, border = 0;
        bool crosses_mirror;

        Limb(const CageParts& parts, int number, const WholeShell& whole, bool crosses)
            : crosses_mirror(crosses) {
            std::map<Edge, std::size_t> edges;
            std::vector<std::uint32_t> corners;
            for (std::size_t f = 0; f < whole.faces.size(); ++f) {
                const auto* part = parts.find(parts.of_face[f]);
                while (part != nullptr && part->number != number) part = parts.find(part->parent);
                if (part == nullptr) continue;
                area += whole.area(f);
                for (std::size_t k = 0; k < 3; ++k) {
                    corners.push_back(whole.faces[f][k]);
                    edges[{whole.faces[f][k], whole.faces[f][(k + 1) % 3]}] = f;
                }
            }
            std::erase_if(
                edges, [at = edges]( // edges inside the limb
                           const auto& edge) { return at.count({edge.first.second, edge.first.first}) > 0; });
            for (const auto& [edge, f] : edges) {
                const Point &a = whole.points[edge.first], &b = whole.points[edge.second];
                border += length(b - a);
                middle = middle + (0.5 * length(b - a)) * (a + b);
            }
            middle = (1 / border) * middle;
            for (const auto& [edge, f] : edges) // the border runs counter-clockwise, seen from the tip
                axis = axis + cross(whole.points[edge.first] - middle, whole.points[edge.second] - middle);
            if (crosses_mirror) axis[0] = 0;
            axis = unit(axis);
            double farthest = -1;
            for (const auto v : corners) {
                const double off = length(whole.points[v] - middle);
                if (off > farthest) tip = whole.points[v];
                farthest = (std::max)(farthest, off);
            }
        }
    };

    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    /// One path along which a plane cuts the shell.
    struct Cut {
        Point normal{};
        double offset = 0;
        double length = 0;
        bool is_open = false;
        std::vector<Edge> edges; ///< each from a vertex below the plane to one above it; ascending
        std::vector<std::uint32_t> faces;
    };

    /// v / |v|; 0 if v is 0.
    static Point unit(const Point& v) noexcept {
        const double size = length(v);
        return size > 0 ? (1 / size) * v : Point{};
    }

    /// Cuts around a limb by the plane of the shortest cut. Returns false if no plane near its joint
    /// separates it.
    bool cut_about(const Limb& limb) {
        if (!(length(limb.axis) > 0)) return false;
        const auto tip = static_cast<std::uint32_t>(
            std::min_element(shell_.points.begin(), shell_.points.end(),
                             [&](const Point& p, const Point& q) {
                                 return dot(p - limb.tip, p - limb.tip) < dot(q - limb.tip, q - limb.tip);
                             }) -
            shell_.points.begin());
        const Point u =
            unit(cross(limb.axis, std::fabs(limb.axis[0]) < 0.9 ? Point{1, 0, 0} : Point{0, 1, 0}));
        const Point w = cross(limb.axis, u);
        const double radius = limb.border / (2 * std::numbers::pi);
        Cut best;
        double least = std::numeric_limits<double>::infinity();
        for (const double along : {0.0, -0.2, 0.2, 0.4, 0.7, 1.0}) { // in radii
            const Point through = limb.middle + (along * radius) * limb.axis;
            for (const double tilt : {0.0, -0.2, 0.2, -0.4, 0.4}) {
                for (const double lean : {0.0, -0.2, 0.2, -0.4, 0.4}) {
                    if (limb.crosses_mirror && tilt != 0) continue; // the cut would not be symmetric
                    const Point normal = unit(limb.axis + tilt * w + lean * u);
                    Cut cut = shortest_cut(limb, normal, dot(normal, through), tip);
                    const double score = cut.length * (1 + 0.5 * std::fabs(along));
                    if (cut.faces.empty() || !(score < least)) continue;
                    least = score;
                    best = std::move(cut);
                }
            }
        }
        if (best.faces.empty()) return false;
        split(best);
        return true;
    }

    /// Shortest path of a plane that separates a limb; without faces if there is none. Shifts the plane off
    /// the vertices.
    Cut shortest_cut(const Limb& limb, const Point& normal, double offset, std::uint32_t tip) const {
        std::vector<double> above(shell_.points.size());
        const auto is_through_a_vertex = [&] {
            double least = spacing_;
            for (std::size_t v = 0; v < above.size(); ++v) {
                above[v] = dot(normal, shell_.points[v]) - offset;
                least = (std::min)(least, std::fabs(above[v]));
            }
            return least < 1e-4 * spacing_;
        };
        for (int step = 0; is_through_a_vertex(); ++step) {
            if (step == 20) return {};
            offset += 3.3e-4 * spacing_;
        }
        std::vector<bool> seen(shell_.faces.size());
        Cut best;
        for (std::uint32_t f = 0; f < shell_.faces.size(); ++f) {
            if (seen[f]) continue;
            Cut cut = path_through(f, above, seen);
            const double border = limb.crosses_mirror ? 0.5 * limb.border : limb.border;
            if (cut.faces.empty() || cut.is_open != limb.crosses_mirror || cut.length > 1.5 * border)
                continue;
            if (touches_ring(cut) || !cuts_off(cut, limb, tip)) continue;
            if (best.faces.empty() || cut.length < best.length) best = std::move(cut);
        }
        best.normal = normal;
        best.offset = offset;
        return best;
    }

    /// The path along which a plane cuts the shell, starting in a face; without faces if the plane misses
    /// that face.
    ///
    ///   above  height of each vertex above the plane
    Cut path_through(std::uint32_t start, const std::vector<double>& above, std::vector<bool>& seen) const {
        Cut cut;
        std::vector<std::uint32_t> stack{start};
        seen[start] = true;
        while (!stack.empty()) {
            const auto f = stack.back();
            stack.pop_back();
            std::array<Point, 2> ends{};
            std::size_t count = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                auto v = shell_.faces[f][k], w = shell_.faces[f][(k + 1) % 3];
                if ((above[v] > 0) == (above[w] > 0)) continue;
                if (above[v] > 0) std::swap(v, w);
                cut.edges.push_back({v, w});
                ends[count++ % 2] = place_at(v, w, -above[v] / (above[w] - above[v]));
                const auto next = shell_.face_across(f, v, w);
                cut.is_open = cut.is_open || next == Shell::none;
                if (next == Shell::none || seen[next]) continue;
                seen[next] = true;
                stack.push_back(next);
            }
            if (count == 0) return cut;
            cut.faces.push_back(f);
            cut.length += length(ends[1] - ends[0]);
        }
        sort_unique(cut.edges);
        return cut;
    }
    Point place_at(std::uint32_t v, std::uint32_t w, double share) const noexcept {
        return shell_.points[v] + share * (shell_.points[w] - shell_.points[v]);
    }
    bool touches_ring(const Cut& cut) const {
        return std::any_of(cut.edges.begin(), cut.edges.end(), [&](const Edge& edge) {
            return shell_.ring_of(edge.first) != Shell::none || shell_.ring_of(edge.second) != Shell::none;
        });
    }

    /// True if a cut separates the limb's tip, and a part of about the limb's area, from the rest.
    bool cuts_off(const Cut& cut, const Limb& limb, std::uint32_t tip) const {
        enum : char { unknown, limb_side, rest_side };
        std::vector<char> side(shell_.points.size(), unknown), is_counted(shell_.faces.size(), 0);
        std::vector<std::uint32_t> stack;
        for (const auto& [v, w] : cut.edges) {
            side[v] = rest_side;
            if (side[w] == unknown) stack.push_back(w);
            side[w] = limb_side;
        }
        double area = 0;
        while (!stack.empty()) {
            const auto v = stack.back();
            stack.pop_back();
            for (const auto f : shell_.star[v]) {
                if (is_counted[f] == 0) area += 0.5 * length(area_normal(shell_.corners(shell_.faces[f])));
                is_counted[f] = 1;
                for (const auto w : shell_.faces[f]) {
                    if (side[w] == limb_side ||
                        std::binary_search(cut.edges.begin(), cut.edges.end(), Edge{w, v}))
                        continue;
                    if (side[w] == rest_side) return false; // a path around the cut
                    side[w] = limb_side;
                    stack.push_back(w);
                }
            }
        }
        if (limb.crosses_mirror) area *= 2;
        return side[tip] == limb_side && area > 0.5 * limb.area && area < 1.6 * limb.area;
    }

    /// Splits edges and faces; the new vertices form a ring.
    void split(const Cut& cut) {
        std::map<Edge, std::uint32_t> middle;
        for (const auto& [v, w] : cut.edges) {
            const double below = cut.offset - dot(cut.normal, shell_.points[v]),
                         above = dot(cut.normal, shell_.points[w]) - cut.offset;
            middle[{v, w}] = middle[{w, v}] = static_cast<std::uint32_t>(shell_.points.size());
            const auto f = shell_.face_across(Shell::none, v, w);
            shell_.points.push_back(place_at(v, w, below / (below + above)));
            shell_.on_rim.push_back(shell_.face_across(f, v, w) == Shell::none);
            shell_.ring.push_back(static_cast<std::uint32_t>(shell_.rings.size()));
        }
        shell_.rings.push_back({cut.normal, cut.offset, cut.edges.size(), cut.is_open});
        for (const auto f : cut.faces) {
            const auto face = shell_.faces[f];
            for (std::size_t k = 0; k < 3; ++k) { // the corner alone on its side
                const auto a = face[k], b = face[(k + 1) % 3], c = face[(k + 2) % 3];
                const auto to_b = middle.find({a, b}), to_c = middle.find({a, c});
                if (to_b == middle.end() || to_c == middle.end()) continue;
                shell_.faces[f] = {a, to_b->second, to_c->second};
                shell_.faces.push_back({to_b->second, b, c});
                shell_.faces.push_back({to_b->second, c, to_c->second});
                break;
            }
        }
        shell_.link();
    }

    Shell& shell_;
    double spacing_;
    std::vector<Limb> limbs_;
};

/// Regions of a whole shell between its rings.
class RingRegions {
public:
    explicit RingRegions(const Shell& shell)
        : shell_(shell)
        , whole_(shell)
        , own_(shell.half ? whole_.faces.size() / 2 : whole_.faces.size())
        , ring_(whole_.points.size(), Shell::none)
        , region_(whole_.faces.size(), Shell::none) {
        for (std::uint32_t f = 0; f < whole_.faces.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k)
                face_of_edge_[{whole_.faces[f][k], whole_.faces[f][(k + 1) % 3]}] = f;
        }
        for (std::uint32_t v = 0; v < shell.points.size(); ++v) {
            const auto r = ring_[v] = shell.ring_of(v);
            if (r == Shell::none || whole_.image[v] == v) continue;
            ring_[whole_.image[v]] =
                shell.rings[r].is_open ? r : r + static_cast<std::uint32_t>(shell.rings.size());
        }
        for (std::uint32_t start = 0; start < region_.size(); ++start) {
            if (region_[start] == Shell::none) fill(start);
        }
    }

    /// Returns the part number of each face. Part 1 is the largest region that is not on the limb side of a
    /// ring. The other regions are numbered by decreasing area; mirrored regions are n and -n.
    std::vector<int> numbers() const {
        std::vector<double> areas(regions_.size()), moment(regions_.size());
        std::vector<std::size_t> images(regions_.size());
        for (std::size_t n = 0; n < regions_.size(); ++n) {
            areas[n] = regions_[n].area;
            moment[n] = regions_[n].moment;
            const auto f = regions_[n].first;
            images[n] = region_[own_ == region_.size() ? f : f < own_ ? f + own_ : f - own_];
        }
        const auto given =
            part_numbers(areas, images, moment, [&](std::size_t n) { return !regions_[n].is_limb(); });
        std::vector<int> numbers(region_.size());
        for (std::size_t f = 0; f < region_.size(); ++f) numbers[f] = given[region_[f]];
        return numbers;
    }

private:
    struct Region {
        std::uint32_t first; ///< face
        double area = 0, moment = 0;
        std::vector<double> turn; ///< per ring: signed area of the border seen along the ring's normal

        bool is_limb() const {
            return std::any_of(turn.begin(), turn.end(), [](double t) { return t > 0; });
        }
    };

    void fill(std::uint32_t start) {
        const auto n = region_[start] = static_cast<std::uint32_t>(regions_.size());
        Region& region = regions_.emplace_back(Region{start, 0, 0, {}});
        region.turn.resize(2 * shell_.rings.size());
        std::vector<std::uint32_t> stack{start};
        while (!stack.empty()) {
            const auto f = stack.back();
            stack.pop_back();
            region.area += whole_.area(f);
            region.moment += f < own_ ? whole_.area(f) : -whole_.area(f);
            for (std::size_t k = 0; k < 3; ++k) {
                const auto v = whole_.faces[f][k], w = whole_.faces[f][(k + 1) % 3];
                if (ring_[v] != Shell::none && ring_[v] == ring_[w]) {
                    const std::size_t r = ring_[v] % shell_.rings.size();
                    auto normal = shell_.rings[r].normal;
                    if (ring_[v] != r) normal[0] = -normal[0];
                    region.turn[ring_[v]] += dot(normal, cross(whole_.points[v], whole_.points[w]));
                    continue;
                }
                const auto g = face_of_edge_.at({w, v});
                if (region_[g] == Shell::none) stack.push_back(g);
                region_[g] = n;
            }
        }
    }

    const Shell& shell_;
    WholeShell whole_;
    std::size_t own_; ///< number of faces that are no images
    /// Ring of each vertex. If a ring does not cross the mirror plane, its image is another ring.
    std::vector<std::uint32_t> ring_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>
        face_of_edge_;                  ///< face to the left of an edge
    std::vector<std::uint32_t> region_; ///< region of each face
    std::vector<Region> regions_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
