// Merges pairs of triangles of a 3D cage to quads.
#pragma once

#include <cageform/enclose/space/cage_maker.hpp>
#include <cageform/enclose/space/matching.hpp>
#include <cageform/enclose/space/mesh_mirror.hpp>

#include <map>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Two triangles with a common edge as a quad. The old diagonal is the common edge; the new one splits the
/// quad into two other triangles. Both triangulations, the fan about the mean corner and the bilinear patch
/// lie in the tetrahedron of the corners.
struct FacePair {
    using Point = Vec<double, 3>;

    std::array<std::uint32_t, 2> faces{};
    std::array<std::uint32_t, 4> loop{}; ///< counter-clockwise; the old diagonal joins corners 0 and 2
    std::array<Point, 4> corner{};
    double warp = 0;         ///< distance between the diagonals over the mean edge length
    double quality = 0;      ///< 1: a square; 0: the worst
    double clearance = 0;    ///< clearance of the tetrahedron, at most that of the cage
    std::uint32_t image = 0; ///< index of the mirrored pair
    bool allowed = true;

    /// Sets warp and quality. Returns true if the quad is convex seen along its normal, with angles of 20 to
    /// 160 degrees and a warp of at most 0.4. A square folded by 59 degrees along a diagonal has this warp.
    bool measure() noexcept {
        constexpr double sharpest = std::numbers::pi / 9, right = std::numbers::pi / 2, most_warp = 0.4;
        const Point normal = cross(corner[2] - corner[0], corner[3] - corner[1]);
        const double size = length(normal);
        if (!(size > 0)) return false;
        double edges = 0, off = 0; // off: largest deviation from a right angle
        for (std::size_t k = 0; k < 4; ++k) {
            const Point to = corner[(k + 1) % 4] - corner[k], back = corner[(k + 3) % 4] - corner[k];
            const Point turn = cross(to, back);
            const double seen = std::atan2(dot(turn, normal) / size, dot(to, back));
            if (!(seen > sharpest && seen < std::numbers::pi - sharpest)) return false;
            off = (std::max)(off, std::fabs(std::atan2(length(turn), dot(to, back)) - right));
            edges += length(to);
        }
        warp = 4 * std::fabs(dot(corner[1] - corner[0], normal)) / (size * edges);
        // Angle term as in Remacle et al., Blossom-Quad, Int. J. Numer. Meth. Eng. 89, 2012.
        quality = 0.5 * (1 - off / right) + 0.5 * (1 - warp / most_warp);
        return warp <= most_warp;
    }

    /// Triangle of all corners except `left_out`. The triangles without corner 0 or 2 are new; those without
    /// corner 1 or 3 are old.
    Facet<3> triangle_without(std::size_t left_out) const noexcept {
        std::array<std::uint32_t, 3> three{};
        for (std::size_t k = 0; k < 3; ++k) three[k] = std::uint32_t((left_out + 1 + k) % 4);
        Facet<3> facet(three, std::span<const Point>(corner));
        for (auto& v : facet.vertex) v = loop[v];
        return facet;
    }
    bool has(std::uint32_t v) const noexcept { return std::find(loop.begin(), loop.end(), v) != loop.end(); }
    /// True if the tetrahedron of the corners contains a point; false for a flat one.
    bool holds(const Point& p) const noexcept {
        const auto six = [](const Point& a, const Point& b, const Point& c, const Point& d) {
            return dot(b - a, cross(c - a, d - a));
        };
        const double all = six(corner[0], corner[1], corner[2], corner[3]);
        const auto e = corner[2] - corner[0];
        if (!(std::fabs(all) > 1e-9 * dot(e, e) * length(e))) return false;
        for (std::size_t k = 0; k < 4; ++k) {
            auto with = corner;
            with[k] = p;
            if (!(six(with[0], with[1], with[2], with[3]) / all >= 0)) return false;
        }
        return true;
    }
    Bounds<double, 3> bounds() const noexcept { return bounds_of(std::span<const Point>(corner)); }
};

/// Finds all valid quads of a cage and selects a largest compatible set.
class FacePairing {
public:
    using Point = Vec<double, 3>;
    using Face = std::array<std::uint32_t, 3>;

