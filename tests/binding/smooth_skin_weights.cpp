// Smooth skins: the laws of every skin, and smooth losses.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/larger.hpp"
#include "support/meshes.hpp"
#include "support/weights.hpp"

#include <cageform/binding/skin_weights.hpp>
#include <cageform/binding/smooth_skin_weights.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>

#include <set>

namespace smooth_skin_weights_tests {

using namespace cageform_tests;
using cageform::SkinWeights;
using cageform::SkinWeightsOptions;
using Binding = cageform::Binding<double, 3>;
using Place = Vec<double, 3>;

namespace {

/// A bumpy figure in a cage of 66 vertices, both with random sizes along the axes.
struct Scene {
    MeshData figure = sphere(3), cage = sphere(2);
    Binding binding;

    explicit Scene(int seed, bool with_seam = false) {
        Random random{std::uint64_t(seed)};
        const Place sizes{random.uniform(0.6, 1.5), random.uniform(0.6, 1.5), random.uniform(1, 2.5)};
        const double bumps = random.uniform(2, 6);
        for (Place& p : figure.vertices) {
            const double radius = 0.65 + 0.15 * std::sin(bumps * p[0]) * std::cos(bumps * p[2]);
            for (std::size_t k = 0; k < 3; ++k) p[k] *= radius * sizes[k];
        }
        for (Place& p : cage.vertices) {
            for (std::size_t k = 0; k < 3; ++k) p[k] *= random.uniform(1.05, 1.25) * sizes[k];
        }
        if (with_seam) { // every triangle has its own vertices
            MeshData apart;
            for (const auto& face : figure.faces) {
                const auto first = int(apart.vertices.size());
                for (const auto corner : face) apart.vertices.push_back(figure.vertices[std::size_t(corner)]);
                apart.faces.push_back({first, first + 1, first + 2});
            }
            figure = std::move(apart);
        }
        binding =
            cageform::bind(cageform::MeanValueCoordinates<double, 3>(cage.mesh<double>()), figure.vertices)
                .value;
    }
    cageform::Result<cageform::SkinWeights, cageform::SkinWeightsReport>
    smooth(const SkinWeightsOptions& options, const cageform::Running& running = {}) const {
        return cageform::smooth_skin_weights(binding, figure.faces, options, running);
    }
    Points3<double> played(const SkinWeights& skin, const Points3<double>& pose) const {
        const auto [of_skin, status] = cageform::skin_to_binding(binding, skin);
        REQUIRE(status == Status::ok);
        Points3<double> moved(figure.vertices.size());
        REQUIRE(clone(of_skin, pose, moved) == Status::ok);
        return moved;
    }
    /// The largest difference of a posed edge between a skin and the binding.
    double edge_loss(const SkinWeights& skin, const Points3<double>& pose) const {
        Points3<double> right(figure.vertices.size());
        REQUIRE(clone(binding, pose, right) == Status::ok);
        const auto moved = played(skin, pose);
        double largest = 0;
        for (const auto& face : figure.faces) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto a = std::size_t(face[k]), b = std::size_t(face[(k + 1) % 3]);
                const Place d = (moved[a] - moved[b]) - (right[a] - right[b]);
                largest = larger(largest, std::sqrt(dot(d, d)));
            }
        }
        return largest;
    }
};

/// The cage twisted about z, by 80 degrees from end to end.
Points3<double> twisted(const Points3<double>& rest) {
    Points3<double> pose;
    for (const Place& p : rest) {
        const double angle = 0.7 * p[2] / 1.5;
        pose.push_back({std::cos(angle) * p[0] - std::sin(angle) * p[1],
                        std::sin(angle) * p[0] + std::cos(angle) * p[1], p[2]});
    }
    return pose;
}

} // namespace

TEST_CASE("a smooth skin satisfies the laws of skins", "[binding][smooth_skin_weights][property]") {
    const auto seed = GENERATE(range(0, effort(6, 1)));
    CAPTURE(seed);
    const Scene scene(seed);
    for (const std::size_t influences : {1u, 3u, 4u, 5u, 8u, 16u}) {
        CAPTURE(influences);
        const auto [skin, report] = scene.smooth({.influences = influences});
        REQUIRE(report.status == Status::ok);
        REQUIRE(skin.point_count() == scene.figure.vertices.size());
        CHECK(report.without_weights.empty());
        for (std::size_t i = 0; i < skin.point_count(); ++i) {
            std::set<std::uint16_t> used;
            double sum = 0, least = 1;
            Place missed = -1.0 * scene.figure.vertices[i];
            for (std::size_t k = 0; k < influences; ++k) {
                const double w = double(skin.weights[i * influences + k]);
                const auto joint = skin.joints[i * influences + k];
                REQUIRE(w >= 0);
                REQUIRE(w <= least);
                if (w > 0)
                    REQUIRE(used.insert(joint).second);
                else
                    REQUIRE(joint == 0);
                least = w;
                sum += w;
                missed = missed + w * scene.cage.vertices[joint];
            }
            REQUIRE(std::fabs(sum - 1) <= 0x1p-25);
            if (influences > 3) REQUIRE(std::sqrt(dot(missed, missed)) <= 1e-6 * 5);
        }
        if (influences > 3) CHECK(report.not_reproduced.empty());
    }
}

