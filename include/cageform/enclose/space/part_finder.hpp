// Step 4 of find_parts: keeps the joints that fit together, and numbers the parts.
#pragma once

#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/enclose/find_parts.hpp>
#include <cageform/enclose/parts_of_faces.hpp>
#include <cageform/enclose/space/mesh_mirror.hpp>
#include <cageform/enclose/space/part_cut.hpp>
#include <cageform/enclose/space/part_sweep.hpp>

#include <numeric>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Areas of a cage that a joint cuts off, or that are a whole shell. Two of those kept are disjoint, or one
/// has all faces of the other.
class PartFinder {
public:
    using Point = Vec<double, 3>;

    PartFinder(std::span<const Point> points, std::span<const MeshFace> faces)
        : points_(points)
        , faces_(faces)
        , mirror_(mirror_of(points, faces))
        , costs_(points, faces, mirror_ ? mirror_->vertices : MirrorImages{})
        , around_(faces.size()) {
        for (const auto& edge : costs_.edges()) {
            around_[edge.one].push_back(edge.other);
            around_[edge.other].push_back(edge.one);
        }
        for (const auto& [a, b, c] : faces) {
            const Point across = cross(points[b] - points[a], points[c] - points[a]);
            areas_.push_back(std::sqrt(dot(across, across)) / 2);
        }
    }

    CageParts find() {
        find_shells();
        keep_long_areas();
        for (;;) { // a part without a vertex of its own is none
            auto parts = parts_of_faces(faces_, points_.size(), numbers());
            const auto bare = std::find_if(parts.parts.begin(), parts.parts.end(),
                                           [](const CagePart& part) { return part.vertices.empty(); });
            if (bare == parts.parts.end()) return parts;
            drop(worst_of(bare->number));
        }
    }

private:
    using Faces = std::vector<bool>; // #faces
    static constexpr std::size_t none = ~std::size_t{0};

    struct Area {
        Faces has;
        double size = 0, compactness = 0;
        std::size_t image = none; // its own number where it is its own image
        bool is_shell = false;
        int number = 0;
    };

    // ---- sets of faces ----------------------------------------------------------------------------

    double size_of(const Faces& set) const {
        double sum = 0;
        for (std::size_t f = 0; f < set.size(); ++f) sum += set[f] ? areas_[f] : 0;
        return sum;
    }
    double border_of(const Faces& set) const {
        double sum = 0;
        for (const auto& edge : costs_.edges()) sum += set[edge.one] != set[edge.other] ? edge.length : 0;
        return sum;
    }
    Faces image_of(const Faces& set) const {
        if (!mirror_) return set;
        Faces image(set.size());
        for (std::size_t f = 0; f < set.size(); ++f) image[mirror_->faces[f]] = set[f];
        return image;
    }
    /// The connected pieces of a set, the largest first.
    std::vector<Faces> pieces_of(const Faces& set) const {
        std::vector<std::pair<double, Faces>> pieces;
        Faces seen(set.size());
        std::vector<std::size_t> stack;
        for (std::size_t start = 0; start < set.size(); ++start) {
            if (!set[start] || seen[start]) continue;
            pieces.push_back({0, Faces(set.size())});
            auto& [size, piece] = pieces.back();
            seen[start] = true;
            stack.push_back(start);
            while (!stack.empty()) {
                const std::size_t f = stack.back();
                stack.pop_back();
                piece[f] = true;
                size += areas_[f];
                for (const std::size_t g : around_[f]) {
                    if (!set[g] || seen[g]) continue;
                    seen[g] = true;
                    stack.push_back(g);
                }
            }
        }
        std::stable_sort(pieces.begin(), pieces.end(),
                         [](const auto& p, const auto& q) { return p.first > q.first; });
        std::vector<Faces> sets;
        sets.reserve(pieces.size());
        for (auto& [size, piece] : pieces) sets.push_back(std::move(piece));
        return sets;
    }
    template <class Rule>
    Faces combined(const Faces& p, const Faces& q, Rule rule) const {
        Faces both(p.size());
        for (std::size_t f = 0; f < p.size(); ++f) both[f] = rule(bool(p[f]), bool(q[f]));
        return both;
    }
    Faces common(const Faces& p, const Faces& q) const {
        return combined(p, q, [](bool a, bool b) { return a && b; });
    }
    Faces without(const Faces& p, const Faces& q) const {
        return combined(p, q, [](bool a, bool b) { return a && !b; });
    }

