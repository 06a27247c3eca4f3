// 13. A function of your own: in a convex polygon every function f of the distance r to the vertices gives
// coordinates. f = 1 is Wachspress, f = r mean value, f = r² discrete harmonic.
#include <cageform/cageform.hpp>

#include <array>
#include <cmath>
#include <cstdio>

using Point = std::array<double, 2>;

// A template of the number type: it is called with SIMD types and with dual numbers. `rr` is r².
struct Blunt {
    template <class X>
    X operator()(const X& rr) const {
        using std::sqrt;
        return sqrt(X(0.01) + rr);
    }
};

template <class Coordinates>
void print(const char* name, const Coordinates& coordinates, const Point& p) {
    std::array<double, 5> weights{};
    if (weights_at(coordinates, p, std::span(weights)) != cageform::PointState::inside) return;
    std::printf("%-18s", name);
    for (const double w : weights) std::printf(" %6.3f", w);
    std::printf("\n");
}

int main() {
    const std::vector<Point> kite{{0, 0}, {2, -1}, {3, 0}, {2, 1}, {0.5, 0.6}};
    const cageform::Polygon<double> cage(kite);
    const Point p{2.4, 0};
    print("Wachspress", cageform::WachspressCoordinates<double>(cage), p);
    print("mean value", cageform::MeanValueCoordinates<double, 2>(cage), p);
    print("discrete harmonic", cageform::DiscreteHarmonicCoordinates<double>(cage), p);
    print("sqrt(0.01 + r^2)", cageform::ThreePointCoordinates<double, Blunt>(cage), p);

    // In polygons that are not convex the formula has poles: such a cage is an error, with the index of a
    // vertex.
    auto dented = kite;
    dented[4] = {1.5, 0};
    const cageform::WachspressCoordinates<double> refused{cageform::Polygon<double>(dented)};
    const auto& report = refused.cage_report();
    std::printf("%s: vertex %zu\n", to_string(report.status), report.faults[0].a);
}

//> Wachspress          0.048  0.202  0.538  0.185  0.028
//> mean value          0.037  0.213  0.524  0.193  0.034
//> discrete harmonic  -0.031  0.282  0.439  0.242  0.067
//> sqrt(0.01 + r^2)    0.037  0.213  0.524  0.193  0.033
//> these coordinates need one strictly convex loop: vertex 4
