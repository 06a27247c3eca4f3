// The 3D cage: closed triangle meshes.
#pragma once

#include <cageform/cage/boundary_value.hpp>
#include <cageform/cage/check.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>

namespace cageform::inline CAGEFORM_ABI {

/// A cage in space: triangles over shared vertices, counter-clockwise seen from outside. Any genus, several components,
/// cavities. Shells that turn the other way as a whole are handled.
///
/// Copies the vertices and faces (a cage is small). Construction never fails; `check` tells whether the mesh can serve
/// as a cage, and every coordinate type asks it.
///
/// Small gaps are closed by faces over the vertices around them, so that coordinates keep their laws; `check` names
/// their edges in warnings. Small is what adds up to at most a quarter of the area. Takes O(#F log #F) and the square of the
/// edges of a gap.
template <Scalar T>
class TriangleMesh {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    using Face = std::array<std::uint32_t, 3>;

    TriangleMesh() = default;

    /// `faces[f][k]`, k = 0, 1, 2, is the vertex at a corner of a face. Indices below 0 or from the number of vertices on are
    /// remembered and reported by `check`.
    template <PointRange R, class Faces>
        requires(range_dimension<R> == 3)
    TriangleMesh(const R& vertices, const Faces& faces) {
        vertices_.reserve(std::size(vertices));
        for (std::size_t i = 0; i < std::size(vertices); ++i) vertices_.push_back(to_vec<T>(vertices[i]));
        faces_.reserve(std::size(faces));
        for (std::size_t f = 0; f < std::size(faces); ++f) {
            Face face;
            for (std::size_t k = 0; k < 3; ++k) {
                const auto i = faces[f][k];
                face[k] = i >= 0 && std::uint64_t(i) < vertices_.size() ? std::uint32_t(i) : no_vertex;
            }
            faces_.push_back(face);
        }
        given_ = faces_.size();
        close_gaps();
    }

    static constexpr std::uint32_t no_vertex = ~std::uint32_t{0};

    std::size_t size() const noexcept { return vertices_.size(); }
    std::span<const Vec<T, 3>> vertices() const noexcept { return vertices_; }
    const Vec<T, 3>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    std::span<const Face> faces() const noexcept {
        return faces_;
    } ///< those given, then those that close gaps
    std::size_t given_faces() const noexcept { return given_; }

    /// A face's way along an edge.
    struct Way {
        std::uint32_t from, to, face;
        auto key() const noexcept { return std::pair(std::min(from, to), std::max(from, to)); }
    };
    /// All ways, those along the same edge in a row.
    std::vector<Way> ways() const {
        std::vector<Way> all;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            for (std::size_t k = 0; k < 3; ++k)
                all.push_back({faces_[f][k], faces_[f][(k + 1) % 3], std::uint32_t(f)});
        }
        std::sort(all.begin(), all.end(), [](const Way& a, const Way& b) {
            return std::tuple(a.key(), a.from, a.face) < std::tuple(b.key(), b.from, b.face);
        });
        return all;
    }

private:
    double area(const Face& face) const noexcept {
        const auto a = vec_cast<double>(vertices_[face[0]]), b = vec_cast<double>(vertices_[face[1]]),
                   c = vec_cast<double>(vertices_[face[2]]);
        const auto n = cross(b - a, c - a);
        return 0.5 * std::sqrt(dot(n, n));
    }

    /// Whether a gap of three edges is the rim of a single face, which no second one makes a cage.
    bool is_stray(const std::vector<std::uint32_t>& around) const noexcept {
        return around.size() == 3 && std::any_of(faces_.begin(), faces_.end(), [&](const Face& face) {
                   return std::is_permutation(face.begin(), face.end(), around.begin());
               });
    }