TEST_CASE("a smooth skin of all handles equals the binding", "[binding][smooth_skin_weights]") {
    const Scene scene(1);
    const auto [skin, report] = scene.smooth({.influences = scene.cage.vertices.size()});
    REQUIRE(report.status == Status::ok);
    CHECK(report.weight_error.value <= 0.02); // the convergence of the passes, relative to a sum of 1
    CHECK(report.mean_weight_error <= 0.005);
}

TEST_CASE("smooth skins have smaller edge errors than pointwise skins",
          "[binding][smooth_skin_weights][property]") {
    const auto seed = GENERATE(range(0, effort(6, 2)));
    CAPTURE(seed);
    const Scene scene(seed);
    const auto pose = twisted(scene.cage.vertices);
    for (const std::size_t influences : {8u, 16u}) {
        const auto alone = cageform::skin_weights(scene.binding, {.influences = influences});
        const auto smooth = scene.smooth({.influences = influences});
        const double before = scene.edge_loss(alone.value, pose), after = scene.edge_loss(smooth.value, pose);
        CAPTURE(influences, before, after);
        CHECK(after <= 0.8 * before);
    }
}

TEST_CASE("smooth skins preserve affine poses and closed seams", "[binding][smooth_skin_weights][property]") {
    const auto seed = GENERATE(range(0, effort(3, 1)));
    CAPTURE(seed);
    const Scene scene(seed, true);
    const auto [skin, report] = scene.smooth({.influences = 6});
    REQUIRE(report.status == Status::ok);
    std::map<std::array<double, 3>, std::size_t> first;
    for (std::size_t i = 0; i < scene.figure.vertices.size(); ++i) {
        const Place& p = scene.figure.vertices[i];
        const std::size_t same = first.insert({{p[0], p[1], p[2]}, i}).first->second;
        for (std::size_t k = 0; k < 6; ++k) {
            REQUIRE(skin.joints[6 * i + k] == skin.joints[6 * same + k]);
            REQUIRE(skin.weights[6 * i + k] == skin.weights[6 * same + k]);
        }
    }
    CHECK(first.size() == sphere(3).vertices.size());
    const auto affine = [](const Place& p) {
        return Place{1.5 * p[0] - p[1], p[2] + 0.25 * p[0], p[1] - 2 * p[2]};
    };
    Points3<double> pose;
    for (const Place& p : scene.cage.vertices) pose.push_back(affine(p));
    const auto moved = scene.played(skin, pose);
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const Place off = moved[i] - affine(scene.figure.vertices[i]);
        REQUIRE(std::sqrt(dot(off, off)) <= 1e-4);
    }
}

TEST_CASE("points kept in place have no weights, and their edges are ignored",
          "[binding][smooth_skin_weights]") {
    Scene scene(2);
    scene.figure.vertices[7] = {50, 0, 0};
    scene.binding = cageform::bind(cageform::MeanValueCoordinates<double, 3>(scene.cage.mesh<double>()),
                                   scene.figure.vertices, {.outside = cageform::OutsidePoints::keep_in_place})
                        .value;
    const auto [skin, report] = scene.smooth({.influences = 8});
    REQUIRE(report.status == Status::ok);
    CHECK(report.without_weights == std::vector<std::size_t>{7});
    CHECK(report.not_reproduced.empty());
    for (std::size_t k = 0; k < 8; ++k) CHECK(skin.weights[7 * 8 + k] == 0);
}

TEST_CASE("weights below the threshold are dropped from a smooth skin", "[binding][smooth_skin_weights]") {
    const Scene scene(3);
    const auto [skin, report] = scene.smooth({.influences = 16, .threshold = 0.04});
    REQUIRE(report.status == Status::ok);
    CHECK(report.not_reproduced.empty());
    CHECK(report.mean_influences < scene.smooth({.influences = 16}).report.mean_influences);
}

TEST_CASE("a smooth skin does not depend on threads", "[binding][smooth_skin_weights]") {
    const Scene scene(4);
    const auto serial = scene.smooth({.influences = 8});
    const auto parallel = scene.smooth({.influences = 8}, {.parallel = cageform::ThreadedFor{3}});
    CHECK(serial.value.joints == parallel.value.joints);
    CHECK(serial.value.weights == parallel.value.weights);
}

TEST_CASE("invalid input of smooth_skin_weights is rejected", "[binding][smooth_skin_weights]") {
    Scene scene(5);
    const auto status = [&](const SkinWeightsOptions& options) {
        const auto result = scene.smooth(options);
        CHECK(result.value.weights.empty());
        return result.report.status;
    };
    CHECK(status({.influences = 0}) == Status::too_few_influences);
    CHECK(status({.influences = 65536}) == Status::too_many_handles);
    CHECK(status({.threshold = std::numeric_limits<double>::quiet_NaN()}) == Status::value_not_finite);
    scene.figure.faces[3][1] = int(scene.figure.vertices.size());
    CHECK(status({}) == Status::index_out_of_range);
}

} // namespace smooth_skin_weights_tests
