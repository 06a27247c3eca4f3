// Figures: bits of separate calls, one solve, rejected with a status if
// invalid.
#include "../support/allocation_count.hpp"
#include "../support/figures.hpp"
#include "../support/packed.hpp"

#include <cageform/binding/rebind_cage.hpp>
#include <cageform/clone/clone_figure.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

namespace figure_tests {

using namespace cageform_tests;
using cageform::bind;
using cageform::BlobCheck;
using cageform::FigureHeader;
using cageform::FigureOutput;
using cageform::FigurePart;
using cageform::FigurePoints;
using cageform::FigureTag;
using cageform::FigureTags;
using cageform::open;
using cageform::pack;

namespace {

template <class T>
using Mean3 = cageform::MeanValueCoordinates<T, 3>;

template <class T, std::size_t D>
std::vector<Vec<T, D>> random_directions(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    std::vector<Vec<T, D>> directions(count);
    for (auto& d : directions) {
        for (std::size_t k = 0; k < D; ++k) d[k] = T(random.uniform(-1, 1));
    }
    return directions;
}

/// Tangents as in glTF.
template <class T>
std::vector<std::array<T, 4>> signed_tangents(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    std::vector<std::array<T, 4>> tangents;
    for (const auto& t : random_directions<T, 3>(count, seed))
        tangents.push_back({t[0], t[1], t[2], T(random.below(2) == 0 ? 1 : -1)});
    return tangents;
}

/// A small figure with all parts.
cageform::FigureBinding<float, 3> small_figure(std::uint64_t seed = 1, std::size_t count = 37) {
    const auto mesh = random_mesh(seed).mesh<float>();
    const Mean3<float> coordinates(mesh);
    const auto points = points_in(mesh, count, seed);
    auto result =
        cageform::bind(coordinates, FigurePoints{points, random_directions<float, 3>(points.size(), seed),
                                                 signed_tangents<float>(points.size(), seed + 1)});
    REQUIRE(result.report.status == Status::ok);
    std::vector<std::string> labels;
    for (std::size_t i = 0; i < mesh.size(); ++i)
        labels.push_back(i % 3 == 1 ? "" : "corner " + std::to_string(i));
    REQUIRE(result.value.set_labels(labels) == Status::ok);
    return std::move(result.value);
}

cageform::PackedFigure<float, 3> small_packed(const cageform::FigurePackOptions& options = {
                                                  .weights = {.format = WeightFormat::int16, .largest = 4}}) {
    auto result = cageform::pack(small_figure(), options);
    REQUIRE(result.report.status == Status::ok);
    REQUIRE(result.report.bytes == result.value.bytes().size());
    return std::move(result.value);
}

Status status_of(std::span<const std::byte> bytes, const cageform::BlobExpectation& expected = {}) {
    const auto opened = cageform::open<float, 3>(bytes, expected);
    if (opened.status() != Status::ok) {
        CHECK(opened.value.point_count() == 0);
        CHECK(opened.value.table.empty());
    }
    return opened.status();
}

/// The offset of a part's entry in the table.
std::size_t line_of(Aligned& memory, FigureTag tag) {
    for (std::size_t at = sizeof(FigureHeader);; at += sizeof(FigurePart)) {
        FigurePart part;
        std::memcpy(&part, memory.data() + at, sizeof(part));
        if (part.tag == tag) return at;
    }
}
std::size_t offset_of(Aligned& memory, FigureTag tag) {
    FigurePart part;
    std::memcpy(&part, memory.data() + line_of(memory, tag), sizeof(part));
    return std::size_t(part.offset);
}

template <class T, std::size_t D>
void check_same(const cageform::PackedBinding<T, D>& separate, std::span<const std::byte> part) {
    CHECK(std::equal(part.begin(), part.end(), separate.bytes().begin(), separate.bytes().end()));
}

} // namespace

TEMPLATE_TEST_CASE("bind of a figure has the bits of separate calls", "[figure]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(seeds(3)));
    CAPTURE(seed);
    const auto mesh = random_mesh(seed).mesh<T>();
    const Mean3<T> coordinates(mesh);
    const auto points = points_in(mesh, 70 + 5 * seed, seed);
    const auto normals = random_directions<double, 3>(points.size(), seed); // of another scalar
    const auto tangents = signed_tangents<T>(points.size(), seed);
    const auto pose = shaken(mesh.vertices(), 0.2, seed);

    const auto bound = cageform::bind(coordinates, points);
    std::vector<Vec<T, 3>> plain;
    for (const auto& t : tangents) plain.push_back({t[0], t[1], t[2]});
    const auto turned = bind_vectors(coordinates, points, cageform::tangents_of(normals, plain));
    Points3<T> moved(points.size()), up(points.size()), along(points.size());
    REQUIRE(clone(bound.value, pose, moved) == Status::ok);
    REQUIRE(clone_tangent_frames(turned.value, pose, up, along) == Status::ok);

    const auto [figure, report] = cageform::bind(coordinates, FigurePoints{points, normals, tangents});
    REQUIRE(report.status == Status::ok);
    CHECK(report.points.partition_error.value == bound.report.partition_error.value);
    CHECK(report.vectors.partition_error.value == turned.report.partition_error.value);
    Points3<T> out(points.size()), out_up(points.size());
    std::vector<std::array<T, 4>> out_along(points.size());
    const auto check = [&](const auto& any_figure, const Points3<T>& p, const Points3<T>& n,
                           const Points3<T>& t) {
        REQUIRE(clone(any_figure, pose, FigureOutput{out, out_up, out_along}, cageform::ThreadedFor{2}) ==
                Status::ok);
        CHECK(out == p);
        CHECK(out_up == n);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CHECK(Vec<T, 3>{out_along[i][0], out_along[i][1], out_along[i][2]} == t[i]);
            CHECK(out_along[i][3] == tangents[i][3]);
        }
        Points3<T> alone(points.size()), beside(points.size());
        REQUIRE(clone(any_figure, pose, alone) == Status::ok);
        REQUIRE(clone(any_figure, pose, FigureOutput{beside, out_up}) == Status::ok);
        CHECK(alone == p);
        CHECK(beside == p);
        CHECK(out_up == n);
    };
    check(figure, moved, up, along);