    /// The largest piece of a set, with the holes that it has in a shell: what it cuts off from the largest
    /// rest.
    Faces filled(const Faces& set, const Faces& shell) const {
        auto pieces = pieces_of(set);
        if (pieces.empty()) return set;
        const auto rest = pieces_of(without(shell, pieces[0]));
        return rest.empty() ? shell : without(shell, rest[0]);
    }

    // ---- joints -----------------------------------------------------------------------------------

    void find_shells() {
        for (Faces& shell : pieces_of(Faces(faces_.size(), true))) {
            const std::size_t whole = kept_.size();
            kept_.push_back({shell, size_of(shell), 0, none, true, 0});
            std::size_t image = none;
            if (mirror_) {
                const auto face = std::size_t(std::find(shell.begin(), shell.end(), true) - shell.begin());
                for (std::size_t n = 0; n <= whole; ++n) {
                    if (kept_[n].is_shell && kept_[n].has[mirror_->faces[face]]) image = n;
                }
                if (image != none) {
                    kept_[whole].image = image;
                    kept_[image].image = whole;
                }
            }
            if (image != none && image != whole) {
                add_images(image, whole);
                continue;
            }
            auto found = areas_in(shell, image == whole);
            std::vector<std::size_t> order(found.size());
            std::iota(order.begin(), order.end(), std::size_t{0});
            std::stable_sort(order.begin(), order.end(), [&](std::size_t p, std::size_t q) {
                return found[p].compactness > found[q].compactness;
            });
            for (const std::size_t n : order) keep(std::move(found[n]), shell, image == whole);
        }
    }

    /// Copies the areas of a shell to the image of that shell.
    void add_images(std::size_t shell, std::size_t whole) {
        const Faces within = kept_[shell].has;
        for (std::size_t n = 0; n < whole; ++n) {
            if (kept_[n].is_shell || size_of(common(kept_[n].has, within)) == 0) continue;
            Area image = kept_[n];
            image.has = image_of(image.has);
            kept_[n].image = kept_.size();
            image.image = n;
            kept_.push_back(std::move(image));
        }
    }

