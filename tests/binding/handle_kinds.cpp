// Vector handles in all functions of bindings.
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/packed.hpp"
#include "../support/vector_handles.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/bind_bones.hpp>
#include <cageform/binding/skin_weights.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/green.hpp>

namespace handle_kinds_tests {

using namespace cageform_tests;
using cageform::bind;
using cageform::bind_bones;
using cageform::Binding;
using cageform::BlendedCoordinates;
using cageform::epsilon;
using cageform::GreenCoordinates;
using cageform::open_blob;
using cageform::pack;
using cageform::pose_handles;
using cageform::Transform;

namespace {

template <class T>
cageform::Polygon<T> l_shape() {
    return cageform::Polygon<T>(Points2<T>{{0, 0}, {4, 0}, {4, 1}, {1.5, 1.5}, {1, 3}, {0, 3}});
}
/// Clockwise, similar to the other.
template <class T>
cageform::Polygon<T> diamond() {
    return cageform::Polygon<T>(Points2<T>{{3, 0.5}, {1, -2}, {-1, 0.5}, {1, 2}});
}

/// A coordinate type with faces, its vertices, and points to bind.
template <class Scalar, std::size_t Dimension>
struct Case {
    using T = Scalar;
    static constexpr std::size_t D = Dimension;

    static auto coordinates() {
        if constexpr (D == 2)
            return GreenCoordinates<T, 2>(l_shape<T>());
        else
            return GreenCoordinates<T, 3>(sphere(1).template mesh<T>());
    }
    static std::vector<Vec<T, D>> vertices(const cageform::HandleView<T, D>& handles) {
        std::vector<Vec<T, D>> result;
        for (std::size_t i = 0; i < handles.count; ++i) {
            if (handles.is_point(i)) result.push_back(handles.rest[i]);
        }
        return result;
    }
    static std::vector<Vec<T, D>> points(std::uint64_t seed, std::size_t count = 70) {
        Random random(seed << 20); // adjacent seeds share numbers
        std::vector<Vec<T, D>> result;
        while (result.size() < count) {
            if constexpr (D == 2)
                result.push_back(random_inside(l_shape<T>(), random, 0.01));
            else
                result.push_back(0.8F * random_points<T, D>(1, 0.6, random.bits())[0]);
        }
        return result;
    }
};
using Double2 = Case<double, 2>;
using Float3 = Case<float, 3>;

/// x ↦ μ R x + b without a reflection.
template <std::size_t D>
AffineMap<D> random_similarity(std::uint64_t seed) {
    Random random(seed);
    AffineMap<D> map;
    for (std::size_t k = 0; k < D; ++k) {
        map.rows[k][k] = 1;
        map.shift[k] = random.uniform(-3, 3);
    }
    for (std::size_t turn = 0; turn < 2 * D; ++turn) { // in coordinate planes, in turn
        const double angle = random.uniform(0, 6), c = std::cos(angle), s = std::sin(angle);
        auto &a = map.rows[turn % D], &b = map.rows[(turn + 1) % D];
        const auto turned = c * a - s * b;
        b = s * a + c * b;
        a = turned;
    }
    const double scale = random.uniform(0.3, 3);
    for (auto& row : map.rows.v) row = scale * row;
    return map;
}

template <class B, class Pose>
auto posed(const B& binding, const Pose& vertices) {
    std::vector<Vec<typename B::scalar, B::dimension>> handles(binding.handle_view().count);
    const auto report = pose_handles(binding, vertices, handles);
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.collapsed_faces == 0);
    return handles;
}

template <class T, std::size_t D>
auto cloned_view(const cageform::PackedBindingView<T, D>& view, const std::vector<Vec<T, D>>& handles) {
    std::vector<Vec<T, D>> out(view.point_count());
    REQUIRE(cageform::clone(view, handles, out) == Status::ok);
    return out;
}

/// Checks that a binding is exact at rest bit for bit and in similarity poses.
template <class T, std::size_t D>
void check_poses(const cageform::PackedBindingView<T, D>& view, const std::vector<Vec<T, D>>& vertices,
                 const std::vector<Vec<T, D>>& points) {
    CHECK(cloned_view(view, posed(view, vertices)) == points);
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const auto map = random_similarity<D>(seed);
        const auto pose = map(std::span<const Vec<T, D>>(vertices));
        const auto moved = cloned_view(view, posed(view, pose));
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(seed, i);
            CHECK(distance(moved[i], map(cageform::vec_cast<long double>(points[i]))) <=
                  64 * double(epsilon<T>) * (size_of(vertices) + size_of(pose)));
        }
    }
}

} // namespace

