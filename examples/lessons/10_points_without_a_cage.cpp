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

    // A figure point that is also a control point moves exactly with it.
    const std::vector<Point> middle{{5, 2}};
    const std::vector<std::size_t> chosen{nose, lower_fin, upper_fin};
    const auto made = cageform::sites_with_figure_points(middle, fish, chosen);
    if (!made) return std::puts(to_string(made.status()));
    auto [sites, handles] = made.value;

    // Figure points outside the hull of the control points do not move: the report lists them.
    const auto alone = cageform::bind(cageform::SibsonCoordinates<double, 2>(sites), fish).report;
    std::printf("%zu control points: %zu figure points outside their hull, the first is %zu\n", sites.size(),
                alone.outside.size(), alone.outside.front());

    // Add a fixed box of control points around the figure; the deformation fades towards the box.
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
    std::printf("%zu control points: %zu figure points outside, %.1f weights per point\n", sites.size(),
                report.outside.size(), double(heard) / double(fish.size()));

    // The two tips of the tail fin move up by 2.
    auto pose = sites;
    for (const std::size_t handle : {handles[1], handles[2]}) pose[handle][1] += 2;
    std::vector<Point> moved(fish.size());
    if (clone(binding, pose, moved) != cageform::Status::ok) return 1;
    for (std::size_t i = 0; i < fish.size(); ++i)
        std::printf("(%g, %g) goes up by %.2f\n", fish[i][0], fish[i][1], moved[i][1] - fish[i][1]);
}

//> 4 control points: 4 figure points outside their hull, the first is 1
//> 8 control points: 0 figure points outside, 3.2 weights per point
//> (0, 2) goes up by 0.00
//> (2, 1) goes up by 0.00
//> (2, 3) goes up by 0.00
//> (5, 1.2) goes up by 0.19
//> (5, 2.8) goes up by 0.19
//> (8, 2) goes up by 1.50
//> (9, 1) goes up by 2.00
//> (9, 3) goes up by 2.00
