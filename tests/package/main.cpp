#include <cageform/cageform.hpp>

#include <array>

int main() {
    using Point = std::array<float, 2>;
    const std::array<Point, 3> cage{{{0, 0}, {0, 3}, {3, 3}}};
    const std::array<Point, 1> figure{{{1, 2}}};
    const auto [binding, report] = cageform::bind(cageform::BarycentricCoordinates<float, 2>(cage), figure);
    std::array<Point, 1> out{};
    if (report.status != cageform::Status::ok) return 1;
    if (cageform::clone(binding, cage, out) != cageform::Status::ok) return 2;
    return out == figure ? 0 : 3;
}
