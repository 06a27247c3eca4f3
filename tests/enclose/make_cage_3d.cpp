// Laws of 3D cages.

#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"

#include <cageform/cage/detail/shells.hpp>
#include <cageform/enclose/make_cage_3d.hpp>
#include <cageform/parallel/threads.hpp>

#include <algorithm>
#include <map>

namespace make_cage_3d_tests {

using namespace cageform;
using namespace cageform_tests;

template <class T>
struct Figure {
    std::vector<Vec<T, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;

    /// Adds faces between rings of `columns` vertices, closed along the rings and optionally across.
    void add_rings(std::size_t first, std::size_t rings, std::size_t columns, bool closed) {
        for (std::size_t i = 0; i + (closed ? 0 : 1) < rings; ++i) {
            for (std::size_t j = 0; j < columns; ++j) {
                const auto at = [&](std::size_t a, std::size_t b) {
                    return std::uint32_t(first + a % rings * columns + b % columns);
                };
                faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            }
        }
    }
};

template <class T>
Figure<T> torus(double large, double small) {
    Figure<T> figure;
    constexpr int rings = 24, columns = 10;
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < columns; ++j) {
            const double u = 2 * std::numbers::pi * i / rings, v = 2 * std::numbers::pi * j / columns;
            const double r = large + small * std::cos(v);
            figure.vertices.push_back({T(r * std::cos(u)), T(r * std::sin(u)), T(small * std::sin(v))});
        }
    }
    figure.add_rings(0, rings, columns, true);
    return figure;
}

template <class T>
void add_ball(Figure<T>& figure, const Vec<double, 3>& middle, double radius) {
    constexpr int rings = 7, columns = 8;
    const std::size_t first = figure.vertices.size();
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < columns; ++j) {
            const double u = std::numbers::pi * (i + 0.5) / rings, v = 2 * std::numbers::pi * j / columns;
            figure.vertices.push_back({T(middle[0] + radius * std::sin(u) * std::cos(v)),
                                       T(middle[1] + radius * std::sin(u) * std::sin(v)),
                                       T(middle[2] + radius * std::cos(u))});
        }
    }
    figure.add_rings(first, rings, columns, false); // open at both ends
}

/// Random triangles, some in chains, at any scale.
template <class T>
Figure<T> random_soup(std::uint64_t seed) {
    Random random(seed);
    Figure<T> figure;
    const double size = std::pow(10.0, random.uniform(-4, 4));
    const Vec<double, 3> shift{size * random.uniform(-3, 3), size * random.uniform(-3, 3),
                               size * random.uniform(-3, 3)};
    for (std::size_t n = 3 + random.below(12); n > 0; --n) {
        const auto first = std::uint32_t(figure.vertices.size());
        for (int k = 0; k < 3; ++k) {
            Vec<T, 3> p;
            for (std::size_t axis = 0; axis < 3; ++axis)
                p[axis] = T(shift[axis] + size * random.uniform(0, 1));
            figure.vertices.push_back(p);
        }
        const bool chained = first > 0 && random.below(2) == 0;
        figure.faces.push_back({chained ? first - 1 : first, first + 1, first + 2});
    }
    return figure;
}

bool is_cage(const CageReport& report) {
    return report.status == Status::ok && report.faults.empty();
}

/// The minimum distance of sampled points of the figure from the cage; negative if a point is outside.
template <class T>
double sampled_clearance(const TriangleMesh<T>& cage, const Figure<T>& figure) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& face : figure.faces) {
        for (const auto& weights : {Vec<double, 3>{1, 0, 0}, Vec<double, 3>{0, 1, 0},
                                    Vec<double, 3>{0, 0.5, 0.5}, Vec<double, 3>{0.3, 0.3, 0.4}}) {
            Vec<double, 3> p{};
            for (std::size_t k = 0; k < 3; ++k)
                p = p + weights[k] * vec_cast<double>(figure.vertices[face[k]]);
            double nearest = std::numeric_limits<double>::infinity();
            for (const auto& f : cage.faces())
                nearest =
                    std::min(nearest, detail::distance_to_facet(p, Facet<3>(f, cage.vertices()).corner));
            const bool inside = detail::is_enclosed(winding_number(cage, vec_cast<T>(p)));
            least = std::min(least, inside ? nearest : -nearest);
        }
    }
    return least;
}

