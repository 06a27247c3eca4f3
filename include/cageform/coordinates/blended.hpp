// Coordinates of several cages over one figure, blended where the cages overlap.
#pragma once

#include <cageform/cage/detail/depth.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/core/affine/linear_restorer.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Coordinates with respect to several cages, for example one for the body and one for the head. The handles
/// of the first cage come first, then those of the second, and so on. The weights are
///
///     w = Σ_k β_k w^k,   β_k = d_k² / Σ_j d_j²
///
/// summed over the cages that contain the point. d_k is the depth of the point in cage k, divided by the
/// diagonal of the cage (cage/detail/depth.hpp). The weights are C¹ across the boundary of a cage that lies
/// inside another cage. They sum to 1 and reproduce the point if the weights w^k do.
///
///   range     that of the components, with linear precision restored in each component
///   outside   undefined outside all cages
///   cost      all components at all points, O(edges or faces) per point and cage, and memory for the weights
///             of one component
///   fails     as the first component that fails; too_few_vertices without components
template <CageCoordinates C>
    requires requires(const C& c) { detail::Depth<std::decay_t<decltype(c.cage())>>(c.cage()); }
class BlendedCoordinates {
public:
    using scalar = typename C::scalar;
    using Component = C;
    static constexpr std::size_t dimension = C::dimension;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = C::closed_form;

    explicit BlendedCoordinates(std::vector<C> components)
        : components_(std::move(components)) {
        const Status status = detail::guard_memory([&] { join_components(); });
        if (status != Status::ok) report_ = {status, {}};
    }

    std::span<const C> components() const noexcept { return components_; }
    /// Returns the first handle of a component, or the number of handles for component = #components.
    std::size_t first_handle(std::size_t component) const noexcept { return first_[component]; }
    std::span<const Vec<scalar, dimension>> handles() const noexcept { return handles_; }
    std::span<const HandleKind> handle_kinds() const noexcept { return kinds_; }
    std::span<const HandleFace<dimension>> handle_faces() const noexcept { return faces_; }

    /// Returns the report of `refused_component()`, the first refused cage, or the warnings of all cages.
    const CageReport& cage_report() const noexcept { return report_; }
    static constexpr std::size_t none = ~std::size_t{0};
    std::size_t refused_component() const noexcept { return refused_; }

    /// Solves all components and keeps their functions. Only for components that have `solve`.
    Evaluation solve(const Running& running = {})
        requires requires(C c) { c.solve(running); }
    {
        Evaluation result;
        const Status status = detail::guard_memory([&] {
            result = for_each_component(
                running, [&](std::size_t k, const Running& some) { return components_[k].solve(some); });
            return result.status;
        });
        result.status = status;
        return result;
    }

    Evaluation evaluate(BlockView<const scalar> points, BlockView<scalar> weights,
                        std::span<PointState> states, const Running& running = {}) const {
        CAGEFORM_ASSERT(weights.rows == handles_.size() && states.size() == points.points,
                        "one row per handle");
        Evaluation result;
        const Status status = detail::guard_memory([&] {
            std::vector<PointState> all(components_.size() * states.size());
            result = for_each_component(running, [&](std::size_t k, const Running& some) {
                const auto own = std::span(all).subspan(k * states.size(), states.size());
                std::copy(states.begin(), states.end(), own.begin());
                return evaluate_component(k, points, weights, own, some);
            });
            if (result.status != Status::ok) return result.status;
            detail::in_parallel(running, points.blocks(), 16, [&](std::size_t begin, std::size_t end) {
                for (std::size_t b = begin; b < end; ++b) blend(b, points, weights, all, states);
            });
            return Status::ok;
        });
        result.status = status;
        return result;
    }

    Vec<scalar, dimension> nearest_boundary(const Vec<scalar, dimension>& p, std::span<scalar> row) const {
        Vec<scalar, dimension> nearest{};
        double least = std::numeric_limits<double>::infinity();
        std::size_t best = 0;
        for (const bool found : {false, true}) {
            std::fill(row.begin(), row.end(), scalar(0));
            for (std::size_t k = 0; k < components_.size(); ++k) {
                if (found && k != best) continue;
                const auto q =
                    components_[k].nearest_boundary(p, row.subspan(first_[k], first_[k + 1] - first_[k]));
                const double d = detail::length(vec_cast<double>(q) - vec_cast<double>(p));
                if (k != 0 && d >= least) continue;
                least = d;
                best = k;
                nearest = q;
            }
        }
        return nearest;
    }

private:
    static constexpr std::size_t lanes = lane_count<scalar>;

    void join_components() {
        for (const C& component : components_) {
            first_.push_back(handles_.size());
            add_handles(handle_view(component));
        }
        first_.push_back(handles_.size());
        if (components_.empty()) report_.add(CageFaultKind::too_few_vertices, 0, 0);
        for (std::size_t k = 0; k < components_.size() && report_.status == Status::ok; ++k) {
            const CageReport& report = components_[k].cage_report();
            if (report.status != Status::ok) {
                report_ = report;
                refused_ = k;
            } else {
                report_.faults.insert(report_.faults.end(), report.faults.begin(), report.faults.end());
            }
        }
        if (report_.status != Status::ok) return;
        for (const C& component : components_) {
            depths_.emplace_back(component.cage());
            scales_.push_back(1 / double(detail::frame_of(handle_view(component)).size));
            restorers_.emplace_back(handle_view(component));
        }
    }

