// Coordinates whose type is chosen at run time.
#pragma once

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/detail/outside_distance.hpp>
#include <cageform/coordinates/harmonic/cage_solver.hpp>
#include <cageform/core/detail/stopwatch.hpp>

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Type-erased coordinates, for types that are chosen at run time, or to compile a coordinate type in
/// only one file of a program:
///
///     AnyCoordinates<float, 3> coordinates_of(const TriangleMesh<float>& cage, bool harmonic) {
///         if (harmonic) return HarmonicCoordinates(cage);
///         return MeanValueCoordinates(cage);
///     }
///     const auto [binding, report] = bind(coordinates_of(cage, true), points);
///
/// Results equal those of the contained type bit for bit. Copies share the contained coordinates: a
/// copy costs as much as a pointer, and all copies use the functions that `solve` stores. Every call of
/// default-constructed coordinates returns coordinates_empty.
template <Scalar T, std::size_t D>
class AnyCoordinates {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    AnyCoordinates() = default;

    /// Holds coordinates of any type of this scalar and dimension.
    template <CageCoordinates C>
        requires(std::is_same_v<typename C::scalar, T> && C::dimension == D)
    AnyCoordinates(C coordinates) // implicit, so that a function can return either type
        : model_(std::make_shared<Model<C>>(std::move(coordinates))) {}

    /// Whether weights are defined outside the cage.
    bool has_extension() const noexcept { return model_ && model_->has_extension; }
    /// Whether the weights need no solver; `solve` then does nothing.
    bool closed_form() const noexcept { return model_ && model_->closed_form; }
    /// Whether the coordinates have gradients, which `bind` needs for normals and tangents.
    bool has_gradients() const noexcept { return model_ && model_->has_gradients; }

    /// Returns the distance of a finite point outside from the boundary, in the units of the cage;
    /// undefined for points inside. O(#faces). May throw std::bad_alloc.
    double distance_from_boundary(const Vec<T, D>& p) const {
        return model_ ? model_->distance_from_boundary(p) : 0;
    }

    HandleView<T, D> handles() const { return model_ ? model_->handles() : HandleView<T, D>{}; }
    const CageReport& cage_report() const {
        static const CageReport empty{Status::coordinates_empty, {}};
        return model_ ? model_->cage_report() : empty;
    }

    /// Computes and stores the functions, so that several binds solve only once.
    Evaluation solve(const Running& running = {}) const {
        if (!model_) return {Status::coordinates_empty, {}};
        return model_->solve(running);
    }

    /// Pack the solved functions for a file, and load packed functions instead of solving
    /// (HarmonicCoordinates). Return solver_not_supported if the type cannot do this.
    Result<std::vector<std::byte>, Evaluation> save_solution(const Running& running = {}) const {
        if (model_) return model_->save_solution(running);
        return {{}, {Status::coordinates_empty, {}}};
    }
    Evaluation load_solution(std::span<const std::byte> data, const Running& running = {}) const {
        if (!model_) return {Status::coordinates_empty, {}};
        return model_->load_solution(data, running);
    }

    /// Calls f(cell) for the cells of the adaptive grid. Returns solver_not_supported without such a grid.
    Evaluation for_each_cell(const std::function<void(const GridCell<T, D>&)>& f) const {
        if (!model_) return {Status::coordinates_empty, {}};
        return model_->for_each_cell(f);
    }

    /// Evaluates a batch of points; see `CageCoordinates`.
    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running) const {
        if (!model_) return {Status::coordinates_empty, {}};
        return model_->evaluate(points, weights, states, running);
    }

    /// Binds points; called by `bind(coordinates, points, …)`.
    template <PointRangeIn<D> R>
    Result<Binding<T, D>, BindReport> bind(const R& points, const BindOptions& options = {},
                                           const Running& running = {}) const {
        return bind(points, options, Binding<T, D>{}, running);
    }
    template <PointRangeIn<D> R>
    Result<Binding<T, D>, BindReport> bind(const R& points, const BindOptions& options,
                                           Binding<T, D>&& recycled, const Running& running = {}) const {
        if (!model_) {
            Result<Binding<T, D>, BindReport> refused;
            refused.report.status = Status::coordinates_empty;
            return refused;
        }
        return detail::bind_points(model_->input(detail::read_points<T>(points)), options,
                                   std::move(recycled), running);
    }

    /// Binds a figure; called by `bind(coordinates, figure, …)`. For normals, coordinates
    /// without gradients return gradients_not_supported.
    template <PointRangeIn<D> P, class N, class G>
        requires(detail::NormalsIn<N, D> && detail::TangentsIn<G, N, D>)
    Result<FigureBinding<T, D>, FigureBindReport> bind(const FigurePoints<P, N, G>& figure,
                                                       const BindOptions& options = {},
                                                       const Running& running = {}) const {
        Result<FigureBinding<T, D>, FigureBindReport> result;
        detail::run_into(result.report, [&] {
            if (!model_) return Status::coordinates_empty;
            return detail::read_figure<T, D>(figure, [&](detail::FigureInput<T, D>& input) {
                if (input.has_normals() && !has_gradients()) return Status::gradients_not_supported;
                return detail::bind_read_figure(model_->input(input.points), input, options, running, result);
            });
        });
        return result;
    }

    /// Binds families of vectors, one vector per point; called by `bind_vectors(coordinates, points,
    /// …)`. Without gradients the status is gradients_not_supported.
    template <PointRangeIn<D> R, PointRangeIn<D> V, std::size_t K>
    Result<std::array<Binding<T, D>, K>, BindReport>
    bind_vectors(const R& points, const std::array<V, K>& vectors, const BindOptions& options = {},
                 const Running& running = {}) const {
        Result<std::array<Binding<T, D>, K>, BindReport> refused;
        refused.report.status = model_ ? Status::gradients_not_supported : Status::coordinates_empty;
        if (!has_gradients()) return refused;
        std::array<detail::PointReader<T>, K> readers;
        for (std::size_t n = 0; n < K; ++n) {
            CAGEFORM_ASSERT(std::size(vectors[n]) == std::size(points), "a vector for every point");
            readers[n] = detail::read_points<T>(vectors[n]);
        }
        return detail::bind_each_vector(model_->input(detail::read_points<T>(points)), readers, options,
                                        running);
    }

    /// Binds the D axes at every point; called by `bind_jacobians(coordinates, points, …)`. Without
    /// gradients the status is gradients_not_supported.
    template <PointRangeIn<D> R>
    Result<std::array<Binding<T, D>, D>, BindReport>
    bind_jacobians(const R& points, const BindOptions& options = {}, const Running& running = {}) const {
        if (has_gradients())
            return detail::bind_axes(model_->input(detail::read_points<T>(points)), options, running);
        Result<std::array<Binding<T, D>, D>, BindReport> refused;
        refused.report.status = model_ ? Status::gradients_not_supported : Status::coordinates_empty;
        return refused;
    }