TEMPLATE_TEST_CASE("a coordinate type with normals is bound without changes of the library",
                   "[handle_kinds][bind]", Double2, Float3) {
    using T = typename TestType::T;
    const auto coordinates = TestType::coordinates();
    const auto points = TestType::points(1);
    const auto [binding, report] = bind(coordinates, points);
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.outside.empty());
    const double rounding = 64 * double(epsilon<T>) * size_of(coordinates.handles());
    CHECK(report.partition_error.value <= rounding);
    CHECK(report.reproduction_error.value <= rounding);
    CHECK(report.weight_change.value <= rounding);
    CHECK(report.residual_restored.value <= rounding);

    const auto view = binding.view();
    REQUIRE(view.handle_kinds != nullptr);
    REQUIRE(view.handle_faces != nullptr);
    CHECK(std::equal(view.handle_kinds, view.handle_kinds + view.handle_count(),
                     coordinates.handle_kinds().begin()));
    CHECK(
        std::equal(coordinates.handle_faces().begin(), coordinates.handle_faces().end(), view.handle_faces));
    check_poses<T, TestType::D>(view, TestType::vertices(binding.handle_view()), points);
}

TEST_CASE("linear precision is restored with vector handles", "[handle_kinds][bind]") {
    const GreenCoordinates<double, 2> green(l_shape<double>());
    const auto handles = cageform::handle_view(green);
    const cageform::detail::LinearRestorer<double, 2> restorer(handles);
    const auto points = Double2::points(2, 8);
    std::vector<cageform::Lanes<double>> row(handles.count), target(2), bound(1);
    std::vector<double> weights(handles.count);
    Random random(3);
    for (std::size_t lane = 0; lane < 8; ++lane) {
        REQUIRE(cageform::weights_at(green, points[lane], weights) == PointState::inside);
        for (std::size_t h = 0; h < handles.count; ++h)
            row[h][lane] = weights[h] + random.uniform(-0.01, 0.01);
        for (std::size_t k = 0; k < 2; ++k) target[k][lane] = points[lane][k];
        bound[0][lane] = 1;
    }
    cageform::detail::LinearRestorer<double, 2>::Scratch scratch;
    const auto result = restorer.run(target.data(), bound[0], row.data(), true, scratch);
    for (std::size_t lane = 0; lane < 8; ++lane) {
        CHECK(result.change[lane] < 0.05);
        double sum = 0;
        Vec<double, 2> place{};
        for (std::size_t h = 0; h < handles.count; ++h) {
            sum += handles.is_point(h) ? row[h][lane] : 0;
            place = place + row[h][lane] * handles.rest[h];
        }
        CHECK(std::fabs(sum - 1) < 1e-14);
        CHECK(distance(place, points[lane]) < 1e-14);
    }
}

