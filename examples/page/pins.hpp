// Pins on a figure, which move its cage.
#pragma once

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/binding/pose_samples.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

namespace cageform_page {

/// Finds the pose of the points that is nearest to a pose of all handles, for cages with vectors. With Green
/// coordinates the vectors depend on the points, but PoseSolver moves vectors independently. The distance is
/// the energy of the samples, with the pins and the held points. In 2D vectors are linear in the points.
class NearestPoints {
public:
    template <class B>
    void begin(const cageform::PoseSamples<double, 2>& samples, const B& binding) {
        const std::size_t handles = samples.handle_count();
        size_ = samples.size;
        points_.clear();
        std::vector<cageform::Vec<double, 2>> rest, moved(handles);
        for (std::size_t i = 0; i < handles; ++i) {
            if (!binding.handle_view().is_point(i)) continue;
            points_.push_back(i);
            rest.push_back(samples.rest_handles[i]);
        }
        handles_of_ = Eigen::MatrixXd(2 * handles, 2 * rest.size());
        for (std::size_t n = 0; n < 2 * rest.size(); ++n) {
            auto pose = rest;
            pose[n / 2][n % 2] += size_;
            pose_handles(binding, pose, moved);
            for (std::size_t i = 0; i < 2 * handles; ++i)
                handles_of_(Index(i), Index(n)) =
                    (moved[i / 2][i % 2] - samples.rest_handles[i / 2][i % 2]) / size_;
        }
        Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(2 * Index(handles), 2 * Index(handles));
        for (std::size_t i = 0; i < handles; ++i) {
            for (std::size_t j = 0; j < handles; ++j) {
                for (std::size_t k = 0; k < 2; ++k)
                    stiffness(Index(2 * i + k), Index(2 * j + k)) = samples.stiffness_of(i, j);
            }
        }
        pull_ = handles_of_.transpose() * stiffness;
        matrix_ = pull_ * handles_of_;
        proximity_ = 1e-10 * matrix_.trace() / double(matrix_.rows());
        matrix_.diagonal().array() += proximity_;
    }
    bool is_needed() const { return points_.size() * 2 < std::size_t(pull_.cols()); }

    /// Sets the pins by the rows of their weights (#rows × #handles), and the held points.
    void set(const Eigen::MatrixXd& rows, std::span<const std::uint32_t> held) {
        rows_ = Eigen::MatrixXd(2 * rows.rows(), matrix_.cols());
        for (Index r = 0; r < rows.rows(); ++r) {
            for (Index k = 0; k < 2; ++k) {
                rows_.row(2 * r + k).setZero();
                for (Index i = 0; i < rows.cols(); ++i)
                    rows_.row(2 * r + k) += rows(r, i) * handles_of_.row(2 * i + k);
            }
        }
        Eigen::MatrixXd matrix = matrix_ + pin_weight * rows_.transpose() * rows_;
        held_.clear();
        for (std::size_t n = 0; n < points_.size(); ++n) {
            if (std::find(held.begin(), held.end(), points_[n]) == held.end()) continue;
            held_.push_back(n);
            for (std::size_t k = 0; k < 2; ++k) matrix(Index(2 * n + k), Index(2 * n + k)) += held_weight;
        }
        factor_.compute(matrix);
    }
    /// Updates the points of a pose of all handles. Offsets and displacements are in the units of the
    /// samples.
    ///
    ///   offsets  of the pins' targets from rest, 2 numbers per row
    void solve(const Eigen::VectorXd& offsets, std::span<const cageform::Vec<double, 2>> rest,
               std::span<cageform::Vec<double, 2>> handles) const {
        Eigen::VectorXd moved(pull_.cols());
        for (Index i = 0; i < moved.size(); ++i) {
            const auto handle = std::size_t(i / 2), axis = std::size_t(i % 2);
            moved(i) = (handles[handle][axis] - rest[handle][axis]) / size_;
        }
        Eigen::VectorXd right = pull_ * moved + pin_weight * rows_.transpose() * offsets;
        for (std::size_t n = 0; n < points_.size(); ++n)
            right.segment<2>(Index(2 * n)) += proximity_ * moved.segment<2>(Index(2 * points_[n]));
        for (const std::size_t n : held_)
            right.segment<2>(Index(2 * n)) += held_weight * moved.segment<2>(Index(2 * points_[n]));
        const Eigen::VectorXd found = factor_.solve(right);
        for (std::size_t n = 0; n < points_.size(); ++n) {
            for (std::size_t k = 0; k < 2; ++k)
                handles[points_[n]][k] = rest[points_[n]][k] + size_ * found(Index(2 * n + k));
        }
    }

private:
    using Index = Eigen::Index;
    static constexpr double pin_weight = 1e6, held_weight = 1e8;

