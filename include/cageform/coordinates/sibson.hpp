// Natural neighbour coordinates (Sibson): a closed form for control points without a cage.
#pragma once

#include <cageform/cage/point_set.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/sibson/site_gradients.hpp>

namespace cageform::inline CAGEFORM_ABI {

struct SibsonOptions {
    /// 1: Sibson's coordinates, never negative, with a crease at every site. 3: Farin's interpolant, which is
    /// smooth at the sites too. Other degrees are refused.
    int degree = 1;
    /// Degree 3: how the gradient at a site is estimated from the posed sites.
    SiteGradients gradients = SiteGradients::facets;
    /// Degree 3: the user controls the gradients instead. Each site i of n gets D frame handles, at indices
    /// n + D i + axis. At rest, a frame handle lies along the axis, at half the distance from the site to the
    /// nearest other site. SibsonCoordinates::pose_of computes the poses of frame handles.
    bool frames = false;
};

/// Natural neighbour coordinates of sites in 2D or 3D (Sibson, A vector identity for the Dirichlet
/// tessellation, 1980). If a point p were inserted into the Voronoi diagram of the sites, its cell V_p would
/// be cut out of the cells V_i of the sites. The weight of site i is the fraction of V_p that is cut out of
/// V_i:
///
///   u_i = |V_p ∩ V_i| / |V_p|
///
/// Degree 3 is Farin's interpolant (Surfaces over Dirichlet tessellations, CAGD 7, 1990). With s = Σu²,
/// q = Σ u_j² P_j and estimated gradients g_i = Σ_l G_il z_l of values z, the weights are
///
///   w_l = Z_l + Σ_i V_i·G_il,  Z_i = u_i (1 + u_i − s),  V_i = ½ u_i ((1 + u_i)(p − P_i) − (q − s P_i))
///
/// On the hull cells are unbounded, and the limits of the weights are used: linear along edges, barycentric
/// on triangles, and the C² coordinates of Hiyoshi & Sugihara on flat facets with more sites. If sites lie on
/// a common circle or sphere (lattices, rings), the weights do not depend on the choice of the triangulation.
///
/// The computation is in coordinates/sibson/: natural_neighbours.hpp (read it first), new_cell.hpp,
/// cell_overlap.hpp; site_gradients.hpp has the gradients of degree 3.
///
///   range      degree 1: in [0, 1], non-zero for natural neighbours only: about 6 in 2D, 15 in 3D. Degree 3:
///              can be negative; neighbours of neighbours have weights too. Σ|w| grows where sites are close
///              together (BindReport::amplification)
///   defined    in the convex hull of the sites; no extension
///   smooth     inside the hull C¹ in 2D, C² in 3D; at the sites C⁰ with degree 1, C¹ with degree 3
///   accuracy   sites and points are rounded to a lattice of step 2^-60 of the sites' extent. Weights are
///              computed in double if their estimated rounding error is at most 2^-39 (2D) or 2^-35 (3D),
///              else from integers. Measured over hostile sites: below 1e-13 (sibson/new_cell.hpp)
///   cost       O(n log n) to construct. Per point: a walk through the triangulation, one term per neighbour,
///              and setting n weights to zero
///   gradients  not defined at sites for degree 1, and one-sided on the hull. At such points the gradient is
///              that of a point moved by 1e-6 of the way to the centroid of a simplex
///   faults     too_few_vertices, vertex_not_finite, duplicate_vertices, sites_in_a_plane
template <Scalar T, std::size_t D>
class SibsonCoordinates {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = true;
    static constexpr bool local = true;

    explicit SibsonCoordinates(PointSet<T, D> sites, const SibsonOptions& options = {})
        : options_(options) {
        report_ = check(sites);
        if (report_.status == Status::ok && options.degree != 1 && options.degree != 3)
            report_.status = Status::sibson_degree_not_supported;
        const Status status = detail::guard_memory([&] {
            handles_.assign(sites.sites().begin(), sites.sites().end());
            return report_.status == Status::ok ? prepare() : Status::ok;
        });
        if (status != Status::ok) report_ = {status, {}};
    }
    template <PointRangeIn<D> R>
    explicit SibsonCoordinates(const R& sites, const SibsonOptions& options = {})
        : SibsonCoordinates(PointSet<T, D>(sites), options) {}

    /// Returns the sites, followed by the frame handles if SibsonOptions::frames is set.
    std::span<const Vec<T, D>> handles() const noexcept { return handles_; }
    std::size_t sites() const noexcept { return site_count_; }
    const CageReport& cage_report() const noexcept { return report_; }
    const SibsonOptions& options() const noexcept { return options_; }