TEMPLATE_TEST_CASE("packed bindings with normals are exact at rest and in similarity poses in every format",
                   "[handle_kinds][pack]", Double2, Float3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto points = TestType::points(4);
    const auto bound = bind(TestType::coordinates(), points).value;
    const auto vertices = TestType::vertices(bound.handle_view());
    for (const auto format :
         {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
        for (const std::size_t largest : {std::size_t(0), D + 1, std::size_t(8)}) {
            CAPTURE(int(format), largest);
            const auto [packed, report] = pack(bound, {.format = format, .largest = largest});
            REQUIRE(report.status == Status::ok);
            check_poses(packed.view(), vertices, points);
            const auto opened = open_blob<T, D>(packed.bytes());
            REQUIRE(opened.status() == Status::ok);
            check_poses(opened.value, vertices, points);
        }
    }
}

TEMPLATE_TEST_CASE("vectors bound with normals follow similarity poses, also packed",
                   "[handle_kinds][bind_vectors]", Double2, Float3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto points = TestType::points(11);
    const auto coordinates = TestType::coordinates();
    const auto [bindings, report] = cageform::bind_jacobians(coordinates, points);
    REQUIRE(report.status == Status::ok);
    const auto vertices = TestType::vertices(cageform::handle_view(coordinates));
    const double rounding = 64 * double(epsilon<T>) * size_of(vertices);
    for (std::size_t axis = 0; axis < D; ++axis) {
        const auto packed = pack(bindings[axis], {.format = WeightFormat::int16, .largest = 8}).value;
        Vec<T, D> still{};
        still[axis] = 1;
        CHECK(cloned(bindings[axis], posed(bindings[axis], vertices)) == std::vector(points.size(), still));
        for (std::uint64_t seed = 0; seed < 4; ++seed) {
            const auto map = random_similarity<D>(seed);
            const auto handles = posed(bindings[axis], map(std::span<const Vec<T, D>>(vertices)));
            Vec<double, D> turned{};
            for (std::size_t k = 0; k < D; ++k) turned[k] = map.rows[k][axis];
            const auto dense = cloned(bindings[axis], handles), few = cloned_view(packed.view(), handles);
            for (std::size_t i = 0; i < points.size(); ++i) {
                CAPTURE(axis, seed, i);
                CHECK(distance(dense[i], turned) <= 4 * rounding);
                CHECK(distance(few[i], turned) <= 4 * rounding);
            }
        }
    }
}

TEST_CASE("a skin rejects vector handles", "[handle_kinds][skin_weights][status]") {
    const auto bound = bind(GreenCoordinates<double, 2>(l_shape<double>()), Double2::points(7));
    const auto made = cageform::skin_weights(bound.value);
    CHECK(made.report.status == Status::handles_not_points);
    CHECK(made.value.joints.empty());
}

TEST_CASE("blended cages with normals: handles of a cage are consecutive", "[handle_kinds][blended]") {
    using Green = GreenCoordinates<double, 2>;
    const BlendedCoordinates<Green> coordinates({Green(l_shape<double>()), Green(diamond<double>())});
    const auto points = Double2::points(8);
    const auto [binding, report] = bind(coordinates, points);
    REQUIRE(report.status == Status::ok);
    CHECK(report.partition_error.value < 1e-14);
    const auto handles = binding.handle_view();
    CHECK(handles.vector_count() == 10);
    CHECK(handles.faces[6][0] >= 12); // corners are indices of all handles
    check_poses<double, 2>(binding.view(), Double2::vertices(handles), points);
    const auto packed = pack(binding, {.format = WeightFormat::int16, .largest = 8}).value;
    check_poses(packed.view(), Double2::vertices(handles), points);

    // In place.
    const auto vertices = Double2::vertices(handles);
    std::vector<Vec<double, 2>> place(vertices);
    place.resize(handles.count);
    const std::span<const Vec<double, 2>> pose(place.data(), vertices.size());
    CHECK(pose_handles(binding, pose, place).status == Status::ok);
    CHECK(place == std::vector(handles.rest, handles.rest + handles.count));
}

TEMPLATE_TEST_CASE("a clone by bones is linear blend skinning", "[handle_kinds][bones]", Double2, Float3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    using Bone = cageform::Transform<T, D>;
    const BoneCoordinates<T, D> coordinates(random_points<T, D>(5, 2, 1));
    const auto points = random_points<T, D>(50, 3, 2);
    const auto [binding, report] = bind(coordinates, points);
    REQUIRE(report.status == Status::ok);
    CHECK(report.partition_error.value <= 32 * double(epsilon<T>));
    std::vector<Bone> still(5), own(5), common(5);
    std::vector<AffineMap<D>> maps;
    Random random(3);
    for (std::size_t b = 0; b < 5; ++b) {
        maps.push_back(random_affine<D>(random, 2));
        for (std::size_t r = 0; r < D; ++r) {
            still[b].translation[r] = 0;
            own[b].translation[r] = T(maps[b].shift[r]);
            common[b].translation[r] = T(maps[0].shift[r]);
            for (std::size_t k = 0; k < D; ++k) {
                still[b].columns[k][r] = r == k ? 1 : 0;
                own[b].columns[k][r] = T(maps[b].rows[r][k]);
                common[b].columns[k][r] = T(maps[0].rows[r][k]);
            }
        }
    }
    std::vector<Vec<T, D>> handles(binding.handle_count());
    const auto pose = [&](const std::vector<Bone>& bones) {
        REQUIRE(cageform::pose_bones(binding, std::span<const Bone>(bones), handles) == Status::ok);
        return handles;
    };
    const double rounding = 512 * double(epsilon<T>);
    const auto packed = pack(binding, {.format = WeightFormat::int16}).value;
    CHECK(cloned(binding, pose(still)) == points);
    CHECK(cloned_view(packed.view(), pose(still)) == points);
    const auto skinned = cloned(binding, pose(own)), moved = cloned_view(packed.view(), pose(common));
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto shares = coordinates.shares(points[i]);
        Vec<double, D> expected{};
        for (std::size_t b = 0; b < 5; ++b)
            expected = expected + shares[b] * maps[b](cageform::vec_cast<double>(points[i]));
        CHECK(distance(skinned[i], expected) <= rounding);
        CHECK(distance(moved[i], maps[0](cageform::vec_cast<double>(points[i]))) <= rounding);
    }
    std::vector<Bone> four(4);
    CHECK(cageform::pose_bones(binding, std::span<const Bone>(four), handles) == Status::pose_size_differs);
    own[3].translation[0] = std::numeric_limits<T>::infinity();
    CHECK(cageform::pose_bones(binding, std::span<const Bone>(own), handles) == Status::pose_not_finite);
    handles.pop_back();
    CHECK(cageform::pose_bones(binding, std::span<const Bone>(still), handles) == Status::output_too_small);
    CHECK(pose_handles(binding, points, handles).status == Status::pose_size_differs);
    handles.push_back({});
    const std::vector<Vec<T, D>> origins(points.begin(), points.begin() + 5);
    CHECK(pose_handles(binding, origins, handles).status == Status::handles_not_faces);
    const auto faces = bind(TestType::coordinates(), TestType::points(9)).value;
    CHECK(cageform::pose_bones(faces, std::span<const Bone>(still), handles) == Status::handles_not_bones);
}