    ///   parts  part number of each face; faces of different parts form no pair. May be empty
    FacePairing(std::vector<Point> points, std::vector<Face> faces, std::vector<int> parts = {})
        : points_(std::move(points))
        , faces_(std::move(faces))
        , parts_(std::move(parts))
        , image_(faces_.size()) {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k) face_of_edge_[{faces_[f][k], faces_[f][(k + 1) % 3]}] = f;
            image_[f] = f;
        }
        for (const auto& [edge, f] : face_of_edge_) {
            if (edge.first < edge.second) add_pair(edge, f);
        }
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) pairs_[n].image = n;
    }

    /// Selects pairs together with their images, if the cage is symmetric.
    ///
    ///   tolerance  maximum distance of a vertex from the image of another
    void mirror(std::size_t axis, double position, double tolerance) {
        auto mirrored = mirror_across(axis, position, tolerance, points_, faces_);
        if (!mirrored) return;
        image_ = std::move(mirrored->faces);
        std::map<std::array<std::uint32_t, 2>, std::uint32_t> number;
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) number[pairs_[n].faces] = n;
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) {
            std::array<std::uint32_t, 2> faces{image_[pairs_[n].faces[0]], image_[pairs_[n].faces[1]]};
            std::sort(faces.begin(), faces.end());
            const auto found = number.find(faces);
            if (found == number.end())
                pairs_[n].allowed = false; // its image was just rejected, due to rounding
            else
                pairs_[n].image = found->second;
        }
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) {
            const auto &faces = pairs_[n].faces, &images = pairs_[pairs_[n].image].faces;
            const bool share =
                std::find_first_of(faces.begin(), faces.end(), images.begin(), images.end()) != faces.end();
            if (share && pairs_[n].image != n) pairs_[n].allowed = false; // only one of the two can be chosen
        }
    }

    /// Rejects pairs whose tetrahedron is closer to a figure than `least`.
    ///
    ///   clearance  clearance of the cage
    void reject_near(std::span<const Corners<3>> figure, double clearance, double least) {
        FaceHash hash = make_hash();
        std::vector<std::size_t> seen(pairs_.size(), figure.size()); // the hash may return a pair twice
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) {
            pairs_[n].clearance = clearance;
            hash.add(n, box_corners(pairs_[n]));
        }
        for (std::size_t f = 0; f < figure.size(); ++f) {
            const Corners<3>& triangle = figure[f];
            const auto middle = (1.0 / 3) * (triangle[0] + triangle[1] + triangle[2]);
            double radius = 0;
            for (const auto& p : triangle) radius = (std::max)(radius, length(p - middle));
            const auto box = box_of(triangle);
            (void)hash.any(box.widened(clearance), [&](std::uint32_t n) {
                FacePair& pair = pairs_[n];
                if (!pair.allowed || seen[n] == f) return false;
                seen[n] = f;
                if (!hash.box(n).overlaps(box.widened(pair.clearance))) return false;
                for (const std::size_t k : {0U, 2U}) {
                    const auto& corner = pair.triangle_without(k).corner;
                    if (distance_to_facet(middle, corner) - radius < pair.clearance)
                        pair.clearance = (std::min)(pair.clearance, facet_distance(triangle, corner));
                }
                if (pair.holds(triangle[0])) pair.clearance = 0;
                pair.allowed = pair.clearance >= least;
                return false;
            });
        }
    }

    /// Rejects pairs whose tetrahedron intersects another triangle of the cage.
    void reject_crossing() {
        FaceHash hash = make_hash();
        for (std::uint32_t f = 0; f < faces_.size(); ++f)
            hash.add(f, Facet<3>(faces_[f], std::span<const Point>(points_)).corner);
        for (FacePair& pair : pairs_) {
            pair.allowed = pair.allowed && !hash.any(pair.bounds(), [&](std::uint32_t f) {
                return f != pair.faces[0] && f != pair.faces[1] &&
                       intersects(pair, Facet<3>(faces_[f], std::span<const Point>(points_)));
            });
        }
    }

    /// Returns as many pairs as possible with the greatest sum of qualities. If the tetrahedra of two chosen
    /// pairs intersect, rejects the one of lower quality and repeats.
    std::vector<std::uint32_t> choose() {
        for (FacePair& pair : pairs_) pair.allowed = pair.allowed && pairs_[pair.image].allowed;
        for (;;) {
            const auto chosen = best_choice();
            if (!reject_intersecting(chosen)) return chosen;
        }
    }
    const FacePair& operator[](std::size_t n) const noexcept { return pairs_[n]; }

