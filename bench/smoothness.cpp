// Measures harmonic weights in space: their smoothness, their errors next to the skin, and their cost.
//
//     bench_smoothness [--cage NAME] [--obj FILE] [--turned] [--locality K] [--count COUNT] [--points COUNT]
//                      [--figure FILE] [--box X Y Z] MEASURE [ACCURACY…]
//
// MEASURE is one of:
//
//     lines      Second differences of weights along random lines inside the cage, near its skin.
//     sheet      Angles between adjacent faces of flat sheets in a posed cube, also by mean value.
//     weights    Differences to the weights at the last accuracy, below faces and at random points inside.
//     depths     Differences to the weights on a face, at depths of 0.01 to 0.0001 square roots of its area.
//     plates     Nodes, time and memory of flat boxes. Differences to the weights at the last accuracy.
//                Errors farther from the rim than four thicknesses, where the solution is known.
//     gradients  Differences to the gradients at the last accuracy; jumps of gradients along the lines.
//     pack       Time to pack the points of a figure, or points near the skin.
//     cost       Time to bind them, and to bind them again with the same solution.
//
// At half the step, second differences of a smooth function fall by a factor of four, differences of its
// gradients by two. Jumps do not fall. Lines where they fall by less than 2.5 or 1.6 are counted, unless the
// differences are below 1e-8. These lines are measured again with steps 4,096 times smaller, which keeps only
// jumps. Gradients are multiplied by the square root of the mean face area. --count is for lines and sheets.
// --turned rotates everything by 0.7 radians about (1, 2, 3). Compile with -I of another version's headers to
// measure that version on the same lines and points.
#include "../tests/support/gradients.hpp"
#include "../tests/support/walk_on_spheres.hpp"
#include "named_cages.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <ctime>

namespace {

using namespace cageform_bench;
using cageform::PointState, cageform::Status, cageform::Facet, cageform::detail::length;
using cageform_tests::gradients_of, cageform_tests::larger, cageform_tests::WalkNumbers;
using Point = cageform::Vec<double, 3>;
using Points = std::vector<Point>;
using Mesh = cageform::TriangleMesh<double>;
using Harmonic = cageform::HarmonicCoordinates<double, 3>;

struct Given {
    std::size_t points = 0, count = 0; ///< count: of lines or sheets
    std::vector<double> accuracies;
    Points boxes, figure;
    double angle = 0, locality = 0;