TEST_CASE("a point skinned by two bones equals exact arithmetic", "[handle_kinds][bones][oracle]") {
    const auto json = read_json("bone_handles");
    const auto number = [](const nlohmann::json& text) {
        const auto fraction = text.get<std::string>();
        const std::size_t slash = fraction.find('/');
        return std::stod(fraction) / (slash == std::string::npos ? 1 : std::stod(fraction.substr(slash + 1)));
    };
    const auto place = [&](const nlohmann::json& pair) {
        return Vec<double, 2>{number(pair[0]), number(pair[1])};
    };
    std::vector<Transform<double, 2>> bones(2), moves(2);
    std::vector<double> shares;
    for (std::size_t b = 0; b < 2; ++b) {
        const auto& rest = json["handles_rest"];
        bones[b] = {{place(rest[3 * b + 1]), place(rest[3 * b + 2])}, place(rest[3 * b])};
        const auto& move = json["transforms"][b];
        const auto x = place(move["matrix"][0]), y = place(move["matrix"][1]);
        moves[b] = {{Vec<double, 2>{x[0], y[0]}, Vec<double, 2>{x[1], y[1]}}, place(move["translation"])};
        shares.push_back(number(json["bone_weights"][b]));
    }
    const std::vector<Vec<double, 2>> points{place(json["point"])};
    const auto [binding, report] =
        bind_bones(points, std::span<const Transform<double, 2>>(bones), std::span<const double>(shares));
    REQUIRE(report.status == Status::ok);
    REQUIRE(binding.handle_count() == 6);
    CHECK(report.unused.empty());
    std::vector<Vec<double, 2>> handles(6);
    REQUIRE(pose_bones(binding, std::span<const Transform<double, 2>>(moves), handles) == Status::ok);
    for (std::size_t h = 0; h < 6; ++h) {
        CAPTURE(h);
        CHECK(std::fabs(binding.weight(0, h) - number(json["weights"][h])) <= 1e-15);
        CHECK(binding.rest_handle(h) == place(json["handles_rest"][h]));
        CHECK(distance(handles[h], place(json["handles_posed"][h])) <= 1e-15);
    }
    CHECK(distance(cloned(binding, handles)[0], place(json["clone"])) <= 1e-15);
}

