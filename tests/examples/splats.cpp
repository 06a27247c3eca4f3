#include "files/ply_file.hpp"
#include "pictures/splat_picture.hpp"
#include "splats/harmonics.hpp"
#include "splats/posed_splats.hpp"
#include "splats/splat.hpp"
#include "splats/splat_file.hpp"
#include "splats/surface_splats.hpp"

#include "catch.hpp"
#include "support/temporary_file.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace splats_tests {

using namespace cageform_support;

namespace {

class Random {
public:
    explicit Random(int seed)
        : generator_(unsigned(seed)) {}

    double between(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(generator_);
    }
    double normal() { return std::normal_distribution<double>()(generator_); }
    Point3 point() { return {normal(), normal(), normal()}; }
    Point3 direction() {
        const Point3 p = point();
        return (1 / length_of(p)) * p;
    }
    Matrix3 matrix() { return {point(), point(), point()}; }
    /// A uniformly distributed rotation, from a quaternion.
    Matrix3 rotation() { return factor_of({{normal(), normal(), normal(), normal()}, {}}); }
    /// A splat whose axes differ by a factor of up to 1000.
    SplatShape shape() {
        return {{normal(), normal(), normal(), normal()}, {between(-7, 0), between(-7, 0), between(-7, 0)}};
    }

private:
    std::mt19937 generator_;
};

Matrix3 scaled(const Matrix3& a, const Point3& sizes) {
    return {sizes[0] * a[0], sizes[1] * a[1], sizes[2] * a[2]};
}
Matrix3 square(const Matrix3& factor) {
    return product(factor, transposed(factor));
}

double largest(const Matrix3& a) {
    double most = 0;
    for (const Point3& column : a) {
        for (const double x : column.v) most = std::max(most, std::fabs(x));
    }
    return most;
}
double distance(const Matrix3& a, const Matrix3& b) {
    return largest({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

Splat random_splat(Random& random, std::size_t degree) {
    Splat splat{random.point(), random.shape(), random.normal(), {}, {}};
    for (std::size_t channel = 0; channel < 3; ++channel) {
        splat.colour[channel] = random.normal();
        for (std::size_t k = 0; k < harmonics_of(degree); ++k)
            splat.harmonics[channel].push_back(random.normal());
    }
    return splat;
}
SplatFile random_scene(Random& random, std::size_t degree, std::size_t count) {
    SplatFile scene = empty_scene(degree);
    for (std::size_t i = 0; i < count; ++i) append(scene, random_splat(random, degree));
    return scene;
}
std::string bytes_of(const SplatFile& scene) {
    return scene.header_text(scene.size()) + scene.rows;
}

/// The part of a colour that depends on the direction of view.
double seen(const SplatFile& scene, std::size_t splat, std::size_t channel, const Point3& direction) {
    std::array<double, most_harmonics> values{};
    harmonics_at(direction, values);
    const std::size_t count = scene.layout.rest.size() / 3;
    double sum = 0;
    for (std::size_t k = 0; k < count; ++k)
        sum += values[k] * scene.number(splat, scene.layout.rest[channel * count + k]);
    return sum;
}

void pose(SplatFile& scene, std::size_t splat, const Matrix3& map, const Point3& shift = {}) {
    const SplatPart part = part_of(scene, splat);
    write_posed(scene, part, product(map, part.place) + shift, map, posed_shape(part, map));
}

std::string fault_of(const std::string& bytes) {
    const auto scene = parse_splats(bytes, "scene.ply");
    return scene ? std::string() : to_string(scene.error());
}

/// A text with the first `from` replaced.
std::string with(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != text.npos);
    return text.replace(at, from.size(), to);
}

} // namespace

TEST_CASE("every matrix is the product of its singular values and of orthogonal matrices", "[splats]") {
    const int seed = GENERATE(range(0, 200));
    CAPTURE(seed);
    Random random(seed);
    Matrix3 a = random.matrix();
    if (seed % 4 == 1) a[1] = 2.0 * a[0];              // of rank two
    if (seed % 4 == 2) a = scaled(a, {1, 1e-6, 1e-9}); // singular values of different sizes
    if (seed % 4 == 3) a = {random.normal() * a[0], random.normal() * a[0], {}}; // of rank one
    const SingularValues values = singular_values(a);
    const double rounding = 1e-14;
    CHECK(distance(product(scaled(values.left, values.sizes), transposed(values.right)), a) <=
          rounding * largest(a));
    for (const Matrix3& m : {values.left, values.right})
        CHECK(distance(product(transposed(m), m), identity3) <= rounding);
    for (const double size : values.sizes.v) CHECK(size >= 0);
    CHECK(determinant(values.right) > 0);
    if (seed % 4 == 1 || seed % 4 == 3) CHECK(determinant(values.left) > 0);
}

TEST_CASE("the polar decomposition returns the rotation, also of reflections", "[splats]") {
    const int seed = GENERATE(range(0, 200));
    CAPTURE(seed);
    Random random(seed);
    Matrix3 rotation = random.rotation();
    if (seed % 2 == 1) rotation[2] = -1.0 * rotation[2];
    const Matrix3 axes = random.rotation();
    const Point3 sizes{std::exp(random.normal()), std::exp(random.normal()), std::exp(random.normal())};
    const Matrix3 stretch = product(scaled(axes, sizes), transposed(axes));
    const Matrix3 found = nearest_orthogonal(product(rotation, stretch));
    CHECK(distance(found, rotation) <= 1e-12);
    CHECK(determinant(found) * (seed % 2 == 1 ? -1 : 1) > 0);
}

TEST_CASE("affine poses of splats are exact: covariance, place, opacity", "[splats]") {
    const int seed = GENERATE(range(0, 100));
    CAPTURE(seed);
    Random random(seed);
    SplatFile scene = random_scene(random, std::size_t(seed % 4), 3);
    const SplatFile rest = scene;
    const Matrix3 map = random.matrix(); // mirrors half of the scenes
    const Point3 shift = random.point();
    for (std::size_t i = 0; i < scene.size(); ++i) {
        pose(scene, i, map, shift);
        const Matrix3 covariance = square(factor_of(scene.shape(i))),
                      wanted = square(product(map, factor_of(rest.shape(i))));
        CHECK(distance(covariance, wanted) <= 1e-6 * largest(wanted));
        const Point3 place = product(map, rest.place(i)) + shift, off = scene.place(i) - place;
        CHECK(length_of(off) <= 1e-6 * (1 + largest(map) + length_of(place)));
        CHECK(scene.number(i, scene.layout.opacity) == rest.number(i, rest.layout.opacity));
        for (const std::size_t colour : scene.layout.colour)
            CHECK(scene.number(i, colour) == rest.number(i, colour));
    }
}

TEST_CASE("affine poses of a cage are exact for the splats inside it", "[splats]") {
    const int seed = GENERATE(range(0, 5));
    CAPTURE(seed);
    Random random(seed);
    const auto cage = cageform::box_mesh<double>({-9, -9, -9}, {9, 9, 9}, {2, 2, 2});
    const cageform::MeanValueCoordinates<double, 3, cageform::PolyhedralMesh<double>> coordinates{cage};
    SplatFile scene = random_scene(random, 3, 40);
    const SplatFile rest = scene;
    std::vector<Point3> places(scene.size()), handles(cage.vertices().begin(), cage.vertices().end());
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = scene.place(i);
    const Matrix3 map = random.matrix(), turn = nearest_orthogonal(map);
    for (Point3& handle : handles) handle = product(map, handle);
    std::vector<Matrix3> jacobians(places.size());
    const auto bound = cageform::bind(coordinates, places);
    const auto axes = cageform::bind_jacobians(coordinates, places);
    REQUIRE(cageform::clone(bound.value, handles, places) == cageform::Status::ok);
    REQUIRE(cageform::clone_jacobians(axes.value, handles,
                                      cageform::StridedMatrices<double, 3>(
                                          jacobians[0][0].v, jacobians.size())) == cageform::Status::ok);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const SplatPart part = part_of(scene, i);
        write_posed(scene, part, places[i], jacobians[i], posed_shape(part, jacobians[i]));
        const Matrix3 wanted = square(product(map, factor_of(rest.shape(i))));
        CHECK(distance(square(factor_of(scene.shape(i))), wanted) <= 1e-6 * largest(wanted));
        const Point3 d = random.direction();
        CHECK(std::fabs(seen(scene, i, 1, d) - seen(rest, i, 1, product(transposed(turn), d))) <= 1e-5);
    }
}

TEST_CASE("rotated harmonics are the function at rotated directions, also for reflections", "[splats]") {
    const int seed = GENERATE(range(0, 100));
    CAPTURE(seed);
    Random random(seed);
    for (std::size_t degree = 1; degree <= 3; ++degree) {
        CAPTURE(degree);
        Matrix3 turn = random.rotation();
        if (seed % 2 == 1) turn[0] = -1.0 * turn[0];
        std::vector<double> rest(harmonics_of(degree));
        for (double& x : rest) x = random.normal();
        std::vector<double> turned = rest;
        TurnedHarmonics(turn).turn(turned);
        double before = 0, after = 0;
        for (const double x : rest) before += x * x;
        for (const double x : turned) after += x * x;
        CHECK(std::fabs(after - before) <= 1e-13 * before); // the functions are orthonormal
        for (int n = 0; n < 10; ++n) {
            const Point3 d = random.direction();
            std::array<double, most_harmonics> here{}, back{};
            harmonics_at(d, here);
            harmonics_at(product(transposed(turn), d), back);
            double sum = 0, wanted = 0;
            for (std::size_t k = 0; k < rest.size(); ++k) {
                sum += turned[k] * here[k];
                wanted += rest[k] * back[k];
            }
            CHECK(std::fabs(sum - wanted) <= 1e-13 * before);
        }
    }
}

TEST_CASE("the rotated harmonics of a file are exact to its digits", "[splats]") {
    const int seed = GENERATE(range(0, 60));
    CAPTURE(seed);
    Random random(seed);
    const auto degree = std::size_t(1 + seed % 3);
    SplatFile scene = random_scene(random, degree, 1);
    const SplatFile rest = scene;
    const Matrix3 turn = random.rotation();
    pose(scene, 0, turn);
    double size = 0;
    for (const std::size_t k : rest.layout.rest) size += rest.number(0, k) * rest.number(0, k);
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const Point3 d = random.direction();
        CHECK(std::fabs(seen(scene, 0, channel, d) - seen(rest, 0, channel, product(transposed(turn), d))) <=
              1e-6 * std::sqrt(size));
    }
}