    for (const std::size_t largest : {0u, 5u}) {
        cageform::PackOptions options{.format = WeightFormat::half, .largest = largest};
        const auto opened_from = cageform::pack(figure, {.weights = options});
        REQUIRE(opened_from.report.status == Status::ok);
        const auto opened = cageform::open<T, 3>(opened_from.value.bytes());
        REQUIRE(opened.status() == Status::ok);
        const auto packed = cageform::pack(bound.value, options);
        if (largest != 0) options.order = {packed.value.view().order, points.size()};
        const std::array vectors{cageform::pack(turned.value[0], options),
                                 cageform::pack(turned.value[1], options)};
        check_same(packed.value, opened.value.part(FigureTags::points));
        check_same(vectors[0].value, opened.value.part(FigureTags::tangents));
        check_same(vectors[1].value, opened.value.part(FigureTags::bitangents));
        CHECK(opened_from.report.vectors[1].error.value == vectors[1].report.error.value);
        REQUIRE(clone(packed.value, pose, moved) == Status::ok);
        REQUIRE(clone_tangent_frames(std::array{vectors[0].value.view(), vectors[1].value.view()}, pose, up,
                                     along) == Status::ok);
        check(opened.value, moved, up, along);
    }
}

TEMPLATE_TEST_CASE("in 2D a figure has one tangent", "[figure][plane]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(seeds(3)));
    CAPTURE(seed);
    const cageform::Polygon<T> cage(random_star<T>(seed));
    const cageform::MeanValueCoordinates<T, 2> coordinates(cage);
    Random random(seed);
    Points2<T> points;
    for (int n = 0; n < 60; ++n) points.push_back(random_inside(cage, random));
    const auto normals = random_directions<T, 2>(points.size(), seed);
    const auto pose = shaken(coordinates.handles(), 0.1, seed);
    const auto turned = bind_vectors(coordinates, points, cageform::tangents_of(normals));
    Points2<T> up(points.size()), out(points.size()), out_up(points.size());
    REQUIRE(clone_normals(turned.value, pose, up) == Status::ok);
    const auto [figure, report] = cageform::bind(coordinates, FigurePoints{points, normals});
    REQUIRE(report.status == Status::ok);
    REQUIRE(clone(figure, pose, FigureOutput{out, out_up}) == Status::ok);
    CHECK(out == cloned(cageform::bind(coordinates, points).value, pose));
    CHECK(out_up == up);
    const auto packed = cageform::pack(figure);
    const auto opened = cageform::open<T, 2>(packed.value.bytes());
    REQUIRE(opened.status() == Status::ok);
    REQUIRE(clone(opened.value, pose, FigureOutput{out, out_up}) == Status::ok);
    CHECK(out_up == up);
    CHECK(opened.value.part(FigureTags::bitangents).empty());
}