    /// All areas that joints cut off in a shell; one of each pair of images.
    std::vector<Area> areas_in(const Faces& shell, bool is_mirrored) const {
        std::vector<Point> points;
        std::vector<MeshFace> faces;
        std::vector<std::uint32_t> number(points_.size(), no_vertex), vertices, whole;
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            if (!shell[f]) continue;
            whole.push_back(f);
            MeshFace& face = faces.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const auto v = faces_[f][k];
                if (number[v] == no_vertex) {
                    number[v] = std::uint32_t(points.size());
                    points.push_back(points_[v]);
                    vertices.push_back(v);
                }
                face[k] = number[v];
            }
        }
        constexpr std::size_t fewest = 10; // vertices of a shell with a limb
        if (points.size() < fewest) return {};
        MirrorImages images;
        for (std::size_t n = 0; mirror_ && is_mirrored && n < vertices.size(); ++n)
            images.push_back(number[mirror_->vertices[vertices[n]]]);
        const PartSurface surface(std::move(points), std::move(faces), std::move(images));

        // Bumps below a fiftieth of the size are no limbs.
        const double least = 0.02 * std::sqrt(surface.total_area());
        const auto tips = extremities(surface, mean_distances(surface), least, 64);
        std::vector<Area> found;
        for (const auto tip : tips) {
            const auto image = surface.image(tip);
            const bool is_pair = image != tip && std::find(tips.begin(), tips.end(), image) != tips.end();
            if (is_pair && image < tip) continue;
            const bool is_own = is_mirrored && !is_pair;
            auto distance = surface.distances(std::array{tip, is_own ? image : tip});
            if (is_own) surface.make_symmetric(distance);
            for (const SweptJoint& joint : swept_joints(surface, distance)) {
                Area area;
                area.has = filled(cut(joint, surface, distance, whole), shell);
                if (is_pair) // what both have is of neither
                    area.has = filled(without(area.has, image_of(area.has)), shell);
                if (is_own && image_of(area.has) != area.has) continue;
                area.image = is_own ? found.size() : none;
                measure(area);
                if (area.size <= 0.5 * surface.total_area()) found.push_back(std::move(area));
            }
        }
        return found;
    }

    void measure(Area& area) const {
        area.size = size_of(area.has);
        const double border = border_of(area.has);
        area.compactness = border > 0 ? 4 * std::numbers::pi * area.size / (border * border) : 0;
    }

    /// The cheapest cut between the fronts before and behind a joint: its faces on the extremity's side.
    Faces cut(const SweptJoint& joint, const PartSurface& surface, const std::vector<double>& distance,
              std::span<const std::uint32_t> whole) const {
        std::vector<char> swept(faces_.size(), 1), passed(faces_.size(), 1), has_tip(faces_.size());
        for (std::size_t f = 0; f < surface.faces().size(); ++f) {
            const auto of = whole[surface.origin(f)];
            for (const auto v : surface.faces()[f]) {
                if (joint.before.rest[v]) swept[of] = 0;
                if (!joint.behind.rest[v]) passed[of] = 0;
                if (distance[v] == 0) has_tip[of] = 1;
            }
        }
        std::vector<CutSide> sides(faces_.size(), CutSide::rest);
        for (const auto f : whole)
            sides[f] = swept[f] || has_tip[f] ? CutSide::limb : passed[f] ? CutSide::rest : CutSide::open;
        const CheapestCut cheapest(costs_.edges(), sides);
        Faces limb(faces_.size());
        for (const auto f : whole) limb[f] = cheapest.is_limb(f);
        return limb;
    }

    // ---- a choice of them -------------------------------------------------------------------------

    /// Keeps an area, and its image, if it goes with those kept before, which are more compact. Where two are
    /// nearly nested or disjoint, the later one gives way.
    void keep(Area area, const Faces& shell, bool is_mirrored) {
        for (const Area& other : kept_) {
            if (other.is_shell) continue;
            const double both = size_of(common(area.has, other.has));
            if (both == 0) continue;
            const double less = (std::min)(area.size, other.size), more = (std::max)(area.size, other.size);
            if (both > 0.7 * more) return; // the same area, found again
            if (both >= 0.9 * less)
                area.has = area.size < other.size
                               ? common(area.has, other.has)
                               : combined(area.has, other.has, [](bool a, bool b) { return a || b; });
            else if (both <= 0.1 * less)
                area.has = without(area.has, other.has);
            else
                return;
            measure(area);
        }
        if (area.compactness < least_compactness || filled(area.has, shell) != area.has) return;
        const bool is_pair = is_mirrored && area.image == none;
        Area image = area;
        if (is_mirrored) image.has = image_of(area.has);
        if (is_pair ? size_of(common(area.has, image.has)) > 0 : is_mirrored && image.has != area.has) return;
        for (const Area& other : kept_) {
            for (const Area* one : {&area, &image}) {
                const Faces both = common(one->has, other.has);
                if (size_of(both) > 0 && both != one->has && both != other.has) return;
                if (!other.is_shell && one->has == other.has) return;
            }
        }
        const std::size_t n = kept_.size();
        area.image = is_pair ? n + 1 : is_mirrored ? n : none;
        image.image = n;
        kept_.push_back(std::move(area));
        if (is_pair) kept_.push_back(std::move(image));
    }

    /// A limb with branches, such as an arm with fingers or a neck with a head and antlers, is long itself
    /// and not most of its shell: a body below the arms, which has two legs, is no limb.
    void keep_long_areas() {
        std::vector<std::size_t> order;
        for (std::size_t n = 0; n < kept_.size(); ++n) {
            if (!kept_[n].is_shell) order.push_back(n);
        }
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t p, std::size_t q) { return kept_[p].size < kept_[q].size; });
        std::vector<bool> dropped(kept_.size());
        std::vector<std::size_t> settled;
        for (const std::size_t n : order) {
            if (dropped[n]) continue;
            Faces own = kept_[n].has;
            double shell = 0;
            for (const Area& whole : kept_)
                shell += whole.is_shell && size_of(common(whole.has, own)) > 0 ? whole.size : 0;
            for (const std::size_t inner : settled) {
                if (size_of(common(kept_[inner].has, kept_[n].has)) > 0) own = without(own, kept_[inner].has);
            }
            const double share = size_of(own) / kept_[n].size;
            if (share < 1 && (share * kept_[n].compactness < 3.5 || kept_[n].size > 0.4 * shell)) {
                dropped[n] = true;
                if (kept_[n].image != none) dropped[kept_[n].image] = true;
            } else {
                settled.push_back(n);
            }
        }
        for (std::size_t n = kept_.size(); n-- > 0;) {
            if (dropped[n]) erase(n);
        }
    }

    void erase(std::size_t n) {
        kept_.erase(kept_.begin() + std::ptrdiff_t(n));
        for (Area& area : kept_) {
            if (area.image == none) continue;
            if (area.image == n)
                area.image = none;
            else if (area.image > n)
                --area.image;
        }
    }
    void drop(std::size_t n) {
        const std::size_t image = kept_[n].image;
        erase((std::max)(n, image == none ? n : image));
        if (image != none && image != n) erase((std::min)(n, image));
    }

    /// The area to give up where a part has no vertex: this one, or of a whole shell the least compact limb.
    std::size_t worst_of(int number) const {
        std::size_t worst = none;
        for (std::size_t n = 0; n < kept_.size(); ++n) {
            if (kept_[n].number == number && !kept_[n].is_shell) return n;
            if (!kept_[n].is_shell && (worst == none || kept_[n].compactness < kept_[worst].compactness))
                worst = n;
        }
        return worst;
    }

    // ---- numbers ----------------------------------------------------------------------------------

    /// The number of each face's part, which is the least area that has the face.
    std::vector<int> numbers() {
        std::vector<std::size_t> of(faces_.size(), none);
        for (std::size_t n = 0; n < kept_.size(); ++n) {
            for (std::size_t f = 0; f < of.size(); ++f) {
                if (kept_[n].has[f] && (of[f] == none || kept_[n].size < kept_[of[f]].size)) of[f] = n;
            }
        }
        std::vector<double> own(kept_.size()), moment(kept_.size());
        for (std::size_t f = 0; f < of.size(); ++f) {
            own[of[f]] += areas_[f];
            for (const auto v : faces_[f])
                moment[of[f]] += mirror_ ? areas_[f] * (points_[v][mirror_->axis] - mirror_->position) : 0;
        }
        std::vector<std::size_t> images(kept_.size());
        for (std::size_t n = 0; n < kept_.size(); ++n)
            images[n] = kept_[n].image == none ? n : kept_[n].image;
        const auto given = part_numbers(own, images, moment, [](std::size_t n) { return n == 0; });
        for (std::size_t n = 0; n < kept_.size(); ++n) kept_[n].number = given[n];
        std::vector<int> list(of.size());
        for (std::size_t f = 0; f < of.size(); ++f) list[f] = kept_[of[f]].number;
        return list;
    }

    std::span<const Point> points_;
    std::span<const MeshFace> faces_;
    std::optional<MeshMirror> mirror_;
    EdgeCosts costs_;
    std::vector<std::vector<std::size_t>> around_; // the faces beside each
    std::vector<double> areas_;
    std::vector<Area> kept_; // the largest shell first
};

template <class T>
CageParts parts_of_cage(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces) {
    std::vector<Vec<double, 3>> points;
    for (const auto& p : vertices) points.push_back(vec_cast<double>(p));
    return PartFinder(points, faces).find();
}

} // namespace cageform::inline CAGEFORM_ABI::detail