TEMPLATE_TEST_CASE("a 3D cage contains its figure and keeps the margin", "[enclose][property]",
                   CAGEFORM_SCALARS) {
    constexpr std::uint64_t first = std::is_same_v<TestType, float> ? 0 : 2;
    for (std::uint64_t seed = first; seed < first + 2; ++seed) {
        CAPTURE(seed);
        const auto figure = random_soup<TestType>(seed);
        MakeCageOptions options;
        Random random(seed + 1000);
        options.vertices = 40 + random.below(60);
        options.margin = random.uniform(0.09, 0.12);
        const auto made = make_cage(figure.vertices, figure.faces, options);
        REQUIRE(to_string(made.report.status) == std::string("ok"));
        CHECK(is_cage(check(made.value)));
        CHECK(made.value.size() == options.vertices);
        CHECK(made.report.vertices == options.vertices);
        CHECK(made.report.clearance >= 0.9 * made.report.margin);
        const double sampled = sampled_clearance(made.value, figure);
        // A sampled minimum is an upper bound of the minimum over the faces.
        CHECK(sampled >= made.report.clearance * (1 - 1e-5));
        CHECK(made.report.area > 0.9 * made.report.tightest_area);
        CHECK(made.report.least_angle > 0.5);
    }
}

TEST_CASE("a cage keeps tunnels, or fills them", "[enclose]") {
    const auto figure = torus<double>(1, 0.3);
    MakeCageOptions options;
    options.vertices = 60;
    options.margin = 0.08;
    const auto kept = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(kept);
    CHECK(kept.report.tunnels == 1);
    CHECK(is_cage(kept.report.cage));
    CHECK_FALSE(detail::is_enclosed(winding_number(kept.value, {0, 0, 0})));
    options.fill_tunnels = true;
    const auto filled = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(filled);
    CHECK(filled.report.tunnels == 0);
    CHECK(is_cage(filled.report.cage));
    CHECK(detail::is_enclosed(winding_number(filled.value, {0, 0, 0})));
    CHECK(filled.report.area > kept.report.area);
    CHECK(sampled_clearance(filled.value, figure) > 0.9 * filled.report.margin);
}

TEST_CASE("a cage has more vertices than requested if its tunnel needs them", "[enclose]") {
    const auto figure = torus<double>(1, 0.3);
    MakeCageOptions options;
    options.vertices = 4;
    options.margin = 0.08;
    const auto made = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(made);
    CHECK(made.report.tunnels == 1);
    CHECK(made.report.vertices == made.value.size());
    CHECK(made.value.size() >= 7); // minimum for a torus
    CHECK(made.value.size() < 24);
    CHECK(is_cage(check(made.value)));
    CHECK(sampled_clearance(made.value, figure) >= 0.9 * made.report.margin);
}

TEST_CASE("several tunnels are counted", "[enclose]") {
    Figure<double> ladder;
    const auto add_board = [&](double x, double y, double width, double height) {
        const auto first = std::uint32_t(ladder.vertices.size());
        ladder.vertices.insert(
            ladder.vertices.end(),
            {{x, y, 0}, {x + width, y, 0}, {x + width, y + height, 0}, {x, y + height, 0}});
        ladder.faces.push_back({first, first + 1, first + 2});
        ladder.faces.push_back({first, first + 2, first + 3});
    };
    constexpr int steps = 4;
    for (int k = 0; k < steps; ++k) add_board(k, 0, 0.1, 1);
    for (const double y : {0.0, 1.0}) add_board(0, y, steps - 0.9, 0.1);
    MakeCageOptions options;
    options.vertices = 80;
    options.margin = 0.05;
    const auto made = make_cage(ladder.vertices, ladder.faces, options);
    REQUIRE(made);
    CHECK(made.report.tunnels == steps - 1);
    CHECK(is_cage(made.report.cage));
}

TEST_CASE("separate balls: one cage with bridges, or one shell each", "[enclose]") {
    Figure<double> figure;
    add_ball(figure, {0, 0, 0}, 1);
    add_ball(figure, {3, 0.5, 0}, 0.8);
    add_ball(figure, {1, 3, 1}, 0.6);
    MakeCageOptions options;
    options.vertices = 60;
    options.margin = 0.05;
    const auto one = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(one);
    CHECK(one.report.components == 3);
    CHECK(one.report.bridges == 2);
    CHECK(cageform::detail::shells_of(one.value).first_face.size() == 1);
    options.one_cage = false;
    const auto each = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(each);
    CHECK(each.report.bridges == 0);
    CHECK(cageform::detail::shells_of(each.value).first_face.size() == 3);
    CHECK(each.value.size() == 60);
    CHECK(is_cage(each.report.cage));
    CHECK(each.report.tightest_area < one.report.tightest_area);
    CHECK(sampled_clearance(each.value, figure) > 0.9 * each.report.margin);
}