TEST_CASE("a figure is solved once, and the report has the solver", "[figure][harmonic]") {
    const auto check = [](auto coordinates, const auto& points, const auto& normals) {
        const auto [figure, report] = cageform::bind(coordinates, FigurePoints{points, normals});
        REQUIRE(report.status == Status::ok);
        // Equal times show that both reports are of the same solve.
        CHECK(report.points.solver.seconds > 0);
        CHECK(report.points.solver.seconds == report.vectors.solver.seconds);
        CHECK(report.points.solver.solves == coordinates.handles().size());
        // Solved functions are not solved again.
        const auto before = coordinates.solve();
        const auto again = cageform::bind(coordinates, FigurePoints{points, normals});
        CHECK(again.report.points.solver.seconds == before.solver.seconds);
        CHECK(again.report.vectors.solver.seconds == before.solver.seconds);
        // Bits of separate calls.
        const auto bound = cageform::bind(coordinates, points);
        const auto turned = bind_vectors(coordinates, points, cageform::tangents_of(normals));
        const auto pose = shaken(coordinates.handles(), 0.1, 3);
        CHECK(cloned(figure.points, pose) == cloned(bound.value, pose));
        for (std::size_t k = 0; k < turned.value.size(); ++k)
            CHECK(cloned(figure.tangents[k], pose) == cloned(turned.value[k], pose));
    };
    const cageform::Polygon<double> cage(random_star<double>(4));
    Random random(4);
    Points2<double> points;
    for (int n = 0; n < 40; ++n) points.push_back(random_inside(cage, random));
    check(cageform::HarmonicCoordinates<double, 2>(cage, {.resolution = 64}, cageform::UniformGrid{}), points,
          random_directions<double, 2>(40, 4));
    const auto mesh = sphere(1).mesh<float>();
    check(cageform::HarmonicCoordinates<float, 3>(mesh, {.resolution = 16}, cageform::UniformGrid{}),
          points_in(mesh, 40, 4), random_directions<float, 3>(40, 4));
}

