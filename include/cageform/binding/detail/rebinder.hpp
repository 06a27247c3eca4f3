// Finds the weights of a changed figure. Copies those of old points at the same position, and
// interpolates the others from the nearest old points.
#pragma once

#include <cageform/binding/binding.hpp>
#include <cageform/binding/detail/bind_input.hpp>
#include <cageform/binding/detail/linear_shares.hpp>
#include <cageform/binding/detail/piece_measures.hpp>
#include <cageform/binding/detail/point_tree.hpp>
#include <cageform/binding/types/rebind_options.hpp>
#include <cageform/core/affine/linear_restorer.hpp>
#include <cageform/core/detail/huge_pages.hpp>
#include <cageform/core/detail/in_parallel.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/running.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The working state of one rebind.
template <Scalar T, std::size_t D>
class Rebinder {
public:
    Rebinder(const BindingView<T, D>& old, const PointReader<T>& points, const RebindOptions& options,
             const Running& running)
        : old_(old)
        , points_(points)
        , options_(options)
        , running_(running)
        , handles_(old.handle_view())
        , restorer_(handles_, is_mostly_zero(old))
        , count_(points.size)
        , neighbours_(options.neighbours == 0 ? 4 * D : (std::max)(options.neighbours, D + 1)) {}

    Status run(Binding<T, D>& binding, RebindReport& report) {
        if (count_ > 0 && old_.point_count() == 0) return Status::binding_empty;
        const std::size_t blocks = block_count<T>(count_);
        std::vector<Lanes<T>> weights, rest(blocks * D);
        resize_large(weights, blocks * handles_.count);
        weights_ = {weights.data(), handles_.count, count_};
        rest_ = {rest.data(), D, count_};
        Status status = look_at_old(report);
        if (status != Status::ok) return status;
        sources_.assign(count_, none);
        kinds_.assign(count_, Kind::interpolated);
        status = for_each_block(blocks, running_.part(0.2, 0.4), [this](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) match(b);
        });
        if (status != Status::ok) return status;
        if (std::find(kinds_.begin(), kinds_.end(), Kind::interpolated) != kinds_.end()) plant_tree();
        pieces_.assign((blocks + piece_blocks - 1) / piece_blocks, {});
        status = for_each_block(pieces_.size(), running_.part(0.4, 1),
                                [this, blocks](std::size_t begin, std::size_t end) {
                                    Scratch scratch;
                                    for (std::size_t piece = begin; piece < end; ++piece) {
                                        const std::size_t first = piece * piece_blocks;
                                        const std::size_t last = (std::min)(first + piece_blocks, blocks);
                                        for (std::size_t b = first; b < last; ++b)
                                            fill(b, pieces_[piece], scratch);
                                    }
                                });
        if (status != Status::ok) return status;
        gather(report);
        binding = Binding<T, D>(std::move(weights), std::move(rest), handles_, count_);
        return Status::ok;
    }

