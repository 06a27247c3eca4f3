// Laws of 2D cages.

#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"

#include <cageform/enclose/make_cage.hpp>

#include <map>

namespace make_cage_tests {

using namespace cageform;
using namespace cageform_tests;

template <class T>
using Figure = std::vector<DrawnSegment<T>>;

template <class T>
Vec<T, 2> at(double x, double y) {
    return {T(x), T(y)};
}

/// A polygonal outline.
template <class T>
void add_loop(Figure<T>& figure, const Points2<T>& points, T radius = 0) {
    for (std::size_t i = 0; i < points.size(); ++i)
        figure.push_back({points[i], points[(i + 1) % points.size()], radius});
}
template <class T>
void add_disc(Figure<T>& figure, double x, double y, double radius) {
    figure.push_back({at<T>(x, y), at<T>(x, y), T(radius)});
}

/// Strokes of several widths, a star, dots; separate or crossing.
template <class T>
Figure<T> random_figure(std::uint64_t seed) {
    Random random(seed);
    Figure<T> figure;
    const double size = std::pow(10.0, random.uniform(-4, 4));
    const double x = size * random.uniform(-3, 3), y = size * random.uniform(-3, 3);
    const auto place = [&] {
        return at<T>(x + size * random.uniform(0, 1), y + size * random.uniform(0, 1));
    };
    for (std::size_t n = random.below(5); n > 0; --n) {
        Vec<T, 2> from = place();
        const T radius = T(size * random.uniform(0, 0.03));
        for (std::size_t k = 1 + random.below(5); k > 0; --k) {
            const auto to = place();
            figure.push_back({from, to, radius});
            from = to;
        }
    }
    if (random.below(2) == 0) add_loop(figure, Points2<T>{place(), place(), place(), place()});
    for (std::size_t n = random.below(4); n > 0; --n) {
        const auto p = place();
        add_disc<T>(figure, p[0], p[1], size * random.uniform(0, 0.1));
    }
    figure.push_back({place(), place(), T(0)});
    return figure;
}

/// The minimum distance of sampled points of the figure from the cage; negative if a point is outside.
template <class T>
double sampled_clearance(const Polygon<T>& cage, const Figure<T>& figure) {
    double least = std::numeric_limits<double>::infinity();
    Points2<double> vertices;
    std::vector<std::size_t> sizes;
    for (const auto& p : cage.vertices()) vertices.push_back(vec_cast<double>(p));
    for (const auto& loop : cage.loops()) sizes.push_back(loop.size());
    const Polygon<double> polygon(vertices, sizes);
    for (const auto& s : figure) {
        for (int k = 0; k <= 8; ++k) {
            const auto a = vec_cast<double>(s.a), b = vec_cast<double>(s.b);
            const auto p = a + (k / 8.0) * (b - a);
            const double distance = nearest_on_boundary(polygon, p).distance - double(s.radius);
            const bool inside = locate(polygon, p, 0.0) == PointState::inside;
            least = std::min(least, inside ? distance : -std::fabs(distance));
        }
    }
    return least;
}

bool is_cage(const CageReport& report) {
    return report.status == Status::ok &&
           std::all_of(report.faults.begin(), report.faults.end(),
                       [](const CageFault& fault) { return fault.kind == CageFaultKind::collinear_vertex; });
}

TEMPLATE_TEST_CASE("a cage contains its figure and keeps the margin", "[enclose][property]",
                   CAGEFORM_SCALARS) {
    for (std::uint64_t seed = 0; seed < effort(12u, 4u); ++seed) {
        CAPTURE(seed);
        const auto figure = random_figure<TestType>(seed);
        MakeCageOptions options;
        Random random(seed + 1000);
        options.vertices = 8 + random.below(40);
        options.margin = random.uniform(0.015, 0.06);
        const auto made = make_cage(std::span<const DrawnSegment<TestType>>(figure), options);
        REQUIRE(to_string(made.report.status) == std::string("ok"));
        const auto& report = made.report;
        CHECK(is_cage(check(made.value)));
        CHECK(made.value.loops().size() == 1);
        CHECK(made.value.size() == options.vertices);
        CHECK(report.vertices == options.vertices);
        CHECK(report.clearance >= 0.9 * report.margin);
        const double sampled = sampled_clearance(made.value, figure);
        const auto box = bounds_of(made.value.vertices());
        CHECK(sampled >= report.clearance - double(coincidence_tolerance(box)));
        CHECK(sampled <= report.clearance + 0.5 * double(box.diagonal())); // has the scale of the cage
        // The area around a line is mostly margin; the cage may be 5 % smaller.
        CHECK(report.area >= 0.95 * report.tightest_area);
        CHECK(report.least_angle > 10);
        CHECK(report.bridges + 1 >= report.components);
    }
}

TEMPLATE_TEST_CASE("more vertices make a tighter cage", "[enclose][property]", CAGEFORM_SCALARS) {
    for (std::uint64_t seed = 0; seed < effort(8u, 2u); ++seed) {
        CAPTURE(seed);
        const auto figure = random_figure<TestType>(seed);
        double before = std::numeric_limits<double>::infinity();
        for (const std::size_t vertices : {10u, 20u, 40u, 80u}) {
            MakeCageOptions options;
            options.vertices = vertices;
            const auto made = make_cage(std::span<const DrawnSegment<TestType>>(figure), options);
            REQUIRE(made);
            const double ratio = made.report.area / made.report.tightest_area;
            CHECK(ratio <= std::max(before, 1.0) + 0.02);
            before = ratio;
        }
        CHECK(before < 1.06);
    }
}

TEMPLATE_TEST_CASE("a mirrored cage is symmetric", "[enclose][property]", CAGEFORM_SCALARS) {
    for (std::uint64_t seed = 0; seed < effort(12u, 4u); ++seed) {
        CAPTURE(seed);
        const auto figure = random_figure<TestType>(seed);
        MakeCageOptions options;
        options.vertices = 24;
        const std::size_t axis = seed % 2;
        options.mirror = MirrorPlane{axis, {}};
        if (seed % 3 == 0) options.mirror->position = double(figure[0].a[axis]);
        const auto made = make_cage(std::span<const DrawnSegment<TestType>>(figure), options);
        REQUIRE(to_string(made.report.status) == std::string("ok"));
        CHECK(is_cage(made.report.cage));
        CHECK(made.value.size() == 24);
        CHECK(sampled_clearance(made.value, figure) >= 0.89 * made.report.margin);
        const auto vertices = made.value.vertices();
        const auto box = bounds_of(vertices);
        const double middle = (double(box.lower[axis]) + double(box.upper[axis])) / 2;
        if (options.mirror->position)
            CHECK(std::fabs(middle - *options.mirror->position) <= double(coincidence_tolerance(box)));
        double worst = 0;
        for (const auto& p : vertices) {
            auto image = vec_cast<double>(p);
            image[axis] = 2 * middle - image[axis];
            double nearest = std::numeric_limits<double>::infinity();
            for (const auto& q : vertices)
                nearest = std::min(nearest, detail::length(vec_cast<double>(q) - image));
            worst = larger(worst, nearest);
        }
        CHECK(worst <= double(coincidence_tolerance(box)));
    }
}

TEST_CASE("translating or scaling the figure by powers of two does the same to the cage", "[enclose]") {
    Random random(5);
    Figure<double> figure, moved;
    for (int k = 0; k < 12; ++k) {
        const auto number = [&] { return double(random.below(1024)); };
        figure.push_back({{number(), number()}, {number(), number()}, double(random.below(16))});
        const auto& s = figure.back();
        const auto map = [](const Vec<double, 2>& p) {
            return Vec<double, 2>{4 * p[0] - 4096, 4 * p[1] + 8192};
        };
        moved.push_back({map(s.a), map(s.b), 4 * s.radius});
    }
    const auto made = make_cage(figure), again = make_cage(figure), other = make_cage(moved);
    REQUIRE(made);
    REQUIRE(other);
    REQUIRE(made.value.size() == other.value.size());
    for (std::size_t i = 0; i < made.value.size(); ++i) {
        CHECK(made.value[i] == again.value[i]);
        const auto& p = made.value[i];
        CHECK(detail::length(other.value[i] - Vec<double, 2>{4 * p[0] - 4096, 4 * p[1] + 8192}) <= 1e-11);
    }
    std::reverse(moved.begin(), moved.end());
    const auto reversed = make_cage(moved);
    for (std::size_t i = 0; i < other.value.size(); ++i) CHECK(reversed.value[i] == other.value[i]);
}

TEST_CASE("separate discs: one cage with bridges, or one loop each", "[enclose]") {
    for (const std::size_t count : {2u, 3u, 7u, 20u}) {
        CAPTURE(count);
        Figure<double> figure;
        for (std::size_t k = 0; k < count; ++k)
            add_disc<double>(figure, 3 * double(k), double(k * k % 5), 0.6 + 0.1 * double(k % 3));
        MakeCageOptions options;
        options.vertices = 12 * count;
        options.margin = 0.003;
        const auto one = make_cage(figure, options);
        REQUIRE(one);
        CHECK(one.report.components == count);
        CHECK(one.report.bridges == count - 1);
        CHECK(one.value.loops().size() == 1);
        options.one_cage = false;
        const auto each = make_cage(figure, options);
        REQUIRE(each);
        CHECK(each.report.bridges == 0);
        CHECK(each.value.loops().size() == count);
        CHECK(each.value.size() == options.vertices);
        CHECK(each.report.tightest_area < one.report.tightest_area);
        CHECK(is_cage(check(each.value)));
        CHECK(sampled_clearance(each.value, figure) > 0.85 * each.report.margin);
        options.vertices = 3; // fewer than needed
        const auto few = make_cage(figure, options);
        REQUIRE(few);
        CHECK(few.report.vertices == 4 * count);
    }
}

TEST_CASE("loops of equal size have equal numbers of vertices, mirrored or not", "[enclose]") {
    MakeCageOptions options;
    options.one_cage = false;
    options.margin = 0.01;
    for (const std::size_t pairs : {1u, 2u, 4u}) {
        for (const std::size_t each : {5u, 8u}) {
            CAPTURE(pairs, each);
            Figure<double> figure;
            for (std::size_t k = 0; k < pairs; ++k) add_disc<double>(figure, 3 + 4 * double(k), 0, 1);
            options.mirror = MirrorPlane{0, 0.0};
            options.vertices = 2 * pairs * each;
            const auto made = make_cage(figure, options);
            REQUIRE(made);
            CHECK(made.value.loops().size() == 2 * pairs);
            for (const auto& loop : made.value.loops()) CHECK(loop.size() == each);
        }
    }
}

TEST_CASE("loops of any sizes share the vertices, also with collinear sides", "[enclose]") {
    Figure<double> figure;
    const auto add_box = [&](double x, double y, double width, double height) {
        const std::array<Vec<double, 2>, 4> p{
            {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}}};
        for (std::size_t k = 0; k < 4; ++k) figure.push_back({p[k], p[(k + 1) % 4], 0});
    };
    // The lower sides of these boxes are collinear, so many contour vertices are.
    const std::array<double, 5> sizes{16, 13, 1, 1, 1};
    double x = 0;
    for (const double size : sizes) {
        add_box(x, 2, size, size);
        x += size + 6;
    }
    MakeCageOptions options;
    options.one_cage = false;
    for (const std::size_t vertices : {20u, 24u, 31u, 60u}) {
        CAPTURE(vertices);
        options.vertices = vertices;
        const auto made = make_cage(figure, options);
        REQUIRE(made);
        CHECK(made.value.loops().size() == sizes.size());
        CHECK(made.value.size() == vertices);
        CHECK(is_cage(check(made.value)));
    }
}