TEST_CASE("errors of the cage, the solver and the caller are reported by bind", "[figure][status]") {
    const auto mesh = random_mesh(2).mesh<float>();
    const auto points = points_in(mesh, 20, 2);
    const auto normals = random_directions<float, 3>(20, 2), fewer = random_directions<float, 3>(19, 2);
    const Mean3<float> coordinates(mesh);
    const auto empty = [](const auto& result) {
        return result.value.points.point_count() == 0 && !result.value.has_normals();
    };
    auto result = cageform::bind(coordinates, FigurePoints{points, fewer});
    CHECK(result.report.status == Status::vectors_do_not_match);
    CHECK(empty(result));
    result = cageform::bind(coordinates, FigurePoints{points, normals, fewer});
    CHECK(result.report.status == Status::vectors_do_not_match);
    result = cageform::bind(coordinates, FigurePoints{points, normals}, {},
                            {.progress = [](double) { return false; }});
    CHECK(result.report.status == Status::cancelled);
    CHECK(empty(result));

    const Points2<double> bow{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, one{{0.2, 0.1}};
    const cageform::HarmonicCoordinates<double, 2> crossed(bow);
    const auto faulty = cageform::bind(crossed, FigurePoints{one, one});
    CHECK(faulty.report.status == Status::cage_self_crossing);
    CHECK(faulty.report.points.cage.status == Status::cage_self_crossing);
    const Points2<double> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const cageform::HarmonicCoordinates<double, 2> coarse(square, {.resolution = 2}, cageform::UniformGrid{});
    const auto refused = cageform::bind(coarse, FigurePoints{one, one});
    CHECK(refused.report.status == Status::resolution_not_supported);
    CHECK(refused.report.points.status == Status::resolution_not_supported);
    CHECK(refused.report.points.points == 1);

    // Invalid points and normals are listed; the others are bound.
    auto with_bad = points;
    with_bad[3][0] = std::numeric_limits<float>::infinity();
    auto bad_normals = normals;
    bad_normals[5][1] = std::numeric_limits<float>::quiet_NaN();
    const auto listed = cageform::bind(coordinates, FigurePoints{with_bad, bad_normals});
    REQUIRE(listed.report.status == Status::ok);
    CHECK(listed.report.points.not_finite == std::vector<std::size_t>{3});
    CHECK(listed.report.vectors.not_finite == std::vector<std::size_t>{3, 5});
}

TEST_CASE("the progress of a figure rises from 0 to 1", "[figure][progress]") {
    const auto mesh = sphere(1).mesh<float>();
    const auto points = points_in(mesh, 400, 2), normals = random_directions<float, 3>(400, 2);
    std::vector<double> told;
    const cageform::Running running{.progress = [&told](double done) {
        told.push_back(done);
        return true;
    }};
    const auto check = [&told] {
        REQUIRE(told.size() > 2);
        CHECK(std::is_sorted(told.begin(), told.end()));
        CHECK(told.front() >= 0);
        CHECK(told.back() == Approx(1));
        told.clear();
    };
    const auto [figure, report] = cageform::bind(
        cageform::HarmonicCoordinates<float, 3>(mesh, {.resolution = 16}, cageform::UniformGrid{}),
        FigurePoints{points, normals}, {}, running);
    check();
    REQUIRE(cageform::pack(figure, {.weights = {.largest = 6}}, running).report.status == Status::ok);
    check();
}

TEST_CASE("tangents meet their own tolerance, with and without one for points", "[figure][tolerance]") {
    const auto figure = small_figure(3);
    for (const double of_points : {0.0, 0.02}) {
        const auto [packed, report] =
            cageform::pack(figure, {.weights = {.tolerance = of_points}, .tangent_tolerance = 0.01});
        REQUIRE(report.status == Status::ok);
        CHECK(cageform::open<float, 3>(packed.bytes()).status() == Status::ok);
        CHECK(report.points.distance.value <= (of_points == 0 ? 1e-6 : of_points));
        for (const auto& part : report.vectors) {
            CHECK(part.distance.value <= 0.01);
            CHECK(part.distance.value > 0.001); // weights were dropped
        }
    }
    for (const double none : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
        const auto report = cageform::pack(figure, {.tangent_tolerance = none}).report;
        CHECK(report.status == Status::value_not_finite);
        CHECK(report.culprit == FigureTags::tangents);
    }
}

TEST_CASE("figures of one point or one position can be packed with a tolerance", "[figure][tolerance]") {
    const auto mesh = random_mesh(5).mesh<float>();
    const auto place = points_in(mesh, 1, 5);
    for (const std::size_t count : {1u, 20u}) {
        const std::vector points(count, place[0]);
        const auto normals = random_directions<float, 3>(count, 5);
        const auto bound = cageform::bind(Mean3<float>(mesh), FigurePoints{points, normals});
        REQUIRE(bound.report.status == Status::ok);
        const auto [packed, report] = cageform::pack(bound.value, {.weights = {.tolerance = 0.01}});
        REQUIRE(report.status == Status::ok);
        CHECK(cageform::open<float, 3>(packed.bytes()).status() == Status::ok);
    }
}

TEST_CASE("a figure with parts of different sizes is rejected", "[figure][status]") {
    auto figure = small_figure(4);
    const std::size_t points = figure.points.point_count(), handles = figure.points.handle_count();
    const std::vector<std::string> labels(handles, "one of many");
    REQUIRE(figure.set_labels(labels) == Status::ok);
    const auto refused = [](const cageform::FigureBinding<float, 3>& broken, Status status,
                            FigureTag culprit) {
        const auto [packed, report] = cageform::pack(broken);
        CHECK(report.status == status);
        CHECK(report.culprit == culprit);
        CHECK(packed.bytes().empty());
    };
    auto short_of_signs = figure;
    short_of_signs.handedness.pop_back();
    refused(short_of_signs, Status::vectors_do_not_match, FigureTags::handedness);
    std::vector<Vec<float, 3>> out(points), up(points);
    std::vector<std::array<float, 4>> along(points);
    const std::vector pose(figure.view().rest_handles().begin(), figure.view().rest_handles().end());
    CHECK(clone(figure, pose, FigureOutput{out, up, along}) == Status::ok);
    CHECK(clone(short_of_signs, pose, FigureOutput{out, up, along}) == Status::vectors_missing);

    auto of_another_cage = figure; // a box has eight handles
    of_another_cage.points =
        cageform::bind(Mean3<float>(divided_box({1, 1, 1}, 1).mesh<float>()), FigurePoints{out}).value.points;
    REQUIRE(of_another_cage.points.handle_count() != handles);
    of_another_cage.tangents = {};
    of_another_cage.handedness.clear();
    refused(of_another_cage, Status::labels_do_not_match, FigureTags::labels);
    CHECK(of_another_cage.view().label(0).empty());
    of_another_cage = figure;
    of_another_cage.tangents[1] = small_figure(5, points + 1).tangents[1];
    refused(of_another_cage, Status::bindings_differ, FigureTags::bitangents);
}

TEST_CASE("a packed figure keeps labels and parts of the user", "[figure][labels]") {
    const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {2, 1, 3}};
    const std::array notes{std::byte{7}, std::byte{8}, std::byte{9}};
    const cageform::FigurePartData parts[] = {
        {"TRIS", std::as_bytes(std::span(triangles))}, {"NOTE", notes}, {"NONE", {}}};
    const auto figure = small_figure();
    const auto packed = cageform::pack(figure, {.parts = parts});
    REQUIRE(packed.report.status == Status::ok);
    Aligned elsewhere(packed.value.bytes());
    const auto opened = cageform::open<float, 3>(elsewhere.bytes());
    REQUIRE(opened.status() == Status::ok);
    const auto read = opened.value.part_as<std::array<std::uint32_t, 3>>("TRIS");
    CHECK(std::equal(read.begin(), read.end(), triangles.begin(), triangles.end()));
    CHECK(opened.value.part("NOTE").size() == 3);
    CHECK(opened.value.part("NOTE")[2] == std::byte{9});
    CHECK(opened.value.part("NONE").empty());
    CHECK(opened.value.part("ELSE").empty());
    for (std::size_t i = 0; i < figure.points.handle_count(); ++i) {
        const std::string label = i % 3 == 1 ? "" : "corner " + std::to_string(i);
        CHECK(opened.value.label(i) == label);
        CHECK(figure.view().label(i) == label);
        if (i % 3 != 1) CHECK(opened.value.find_handle(label) == i);
    }
    CHECK(opened.value.find_handle("corner") == figure.points.handle_count());

    auto labelled = figure;
    const std::array<std::string_view, 2> two{"a", "b"};
    CHECK(labelled.set_labels(two) == Status::labels_do_not_match);
    CHECK(labelled.view().label(3) == "corner 3");
    const auto refused = [&](FigureTag tag, FigureTag other, Status status) {
        const cageform::FigurePartData twice[] = {{other, notes}, {tag, notes}};
        const auto result = cageform::pack(figure, {.parts = twice});
        CHECK(result.report.status == status);
        CHECK(result.report.culprit == tag);
        CHECK(result.value.bytes().empty());
    };
    refused("NOTE", "NOTE", Status::duplicate_tag);
    for (const FigureTag own : {FigureTags::points, FigureTags::tangents, FigureTags::bitangents,
                                FigureTags::handedness, FigureTags::labels, FigureTag{}})
        refused(own, "NOTE", Status::duplicate_tag);
    const std::vector<cageform::FigurePartData> many(300);
    CHECK(cageform::pack(figure, {.parts = many}).report.status == Status::too_many_parts);
    CHECK(FigureTags::tangents.text() == std::array{'T', 'A', 'N', '1', '\0'});
    const auto few = cageform::pack(figure, {.weights = {.largest = 2}}); // with the part of the user
    CHECK(few.report.status == Status::too_few_weights);
    CHECK(few.report.culprit == FigureTags::points);
}

