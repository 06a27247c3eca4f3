// A figure in the plane: coordinates of any type, and the points bound to them.
#pragma once

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>

#include <array>
#include <span>
#include <vector>

namespace cageform_page {

using cageform::Status;
using Point2 = cageform::Vec<double, 2>;

/// Two batches of points from one solve: the figure's, and the nodes where weights are shown.
constexpr std::size_t batches = 2;

/// A cage and the points bound to it.
struct Plane {
    cageform::AnyCoordinates<double, 2> coordinates;
    bool is_sites = false;                                        // points that belong to no cage
    std::size_t frame_handles = 0;                                // the last ones, which poses leave at rest
    std::array<cageform::Binding<double, 2>, batches> bindings{}; // of `coordinates`
    std::vector<Point2> pose{}, handles{}, places{};              // of the batch that was moved last

    cageform::BindReport bind(std::size_t batch, std::span<const Point2> points) {
        cageform::BindOptions options;
        if (!coordinates.has_extension()) // the default of the programs
            options.outside = is_sites && batch == 0 ? cageform::OutsidePoints::keep_in_place
                                                     : cageform::OutsidePoints::nearest_boundary;
        auto [binding, report] = coordinates.bind(points, options);
        bindings[batch] = std::move(binding);
        return report;
    }
    /// Moves a batch by a pose of all points but the still ones.
    Status clone(std::size_t batch, std::span<const Point2> vertices) {
        const auto& binding = bindings[batch];
        const auto all = binding.handle_view();
        pose.assign(vertices.begin(), vertices.end());
        for (std::size_t i = all.count - frame_handles; i < all.count; ++i) pose.push_back(all.rest[i]);
        handles.resize(binding.handle_count());
        places.resize(binding.point_count());
        const auto posed = pose_handles(binding, pose, handles);
        return posed.status == Status::ok ? cageform::clone(binding, handles, places) : posed.status;
    }
};

} // namespace cageform_page
