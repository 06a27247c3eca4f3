// Definitions of CurvedGreenCoordinates. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/coordinates/curved_green.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T>
Evaluation CurvedGreenCoordinates<T>::evaluate(BlockView<const T> points, BlockView<T> weights,
                                               std::span<PointState> states, const Running& running) const {
    return evaluate_rows<false>({points, weights, states}, running);
}

template <Scalar T>
Evaluation CurvedGreenCoordinates<T>::evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                                         std::span<PointState> states,
                                                         const Running& running) const {
    return evaluate_rows<true>({points, gradients, states}, running);
}

template <Scalar T>
Vec<T, 2> CurvedGreenCoordinates<T>::nearest_boundary(const Vec<T, 2>& p, std::span<T> row) const {
    const auto q = tables_.scale * vec_cast<double>(p);
    const auto nearest = nearest_of(q);
    const auto at = tables_.edges[nearest.edge].curve.at(nearest.place.t);
    detail::CurvedBlock<T> block(tables_);
    std::vector<Lanes<double>> weights(tables_.handles.size());
    std::array<PointState, detail::CurvedBlock<T>::lanes> states;
    states.fill(PointState::unreached);
    for (std::size_t lane = 0; lane < states.size(); ++lane) {
        block.x[lane] = at[0];
        block.y[lane] = at[1];
    }
    evaluate_block<false>(block, weights.data(), states, 4 * tables_.tolerance);
    for (std::size_t h = 0; h < row.size(); ++h) row[h] = static_cast<T>(weights[h][0]);
    return vec_cast<T>((1 / tables_.scale) * at);
}

template <Scalar T>
detail::OutsideDistance<2> CurvedGreenCoordinates<T>::distance_outside(const Vec<T, 2>& p) const noexcept {
    const auto nearest = nearest_of(tables_.scale * vec_cast<double>(p));
    const auto at = tables_.edges[nearest.edge].curve.at(nearest.place.t);
    return detail::OutsideDistance<2>(vec_cast<double>(p) - (1 / tables_.scale) * at);
}

template <Scalar T>
void CurvedGreenCoordinates<T>::prepare(const CurvedGreenOptions<T>& options) {
    report_ = check(cage_);
    if (report_.status != Status::ok) return;
    CageReport read;
    const detail::CurveLoops loops(cage_, read);
    std::vector<std::size_t> degrees = options.posed_degrees;
    for (std::size_t e = 0; degrees.size() < loops.edges.size() && options.posed_degrees.empty(); ++e)
        degrees.push_back((std::max)(options.posed_degree, loops.edges[e].degree));
    if (degrees.size() != loops.edges.size())
        return report_.add(CageFaultKind::curve_degree, degrees.size(), 0);
    for (std::size_t e = 0; e < degrees.size(); ++e) {
        if (degrees[e] < loops.edges[e].degree || degrees[e] > detail::most_posed_degree)
            report_.add(CageFaultKind::curve_degree, e, degrees[e]);
    }
    if (report_.status != Status::ok) return;
    tables_ = detail::CurvedTables<T>(loops, degrees);
    for (std::size_t i = 0; i < tables_.handles.size(); ++i) {
        if (is_finite(tables_.handles[i])) continue;
        report_.add(CageFaultKind::vertex_not_finite, i % tables_.points());
    }
    if (options.disk && report_.status == Status::ok) set_disk(*options.disk);
}

} // namespace cageform::inline CAGEFORM_ABI