TEST_CASE("the halves of a split splat have its mass, mean and second moment, at rest and posed",
          "[splats]") {
    const int seed = GENERATE(range(0, 100));
    CAPTURE(seed);
    Random random(seed);
    const SplatFile scene = random_scene(random, 0, 1);
    const SplatPart whole = part_of(scene, 0);
    const Matrix3 map = random.matrix();
    const SingularValues posed = posed_shape(whole, map);
    const auto halves = halves_of(whole, posed, 7);
    CHECK(halves[0].row == 0);
    CHECK(halves[1].row == 7);
    for (const Matrix3& by : {identity3, map}) {
        const auto mass = [&](const SplatPart& part) {
            return part.opacity * std::fabs(determinant(product(by, part.factor)));
        };
        CHECK(mass(halves[0]) + mass(halves[1]) == Approx(mass(whole)).epsilon(1e-12));
        CHECK(mass(halves[0]) == Approx(mass(halves[1])).epsilon(1e-12));
        Point3 mean{};
        Matrix3 moment{};
        for (const SplatPart& half : halves) {
            const Point3 off = product(by, half.place - whole.place);
            mean = mean + 0.5 * off;
            const Matrix3 covariance = square(product(by, half.factor));
            for (std::size_t k = 0; k < 3; ++k) moment[k] = moment[k] + 0.5 * (covariance[k] + off[k] * off);
        }
        const Matrix3 wanted = square(product(by, whole.factor));
        CHECK(length_of(mean) <= 1e-13 * (1 + length_of(whole.place)));
        CHECK(distance(moment, wanted) <= 1e-11 * largest(wanted));
    }
    // along the pose's longest axis
    const Point3 off = product(map, halves[1].place - whole.place);
    CHECK(length_of(off) == Approx(posed.sizes[posed.largest()] / std::sqrt(2.0)).epsilon(1e-9));
    CHECK(stretch_of(halves[0], posed_shape(halves[0], map)) <=
          std::max(stretch_of(whole, posed), 1e-300) * (1 + 1e-12));
}

