// Animations of glTF documents: random keys are interpolated as the specification says (3.11 and appendix C);
// broken animations are reported.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include "files/gltf_animation.hpp"
#include "files/gltf_figure.hpp"

namespace gltf_animation_tests {

using namespace cageform_support;
using cageform_tests::Random;
using Use = GltfDocument::Use;
using Value = std::vector<double>;

namespace {

constexpr std::size_t targets = 2;
const std::string ways[] = {"LINEAR", "STEP", "CUBICSPLINE"};

/// A triangle with morph targets at a node.
GltfDocument random_triangle(Random& random) {
    GltfDocument document("test");
    std::vector<GltfIndex> accessors;
    for (std::size_t t = 0; t <= targets; ++t) {
        std::vector<std::array<float, 3>> places(3);
        for (auto& place : places) {
            for (float& x : place) x = float(random.uniform(-1, 1));
        }
        accessors.push_back(document.add(places, Use::vertices, true));
    }
    GltfJson primitive = {{"attributes", {{"POSITION", accessors[0]}}}};
    for (std::size_t t = 1; t <= targets; ++t) primitive["targets"].push_back({{"POSITION", accessors[t]}});
    document.append("meshes", {{"primitives", GltfJson::array({primitive})}});
    document.append("nodes", {{"mesh", 0}});
    return document;
}

/// Random keys of a property.
struct Keys {
    const char* path;
    std::string way;
    std::vector<double> times;
    std::vector<Value> values; // of all keys; CUBICSPLINE: in-tangent, value, out-tangent

    Keys(Random& random, const char* of, const std::string& interpolation)
        : path(of)
        , way(interpolation) {
        const std::size_t count = 1 + random.below(5), width = is_turn()                      ? 4
                                                               : std::string(of) == "weights" ? 2
                                                                                              : 3;
        double time = random.below(2) == 0 ? 0 : random.uniform(0, 1);
        for (std::size_t k = 0; k < count; ++k) {
            times.push_back(double(float(time)));
            time += random.uniform(0.05, 1);
        }
        for (std::size_t n = 0; n < count * parts(); ++n) {
            Value value(width);
            double square = 0;
            for (double& x : value) {
                x = double(float(random.uniform(-1, 1)));
                square += x * x;
            }
            for (double& x : value) x = is_turn() && !is_cubic() ? double(float(x / std::sqrt(square))) : x;
            values.push_back(value);
        }
    }

    bool is_turn() const { return std::string(path) == "rotation"; }
    bool is_cubic() const { return way == "CUBICSPLINE"; }
    std::size_t parts() const { return is_cubic() ? 3 : 1; }
    const Value& key(std::size_t k) const { return values[parts() * k + (is_cubic() ? 1 : 0)]; }

