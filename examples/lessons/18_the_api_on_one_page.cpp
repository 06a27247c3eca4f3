// 18. The API on one page: everything that most programs call, in the order of use.
//
// Functions that create objects return a Result: a value, and a report with a status. Functions that write
// into the caller's memory return a Status. Arguments come in this order: inputs, options, then running
// (threads and progress).
#include <cageform/animate/compile.hpp>
#include <cageform/binding/any_coordinates.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/cageform.hpp>
#include <cageform/enclose/make_cage.hpp>
#include <cageform/runtime.hpp>

#include <cstdio>

using namespace cageform;
using Points = std::vector<Vec<float, 2>>;

/// A coordinate type that is chosen at run time.
AnyCoordinates<float, 2> coordinates_of(const Polygon<float>& cage, bool harmonic) {
    if (harmonic) return HarmonicCoordinates(cage, {.accuracy = 1e-3});
    return MeanValueCoordinates(cage);
}

int main() {
    // A cage: drawn by hand, or made around a figure. check() lists its faults.
    const std::vector<DrawnSegment<float>> drawing{{{0, 0}, {8, 0}, 1}, {{8, 0}, {8, 6}, 1}};
    const auto [cage, made] = make_cage(drawing, {.vertices = 12});
    std::printf("make_cage: %s, %zu vertices, check: %s\n", to_string(made.status), cage.size(),
                to_string(check(cage).status));

    // Bind points, or a figure of points and normals, once.
    const Points points{{1, 0}, {7, 0}, {8, 5}}, normals{{0, 1}, {0, 1}, {1, 0}};
    const auto coordinates = coordinates_of(cage, true);
    const auto [binding, of_points] = cageform::bind(coordinates, points);
    const auto [figure, of_figure] = cageform::bind(coordinates, FigurePoints{points, normals});
    std::printf("bind: %s, %zu points outside, %s\n", to_string(of_points.status), of_points.outside.size(),
                to_string(of_figure.status));

    // Pack within a tolerance. Open the bytes in place.
    const auto [packed, size] = pack(figure, {.weights = {.tolerance = 0.01}});
    const auto [opened, of_file] = open<float, 2>(packed.bytes());
    std::printf("pack: %s, open: %s\n", to_string(size.status), to_string(of_file.status));

    // Compile key frames to a motion of the cage: one curve for each coordinate of each vertex.
    std::vector<std::vector<Key>> keys(2 * cage.size());
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const float at = cage.vertices()[k / 2][k % 2];
        for (const float time : {0.f, 1.f}) {
            Key key;
            key.time = time;
            key.value = k % 2 == 0 ? at : at * (1 + time / 2); // the cage grows to 1.5 times its height
            keys[k].push_back(key);
        }
    }
    const auto [clip, compiled] = compile<float, 2>(keys);
    std::printf("compile: %s, within 1e-6: %d\n", to_string(compiled.status), compiled.sup_error < 1e-6);

    // Every frame: the pose of the cage, and the clone of the figure, without allocation.
    auto cursor = clip.make_cursor();
    Points pose(cage.size()), out(points.size()), out_normals(points.size());
    clip.sample(1, cursor, pose);
    Status status = clone(binding, pose, out);
    std::printf("clone: %s, the last point at %.2f %.2f\n", to_string(status), out[2][0], out[2][1]);
    status = clone(opened, pose, FigureOutput{out, out_normals});
    std::printf("clone of the packed figure: %s, at %.2f %.2f\n", to_string(status), out[2][0], out[2][1]);
}

//> make_cage: ok, 12 vertices, check: ok
//> bind: ok, 0 points outside, ok
//> pack: ok, open: ok
//> compile: ok, within 1e-6: 1
//> clone: ok, the last point at 8.00 7.50
//> clone of the packed figure: ok, at 8.00 7.50