TEST_CASE("loops contain parts smaller than a step", "[enclose]") {
    // Dots and short lines, which loops of few vertices once skipped.
    const Figure<double> dots{{{20918, 3720}, {20918, 3720}, 0},
                              {{12263, 537}, {12263, 537}, 0},
                              {{7661, 17237}, {7661, 17237}, 0}};
    MakeCageOptions options;
    options.one_cage = false;
    options.vertices = 4;
    options.mirror = MirrorPlane{0, {}};
    CHECK(make_cage(dots, options));
    options.mirror.reset();
    options.margin = 0.008;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        Figure<double> figure;
        for (std::size_t n = 10 + random.below(30); n > 0; --n) {
            const Vec<double, 2> p{random.uniform(-1, 1), random.uniform(-1, 1)};
            figure.push_back({p, p + Vec<double, 2>{random.uniform(-0.02, 0.02), 0}, 0});
        }
        options.vertices = 4 + random.below(8);
        const auto made = make_cage(figure, options);
        REQUIRE(made);
        CHECK(sampled_clearance(made.value, figure) > 0.85 * made.report.margin);
    }
}

TEST_CASE("cages of convex figures are nearly convex", "[enclose]") {
    const std::vector<std::vector<Vec<double, 2>>> figures{
        {{10, 3}, {11, 3}, {11, 19}, {10, 19}}, {{4, 10}, {12, 10}, {8, 6}}, {{6, 4}, {6, 12}, {10, 8}}};
    for (const auto& corners : figures) {
        Figure<double> figure;
        for (std::size_t k = 0; k < corners.size(); ++k)
            figure.push_back({corners[k], corners[(k + 1) % corners.size()], 0});
        for (const std::size_t vertices : {16u, 24u, 40u}) {
            CAPTURE(corners.size(), vertices);
            MakeCageOptions options;
            options.vertices = vertices;
            const auto made = make_cage(figure, options);
            REQUIRE(made);
            double most = 0; // largest reflex turn
            for (std::size_t i = 0; i < vertices; ++i) {
                const Vec<double, 2> u = made.value[(i + 1) % vertices] - made.value[i],
                                     v = made.value[(i + 2) % vertices] - made.value[(i + 1) % vertices];
                most = larger(most, std::atan2(-cross(u, v), dot(u, v)));
            }
            CHECK(most < 0.8);
        }
    }
}

