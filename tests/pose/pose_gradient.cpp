// The gradient of a pose's energy by transposed clones: of the Jacobians of samples, of spokes, of pins.
#include "../support/pins.hpp"

#include <cageform/clone/clone_transposed.hpp>

namespace pose_gradient_tests {

using namespace cageform_tests;
using cageform::CloneMode;
using cageform::GreenCoordinates;
using cageform::HarmonicCoordinates;
using cageform::MeanValueCoordinates;
using cageform::StridedMatrices;

namespace {

/// The gradient of the energy from bindings and their transposed clones, as available to a program. The
/// rotations of SampledEnergy minimise the energy, so they count as constant.
template <class C>
class TransposedGradient {
public:
    static constexpr std::size_t D = C::dimension;
    using Point = Vec<double, D>;

    explicit TransposedGradient(const Pinned<C>& figure)
        : figure_(figure)
        , samples_(figure.solver.samples()) {
        auto axes = bind_jacobians(figure.coordinates, samples_.points);
        REQUIRE(axes);
        axes_ = std::move(axes.value);
        Places<D> centres;
        for (const std::uint32_t s : samples_.centres) centres.push_back(samples_.points[s]);
        centres_ = bound(figure.coordinates, centres);
    }

    /// Returns the gradient of each handle, times the cage's size.
    std::vector<Point> operator()(const SampledEnergy<C>& energy, const Places<D>& targets) const {
        const auto& pose = figure_.pose;
        const auto turns = energy.rotations(energy.handles_of(pose));
        const std::size_t count = samples_.points.size();
        std::vector<Point> pulled(pose.size(), Point{});
        // |J - R|² of each sample, by the Jacobians that clone_jacobians computes.
        std::vector<double> numbers(count * D * D);
        const StridedMatrices<double, D> jacobians(numbers.data(), count);
        REQUIRE(clone_jacobians(axes_, pose, jacobians) == Status::ok);
        for (std::size_t k = 0; k < D; ++k) {
            const auto column = jacobians.column(k);
            for (std::size_t s = 0; s < count; ++s) {
                Point of_turn;
                for (std::size_t r = 0; r < D; ++r)
                    of_turn[r] = turns[samples_.clusters[s]](Eigen::Index(r), Eigen::Index(k));
                store_point(column, s, (2 / double(count)) * (cageform::to_vec<double>(column[s]) - of_turn));
            }
        }
        REQUIRE(clone_jacobians_transposed(axes_, jacobians, pulled) == Status::ok);
        // Spokes, as in SampledEnergy; spokes of points end at the centre of a cluster.
        std::vector<Point> ends(samples_.cluster_count), of_ends(samples_.cluster_count, Point{});
        REQUIRE(clone(centres_, pose, ends) == Status::ok);
        for (const auto& spoke : energy.spokes()) {
            const auto& turn = turns[spoke.cluster];
            Point off = (1 / spoke.length) *
                        (spoke.is_point ? pose[spoke.handle] - ends[spoke.cluster] : pose[spoke.handle]);
            for (std::size_t r = 0; r < D; ++r) {
                for (std::size_t k = 0; k < D; ++k)
                    off[r] -= turn(Eigen::Index(r), Eigen::Index(k)) * spoke.direction[k];
            }
            const Point gradient = (2 * spoke.weight / spoke.length) * off;
            pulled[spoke.handle] = pulled[spoke.handle] + gradient;
            if (spoke.is_point) of_ends[spoke.cluster] = of_ends[spoke.cluster] - gradient;
        }
        REQUIRE(clone_transposed(centres_, of_ends, pulled, {.mode = CloneMode::add}) == Status::ok);
        // Pins.
        std::vector<Point> places(targets.size());
        REQUIRE(clone(figure_.binding, pose, places) == Status::ok);
        const double factor = figure_.options.pin_weight / (figure_.size() * figure_.size());
        for (std::size_t n = 0; n < targets.size(); ++n) places[n] = 2 * factor * (places[n] - targets[n]);
        REQUIRE(clone_transposed(figure_.binding, places, pulled, {.mode = CloneMode::add}) == Status::ok);
        for (auto& g : pulled) g = figure_.size() * g;
        return pulled;
    }

private:
    const Pinned<C>& figure_;
    const PoseSamples<double, D>& samples_;
    std::array<cageform::Binding<double, D>, D> axes_;
    cageform::Binding<double, D> centres_;
};

template <class C>
void check_gradient(const C& coordinates, const Places<C::dimension>& pins,
                    const Places<C::dimension>& targets) {
    constexpr std::size_t D = C::dimension;
    const PoseSampleOptions how{.samples = effort<std::size_t>(1000, 300)};
    Pinned figure(coordinates, pins, how, {.iterations = 16});
    const SampledEnergy energy(figure, targets);
    const TransposedGradient gradient(figure);
    // At an intermediate pose: differences of the energy, with optimal rotations.
    figure.solve(targets);
    Random random(3);
    for (auto& h : figure.pose) {
        for (std::size_t k = 0; k < D; ++k) h[k] += 0.01 * figure.size() * random.uniform(-1, 1);
    }
    const auto slopes = gradient(energy, targets);
    const auto handles = energy.handles_of(figure.pose);
    const double step = 1e-5 * figure.size();
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < slopes.size(); i += effort(1u, 7u)) {
        for (std::size_t k = 0; k < D; ++k) {
            auto before = handles, after = handles;
            before(Eigen::Index(k), Eigen::Index(i)) -= step;
            after(Eigen::Index(k), Eigen::Index(i)) += step;
            const double slope = (energy(after) - energy(before)) / 2e-5;
            worst = std::fmax(worst, std::fabs(slope - slopes[i][k]));
            largest = std::fmax(largest, std::fabs(slope));
        }
    }
    CAPTURE(worst, largest);
    CHECK(largest > 1);
    CHECK(worst <= 1e-6 * largest);
    // The gradient vanishes at the solver's limit. Pins of weight 1e4 amplify rounding of the pose.
    figure.solve(targets, 150);
    double left = 0;
    for (const auto& g : gradient(energy, targets)) left += dot(g, g);
    CAPTURE(std::sqrt(left));
    CHECK(std::sqrt(left) <= 1e-8);
}

} // namespace

TEST_CASE("transposed clones give the gradient of the energy, which vanishes where a pose has settled",
          "[pose][transposed]") {
    check_gradient(MeanValueCoordinates(cat_cage()), cat_pins(), cat_targets());
    HarmonicCoordinates harmonic(cat_cage());
    REQUIRE(harmonic.solve().status == Status::ok); // all evaluations use the same functions
    check_gradient(harmonic, cat_pins(), cat_targets());
    check_gradient(GreenCoordinates(cat_cage()), cat_pins(), cat_targets());
    check_gradient(MeanValueCoordinates(bar().mesh<double>()), bar_pins(), bar_targets());
    check_gradient(GreenCoordinates(bar().mesh<double>()), bar_pins(), bar_targets());
}

} // namespace pose_gradient_tests