    void add_handles(const HandleView<scalar, dimension>& component) {
        const std::size_t first = handles_.size();
        handles_.insert(handles_.end(), component.rest, component.rest + component.count);
        for (std::size_t i = 0; i < component.count; ++i)
            kinds_.push_back(component.is_point(i) ? HandleKind::point : HandleKind::vector);
        for (std::size_t n = 0; component.faces != nullptr && n < component.vector_count(); ++n) {
            faces_.push_back(component.faces[n]);
            for (auto& corner : faces_.back()) corner += static_cast<std::uint32_t>(first);
        }
    }

    /// Calls evaluation = f(component, running) for each component until one fails. Adds up the reports.
    template <class F>
    Evaluation for_each_component(const Running& running, const F& f) const {
        Evaluation total;
        total.status = report_.status;
        for (std::size_t k = 0; k < components_.size() && total.status == Status::ok; ++k) {
            const auto count = double(components_.size());
            Evaluation component = f(k, running.subtask(double(k) / count, double(k + 1) / count));
            total.status = component.status;
            SolverReport& sum = total.solver;
            for (CornerError& corner : component.solver.multigrid.corners) {
                for (std::size_t& handle : corner.handles) handle += first_[k];
            }
            sum.add(component.solver);
            if (component.solver.unseen_handle != SolverReport::none) {
                sum.unseen_handle = first_[k] + component.solver.unseen_handle;
                sum.sufficient_resolution = component.solver.sufficient_resolution;
            }
        }
        return total;
    }

    /// Evaluates component `k` and writes its weights to its rows.
    Evaluation evaluate_component(std::size_t k, BlockView<const scalar> points, BlockView<scalar> weights,
                                  std::span<PointState> states, const Running& running) const {
        const std::size_t count = first_[k + 1] - first_[k];
        std::vector<Lanes<scalar>> memory(points.blocks() * count);
        const BlockView<scalar> own{memory.data(), count, points.points};
        const Evaluation evaluation = components_[k].evaluate(points, own, states, running);
        if (evaluation.status != Status::ok) return evaluation;
        for (std::size_t b = 0; b < points.blocks(); ++b)
            std::copy_n(own.block(b), count, weights.block(b) + first_[k]);
        return evaluation;
    }

    /// Blends the weights of all components in block b. `all` holds the states by component and point.
    void blend(std::size_t b, BlockView<const scalar> points, BlockView<scalar> weights,
               std::span<const PointState> all, std::span<PointState> states) const {
        const std::size_t count = states.size(), components = components_.size();
        std::vector<Lanes<scalar>> share(components);
        typename detail::LinearRestorer<scalar, dimension>::Scratch scratch;
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t i = b * lanes + lane;
            for (auto& row : share) row[lane] = scalar(0);
            if (i >= count || states[i] == PointState::not_finite) continue;
            const auto of_component = [&](std::size_t k) { return all[k * count + i]; };
            // Blends the components that contain the point, or else those with the point on their boundary.
            states[i] = PointState::outside;
            for (const auto state : {PointState::unreached, PointState::on_boundary, PointState::inside}) {
                for (std::size_t k = 0; k < components; ++k) {
                    if (of_component(k) == state) states[i] = state;
                }
            }
            if (states[i] == PointState::outside || states[i] == PointState::unreached) continue;
            std::vector<double> depth_weight(components);
            double sum = 0;
            const auto p = block_point<dimension>(points, i);
            for (const bool equal : {states[i] == PointState::on_boundary, true}) {
                for (std::size_t k = 0; k < components; ++k) {
                    if (of_component(k) != states[i]) continue;
                    const double depth = (equal ? 1 : depths_[k](p)) * scales_[k];
                    sum += depth_weight[k] = depth * depth;
                }
                if (sum > 0) break; // else all depths underflow, and the components get equal shares
            }
            for (std::size_t k = 0; k < components; ++k)
                share[k][lane] = static_cast<scalar>(depth_weight[k] / sum);
        }
        for (std::size_t k = 0; k < components; ++k) {
            auto* const row = weights.block(b) + first_[k];
            const std::size_t handles = first_[k + 1] - first_[k];
            Lanes<scalar> bound;
            bool any = false;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                any = any || share[k][lane] != scalar(0);
                bound[lane] = share[k][lane] != scalar(0) ? scalar(1) : scalar(0);
                if (bound[lane] != scalar(0)) continue;
                // The component left these weights unspecified.
                for (std::size_t h = 0; h < handles; ++h) row[h][lane] = scalar(0);
            }
            if (!any) continue;
            (void)restorers_[k].run(points.block(b), bound, row, true, scratch);
            for (std::size_t h = 0; h < handles; ++h) {
                for (std::size_t lane = 0; lane < lanes; ++lane) row[h][lane] *= share[k][lane];
            }
        }
    }

    using Cage = std::decay_t<decltype(std::declval<const C&>().cage())>;

    std::vector<C> components_;
    std::vector<std::size_t> first_; ///< first handle of every component, then the number of handles
    std::vector<Vec<scalar, dimension>> handles_;
    std::vector<HandleKind> kinds_;
    std::vector<HandleFace<dimension>> faces_;
    CageReport report_;
    std::size_t refused_ = none;
    std::vector<detail::Depth<Cage>> depths_;
    std::vector<double> scales_;
    std::vector<detail::LinearRestorer<scalar, dimension>> restorers_;
};

} // namespace cageform::inline CAGEFORM_ABI