/// An arc of a circle with a gap on the right.
Figure<double> open_ring(double gap) {
    Figure<double> figure;
    const double first = std::asin(gap / 2);
    constexpr int pieces = 200;
    for (int k = 0; k < pieces; ++k) {
        const auto place = [&](int n) {
            const double angle = first + (2 * std::numbers::pi - 2 * first) * n / pieces;
            return Vec<double, 2>{std::cos(angle), std::sin(angle)};
        };
        figure.push_back({place(k), place(k + 1), 0});
    }
    return figure;
}

TEST_CASE("narrow gaps are closed, wide ones stay open", "[enclose]") {
    const double margin = 0.05 * 2 * std::sqrt(2.0); // of the bounds of the ring
    MakeCageOptions options;
    options.margin = 0.05;
    options.vertices = 32;
    // A gap leaves its width minus two margins; free widths below 1.2 margins are closed.
    const auto open = make_cage(open_ring(4.5 * margin), options);
    const auto closed = make_cage(open_ring(2.9 * margin), options);
    REQUIRE(open);
    REQUIRE(closed);
    const Vec<double, 2> middle{0, 0};
    CHECK(locate(open.value, middle, 0.0) == PointState::outside);
    CHECK(locate(closed.value, middle, 0.0) == PointState::inside);
    // The closed cage contains at least the whole disc.
    CHECK(closed.report.area > std::numbers::pi);
    CHECK(open.report.area < 2);
}