TEST_CASE("splats that do not move keep their bytes", "[splats]") {
    const int seed = GENERATE(range(0, 20));
    CAPTURE(seed);
    Random random(seed);
    SplatFile scene = random_scene(random, std::size_t(seed % 4), 5);
    const std::string before = bytes_of(scene);
    for (std::size_t i = 0; i < scene.size(); ++i) pose(scene, i, identity3);
    CHECK(bytes_of(scene) == before);
    const auto read = parse_splats(before, "scene.ply");
    REQUIRE(read);
    CHECK(bytes_of(*read) == before);
}

TEST_CASE("degenerate splats and poses give finite numbers", "[splats]") {
    const std::array<SplatShape, 5> shapes{SplatShape{{0, 0, 0, 0}, {-1, -2, -3}},
                                           {{1, 0, 0, 0}, {-1000, -1000, -1000}},
                                           {{0, 0, 3, 0}, {-1000, -1, -1}},
                                           {{0.5, 0.5, 0.5, 0.5}, {80, -80, 0}},
                                           {{1e-20, 0, 0, 1e-20}, {-60, -2, -61}}};
    const std::array<Matrix3, 5> maps{Matrix3{},
                                      {Point3{1, 0, 0}, {1, 0, 0}, {1, 0, 0}},
                                      {Point3{1, 0, 0}, {0, 1, 0}, {0, 0, 0}},
                                      {Point3{-1, 0, 0}, {0, 1e-30, 0}, {0, 0, 1}},
                                      {Point3{1e30, 0, 0}, {0, 1, 0}, {0, 1e-9, 1}}};
    Random random(1);
    for (const SplatShape& shape : shapes) {
        for (const Matrix3& map : maps) {
            SplatFile scene = empty_scene(3);
            Splat splat = random_splat(random, 3);
            splat.shape = shape;
            append(scene, splat);
            pose(scene, 0, map);
            CHECK(fault_of(bytes_of(scene)) == "");
            const auto q = scene.shape(0).rotation;
            CHECK(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] == Approx(1).epsilon(1e-6));
        }
    }
}

