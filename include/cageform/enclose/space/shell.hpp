// make_cage in 3D: an editable triangle mesh, and a spatial hash of its faces.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/enclose/space/clear_test.hpp>

#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The mesh between steps 3 and 5; faces are counter-clockwise seen from outside. In a mirrored cage it is
/// the half with x >= 0, open along a rim in the plane x = 0.
struct Shell {
    using Point = Vec<double, 3>;
    using Face = std::array<std::uint32_t, 3>;
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    std::vector<Point> points;
    std::vector<bool> on_rim; ///< per point of a half: whether it lies on the mirror plane
    std::vector<Face> faces;  ///< removed faces have equal vertices
    bool half = false;
    std::vector<std::vector<std::uint32_t>> star; ///< faces of each point; empty if it is removed
    /// A closed planar path of edges around a limb. No other edges join two vertices of the path.
    struct Ring {
        Point normal;  ///< unit normal of the plane, towards the limb
        double offset; ///< offset of the plane along its normal
        std::size_t vertices;
        bool is_open; ///< in a half: the path ends on the rim, and the normal has x = 0
    };
    std::vector<Ring> rings;
    std::vector<std::uint32_t> ring; ///< ring of each point, or `none`; may be empty

    std::uint32_t ring_of(std::uint32_t v) const noexcept { return ring.empty() ? none : ring[v]; }
    bool are_of_one_ring(std::uint32_t v, std::uint32_t w) const noexcept {
        return ring_of(v) != none && ring_of(v) == ring_of(w);
    }
    /// Nearest valid position to p. Rim vertices of a half stay on the mirror plane, its other vertices to
    /// the right of the plane. Ring vertices stay in the plane of their ring.
    ///
    ///   number  of the ring, or `none`
    Point allowed(Point p, bool is_on_rim, std::uint32_t number, double spacing) const noexcept {
        if (half) p[0] = is_on_rim ? 0 : (std::max)(p[0], 0.4 * spacing);
        if (number == none) return p;
        const Ring& of = rings[number];
        return p + (of.offset - dot(of.normal, p)) * of.normal;
    }
    /// True if a vertex is on the rim or to the right of the mirror plane.
    bool is_right_of_mirror(const Point& p, bool is_on_rim, double spacing) const noexcept {
        return !half || is_on_rim || p[0] > 0.39 * spacing;
    }

    void link() {
        star.assign(points.size(), {});
        for (std::size_t f = 0; f < faces.size(); ++f) {
            if (!is_face(f)) continue;
            for (const auto v : faces[f]) star[v].push_back(static_cast<std::uint32_t>(f));
        }
    }

