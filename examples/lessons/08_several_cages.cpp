// 8. Several cages over one figure: one for the body, one for the head, blended where they overlap.
#include <cageform/cageform.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 2>;
using Mean = cageform::MeanValueCoordinates<double, 2>;

int main() {
    const std::vector<Point> body{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, head{{1, 3}, {3, 3}, {3, 6}, {1, 6}};
    const cageform::BlendedCoordinates<Mean> coordinates({Mean(body), Mean(head)});
    const auto first_of_head = coordinates.first_handle(1);

    const std::array<Point, 5> figure{{{2, 2}, {2, 3}, {2, 3.5}, {2, 4}, {2, 5}}}; // upwards through the neck
    const auto [binding, report] = cageform::bind(coordinates, figure);
    std::printf("%zu handles, the head's from %zu: %s\n", binding.handle_count(), first_of_head,
                to_string(report.status));

    std::vector<Point> pose;
    for (const auto& v : coordinates.handles()) pose.push_back({v[0], v[1]});
    for (std::size_t i = first_of_head; i < pose.size(); ++i) pose[i][0] += 1; // the head's cage to the right
    std::array<Point, 5> moved;
    if (clone(binding, pose, moved) != cageform::Status::ok) return 1;
    for (std::size_t i = 0; i < figure.size(); ++i)
        std::printf("at height %.1f: to the right by %.2f\n", figure[i][1], moved[i][0] - figure[i][0]);
}

//> 8 handles, the head's from 4: ok
//> at height 2.0: to the right by 0.00
//> at height 3.0: to the right by 0.00
//> at height 3.5: to the right by 0.61
//> at height 4.0: to the right by 1.00
//> at height 5.0: to the right by 1.00