    /// See CageCoordinates.
    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const;
    /// See GradientCoordinates.
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const;
    Vec<T, D> nearest_boundary(const Vec<T, D>& p, std::span<T> row) const;

    /// Computes the pose of all handles from posed sites and a frame per site. A frame rotates and stretches
    /// the neighbourhood of its site: a frame handle goes to the posed site plus the frame's column times the
    /// handle's distance at rest. Identity frames move the sites alone. If sites and frames follow one affine
    /// map, the whole figure does.
    ///
    ///   sites   posed sites, #sites
    ///   frames  #sites; columns[axis] is the image of the unit vector of the axis
    ///   pose    out: #handles
    ///   fails   sibson_degree_not_supported (options().frames is not set); pose_size_differs;
    ///           pose_not_finite; output_too_small. `pose` is then untouched
    template <PointRangeIn<D> R>
    Status pose_of(const R& sites, std::span<const std::array<Vec<T, D>, D>> frames,
                   std::span<Vec<T, D>> pose) const {
        if (handles_.size() == site_count_) return Status::sibson_degree_not_supported;
        if (std::size(sites) != site_count_ || frames.size() != site_count_) return Status::pose_size_differs;
        if (pose.size() < handles_.size()) return Status::output_too_small;
        for (std::size_t i = 0; i < site_count_; ++i) {
            bool finite = is_finite(to_vec<T>(sites[i]));
            for (const auto& column : frames[i]) finite = finite && is_finite(column);
            if (!finite) return Status::pose_not_finite;
        }
        for (std::size_t i = 0; i < site_count_; ++i) {
            pose[i] = to_vec<T>(sites[i]);
            for (std::size_t k = 0; k < D; ++k) {
                const std::size_t handle = site_count_ + D * i + k;
                pose[handle] = pose[i] + (handles_[handle][k] - handles_[i][k]) * frames[i][k];
            }
        }
        return Status::ok;
    }

private:
    using Neighbours = detail::NaturalNeighbours<D>;
    using Matrix = std::array<Vec<double, D>, D>; ///< row k: derivatives along axis k

    /// A row of weights, or of their derivatives along every axis, with scratch memory.
    struct RowBuilder {
        typename Neighbours::Scratch scratch;
        std::vector<double> row;
        std::vector<std::uint32_t> touched;

        explicit RowBuilder(std::size_t rows)
            : row(rows, 0) {}
        void add(std::size_t n, double x) {
            row[n] += x;
            touched.push_back(std::uint32_t(n));
        }
    };

    Status prepare();
    void add_frame_handles() {
        std::vector<double> nearest(site_count_, (std::numeric_limits<double>::max)());
        const auto& sites = neighbours_.sites();
        for (const auto& simplex : sites.simplices()) {
            for (std::size_t i = 0; !simplex.is_ghost() && i <= D; ++i) {
                for (std::size_t k = 0; k < i; ++k) {
                    const std::uint32_t a = sites.site(simplex.vertex[i]), b = sites.site(simplex.vertex[k]);
                    const double distance =
                        detail::length(vec_cast<double>(handles_[a]) - vec_cast<double>(handles_[b]));
                    nearest[a] = std::fmin(nearest[a], distance);
                    nearest[b] = std::fmin(nearest[b], distance);
                }
            }
        }
        handles_.reserve((D + 1) * site_count_);
        for (std::size_t i = 0; i < site_count_; ++i) {
            for (std::size_t k = 0; k < D; ++k) {
                Vec<T, D> handle = handles_[i];
                handle[k] += static_cast<T>(nearest[i] / 2);
                handles_.push_back(handle);
            }
        }
    }

    template <bool gradients>
    Evaluation evaluate_rows(const Batch<T>& batch, const Running& running) const {
        const std::size_t rows = (gradients ? D : 1) * handles_.size();
        return detail::evaluate_blocks(report_, rows, batch, running,
                                       [&](std::size_t begin, std::size_t end) {
                                           RowBuilder builder(rows);
                                           for (std::size_t b = begin; b < end; ++b)
                                               evaluate_block<gradients>(batch, b, builder);
                                       });
    }
    template <bool gradients>
    void evaluate_block(const Batch<T>& batch, std::size_t b, RowBuilder& builder) const {
        Lanes<T>* const rows = batch.rows.block(b);
        for (std::size_t n = 0; n < batch.rows.rows; ++n) std::fill_n(rows[n].v, lane_count<T>, T(0));
        const std::size_t first = b * lane_count<T>;
        const std::size_t used = (std::min)(lane_count<T>, batch.points.points - first);
        for (std::size_t lane = 0; lane < used; ++lane) {
            PointState& state = batch.states[first + lane];
            if (state == PointState::not_finite) continue;
            const auto p = vec_cast<double>(block_point<D>(batch.points, first + lane));
            builder.scratch.gradients = gradients;
            state = neighbours_.find(p, builder.scratch);
            if (state == PointState::outside) continue;
            if constexpr (gradients) {
                find_gradients(p, state, builder);
                add_gradients(builder);
            } else {
                add_weights(builder);
            }
            bool finite = true;
            for (const std::uint32_t n : builder.touched) {
                rows[n][lane] = static_cast<T>(builder.row[n]);
                finite = finite && is_finite(rows[n][lane]);
            }
            for (const std::uint32_t n : builder.touched) builder.row[n] = 0;
            builder.touched.clear();
            if (!finite) state = PointState::unreached;
        }
    }

