// Definitions of SibsonCoordinates. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/coordinates/sibson.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
Evaluation SibsonCoordinates<T, D>::evaluate(BlockView<const T> points, BlockView<T> weights,
                                             std::span<PointState> states, const Running& running) const {
    return evaluate_rows<false>({points, weights, states}, running);
}

template <Scalar T, std::size_t D>
Evaluation SibsonCoordinates<T, D>::evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                                       std::span<PointState> states,
                                                       const Running& running) const {
    return evaluate_rows<true>({points, gradients, states}, running);
}

template <Scalar T, std::size_t D>
Vec<T, D> SibsonCoordinates<T, D>::nearest_boundary(const Vec<T, D>& p, std::span<T> row) const {
    RowBuilder builder(handles_.size());
    const auto position = neighbours_.find_on_hull(vec_cast<double>(p), builder.scratch);
    add_weights(builder);
    for (std::size_t h = 0; h < handles_.size(); ++h) row[h] = static_cast<T>(builder.row[h]);
    return vec_cast<T>(position);
}

template <Scalar T, std::size_t D>
Status SibsonCoordinates<T, D>::prepare() {
    site_count_ = handles_.size();
    std::vector<Vec<double, D>> sites;
    sites.reserve(site_count_);
    for (const auto& site : handles_) sites.push_back(vec_cast<double>(site));
    neighbours_ = Neighbours(sites, double(coincidence_tolerance(bounds_of(handles()))));
    if (neighbours_.empty()) {
        report_.add(CageFaultKind::sites_in_a_plane);
        return Status::ok;
    }
    if (options_.degree != 3) return Status::ok;
    if (options_.frames) {
        add_frame_handles();
    } else {
        gradients_ = detail::SiteGradientRows<D>(neighbours_, options_.gradients, neighbours_.on_hull());
    }
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