/// Frames with random axes, and non-negative weights of points, some zero, all zero for the last bone.
template <class T, std::size_t D>
struct RandomSkin {
    std::vector<Transform<T, D>> bones;
    std::vector<Vec<T, D>> points;
    std::vector<double> shares;

    explicit RandomSkin(std::uint64_t seed)
        : bones(4)
        , points(random_points<T, D>(40, 3, seed))
        , shares(points.size() * bones.size(), 0.0) {
        Random random(seed + 1);
        for (auto& bone : bones) {
            for (std::size_t r = 0; r < D; ++r) {
                bone.translation[r] = T(random.uniform(-3, 3));
                for (std::size_t k = 0; k < D; ++k)
                    bone.columns[k][r] = T(random.uniform(-0.3, 0.3) + (r == k ? 2 : 0));
            }
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto row = random_shares(2, random);
            const std::size_t first = random.below(2);
            shares[4 * i + first] = row[0];
            shares[4 * i + first + 1] = row[1];
        }
    }
    auto bind(const std::vector<double>& weights, const cageform::BindOptions& options = {},
              const cageform::Running& running = {}) const {
        return bind_bones(points, std::span<const Transform<T, D>>(bones), std::span<const double>(weights),
                          options, running);
    }
};

TEMPLATE_TEST_CASE("bones bound by given weights are linear blend skinning", "[handle_kinds][bones]", Double2,
                   Float3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto seed = GENERATE(seeds(8));
    CAPTURE(seed);
    const RandomSkin<T, D> skin(std::uint64_t(seed) + 10);
    const auto& points = skin.points;
    Random random{std::uint64_t(seed)};
    std::vector<AffineMap<D>> maps;
    std::vector<Transform<T, D>> own(4), common(4);
    for (std::size_t b = 0; b < 4; ++b) {
        maps.push_back(random_affine<D>(random, 2));
        for (std::size_t r = 0; r < D; ++r) {
            own[b].translation[r] = T(maps[b].shift[r]);
            common[b].translation[r] = T(maps[0].shift[r]);
            for (std::size_t k = 0; k < D; ++k) {
                own[b].columns[k][r] = T(maps[b].rows[r][k]);
                common[b].columns[k][r] = T(maps[0].rows[r][k]);
            }
        }
    }
    auto uneven = skin.shares; // differ only by their sums, which are restored
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double factor = random.uniform(0.5, 1.5);
        for (std::size_t b = 0; b < 4; ++b) uneven[4 * i + b] *= factor;
    }
    const double rounding = 512 * double(epsilon<T>);
    for (const auto& shares : {skin.shares, uneven}) {
        const auto [binding, report] = skin.bind(shares);
        REQUIRE(report.status == Status::ok);
        CHECK(report.unused == std::vector<std::uint32_t>{3});
        CHECK(report.partition_error.value <= 8 * double(epsilon<T>));
        CHECK((report.weight_change.value > 0.1) == (shares != skin.shares));
        std::vector<Vec<T, D>> handles(binding.handle_count());
        const auto pose = [&](const std::vector<Transform<T, D>>& moves) {
            REQUIRE(pose_bones(binding, std::span<const Transform<T, D>>(moves), handles) == Status::ok);
            return handles;
        };
        const auto packed = pack(binding, {.format = WeightFormat::int16}).value;
        const auto skinned = cloned(binding, pose(own)), moved = cloned_view(packed.view(), pose(common));
        std::vector<Vec<T, D>> frames; // the posed frames are also a pose of the handles
        for (std::size_t b = 0; b < 4; ++b) {
            frames.push_back(maps[b](skin.bones[b].translation));
            for (const auto& axis : skin.bones[b].columns) frames.push_back(own[b].map_vector(axis));
        }
        const auto by_frames = cloned(binding, frames);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto p = cageform::vec_cast<double>(points[i]);
            Vec<double, D> expected{};
            for (std::size_t b = 0; b < 4; ++b) expected = expected + skin.shares[4 * i + b] * maps[b](p);
            CAPTURE(i);
            CHECK(distance(skinned[i], expected) <= rounding);
            CHECK(distance(by_frames[i], expected) <= rounding);
            CHECK(distance(moved[i], maps[0](p)) <= rounding);
            for (std::size_t h = 0; h < binding.handle_count(); ++h) { // zeros stay zeros
                if (skin.shares[4 * i + h / (D + 1)] == 0) CHECK(binding.weight(i, h) == T(0));
            }
        }
    }
}