TEST_CASE("rebind_cage equals bind and keeps the labels", "[figure][rebind][labels]") {
    const auto seed = std::uint64_t(GENERATE(seeds(3)));
    CAPTURE(seed);
    const auto mesh = sphere(1).mesh<float>();
    const auto points = points_in(mesh, 40, seed), normals = random_directions<float, 3>(40, seed);
    const auto tangents = signed_tangents<float>(40, seed);
    const auto inside = [&points] { // so that points stay inside after every edit
        auto smaller = points;
        for (auto& p : smaller) p = 0.5f * p;
        return smaller;
    }();
    auto before = cageform::bind(Mean3<float>(mesh), FigurePoints{inside, normals, tangents}).value;
    std::vector<std::string> labels;
    for (std::size_t i = 0; i < mesh.size(); ++i) labels.push_back("v" + std::to_string(i));
    REQUIRE(before.set_labels(labels) == Status::ok);
    const auto check = [&](const Mean3<float>& edited, std::span<const std::size_t> given,
                           std::span<const std::size_t> expected) {
        const auto again = rebind_cage(before, edited, given);
        const auto anew = cageform::bind(edited, FigurePoints{inside, normals, tangents});
        REQUIRE(again.report.status == Status::ok);
        REQUIRE(anew.report.status == Status::ok);
        CHECK(std::equal(expected.begin(), expected.end(), again.report.old_handles.begin(),
                         again.report.old_handles.end()));
        const auto pose = shaken(edited.handles(), 0.2, seed);
        Points3<float> out(40), up(40), out_anew(40), up_anew(40);
        std::vector<std::array<float, 4>> along(40), along_anew(40);
        REQUIRE(clone(again.value, pose, FigureOutput{out, up, along}) == Status::ok);
        REQUIRE(clone(anew.value, pose, FigureOutput{out_anew, up_anew, along_anew}) == Status::ok);
        CHECK(out == out_anew);
        CHECK(again.report.points.partition_error.value == anew.report.points.partition_error.value);
        for (std::size_t i = 0; i < 40; ++i) { // unit tangents stay equal up to rounding
            CHECK(distance(up[i], up_anew[i]) <= 1e-6);
            CHECK(along[i] == along_anew[i]);
        }
        for (std::size_t i = 0; i < expected.size(); ++i)
            CHECK(again.value.view().label(i) ==
                  (expected[i] == cageform::new_handle ? "" : labels[expected[i]]));
    };
    std::vector<std::size_t> same(mesh.size());
    std::iota(same.begin(), same.end(), std::size_t{0});
    const auto moved = shaken(mesh.vertices(), 0.05, seed);
    check(Mean3<float>(moved, mesh.faces()), {}, same);

    // A new vertex in the centre of the first face, and reversed indices.
    Points3<float> more(mesh.vertices().rbegin(), mesh.vertices().rend());
    const auto last = std::uint32_t(mesh.size() - 1);
    std::vector<std::array<std::uint32_t, 3>> faces;
    for (const auto& f : mesh.faces())
        faces.push_back({last - std::uint32_t(f[0]), last - std::uint32_t(f[1]), last - std::uint32_t(f[2])});
    const auto [a, b, c] = faces[0];
    more.push_back((1.0f / 3) * (more[a] + more[b] + more[c]));
    faces[0] = {a, b, last + 1};
    faces.push_back({b, c, last + 1});
    faces.push_back({c, a, last + 1});
    std::vector<std::size_t> reversed(same.rbegin(), same.rend());
    reversed.push_back(cageform::new_handle);
    const Mean3<float> longer(more, faces);
    check(longer, {}, reversed);
    check(longer, reversed, reversed);

    CHECK(rebind_cage(before, longer, same).report.status == Status::labels_do_not_match);
    reversed[3] = mesh.size();
    CHECK(rebind_cage(before, longer, reversed).report.status == Status::labels_do_not_match);
    more[2][1] = std::numeric_limits<float>::quiet_NaN();
    const auto faulty = rebind_cage(before, Mean3<float>(more, faces));
    CHECK(faulty.report.status == Status::vertex_not_finite);
    CHECK(faulty.report.points.cage.status == Status::vertex_not_finite);
    CHECK(faulty.value.points.point_count() == 0);
}