TEST_CASE("with options.holes, unpainted holes are kept", "[enclose]") {
    Figure<double> figure;
    add_loop(figure, Points2<double>{{0, 0}, {10, 0}, {10, 10}, {0, 10}});
    add_loop(figure,
             Points2<double>{{3, 3}, {7, 3}, {7, 7}, {3, 7}}); // same orientation as the outer outline
    MakeCageOptions options;
    options.vertices = 20;
    const auto filled = make_cage(figure, options);
    REQUIRE(filled);
    CHECK(filled.value.loops().size() == 1);
    options.holes = true;
    const auto lines = make_cage(figure, options);
    REQUIRE(lines);
    CHECK(lines.value.loops().size() == 4); // a band along each outline
    const PaintedArea even_odd{0, figure.size(), true}, non_zero{0, figure.size(), false};
    const auto frame = make_cage(Drawing(figure, std::span(&even_odd, 1)), options);
    REQUIRE(frame);
    REQUIRE(frame.value.loops().size() == 2);
    CHECK(is_cage(check(frame.value)));
    CHECK(signed_area(frame.value, frame.value.loops()[0]) > 100);
    CHECK(signed_area(frame.value, frame.value.loops()[1]) < 0);
    CHECK(locate(frame.value, {5, 5}, 0.0) == PointState::outside);
    const auto solid = make_cage(Drawing(figure, std::span(&non_zero, 1)), options);
    REQUIRE(solid);
    CHECK(solid.value.loops().size() == 1);
}

