// find_parts, step 4: selects compatible joints and numbers the parts.
#pragma once

#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/enclose/find_parts.hpp>
#include <cageform/enclose/parts_of_faces.hpp>
#include <cageform/enclose/space/mesh_mirror.hpp>
#include <cageform/enclose/space/part_cut.hpp>
#include <cageform/enclose/space/part_sweep.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Selects regions of a cage that are cut off by a joint, or are a whole shell. Selected regions are nested
/// or disjoint.
class PartFinder {
public:
    using Point = Vec<double, 3>;

    PartFinder(std::span<const Point> points, std::span<const MeshFace> faces)
        : points_(points)
        , faces_(faces)
        , mirror_(mirror_of(points, faces))
        , costs_(points, faces, mirror_ ? mirror_->vertices : MirrorImages{})
        , adjacent_(faces.size()) {
        for (const auto& edge : costs_.edges()) {
            adjacent_[edge.one].push_back(edge.other);
            adjacent_[edge.other].push_back(edge.one);
        }
        for (const auto& face : faces) areas_.push_back(length(area_normal(points, face)) / 2);
    }

    CageParts find() {
        find_shells();
        drop_short_branches();
        for (;;) { // drop parts without a vertex
            auto parts = parts_of_faces(faces_, points_.size(), numbers());
            const auto bare = std::find_if(parts.parts.begin(), parts.parts.end(),
                                           [](const CagePart& part) { return part.vertices.empty(); });
            if (bare == parts.parts.end()) return parts;
            drop(region_to_drop(bare->number));
        }
    }

private:
    using Faces = std::vector<bool>; // flag per face
    static constexpr std::size_t none = ~std::size_t{0};

    struct Region {
        Faces has;
        double size = 0, compactness = 0;
        std::size_t image = none; // itself if symmetric
        bool is_shell = false;
        int number = 0;
    };

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
    /// Connected components of a set, largest first.
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
                for (const std::size_t g : adjacent_[f]) {
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

    /// Returns the largest component of a set, with its holes filled. Its holes are all pieces of the rest of
    /// the shell except the largest piece.
    Faces filled(const Faces& set, const Faces& shell) const {
        auto pieces = pieces_of(set);
        if (pieces.empty()) return set;
        const auto rest = pieces_of(without(shell, pieces[0]));
        return rest.empty() ? shell : without(shell, rest[0]);
    }

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
            auto found = regions_in(shell, image == whole);
            std::stable_sort(found.begin(), found.end(),
                             [](const Region& p, const Region& q) { return p.compactness > q.compactness; });
            for (Region& region : found) add_if_compatible(std::move(region), shell, image == whole);
        }
    }

    /// Copies the regions of a shell to its mirror image.
    void add_images(std::size_t shell, std::size_t whole) {
        const Faces within = kept_[shell].has;
        for (std::size_t n = 0; n < whole; ++n) {
            if (kept_[n].is_shell || size_of(common(kept_[n].has, within)) == 0) continue;
            Region image = kept_[n];
            image.has = image_of(image.has);
            kept_[n].image = kept_.size();
            image.image = n;
            kept_.push_back(std::move(image));
        }
    }

    /// All regions that joints cut off in a shell; one of each mirrored pair.
    std::vector<Region> regions_in(const Faces& shell, bool is_mirrored) const {
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

        // Bumps below a fiftieth of the size are not limbs.
        const double least = 0.02 * std::sqrt(surface.total_area());
        const auto tips = extremities(surface, mean_distances(surface), least, 64);
        std::vector<Region> found;
        for (const auto tip : tips) {
            const auto image = surface.image(tip);
            const bool is_pair = image != tip && std::find(tips.begin(), tips.end(), image) != tips.end();
            if (is_pair && image < tip) continue;
            const bool is_own = is_mirrored && !is_pair;
            auto distance = surface.distances(std::array{tip, is_own ? image : tip});
            if (is_own) surface.make_symmetric(distance);
            for (const SweptJoint& joint : swept_joints(surface, distance)) {
                Region area;
                area.has = filled(cut(joint, surface, distance, whole), shell);
                if (is_pair) // faces common to the region and its image belong to neither
                    area.has = filled(without(area.has, image_of(area.has)), shell);
                if (is_own && image_of(area.has) != area.has) continue;
                area.image = is_own ? found.size() : none;
                measure(area);
                if (area.size <= 0.5 * surface.total_area()) found.push_back(std::move(area));
            }
        }
        return found;
    }

    void measure(Region& area) const {
        area.size = size_of(area.has);
        const double border = border_of(area.has);
        area.compactness = border > 0 ? 4 * std::numbers::pi * area.size / (border * border) : 0;
    }

    /// Faces on the extremity's side of the minimum cut between the fronts before and behind a joint.
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
            sides[f] = swept[f] || has_tip[f] ? CutSide::limb
                       : passed[f]            ? CutSide::rest
                                              : CutSide::undecided;
        const CheapestCut cheapest(costs_.edges(), sides);
        Faces limb(faces_.size());
        for (const auto f : whole) limb[f] = cheapest.is_limb(f);
        return limb;
    }

    /// Keeps a region (and its image) if it is compatible with those kept before, which are more compact. If
    /// two are nearly nested or nearly disjoint, the new one is adjusted.
    void add_if_compatible(Region area, const Faces& shell, bool is_mirrored) {
        for (const Region& other : kept_) {
            if (other.is_shell) continue;
            const double both = size_of(common(area.has, other.has));
            if (both == 0) continue;
            const double less = (std::min)(area.size, other.size), more = (std::max)(area.size, other.size);
            if (both > 0.7 * more) return; // the same region found again
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
        Region image = area;
        if (is_mirrored) image.has = image_of(area.has);
        if (is_pair ? size_of(common(area.has, image.has)) > 0 : is_mirrored && image.has != area.has) return;
        for (const Region& other : kept_) {
            for (const Region* one : {&area, &image}) {
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

    /// Drops regions with branches (an arm with fingers, a neck with head and antlers). Keeps such a region
    /// if it is long without its branches and no more than 40 % of its shell. A body below the arms, which
    /// has two legs, is not a limb.
    void drop_short_branches() {
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
            for (const Region& whole : kept_)
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
        for (Region& area : kept_) {
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

    /// The region to drop if part `number` has no vertex: this region or, for a whole shell, the least
    /// compact region.
    std::size_t region_to_drop(int number) const {
        std::size_t worst = none;
        for (std::size_t n = 0; n < kept_.size(); ++n) {
            if (kept_[n].number == number && !kept_[n].is_shell) return n;
            if (!kept_[n].is_shell && (worst == none || kept_[n].compactness < kept_[worst].compactness))
                worst = n;
        }
        return worst;
    }

    /// Part number of each face: that of the smallest region that contains it.
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
    std::vector<std::vector<std::size_t>> adjacent_; // adjacent faces
    std::vector<double> areas_;
    std::vector<Region> kept_; // the largest shell first
};

template <class T>
CageParts parts_of_cage(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces) {
    std::vector<Vec<double, 3>> points;
    for (const auto& p : vertices) points.push_back(vec_cast<double>(p));
    return PartFinder(points, faces).find();
}

} // namespace cageform::inline CAGEFORM_ABI::detail