TEST_CASE("clones of a figure reject invalid input without writing", "[figure][status]") {
    const auto mesh = random_mesh(1).mesh<float>();
    const auto figure = small_figure();
    const auto points = points_in(mesh, 37, 1);
    const Mean3<float> coordinates(mesh);
    const auto bare = cageform::bind(coordinates, FigurePoints{points}).value;
    const auto of_normals =
        cageform::bind(coordinates, FigurePoints{points, random_directions<float, 3>(37, 1)}).value;
    const auto pose = shaken(mesh.vertices(), 0.1, 1);
    Points3<float> out(37), normals(37), tangents(37), few(36);
    const auto refused = [&](const auto& of, const auto& with, Status expected) {
        CHECK(clone(of, with, FigureOutput{out, normals, tangents}) == expected);
        CHECK(out == Points3<float>(37));
        CHECK(normals == Points3<float>(37));
        CHECK(tangents == Points3<float>(37));
    };
    refused(bare, pose, Status::vectors_missing);
    refused(of_normals, pose, Status::vectors_missing); // it has no tangents of its own
    auto bad = pose;
    bad[2][1] = std::numeric_limits<float>::infinity();
    refused(figure, bad, Status::pose_not_finite);
    bad.pop_back();
    refused(figure, bad, Status::pose_size_differs);
    CHECK(clone(figure, pose, FigureOutput{few, normals, tangents}) == Status::output_too_small);
    CHECK(clone(figure, pose, FigureOutput{out, few, tangents}) == Status::output_too_small);
    CHECK(clone(figure, pose, FigureOutput{out, normals, few}) == Status::output_too_small);
    auto mixed = figure;
    mixed.tangents[1] = small_figure(1, 36).tangents[1];
    refused(mixed, pose, Status::bindings_differ);
    const std::size_t before = allocations;
    const Status status = clone(figure, pose, FigureOutput{out, normals, tangents});
    CHECK(allocations == before);
    CHECK(status == Status::ok);
    STATIC_REQUIRE(noexcept(clone(figure, pose, FigureOutput{out, normals, tangents})));
}

TEST_CASE("a figure of another kind, cage or figure is rejected with its status", "[figure][status]") {
    const auto packed = small_packed();
    const auto bytes = packed.bytes();
    const auto opened = cageform::open<float, 3>(bytes);
    REQUIRE(opened.status() == Status::ok);
    CHECK(opened.report.bytes == bytes.size());
    CHECK(status_of(bytes, {.cage_hash = opened.report.cage_hash,
                            .figure_hash = opened.report.figure_hash}) == Status::ok);
    CHECK(status_of(bytes, {.cage_hash = 1}) == Status::blob_of_another_cage);
    CHECK(status_of(bytes, {.figure_hash = 1}) == Status::blob_of_another_figure);
    CHECK(cageform::open<double, 3>(bytes).status() == Status::blob_kind_differs);
    CHECK(cageform::open<float, 2>(bytes).status() == Status::blob_kind_differs);
    CHECK(status_of({}) == Status::not_a_figure);
    CHECK(status_of(bytes.subspan(8)) == Status::not_a_figure);
    const auto single = cageform::open<float, 3>(opened.value.part(FigureTags::points));
    REQUIRE(single.status() == Status::ok); // a single binding is a figure with only points
    CHECK(single.value.point_count() == opened.value.point_count());
    CHECK(!single.value.has_normals());
    CHECK(single.report.bytes == opened.value.part(FigureTags::points).size());
    CHECK(cageform::open_blob<float, 3>(bytes).status() == Status::not_a_blob);

    Aligned newer(bytes);
    newer.set(offsetof(FigureHeader, version), FigureHeader::current_version + 1);
    CHECK(status_of(newer.bytes()) == Status::blob_version_differs);
    Aligned turned(bytes);
    std::reverse(turned.data(), turned.data() + 8);
    CHECK(status_of(turned.bytes()) == Status::blob_version_differs);
    Aligned tag(bytes);
    tag.set(offsetof(FigureHeader, endian), std::uint32_t(0x04030201));
    CHECK(status_of(tag.bytes()) == Status::blob_version_differs);
}