TEMPLATE_TEST_CASE("invalid figures and options are reported", "[enclose][error]", CAGEFORM_SCALARS) {
    using Segments = Figure<TestType>;
    const TestType nan = std::numeric_limits<TestType>::quiet_NaN(),
                   huge = std::numeric_limits<TestType>::max();
    const Segments sound{{{0, 0}, {1, 1}, 0}, {{1, 1}, {2, 0}, TestType(0.1)}};
    const auto status = [](const Segments& figure, const MakeCageOptions& options, std::size_t culprit = 0,
                           std::span<const PaintedArea> areas = {}) {
        const auto made = make_cage(Drawing(figure, areas), options);
        CHECK(made.value.size() == (made ? made.report.vertices : 0));
        if (!made) CHECK(made.report.culprit == culprit);
        return made.report.status;
    };
    CHECK(status(sound, {}) == Status::ok);
    CHECK(status({}, {}) == Status::figure_empty);
    CHECK(status({{{3, 4}, {3, 4}, 0}, {{3, 4}, {3, 4}, 0}}, {}) == Status::figure_has_no_size);
    const TestType large = std::is_same_v<TestType, double> ? TestType(1e300) : huge; // its square overflows
    for (const TestType bad : {nan, large, huge, -huge, std::numeric_limits<TestType>::infinity()}) {
        Segments figure = sound;
        figure[1].b[1] = bad;
        CHECK(status(figure, {}, 1) == Status::figure_not_finite);
        figure = sound;
        figure[0].radius = bad;
        CHECK(status(figure, {}, 0) == Status::figure_not_finite);
    }
    Segments negative = sound;
    negative[1].radius = -1;
    CHECK(status(negative, {}, 1) == Status::figure_not_finite);
    for (const std::size_t vertices : {1u, 2u}) {
        MakeCageOptions options;
        options.vertices = vertices;
        CHECK(status(sound, options) == Status::too_few_cage_vertices);
    }
    for (const double margin :
         {-0.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        MakeCageOptions options;
        options.margin = margin;
        CHECK(status(sound, options) == Status::margin_not_positive);
    }
    MakeCageOptions thin;
    thin.margin = 1e-6;
    CHECK(status(sound, thin) == Status::margin_too_small);
    MakeCageOptions mirror;
    mirror.mirror = MirrorPlane{2, {}};
    CHECK(status(sound, mirror) == Status::mirror_not_supported);
    mirror.mirror = MirrorPlane{0, std::numeric_limits<double>::infinity()};
    CHECK(status(sound, mirror) == Status::mirror_not_supported);
    const std::vector<PaintedArea> areas{{0, 2, false}, {1, 3, false}};
    CHECK(status(sound, {}, 1, areas) == Status::index_out_of_range);
}

TEST_CASE("very large and very small figures, lines and dots", "[enclose]") {
    for (const double size : {1e-140, 1e-30, 1e30, 1e140}) {
        CAPTURE(size);
        const Figure<double> line{{{size, size}, {2 * size, 3 * size}, 0}};
        const auto made = make_cage(line);
        REQUIRE(made);
        CHECK(made.report.clearance >= 0.9 * made.report.margin);
        CHECK(made.report.clearance <= 2 * made.report.margin);
    }
    Figure<double> dot;
    add_disc<double>(dot, 7, 7, 2);
    const auto about_dot = make_cage(dot);
    REQUIRE(about_dot);
    CHECK(about_dot.report.area > std::numbers::pi * 4);
    // Far from the origin, single precision cannot represent the margin.
    const Figure<float> far{{{1e7F, 0}, {1e7F + 2, 1}, 0}};
    const auto far_off = make_cage(far);
    CHECK(far_off.report.status == Status::cage_not_found);
}

TEST_CASE("with coarse coordinates the margin is kept, or no cage is returned", "[enclose]") {
    std::size_t found = 0, found_later = 0;
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        // A margin of a few ulps of the coordinates, to which the cage is rounded.
        const double size = 1 / (random.uniform(4, 6) * double(epsilon<float>));
        Figure<float> figure;
        const auto place = [&] {
            return at<float>(size + 12 * random.uniform(0, 1), 12 * random.uniform(0, 1));
        };
        for (int k = 0; k < 4; ++k) figure.push_back({place(), place(), 0});
        MakeCageOptions options;
        options.margin = 0.08;
        options.vertices = 6;
        double most = 0;
        cageform::Running running;
        running.progress = [&](double done) {
            if (done < 1) most = larger(most, done);
            return true;
        };
        const auto made = make_cage(figure, options, running);
        const double kept = 0.9 * made.report.margin;
        CHECK((made ? made.report.clearance >= kept && sampled_clearance(made.value, figure) >= kept
                    : made.report.status == Status::cage_not_found && made.value.size() == 0));
        found += made ? 1 : 0;
        found_later += made && most > 0.9 ? 1 : 0; // not at the first try
    }
    CHECK(found > 12);
    CHECK(found_later > 1);
}