    bool is_face(std::size_t f) const noexcept { return faces[f][0] != faces[f][1]; }
    bool has(std::size_t f, std::uint32_t v) const noexcept {
        return faces[f][0] == v || faces[f][1] == v || faces[f][2] == v;
    }
    Corners<3> corners(const Face& face) const noexcept {
        return {points[face[0]], points[face[1]], points[face[2]]};
    }
    /// Number of vertices of the whole cage, including the image of a half.
    std::size_t whole_size() const noexcept {
        std::size_t count = 0;
        for (std::size_t v = 0; v < points.size(); ++v)
            count += star[v].empty() ? 0 : half && !on_rim[v] ? 2 : 1;
        return count;
    }
    /// Six times the enclosed volume; the mirror plane, which contains the origin, closes a half.
    double six_volumes() const noexcept {
        double sum = 0;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            if (is_face(f)) sum += six_volumes(faces[f]);
        }
        return sum;
    }
    double six_volumes(const Face& face) const noexcept {
        return dot(points[face[0]], cross(points[face[1]], points[face[2]]));
    }

    /// Neighbours of a point, ascending.
    std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
        std::vector<std::uint32_t> all;
        for (const auto f : star[v]) {
            for (const auto w : faces[f]) {
                if (w != v) all.push_back(w);
            }
        }
        sort_unique(all);
        return all;
    }
    /// The other face at the edge v w; `none` on a rim.
    std::uint32_t face_across(std::uint32_t f, std::uint32_t v, std::uint32_t w) const noexcept {
        for (const auto g : star[v]) {
            if (g != f && has(g, w)) return g;
        }
        return none;
    }
    std::uint32_t third(std::uint32_t f, std::uint32_t v, std::uint32_t w) const noexcept {
        for (const auto x : faces[f]) {
            if (x != v && x != w) return x;
        }
        return v;
    }

    void remove_face(std::uint32_t f) {
        for (const auto v : faces[f]) std::erase(star[v], f);
        faces[f] = {0, 0, 0};
    }

    /// Returns the mesh without removed elements; points, faces and stars keep their order.
    Shell compacted() const {
        Shell less;
        less.half = half;
        less.rings = rings;
        std::vector<std::uint32_t> number(points.size(), none), face_number(faces.size(), none);
        for (std::size_t v = 0; v < points.size(); ++v) {
            if (star[v].empty()) continue;
            number[v] = static_cast<std::uint32_t>(less.points.size());
            less.points.push_back(points[v]);
            less.on_rim.push_back(on_rim[v]);
            if (!ring.empty()) less.ring.push_back(ring[v]);
            less.star.push_back(star[v]);
        }
        for (std::size_t f = 0; f < faces.size(); ++f) {
            if (!is_face(f)) continue;
            face_number[f] = static_cast<std::uint32_t>(less.faces.size());
            less.faces.push_back({number[faces[f][0]], number[faces[f][1]], number[faces[f][2]]});
        }
        for (auto& around : less.star) {
            for (auto& f : around) f = face_number[f];
        }
        return less;
    }
};

/// Euler number V - E + F of the whole mesh: 2 for each shell without a tunnel.
inline std::ptrdiff_t euler_number(const Shell& shell) {
    std::ptrdiff_t points = 0, faces = 0, rim = 0;
    for (std::size_t v = 0; v < shell.points.size(); ++v) {
        points += shell.star[v].empty() ? 0 : 1;
        rim += !shell.star[v].empty() && shell.on_rim[v] ? 1 : 0;
    }
    for (std::size_t f = 0; f < shell.faces.size(); ++f) faces += shell.is_face(f) ? 1 : 0;
    if (!shell.half) return points - faces / 2;
    // The doubled mesh has V = 2 points - rim, F = 2 faces, E = 3 faces; the rim has as many edges as points.
    return 2 * points - rim - faces;
}

/// Number of connected components.
inline std::ptrdiff_t shell_count(const Shell& shell) {
    DisjointSets components(shell.points.size());
    std::ptrdiff_t count = 0;
    for (const auto& star : shell.star) count += star.empty() ? 0 : 1;
    for (std::size_t f = 0; f < shell.faces.size(); ++f) {
        for (std::size_t k = 1; k < 3 && shell.is_face(f); ++k)
            count -= components.join(shell.faces[f][0], shell.faces[f][k]) ? 1 : 0;
    }
    return count;
}

/// 1 for an equilateral triangle, near 0 for needles: altitude over longest side, times 2/sqrt(3).
inline double triangle_quality(double twice_area, double longest2) noexcept {
    return longest2 > 0 ? twice_area / longest2 * (2 / std::numbers::sqrt3) : 0;
}
inline double triangle_quality(const Corners<3>& corner) noexcept {
    double longest2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto e = corner[(k + 1) % 3] - corner[k];
        longest2 = (std::max)(longest2, dot(e, e));
    }
    return triangle_quality(length(area_normal(corner)), longest2);
}

/// Bounds of a triangle with finite corners.
inline Bounds<double, 3> box_of(const Corners<3>& corner) noexcept {
    return bounds_of(std::span<const Vec<double, 3>>(corner));
}

