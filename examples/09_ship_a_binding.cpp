// 9. What a game ships: a sparse binding in one piece of memory, opened where it lies.
#include <cageform/binding/pack.hpp>
#include <cageform/cageform.hpp>
#include <cageform/clone/clone.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

using Point = std::array<float, 2>;

int main() {
    // In the editor: a ring of 40 vertices, a figure of 1,000 points.
    std::vector<Point> cage, figure;
    for (int k = 0; k < 40; ++k)
        cage.push_back({std::cos(0.15708f * float(k)), std::sin(0.15708f * float(k))});
    for (int i = 0; i < 1000; ++i) {
        const float radius = 0.95f * std::sqrt(float(i) / 1000), angle = 2.4f * float(i);
        figure.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    const auto bound = cageform::bind(cageform::MeanValueCoordinates2f(cage), figure);
    // The poses that count, those of a clip say: in none of them may a point be off by more than 0.002.
    std::vector<double> poses;
    for (const float bend : {-0.5f, 0.2f, 0.5f}) {
        std::vector<Point> bent;
        for (const auto& [x, y] : cage) bent.push_back({x, y + bend * x * x});
        cageform::append_pose(poses, bent);
    }
    const auto [packed, report] = cageform::pack(bound.binding, {.tolerance = 0.002, .poses = poses});
    if (report.status != cageform::Status::ok) return std::puts(to_string(report.status));
    std::printf("%.0f %% of the bytes, %s\n", 100.0 * double(report.bytes) / double(report.dense_bytes),
                report.distance.value <= 0.002 ? "no point off by more than 0.002" : "too far off");

    // In the game: the bytes of a file, at a multiple of 64. Wrong or broken ones are refused.
    const auto bytes = packed.bytes();
    std::vector<cageform::Lanes<double>> broken(bytes.size() / 64);
    std::memcpy(&broken[0], bytes.data(), bytes.size());
    broken[5][0] = 7;
    std::puts(to_string(cageform::open_blob<float, 2>(std::as_bytes(std::span(broken))).status));
    const auto opened = cageform::open_blob<float, 2>(bytes);
    if (opened.status != cageform::Status::ok) return 1;

    // An affine pose stays exact, whatever was dropped and rounded.
    std::vector<Point> pose, moved(figure.size());
    for (const auto& [x, y] : cage) pose.push_back({2 * x + y, y - x});
    if (clone(opened.binding, pose, moved) != cageform::Status::ok) return 1;
    float worst = 0;
    for (std::size_t i = 0; i < figure.size(); ++i) {
        const auto [x, y] = figure[i];
        worst = std::fmax(worst, std::hypot(moved[i][0] - (2 * x + y), moved[i][1] - (y - x)));
    }
    std::printf("an affine pose is met %s\n", worst < 1e-5f ? "to rounding" : "badly");
}

//> 19 % of the bytes, no point off by more than 0.002
//> the checksum of the packed data differs
//> an affine pose is met to rounding
