// 21. Pins: a solver finds the pose of the cage that moves pinned points of the figure to targets and deforms
// the rest as rigidly as possible.
#include <cageform/cageform.hpp>

#include <cmath>
#include <cstdio>

using Point = cageform::Vec<double, 2>;

int main() {
    // The cage of a person who stands with arms held out.
    const std::vector<Point> cage{{-6, -1.5}, {-2.5, -1.5}, {0, 5.5}, {2.5, -1.5}, {6, -1.5},  {2.2, 9},
                                  {2.2, 11},  {9, 10},      {9, 14},  {3, 15.8},   {4, 21},    {0, 24},
                                  {-4, 21},   {-3, 15.8},   {-9, 14}, {-9, 10},    {-2.2, 11}, {-2.2, 9}};
    const cageform::MeanValueCoordinates<double, 2> coordinates(cage);

    // Once: sample the inside. Packed samples ship with a game, alone or in a figure.
    const auto samples = cageform::pose_samples(coordinates);
    const auto shipped = pack(samples.value);
    if (!samples || !shipped) return std::puts(to_string(samples.status()));
    auto opened = cageform::open_pose_samples<double, 2>(shipped.value.bytes());
    cageform::PoseSolver<double, 2> solver(std::move(opened.value));

    // A click: pins on two feet, the head and the right hand. Pins are bound like all points.
    const std::vector<Point> pins{{-4, 0}, {4, 0}, {0, 20}, {7, 12}};
    const auto binding = cageform::bind(coordinates, pins);
    cageform::Status status = solver.set_pins({.binding = binding.value.view()});
    if (status != cageform::Status::ok) return std::puts(to_string(status));

    // A drag: the hand moves up in 20 frames. Then solve until the figure settles.
    const std::vector<Point> seen{{7, 12}, {3.5, 13}, {-7, 12}, {0, 8}}; // right hand, arm, left hand, hips
    const auto figure = cageform::bind(coordinates, seen);
    std::vector<Point> targets = pins, pose(cage.size()), out(seen.size());
    cageform::PoseSolverReport report;
    for (int frame = 1; frame < 60 && !(frame > 20 && report.settled); ++frame) {
        const double part = std::fmin(frame / 20.0, 1);
        targets[3] = {7 - 1.5 * part, 12 + 6.5 * part};
        report = solver.solve(targets, pose);
    }
    status = clone(figure.value, pose, out);
    if (status != cageform::Status::ok) return std::puts(to_string(status));
    const char* const names[] = {"right hand", "right arm", "left hand", "hips"};
    for (std::size_t n = 0; n < seen.size(); ++n)
        std::printf("%-10s moves by %5.2f, %5.2f\n", names[n], out[n][0] - seen[n][0] + 0.0,
                    out[n][1] - seen[n][1] + 0.0);
    std::printf("settled: %s, pins missed by less than 0.01: %s, parts turned inside out: %zu\n",
                report.settled ? "yes" : "no", report.miss < 0.01 ? "yes" : "no", report.folded);

    // A pin can rotate: the head by half a radian. This needs the gradients of the weights.
    const auto axes = cageform::bind_jacobians(coordinates, pins);
    const std::uint8_t turned[] = {0, 0, 1, 0};
    status = solver.set_pins({.binding = binding.value.view(),
                              .axes = {axes.value[0].view(), axes.value[1].view()},
                              .turned = turned});
    if (status != cageform::Status::ok) return std::puts(to_string(status));
    const cageform::PoseTurn<2> turns[] = {{}, {}, {0.5}, {}};
    for (int frame = 0; frame < 40; ++frame) report = solver.solve(targets, pose, turns);
    const std::vector<Point> head{{0, 19}, {0, 21}};
    status = clone(cageform::bind(coordinates, head).value, pose, out);
    if (status != cageform::Status::ok) return std::puts(to_string(status));
    std::printf("the head turns by %.1f radians\n", std::atan2(out[0][0] - out[1][0], out[1][1] - out[0][1]));
}

//> right hand moves by -1.50,  6.50
//> right arm  moves by -1.06,  3.36
//> left hand  moves by -0.07, -0.45
//> hips       moves by -0.01,  0.72
//> settled: yes, pins missed by less than 0.01: yes, parts turned inside out: 0
//> the head turns by 0.5 radians