private:
    static constexpr std::size_t lanes = lane_count<T>;
    static constexpr std::size_t piece_blocks = 4;
    static constexpr std::size_t none = Extreme::none;
    using Tree = PointTree<D>;

    /// Returns whether coordinates are local. If so, restoring linear precision keeps their zeros.
    static bool is_mostly_zero(const BindingView<T, D>& binding) noexcept {
        std::size_t zeros = 0;
        for (std::size_t i = 0; i < binding.point_count(); ++i) {
            for (std::size_t h = 0; h < binding.handle_count(); ++h)
                zeros += binding.weights(i, h) == T(0) ? 1 : 0;
        }
        return 2 * zeros > binding.point_count() * binding.handle_count();
    }

    enum class Kind : std::uint8_t { matched, interpolated, distant, kept_in_place, not_finite, unreached };

    struct Piece {
        BindPiece measures;
        Extreme distance;
    };
    /// Where the weights of a new point are written.
    struct Slot {
        std::size_t point;
        Lanes<T>* rows;
        std::size_t lane;
    };
    struct Scratch {
        std::vector<typename Tree::Neighbour> found, around;
        std::vector<Vec<double, D>> places;
        LinearShares<D> shares;
        std::vector<double> row;
    };

    Vec<T, D> old_point(std::size_t i) const { return block_point<D>(old_.rest, i); }
    /// Scales by a power of two, which is exact; old points are then of order one.
    Vec<double, D> in_units(const Vec<T, D>& p) const { return unit_ * vec_cast<double>(p); }

    /// Finds the old points that are bound, and lists their distinct positions in `places_`, ascending.
    Status look_at_old(RebindReport& report) {
        const std::size_t count = old_.point_count(), blocks = block_count<T>(count);
        bound_.assign(count, 0);
        std::vector<char> sound(count, 1);
        const auto look = [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin * lanes; i < (std::min)(end * lanes, count); ++i) {
                for (std::size_t h = 0; h < handles_.count; ++h) {
                    const T w = old_.weights(i, h);
                    if (w != T(0)) bound_[i] = 1;
                    if (!is_finite(w)) sound[i] = 0;
                }
            }
        };
        const Status status = for_each_block(blocks, running_.part(0, 0.2), look);
        if (status != Status::ok) return status;
        const auto spoilt = std::find(sound.begin(), sound.end(), char{0});
        if (spoilt != sound.end()) {
            report.culprit = std::size_t(spoilt - sound.begin());
            return Status::weight_not_finite;
        }

        double magnitude = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const auto p = old_point(i);
            if (!is_finite(p)) continue;
            places_.push_back(i);
            for (std::size_t k = 0; k < D; ++k) magnitude = (std::max)(magnitude, std::fabs(double(p[k])));
        }
        std::sort(places_.begin(), places_.end(), [this](std::size_t a, std::size_t b) {
            const auto p = old_point(a), q = old_point(b);
            return p != q ? before(p, q) : a < b;
        });
        const auto same = [this](std::size_t a, std::size_t b) { return old_point(a) == old_point(b); };
        places_.erase(std::unique(places_.begin(), places_.end(), same), places_.end());
        int exponent = 0;
        std::frexp(magnitude, &exponent);
        unit_ = std::ldexp(1.0, std::clamp(-exponent, -1000, 1000));
        return Status::ok;
    }

    static bool before(const Vec<T, D>& p, const Vec<T, D>& q) noexcept {
        return std::lexicographical_compare(p.v, p.v + D, q.v, q.v + D);
    }

    /// Reads the user's points and finds old points at the same positions; the old point with the
    /// same number is preferred.
    void match(std::size_t block) {
        points_.read(block, rest_.block(block));
        for (std::size_t i = block * lanes; i < (std::min)((block + 1) * lanes, count_); ++i) {
            const auto p = block_point<D>(rest_, i);
            if (!is_finite(p)) {
                kinds_[i] = Kind::not_finite;
                continue;
            }
            if (i < old_.point_count() && old_point(i) == p) {
                sources_[i] = i;
            } else {
                const auto at = std::lower_bound(
                    places_.begin(), places_.end(), p,
                    [this](std::size_t a, const Vec<T, D>& q) { return before(old_point(a), q); });
                if (at == places_.end() || old_point(*at) != p) continue;
                sources_[i] = *at;
            }
            kinds_[i] = Kind::matched;
        }
    }

    void plant_tree() {
        std::vector<Vec<double, D>> points;
        points.reserve(places_.size());
        for (const std::size_t i : places_) points.push_back(in_units(old_point(i)));
        tree_ = Tree(points);
        any_kept_ =
            std::any_of(places_.begin(), places_.end(), [this](std::size_t i) { return bound_[i] == 0; });
    }

    /// Fills all weights of a block. Copied weights are written last, because restoring would
    /// change their bits.
    void fill(std::size_t block, Piece& piece, Scratch& scratch) {
        Lanes<T>* const rows = weights_.block(block);
        Lanes<T> target[D], bound;
        bool any = false;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = block * lanes + lane;
            clear(rows, lane);
            // Lanes without weights get some finite target.
            Vec<T, D> place = handles_.count == 0 ? Vec<T, D>{} : handles_.rest[0];
            bound[lane] = T(0);
            if (i < count_ && kinds_[i] == Kind::interpolated) {
                kinds_[i] = interpolate({i, rows, lane}, place, piece, scratch);
                if (is_interpolated(kinds_[i])) bound[lane] = T(1);
                any = any || is_interpolated(kinds_[i]);
            }
            for (std::size_t k = 0; k < D; ++k) target[k][lane] = place[k];
        }
        if (any) {
            const auto outcome = restorer_.run(target, bound, rows, true);
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const std::size_t i = block * lanes + lane;
                if (bound[lane] == T(0)) continue;
                if (is_finite(outcome.partition[lane]) && is_finite(outcome.reproduction[lane])) continue;
                kinds_[i] = Kind::unreached;
                bound[lane] = T(0);
            }
            PieceMeasures<T> measures(block * lanes);
            measures.note(outcome, bound, block);
            measures.put_into(piece.measures);
        }
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = block * lanes + lane;
            if (i < count_ && is_interpolated(kinds_[i])) continue;
            clear(rows, lane);
            if (i >= count_ || kinds_[i] != Kind::matched) continue;
            for (std::size_t h = 0; h < handles_.count; ++h) rows[h][lane] = old_.weights(sources_[i], h);
        }
    }

    static bool is_interpolated(Kind kind) noexcept {
        return kind == Kind::interpolated || kind == Kind::distant;
    }

    void clear(Lanes<T>* rows, std::size_t lane) const noexcept {
        for (std::size_t h = 0; h < handles_.count; ++h) rows[h][lane] = T(0);
    }

    /// Writes the weights of a point, and writes to `target` the point that they must reproduce.
    Kind interpolate(const Slot& slot, Vec<T, D>& target, Piece& piece, Scratch& scratch) const {
        const auto place = block_point<D>(BlockView<const T>(rest_), slot.point);
        const Vec<double, D> p = in_units(place);
        const auto any = [](std::size_t) { return true; };
        const auto is_bound = [this](std::size_t n) { return bound_[places_[n]] != 0; };
        auto& found = scratch.found;
        if (any_kept_) {
            tree_.nearest(p, 1, any, found);
            if (found.empty() || !is_bound(found[0].point)) return Kind::kept_in_place;
        }
        tree_.nearest(p, neighbours_ + 1, is_bound, found);
        if (found.empty()) return Kind::kept_in_place;
        if (!is_finite(found.back().squared)) return Kind::unreached;

        tree_.nearest(in_units(old_point(places_[found[0].point])), D + 1, any, scratch.around);
        const double spacing = std::sqrt(scratch.around.back().squared),
                     distance = std::sqrt(found[0].squared);

        const double radius = std::sqrt(found.back().squared);
        if (found.size() > neighbours_) found.pop_back();
        scratch.places.clear();
        for (const auto& n : found) scratch.places.push_back(in_units(old_point(places_[n.point])) - p);
        scratch.shares.compute(scratch.places, radius, 8 * double(epsilon<T>));
        scratch.row.assign(handles_.count, 0.0);
        // Σ s q minus the point: 0 unless the old points leave slopes undetermined.
        Vec<double, D> reached{};
        for (std::size_t j = 0; j < found.size(); ++j) {
            const double share = scratch.shares[j];
            const std::size_t source = places_[found[j].point];
            reached = reached + share * scratch.places[j];
            for (std::size_t h = 0; h < handles_.count; ++h)
                scratch.row[h] += share * double(old_.weights(source, h));
        }
        // If the old weights reproduce points offset from their own, by more than rounding, so do
        // the new ones: points outside the cage follow the boundary at an offset.
        Vec<double, D> offset = reached + p;
        Vec<double, D> rounding{};
        for (std::size_t h = 0; h < handles_.count; ++h) {
            const auto part = (scratch.row[h] * unit_) * vec_cast<double>(handles_.rest[h]);
            offset = offset - part;
            for (std::size_t k = 0; k < D; ++k) rounding[k] += std::fabs(part[k]);
            slot.rows[h][slot.lane] = static_cast<T>(scratch.row[h]);
        }
        const double size = length(p) + length(rounding);
        target = place;
        if (length(offset) > 64 * double(epsilon<T>) * size)
            target = vec_cast<T>(vec_cast<double>(place) - (1 / unit_) * offset);
        piece.distance.raise({distance / spacing, slot.point});
        return distance <= options_.largest_distance * spacing ? Kind::interpolated : Kind::distant;
    }

    void gather(RebindReport& report) const {
        for (const Piece& piece : pieces_) {
            report.distance.raise(piece.distance);
            report.partition_error.raise(piece.measures.partition);
            report.reproduction_error.raise(piece.measures.reproduction);
            report.weight_change.raise(piece.measures.change);
            report.residual_restored.raise(piece.measures.before);
            report.least_weight.lower(piece.measures.least);
        }
        for (std::size_t i = 0; i < count_; ++i) {
            if (is_interpolated(kinds_[i])) ++report.interpolated;
            switch (kinds_[i]) {
            case Kind::interpolated: break;
            case Kind::distant: report.distant.push_back(i); break;
            case Kind::kept_in_place: report.kept_in_place.push_back(i); break;
            case Kind::not_finite: report.not_finite.push_back(i); break;
            case Kind::unreached: report.unreached.push_back(i); break;
            case Kind::matched:
                ++report.matched;
                if (bound_[sources_[i]] == 0) report.kept_in_place.push_back(i);
                break;
            }
        }
    }

    const BindingView<T, D>& old_;
    const PointReader<T>& points_;
    const RebindOptions& options_;
    const Running& running_;
    HandleView<T, D> handles_;
    LinearRestorer<T, D> restorer_;
    std::size_t count_, neighbours_;
    BlockView<T> weights_, rest_;
    std::vector<char> bound_;          // of old points: some weight is not zero
    std::vector<std::size_t> places_;  // old points, one per distinct finite position, ascending
    double unit_ = 1;                  // a power of two
    Tree tree_;                        // of places_
    bool any_kept_ = false;            // whether any of these is kept in place
    std::vector<std::size_t> sources_; // the old points at the positions of new ones
    std::vector<Kind> kinds_;
    std::vector<Piece> pieces_;
};

template <Scalar T, std::size_t D>
Result<Binding<T, D>, RebindReport> rebind_points(const BindingView<T, D>& binding,
                                                  const PointReader<T>& points, const RebindOptions& options,
                                                  const Running& running) {
    Result<Binding<T, D>, RebindReport> result;
    result.report.points = points.size;
    run_into(result.report, [&] {
        return Rebinder<T, D>(binding, points, options, running).run(result.value, result.report);
    });
    return result;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
