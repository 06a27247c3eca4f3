// 4. Two coordinate types behind one concept. In a cage with two legs, a vertex of one leg has negative mean
// value weights in the other leg. Moving one leg therefore moves the other in the opposite direction.
// Harmonic weights are non-negative.
#include <cageform/cageform.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 2>;

// Legs from y = 0 to 4 with a narrow gap between them, a body above.
const std::array<Point, 8> cage{{{0, 0}, {1.9, 0}, {1.9, 4}, {2.1, 4}, {2.1, 0}, {4, 0}, {4, 6}, {0, 6}}};
const std::array<Point, 1> right_knee{{{2.3, 2}}};

namespace {

template <cageform::CageCoordinates Coordinates>
void report_weights(const char* name, const Coordinates& coordinates) {
    const auto [binding, report] = cageform::bind(coordinates, right_knee);
    if (report.status != cageform::Status::ok) {
        std::printf("%s: %s\n", name, cageform::to_string(report.status));
        return;
    }
    // Vertex 1 is the inner toe of the left leg.
    std::printf("%-10s weight of the left toe %5.2f, least weight %5.2f\n", name, binding.weight(0, 1),
                report.least_weight.value);
}

} // namespace

int main() {
    report_weights("mean value", cageform::MeanValueCoordinates(cage));

    // Harmonic coordinates are solved on a grid. Long solves report progress and can be cancelled.
    cageform::HarmonicOptions options;
    options.resolution = 96;
    const cageform::HarmonicCoordinates harmonic(cage, options, cageform::UniformGrid{});
    report_weights("harmonic", harmonic);

    const cageform::Running impatient{.progress = [](double done) { return done < 0.3; }};
    std::printf("stopped at 30 %%: %s\n",
                cageform::to_string(cageform::bind(harmonic, right_knee, {}, impatient).report.status));
}

//> mean value weight of the left toe -0.30, least weight -0.33
//> harmonic   weight of the left toe  0.00, least weight  0.00
//> stopped at 30 %: cancelled by the progress callback