TEMPLATE_TEST_CASE("a mirrored 3D cage is symmetric", "[enclose][property]", CAGEFORM_SCALARS) {
    for (const std::size_t axis : {0u, 1u, 2u}) {
        CAPTURE(axis);
        const auto figure = random_soup<TestType>(7);
        MakeCageOptions options;
        options.vertices = 50;
        options.margin = 0.1;
        options.mirror = MirrorPlane{axis, {}};
        if (axis == 1) options.mirror->position = double(figure.vertices[figure.faces[0][1]][1]);
        const auto made = make_cage(figure.vertices, figure.faces, options);
        REQUIRE(to_string(made.report.status) == std::string("ok"));
        CHECK(is_cage(made.report.cage));
        CHECK(made.value.size() + 1 >= options.vertices);
        CHECK(made.value.size() <= options.vertices);
        CHECK(sampled_clearance(made.value, figure) > 0.89 * made.report.margin);
        const auto vertices = made.value.vertices();
        const auto box = bounds_of(vertices);
        const double middle = (double(box.lower[axis]) + double(box.upper[axis])) / 2;
        double worst = 0;
        std::vector<std::uint32_t> image(vertices.size());
        for (std::size_t v = 0; v < vertices.size(); ++v) {
            auto p = vec_cast<double>(vertices[v]);
            p[axis] = 2 * middle - p[axis];
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t w = 0; w < vertices.size(); ++w) {
                const double distance = detail::length(vec_cast<double>(vertices[w]) - p);
                if (distance < nearest) image[v] = std::uint32_t(w);
                nearest = std::min(nearest, distance);
            }
            worst = larger(worst, nearest);
        }
        CHECK(worst <= double(coincidence_tolerance(box)));
        // Faces map to reversed faces.
        std::map<std::array<std::uint32_t, 3>, int> faces;
        const auto sorted_from_least = [](std::array<std::uint32_t, 3> face) {
            std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
            return face;
        };
        for (const auto& face : made.value.faces()) ++faces[sorted_from_least(face)];
        for (const auto& face : made.value.faces())
            CHECK(faces.count(sorted_from_least({image[face[0]], image[face[2]], image[face[1]]})) == 1);
    }
}

TEST_CASE("translating or scaling a 3D figure by powers of two does the same to the cage", "[enclose]") {
    Random random(5);
    Figure<double> figure, moved;
    for (int k = 0; k < 30; ++k)
        figure.vertices.push_back(
            {double(random.below(64)), double(random.below(64)), double(random.below(64))});
    for (const auto& p : figure.vertices) moved.vertices.push_back(4.0 * p + Vec<double, 3>{1024, -512, 256});
    for (std::uint32_t k = 0; k < 10; ++k) figure.faces.push_back({3 * k, 3 * k + 1, 3 * k + 2});
    moved.faces = figure.faces;
    MakeCageOptions options;
    options.vertices = 50;
    options.margin = 0.12;
    const auto made = make_cage(figure.vertices, figure.faces, options);
    const auto again = make_cage(figure.vertices, figure.faces, options);
    const auto other = make_cage(moved.vertices, moved.faces, options);
    REQUIRE(made);
    REQUIRE(other);
    REQUIRE(made.value.size() == other.value.size());
    for (std::size_t i = 0; i < made.value.size(); ++i) {
        CHECK(made.value[i] == again.value[i]);
        CHECK(detail::length(other.value[i] - (4.0 * made.value[i] + Vec<double, 3>{1024, -512, 256})) <=
              1e-10);
    }
    CHECK(std::ranges::equal(made.value.faces(), other.value.faces()));
}

