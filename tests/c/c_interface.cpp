// The C interface: statuses, equality with C++, invalid calls, and failing allocations.
#if !defined(CAGEFORM_COMPILED) // else it is in the library
#define CAGEFORM_C_IMPLEMENTATION
#endif
#include "../catch.hpp"
#include "../support/allocations.hpp"
#include "../support/effort.hpp"
#include "support.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/c/detail/objects.hpp>
#include <cageform/clone/clone_figure.hpp>
#include <cageform/clone/clone_transposed.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

#include <cstring>
#include <set>
#include <string>

extern "C" int cageform_c_calls(void); // calls.c

namespace c_interface_tests {

using cageform::Status;

namespace {

/// A bar in 3D and points in and around it, bound by both interfaces.
template <class T>
struct Bar {
    MeshData cage = divided_box({1, 1, 3}, 1);
    std::vector<Vec<double, 3>> vertices = cage.vertices;
    std::vector<Vec<T, 3>> figure, normals, pose;
    std::vector<std::uint32_t> indices;
    Owned<cageform_coordinates> coordinates;
    Owned<cageform_binding> binding;

    explicit Bar(std::uint32_t type, std::size_t count = 300) {
        Random random(20261126);
        for (std::size_t n = 0; n < count; ++n) {
            figure.push_back({T(random.uniform(-0.45, 0.45)), T(random.uniform(-0.45, 0.45)),
                              T(random.uniform(-1.4, 1.4))});
            normals.push_back({T(random.uniform(-1, 1)), T(random.uniform(-1, 1)), T(1)});
        }
        for (const auto& face : cage.faces) {
            for (const int vertex : face) indices.push_back(std::uint32_t(vertex));
        }
        auto described = sized<cageform_cage>();
        described.kind = CAGEFORM_MESH;
        described.vertices = points_of(vertices);
        described.indices = indices.data();
        described.index_count = indices.size();
        auto options = sized<cageform_coordinates_options>();
        options.type = type;
        options.scalar = std::is_same_v<T, double> ? CAGEFORM_DOUBLE : CAGEFORM_FLOAT;
        REQUIRE(cageform_coordinates_create(&described, &options, &coordinates.object, nullptr) ==
                CAGEFORM_OK);
        const auto of_normals = points_of(normals);
        REQUIRE(cageform_bind(coordinates.object, points_of(figure), &of_normals, nullptr, nullptr, nullptr,
                              &binding.object, nullptr) == CAGEFORM_OK);
        for (const auto& v : vertices)
            pose.push_back({T(v[0] + 0.1 * v[2] * v[2]), T(v[1] + random.uniform(-0.2, 0.2)), T(v[2])});
    }
};

/// A bar that bends and twists differently in every frame.
template <class T>
struct Motion {
    MeshData figure = divided_box({1, 1, 3}, 2);
    std::vector<Vec<double, 3>> rest = figure.vertices;
    std::vector<std::uint32_t> indices;
    std::vector<std::vector<Vec<T, 3>>> frames;
    std::vector<Vec<T, 3>> in_a_row;