/// Spatial hash of faces by the grid cells that intersect their bounds. Cells may share a bucket.
class FaceHash {
public:
    FaceHash(double cell, std::size_t faces)
        : cell_(cell)
        , buckets_(std::bit_ceil(std::max<std::size_t>(2 * faces, 64))) {}

    void add(std::uint32_t face, const Corners<3>& corner) {
        if (face >= boxes_.size()) boxes_.resize(face + 1);
        boxes_[face] = box_of(corner);
        for_each_cell(boxes_[face], [&](std::size_t bucket) {
            buckets_[bucket].push_back(face);
            return false;
        });
    }
    void remove(std::uint32_t face) {
        for_each_cell(boxes_[face], [&](std::size_t bucket) {
            buckets_[bucket].erase(std::find(buckets_[bucket].begin(), buckets_[bucket].end(), face));
            return false;
        });
    }
    /// True if test(face) holds for a face whose bounds overlap `box`. A face may be tested several times.
    template <class Test>
    bool any(const Bounds<double, 3>& box, const Test& test) const {
        return for_each_cell(box, [&](std::size_t bucket) {
            return std::any_of(buckets_[bucket].begin(), buckets_[bucket].end(),
                               [&](std::uint32_t face) { return boxes_[face].overlaps(box) && test(face); });
        });
    }

    const Bounds<double, 3>& box(std::uint32_t face) const noexcept { return boxes_[face]; }

private:
    template <class Visit>
    bool for_each_cell(const Bounds<double, 3>& box, const Visit& visit) const {
        std::array<std::int64_t, 3> from{}, to{};
        for (std::size_t k = 0; k < 3; ++k) {
            from[k] = static_cast<std::int64_t>(std::floor(box.lower[k] / cell_));
            to[k] = static_cast<std::int64_t>(std::floor(box.upper[k] / cell_));
        }
        for (auto z = from[2]; z <= to[2]; ++z) {
            for (auto y = from[1]; y <= to[1]; ++y) {
                for (auto x = from[0]; x <= to[0]; ++x) {
                    const auto mixed = std::uint64_t(x) * 0x9E3779B97F4A7C15U ^
                                       std::uint64_t(y) * 0xC2B2AE3D27D4EB4FU ^
                                       std::uint64_t(z) * 0x165667B19E3779F9U;
                    if (visit(std::size_t(mixed >> 20U) & (buckets_.size() - 1))) return true;
                }
            }
        }
        return false;
    }

    double cell_;
    std::vector<std::vector<std::uint32_t>> buckets_;
    std::vector<Bounds<double, 3>> boxes_;
};

/// Hashes all faces of a shell; cells are 2.5 mean edges wide.
inline FaceHash hash_of(const Shell& shell) {
    double edges = 0;
    std::size_t count = 0;
    for (std::size_t f = 0; f < shell.faces.size(); ++f) {
        if (!shell.is_face(f)) continue;
        const auto corner = shell.corners(shell.faces[f]);
        edges += length(corner[1] - corner[0]);
        ++count;
    }
    FaceHash hash(2.5 * edges / double(count), count);
    for (std::uint32_t f = 0; f < shell.faces.size(); ++f) {
        if (shell.is_face(f)) hash.add(f, shell.corners(shell.faces[f]));
    }
    return hash;
}

