// Where folds are tested: points with bound Jacobians, and cells of a mesh.
#pragma once

#include <cageform/clone/detail/check_clone.hpp>
#include <cageform/clone/detail/determinants.hpp>
#include <cageform/clone/detail/vector_tile.hpp>
#include <cageform/clone/types/fold_report.hpp>

#include <tuple>

namespace cageform::inline CAGEFORM_ABI::detail {

inline bool is_supported(const FoldOptions& options) noexcept {
    return is_finite(options.threshold) && options.threshold < 1;
}

/// Adds the Jacobian of a place to a report.
template <std::size_t D>
void add_to_report(FoldReport& report, const FoldOptions& options, std::size_t place,
                   const Columns<D>& jacobian) noexcept {
    const double determinant_here = determinant(jacobian);
    const auto [largest, least] = singular_values(jacobian);
    if (!is_finite(determinant_here) || !is_finite(largest)) {
        ++report.skipped;
        return;
    }
    if (!(determinant_here > options.threshold)) {
        if (report.count < report.folded.size()) report.folded[report.count] = place;
        ++report.count;
    }
    const auto keep = [place](double value, bool further, double& kept, std::size_t& at) {
        if (at != FoldReport::nowhere && !further) return;
        kept = value;
        at = place;
    };
    keep(determinant_here, determinant_here < report.least_determinant, report.least_determinant,
         report.least_determinant_at);
    keep(largest, largest > report.largest_stretch, report.largest_stretch, report.largest_stretch_at);
    keep(least, least < report.least_stretch, report.least_stretch, report.least_stretch_at);
}

/// The pose `from + t (to - from)`.
template <std::size_t D, class From, class To>
struct PoseBetween {
    const From& from;
    const To& to;
    double t;

    std::size_t size() const noexcept { return std::size(from); }
    Vec<double, D> operator[](std::size_t i) const noexcept {
        const auto start = to_vec<double>(from[i]);
        return start + t * (to_vec<double>(to[i]) - start);
    }
};

/// Points with bound Jacobians.
template <class View>
class JacobianPlaces {
public:
    using T = typename View::scalar;
    static constexpr std::size_t D = View::dimension;

    explicit JacobianPlaces(const std::array<View, D>& columns) noexcept
        : columns_(columns) {}

    /// Calls visit(point, Jacobians…) for every point, with one Jacobian per pose.
    template <class Visit, class... Poses>
    void for_each(const Visit& visit, const Poses&... poses) const noexcept {
        const PackedBindingView<T, D> layout(columns_[0]);
        const std::size_t blocks = block_count<T>(layout.points);
        std::array<std::array<Tile, D>, sizeof...(Poses)> tiles;
        for (std::size_t from = 0; from < blocks; from += Tile::blocks) {
            const std::size_t to = blocks - from < Tile::blocks ? blocks : from + Tile::blocks;
            std::size_t n = 0;
            (load(tiles[n++], poses, from, to), ...);
            for (std::size_t b = from; b < to; ++b) {
                for (std::size_t lane = 0; lane < lane_count<T>; ++lane) {
                    const std::size_t position = b * lane_count<T> + lane;
                    if (position >= layout.points) break;
                    const std::size_t point = layout.order != nullptr ? layout.order[position] : position;
                    [&]<std::size_t... P>(std::index_sequence<P...>) {
                        visit(point, jacobian(tiles[P], b, lane)...);
                    }(std::index_sequence_for<Poses...>{});
                }
            }
        }
    }

    /// Determinants of Jacobians are relative to 1.
    static double rest_volume(std::size_t) noexcept { return 1; }

private:
    using Tile = VectorTile<T, D, 8>; // up to six tiles are on the stack

    template <class Pose>
    void load(std::array<Tile, D>& tiles, const Pose& pose, std::size_t from, std::size_t to) const noexcept {
        for (std::size_t k = 0; k < D; ++k) tiles[k].load(columns_[k], pose, from, to);
    }
    static Columns<D> jacobian(const std::array<Tile, D>& tiles, std::size_t b, std::size_t lane) noexcept {
        Columns<D> result;
        for (std::size_t k = 0; k < D; ++k) {
            const auto block = tiles[k].block(b);
            result[k] = vec_cast<double>(block.at(block.moved, lane));
        }
        return result;
    }

    const std::array<View, D>& columns_;
};

/// A range whose elements are D + 1 indices each.
template <class Cells, std::size_t D>
concept SimplexRange = requires(const Cells& cells, std::size_t i) {
    { std::size(cells) } -> std::convertible_to<std::size_t>;
    requires std::tuple_size_v<std::remove_cvref_t<decltype(cells[i])>> == D + 1;
    { cells[i][0] } -> std::convertible_to<std::size_t>;
};

/// Triangles in 2D or tetrahedra in 3D.
template <class Rest, class Cells>
class CellPlaces {
public:
    static constexpr std::size_t D = range_dimension<Rest>;

    CellPlaces(const Rest& rest, const Cells& cells) noexcept
        : rest_(rest)
        , cells_(cells) {}