    explicit Motion(Random random) {
        for (const auto& face : figure.faces) {
            for (const int vertex : face) indices.push_back(std::uint32_t(vertex));
        }
        for (std::size_t t = 0; t < 7; ++t) {
            const double twist = random.uniform(-0.5, 0.5), bend = random.uniform(-0.3, 0.3);
            auto& frame = frames.emplace_back();
            for (const auto& v : rest) {
                const auto [x, y, z] = std::array{v[0], v[1], v[2]};
                const double c = std::cos(twist * z), s = std::sin(twist * z);
                frame.push_back({T(c * x - s * y + bend * z * z), T(s * x + c * y), T(z)});
            }
            in_a_row.insert(in_a_row.end(), frame.begin(), frame.end());
        }
    }
};

template <class T>
void check_skeleton_bits(std::uint64_t seed) {
    CAPTURE(seed);
    const Motion<T> motion{Random(seed)};
    for (const auto kind :
         {cageform::BoneKind::rigid, cageform::BoneKind::similar, cageform::BoneKind::stretched}) {
        const auto expected = cageform::fit_skeleton(motion.rest, motion.frames, motion.figure.faces,
                                                     {.bones = 3, .influences = 2, .kind = kind});
        REQUIRE(expected);
        auto options = sized<cageform_skeleton_options>();
        options.bones = 3;
        options.influences = 2;
        options.kind = std::uint32_t(kind);
        auto running = sized<cageform_running>();
        running.threads = 2;
        auto report = sized<cageform_report>();
        Owned<cageform_skeleton> skeleton;
        REQUIRE(cageform_fit_skeleton(points_of(motion.rest), points_of(motion.in_a_row),
                                      motion.indices.data(), motion.indices.size(), &options, &running,
                                      &skeleton.object, &report) == CAGEFORM_OK);
        CHECK(report.rms == expected.report.rms);
        CHECK(report.max_distance == expected.report.max_distance);
        CHECK(report.frame == expected.report.frame);
        CHECK(report.culprit == expected.report.vertex);
        auto info = sized<cageform_skeleton_info>();
        REQUIRE(cageform_skeleton_describe(skeleton.object, &info) == CAGEFORM_OK);
        const auto& its = expected.value;
        REQUIRE(info.bones == its.bones);
        REQUIRE(info.frames == its.frames);
        REQUIRE(info.vertices == motion.rest.size());
        CHECK(std::equal(its.parents.begin(), its.parents.end(), info.parents));
        CHECK(std::equal(its.skin.joints.begin(), its.skin.joints.end(), info.vertex_bones));
        CHECK(std::equal(its.skin.weights.begin(), its.skin.weights.end(), info.weights));
        CHECK(std::memcmp(info.joints, its.joints.data(), its.bones * 3 * sizeof(double)) == 0);
        CHECK(std::memcmp(info.maps, its.maps.data(), its.frames * its.bones * 12 * sizeof(double)) == 0);
    }
}

template <class T>
void check_bits(std::uint32_t type, const auto& coordinates) {
    const Bar<T> bar(type);
    const auto bound = cageform::bind(coordinates, cageform::FigurePoints{bar.figure, bar.normals});
    REQUIRE(bound);
    Owned<cageform_bytes> packed;
    auto options = sized<cageform_pack_options>();
    options.tolerance = 1e-3;
    REQUIRE(cageform_pack(bar.binding.object, &options, nullptr, &packed.object, nullptr) == CAGEFORM_OK);
    const void* data = nullptr;
    std::size_t bytes = 0;
    REQUIRE(cageform_bytes_view(packed.object, &data, &bytes) == CAGEFORM_OK);
    cageform::FigurePackOptions own;
    own.weights.tolerance = 1e-3;
    const auto expected = pack(bound.value, own);
    REQUIRE(expected);
    REQUIRE(expected.value.bytes().size() == bytes);
    CHECK(std::memcmp(expected.value.bytes().data(), data, bytes) == 0);

    Owned<cageform_figure> dense, opened;
    REQUIRE(cageform_binding_figure(bar.binding.object, &dense.object) == CAGEFORM_OK);
    REQUIRE(cageform_open(data, bytes, nullptr, &opened.object, nullptr) == CAGEFORM_OK);
    const auto view = cageform::open<T, 3>(expected.value.bytes());
    const auto compare = [&](cageform_figure* figure, const auto& its) {
        std::vector<Vec<T, 3>> out(bar.figure.size()), normals(out), points(out), turned(out);
        const auto to = output_of(normals);
        REQUIRE(cageform_clone(figure, points_of(bar.pose), output_of(out), &to, nullptr, nullptr) ==
                CAGEFORM_OK);
        REQUIRE(clone(its, bar.pose, cageform::FigureOutput{points, turned}) == Status::ok);
        CHECK(out == points);
        CHECK(normals == turned);
        std::vector<Vec<T, 3>> gradients(bar.pose.size()), of_handles(gradients);
        REQUIRE(cageform_clone_transposed(figure, points_of(out), output_of(gradients), nullptr) ==
                CAGEFORM_OK);
        REQUIRE(cageform::clone_transposed(its.points, points, of_handles) == Status::ok);
        CHECK(gradients == of_handles);
    };
    compare(dense.object, bound.value.view());
    compare(opened.object, view.value);
    std::vector<T> weights(bar.figure.size() * bar.pose.size());
    REQUIRE(cageform_binding_weights(bar.binding.object, 0, bar.figure.size(), weights.data(),
                                     weights.size() * sizeof(T)) == CAGEFORM_OK);
    bool same = true;
    for (std::size_t n = 0; n < weights.size(); ++n)
        same = same && weights[n] == bound.value.points.weight(n / bar.pose.size(), n % bar.pose.size());
    CHECK(same);
}

} // namespace

TEST_CASE("a C program calls every function", "[c]") {
    CHECK(cageform_c_calls() == 0);
}

TEST_CASE("every status has a code, a name and its text", "[c]") {
    std::set<cageform_status> codes;
    std::size_t count = 0;
    for (int n = 0; n < 256; ++n) {
        const auto status = static_cast<Status>(n);
        if (std::string(to_string(status)) == "unknown status") break;
        const cageform_status code = cageform::detail::c::code_of(status);
        CHECK(codes.insert(code).second);
        CHECK(std::string(cageform_status_text(code)) == to_string(status));
        CHECK(std::string(cageform_status_name(code)) != "unknown");
        ++count;
    }
    CHECK(count > 100);
    CHECK(std::string(cageform_status_name(CAGEFORM_ARGUMENT_NULL)) == "argument_null");
    CHECK(std::string(cageform_status_text(CAGEFORM_STATUS_END)) == "unknown status");
}

TEST_CASE("bindings, packed bytes and clones equal those of C++ bit for bit", "[c]") {
    const auto box = divided_box({1, 1, 3}, 1);
    check_bits<float>(CAGEFORM_MEAN_VALUE, cageform::MeanValueCoordinates(box.mesh<float>()));
    check_bits<double>(CAGEFORM_MEAN_VALUE, cageform::MeanValueCoordinates(box.mesh<double>()));
    check_bits<double>(CAGEFORM_HARMONIC, cageform::HarmonicCoordinates<double, 3>(box.mesh<double>()));
}

TEST_CASE("skeletons equal those of C++ bit for bit", "[c]") {
    check_skeleton_bits<float>(20261127);
    check_skeleton_bits<double>(20261128);
}

TEST_CASE("failing allocations give a status, without leaks", "[c]") {
    Bar<double> bar(CAGEFORM_MEAN_VALUE, 20);
    const auto fails = [&](auto call) {
        std::size_t failures = 0;
        for (;; ++failures) {
            failing_allocation = allocations + 1 + failures;
            const cageform_status status = call();
            failing_allocation = 0;
            if (status == CAGEFORM_OK) break;
            REQUIRE(status == CAGEFORM_OUT_OF_MEMORY);
        }
        return failures;
    };
    CHECK(fails([&] {
              Owned<cageform_binding> binding;
              return cageform_bind(bar.coordinates.object, points_of(bar.figure), nullptr, nullptr, nullptr,
                                   nullptr, &binding.object, nullptr);
          }) > 3);
    CHECK(fails([&] {
              Owned<cageform_bytes> packed;
              return cageform_pack(bar.binding.object, nullptr, nullptr, &packed.object, nullptr);
          }) > 3);
    CHECK(fails([&] {
              Owned<cageform_figure> figure;
              return cageform_binding_figure(bar.binding.object, &figure.object);
          }) == 1);
    const Motion<float> motion{Random(20261127)};
    auto options = sized<cageform_skeleton_options>();
    options.bones = 2;
    Owned<cageform_skeleton> skeleton;
    CHECK(fails([&] {
              return cageform_fit_skeleton(points_of(motion.rest), points_of(motion.in_a_row), nullptr, 0,
                                           &options, nullptr, &skeleton.object, nullptr);
          }) > 3);
    std::vector<Vec<double, 3>> translations(14);
    std::vector<Vec<double, 4>> rotations(14);
    CHECK(fails([&] {
              return cageform_skeleton_transforms(skeleton.object, output_of(translations),
                                                  output_of(rotations), nullptr, nullptr);
          }) == 1);
}

TEST_CASE("invalid calls give a status", "[c]") {
    Bar<float> space(CAGEFORM_MEAN_VALUE, 30);
    Owned<cageform_figure> figure;
    Owned<cageform_samples> samples;
    Owned<cageform_pins> pins;
    Owned<cageform_bytes> packed, clip;
    Owned<cageform_player> player;
    Owned<cageform_skeleton> skeleton;
    Owned<cageform_wrap> wrap;
    REQUIRE(cageform_binding_figure(space.binding.object, &figure.object) == CAGEFORM_OK);
    auto sampling = sized<cageform_samples_options>();
    sampling.samples = 200;
    REQUIRE(cageform_pose_samples(space.coordinates.object, &sampling, nullptr, &samples.object, nullptr) ==
            CAGEFORM_OK);
    REQUIRE(cageform_pins_create(samples.object, nullptr, &pins.object) == CAGEFORM_OK);
    REQUIRE(cageform_pack(space.binding.object, nullptr, nullptr, &packed.object, nullptr) == CAGEFORM_OK);
    const double times[2] = {0, 1};
    auto poses = space.pose;
    poses.insert(poses.end(), space.pose.begin(), space.pose.end());
    REQUIRE(cageform_compile_clip(times, 2, points_of(poses), nullptr, nullptr, &clip.object, nullptr) ==
            CAGEFORM_OK);
    const void* clip_data = nullptr;
    std::size_t clip_bytes = 0;
    REQUIRE(cageform_bytes_view(clip.object, &clip_data, &clip_bytes) == CAGEFORM_OK);
    REQUIRE(cageform_play_bytes(clip_data, clip_bytes, nullptr, &player.object) == CAGEFORM_OK);
    auto fitting = sized<cageform_skeleton_options>();
    fitting.bones = 1;
    REQUIRE(cageform_fit_skeleton(points_of(space.pose), points_of(poses), nullptr, 0, &fitting, nullptr,
                                  &skeleton.object, nullptr) == CAGEFORM_OK);
    auto thin = space.vertices;
    for (auto& v : thin) v = {0.2 * v[0], 0.2 * v[1], v[2]};
    const auto solid = drawing_of(thin, space.indices);
    auto coarse = sized<cageform_wrap_options>();
    coarse.finest = 6;
    REQUIRE(cageform_fit_wrap(nullptr, &solid, &solid, &coarse, nullptr, &wrap.object, nullptr) ==
            CAGEFORM_OK);

    const std::uint64_t seed = 20261126;
    CAPTURE(seed);
    Random random(seed);
    alignas(64) std::array<std::byte, 4096> memory{};
    const auto pick = [&](std::size_t count) {
        return std::size_t(random.uniform(0, double(count))) % count;
    };
    const auto number = [&]() -> std::size_t {
        const std::array<std::size_t, 12> odd{
            0, 1, 2, 3, 4, 7, 30, 31, 4096, std::size_t(-1), std::size_t(-1) / 2, 64};
        return odd[pick(odd.size())];
    };
    // Objects of every kind, or null, as a pointer of any type.
    const std::array<void*, 10> objects{nullptr,
                                        space.coordinates.object,
                                        space.binding.object,
                                        figure.object,
                                        samples.object,
                                        pins.object,
                                        packed.object,
                                        player.object,
                                        skeleton.object,
                                        wrap.object};
    const auto any = [&](auto* own) {
        using X = std::remove_pointer_t<decltype(own)>;
        return pick(3) != 0 ? own : static_cast<X*>(objects[pick(objects.size())]);
    };
    // Views of existing memory, with arbitrary other members.
    const auto view = [&]() -> cageform_output {
        const std::size_t from = pick(3) != 0 ? 0 : pick(64);
        return {pick(10) == 0 ? nullptr : memory.data() + from,
                number(),
                pick(3) != 0 ? 0 : number(),
                pick(5) == 0 ? number() % (memory.size() - from) : memory.size() - from,
                pick(8) == 0 ? std::uint32_t(number()) : 0u,
                pick(8) == 0 ? std::uint32_t(number()) : 3u};
    };
    const auto reading = [&] {
        const auto its = view();
        return cageform_points{its.data, its.count, its.stride, its.bytes, its.scalar, its.dimension};
    };
    const auto spoil = [&](auto its) { // sets members to arbitrary values, except sizes of memory
        if (pick(6) == 0) its.size = number();
        return its;
    };
    std::set<cageform_status> met;
    const std::size_t calls = effort<std::size_t>(1000000, 100000);
    for (std::size_t n = 0; n < calls; ++n) {
        if (pick(50) == 0) {
            for (std::size_t b = 0; b < 64; ++b) memory[pick(memory.size())] = std::byte(pick(256));
        }
        cageform_status status = CAGEFORM_OK;
        std::size_t out = 0;
        const char* text = nullptr;
        auto info = spoil(sized<cageform_figure_info>());
        auto report = spoil(sized<cageform_report>());
        const auto points = view();
        switch (pick(20)) {
        case 0: status = cageform_figure_describe(any(figure.object), &info); break;
        case 1: status = cageform_figure_rest(any(figure.object), points); break;
        case 2: status = cageform_figure_label(any(figure.object), number(), &text, &out); break;
        case 3: {
            const auto normals = view();
            status = cageform_clone(any(figure.object), pick(2) ? points_of(space.pose) : reading(), points,
                                    pick(2) ? &normals : nullptr, pick(9) == 0 ? &points : nullptr, nullptr);
            break;
        }
        case 4: status = cageform_clone_transposed(any(figure.object), reading(), points, nullptr); break;
        case 5: status = cageform_pose_handles(any(figure.object), reading(), points); break;
        case 6:
            status =
                cageform_player_sample(any(player.object), random.uniform(-2, 2) / double(pick(2)), points);
            break;
        case 7: {
            auto its = spoil(sized<cageform_clip_info>());
            status = cageform_player_describe(any(player.object), &its);
            break;
        }
        case 8: {
            Owned<cageform_figure> opened;
            status = cageform_open(memory.data(), number() % memory.size(), nullptr, &opened.object, &out);
            break;
        }
        case 9: {
            const std::size_t first = number(), count = number();
            status = cageform_binding_weights(any(space.binding.object), first, count, memory.data(),
                                              memory.size());
            break;
        }
        case 10: {
            std::array<std::size_t, 8> list{};
            status = cageform_binding_list(any(space.binding.object), std::uint32_t(number()), list.data(),
                                           number() % 9, &out);
            break;
        }
        case 11: {
            const std::array<std::uint32_t, 4> handles{0, std::uint32_t(number()), 2,
                                                       std::uint32_t(number())};
            status = pick(2) ? cageform_pins_hold(any(pins.object), handles.data(), pick(5), &report)
                             : cageform_pins_set(any(pins.object), any(figure.object), handles.data(),
                                                 pick(5), nullptr, &report);
            break;
        }
        case 12: {
            auto pose = space.pose;
            status = cageform_pins_solve(any(pins.object), reading(), output_of(pose), &report);
            break;
        }
        case 13: {
            auto cage = spoil(sized<cageform_cage>());
            cage.kind = std::uint32_t(number());
            cage.vertices = reading();
            cage.dimension = std::uint32_t(number());
            cage.divisions = std::uint32_t(pick(4));
            const std::array<std::uint32_t, 6> indices{0, 1, std::uint32_t(number()),
                                                       2, 3, std::uint32_t(number())};
            if (pick(2) != 0) {
                cage.indices = indices.data();
                cage.index_count = pick(7);
            }
            if (pick(3) == 0) {
                cage.counts = indices.data();
                cage.count_count = pick(7);
            }
            std::array<cageform_fault, 4> faults{};
            status = cageform_check(&cage, faults.data(), pick(5), &out);
            if (pick(4) == 0) {
                Owned<cageform_coordinates> made;
                auto options = spoil(sized<cageform_coordinates_options>());
                options.type = std::uint32_t(pick(10));
                options.scalar = std::uint32_t(pick(3));
                status = cageform_coordinates_create(&cage, &options, &made.object, &report);
            }
            break;
        }
        case 14: {
            if (pick(20) != 0) break; // takes longer
            Owned<cageform_binding> binding;
            auto options = spoil(sized<cageform_bind_options>());
            options.outside = std::uint32_t(pick(4));
            status = cageform_bind(any(space.coordinates.object), reading(), nullptr, nullptr, &options,
                                   nullptr, &binding.object, &report);
            break;
        }
        case 15: {
            const auto scales = view(), axes = view();
            status = cageform_skeleton_transforms(any(skeleton.object), points, view(),
                                                  pick(2) ? &scales : nullptr, pick(2) ? &axes : nullptr);
            break;
        }
        case 16: {
            auto described = spoil(sized<cageform_skeleton_info>());
            status = cageform_skeleton_describe(any(skeleton.object), &described);
            if (pick(20) != 0) break; // takes longer
            Owned<cageform_skeleton> fitted;
            auto options = spoil(sized<cageform_skeleton_options>());
            options.bones = number();
            options.influences = number();
            options.kind = std::uint32_t(pick(4));
            const std::array<std::uint32_t, 4> indices{0, std::uint32_t(number()), 2, 1};
            status = cageform_fit_skeleton(pick(2) ? points_of(space.pose) : reading(),
                                           pick(2) ? points_of(poses) : reading(), indices.data(), pick(5),
                                           &options, nullptr, &fitted.object, &report);
            break;
        }
        case 17: {
            const auto jacobians = view();
            status = cageform_wrap_move(any(wrap.object), reading(), points, pick(2) ? &jacobians : nullptr,
                                        nullptr);
            break;
        }
        case 18: {
            auto described = spoil(sized<cageform_wrap_info>());
            status = cageform_wrap_describe(any(wrap.object), &described);
            if (pick(800) != 0) break; // takes longer
            Owned<cageform_wrap> fitted;
            auto options = spoil(coarse);
            const auto tame = [&] { // finite numbers of this size
                auto its = points_of(thin);
                for (std::size_t* const member : {&its.count, &its.stride, &its.bytes}) {
                    if (pick(8) == 0) *member = number() % its.bytes;
                }
                return its;
            };
            options.follow = tame();
            options.floor = random.uniform(-0.2, 1.2);
            if (pick(3) == 0) options.finest = std::uint32_t(number());
            std::array<cageform_drawing, 2> drawings{solid, solid};
            auto& drawing = drawings[pick(2)] = spoil(solid);
            drawing.points = tame();
            if (pick(3) == 0) drawing.index_count = pick(solid.index_count);
            status = cageform_fit_wrap(pick(3) ? nullptr : any(space.coordinates.object), &drawings[0],
                                       &drawings[1], &options, nullptr, &fitted.object, &report);
            break;
        }
        default: {
            Owned<cageform_bytes> bytes;
            if (pick(20) == 0)
                status = cageform_compile_clip(times, pick(3), reading(), nullptr, nullptr, &bytes.object,
                                               &report);
            else
                status = cageform_figure_find_clip(any(figure.object), nullptr, number() % 2, &out);
        }
        }
        met.insert(status);
        if (std::string(cageform_status_name(status)) == "unknown" || status == CAGEFORM_FAILED) FAIL(status);
    }
    CHECK(met.size() > 15);
    CHECK(met.contains(CAGEFORM_OBJECT_OF_ANOTHER_KIND));
    CHECK(met.contains(CAGEFORM_POINTS_LEAVE_MEMORY));
}

} // namespace c_interface_tests
