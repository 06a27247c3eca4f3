// Defines the functions of binders.hpp, which includes this file, unless the program links
// cageform::compiled.
#pragma once

#include <cageform/binding/detail/binders.hpp>
#include <cageform/binding/detail/falloff.hpp>
#include <cageform/binding/detail/point_binder.hpp>
#include <cageform/binding/detail/vector_binder.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class T, std::size_t D>
Result<std::array<Binding<T, D>, D>, BindReport>
bind_axes(const BindInput<T, D>& input, const BindOptions& options, const Running& running) {
    std::array<Vec<T, D>, D> axes{};
    std::array<PointReader<T>, D> readers;
    for (std::size_t n = 0; n < D; ++n) {
        axes[n][n] = 1;
        readers[n] = repeat_vector(input.points.size, axes[n]);
    }
    return bind_each_vector(input, readers, options, running);
}

/// Binds points and vectors. Coordinates with a solver must already be solved.
template <class T, std::size_t D>
Status bind_points_and_vectors(const BindInput<T, D>& coordinates, FigureInput<T, D>& input,
                               const BindOptions& options, const Running& running,
                               Result<FigureBinding<T, D>, FigureBindReport>& result) {
    auto& [figure, report] = result;
    const Running first = running.subtask(0, input.has_normals() ? 0.4 : 1), second = running.subtask(0.4, 1);
    auto points = bind_points(coordinates, options, Binding<T, D>{}, first);
    report.points = std::move(points.report);
    if (report.points.status != Status::ok) return report.points.status;
    if (input.has_normals()) {
        auto vectors = bind_each_vector(coordinates, input.tangents, options, second);
        report.vectors = std::move(vectors.report);
        if (report.vectors.status != Status::ok) return report.vectors.status;
        figure.tangents = std::move(vectors.value);
    }
    figure.points = std::move(points.value);
    figure.handedness = std::move(input.handedness);
    return Status::ok;
}

template <class T, std::size_t D>
Status bind_read_figure(const BindInput<T, D>& coordinates, FigureInput<T, D>& input,
                        const BindOptions& options, const Running& running,
                        Result<FigureBinding<T, D>, FigureBindReport>& result) {
    const bool solves = coordinates.with_solved && input.has_normals() &&
                        check_falloff(options, coordinates.has_extension) == Status::ok &&
                        coordinates.cage.status == Status::ok;
    if (!solves) return bind_points_and_vectors(coordinates, input, options, running, result);
    const auto use = [&](const Evaluation& solution, const BindInput<T, D>& solved) {
        BindReport& report = result.report.points;
        report.cage = coordinates.cage;
        report.points = input.points.size;
        report.solver = solution.solver;
        report.status = solution.status;
        // Memory for all functions is insufficient; it may suffice for one group.
        if (report.status == Status::out_of_memory)
            return bind_points_and_vectors(coordinates, input, options, running, result);
        if (report.status != Status::ok) return report.status;
        return bind_points_and_vectors(solved, input, options, running.subtask(0.7, 1), result);
    };
    return coordinates.with_solved(running.subtask(0, 0.7), input.points, use);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