    void close_gaps() {
        double whole = 0;
        for (const Face& face : faces_) {
            if (std::find(face.begin(), face.end(), no_vertex) != face.end()) return;
            whole += area(face);
        }
        const auto all = ways();
        std::vector<std::pair<std::uint32_t, std::uint32_t>>
            open; // against the ways of the faces, which is that of what closes them
        for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
            while (end < all.size() && all[end].key() == all[begin].key()) ++end;
            if (end - begin == 1) open.push_back({all[begin].to, all[begin].from});
        }
        std::sort(open.begin(), open.end());
        std::vector<Face> closing;
        double gaps = 0;
        const auto is_edge = [&](std::uint32_t i, std::uint32_t j) {
            const auto key = std::pair(std::min(i, j), std::max(i, j));
            const auto way = std::lower_bound(all.begin(), all.end(), key,
                                              [](const Way& a, const auto& k) { return a.key() < k; });
            return way != all.end() && way->key() == key;
        };
        std::vector<std::uint32_t> way; // along open edges
        while (!open.empty()) {
            if (way.empty()) way.push_back(open.front().first);
            const auto on =
                std::lower_bound(open.begin(), open.end(), std::pair(way.back(), std::uint32_t{0}));
            if (on == open.end() || on->first != way.back()) return; // no closed way
            const auto next = on->second;
            open.erase(on);
            const auto met = std::find(way.begin(), way.end(), next);
            if (met == way.end()) {
                way.push_back(next);
                continue;
            }
            // Closed: a gap, perhaps one that touches another at this vertex.
            const std::vector<std::uint32_t> around(met, way.end());
            way.erase(met == way.begin() ? met : met + 1, way.end());
            if (around.size() < 3 || is_stray(around)) return;
            // A fan from the vertex where it is smallest, of those that have no edge twice.
            std::vector<Face> best;
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t apex = 0; apex < around.size(); ++apex) {
                std::vector<Face> fan;
                double sum = 0;
                bool twice = false;
                for (std::size_t k = 1; k + 1 < around.size(); ++k) {
                    fan.push_back({around[apex], around[(apex + k) % around.size()],
                                   around[(apex + k + 1) % around.size()]});
                    sum += area(fan.back());
                    twice = twice || (k > 1 && is_edge(fan.back()[0], fan.back()[1]));
                }
                if (twice || sum >= least) continue;
                least = sum;
                best = std::move(fan);
            }
            if (best.empty()) return;
            closing.insert(closing.end(), best.begin(), best.end());
            gaps += least;
        }
        if (gaps <= 0.25 * whole) faces_.insert(faces_.end(), closing.begin(), closing.end());
    }

    std::vector<Vec<T, 3>> vertices_;
    std::vector<Face> faces_;
    std::size_t given_ = 0;
};

namespace detail {

/// The barycentric weights of the point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection (2005),
/// sec. 5.1.5: the regions of vertices, edges and the face).
inline std::array<double, 3> nearest_on_triangle(const Vec<double, 3>& p, const Vec<double, 3>& a,
                                                 const Vec<double, 3>& b, const Vec<double, 3>& c) noexcept {
    const auto n = cross(b - a, c - a);
    const double area2 = dot(n, n);
    if (area2 > 0) {
        const double u = dot(cross(c - b, p - b), n) / area2, v = dot(cross(a - c, p - c), n) / area2;
        if (u >= 0 && v >= 0 && u + v <= 1) return {u, v, 1 - u - v};
    }
    std::array<double, 3> best{1, 0, 0};
    double least = std::numeric_limits<double>::infinity();
    const std::array<Vec<double, 3>, 3> corner{a, b, c};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3;
        const double s = part_of_segment(p, corner[k], corner[l]);
        const auto d = corner[k] + s * (corner[l] - corner[k]) - p;
        if (dot(d, d) >= least) continue;
        least = dot(d, d);
        best = {0, 0, 0};
        best[k] = 1 - s;
        best[l] = s;
    }
    return best;
}

/// Whether the segment from `s` to `t` passes through a triangle, touching its rim included.
inline bool pierces(const Vec<double, 3>& s, const Vec<double, 3>& t, const Vec<double, 3>& a,
                    const Vec<double, 3>& b, const Vec<double, 3>& c) noexcept {
    const auto n = cross(b - a, c - a);
    const double from = dot(n, s - a), to = dot(n, t - a);
    if (!((from > 0) != (to > 0)) || from == to) return false;
    const auto p = s + (from / (from - to)) * (t - s);
    return dot(n, cross(b - a, p - a)) >= 0 && dot(n, cross(c - b, p - b)) >= 0 &&
           dot(n, cross(a - c, p - c)) >= 0;
}

} // namespace detail