TEMPLATE_TEST_CASE("invalid 3D figures and options are reported", "[enclose][error]", CAGEFORM_SCALARS) {
    using Solid = Figure<TestType>;
    const TestType nan = std::numeric_limits<TestType>::quiet_NaN(),
                   huge = std::numeric_limits<TestType>::max();
    Solid sound;
    sound.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}}; // the last vertex has no face
    sound.faces = {{0, 1, 2}};
    MakeCageOptions quick;
    quick.vertices = 20;
    quick.margin = 0.1;
    const auto status = [](const Solid& figure, const MakeCageOptions& options, std::size_t culprit = 0) {
        const auto made = make_cage(figure.vertices, figure.faces, options);
        CHECK(made.value.size() == (made ? made.report.vertices : 0));
        if (!made) CHECK(made.report.culprit == culprit);
        return made.report.status;
    };
    CHECK(status(sound, quick) == Status::ok);
    CHECK(status({}, quick) == Status::figure_empty);
    Solid without_faces = sound;
    without_faces.faces.clear();
    CHECK(status(without_faces, quick) == Status::figure_empty);
    Solid point = sound;
    point.faces = {{1, 1, 1}};
    CHECK(status(point, quick) == Status::figure_has_no_size);
    Solid line = sound;
    line.faces = {{0, 1, 1}};
    CHECK(status(line, quick) == Status::ok);
    Solid beyond = sound;
    beyond.faces.push_back({0, 4, 1});
    CHECK(status(beyond, quick, 1) == Status::index_out_of_range);
    for (const TestType bad : {nan, huge, -huge, std::numeric_limits<TestType>::infinity()}) {
        Solid figure = sound;
        figure.vertices[2][1] = bad;
        CHECK(status(figure, quick, 2) == Status::figure_not_finite);
    }
    for (const std::size_t vertices : {1u, 2u, 3u}) {
        MakeCageOptions options = quick;
        options.vertices = vertices;
        CHECK(status(sound, options) == Status::too_few_cage_vertices);
    }
    MakeCageOptions options = quick;
    options.margin = std::numeric_limits<double>::quiet_NaN();
    CHECK(status(sound, options) == Status::margin_not_positive);
    options.margin = 1e-4;
    CHECK(status(sound, options) == Status::margin_too_small);
    options = quick;
    options.mirror = MirrorPlane{3, {}};
    CHECK(status(sound, options) == Status::mirror_not_supported);
}

TEST_CASE("3D make_cage reports progress and can be cancelled", "[enclose]") {
    const auto figure = random_soup<double>(3);
    MakeCageOptions options;
    options.vertices = 50;
    options.margin = 0.1;
    std::vector<double> told;
    cageform::Running running;
    running.progress = [&](double done) {
        told.push_back(done);
        return true;
    };
    REQUIRE(make_cage(figure.vertices, figure.faces, options, running));
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.back() == 1);
    for (const std::size_t stop : {std::size_t{0}, std::size_t{1}, told.size() / 2, told.size() - 1}) {
        std::size_t calls = 0;
        running.progress = [&](double) { return calls++ < stop; };
        const auto made = make_cage(figure.vertices, figure.faces, options, running);
        CHECK(made.report.status == Status::cancelled);
        CHECK(made.value.size() == 0);
    }
}

TEST_CASE("a 3D cage does not depend on the number of threads", "[enclose]") {
    MakeCageOptions plain;
    plain.vertices = 40;
    plain.margin = 0.08;
    MakeCageOptions mirrored = plain;
    mirrored.mirror = MirrorPlane{2, {}};
    mirrored.fill_tunnels = true;
    const std::array cases{std::pair(torus<double>(1, 0.3), mirrored),
                           std::pair(random_soup<double>(5), plain)};
    for (const auto& [figure, options] : cases) {
        std::vector<double> told;
        const auto made_by = [&](unsigned threads) {
            told.clear();
            const cageform::Running running{.parallel = ThreadedFor{threads}, .progress = [&](double done) {
                                                told.push_back(done);
                                                return true;
                                            }};
            return make_cage(figure.vertices, figure.faces, options, running);
        };
        const auto alone = made_by(1);
        const auto told_alone = told;
        REQUIRE(alone);
        for (const unsigned threads : {2U, 3U, 7U}) {
            CAPTURE(threads);
            const auto together = made_by(threads);
            CHECK(std::ranges::equal(together.value.vertices(), alone.value.vertices()));
            CHECK(std::ranges::equal(together.value.faces(), alone.value.faces()));
            CHECK(together.report.clearance == alone.report.clearance);
            CHECK(together.report.tightest_area == alone.report.tightest_area);
            CHECK(told == told_alone);
        }
    }
}

TEST_CASE("hull and box of a 3D figure", "[enclose]") {
    const auto figure = random_soup<double>(11);
    MakeCageOptions options;
    options.vertices = 40;
    options.margin = 0.1;
    options.shape = CageShape::hull;
    const auto hull = make_cage(figure.vertices, figure.faces, options);
    REQUIRE(hull);
    CHECK(is_cage(hull.report.cage));
    CHECK(hull.report.tunnels == 0);
    CHECK(hull.value.size() == 40);
    CHECK(sampled_clearance(hull.value, figure) >= 0.9 * hull.report.margin);
    options.shape = CageShape::box;
    for (const bool mirrored : {false, true}) {
        if (mirrored) options.mirror = MirrorPlane{2, {}};
        const auto box = make_cage(figure.vertices, figure.faces, options);
        REQUIRE(box);
        CHECK(is_cage(box.report.cage));
        CHECK(box.value.size() == 8);
        CHECK(box.report.clearance >= (1 - 1e-9) * box.report.margin);
        CHECK(box.report.area > 0);
    }
}

} // namespace make_cage_3d_tests