TEST_CASE("normals of splats rotate as those of a surface", "[splats]") {
    const int seed = GENERATE(range(0, 20));
    CAPTURE(seed);
    Random random(seed);
    SplatFile scene = random_scene(random, 0, 1);
    const Point3 along = random.point(), across = random.point();
    scene.set(0, scene.layout.normal, cross(along, across));
    const Point3 normal = scene.vector(0, scene.layout.normal);
    const Matrix3 map = random.matrix();
    pose(scene, 0, map);
    const Point3 turned = scene.vector(0, scene.layout.normal);
    const double size = length_of(normal);
    CHECK(length_of(turned) == Approx(size).epsilon(1e-5));
    for (const Point3& t : {product(map, along), product(map, across)})
        CHECK(std::fabs(dot(turned, t)) <= 1e-5 * size * length_of(t));
    CHECK(dot(turned, product(map, normal)) > 0); // the outside stays outside
}

TEST_CASE("other properties of a scene are kept, in their order", "[splats]") {
    Random random(3);
    const SplatFile scene = random_scene(random, 1, 4);
    std::string header = with(scene.header_text(4), "property float opacity\n",
                              "property uchar label\ncomment a comment\nproperty float opacity\n");
    header = with(header, "property float rot_3\n", "property float rot_3\nproperty double time\n");
    const std::size_t before = scene.layout.opacity, bytes = scene.layout.row_bytes;
    std::string rows;
    for (std::size_t i = 0; i < 4; ++i) {
        rows += scene.rows.substr(i * bytes, before) + char('a' + i);
        rows += scene.rows.substr(i * bytes + before, bytes - before) + "12345678";
    }
    auto read = parse_splats(header + rows, "scene.ply");
    REQUIRE(read);
    CHECK(bytes_of(*read) == header + rows);
    CHECK(read->layout.degree() == 1);
    for (std::size_t i = 0; i < 4; ++i) {
        pose(*read, i, random.rotation());
        CHECK(read->rows[i * (bytes + 9) + before] == char('a' + i));
        CHECK(read->rows.substr(i * (bytes + 9) + bytes + 1, 8) == "12345678");
    }
}