/// The boundary data at the boundary place nearest to a finite point, and that place: linear on the faces of a sound mesh.
/// O(#F).
template <Scalar T>
BoundaryValue<3> nearest_boundary_value(const TriangleMesh<T>& mesh, const Vec<T, 3>& p,
                                        Vec<T, 3>& place) noexcept {
    const auto q = vec_cast<double>(p);
    double least = std::numeric_limits<double>::infinity();
    BoundaryValue<3> value;
    for (const auto& face : mesh.faces()) {
        std::array<Vec<double, 3>, 3> c;
        for (std::size_t k = 0; k < 3; ++k) c[k] = vec_cast<double>(mesh[face[k]]);
        const auto w = detail::nearest_on_triangle(q, c[0], c[1], c[2]);
        const auto x = w[0] * c[0] + w[1] * c[1] + w[2] * c[2];
        if (dot(x - q, x - q) >= least) continue;
        least = dot(x - q, x - q);
        place = vec_cast<T>(x);
        value = {{face[0], face[1], face[2], face[0]}, {w[0], w[1], w[2], 0}};
    }
    return value;
}

namespace detail {

/// Half the solid angle that a face is seen under from `q`, positive from inside (van Oosterom & Strackee 1983).
template <Scalar T>
double half_solid_angle(const TriangleMesh<T>& mesh, const typename TriangleMesh<T>::Face& face,
                        const Vec<double, 3>& q) noexcept {
    const auto a = vec_cast<double>(mesh[face[0]]) - q, b = vec_cast<double>(mesh[face[1]]) - q,
               c = vec_cast<double>(mesh[face[2]]) - q;
    const double x = length(a), y = length(b), z = length(c);
    return std::atan2(dot(a, cross(b, c)), x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
}

} // namespace detail

/// The generalised winding number: how often the mesh encloses a point, between whole numbers where the mesh has gaps
/// (Jacobson, Kavan, Sorkine-Hornung, Robust inside-outside segmentation using generalized winding numbers, SIGGRAPH 2013,
/// sec. 4). O(#F).
template <Scalar T>
double winding_number(const TriangleMesh<T>& mesh, const Vec<T, 3>& p) noexcept {
    double sum = 0;
    for (const auto& face : mesh.faces()) sum += detail::half_solid_angle(mesh, face, vec_cast<double>(p));
    return sum / (2 * std::numbers::pi);
}

/// The connected parts of a closed mesh.
struct Shells {
    std::vector<std::uint32_t> of_face;    ///< the shell of every face
    std::vector<std::uint32_t> first_face; ///< of every shell
    std::vector<double>
        volume; ///< of every shell, six times; positive where it is counter-clockwise seen from outside
    std::vector<bool>
        turned; ///< whether its faces are to be turned round to be counter-clockwise seen from outside the cage
};

/// O(#F) for one shell, O(#F · shells) for more.
template <Scalar T>
Shells shells_of(const TriangleMesh<T>& mesh) {
    std::vector<std::uint32_t> root(mesh.size());
    std::iota(root.begin(), root.end(), std::uint32_t{0});
    const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    const auto faces = mesh.faces();
    for (const auto& face : faces) root[find(face[1])] = root[find(face[2])] = find(face[0]);
    Shells shells;
    constexpr std::uint32_t unknown = ~std::uint32_t{0};
    std::vector<std::uint32_t> number(mesh.size(), unknown);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        auto& shell = number[find(faces[f][0])];
        if (shell == unknown) {
            shell = std::uint32_t(shells.first_face.size());
            shells.first_face.push_back(f);
            shells.volume.push_back(0);
        }
        shells.of_face.push_back(shell);
        const auto origin = vec_cast<double>(mesh[faces[shells.first_face[shell]][0]]);
        const auto corner = [&](std::size_t k) { return vec_cast<double>(mesh[faces[f][k]]) - origin; };
        shells.volume[shell] += dot(corner(0), cross(corner(1), corner(2)));
    }
    for (std::uint32_t s = 0; s < shells.first_face.size(); ++s) {
        // How many others enclose it.
        std::vector<double> turns(shells.first_face.size());
        const auto q = vec_cast<double>(mesh[faces[shells.first_face[s]][0]]);
        for (std::uint32_t f = 0; f < faces.size() && turns.size() > 1; ++f) {
            if (shells.of_face[f] != s)
                turns[shells.of_face[f]] +=
                    detail::half_solid_angle(mesh, faces[f], q) / (2 * std::numbers::pi);
        }
        const auto enclosing =
            std::count_if(turns.begin(), turns.end(), [](double t) { return std::fabs(t) > 0.5; });
        shells.turned.push_back((shells.volume[s] > 0) != (enclosing % 2 == 0));
    }
    return shells;
}