/// Searches for a separating plane: the plane of triangle `a`, or a plane perpendicular to it through one of
/// its edges. A plane separates if the corners of `b` that are not shared lie beyond it by more than `gap`.
/// The triangles then intersect at most in shared corners. This cheap test decides most pairs.
///
///   n      normal of `a`
///   reach  |n| · gap
CAGEFORM_DETAIL_FLATTEN inline bool are_apart(const Facet<3>& a, const Vec<double, 3>& n, double reach,
                                              const Facet<3>& b, double gap) noexcept {
    int above = 0, below = 0, shared = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (a.has(b.vertex[k])) {
            ++shared;
            continue;
        }
        const double off = dot(n, b.corner[k] - a.corner[0]);
        above += off > reach;
        below += off < -reach;
    }
    if (above + shared == 3 || below + shared == 3) return true;
    for (std::size_t e = 0; e < 3; ++e) {
        const std::size_t next = (e + 1) % 3, opposite = (e + 2) % 3;
        if (b.has(a.vertex[opposite])) continue;
        const auto outwards = cross(a.corner[next] - a.corner[e], n);
        const double limit = gap * length(outwards);
        bool beyond = true;
        for (std::size_t k = 0; k < 3; ++k)
            beyond = beyond && (a.has(b.vertex[k]) || dot(outwards, b.corner[k] - a.corner[e]) > limit);
        if (beyond) return true;
    }
    return false;
}

/// True if two faces touch outside shared vertices and edges, or are closer than `gap`. n and reach: see
/// are_apart.
inline bool faces_touch(const Facet<3>& a, const Vec<double, 3>& n, double reach, const Facet<3>& b,
                        double gap) noexcept {
    if (are_apart(a, n, reach, b, gap)) return false;
    const auto m = area_normal(b.corner);
    return !are_apart(b, m, gap * length(m), a, gap) && facets_touch(a, b, gap);
}

/// The figure as an obstacle of the shell.
struct ShellObstacles {
    const DistanceLattice<3>* lattice;
    double margin;
    /// Minimum distance between faces.
    double gap() const noexcept { return 1e-5 * margin; }
};

/// Tests whether new faces cross other faces of a shell or each other.
class ShellCrossings {
public:
    using Point = Vec<double, 3>;

    ShellCrossings(const Shell& shell, double gap)
        : shell_(shell)
        , gap_(gap)
        , hash_(hash_of(shell))
        , seen_(shell.faces.size(), 0) {}

    void add(std::uint32_t f) { hash_.add(f, shell_.corners(shell_.faces[f])); }
    void remove(std::uint32_t f) { hash_.remove(f); }

    /// True if a new face touches an existing face, except those with replaced(f), or another new face.
    template <class Replaced>
    bool any(std::span<const Shell::Face> fresh, const Replaced& replaced) {
        const std::span<const Point> points(shell_.points);
        fresh_.clear();
        Bounds<double, 3> all = bounds_of(std::span<const Point>());
        for (const auto& face : fresh) {
            const Facet<3> facet(face, points);
            const Point normal = area_normal(facet.corner);
            fresh_.push_back({facet, box_of(facet.corner).widened(gap_), normal, gap_ * length(normal)});
            all.include(fresh_.back().box);
        }
        ++search_;
        near_.clear();
        (void)hash_.any(all, [&](std::uint32_t f) {
            if (seen_[f] != search_ && !replaced(f)) near_.push_back({f, {shell_.faces[f], points}});
            seen_[f] = search_;
            return false;
        });
        for (std::size_t i = 0; i < fresh_.size(); ++i) {
            const NewFace& a = fresh_[i];
            for (const auto& [f, facet] : near_) {
                if (hash_.box(f).overlaps(a.box) && faces_touch(a.facet, a.normal, a.reach, facet, gap_))
                    return true;
            }
            for (std::size_t j = 0; j < i; ++j) {
                if (faces_touch(a.facet, a.normal, a.reach, fresh_[j].facet, gap_)) return true;
            }
        }
        return false;
    }

private:
    struct NewFace {
        Facet<3> facet;
        Bounds<double, 3> box;
        Point normal;
        double reach; ///< |normal| · gap
    };
    struct NearFace {
        std::uint32_t face;
        Facet<3> facet;
    };

    const Shell& shell_;
    double gap_;
    FaceHash hash_;
    std::vector<std::uint64_t> seen_; ///< per face: last search that returned it
    std::uint64_t search_ = 0;
    std::vector<NewFace> fresh_;
    std::vector<NearFace> near_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