TEST_CASE("a truncated figure or one with any bit flipped is rejected", "[figure][status]") {
    const auto packed = small_packed();
    const auto bytes = packed.bytes();
    for (std::size_t size = 0; size < bytes.size(); size += size < 256 ? 1 : 89) {
        Aligned memory(bytes.first(size)); // of the exact size, so that sanitizers detect reads past the end
        CAPTURE(size);
        const Status status = cageform::open<float, 3>(memory.bytes()).status();
        CHECK(status == (size < 16 ? Status::not_a_figure : Status::blob_truncated));
    }
    Aligned memory(bytes);
    std::size_t accepted = 0;
    for (std::size_t byte = 0; byte < bytes.size(); byte += byte < 256 ? 1 : 89) {
        for (int bit = int(byte % 3); bit < 8; bit += 3) {
            memory.data()[byte] ^= std::byte(1 << bit);
            if (cageform::open<float, 3>(memory.bytes()).status() == Status::ok) ++accepted;
            memory.data()[byte] ^= std::byte(1 << bit);
        }
    }
    CHECK(accepted == 0);
    CHECK(status_of(memory.bytes()) == Status::ok);
}

TEST_CASE("parts of a figure that do not match are rejected", "[figure][status]") {
    const auto figure = small_figure();
    const cageform::PackOptions sparse{.format = WeightFormat::int16, .largest = 4};
    const auto points = cageform::pack(figure.points, sparse);
    auto in_order = sparse;
    in_order.order = {points.value.view().order, 37};
    const auto first = cageform::pack(figure.tangents[0], in_order),
               second = cageform::pack(figure.tangents[1], in_order);
    const auto refused = [&](const auto& one, const auto& two, const auto& three, FigureTag culprit) {
        const cageform::FigurePartData parts[] = {{FigureTags::points, one.value.bytes()},
                                                  {FigureTags::tangents, two.value.bytes()},
                                                  {FigureTags::bitangents, three.value.bytes()}};
        const cageform::PackedFigure<float, 3> made(parts);
        const auto opened = cageform::open<float, 3>(made.bytes());
        CHECK(opened.report.culprit == culprit);
        return opened.status();
    };
    CHECK(refused(points, first, second, FigureTag{}) == Status::ok);
    // Another order: each part is valid by itself.
    const auto astray = cageform::pack(figure.tangents[1], sparse);
    CHECK(refused(points, first, astray, FigureTags::bitangents) == Status::bindings_differ);
    const auto dense = cageform::pack(figure.tangents[0]);
    CHECK(refused(points, dense, second, FigureTags::tangents) == Status::bindings_differ);
    const auto fewer = cageform::pack(small_figure(1, 36).tangents[0], {.largest = 4});
    CHECK(refused(points, fewer, second, FigureTags::tangents) == Status::bindings_differ);
    const auto elsewhere = cageform::pack(small_figure(5).tangents[0], in_order);
    CHECK(refused(points, elsewhere, second, FigureTags::tangents) == Status::bindings_differ);
    // As many handles at other positions, with the same hash.
    auto moved = random_binding<float, 3>(37, figure.points.handle_count(), 3);
    in_order.cage_hash = cageform::open<float, 3>(small_packed().bytes()).report.cage_hash;
    const auto other_cage = cageform::pack(moved, in_order);
    CHECK(refused(points, other_cage, second, FigureTags::tangents) == Status::bindings_differ);

    const auto tag_of_bad = [&](std::span<const cageform::FigurePartData> parts) {
        const cageform::PackedFigure<float, 3> made(parts);
        const auto opened = cageform::open<float, 3>(made.bytes());
        CHECK(opened.status() != Status::ok);
        return opened.report.culprit;
    };
    const cageform::FigurePartData all[] = {{FigureTags::tangents, first.value.bytes()},
                                            {FigureTags::points, points.value.bytes()},
                                            {FigureTags::handedness, std::as_bytes(std::span("x"))}};
    CHECK(tag_of_bad(std::span(all).first(1)) == FigureTags::points);       // no points
    CHECK(tag_of_bad(std::span(all).first(2)) == FigureTags::bitangents);   // one tangent in 3D
    CHECK(tag_of_bad(std::span(all).subspan(1)) == FigureTags::handedness); // handedness without tangents
}