/// The faces, those of turned shells turned round: all counter-clockwise seen from outside the cage. Cost as `shells_of`.
template <Scalar T>
std::vector<typename TriangleMesh<T>::Face> outward_faces(const TriangleMesh<T>& mesh) {
    const auto shells = shells_of(mesh);
    std::vector<typename TriangleMesh<T>::Face> faces(mesh.faces().begin(), mesh.faces().end());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (shells.turned[shells.of_face[f]]) std::swap(faces[f][1], faces[f][2]);
    }
    return faces;
}

/// Inside where the winding number rounds to an odd one (so a cavity is outside whichever way it turns); on the boundary
/// when within `tolerance` of a face. O(#F).
template <Scalar T>
PointState locate(const TriangleMesh<T>& mesh, const Vec<T, 3>& p, T tolerance) noexcept {
    if (!is_finite(p)) return PointState::not_finite;
    Vec<T, 3> place;
    (void)nearest_boundary_value(mesh, p, place);
    if (detail::length(vec_cast<double>(place) - vec_cast<double>(p)) <= double(tolerance))
        return PointState::on_boundary;
    const double turns = std::round(winding_number(mesh, p));
    return std::fmod(std::fabs(turns), 2.0) == 1 ? PointState::inside : PointState::outside;
}

/// Whether a mesh can serve as a cage: indices in range, finite vertices, no two at one place, faces with an area, every
/// edge between two faces that walk it opposite ways (those that close a small gap included), one fan of faces about every vertex, no two faces that pass
/// through each other. What "at one place" means is coincidence_tolerance. Usually O(#F log #F), O(#F²) at worst.
template <Scalar T>
CageReport check(const TriangleMesh<T>& mesh) {
    CageReport report;
    const std::size_t count = mesh.size();
    const auto faces = mesh.faces();
    const std::size_t given = mesh.given_faces();
    if (count < 4) report.add(CageFaultKind::too_few_vertices, 0, count);
    for (std::size_t i = 0; i < count; ++i) {
        if (!is_finite(mesh[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    std::vector<bool> used(count);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (const auto i : faces[f]) {
            if (i == TriangleMesh<T>::no_vertex) {
                report.add(CageFaultKind::face_without_vertex, f);
                break;
            }
            used[i] = true;
        }
    }
    if (faces.empty() && report.status == Status::ok) report.add(CageFaultKind::no_volume, 0);
    if (report.status != Status::ok) return report;

    const double tolerance = coincidence_tolerance(bounds_of(mesh.vertices()));
    std::vector<Vec<double, 3>> at;
    for (const auto& v : mesh.vertices()) at.push_back(vec_cast<double>(v));
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return at[i][0] < at[j][0]; });
    for (std::size_t n = 0; n < count; ++n) {
        for (std::size_t m = n + 1; m < count && at[order[m]][0] - at[order[n]][0] <= tolerance; ++m) {
            if (detail::length(at[order[m]] - at[order[n]]) <= tolerance) {
                report.add(CageFaultKind::duplicate_vertices, std::min(order[n], order[m]),
                           std::max(order[n], order[m]));
            }
        }
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto a = at[faces[f][0]], b = at[faces[f][1]], c = at[faces[f][2]];
        const double longest =
            std::max({detail::length(b - a), detail::length(c - b), detail::length(a - c)});
        if (detail::length(cross(b - a, c - a)) > tolerance * longest) continue;
        if (f < given) {
            report.add(CageFaultKind::face_without_area, f);
        } else {
            report.add(CageFaultKind::open_edge, faces[f][1], faces[f][2]); // cannot be closed
        }
    }

    // Every way along an edge once, and so the other way.
    const auto ways = mesh.ways();
    for (std::size_t begin = 0, end = 0; begin < ways.size(); begin = end) {
        while (end < ways.size() && ways[end].key() == ways[begin].key()) ++end;
        const auto [low, high] = ways[begin].key();
        if (end - begin == 1) {
            report.add(CageFaultKind::open_edge, low, high);
        } else if (end - begin > 2) {
            report.add(CageFaultKind::edge_not_manifold, low, high);
        } else if (ways[begin].from == ways[begin + 1].from) {
            report.add(CageFaultKind::face_flipped, ways[begin].face, ways[begin + 1].face);
        } else if ((ways[begin].face < given) != (ways[begin + 1].face < given)) {
            report.add(CageFaultKind::gap_closed, low, high);
        }
    }
    if (report.status != Status::ok) return report;

    // About a vertex: the edges opposite to it must make one closed way.
    std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> opposite(count);
    for (const auto& face : faces) {
        for (std::size_t k = 0; k < 3; ++k)
            opposite[face[k]].push_back({face[(k + 1) % 3], face[(k + 2) % 3]});
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (opposite[i].empty()) {
            report.add(CageFaultKind::vertex_unused, i);
            continue;
        }
        auto& links = opposite[i];
        std::sort(links.begin(), links.end());
        std::size_t steps = 0;
        auto reached = links.front().first;
        do {
            reached =
                std::lower_bound(links.begin(), links.end(), std::pair(reached, std::uint32_t{0}))->second;
            ++steps;
        } while (reached != links.front().first);
        if (steps != links.size()) report.add(CageFaultKind::vertex_not_manifold, i);
    }

    // Faces that pass through each other, swept by x. Faces that share a vertex meet there rightly.
    std::vector<std::array<double, 2>> extent(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto [low, high] = std::minmax({at[faces[f][0]][0], at[faces[f][1]][0], at[faces[f][2]][0]});
        extent[f] = {low, high};
    }
    std::vector<std::size_t> sweep(faces.size());
    std::iota(sweep.begin(), sweep.end(), std::size_t{0});
    std::sort(sweep.begin(), sweep.end(),
              [&](std::size_t f, std::size_t g) { return extent[f][0] < extent[g][0]; });
    const auto passes = [&](std::size_t f, std::size_t g) { // an edge of f through g
        const auto& tip = faces[g];
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = faces[f][k], j = faces[f][(k + 1) % 3];
            const auto in_g = [&](std::uint32_t v) { return v == tip[0] || v == tip[1] || v == tip[2]; };
            if (!in_g(i) && !in_g(j) && detail::pierces(at[i], at[j], at[tip[0]], at[tip[1]], at[tip[2]]))
                return true;
        }
        return false;
    };
    for (std::size_t n = 0; n < sweep.size(); ++n) {
        for (std::size_t m = n + 1; m < sweep.size() && extent[sweep[m]][0] <= extent[sweep[n]][1]; ++m) {
            const std::size_t f = std::min(sweep[n], sweep[m]), g = std::max(sweep[n], sweep[m]);
            if (!passes(f, g) && !passes(g, f)) continue;
            if (g < given) {
                report.add(CageFaultKind::faces_cross, f, g);
            } else {
                report.add(CageFaultKind::open_edge, faces[g][1], faces[g][2]); // cannot be closed
            }
        }
    }
    if (report.status != Status::ok) return report;

    const auto shells = shells_of(mesh);
    const double size = double(bounds_of(mesh.vertices()).diagonal());
    for (std::size_t n = 0; n < shells.turned.size(); ++n) {
        if (std::fabs(shells.volume[n]) <= tolerance * size * size)
            report.add(CageFaultKind::no_volume, shells.first_face[n]);
        if (shells.turned[n]) report.add(CageFaultKind::shell_turns_otherwise, shells.first_face[n]);
    }
    return report;
}

} // namespace cageform::inline CAGEFORM_ABI