TEST_CASE("a broken scene is refused with the fault and its place", "[splats]") {
    Random random(5);
    SplatFile scene = random_scene(random, 1, 4);
    const std::string good = bytes_of(scene);
    CHECK(fault_of(good) == "");
    CHECK(fault_of("") == "scene.ply: is no PLY file: it does not begin with ply");
    CHECK(fault_of("solid cube\n") == "scene.ply: is no PLY file: it does not begin with ply");
    CHECK(fault_of(good.substr(0, 60)).starts_with("scene.ply: the header is cut off"));
    CHECK(fault_of(with(good, "property float rot_2\n", "")) == "scene.ply: a splat has no property rot_2");
    CHECK(fault_of(with(good, "float opacity", "double opacity")) ==
          "scene.ply: the property opacity is not a float");
    CHECK(fault_of(with(good, "float f_rest_8", "float f_other")) ==
          "scene.ply: 8 properties f_rest_: degrees 0 to 3 have 0, 9, 24 or 45");
    CHECK(fault_of(with(good, "float f_rest_8", "float f_rest_9")) ==
          "scene.ply: a splat has no property f_rest_8");
    CHECK(fault_of(with(good, "float f_rest_8", "float f_rest_7")) ==
          "scene.ply: line 21: the element vertex has the property f_rest_7 twice");
    CHECK(fault_of(with(good, "property float x", "property list uchar int x"))
              .starts_with("scene.ply: the property x is a list"));
    CHECK(fault_of(with(good, "float x", "uint packed_position"))
              .starts_with("scene.ply: is a compressed PLY of SuperSplat: export it"));
    CHECK(fault_of(with(good, "element vertex 4", "element face 4")) ==
          "scene.ply: the header has no line element vertex");
    CHECK(fault_of(with(good, "element vertex 4", "element vertex 4\nelement vertex 4")) ==
          "scene.ply: line 4: \"element vertex 4\" does not declare a new element and its number of records");
    CHECK(fault_of(with(good, "end_header", "element face 1\nproperty list uchar int a\nend_header")) ==
          "scene.ply: is cut off in its element \"face\"");
    CHECK(fault_of(with(good, "element vertex 4", "element vertex four")) ==
          "scene.ply: line 3: \"element vertex four\" does not declare a new element and its number of "
          "records");
    CHECK(fault_of(with(good, "element vertex 4", "element vertex 0")) == "scene.ply: has no splats");
    CHECK(fault_of(with(good, "element vertex 4", "element vertex 281474976710656"))
              .starts_with("scene.ply: is cut off: the header declares 281474976710656 splats of 104 bytes"));
    CHECK(fault_of(good.substr(0, good.size() - 1)) ==
          "scene.ply: is cut off: the header declares 4 splats of 104 bytes, but only 415 bytes follow");
    CHECK(fault_of(good + "x").starts_with("scene.ply: is too long"));
    CHECK(fault_of("ply\nend_header\n") == "scene.ply: the header has no line format");
    CHECK(fault_of("ply\nformat binary_little_endian 1.0\nelement vertex 2\nend_header\n") ==
          "scene.ply: a splat has no property x");
}

TEST_CASE("splats that are not finite are left out and counted, all others keep their bytes",
          "[splats][property]") {
    const int seed = GENERATE(range(0, 50));
    CAPTURE(seed);
    Random random(seed);
    SplatFile scene = random_scene(random, std::size_t(seed % 4), 9);
    const SplatFile good = scene;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = HUGE_VAL;
    // Two properties may be infinite: an opacity of either sign, and a scale of −inf.
    scene.set(1, scene.layout.opacity, seed % 2 == 0 ? infinite : -infinite);
    scene.set(2, scene.layout.scales[std::size_t(seed % 3)], -infinite);
    std::string kept, first;
    std::size_t bad = 0;
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const bool breaks = i > 2 && random.between(0, 1) < 0.5;
        if (breaks) {
            const std::array<std::size_t, 5> offsets{scene.layout.place[0], scene.layout.rotation[3],
                                                     scene.layout.colour[1], scene.layout.scales[2],
                                                     scene.layout.opacity};
            const std::size_t at = offsets[(i + std::size_t(seed)) % offsets.size()];
            const double large = at == scene.layout.place[0] ? 1e30 : at == scene.layout.scales[2] ? 89 : nan;
            scene.set(i, at,
                      at == scene.layout.opacity || seed % 3 == 0 ? nan
                      : seed % 3 == 1                             ? infinite
                                                                  : large);
            if (bad++ == 0) first = "splat " + std::to_string(i) + " (counted from 0)";
        } else {
            kept += scene.rows.substr(i * scene.layout.row_bytes, scene.layout.row_bytes);
        }
    }
    auto read = parse_splats(bytes_of(scene), "scene.ply");
    REQUIRE(read);
    CHECK(read->rows == kept);
    CHECK(read->warning.starts_with(
        bad == 0 ? "" : "scene.ply: " + std::to_string(bad) + " of 9 splats are left out, first " + first));
    CHECK(read->warning.empty() == (bad == 0));
    CHECK(bool(parse_splats(bytes_of(scene), "scene.ply", true)) == (bad == 0));
    // No number of a kept splat becomes NaN in a pose.
    for (std::size_t i = 0; i < read->size(); ++i) pose(*read, i, random.matrix());
    CHECK(parse_splats(bytes_of(*read), "posed.ply", true));
    SplatFile none = good;
    for (std::size_t i = 0; i < none.size(); ++i) none.set(i, none.layout.place[1], nan);
    CHECK(fault_of(bytes_of(none)) == "scene.ply: splat 0 (counted from 0): y is not a finite number");
}