    std::vector<std::size_t> points_; // handles that are points
    std::vector<std::size_t> held_;   // held ones of these
    double size_ = 0, proximity_ = 0;
    Eigen::MatrixXd handles_of_; // matrix from the points to all handles
    Eigen::MatrixXd pull_, matrix_, rows_;
    Eigen::LDLT<Eigen::MatrixXd> factor_;
};

/// Returns points from a flat array of numbers.
template <class T, std::size_t D>
std::vector<cageform::Vec<T, D>> points_of(const double* numbers, std::size_t count) {
    std::vector<cageform::Vec<T, D>> points(count);
    for (auto& point : points) {
        for (T& x : point.v) x = static_cast<T>(*numbers++);
    }
    return points;
}

/// The pins of one figure. A pose has the points of the cage.
template <cageform::Scalar T, std::size_t D>
class Pins {
public:
    using Status = cageform::Status;
    using Point = cageform::Vec<T, D>;
    using Coordinates = cageform::AnyCoordinates<T, D>;
    static constexpr std::size_t dimension = D;

    /// Sets the samples of solved coordinates, and removes all pins.
    Status take(const Coordinates& coordinates, cageform::PoseSamples<T, D> samples) {
        solver_ = cageform::PoseSolver<T, D>(std::move(samples));
        if (solver_.status() != Status::ok) return solver_.status();
        binding_ = cageform::bind(coordinates, std::vector<Point>{}).value;
        if constexpr (D == 2) nearest_.begin(solver_.samples(), binding_);
        return set(coordinates, {}, {}, {});
    }

    /// Sets the pins by their rest points, the pins that turn, and the held points of the cage.
    Status set(const Coordinates& coordinates, std::span<const double> numbers,
               std::span<const std::uint8_t> turned, std::span<const std::uint32_t> held) {
        culprit_ = none;
        const auto places = points_of<T, D>(numbers.data(), numbers.size() / D);
        auto [binding, report] = cageform::bind(coordinates, places);
        auto [axes, axes_report] = cageform::bind_jacobians(coordinates, places);
        if (report.status != Status::ok) return report.status;
        for (const auto* left_out : {&report.not_finite, &report.unreached, &report.outside}) {
            const bool counts = left_out != &report.outside || D == 2; // in 2D pins must be inside
            if (counts && !left_out->empty()) culprit_ = (*left_out)[0];
        }
        if (culprit_ != none) return Status::pin_without_weights;
        Status status = solver_.set_held(held);
        cageform::PosePins<T, D> pins;
        pins.binding = binding.view();
        pins.turned = turned;
        for (std::size_t k = 0; k < D && !turned.empty(); ++k) pins.axes[k] = axes[k].view();
        if (status == Status::ok) status = solver_.set_pins(pins);
        culprit_ = solver_.culprit();
        if (status != Status::ok) return status;
        binding_ = std::move(binding);
        axes_ = std::move(axes);
        turned_.assign(turned.begin(), turned.end());
        turned_.resize(places.size(), 0);
        if constexpr (D == 2) {
            if (nearest_.is_needed()) nearest_.set(rows(), held);
        }
        return Status::ok;
    }

    /// Sets the initial pose.
    Status begin(const double* pose, std::size_t count) {
        const Status status = set_handles(pose, count);
        return status == Status::ok ? solver_.set_pose(handles_) : status;
    }
    /// Moves a pose towards the targets, once per frame.
    ///
    ///   turns  of pins that turn, or null
    cageform::PoseSolverReport solve(const double* targets, const double* turns, double* pose,
                                     std::size_t count) {
        cageform::PoseSolverReport report;
        report.status = set_handles(pose, count);
        if (report.status != Status::ok) return report;
        const auto to = points_of<double, D>(targets, turned_.size());
        const auto by = points_of < double, D == 2 ? 1 : 3 > (turns, turns == nullptr ? 0 : turned_.size());
        report = solver_.solve(to, handles_, by);
        if constexpr (D == 2) {
            if (report.status == Status::ok && nearest_.is_needed())
                nearest_.solve(offsets(to, by), solver_.samples().rest_handles, handles_);
        }
        for (std::size_t i = 0; i < handles_.size(); ++i) {
            if (binding_.handle_view().is_point(i)) pose = std::copy_n(handles_[i].v, D, pose);
        }
        return report;
    }

    /// Writes the position of each pin in a pose, and the Jacobian of the pose there, column-major.
    Status locate(const double* pose, std::size_t count, double* out) {
        Status status = set_handles(pose, count);
        if (status == Status::ok) status = locate(binding_, axes_);
        if (status != Status::ok) return status;
        for (const Located& pin : located_) {
            out = std::copy_n(pin.place.v, D, out);
            out = std::copy_n(pin.jacobian, D * D, out);
        }
        return status;
    }

