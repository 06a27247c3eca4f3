// Laws of wraps: exact alignments, fits without folds, invariances, cages, landmarks, noise, invalid input.
#include "../support/effort.hpp"
#include "../support/meshes.hpp"
#include "../support/progress.hpp"

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/fit/push_out.hpp>
#include <cageform/fit/wrap.hpp>
#include <cageform/pose/detail/rigid_frame.hpp>

namespace wrap_tests {

using namespace cageform_tests;
using cageform::ClosestPlaces;
using cageform::Landmark;
using cageform::move;
using cageform::SurfaceMesh;
using cageform::Wrap;
using cageform::WrapOptions;
using cageform::WrapReport;
using V = Vec<double, 3>;

namespace {

double length(const V& v) {
    return std::sqrt(dot(v, v));
}

/// A body: a capsule of height 1 with lumps. Its surface is a function of a position along the height, s in
/// [0, π], and of an angle.
struct Body {
    double girth = 1, wave = 0, size = 1;
    std::array<double, 3> lumps{0.8, 0.6, 0.5}; ///< heights of the lumps, relative to the radius

    static Body random(Random& random) {
        Body body;
        body.girth = random.uniform(0.8, 1.3);
        body.wave = random.uniform(-0.2, 0.2);
        for (double& lump : body.lumps) lump += random.uniform(-0.3, 0.3);
        return body;
    }
    V place(double s, double angle, double outside = 0) const {
        static constexpr double at[3][2]{{1.0, 0.3}, {1.6, 2.5}, {2.1, 4.4}};
        double radius = 0.09 * girth * (1 + wave * std::sin(3 * s));
        for (std::size_t n = 0; n < 3; ++n) {
            const double near_s = (s - at[n][0]) * (s - at[n][0]) / 0.06;
            radius *= 1 + lumps[n] * std::exp(-near_s - (1 - std::cos(angle - at[n][1])) / 0.3);
        }
        radius = radius * std::sqrt(std::sin(s)) + outside;
        return size * V{radius * std::cos(angle), -0.5 * std::cos(s), radius * std::sin(angle)};
    }
    /// A mesh whose vertices are moved along the surface at random, so that no two are equally near.
    MeshData mesh(std::size_t rings, std::size_t around, std::uint64_t seed) const {
        MeshData data;
        Random random(seed);
        const double pi = std::numbers::pi;
        for (std::size_t r = 1; r < rings; ++r) {
            for (std::size_t a = 0; a < around; ++a)
                data.vertices.push_back(
                    place(pi * (double(r) + random.uniform(-0.2, 0.2)) / double(rings),
                          2 * pi * (double(a) + random.uniform(-0.2, 0.2)) / double(around)));
        }
        const int first = int(data.vertices.size());
        data.vertices.push_back(place(0, 0));
        data.vertices.push_back(place(pi, 0));
        const auto at = [&](std::size_t ring, std::size_t a) {
            return int((ring - 1) * around + a % around);
        };
        for (std::size_t a = 0; a < around; ++a) {
            data.faces.push_back({first, at(1, a), at(1, a + 1)});
            data.faces.push_back({first + 1, at(rings - 1, a + 1), at(rings - 1, a)});
            for (std::size_t r = 1; r + 1 < rings; ++r) {
                data.faces.push_back({at(r, a), at(r + 1, a), at(r + 1, a + 1)});
                data.faces.push_back({at(r, a), at(r + 1, a + 1), at(r, a + 1)});
            }
        }
        return data;
    }
    /// Points at a distance from the surface.
    std::vector<V> clothes(double outside) const {
        std::vector<V> points;
        for (std::size_t r = 4; r < 20; ++r) {
            for (std::size_t a = 0; a < 16; ++a)
                points.push_back(place(3.14 * double(r) / 24, 0.4 * double(a), outside));
        }
        return points;
    }
};

SurfaceMesh surface_of(const MeshData& data) {
    return {data.vertices, data.faces};
}
const MeshData& source_mesh() {
    static const MeshData data = Body{}.mesh(26, 14, 1);
    return data;
}

/// A small, fast fit: lattices of 6 and 12 cells.
WrapOptions quick() {
    WrapOptions options;
    options.finest = 12;
    options.samples = 1000;
    return options;
}

struct Similar {
    double scale = 1;
    cageform::detail::LinearMap<double, 3> turn{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    V shift{};
    V operator()(const V& x) const {
        V to = shift;
        for (std::size_t r = 0; r < 3; ++r)
            to[r] += scale * (turn.at[r][0] * x[0] + turn.at[r][1] * x[1] + turn.at[r][2] * x[2]);
        return to;
    }
    MeshData operator()(MeshData data) const {
        for (V& v : data.vertices) v = (*this)(v);
        return data;
    }
    static Similar random(Random& random, double angle) {
        const auto change = cageform::detail::rotation_of(
            V{random.uniform(-angle, angle), random.uniform(-angle, angle), random.uniform(-angle, angle)});
        Similar map{random.uniform(0.2, 5), change, {}};
        for (std::size_t k = 0; k < 3; ++k) {
            map.turn.at[k][k] += 1;
            map.shift[k] = random.uniform(-9, 9);
        }
        return map;
    }
};

template <class T>
std::vector<Vec<T, 3>> cast(const std::vector<V>& points) {
    std::vector<Vec<T, 3>> to;
    for (const V& p : points) to.push_back(vec_cast<T>(p));
    return to;
}

double largest_difference(const std::vector<V>& a, const std::vector<V>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) largest = std::fmax(largest, length(a[i] - b[i]));
    return largest;
}

void check_no_folds(const WrapReport& report) {
    CHECK(report.folded_vertices + report.folded_followers + report.folded_samples == 0);
    CHECK(report.least_stretch >= 0.0999);
}

} // namespace

TEST_CASE("a similar target gives the similarity, without iterations that drift", "[fit]") {
    const int seed = GENERATE(seeds(4));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const bool by_landmarks = seed % 2 == 1;
    const Similar map = Similar::random(random, by_landmarks ? 3 : 0);
    const MeshData target = map(source_mesh());
    WrapOptions options = quick();
    std::vector<Landmark> marks;
    for (int n = 0; n < 5; ++n) {
        const V& from = source_mesh().vertices[random.below(300)];
        marks.push_back({from, map(from), random.uniform(0.5, 2)});
    }
    if (by_landmarks) options.landmarks = marks;
    const auto [wrap, report] = cageform::wrap(surface_of(source_mesh()), surface_of(target), options);
    REQUIRE(report.status == Status::ok);
    CHECK(report.to_target.largest <= 1e-9);
    CHECK(report.miss <= 1e-9);
    std::vector<V> points, expected;
    for (int n = 0; n < 200; ++n) {
        points.push_back({random.uniform(-0.2, 0.2), random.uniform(-0.6, 0.6), random.uniform(-0.2, 0.2)});
        expected.push_back(map(points.back()));
    }
    std::vector<V> moved(points.size());
    REQUIRE(move(wrap, points, moved) == Status::ok);
    CHECK(largest_difference(moved, expected) <= 1e-7 * map.scale);
    check_no_folds(report);
}

TEST_CASE("bodies of other shapes fit without a fold, and followers keep their side", "[fit]") {
    const int seed = GENERATE(seeds(effort(2, 1)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const Body source, target = Body::random(random);
    const MeshData source_data = source.mesh(60, 32, 1), target_data = target.mesh(47, 27, 2);
    const auto clothes = source.clothes(0.01);
    WrapOptions options;
    options.finest = effort(24u, 12u);
    options.samples = 4000;
    options.follow = clothes;
    const auto [wrap, report] = cageform::wrap(surface_of(source_data), surface_of(target_data), options);
    REQUIRE(report.status == Status::ok);
    CHECK(report.to_target.mean <= effort(0.0005, 0.002));
    CHECK(report.to_target.mean <= 0.2 * report.start.mean);
    CHECK(report.to_source.upper <= effort(0.003, 0.006));
    CHECK(report.unmatched_source == 0);
    check_no_folds(report);

    // The report describes the map that `move` evaluates.
    std::vector<V> moved(source_data.vertices.size()), moved_clothes(clothes.size());
    REQUIRE(move(wrap, source_data.vertices, moved) == Status::ok);
    REQUIRE(move(wrap, clothes, moved_clothes) == Status::ok);
    const SurfaceMesh surface = surface_of(target_data);
    const auto distances = ClosestPlaces(surface.vertices(), surface.faces()).distances(moved);
    CHECK(std::fabs(distances.mean / report.height - report.to_target.mean) <= 1e-9);
    CHECK(std::fabs(distances.largest / report.height - report.to_target.largest) <= 1e-9);

    // The map is one to one: what was outside the source is outside the wrapped source, and what was inside
    // is inside.
    const cageform::TriangleMesh<double> before(source_data.vertices, source_data.faces),
        after(moved, source_data.faces);
    for (std::size_t i = 0; i < clothes.size(); ++i) {
        REQUIRE(std::fabs(winding_number(before, clothes[i])) <= 0.01);
        CHECK(std::fabs(winding_number(after, moved_clothes[i])) <= 0.01);
    }

    // Correspondence: the truth is the same position and angle, as in a mesh of the same seed.
    const MeshData truth = target.mesh(60, 32, 1);
    double mean = 0;
    for (std::size_t i = 0; i < moved.size(); ++i)
        mean += length(moved[i] - truth.vertices[i]) / double(moved.size());
    CHECK(mean <= 0.02);

    std::vector<std::array<V, 3>> jacobians(clothes.size());
    REQUIRE(move(wrap, clothes, moved_clothes, jacobians) == Status::ok);
    constexpr double h = 1e-6;
    for (std::size_t k = 0; k < 3; ++k) {
        auto ahead = clothes, back = clothes;
        for (std::size_t i = 0; i < clothes.size(); ++i) {
            ahead[i][k] += h;
            back[i][k] -= h;
        }
        REQUIRE((move(wrap, ahead, ahead) == Status::ok && move(wrap, back, back) == Status::ok));
        for (std::size_t i = 0; i < clothes.size(); ++i)
            CHECK(length(jacobians[i][k] - (0.5 / h) * (ahead[i] - back[i])) <= 1e-6);
    }
}

TEST_CASE("threads, the order of faces, and moves of the whole scene do not change a wrap", "[fit]") {
    const int seed = GENERATE(seeds(2));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const MeshData source = source_mesh(), target = Body::random(random).mesh(25, 16, 2);
    const auto places = [&](const MeshData& from, const MeshData& to, const cageform::Running& running = {}) {
        const auto [wrap, report] = cageform::wrap(surface_of(from), surface_of(to), quick(), running);
        REQUIRE(report.status == Status::ok);
        std::vector<V> moved(from.vertices.size());
        REQUIRE(move(wrap, from.vertices, moved) == Status::ok);
        return moved;
    };
    const auto given = places(source, target);
    cageform::Running threaded;
    threaded.parallel = cageform::ThreadedFor{3};
    CHECK(places(source, target, threaded) == given);

    MeshData other_source = source, other_target = target;
    for (MeshData* data : {&other_source, &other_target}) {
        std::reverse(data->faces.begin(), data->faces.end());
        for (auto& face : data->faces) std::rotate(face.begin(), face.begin() + 1, face.end());
    }
    CHECK(largest_difference(places(other_source, other_target), given) <= 1e-6);

    const Similar map = Similar::random(random, 3);
    auto expected = given;
    for (V& p : expected) p = map(p);
    CHECK(largest_difference(places(map(source), map(target)), expected) <= 1e-6 * map.scale);
}

TEMPLATE_TEST_CASE("a wrap of a cage is a pose of the cage, then of a lattice", "[fit]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(2));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const auto box =
        cageform::box_mesh(Vec<T, 3>{T(-0.4), T(-0.6), T(-0.4)}, Vec<T, 3>{T(0.4), T(0.6), T(0.4)},
                           std::array<std::size_t, 3>{2, 4, 2});
    const MeshData source = source_mesh(), target = Body::random(random).mesh(25, 16, 2);
    const auto clothes = cast<T>(Body{}.clothes(0.01));
    const auto check = [&](const auto& coordinates, unsigned finest, double residual) {
        CAPTURE(finest);
        WrapOptions options = quick();
        options.finest = finest;
        const auto [wrap, report] =
            cageform::wrap(coordinates, surface_of(source), surface_of(target), options);
        REQUIRE(report.status == Status::ok);
        CHECK(wrap.lattice.has_value() == (finest > 0));
        CHECK(report.to_target.mean <= residual);
        check_no_folds(report);
        std::vector<Vec<T, 3>> moved(clothes.size()), cloned(clothes.size());
        std::vector<std::array<Vec<T, 3>, 3>> jacobians(clothes.size());
        REQUIRE(move(wrap, coordinates, clothes, moved, jacobians) == Status::ok);
        for (const auto& j : jacobians) CHECK(dot(j[0], cross(j[1], j[2])) > 0);
        CHECK(move(wrap, clothes, cloned) == Status::bindings_differ);
        const auto [binding, bound] = cageform::bind(coordinates, clothes);
        REQUIRE(clone(binding, wrap.pose, cloned) == Status::ok);
        if (finest == 0) CHECK(moved == cloned);
    };
    const cageform::MeanValueCoordinates coordinates(box);
    check(coordinates, 0, 0.004);
    if (seed == 0) check(coordinates, 12, 0.003);
    if (seed == 0 && sizeof(T) == 4)
        check(cageform::AnyCoordinates<T, 3>(cageform::GreenCoordinates(box)), 0, 0.01);
    if (seed == 0 && sizeof(T) == 8) {
        // Samples outside a harmonic cage have no derivatives, and are left out.
        const auto tight =
            cageform::box_mesh(Vec<T, 3>{T(-0.25), T(-0.53), T(-0.25)}, Vec<T, 3>{T(0.25), T(0.53), T(0.25)},
                               std::array<std::size_t, 3>{2, 4, 2});
        check(cageform::HarmonicCoordinates(tight), 0, 0.004);
    }
}

TEST_CASE("landmarks are met where they agree with the target, and contradictions are reported", "[fit]") {
    Random random(7);
    const Body target = Body::random(random);
    const SurfaceMesh source = surface_of(source_mesh()), surface = surface_of(target.mesh(25, 16, 2));
    const auto fit = [&](std::span<const Landmark> marks) {
        WrapOptions options = quick();
        options.landmarks = marks;
        const auto result = cageform::wrap(source, surface, options);
        REQUIRE(result.report.status == Status::ok);
        check_no_folds(result.report);
        return result.report;
    };
    std::vector<Landmark> marks;
    for (const double s : {1.0, 1.6, 2.1, 2.6})
        marks.push_back({Body{}.place(s, 2 * s), target.place(s, 2 * s)});
    for (const std::size_t count : {1u, 2u, 4u}) {
        CAPTURE(count);
        const auto report = fit(std::span(marks).first(count));
        CHECK(report.miss <= 0.01);
        CHECK(report.missed < count);
    }
    std::vector<Landmark> on_a_line; // no rotation follows from them
    for (const double y : {-0.3, 0.0, 0.2}) on_a_line.push_back({{0, y, 0}, {0, y, 0}});
    CHECK(fit(on_a_line).to_target.mean <= 0.01);
    marks.push_back({marks[1].from, marks[1].to + V{0, 0.1, 0}});
    const auto contradicted = fit(marks);
    CHECK(contradicted.miss >= 0.04);
    CHECK((contradicted.missed == 1 || contradicted.missed == 4));
}

TEST_CASE("a wrap is never worse than its start, for targets that do not match", "[fit]") {
    const MeshData source = source_mesh();
    const auto report_for = [&](const MeshData& target) {
        const auto [wrap, report] = cageform::wrap(surface_of(source), surface_of(target), quick());
        CHECK((report.status == Status::ok || report.status == Status::fit_not_reached));
        CHECK(report.to_target.mean <= report.start.mean);
        check_no_folds(report);
        std::vector<V> moved(source.vertices.size());
        REQUIRE(move(wrap, source.vertices, moved) == Status::ok);
        for (const V& p : moved) REQUIRE(cageform::is_finite(p));
        return report;
    };
    MeshData upside_down = source;
    for (V& v : upside_down.vertices) v = {v[0], -v[1], -v[2]};
    (void)report_for(upside_down);
    MeshData inside_out = source;
    for (auto& face : inside_out.faces) std::swap(face[0], face[1]);
    const auto report = report_for(inside_out);
    CHECK(report.status == Status::fit_not_reached);
    CHECK(report.unmatched_source > 0.5);

    MeshData parts = source; // two parts, open, and a face without an area
    Random random(2);
    std::erase_if(parts.faces, [&](const auto& f) {
        return std::fabs(parts.vertices[std::size_t(f[0])][1]) < 0.03 || random.uniform(0, 1) < 0.1;
    });
    parts.faces.push_back({0, 0, 1});
    const auto of_parts = report_for(parts);
    CHECK(of_parts.skipped_faces == 1);
    CHECK(of_parts.to_target.mean <= 0.003);
}

TEST_CASE("the noise of a target is measured, and ends a fit", "[fit]") {
    Random random(4);
    const Body target = Body::random(random);
    const auto fit = [&](double noise) {
        MeshData data = target.mesh(70, 40, 2);
        const SurfaceMesh clean = surface_of(data);
        const ClosestPlaces surface(clean.vertices(), clean.faces());
        for (std::size_t i = 0; i < data.vertices.size(); ++i) {
            double sum = 0; // of twelve: nearly normally distributed
            for (int n = 0; n < 12; ++n) sum += random.uniform(-0.5, 0.5);
            data.vertices[i] = data.vertices[i] + noise * sum * surface.normals()[i];
        }
        const auto [wrap, report] = cageform::wrap(surface_of(source_mesh()), surface_of(data), quick());
        REQUIRE(report.status == Status::ok);
        check_no_folds(report);
        return report;
    };
    CHECK(fit(0).noise == 0);
    for (const double noise : {0.002, 0.004}) {
        CAPTURE(noise);
        const auto report = fit(noise);
        CHECK(report.noise >= 0.8 * noise);
        CHECK(report.noise <= 1.2 * noise);
    }
    CHECK(fit(0.02).ended == WrapReport::End::noise);
}

TEST_CASE("a wrap names what it refuses", "[fit]") {
    const SurfaceMesh good = surface_of(source_mesh());
    const auto refused = [&](const SurfaceMesh& source, const SurfaceMesh& target, Status status,
                             std::size_t culprit, bool of_target, const WrapOptions& options = quick()) {
        const auto [wrap, report] = cageform::wrap(source, target, options);
        CHECK(report.status == status);
        CHECK(report.culprit == culprit);
        CHECK(report.of_target == of_target);
        CHECK((wrap.pose.empty() && !wrap.lattice));
    };
    constexpr std::size_t none = WrapReport::none;
    refused({}, good, Status::figure_empty, none, false);
    refused(good, {}, Status::figure_empty, none, true);
    MeshData data = source_mesh();
    data.faces.clear();
    refused(good, surface_of(data), Status::figure_empty, none, true);
    data = source_mesh();
    data.vertices[7][1] = std::numeric_limits<double>::quiet_NaN();
    refused(surface_of(data), good, Status::figure_not_finite, 7, false);
    refused(good, surface_of(data), Status::figure_not_finite, 7, true);
    data = source_mesh();
    data.faces[9][2] = 100000;
    refused(good, surface_of(data), Status::index_out_of_range, 9, true);
    for (V& v : data.vertices) v = {};
    data.faces[9][2] = 0;
    refused(good, surface_of(data), Status::figure_has_no_size, none, true);

    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Landmark> marks(3);
    marks[1].to[2] = nan;
    WrapOptions options = quick();
    options.landmarks = marks;
    refused(good, good, Status::value_not_finite, 1, false, options);
    marks[1] = {{}, {}, 0};
    refused(good, good, Status::weights_not_positive, 1, false, options);
    const std::vector<V> follow{{}, {0, nan, 0}};
    options = quick();
    options.follow = follow;
    refused(good, good, Status::value_not_finite, 1, false, options);
    for (const int n : {0, 1, 2, 3}) {
        options = quick();
        if (n == 0) options.floor = nan;
        if (n == 1) options.residual = -1;
        if (n == 2) options.stages = {{0, {1}, 0.1}};
        if (n == 3) options.stages = {{6, {-1}, 0.1}};
        refused(good, good, Status::value_not_finite, none, false, options);
    }
    data = source_mesh();
    for (V& v : data.vertices) v = 50 * v;
    options = quick();
    options.align = false;
    refused(surface_of(data), good, Status::too_many_handles, none, false, options);
    marks = {{}, {{}, {0, 1e9, 0}}};
    options.landmarks = marks;
    refused(good, good, Status::value_not_finite, 1, false, options);

    const cageform::TriangleMesh<double> no_cage;
    const auto [unfit, report] = cageform::wrap(cageform::MeanValueCoordinates(no_cage), good, good);
    CHECK(report.status == Status::too_few_vertices);
    std::vector<V> out(1);
    CHECK(move(Wrap<double>{}, source_mesh().vertices, out) == Status::output_too_small);
}

TEST_CASE("points far from the source change nothing else", "[fit]") {
    Random random(9);
    const MeshData source = source_mesh(), target = Body::random(random).mesh(25, 16, 2);
    std::vector<V> follow = Body{}.clothes(0.01);
    WrapOptions options = quick();
    options.follow = follow;
    const auto without = cageform::wrap(surface_of(source), surface_of(target), options);
    const std::vector<V> far_away{{0, 300, 0}, {-1e9, 2, 0}, {1e308, -1e308, 1e308}};
    follow.insert(follow.begin() + 5, far_away.begin(), far_away.end());
    options.follow = follow;
    const auto with = cageform::wrap(surface_of(source), surface_of(target), options);
    REQUIRE(with.report.status == Status::ok);
    CHECK(without.report.far_followers == 0);
    CHECK(with.report.far_followers == far_away.size());
    CHECK(with.value.lattice_pose == without.value.lattice_pose);
    std::vector<V> moved(2);
    REQUIRE(move(with.value, std::span(far_away).first(2), moved) == Status::ok);
    CHECK((cageform::is_finite(moved[0]) && cageform::is_finite(moved[1])));
}

TEST_CASE("wraps report progress, and a cancelled wrap keeps its last pose without a fold", "[fit]") {
    Random random(3);
    const SurfaceMesh source = surface_of(source_mesh()),
                      target = surface_of(Body::random(random).mesh(25, 16, 2));
    check_progress("wrap",
                   [&](const Running& running) { return cageform::wrap(source, target, quick(), running); });
    int calls = 0;
    Running running;
    running.progress = [&](double done) {
        ++calls;
        return done < 0.5;
    };
    const auto [wrap, report] = cageform::wrap(source, target, quick(), running);
    CHECK(report.status == Status::cancelled);
    CHECK(calls > 3);
    CHECK(!report.steps.empty());
    CHECK(report.to_target.mean < report.start.mean);
    check_no_folds(report);
    REQUIRE(wrap.lattice.has_value());
}

TEST_CASE("pushed points are outside, and no face turns", "[fit]") {
    const int seed = GENERATE(seeds(4));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const Body body = Body::random(random);
    const SurfaceMesh surface = surface_of(body.mesh(60, 40, 1));
    MeshData clothes = body.mesh(30, 20, 2);
    for (V& v : clothes.vertices) v = random.uniform(0.9, 1.15) * v; // inside and outside
    const SurfaceMesh figure = surface_of(clothes);
    const double distance = random.uniform(0.0005, 0.004);
    std::vector<V> out(clothes.vertices.size());
    const auto report = push_out(surface, figure, {}, out, distance);
    REQUIRE(report.status == Status::ok);
    CHECK(report.inside > 0);
    CHECK(report.left <= report.held);
    CHECK(report.largest <= 0.2);
    const ClosestPlaces places(surface.vertices(), surface.faces());
    const auto are_out = places.are_outside(out);
    CHECK(std::size_t(std::count(are_out.begin(), are_out.end(), char{0})) == report.left);
    for (const auto& face : clothes.faces) {
        const auto area = [&](const std::vector<V>& of) {
            const V &a = of[std::size_t(face[0])], &b = of[std::size_t(face[1])],
                    &c = of[std::size_t(face[2])];
            return cross(b - a, c - a);
        };
        CHECK(dot(area(out), area(clothes.vertices)) >= 0);
    }

    // Points that are far enough outside do not move; with may_move, points inside may stay.
    std::vector<V> again(out.size());
    const auto settled = push_out(surface, surface_of({out, clothes.faces}), {}, again, 0.5 * distance);
    if (report.held == 0) CHECK((settled.moved == 0 && again == out));
    const std::vector<char> none(out.size());
    const auto unmoved = push_out(surface, figure, none, again, distance);
    CHECK((unmoved.moved == 0 && again == clothes.vertices));
    CHECK(push_out(surface, figure, {}, again, -1).status == Status::value_not_finite);
    CHECK(push_out({}, figure, {}, again).status == Status::figure_empty);
    CHECK(push_out(surface, figure, std::span(none).first(2), again).status == Status::input_malformed);
    std::vector<V> too_small(3);
    CHECK(push_out(surface, figure, {}, too_small).status == Status::output_too_small);
}

} // namespace wrap_tests