    /// Checks the cells at rest. Cells with a corner that is not finite pass; they are skipped later.
    Status check(std::size_t& culprit) const noexcept {
        for (std::size_t c = 0; c < std::size(cells_); ++c) {
            culprit = c;
            for (std::size_t k = 0; k <= D; ++k) {
                if (!(static_cast<std::size_t>(cells_[c][k]) < std::size(rest_)))
                    return Status::index_out_of_range;
            }
            const auto e = edges(rest_, c);
            double longest = 0, bound = 64 * double(epsilon<Number>);
            bool finite = true;
            for (const auto& edge : e) {
                finite = finite && is_finite(edge);
                longest = dot(edge, edge) > longest ? dot(edge, edge) : longest;
            }
            for (std::size_t k = 0; k < D; ++k) bound *= std::sqrt(longest);
            if (finite && !(std::fabs(determinant(e)) > bound)) return Status::degenerate_simplex;
        }
        culprit = FoldReport::nowhere;
        return Status::ok;
    }

    /// Calls visit(cell, edges…) for every cell, with the edges from its first corner in each pose.
    template <class Visit, class... Poses>
    void for_each(const Visit& visit, const Poses&... poses) const noexcept {
        for (std::size_t c = 0; c < std::size(cells_); ++c) visit(c, edges(poses, c)...);
    }

    /// Returns the determinant of a cell's edges at rest.
    double rest_volume(std::size_t cell) const noexcept { return determinant(edges(rest_, cell)); }

    /// Returns the Jacobian of a cell: E' E⁻¹.
    Columns<D> jacobian(std::size_t cell, const Columns<D>& posed) const noexcept {
        const auto e = edges(rest_, cell), inverse = cofactors(e); // times the determinant, transposed
        const double scale = 1 / determinant(e);
        Columns<D> result{};
        for (std::size_t j = 0; j < D; ++j) {
            for (std::size_t k = 0; k < D; ++k) result[j] = result[j] + (scale * inverse[k][j]) * posed[k];
        }
        return result;
    }

private:
    using Number = std::conditional_t<std::is_same_v<range_scalar_t<Rest>, float>, float, double>;

    template <class Points>
    Columns<D> edges(const Points& points, std::size_t cell) const noexcept {
        const auto corner = [&](std::size_t k) {
            return to_vec<double>(points[static_cast<std::size_t>(cells_[cell][k])]);
        };
        Columns<D> result;
        for (std::size_t k = 0; k < D; ++k) result[k] = corner(k + 1) - corner(0);
        return result;
    }

    const Rest& rest_;
    const Cells& cells_;
};

/// Checks the arguments for points.
template <class View, std::size_t D, class Pose>
Status check_jacobians(const std::array<View, D>& columns, const Pose& pose) noexcept {
    using Packed = PackedBindingView<typename View::scalar, D>;
    for (std::size_t k = 1; k < D; ++k) {
        if (!bindings_match(Packed(columns[0]), Packed(columns[k]))) return Status::bindings_differ;
    }
    return check_pose(columns[0], pose);
}

/// Checks the arguments for cells. `culprit` becomes the refused cell.
template <class Places, class Rest, class Posed>
Status check_cells(const Places& places, const FoldOptions& options, std::size_t& culprit, const Rest& rest,
                   const Posed& posed) noexcept {
    if (!is_supported(options)) return Status::threshold_not_supported;
    if (std::size(posed) != std::size(rest)) return Status::pose_size_differs;
    return places.check(culprit);
}

/// Returns the largest step without a fold, slightly shorter than the first fold.
template <class Places, class From, class To>
StepReport step_over(const Places& places, const FoldOptions& options, const From& from,
                     const To& to) noexcept {
    constexpr std::size_t D = Places::D;
    StepReport report;
    double first = no_root;
    places.for_each(
        [&](std::size_t place, const Columns<D>& start, const Columns<D>& end) {
            Columns<D> change;
            for (std::size_t k = 0; k < D; ++k) change[k] = end[k] - start[k];
            const DeterminantAlong<D> along(start, change, 1 / places.rest_volume(place), options.threshold);
            if (!along.is_finite()) return;
            const double fold = along.first_fold();
            if (!(fold < first)) return;
            first = fold;
            report.culprit = place;
        },
        from, to);
    if (first == 0) return report;
    // Determinants at the step round differently from those along the line.
    for (double margin = 1e-9;; margin *= 8) {
        report.step = first > 1 ? 1 : first * (1 - margin);
        std::size_t folded = FoldReport::nowhere;
        places.for_each(
            [&](std::size_t place, const Columns<D>& there) {
                const double ratio = determinant(there) / places.rest_volume(place);
                if (is_finite(ratio) && !(ratio > options.threshold)) folded = place;
            },
            PoseBetween<D, From, To>{from, to, report.step});
        if (folded == FoldReport::nowhere) return report;
        report.culprit = folded;
        if (first > 1) first = 1;
        if (margin > 0.1) break;
    }
    report.step = 0;
    return report;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