    GltfJson add_to(GltfDocument& document) const {
        Value flat;
        for (const Value& value : values) flat.insert(flat.end(), value.begin(), value.end());
        GltfIndex output = 0;
        const auto add = [&]<std::size_t N>() {
            std::vector<std::array<float, N>> rows(flat.size() / N);
            for (std::size_t n = 0; n < flat.size(); ++n) rows[n / N][n % N] = float(flat[n]);
            output = document.add(rows, Use::other);
        };
        if (is_turn())
            add.operator()<4>();
        else if (std::string(path) == "weights")
            add.operator()<1>();
        else
            add.operator()<3>();
        return {{"input", add_scalars(document, times, true)}, {"output", output}, {"interpolation", way}};
    }
};

/// The value of a property in a pose.
Value value_in(const GltfPose& pose, const std::string& path) {
    const GltfTransform& node = pose.nodes[0];
    if (path == "weights") return pose.weights[0];
    if (path == "rotation") return {node.rotation.begin(), node.rotation.end()};
    const Point3& p = path == "scale" ? node.scale : node.translation;
    return {p[0], p[1], p[2]};
}

double product(const Value& a, const Value& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
}

Value blend(const Value& a, const Value& b, double t) {
    Value result;
    for (std::size_t k = 0; k < a.size(); ++k) result.push_back((1 - t) * a[k] + t * b[k]);
    return result;
}

void check_near(const Value& is, Value wanted, bool is_turn) {
    if (is_turn) {
        const double length = std::sqrt(product(wanted, wanted));
        for (double& x : wanted) x /= length;
    }
    REQUIRE(is.size() == wanted.size());
    for (std::size_t k = 0; k < is.size(); ++k) CHECK(is[k] == Approx(wanted[k]).margin(1e-9));
}

/// The value between two keys, by de Casteljau's algorithm. The inner control points are a third of a tangent away
/// from the keys.
Value cubic(const Keys& keys, std::size_t k, double t) {
    const double third = (keys.times[k + 1] - keys.times[k]) / 3;
    std::vector<Value> points{keys.key(k), keys.key(k), keys.key(k + 1), keys.key(k + 1)};
    for (std::size_t c = 0; c < points[0].size(); ++c) {
        points[1][c] += third * keys.values[3 * k + 2][c];
        points[2][c] -= third * keys.values[3 * (k + 1)][c];
    }
    for (std::size_t left = 3; left > 0; --left) {
        for (std::size_t n = 0; n < left; ++n) points[n] = blend(points[n], points[n + 1], t);
    }
    return points[0];
}

void check_turn(const Value& is, const Value& a, const Value& b, double t) {
    const auto angle = [](const Value& p, const Value& q) {
        return std::acos(std::min(std::fabs(product(p, q)), 1.0));
    };
    CHECK(product(is, is) == Approx(1));
    CHECK(angle(a, is) == Approx(t * angle(a, b)).margin(1e-3));
    CHECK(angle(is, b) == Approx((1 - t) * angle(a, b)).margin(1e-3));
}

void check_keys(const Keys& keys, const GltfAnimation& animation, Random& random) {
    const auto at = [&](double time) { return value_in(animation.pose_at(time), keys.path); };
    check_near(at(keys.times.front() - random.uniform(0, 1)), keys.key(0), keys.is_turn());
    check_near(at(keys.times.back() + random.uniform(0, 1)), keys.key(keys.times.size() - 1), keys.is_turn());
    for (std::size_t k = 0; k < keys.times.size(); ++k)
        check_near(at(keys.times[k]), keys.key(k), keys.is_turn());
    for (std::size_t k = 0; k + 1 < keys.times.size(); ++k) {
        const double t = random.uniform(0.01, 0.99);
        const Value is = at((1 - t) * keys.times[k] + t * keys.times[k + 1]);
        if (keys.way == "STEP")
            check_near(is, keys.key(k), keys.is_turn());
        else if (keys.is_cubic())
            check_near(is, cubic(keys, k, t), keys.is_turn());
        else if (keys.is_turn())
            check_turn(is, keys.key(k), keys.key(k + 1), t);
        else
            check_near(is, blend(keys.key(k), keys.key(k + 1), t), false);
    }
}

} // namespace

TEST_CASE("an animation has its keys, and the interpolation between them", "[examples][gltf]") {
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(static_cast<unsigned>(seed));
    GltfDocument document = random_triangle(random);
    std::vector<Keys> all;
    GltfJson json = {{"name", "motion"}};
    for (const char* path : {"translation", "rotation", "scale", "weights"}) {
        all.emplace_back(random, path, ways[random.below(3)]);
        json["samplers"].push_back(all.back().add_to(document));
        json["channels"].push_back({{"sampler", all.size() - 1}, {"target", {{"node", 0}, {"path", path}}}});
    }
    json["channels"].push_back({{"sampler", 0}, {"target", {{"path", "pointer"}}}}); // of an extension
    document.append("animations", std::move(json));
    const auto file = read_scene(std::move(document), "in.glb");
    REQUIRE(file);
    const auto& scene = static_cast<const GltfScene&>(*file->document);
    REQUIRE(*find_animation(scene, "motion", "in.glb") == 0);
    REQUIRE(*find_animation(scene, "0", "in.glb") == 0);
    REQUIRE(*find_animation(scene, "", "in.glb") == 0);
    REQUIRE(find_animation(scene, "1", "in.glb").error().message ==
            "in.glb: has no animation \"1\"; it has \"motion\"");
    const auto animation = GltfAnimation::read(scene, 0, "in.glb");
    REQUIRE(animation);
    double length = 0;
    for (const Keys& keys : all) {
        check_keys(keys, *animation, random);
        length = std::max(length, keys.times.back());
    }
    CHECK(animation->length() == length);
}

TEST_CASE("faces of a mesh that two nodes share are reversed once", "[examples][gltf]") {
    Random random(1);
    GltfDocument document = random_triangle(random);
    document.append("nodes", {{"mesh", 0}, {"translation", {1, 2, 3}}});
    auto file = read_scene(std::move(document), "in.glb");
    REQUIRE(file);
    const auto triangles = file->triangles;
    const MeshFile turned = with_faces_reversed(std::move(*file));
    const auto written = turned.document->moved(turned, {turned.vertices}, "out.glb");
    REQUIRE(written);
    const auto again = parse_gltf(written->files[0].bytes, "out.glb");
    REQUIRE(again);
    REQUIRE(again->triangles.size() == 2);
    CHECK(again->triangles == turned.triangles);
    for (std::size_t t = 0; t < 2; ++t)
        CHECK(again->triangles[t] == std::array{triangles[t][0], triangles[t][2], triangles[t][1]});
}

TEST_CASE("messages on broken animations name the channel and the sampler", "[examples][gltf]") {
    Random random(1);
    const auto message = [&](const auto& change, const GltfJson& node = {{"mesh", 0}}) {
        GltfDocument document = random_triangle(random);
        document.json["nodes"][0] = node;
        const std::vector<std::array<float, 3>> places{{0, 0, 0}, {1, 0, 0}};
        GltfJson json = {
            {"samplers",
             {{{"input", add_scalars(document, std::vector{0.0, 1.0}, true)},
               {"output", document.add(places, Use::other)}}}},
            {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}};
        change(document, json);
        document.append("animations", std::move(json));
        const auto file = read_scene(std::move(document), "in.glb");
        return file ? std::string() : file.error().message;
    };
    const std::string channel = "in.glb: animation 0, channel 0", sampler = channel + ", sampler 0";
    CHECK(message([](auto&, auto&) {}).empty());
    CHECK(message([](auto&, GltfJson& json) { json.erase("samplers"); }) ==
          "in.glb: animation 0: has no list of channels and samplers");
    CHECK(message([](auto&, GltfJson& json) { json["channels"] = GltfJson::array(); }).empty());
    CHECK(message([](auto&, GltfJson& json) { json["channels"][0]["target"] = 1; }) ==
          channel + ": has no target");
    CHECK(message([](auto&, GltfJson& json) { json["channels"][0]["target"]["node"] = 7; }) ==
          channel + ": there is no node 7; the document has 1");
    CHECK(message([](auto&, GltfJson& json) { json["channels"][0]["target"]["path"] = "colour"; }) ==
          channel + ": the path \"colour\" is none of translation, rotation, scale and weights");
    CHECK(message([](auto&, GltfJson& json) { json["channels"][0]["sampler"] = 3; }) ==
          channel + ": there is no such sampler; the animation has 1");
    CHECK(message([](auto&, GltfJson& json) { json["samplers"][0]["interpolation"] = "EASE"; }) ==
          sampler + ": the interpolation \"EASE\" is none of LINEAR, STEP and CUBICSPLINE");
    CHECK(message([](auto&, GltfJson& json) { json["samplers"][0]["interpolation"] = "CUBICSPLINE"; }) ==
          sampler + ": has 2 times and 6 numbers, but 18 are needed");
    CHECK(message([](GltfDocument& document, GltfJson& json) {
              json["samplers"][0]["input"] = add_scalars(document, std::vector{1.0, 0.5}, true);
          }) == sampler + ": its times do not ascend from 0 or later");
    CHECK(message([](GltfDocument& document, GltfJson& json) {
              json["samplers"][0]["input"] = add_scalars(document, std::vector<double>{0.0, NAN}, true);
          }) == sampler + ": its times do not ascend from 0 or later");
    CHECK(message([](auto&, GltfJson& json) {
              json["samplers"][0]["output"] = 99;
          }).starts_with(sampler + ", output: there is no accessor 99"));
    CHECK(message([](auto&, auto&) {},
                  {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}) ==
          channel + ": node 0 has a matrix, which animations cannot change");
}

} // namespace gltf_animation_tests