TEST_CASE("scenes of any encoding and of any type have the same numbers", "[splats][property]") {
    const int seed = GENERATE(range(0, 12));
    CAPTURE(seed);
    Random random(seed);
    SplatFile scene = random_scene(random, std::size_t(seed % 4), 5);
    scene.set(1, scene.layout.opacity, HUGE_VAL);
    const std::string other = "element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    const std::string header = with(scene.header_text(5), "end_header\n", other);
    const std::string faces = std::string("\2\1\0\0\0\2\0\0\0", 9) + std::string(1, '\0');
    std::string ascii, big, doubles, header_of_doubles = header;
    for (std::size_t at = 0; (at = header_of_doubles.find("property float", at)) != std::string::npos;)
        header_of_doubles.replace(at, 14, "property double");
    for (std::size_t i = 0; i < scene.size(); ++i) {
        for (std::size_t offset = 0; offset < scene.layout.row_bytes; offset += sizeof(float)) {
            const auto number = float(scene.number(i, offset));
            std::array<char, 32> digits{};
            ascii.append(digits.data(),
                         std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr) += ' ';
            auto bytes = std::bit_cast<std::array<char, sizeof(float)>>(number);
            std::reverse(bytes.begin(), bytes.end());
            big.append(bytes.data(), bytes.size());
            append_number(doubles, PlyType::float64, double(number));
        }
        ascii += '\n';
    }
    const auto read = [&](const std::string& text, const std::string& records) {
        const cageform_tests::TemporaryFile file(text + records, "splats.ply");
        auto loaded = load_splats(file.path);
        REQUIRE(loaded);
        CHECK(loaded->rows == scene.rows);
        CHECK(loaded->after == faces);
        CHECK(loaded->header_text(5) == header);
    };
    read(header, scene.rows + faces);
    read(header_of_doubles, doubles + faces);
    read(with(header, "binary_little_endian", "ascii"), ascii + "2 1 2\n0\n");
    read(with(header, "binary_little_endian", "binary_big_endian"),
         big + std::string("\2\0\0\0\1\0\0\0\2", 9) + std::string(1, '\0'));
}

TEST_CASE("elements before and after the splats keep their bytes", "[splats]") {
    Random random(8);
    const SplatFile scene = random_scene(random, 1, 3);
    const std::string header =
        with(with(scene.header_text(3), "element vertex 3\n",
                  "element camera 2\nproperty double f\nproperty list uchar short size\nelement vertex 3\n"),
             "end_header\n", "element face 1\nproperty list int uint vertex_indices\nend_header\n");
    const std::string before = std::string("12345678\2abcd") + "87654321" + std::string(1, '\0'),
                      after = std::string("\1\0\0\0", 4) + "last";
    auto read = parse_splats(header + before + scene.rows + after, "scene.ply");
    REQUIRE(read);
    CHECK(read->rows == scene.rows);
    for (std::size_t i = 0; i < read->size(); ++i) pose(*read, i, random.rotation());
    CHECK(read->before == before);
    CHECK(read->after == after);
    CHECK(read->header_text(3) == header);
}

TEST_CASE("truncated or changed headers are read or refused", "[splats]") {
    Random random(6);
    const std::string good = bytes_of(random_scene(random, 1, 2));
    std::size_t refused = 0;
    for (std::size_t end = 0; end < good.size(); ++end)
        refused += fault_of(good.substr(0, end)).empty() ? 0 : 1;
    CHECK(refused == good.size());
    for (std::size_t n = 0; n < 2000; ++n) {
        std::string bad = good;
        bad[std::size_t(random.between(0, 700))] = char(int(random.between(0, 256)));
        (void)fault_of(bad);
    }
}