private:
    using Edge = std::pair<std::uint32_t, std::uint32_t>;

    std::uint32_t third(std::uint32_t f, std::uint32_t a, std::uint32_t b) const noexcept {
        return faces_[f][0] + faces_[f][1] + faces_[f][2] - a - b;
    }
    void add_pair(const Edge& edge, std::uint32_t f) {
        const auto [a, b] = edge;
        const auto other = face_of_edge_.find({b, a});
        if (other == face_of_edge_.end()) return;
        const std::uint32_t g = other->second, c = third(f, a, b), d = third(g, a, b);
        if (parts_.size() == faces_.size() && parts_[f] != parts_[g]) return;
        // If the cage already has the new diagonal, this edge would have four faces.
        if (face_of_edge_.contains({c, d}) || face_of_edge_.contains({d, c})) return;
        FacePair pair;
        pair.faces = {(std::min)(f, g), (std::max)(f, g)};
        pair.loop = {a, d, b, c};
        for (std::size_t k = 0; k < 4; ++k) pair.corner[k] = points_[pair.loop[k]];
        if (pair.measure()) pairs_.push_back(pair);
    }

    /// Returns corners that have the same bounds as a pair, for the hash.
    static Corners<3> box_corners(const FacePair& pair) noexcept {
        const auto box = pair.bounds();
        return {box.lower, box.upper, box.upper};
    }
    FaceHash make_hash() const {
        double edges = 0;
        for (const auto& face : faces_) edges += length(points_[face[1]] - points_[face[0]]);
        return {2.5 * edges / double(faces_.size()), faces_.size()};
    }
    static bool touch(const Facet<3>& a, const Facet<3>& b) noexcept {
        const auto n = area_normal(a.corner);
        const double gap = 1e-7 * std::sqrt(length(n)), reach = gap * length(n);
        return faces_touch(a, n, reach, b, gap);
    }
    /// True if the tetrahedron of a pair intersects a triangle outside common corners. The old triangles of
    /// the pair are faces of the cage and not tested.
    static bool intersects(const FacePair& pair, const Facet<3>& facet) noexcept {
        for (std::size_t k = 0; k < 3; ++k) {
            if (!pair.has(facet.vertex[k]) && pair.holds(facet.corner[k])) return true;
        }
        return touch(pair.triangle_without(0), facet) || touch(pair.triangle_without(2), facet);
    }

    std::vector<std::uint32_t> best_choice() const {
        // A face and its image are one vertex of the graph. A pair of a face with its own image gets a
        // separate vertex. All other pairs count twice, for themselves and their images.
        constexpr double steps = 1e6; // resolution of the quality
        const auto more = static_cast<std::int64_t>(steps) * std::int64_t(faces_.size());
        std::vector<WeightedEdge> edges;
        std::vector<std::uint32_t> pair_of;
        auto vertices = static_cast<std::uint32_t>(faces_.size());
        for (std::uint32_t n = 0; n < pairs_.size(); ++n) {
            const FacePair& pair = pairs_[n];
            if (!pair.allowed || pair.image < n) continue;
            const auto& [f, g] = pair.faces;
            const auto weight = more + static_cast<std::int64_t>(steps * pair.quality);
            const std::uint32_t a = (std::min)(f, image_[f]), b = (std::min)(g, image_[g]);
            const bool counts_twice = pair.image != n;
            edges.push_back({a, a == b ? vertices++ : b, counts_twice ? 2 * weight : weight});
            pair_of.push_back(n);
        }
        const Matching matching(vertices, edges);
        std::vector<std::uint32_t> chosen;
        for (std::uint32_t e = 0; e < edges.size(); ++e) {
            if (matching.edge_at(edges[e].a) != e) continue;
            const FacePair& pair = pairs_[pair_of[e]];
            chosen.push_back(pair_of[e]);
            if (pair.image != pair_of[e]) chosen.push_back(pair.image);
        }
        return chosen;
    }

    /// Rejects chosen pairs that intersect or share a new diagonal. Returns true if there were any.
    bool reject_intersecting(std::span<const std::uint32_t> chosen) {
        FaceHash hash = make_hash();
        bool any = false;
        for (const std::uint32_t n : chosen) {
            FacePair& pair = pairs_[n];
            (void)hash.any(pair.bounds(), [&](std::uint32_t other) {
                if (!intersect(pair, pairs_[other])) return false;
                any = true;
                reject(pair.quality < pairs_[other].quality ? n : other);
                return false;
            });
            hash.add(n, box_corners(pair));
        }
        return any;
    }
    static bool intersect(const FacePair& a, const FacePair& b) noexcept {
        if (std::minmax(a.loop[1], a.loop[3]) == std::minmax(b.loop[1], b.loop[3])) return true;
        return intersects(a, b.triangle_without(0)) || intersects(a, b.triangle_without(2)) ||
               intersects(b, a.triangle_without(0));
    }
    void reject(std::uint32_t n) noexcept {
        pairs_[n].allowed = false;
        pairs_[pairs_[n].image].allowed = false;
    }

    std::vector<Point> points_;
    std::vector<Face> faces_;
    std::vector<int> parts_;                     ///< part number of each face; may be empty
    std::vector<std::uint32_t> image_;           ///< mirror image of each face, or the face itself
    std::map<Edge, std::uint32_t> face_of_edge_; ///< face to the left of an edge
    std::vector<FacePair> pairs_;
};