TEMPLATE_TEST_CASE("invalid bones are rejected with their index", "[handle_kinds][bones][status]", Double2,
                   Float3) {
    using T = typename TestType::T;
    using Kind = cageform::CageFaultKind;
    constexpr std::size_t D = TestType::D;
    const RandomSkin<T, D> sound(1);
    auto shares = sound.shares;
    shares[4 * 5 + 3] = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t b = 0; b < 4; ++b) shares[4 * 7 + b] = 0;
    auto holed = sound;
    holed.points[9][1] = std::numeric_limits<T>::infinity();
    const auto bound = holed.bind(shares);
    CHECK(bound.report.status == Status::ok);
    CHECK(bound.report.unreached == std::vector<std::size_t>{5, 7});
    CHECK(bound.report.not_finite == std::vector<std::size_t>{9});
    CHECK(bound.value.point_count() == sound.points.size());

    const auto left = sound.bind(std::vector<double>(sound.shares.size(), 0.5),
                                 {.linear_precision = cageform::LinearPrecision::leave});
    CHECK(std::fabs(left.report.partition_error.value - 1) <= 8 * double(epsilon<T>));

    shares.pop_back();
    CHECK(sound.bind(shares).report.status == Status::bone_weights_do_not_match);
    auto none = sound;
    none.bones.clear();
    CHECK(none.bind({}).report.status == Status::bone_weights_do_not_match);

    const auto refused = [&](const RandomSkin<T, D>& skin, Kind kind, std::size_t number) {
        const auto [binding, report] = skin.bind(sound.shares);
        CHECK(report.status == status_of(kind));
        REQUIRE(report.cage.faults.size() == 1);
        CHECK(report.cage.faults[0].kind == kind);
        CHECK(report.cage.faults[0].a == number);
        CHECK(binding.point_count() == 0);
        CHECK(report.unused.empty());
    };
    auto flat = sound;
    flat.bones[2].columns[D - 1] = T(0.3) * flat.bones[2].columns[0];
    refused(flat, Kind::bone_axes_dependent, 2);
    flat.bones[2].columns[D - 1] = {};
    refused(flat, Kind::bone_axes_dependent, 2);
    auto lost = sound;
    lost.bones[1].columns[0][1] = std::numeric_limits<T>::quiet_NaN();
    refused(lost, Kind::vertex_not_finite, D + 2);

    cageform::Running running;
    running.progress = [](double) { return false; };
    CHECK(sound.bind(sound.shares, {}, running).report.status == Status::cancelled);
}

TEMPLATE_TEST_CASE("an invalid pose does not change the output, and collapsed faces are counted",
                   "[handle_kinds][status]", Double2, Float3) {
    using T = typename TestType::T;
    constexpr std::size_t D = TestType::D;
    const auto binding = bind(TestType::coordinates(), TestType::points(9)).value;
    const auto vertices = TestType::vertices(binding.handle_view());
    const std::vector<Vec<T, D>> before(binding.handle_count(), Vec<T, D>{7});
    auto handles = before;
    const auto status = [&](const std::vector<Vec<T, D>>& pose) {
        return pose_handles(binding, pose, handles).status;
    };
    CHECK(status(before) == Status::pose_size_differs);
    for (const T bad : {std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity(),
                        -std::numeric_limits<T>::max()}) {
        auto pose = vertices;
        pose.back()[D - 1] = bad;
        CHECK(status(pose) == Status::pose_not_finite);
    }
    handles.pop_back();
    CHECK(status(vertices) == Status::output_too_small);
    CHECK(handles == std::vector<Vec<T, D>>(before.begin(), before.end() - 1));

    handles = before;
    auto large = vertices; // near the largest number
    for (auto& p : large) p = (std::numeric_limits<T>::max() * epsilon<T> / 8) * p;
    CHECK(status(large) == Status::ok);
    for (const auto& handle : handles) CHECK(cageform::is_finite(handle));

    std::fill(large.begin(), large.end(), vertices[0]);
    const auto report = pose_handles(binding, large, handles);
    CHECK(report.status == Status::ok);
    CHECK(report.collapsed_faces == binding.handle_view().vector_count());
    CHECK(report.first_collapsed == vertices.size());
    CHECK(handles.back() == Vec<T, D>{});
}

