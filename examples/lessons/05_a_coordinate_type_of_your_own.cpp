// 5. Adding a coordinate type: a class that models CageCoordinates. Here: among all weights that sum to one
// and reproduce the point, those closest to equal weights. The weights are not local, and they do not
// interpolate: at a vertex of the cage, its weight is not 1 in general.
#include <cageform/cageform.hpp>

#include <Eigen/LU>

#include <array>
#include <cstdio>

class EvenWeights {
public:
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = true; // defined in the whole plane
    static constexpr bool closed_form = true;   // the cost of a point does not depend on the batch

    explicit EvenWeights(cageform::Polygon<double> cage)
        : cage_(std::move(cage))
        , report_(cageform::check(cage_)) {}

    std::span<const cageform::Vec<double, 2>> handles() const { return cage_.vertices(); }
    const cageform::CageReport& cage_report() const { return report_; }

    // The whole batch at once. A row of `weights` belongs to a handle, a column to a point.
    cageform::Evaluation evaluate(cageform::BlockView<const double> points,
                                  cageform::BlockView<double> weights, std::span<cageform::PointState> states,
                                  const cageform::Running&) const {
        if (report_.status != cageform::Status::ok) return {report_.status, {}};
        const auto count = long(cage_.size());
        Eigen::Matrix3Xd a(3, count);
        for (long i = 0; i < count; ++i) a.col(i) << 1, cage_[std::size_t(i)][0], cage_[std::size_t(i)][1];
        const Eigen::MatrixX3d inverse = a.transpose() * (a * a.transpose()).inverse();
        const double tolerance = cageform::coincidence_tolerance(cageform::bounds_of(cage_.vertices()));
        for (std::size_t p = 0; p < points.blocks() * points.lanes; ++p) { // every lane of the last block
            const Eigen::VectorXd w = inverse * Eigen::Vector3d(1, points(p, 0), points(p, 1));
            for (long i = 0; i < count; ++i) weights(p, std::size_t(i)) = w[i];
            if (p >= points.points || states[p] == cageform::PointState::not_finite) continue;
            states[p] = cageform::locate(cage_, cageform::block_point<2>(points, p), tolerance);
        }
        return {};
    }

    cageform::Vec<double, 2> nearest_boundary(const cageform::Vec<double, 2>& p,
                                              std::span<double> row) const {
        return cageform::nearest_boundary_weights(cage_, p, row);
    }

private:
    cageform::Polygon<double> cage_;
    cageform::CageReport report_;
};

static_assert(cageform::CageCoordinates<EvenWeights>);

int main() {
    using Point = std::array<double, 2>;
    const std::array<Point, 4> cage{{{0, 0}, {2, 0}, {2, 2}, {0, 2}}};
    const std::array<Point, 2> figure{{{1, 1}, {0.5, 1}}};
    const auto [binding, report] = cageform::bind(EvenWeights(cageform::Polygon(cage)), figure);
    if (report.status != cageform::Status::ok) return 1;
    for (std::size_t i = 0; i < figure.size(); ++i) {
        std::printf("(%g, %g):", figure[i][0], figure[i][1]);
        for (std::size_t h = 0; h < 4; ++h) std::printf(" %g", binding.weight(i, h));
        std::printf("\n");
    }
}

//> (1, 1): 0.25 0.25 0.25 0.25
//> (0.5, 1): 0.375 0.125 0.125 0.375