/// Completes the report of the cage.
template <class T>
Status pair_faces_into(const TriangleMesh<T>& cage, std::span<const Vec<T, 3>> vertices,
                       std::span<const MeshFace> faces, const MakeCageOptions& options,
                       Result<PolyhedralMesh<T>, MakeCageReport>& made) {
    auto& report = made.report;
    std::vector<Corners<3>> figure;
    if (const Status status = read_figure(vertices, faces, figure, report); status != Status::ok)
        return status;
    if (const Status status = check_options<3>(options); status != Status::ok) return status;
    std::vector<Vec<double, 3>> points;
    for (const auto& p : cage.vertices()) points.push_back(vec_cast<double>(p));
    FacePairing pairing(points, {cage.faces().begin(), cage.faces().end()}, report.parts.of_face);
    if (options.mirror) {
        const std::size_t axis = options.mirror->axis;
        const auto box = bounds_of_corners(figure);
        const double middle = 0.5 * (box.lower[axis] + box.upper[axis]);
        pairing.mirror(axis, options.mirror->position.value_or(middle), 0.01 * report.margin);
    }
    pairing.reject_near(figure, report.clearance, 0.25 * report.margin);
    pairing.reject_crossing();
    std::vector<std::uint32_t> pair_of(cage.faces().size(), Matching::none);
    const auto chosen = pairing.choose();
    report.quads = chosen.size();
    report.triangles = cage.faces().size() - 2 * chosen.size();
    report.worst_warp = 0;
    for (const std::uint32_t n : chosen) {
        report.worst_warp = (std::max)(report.worst_warp, pairing[n].warp);
        report.clearance = (std::min)(report.clearance, pairing[n].clearance);
        for (const std::uint32_t f : pairing[n].faces) pair_of[f] = n;
    }
    std::vector<std::vector<std::uint32_t>> loops;
    for (std::size_t f = 0; f < cage.faces().size(); ++f) {
        if (pair_of[f] == Matching::none)
            loops.emplace_back(cage.faces()[f].begin(), cage.faces()[f].end());
        else if (pairing[pair_of[f]].faces[0] == f)
            loops.emplace_back(pairing[pair_of[f]].loop.begin(), pairing[pair_of[f]].loop.end());
    }
    made.value = PolyhedralMesh<T>(cage.vertices(), loops,
                                   PolyhedralOptions{.non_planar = PolyhedralOptions::NonPlanar::fan});
    report.cage = check(made.value);
    return report.cage.status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