TEST_CASE("every inconsistency in a figure with a valid checksum is found", "[figure][status]") {
    const auto packed = small_packed();
    const Aligned sound(packed.bytes());
    const auto refused = [&](auto change) {
        Aligned memory = sound;
        change(memory);
        memory.seal();
        return status_of(memory.bytes()) == Status::blob_malformed &&
               status_of(memory.bytes(), {.check = BlobCheck::structure}) == Status::blob_malformed;
    };
    CHECK_FALSE(refused([](Aligned&) {}));
    const auto line = [&](FigureTag tag, std::size_t field, std::uint64_t x) {
        return [=](Aligned& m) { m.set(line_of(m, tag) + field, x); };
    };
    const std::size_t offset = offsetof(FigurePart, offset), bytes = offsetof(FigurePart, bytes);
    for (const FigureTag tag : {FigureTags::points, FigureTags::tangents, FigureTags::bitangents,
                                FigureTags::handedness, FigureTags::labels}) {
        CAPTURE(tag.text().data());
        for (const std::uint64_t x :
             {std::uint64_t(0), std::uint64_t(64), std::uint64_t(packed.bytes().size() + 64),
              std::uint64_t(packed.bytes().size() - 4), ~std::uint64_t{63}})
            CHECK(refused(line(tag, offset, x)));
        for (const std::uint64_t x : {std::uint64_t(packed.bytes().size()), ~std::uint64_t{0}})
            CHECK(refused(line(tag, bytes, x)));
    }
    for (const std::uint64_t x : {0u, 36u, 38u}) CHECK(refused(line(FigureTags::handedness, bytes, x)));
    for (const std::uint64_t x : {0u, 3u, 4u}) CHECK(refused(line(FigureTags::labels, bytes, x)));
    CHECK(refused([](Aligned& m) { m.data()[offset_of(m, FigureTags::handedness) + 5] = std::byte{0}; }));
    for (const std::size_t entry : {0u, 2u})
        CHECK(refused([=](Aligned& m) {
            m.set(offset_of(m, FigureTags::labels) + 4 * entry, std::uint32_t(1u << 30));
        }));
    CHECK(refused(
        [](Aligned& m) { m.set(line_of(m, FigureTags::bitangents), FigureTags::tangents); })); // twice
    CHECK(refused([](Aligned& m) { m.set(line_of(m, FigureTags::bitangents), FigureTag("ELSE")); }));
    for (const std::uint32_t parts : {0u, 257u, ~0u})
        CHECK_FALSE(status_of([&] {
                        Aligned m = sound;
                        m.set(offsetof(FigureHeader, parts), parts);
                        m.seal();
                        return m;
                    }()
                                  .bytes()) == Status::ok);
}

TEST_CASE("hostile figures never cause access out of bounds", "[figure][hostile]") {
    const std::array sound{Aligned(small_packed().bytes()), Aligned(small_packed({}).bytes())};
    Random random{std::uint64_t(GENERATE(range(0, 2)))};
    std::size_t opened_count = 0;
    for (int round = 0; round < 4000; ++round) {
        Aligned memory = sound[random.below(2)];
        for (std::size_t n = 1 + random.below(3); n > 0; --n) {
            const std::size_t reach = random.below(2) == 0 ? 512 : memory.bytes().size();
            const std::uint32_t values[] = {0,
                                            1,
                                            64,
                                            0xFFFFFFFFu,
                                            std::uint32_t(random.bits()),
                                            std::uint32_t(random.below(memory.bytes().size()))};
            memory.set(random.below(reach / 4) * 4, values[random.below(std::size(values))]);
        }
        if (random.below(2) == 0) memory.seal();
        const auto opened = cageform::open<float, 3>(memory.bytes(), {.check = BlobCheck::structure});
        if (opened.status() != Status::ok) continue;
        ++opened_count;
        const auto& figure = opened.value;
        const Points3<float> pose(figure.handle_count(), Vec<float, 3>{1, 2, 3});
        Points3<float> out(figure.point_count()), normals(out), tangents(out);
        const Status status = clone(figure, pose, FigureOutput{out, normals, tangents});
        CHECK(
            (status == Status::ok || status == Status::pose_not_finite || status == Status::vectors_missing));
        std::size_t letters = 0;
        for (std::size_t i = 0; i < figure.handle_count(); ++i) {
            for (const char c : figure.label(i)) letters += std::size_t(c != 0);
        }
        CHECK(letters <= memory.bytes().size());
    }
    CHECK(opened_count > 40);
}

} // namespace figure_tests