TEST_CASE("splats made on a mesh lie on it, and are the same for the same seed", "[splats]") {
    MeshFile mesh;
    mesh.name = "two.obj";
    mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1}, {0, 0, 1}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {3, 4, 0}}; // areas 2, 1, 0
    const SurfaceSplatOptions options{300, 2, 9};
    const SplatFile scene = splats_on(mesh, options);
    CHECK(scene.size() == 300);
    CHECK(fault_of(bytes_of(scene)) == "");
    CHECK(scene.layout.degree() == 2);
    std::size_t flat = 0;
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const Point3 p = scene.place(i);
        CHECK((p[2] == 0 || p[0] == 0));
        flat += p[2] == 0 ? 1 : 0;
        const Matrix3 factor = factor_of(scene.shape(i));
        const Point3 normal = scene.vector(i, scene.layout.normal);
        CHECK(std::fabs(dot(factor[0], normal)) <= 1e-6);
        CHECK(std::fabs(dot(factor[1], normal)) <= 1e-6);
    }
    CHECK(flat >= 199);
    CHECK(flat <= 201);
    CHECK(splats_on(mesh, options).rows == scene.rows);
    CHECK(splats_on(mesh, {300, 2, 10}).rows != scene.rows);
}

TEST_CASE("a quarter turn of the scene is a quarter turn of the view", "[splats]") {
    const int seed = GENERATE(range(0, 3));
    CAPTURE(seed);
    Random random(seed);
    SplatFile scene = random_scene(random, 3, 60);
    const ViewAngles sight{.turn = 20, .rise = 15};
    const Picture rest = draw_splats(scene, nullptr, 80, 60, sight);
    const Matrix3 quarter{Point3{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}; // about y
    for (std::size_t i = 0; i < scene.size(); ++i) pose(scene, i, quarter);
    const Picture turned = draw_splats(scene, nullptr, 80, 60, {.turn = 110, .rise = 15});
    double most = 0, painted = 0;
    for (std::size_t y = 0; y < 60; ++y) {
        for (std::size_t x = 0; x < 80; ++x) {
            const Colour &a = rest.at(x, y), &b = turned.at(x, y);
            most = std::max({most, double(std::fabs(a.r - b.r)), double(std::fabs(a.g - b.g)),
                             double(std::fabs(a.b - b.b))});
            painted += std::fabs(a.r - mesh_background.r) > 0.1f ? 1 : 0;
        }
    }
    CHECK(painted > 100);
    // Contributions below 1/255 are omitted, and rounding decides at the limit; the rest are rounding errors.
    CHECK(most <= 0.5 / 255 + 1.0 / 255);
}

TEST_CASE("one opaque splat is a Gaussian in the picture", "[splats]") {
    SplatFile scene = empty_scene(0);
    // Two transparent splats enlarge the bounding box.
    for (const double x : {-1.0, 1.0}) append(scene, {{x, 0, 0}, {{1, 0, 0, 0}, {-9, -9, -9}}, -30, {}, {}});
    append(scene,
           {{0, 0, 0}, {{1, 0, 0, 0}, {std::log(0.2), std::log(0.1), -9}}, 0, {-9, -9, -9}, {}}); // black
    const Picture picture = draw_splats(scene, nullptr, 100, 50, {.turn = 0, .rise = 0});
    const double pixels = 45; // pixels per unit: the box, two units wide, fills nine tenths of the picture
    for (const std::size_t x : std::array<std::size_t, 4>{20, 40, 50, 60}) {
        for (const std::size_t y : std::array<std::size_t, 3>{20, 25, 28}) {
            const double dx = double(x) + 0.5 - 50, dy = double(y) + 0.5 - 25;
            const double share = 0.5 * std::exp(-0.5 * (dx * dx / (std::pow(0.2 * pixels, 2) + 0.3) +
                                                        dy * dy / (std::pow(0.1 * pixels, 2) + 0.3)));
            const double wanted = double(mesh_background.r) * (1 - (share < 1.0 / 255 ? 0 : share));
            CHECK(std::fabs(double(picture.at(x, y).r) - wanted) <= 1e-4);
        }
    }
}

} // namespace splats_tests