TEMPLATE_TEST_CASE("the vector of a posed face follows the formula", "[handle_kinds][face_handle]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    using Long = Vec<long double, 3>;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        CAPTURE(seed);
        const auto p = random_points<T, 3>(6, 1, seed);
        const double reach = std::pow(10.0, double(seed % 13) - 6);
        std::array<Vec<T, 3>, 3> rest{p[0], p[1], p[2]}, pose;
        for (std::size_t k = 0; k < 3; ++k) pose[k] = T(reach) * p[3 + k];
        const Long u = cageform::vec_cast<long double>(rest[1]) - cageform::vec_cast<long double>(rest[0]),
                   v = cageform::vec_cast<long double>(rest[2]) - cageform::vec_cast<long double>(rest[0]),
                   U = cageform::vec_cast<long double>(pose[1]) - cageform::vec_cast<long double>(pose[0]),
                   V = cageform::vec_cast<long double>(pose[2]) - cageform::vec_cast<long double>(pose[0]);
        const auto n = cross(U, V), m = cross(u, v);
        const long double area = std::sqrt(dot(m, m)) / 2;
        const long double s =
            std::sqrt(dot(U, U) * dot(v, v) - 2 * dot(U, V) * dot(u, v) + dot(V, V) * dot(u, u)) /
            (std::sqrt(8.0L) * area);
        const Long expected = (std::sqrt(area) * s / std::sqrt(dot(n, n))) * n;
        const double size = double(std::sqrt(dot(expected, expected)));
        const double sine =
            double(std::sqrt(dot(n, n) / (dot(U, U) * dot(V, V)))); // thin faces are ill-conditioned
        CHECK(distance(cageform::detail::face_handle(rest, pose), expected) <=
              16 * double(epsilon<T>) * size / sine);
        const T power = T(0x1p40);
        for (auto& corner : pose) corner = power * corner;
        CHECK(cageform::detail::face_handle(rest, pose) ==
              power * cageform::detail::face_handle(
                          rest, {T(1) / power * pose[0], T(1) / power * pose[1], T(1) / power * pose[2]}));
    }
}

TEMPLATE_TEST_CASE("the vector of a face is finite for any thin face", "[handle_kinds][face_handle]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    using Face = std::array<Vec<T, 3>, 3>;
    std::size_t count = 0;
    for (std::uint64_t seed = 0; seed < 4000; ++seed) {
        CAPTURE(seed);
        const auto p = random_points<T, 3>(6, 1, seed);
        const T width = T(std::pow(10.0, -double(seed % 8)));
        Face rest, turned, near, squeezed;
        for (std::size_t k = 0; k < 3; ++k) {
            rest[k] = {p[k][0], width * p[k][1], width * p[k][2]};
            turned[k] = {-2 * rest[k][1], 2 * rest[k][0], 2 * rest[k][2]};
            near[k] = rest[k] + T(1e-3) * Vec<T, 3>{rest[k][0] * p[3 + k][0], rest[k][1] * p[3 + k][1],
                                                    rest[k][2] * p[3 + k][2]};
            squeezed[k] = (k == 0 ? T(0) : k == 1 ? std::numeric_limits<T>::min() : T(1)) * p[k];
        }
        const auto handle = cageform::detail::face_handle(rest, rest);
        if (handle == Vec<T, 3>{}) continue;
        ++count;
        const auto u = rest[1] - rest[0], v = rest[2] - rest[0], n = cross(u, v);
        const double length = std::sqrt(double(dot(handle, handle)));
        const double sine = std::sqrt(double(dot(n, n)) / (double(dot(u, u)) * double(dot(v, v))));
        const Vec<T, 3> expected{-2 * handle[1], 2 * handle[0], 2 * handle[2]};
        CHECK(distance(cageform::detail::face_handle(rest, turned), expected) <=
              32 * epsilon<T> * length / sine);
        CHECK(cageform::is_finite(cageform::detail::face_handle(rest, near)));
        CHECK(cageform::is_finite(cageform::detail::face_handle(rest, squeezed)));
    }
    CHECK(count > 3000);
}

} // namespace handle_kinds_tests