    struct Found {
        Point at;    ///< at rest
        double miss; ///< distance of its posed position from the goal
    };
    /// Finds the rest point that a pose moves to `goal`: Newton's method from `start`, with shorter steps if
    /// whole steps do not reduce the distance or leave the cage.
    ///
    ///   ends  the start and the goal
    Found find(const Coordinates& coordinates, const double* ends, const double* pose, std::size_t count)
        requires(D == 2)
    {
        const Point start{ends[0], ends[1]}, goal{ends[2], ends[3]};
        Found found{start, std::numeric_limits<double>::infinity()};
        if (set_handles(pose, count) != Status::ok) return found;
        Point at = start, step{};
        for (int n = 0; n < 40; ++n) {
            const auto [binding, report] = cageform::bind(coordinates, std::array{at});
            const auto axes = cageform::bind_jacobians(coordinates, std::array{at});
            const bool is_inside = report.outside.empty() && report.unreached.empty();
            if (!is_inside || locate(binding, axes.value) != Status::ok) {
                step = 0.5 * step;
            } else if (const Point off = goal - located_[0].place; std::sqrt(dot(off, off)) < found.miss) {
                found = {at, std::sqrt(dot(off, off))};
                step = newton_step(located_[0].jacobian, off);
            } else {
                step = 0.5 * step;
            }
            at = found.at + step;
            if (at == found.at || !is_finite(at)) break;
        }
        return found;
    }

    const cageform::PoseSamples<T, D>& samples() const { return solver_.samples(); }
    std::size_t culprit() const { return culprit_; }

private:
    struct Located {
        Point place;
        T jacobian[D * D];
    };
    static constexpr std::size_t none = cageform::PoseSolverReport::none;
    static constexpr double lever = cageform::turn_lever;

    Status set_handles(const double* pose, std::size_t count) {
        handles_.resize(binding_.handle_count());
        return pose_handles(binding_, points_of<T, D>(pose, count), handles_).status;
    }
    /// Returns the step at rest that moves the located point by a given step; none if the pose is inverted
    /// there.
    static Point newton_step(const T* j, const Point& off) {
        const double determinant = j[0] * j[3] - j[1] * j[2];
        if (!(determinant > 0)) return {};
        return {(j[3] * off[0] - j[2] * off[1]) / determinant, (j[0] * off[1] - j[1] * off[0]) / determinant};
    }
    Status locate(const cageform::Binding<T, D>& binding,
                  const std::array<cageform::Binding<T, D>, D>& axes) {
        located_.resize(binding.point_count());
        if (located_.empty()) return Status::ok;
        constexpr std::ptrdiff_t stride = sizeof(Located);
        const cageform::StridedPoints<T, D> places(located_[0].place.v, located_.size(), stride);
        const cageform::StridedMatrices<T, D> jacobians(located_[0].jacobian, located_.size(), stride);
        const Status status = cageform::clone(binding, handles_, places);
        return status == Status::ok ? clone_jacobians(axes, handles_, jacobians) : status;
    }

    /// Returns the rows of weights of the pins and of the axes of pins that turn, in the units of the
    /// samples.
    Eigen::MatrixXd rows() const {
        const std::size_t handles = binding_.handle_count();
        Eigen::MatrixXd all(0, Eigen::Index(handles));
        const auto add = [&](const auto& binding, std::size_t pin, double factor) {
            all.conservativeResize(all.rows() + 1, Eigen::NoChange);
            for (std::size_t i = 0; i < handles; ++i)
                all(all.rows() - 1, Eigen::Index(i)) = factor * double(binding.weight(pin, i));
        };
        for (std::size_t pin = 0; pin < turned_.size(); ++pin) {
            add(binding_, pin, 1);
            for (std::size_t k = 0; k < D && turned_[pin] != 0; ++k)
                add(axes_[k], pin, lever * samples().size);
        }
        return all;
    }
    Eigen::VectorXd offsets(const std::vector<cageform::Vec<double, D>>& targets,
                            const std::vector<cageform::PoseTurn<D>>& turns) const {
        std::vector<double> all;
        for (std::size_t pin = 0; pin < turned_.size(); ++pin) {
            const auto rest = cageform::vec_cast<double>(binding_.rest_point(pin));
            for (std::size_t k = 0; k < D; ++k) all.push_back((targets[pin][k] - rest[k]) / samples().size);
            if (turned_[pin] == 0) continue;
            const double c = lever * (std::cos(turns[pin][0]) - 1), s = lever * std::sin(turns[pin][0]);
            all.insert(all.end(), {c, s, -s, c});
        }
        return Eigen::Map<const Eigen::VectorXd>(all.data(), Eigen::Index(all.size()));
    }

    cageform::PoseSolver<T, D> solver_;
    NearestPoints nearest_;
    cageform::Binding<T, D> binding_;
    std::array<cageform::Binding<T, D>, D> axes_;
    std::vector<std::uint8_t> turned_;
    std::vector<Point> handles_;
    std::vector<Located> located_;
    std::size_t culprit_ = none;
};

} // namespace cageform_page
