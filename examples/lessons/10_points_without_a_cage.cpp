// 10. Points without a cage: a few control points, anywhere on or around the figure, without faces. Weights
// are natural neighbour (Sibson) coordinates: a point follows only the neighbouring control points.
#include <cageform/cageform.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 2>;

int main() {
    // A fish as a row of points: nose at the left, tail fin at the right.
    const std::vector<Point> fish{{0, 2}, {2, 1}, {2, 3}, {5, 1.2}, {5, 2.8}, {8, 2}, {9, 1}, {9, 3}};
    const std::size_t nose = 0, lower_fin = 6, upper_fin = 7;

    // Figure points that are control points themselves follow their pose exactly.
    const std::vector<Point> middle{{5, 2}};
    const std::vector<std::size_t> chosen{nose, lower_fin, upper_fin};
    const auto made = cageform::sites_with_figure_points(middle, fish, chosen);
    if (!made) return std::puts(to_string(made.status()));
    auto [sites, handles] = made.value;

    // Points outside the hull of the control points do not move: the report lists them.
    const auto alone = cageform::bind(cageform::SibsonCoordinates<double, 2>(sites), fish).report;
    std::printf("%zu points: %zu of the figure's lie outside their hull, the first is %zu\n", sites.size(),
                alone.outside.size(), alone.outside.front());

    // Add a fixed box of control points around both; the deformation fades towards it.
    std::vector<Point> all = fish;
    all.insert(all.end(), middle.begin(), middle.end());
    const auto box = cageform::surround(all);
    if (!box) return std::puts(to_string(box.status()));
    sites.insert(sites.end(), box.value.begin(), box.value.end());

    const cageform::SibsonCoordinates<double, 2> coordinates(sites);
    const auto [binding, report] = cageform::bind(coordinates, fish);
    if (report.status != cageform::Status::ok) return std::puts(to_string(report.status));
    std::size_t heard = 0;
    for (std::size_t i = 0; i < fish.size(); ++i) {
        for (std::size_t k = 0; k < sites.size(); ++k) heard += binding.weight(i, k) != 0 ? 1 : 0;
    }
    std::printf("%zu points: %zu outside, a figure point hears %.1f of them\n", sites.size(),
                report.outside.size(), double(heard) / double(fish.size()));

    // The tail beats: its two fins go up.
    auto pose = sites;
    for (const std::size_t handle : {handles[1], handles[2]}) pose[handle][1] += 2;
    std::vector<Point> moved(fish.size());
    if (clone(binding, pose, moved) != cageform::Status::ok) return 1;
    for (std::size_t i = 0; i < fish.size(); ++i)
        std::printf("(%g, %g) goes up by %.2f\n", fish[i][0], fish[i][1], moved[i][1] - fish[i][1]);
}

//> 4 points: 4 of the figure's lie outside their hull, the first is 1
//> 8 points: 0 outside, a figure point hears 3.2 of them
//> (0, 2) goes up by 0.00
//> (2, 1) goes up by 0.00
//> (2, 3) goes up by 0.00
//> (5, 1.2) goes up by 0.19
//> (5, 2.8) goes up by 0.19
//> (8, 2) goes up by 1.50
//> (9, 1) goes up by 2.00
//> (9, 3) goes up by 2.00
