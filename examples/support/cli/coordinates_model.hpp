#pragma once

// AnyCoordinates of a type of the library: for the files that compile it.

#include "cli/coordinates.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic/tree_solver.hpp>
#include <cageform/papers/pyramid_solver.hpp>

#include <utility>

namespace cageform_examples {

/// Every solver that there is for a kind of cage.
template <class C>
struct EverySolver {
    using Options = cageform::HarmonicOptions;

    template <class Use>
    static cageform::Status choose(const Options& options, const Use& use) {
        using T = typename C::scalar;
        if constexpr (std::is_same_v<C, cageform::Polygon<T>> || std::is_same_v<C, cageform::TriangleMesh<T>>)
            return cageform::WithAveragingPyramid<C>::choose(options, use);
        else
            return cageform::HarmonicSolverChoice<C>::choose(options, use);
    }
};
template <class C>
using Harmonic = cageform::HarmonicCoordinates<typename C::scalar, C::dimension, C, EverySolver<C>>;

template <class C>
class CoordinatesModel : public AnyCoordinates<typename C::scalar, C::dimension> {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;
    using typename AnyCoordinates<T, D>::Points;

public:
    explicit CoordinatesModel(C coordinates)
        : own(std::move(coordinates)) {
        this->has_extension = C::has_extension;
        this->closed_form = C::closed_form;
        this->handles = own.handles().size();
        this->vectors = cageform::handle_view(own).vector_count();
        this->cage_report = own.cage_report();
    }

    cageform::Evaluation solve(const cageform::Running& running) override {
        if constexpr (requires { own.solve(running); })
            return own.solve(running);
        else
            return {};
    }
    cageform::Result<cageform::Binding<T, D>, cageform::BindReport>
    bind(Points points, const cageform::BindOptions& options,
         const cageform::Running& running) const override {
        return cageform::bind(own, points, options, running);
    }
    cageform::Evaluation
    for_each_cell(const std::function<void(const cageform::GridCell<T, D>&)>& f) const override {
        if constexpr (requires { own.for_each_cell(f); })
            return own.for_each_cell(f);
        else
            return {cageform::Status::solver_not_supported, {}};
    }

    cageform::Result<cageform::FigureBinding<T, D>, cageform::FigureBindReport>
    bind([[maybe_unused]] const typename AnyCoordinates<T, D>::PointsAndNormals& figure,
         [[maybe_unused]] const cageform::BindOptions& options,
         [[maybe_unused]] const cageform::Running& running) const override {
        if constexpr (std::is_same_v<T, float> && D == 3 && cageform::GradientCoordinates<C>) {
            return cageform::bind(own, figure, options, running);
        } else {
            cageform::Result<cageform::FigureBinding<T, D>, cageform::FigureBindReport> none;
            none.report.status = cageform::Status::solver_not_supported;
            return none;
        }
    }

private:
    C own;
};

template <class C>
auto model_of(C coordinates) {
    return std::make_unique<CoordinatesModel<C>>(std::move(coordinates));
}

} // namespace cageform_examples