    Mesh turned(const Mesh& mesh) const {
        return {turned(Points(mesh.vertices().begin(), mesh.vertices().end())), mesh.faces()};
    }
    Points turned(Points list) const {
        for (Point& p : list) p = cageform_tests::turned_about_123(p, angle);
        return list;
    }
};

double seconds_since(std::clock_t start) {
    return double(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Ends the program if a step failed.
void demand(Status status) {
    if (status == Status::ok) return;
    std::printf(" %s\n", to_string(status));
    std::exit(1);
}
/// Solves and keeps all functions; prints cage, accuracy and number of nodes.
Harmonic solved(const Given& given, const NamedCage& cage, double accuracy) {
    std::printf("%s, accuracy %g:", cage.name.c_str(), accuracy);
    Harmonic coordinates(cage.mesh, {.accuracy = accuracy, .locality = given.locality});
    const auto [status, solver] = coordinates.solve();
    demand(status);
    std::printf(" %zu nodes;", solver.cells);
    return coordinates;
}
template <class C>
cageform::Binding<double, 3> bound(const C& coordinates, const Points& points) {
    auto binding = cageform::bind(coordinates, points);
    demand(binding.status());
    return std::move(binding.value);
}
template <class Value>
double largest_of(std::size_t count, const Value& value) {
    double largest = 0;
    for (std::size_t i = 0; i < count; ++i) largest = larger(largest, std::fabs(value(i)));
    return largest;
}
void print(const char* what, std::vector<double> of_points) {
    if (of_points.empty()) return;
    const Errors errors(std::move(of_points));
    std::printf(" %s max %.1e, 99 %% %.1e, 90 %% %.1e, median %.1e;", what, errors.at(1), errors.at(0.99),
                errors.at(0.9), errors.at(0.5));
}
void end_row() {
    std::printf("\n");
    std::fflush(stdout);
}

/// A point below a face, and the weights of its foot on the face.
struct Below {
    Point at;
    Facet<3> face;
    std::array<double, 3> weights;
};
/// `face` selects the face (a share of all faces), `depth` is in square roots of its area; s and t select the
/// position.
struct Choice {
    double face, depth, s, t;
};
Below below_face(const Mesh& mesh, const Choice& choice) {
    const Facet<3> face(mesh.faces()[std::size_t(choice.face * double(mesh.faces().size()))],
                        mesh.vertices());
    const auto& [a, b, c] = face.corner;
    const double s = std::sqrt(choice.s), t = choice.t;
    const Point normal = cross(b - a, c - a);
    const auto deep = choice.depth / std::sqrt(2 * length(normal)) * normal;
    return {(1 - s) * a + (s * (1 - t)) * b + (s * t) * c - deep, face, {1 - s, s * (1 - t), s * t}};
}
Point near_skin(const Mesh& mesh, double face, WalkNumbers& numbers) {
    return below_face(mesh, {face, 0.02 + 0.1 * numbers.next(), numbers.next(), numbers.next()}).at;
}
bool is_inside(const Mesh& mesh, const Point& p) {
    return locate(mesh, p, 0.0) == PointState::inside;
}

/// The figure, or points near the skin in face order, without those outside the cage.
Points figure_in(const Mesh& mesh, const Given& given) {
    Points points = given.turned(given.figure);
    for (std::size_t n = 0; n < given.points && given.figure.empty(); ++n) {
        WalkNumbers numbers(23, n);
        const Point p = near_skin(mesh, double(n) / double(given.points), numbers);
        if (is_inside(mesh, p)) points.push_back(p);
    }
    return points;
}

using Line = std::array<Point, 2>;
Points points_on(const Line& line, std::size_t steps) {
    Points points;
    for (std::size_t n = 0; n <= steps; ++n)
        points.push_back(line[0] + (double(n) / double(steps)) * (line[1] - line[0]));
    return points;
}
/// Lines inside the cage between random points near its skin; fewer if most lines leave the cage.
std::vector<Line> lines_near_skin(const Mesh& mesh, std::size_t count) {
    std::vector<Line> lines;
    for (std::size_t n = 0; lines.size() < count && n < 10000 * count; ++n) {
        WalkNumbers numbers(19, n);
        Line line;
        for (Point& end : line) end = near_skin(mesh, numbers.next(), numbers);
        const auto stays = [&](std::size_t steps) {
            const auto points = points_on(line, steps);
            return std::all_of(points.begin(), points.end(),
                               [&](const Point& p) { return is_inside(mesh, p); });
        };
        if (stays(64) && stays(4000)) lines.push_back(line);
    }
    return lines;
}
/// Maximum difference of first or second order between neighbouring rows, and its position.
struct Largest {
    double value = 0;
    std::size_t row = 0;
};
template <class Value>
Largest largest_difference(int order, std::size_t rows, std::size_t columns, const Value& value) {
    Largest largest;
    for (std::size_t i = 1; i + 1 < rows; ++i) {
        for (std::size_t k = 0; k < columns; ++k) {
            const double next = value(i + 1, k) - value(i, k);
            const double change = std::fabs(order == 1 ? next : next - (value(i, k) - value(i - 1, k)));
            if (!(change <= largest.value)) largest = {change, i};
        }
    }
    return largest;
}
/// Prints how the maximum differences along lines change at half the step. If they do not fall, divides the
/// step near the maximum by eight four times.
template <class Find>
void print_lines(const std::vector<Line>& lines, double least, const Find& find) {
    double at_step = 0, at_half = 0, most = 0, left = 0;
    std::size_t count = 0;
    for (const Line& line : lines) {
        const double whole = find(points_on(line, 2000)).value;
        auto points = points_on(line, 4000);
        auto largest = find(points);
        at_step = larger(at_step, whole);
        at_half = larger(at_half, largest.value);
        if (whole <= 1e-8 || whole >= least * largest.value) continue;
        ++count;
        most = larger(most, largest.value);
        for (int round = 0; round < 4; ++round) {
            const std::size_t from = largest.row - (std::min)(largest.row, std::size_t{4});
            const std::size_t to = (std::min)(from + 8, points.size() - 1);
            points = points_on({points[from], points[to]}, 8 * (to - from));
            largest = find(points);
        }
        left = larger(left, largest.value);
    }
    std::printf(
        " %zu lines: largest %.1e, at half the step %.1e; %zu fall by less than %g: at most %.1e, and %.1e "
        "at steps 4,096 times smaller",
        lines.size(), at_step, at_half, count, least, most, left);
}
void measure_lines(const Given& given, const NamedCage& cage) {
    const auto lines = lines_near_skin(cage.mesh, given.count);
    for (const double accuracy : given.accuracies) {
        const auto coordinates = solved(given, cage, accuracy);
        print_lines(lines, 2.5, [&](const Points& points) {
            const auto binding = bound(coordinates, points);
            const auto weight = [&](std::size_t i, std::size_t k) { return binding.weight(i, k); };
            return largest_difference(2, points.size(), cage.mesh.size(), weight);
        });
        end_row();
    }
}
void measure_gradients(const Given& given, const NamedCage& cage) {
    double area = 0;
    for (const auto& face : cage.mesh.faces()) {
        const auto& [a, b, c] = Facet<3>(face, cage.mesh.vertices()).corner;
        area += 0.5 * length(cross(b - a, c - a));
    }
    const double size = std::sqrt(area / double(cage.mesh.faces().size()));
    const auto points = cageform_tests::points_anywhere(cage.mesh, given.points, 18);
    const auto lines = lines_near_skin(cage.mesh, given.count);
    const auto finest = gradients_of(solved(given, cage, given.accuracies.back()), points);
    demand(finest.evaluation.status);
    std::printf(" used as reference\n");
    for (std::size_t n = 0; n + 1 < given.accuracies.size(); ++n) {
        const auto coordinates = solved(given, cage, given.accuracies[n]);
        const auto found = gradients_of(coordinates, points);
        demand(found.evaluation.status);
        std::vector<double> errors;
        for (std::size_t i = 0; i < points.size(); ++i) {
            errors.push_back(size * largest_of(cage.mesh.size(), [&](std::size_t k) {
                                 return length(found.rows[i][k] - finest.rows[i][k]);
                             }));
        }
        print("off by", std::move(errors));
        print_lines(lines, 1.6, [&](const Points& along) {
            const auto [evaluation, states, rows] = gradients_of(coordinates, along);
            demand(evaluation.status);
            const auto part = [&, &all = rows](std::size_t i, std::size_t k) {
                return size * all[i][k / 3][k % 3];
            };
            return largest_difference(1, along.size(), 3 * cage.mesh.size(), part);
        });
        end_row();
    }
}

void measure_weights(const Given& given, const NamedCage& cage) {
    const auto skin = cageform_tests::points_below_faces(cage.mesh, given.points, 17);
    const auto inside = cageform_tests::points_anywhere(cage.mesh, given.points, 18);
    const auto finest = solved(given, cage, given.accuracies.back());
    const auto finest_skin = bound(finest, skin), finest_inside = bound(finest, inside);
    std::printf(" used as reference\n");
    for (std::size_t n = 0; n + 1 < given.accuracies.size(); ++n) {
        const auto coordinates = solved(given, cage, given.accuracies[n]);
        const auto print_errors = [&](const char* what, const Points& points, const auto& right) {
            const auto found = bound(coordinates, points);
            std::vector<double> errors;
            for (std::size_t i = 0; i < points.size(); ++i) {
                errors.push_back(largest_of(cage.mesh.size(), [&](std::size_t k) {
                    return found.weight(i, k) - right.weight(i, k);
                }));
            }
            print(what, std::move(errors));
        };
        print_errors("errors below faces", skin, finest_skin);
        print_errors("inside", inside, finest_inside);
        end_row();
    }
}

void measure_depths(const Given& given, const NamedCage& cage) {
    for (const double accuracy : given.accuracies) {
        const auto coordinates = solved(given, cage, accuracy);
        for (const double depth : {1e-2, 1e-3, 1e-4}) {
            Points points;
            std::vector<Below> known;
            for (std::size_t n = 0; n < given.points; ++n) {
                WalkNumbers numbers(7, n);
                known.push_back(
                    below_face(cage.mesh, {numbers.next(), depth, numbers.next(), numbers.next()}));
                if (is_inside(cage.mesh, known.back().at))
                    points.push_back(known.back().at);
                else
                    known.pop_back();
            }
            const auto binding = bound(coordinates, points);
            std::vector<double> errors;
            for (std::size_t n = 0; n < points.size(); ++n) {
                errors.push_back(largest_of(cage.mesh.size(), [&](std::size_t i) {
                    double off = binding.weight(n, i);
                    for (std::size_t k = 0; k < 3; ++k)
                        off -= known[n].face.vertex[k] == i ? known[n].weights[k] : 0.0;
                    return off;
                }));
            }
            std::printf("\n  depth %g:", depth);
            print("off by", std::move(errors));
        }
        end_row();
    }
}

/// Angles in degrees between the faces of a sheet, two per square.
std::vector<double> bends(const Points& sheet, std::size_t side) {
    const auto normal = [&](std::size_t a, int upper) {
        const Point &p = sheet[a + 1], &q = sheet[a + side], &r = sheet[upper ? a + side + 1 : a];
        return upper ? cross(q - r, p - r) : cross(p - r, q - r);
    };
    std::vector<double> degrees;
    for (std::size_t y = 0; y + 1 < side; ++y) {
        for (std::size_t x = 0; x + 1 < side; ++x) {
            const std::size_t a = y * side + x;
            degrees.push_back(degrees_between(normal(a, 1), normal(a, 0)));
            if (x + 2 < side) degrees.push_back(degrees_between(normal(a, 1), normal(a + 1, 0)));
            if (y + 2 < side) degrees.push_back(degrees_between(normal(a, 1), normal(a + side, 0)));
        }
    }
    return degrees;
}
void measure_sheet(const Given& given) {
    constexpr std::size_t side = 201;
    const auto cube = divided_box<double>({1, 1, 1}, 4);
    Points pose(cube.vertices().begin(), cube.vertices().end());
    for (Point& p : pose) {
        if (p == Point{2, 2, 2}) p = {3.5, 2.8, 3.1};
        if (p == Point{2, -2, 2}) p = {2.4, -2.9, 2.6};
        if (p == Point{-2, 2, -2}) p = {-2, 2, -2.8};
        if (p == Point{-2, -2, -2}) p = {-2.7, -1.6, -3};
    }
    const auto print_bends = [&](const auto& coordinates) {
        std::vector<double> degrees;
        for (std::size_t n = 0; n < given.count; ++n) {
            WalkNumbers numbers(31, n);
            Points sheet(side * side);
            const Point at{numbers.next(), numbers.next(), numbers.next()};
            for (std::size_t i = 0; i < sheet.size(); ++i) {
                const double x = 0.002 * double(i % side), y = 0.002 * double(i / side);
                sheet[i] = Point{-1.9, -1.9, -1.9} + 3.4 * at + Point{x, y, 0.2 * x + 0.15 * y};
            }
            demand(clone(bound(coordinates, given.turned(sheet)), pose, sheet));
            const auto found = bends(sheet, side);
            degrees.insert(degrees.end(), found.begin(), found.end());
        }
        const Errors sorted(std::move(degrees));
        std::printf(" largest bend %.3f degrees, 99 %% %.3f, median %.4f, in %zu sheets", sorted.at(1),
                    sorted.at(0.99), sorted.at(0.5), given.count);
        end_row();
    };
    for (const double accuracy : given.accuracies) {
        std::printf("sheets, accuracy %g:", accuracy);
        Harmonic coordinates(given.turned(cube), {.accuracy = accuracy});
        demand(coordinates.solve().status);
        print_bends(coordinates);
    }
    std::printf("sheets, mean value:");
    print_bends(cageform::MeanValueCoordinates(given.turned(cube)));
}

/// Weights far from the rim of a box whose floor and lid are split along u = v. They are linear in u, v and
/// |u - v|. In units of the thickness, the extension of |s| at z = 0 and 0 at z = 1 is |s| (1 - z) + sum 2/(n
/// pi)^2 sin(n pi z) exp(-n pi |s|).
std::array<double, 8> weights_in_plate(const Point& size, const Point& p) {
    const double u = p[0] / size[0], v = p[1] / size[1];
    const double unit = std::hypot(size[0], size[1]) / (size[0] * size[1]) * size[2]; // |u - v| where |s| = 1
    std::array<double, 8> weights{};
    for (std::size_t lid = 0; lid < 2; ++lid) {
        const double s = std::fabs(u - v) / unit, z = lid == 0 ? p[2] / size[2] : 1 - p[2] / size[2];
        double kink = s * (1 - z);
        for (int n = 1; n < 400; ++n) {
            const double k = n * std::numbers::pi;
            kink += 2 / (k * k) * std::sin(k * z) * std::exp(-k * s);
        }
        const double sum = (u + v) * (1 - z), difference = (u - v) * (1 - z);
        const std::array twice{2 * (1 - z) - sum, difference, sum, -difference};
        for (std::size_t k = 0; k < 4; ++k)
            weights[4 * lid + k] = 0.5 * (twice[k] + (k % 2 == 0 ? -unit : unit) * kink);
    }
    return weights;
}
void measure_plates(const Given& given) {
    for (const Point& size : given.boxes) {
        const double x = size[0], y = size[1], z = size[2];
        Points points, turned;
        for (std::size_t n = 0; n < given.points; ++n) { // everywhere, near the rim, near the split
            WalkNumbers numbers(29, n);
            Point p{x * numbers.next(), y * numbers.next(), z * numbers.next()};
            if (n % 3 == 1) p[n % 2] *= (std::min)(1.0, 4 * z / size[n % 2]);
            if (n % 3 == 2) p[1] = y * p[0] / x + z * (2 * numbers.next() - 1);
            if (!(p[1] > 0 && p[1] < y)) continue;
            points.push_back(p);
            turned.push_back(cageform_tests::turned_about_123(p, 1)); // like the prisms
        }
        const auto box = prism({{0, 0}, {x, 0}, {x, y}, {0, y}}, {{0, 1, 2}, {0, 2, 3}}, z);
        std::vector<std::array<double, 8>> last;
        for (std::size_t k = given.accuracies.size(); k-- > 0;) {
            const auto start = std::clock();
            const double accuracy = given.accuracies[k];
            const auto [weights, report] =
                cageform::bind(Harmonic(given.turned(box), {.accuracy = accuracy}), given.turned(turned));
            std::printf("plate %g x %g x %g, accuracy %g: %zu nodes; %s; %.2f s, %.0f MB;", x, y, z, accuracy,
                        report.solver.cells, to_string(report.status), seconds_since(start),
                        double(report.solver.bytes) / 1e6);
            std::vector<double> errors, apart;
            for (std::size_t n = 0; report.status == Status::ok && n < points.size(); ++n) {
                std::array<double, 8> row{};
                for (std::size_t i = 0; i < 8; ++i) row[i] = weights.weight(n, i);
                const auto off = [&](const std::array<double, 8>& right) {
                    return largest_of(8, [&](std::size_t i) { return row[i] - right[i]; });
                };
                const Point& p = points[n];
                if ((std::min)({p[0], x - p[0], p[1], y - p[1]}) > 4 * z)
                    errors.push_back(off(weights_in_plate(size, p)));
                if (last.size() == n) last.push_back(row);
                apart.push_back(off(last[n]));
            }
            print("errors far from the rim", std::move(errors));
            if (k + 1 < given.accuracies.size()) print("difference to the last", std::move(apart));
            end_row();
        }
    }
}

void measure_pack(const Given& given, const NamedCage& cage) {
    const auto points = figure_in(cage.mesh, given);
    for (const double accuracy : given.accuracies) {
        const auto coordinates = solved(given, cage, accuracy);
        const auto start = std::clock();
        demand(pack(coordinates, points, cageform::StreamedPackOptions{}).status());
        std::printf(" %zu points x %zu handles packed in %.2f s", points.size(), cage.mesh.size(),
                    seconds_since(start));
        end_row();
    }
}
void measure_cost(const Given& given, const NamedCage& cage) {
    const auto points = figure_in(cage.mesh, given);
    if (points.empty()) return;
    const auto seconds_of_bind = [&](const Harmonic& coordinates) {
        const auto start = std::clock();
        (void)bound(coordinates, points);
        return seconds_since(start);
    };
    for (const double accuracy : given.accuracies) {
        const double whole = seconds_of_bind(Harmonic(cage.mesh, {.accuracy = accuracy}));
        const auto coordinates = solved(given, cage, accuracy);
        std::vector<double> again(9);
        for (double& seconds : again) seconds = seconds_of_bind(coordinates);
        std::printf(" %zu points bound in %.3f s; again %.1f us a point (median of nine)", points.size(),
                    whole, 1e6 * Errors(again).at(0.5) / double(points.size()));
        end_row();
    }
}

/// A measure, with its default numbers.
struct Measure {
    std::string name;
    std::size_t points, count;
    std::vector<double> accuracies;
    void (*in_cage)(const Given&, const NamedCage&); ///< null if the measure has its own cages
    void (*without_cage)(const Given&) = nullptr;
};

} // namespace

int main(int argc, char** argv) {
    Given given;
    std::string name;
    CommandLine line("bench_smoothness", argc, argv);
    while (line.next()) {
        if (line.word() == "--turned")
            given.angle = 0.7;
        else if (line.word() == "--locality")
            given.locality = line.number<double>();
        else if (line.word() == "--count")
            given.count = line.number<std::size_t>();
        else if (line.word() == "--points")
            given.points = line.number<std::size_t>();
        else if (line.word() == "--figure")
            given.figure = line.mesh().vertices;
        else if (line.word() == "--box")
            given.boxes.push_back({line.number<double>(), line.number<double>(), line.number<double>()});
        else if (name.empty())
            name = line.word();
        else
            given.accuracies.push_back(line.accuracy());
    }
    if (given.boxes.empty()) given.boxes = {{4, 4, 0.1}, {20, 20, 0.1}, {200, 200, 0.02}};
    const std::vector<Measure> measures{{"lines", 1, 100, {1e-3}, measure_lines},
                                        {"sheet", 1, 12, {1e-2, 1e-3}, nullptr, measure_sheet},
                                        {"weights", 2000, 1, {2e-3, 2e-4}, measure_weights},
                                        {"depths", 3000, 1, {1e-3}, measure_depths},
                                        {"plates", 3000, 1, {1e-3}, nullptr, measure_plates},
                                        {"gradients", 400, 20, {1e-3, 1e-4}, measure_gradients},
                                        {"pack", 100000, 1, {2e-3}, measure_pack},
                                        {"cost", 8066, 1, {1e-3}, measure_cost}};
    const auto measure = std::find_if(measures.begin(), measures.end(),
                                      [&](const Measure& known) { return known.name == name; });
    if (measure == measures.end()) {
        std::string names;
        for (const Measure& known : measures) names += ' ' + known.name;
        line.refuse("missing measure, one of" + names);
    }
    if (given.points == 0) given.points = measure->points;
    if (given.count == 0) given.count = measure->count;
    if (given.accuracies.empty()) given.accuracies = measure->accuracies;
    if (measure->without_cage != nullptr) return measure->without_cage(given), 0;
    for (const auto& cage : line.cages())
        measure->in_cage(given, NamedCage{cage.name, given.turned(cage.mesh)});
}