    // ---- weights --------------------------------------------------------------------------------

    void add_weights(RowBuilder& builder) const {
        const auto& found = builder.scratch.found;
        if (options_.degree == 1) {
            for (const auto& n : found) builder.add(n.site, n.weight);
            return;
        }
        double s = 0;
        Vec<double, D> m{};
        for (const auto& n : found) {
            s += n.weight * n.weight;
            m = m + (n.weight * n.weight) * n.away;
        }
        for (const auto& n : found) {
            builder.add(n.site, n.weight * (1 + n.weight - s));
            add_slope(n.site, (0.5 * n.weight) * ((s - 1 - n.weight) * n.away - m), 0, builder);
        }
    }
    /// Adds the product of the gradient at a site with `v` to the rows from `offset` on.
    void add_slope(std::uint32_t site, const Vec<double, D>& v, std::size_t offset,
                   RowBuilder& builder) const {
        if (options_.frames) {
            for (std::size_t k = 0; k < D; ++k) {
                const std::size_t handle = site_count_ + D * site + k;
                const double x = v[k] / (double(handles_[handle][k]) - double(handles_[site][k]));
                builder.add(offset + handle, x);
                builder.add(offset + site, -x);
            }
        } else {
            for (const auto& term : gradients_.row(site))
                builder.add(offset + term.site, dot(v, term.vector));
        }
    }

    // ---- gradients ------------------------------------------------------------------------------

    /// Where gradients do not exist at `p`, finds the neighbours of a point slightly inside.
    void find_gradients(const Vec<double, D>& p, PointState state, RowBuilder& builder) const {
        auto& scratch = builder.scratch;
        if (state == PointState::inside && !scratch.at_site) return;
        if (scratch.at_site && options_.degree == 3) return;
        for (const double fraction : {0x1p-20, 0x1.8p-20}) {
            (void)neighbours_.find(neighbours_.moved_inside(p, fraction), scratch);
            if (!scratch.at_site) return;
        }
    }
    void add_gradients(RowBuilder& builder) const {
        const auto& found = builder.scratch.found;
        const std::size_t handles = handles_.size();
        if (options_.degree == 1) {
            for (const auto& n : found) {
                for (std::size_t k = 0; k < D; ++k) builder.add(k * handles + n.site, n.gradient[k]);
            }
            return;
        }
        double s = 0;
        Vec<double, D> m{}, ds{};
        Matrix dm{}; // without the derivative of the point itself
        for (const auto& n : found) {
            const double u = n.weight;
            s += u * u;
            m = m + (u * u) * n.away;
            ds = ds + (2 * u) * n.gradient;
            for (std::size_t k = 0; k < D; ++k) dm[k] = dm[k] + (2 * u * n.gradient[k]) * n.away;
        }
        for (const auto& n : found) {
            const double u = n.weight;
            const auto bracket = (s - 1 - u) * n.away - m;
            for (std::size_t k = 0; k < D; ++k) {
                builder.add(k * handles + n.site, n.gradient[k] * (1 + 2 * u - s) - u * ds[k]);
                auto v =
                    (0.5 * n.gradient[k]) * bracket + (0.5 * u) * ((ds[k] - n.gradient[k]) * n.away - dm[k]);
                v[k] += 0.5 * u * (1 + u);
                add_slope(n.site, v, k * handles, builder);
            }
        }
    }

    SibsonOptions options_;
    std::vector<Vec<T, D>> handles_;
    std::size_t site_count_ = 0;
    CageReport report_;
    Neighbours neighbours_;
    detail::SiteGradientRows<D> gradients_;
};

// `SibsonCoordinates coordinates(sites)` deduces the scalar and the dimension.
template <Scalar T, std::size_t D>
SibsonCoordinates(PointSet<T, D>, const SibsonOptions& = {}) -> SibsonCoordinates<T, D>;
template <PointRange R>
SibsonCoordinates(const R&, const SibsonOptions& = {})
    -> SibsonCoordinates<range_scalar_t<R>, range_dimension<R>>;

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/sibson/evaluation.impl.hpp>
#endif