TEST_CASE("make_cage reports progress and can be cancelled", "[enclose]") {
    const auto figure = random_figure<double>(3);
    MakeCageOptions options;
    std::vector<double> told;
    cageform::Running running;
    running.progress = [&](double done) {
        told.push_back(done);
        return true;
    };
    REQUIRE(make_cage(figure, options, running));
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.back() == 1);
    for (std::size_t stop = 0; stop < told.size(); ++stop) {
        std::size_t calls = 0;
        running.progress = [&](double) { return calls++ < stop; };
        const auto made = make_cage(figure, options, running);
        CHECK(made.report.status == Status::cancelled);
        CHECK(made.value.size() == 0);
    }
}

TEST_CASE("hull and box of a figure", "[enclose]") {
    for (const std::uint64_t seed : {1u, 4u, 5u}) {
        CAPTURE(seed);
        const auto figure = random_figure<double>(seed);
        MakeCageOptions options;
        options.vertices = 40;
        const auto tight = make_cage(figure, options);
        options.shape = CageShape::hull;
        const auto hull = make_cage(figure, options);
        options.shape = CageShape::box;
        const auto box = make_cage(figure, options);
        REQUIRE(tight);
        REQUIRE(hull);
        REQUIRE(box);
        CHECK(hull.report.bridges == 0);
        CHECK(hull.report.area >= 0.99 * tight.report.area);
        CHECK(hull.value.size() == 40);
        CHECK(sampled_clearance(hull.value, figure) >= 0.9 * hull.report.margin);
        // The hull is convex up to what relaxation leaves within the margin.
        CHECK(hull.report.area <= 1.03 * hull.report.tightest_area);
        CHECK(box.value.size() == 4);
        CHECK(box.report.clearance >= (1 - 1e-9) * box.report.margin);
        CHECK(is_cage(check(box.value)));
        options.mirror = MirrorPlane{1, {}};
        options.shape = CageShape::hull;
        const auto mirrored = make_cage(figure, options);
        REQUIRE(mirrored);
        CHECK(mirrored.report.area >= 0.99 * hull.report.area);
    }
}

} // namespace make_cage_tests