private:
    struct Interface {
        virtual ~Interface() = default;
        virtual HandleView<T, D> handles() const = 0;
        virtual const CageReport& cage_report() const = 0;
        virtual double distance_from_boundary(const Vec<T, D>&) const = 0;
        virtual Evaluation solve(const Running&) = 0;
        virtual Evaluation for_each_cell(const std::function<void(const GridCell<T, D>&)>&) const = 0;
        virtual Evaluation evaluate(BlockView<const T>, BlockView<T>, std::span<PointState>,
                                    const Running&) const = 0;
        virtual detail::BindInput<T, D> input(const detail::PointReader<T>&) const = 0;
        virtual Result<std::vector<std::byte>, Evaluation> save_solution(const Running&) = 0;
        virtual Evaluation load_solution(std::span<const std::byte>, const Running&) = 0;

        bool has_extension = false, closed_form = false, has_gradients = false;
    };

    template <class C>
    struct Model final : Interface {
        explicit Model(C its_coordinates)
            : own(std::move(its_coordinates)) {
            this->has_extension = C::has_extension;
            this->closed_form = C::closed_form;
            this->has_gradients = GradientCoordinates<C>;
        }

        HandleView<T, D> handles() const override { return handle_view(own); }
        const CageReport& cage_report() const override { return own.cage_report(); }
        double distance_from_boundary(const Vec<T, D>& p) const override {
            return detail::outside_distance(own, p).distance;
        }
        Evaluation solve(const Running& running) override {
            if constexpr (requires { own.solve(running); })
                return own.solve(running);
            else
                return {running.end(own.cage_report().status), {}};
        }
        Evaluation for_each_cell(const std::function<void(const GridCell<T, D>&)>& f) const override {
            if constexpr (requires { own.for_each_cell(f); })
                return own.for_each_cell(f);
            else
                return {Status::solver_not_supported, {}};
        }
        Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                            const Running& running) const override {
            return own.evaluate(points, weights, states, running);
        }
        detail::BindInput<T, D> input(const detail::PointReader<T>& points) const override {
            return detail::figure_input(own, points);
        }
        Result<std::vector<std::byte>, Evaluation> save_solution(const Running& running) override {
            if constexpr (requires { own.save_solution(running); })
                return own.save_solution(running);
            else
                return {{}, {Status::solver_not_supported, {}}};
        }
        Evaluation load_solution(std::span<const std::byte> data, const Running& running) override {
            if constexpr (requires { own.load_solution(data, running); })
                return own.load_solution(data, running);
            else
                return {Status::solver_not_supported, {}};
        }

        C own;
    };

    std::shared_ptr<Interface> model_;
};

/// Binds families of vectors. Contract and cost are those of the contained type.
template <Scalar T, std::size_t D, PointRangeIn<D> R, PointRangeIn<D> V, std::size_t K>
Result<std::array<Binding<T, D>, K>, BindReport>
bind_vectors(const AnyCoordinates<T, D>& coordinates, const R& points, const std::array<V, K>& vectors,
             const BindOptions& options = {}, const Running& running = {}) {
    return coordinates.bind_vectors(points, vectors, options, running);
}

/// Binds the D axes at every point. Contract and cost are those of the contained type.
template <Scalar T, std::size_t D, PointRangeIn<D> R>
Result<std::array<Binding<T, D>, D>, BindReport>
bind_jacobians(const AnyCoordinates<T, D>& coordinates, const R& points, const BindOptions& options = {},
               const Running& running = {}) {
    return coordinates.bind_jacobians(points, options, running);
}

/// Returns the handles of the coordinates, with their kinds and faces.
template <Scalar T, std::size_t D>
HandleView<T, D> handle_view(const AnyCoordinates<T, D>& coordinates) {
    return coordinates.handles();
}

} // namespace cageform::inline CAGEFORM_ABI
