// A bind and a clone by mingw-w64, as a program for Windows.
#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <array>
#include <vector>

int main() {
    using Point = std::array<double, 2>;
    const std::vector<Point> cage{{0, 0}, {4, 0}, {4, 2}, {0, 2}}, figure{{1, 1}, {2, 1}};
    const auto [binding, report] = cageform::bind(cageform::MeanValueCoordinates<double, 2>(cage), figure);
    std::vector<Point> out(figure.size());
    if (report.status != cageform::Status::ok) return 1;
    if (cageform::clone(binding, cage, out) != cageform::Status::ok) return 2;
    return out == figure ? 0 : 3;
}
