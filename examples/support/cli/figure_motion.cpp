#include "cli/figure_motion.hpp"

#include "cli/progress_bar.hpp"
#include "files/bind_report.hpp"
#include "io/messages.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/cage/polygon.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/clone_rational.hpp>
#include <cageform/clone/jacobians.hpp>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

namespace cageform_support {

std::string FigureControl::name_of(std::size_t frame) const {
    return frames == 1 ? pose_name : pose_name + ": frame " + std::to_string(frame);
}

FigureControl control_of(const CoordinatesChoice& choice, const CageFile& cage) {
    FigureControl control;
    control.coordinates = make_coordinates<double>(choice, cage);
    control.name = cage.name;
    control.describe_faults = [name = cage.name](const cageform::BindReport& report) {
        return describe_faults(name, report);
    };
    return control;
}

namespace {

/// Returns the errors of a posed cage; empty if there are none.
using PoseCheck = std::function<std::string(const std::vector<Point2>& pose)>;

PoseCheck check_crossings(const CageFile& cage) {
    return [&cage](const std::vector<Point2>& pose) {
        std::vector<cageform::Vec<double, 2>> places;
        for (std::size_t i = 0; i < cage.vertices.size(); ++i) places.push_back({pose[i].x, pose[i].y});
        const CageFile moved = moved_cage(cage, places);
        const auto report = cage.curves ? cageform::check(moved.curved_polygon<double>())
                                        : cageform::check(moved.polygon<double>());
        std::string text;
        if (report.status == cageform::Status::ok) return text;
        for (const auto& fault : report.faults) {
            if (cageform::status_of(fault.kind) == cageform::Status::ok) continue;
            text = "in the posed cage " + describe_fault(fault);
            break;
        }
        if (report.fault_count > 1) text += " and " + std::to_string(report.fault_count - 1) + " more";
        return text;
    };
}

/// Checks for folds: points of a grid where the Jacobian determinant, 1 at rest, is not positive.
PoseCheck check_folds(const LatticeBox<2>& lattice) {
    std::array<std::size_t, 2> counts{};
    for (std::size_t k = 0; k < 2; ++k)
        counts[k] = std::min<std::size_t>(4 * (lattice.axes[k].points - 1) + 1, 65);
    std::vector<Point2> places;
    for (std::size_t n = 0; n < counts[0] * counts[1]; ++n) {
        const cageform::Vec<double, 2> u{double(n % counts[0]) / double(counts[0] - 1),
                                         double(n / counts[0]) / double(counts[1] - 1)};
        const auto p = lattice.frame.translation + lattice.frame.map_vector(u);
        places.push_back({p[0], p[1]});
    }
    auto bound = cageform::bind_jacobians(lattice.coordinates<double>(), places);
    return [places = std::move(places), columns = std::move(bound.value)](const std::vector<Point2>& pose) {
        std::vector<double> numbers(4 * places.size());
        const cageform::StridedMatrices<double, 2> jacobians(numbers.data(), places.size());
        const auto status = cageform::clone_jacobians(columns, pose, jacobians);
        double least = 0;
        std::size_t where = places.size();
        for (std::size_t i = 0; i < places.size() && status == cageform::Status::ok; ++i) {
            const double* const j = numbers.data() + 4 * i;
            const double determinant = j[0] * j[3] - j[1] * j[2];
            if (determinant > 0 || (where < places.size() && determinant >= least)) continue;
            least = determinant;
            where = i;
        }
        return where < places.size() ? "the posed lattice folds most at " + name_points(places, {where})
                                     : std::string();
    };
}

} // namespace

std::string pose_faults(const FigureControl& control, const CageFile& cage) {
    const PoseCheck check = cage.lattice ? check_folds(*cage.lattice) : check_crossings(cage);
    std::size_t count = 0;
    std::string first;
    for (std::size_t i = 0; i < control.poses.size(); ++i) {
        const std::string fault = check(control.poses[i]);
        if (fault.empty() || ++count > 1) continue;
        first = control.name_of(i % control.frames) + ": " + fault;
    }
    if (count == 0) return {};
    return first + (count > 1 ? ", and in " + std::to_string(count - 1) + " more frames" : "") +
           ": the figure may fold over itself there";
}

namespace {

/// Binds batches of points and moves them to all frames. The first batch decides whether the figure is inside
/// the cage; only visible points count. In later batches, each point is checked separately. Points without
/// weights become NaN.
class BatchMover {
public:
    BatchMover(const std::string& figure, const FigureControl& control, OutsideChoice outside,
               cageform::ParallelFor parallel)
        : figure_(figure)
        , control_(control)
        , outside_(std::move(outside))
        , running_{std::move(parallel)} {
        options_ = outside_.bind_options(control.coordinates);
    }

    /// False on an error, see `failure`.
    bool move(std::span<const Point2> in, std::span<const PointRole> roles, std::span<Point2> out) {
        const auto& coordinates = control_.coordinates;
        const auto [binding, bound] = coordinates.bind(in, options_, running_);
        if (bound.status != cageform::Status::ok) {
            failure = control_.describe_faults(bound);
            return false;
        }
        std::vector<bool> counts(in.size()); // visible, and with weights
        for (std::size_t i = 0; i < in.size(); ++i) counts[i] = roles[i].is_seen;
        for (const std::size_t i : bound.unreached) counts[i] = false;
        cageform::BindReport judged = bound;
        judged.unreached.clear();
        judged.points = std::size_t(std::count(counts.begin(), counts.end(), true));
        std::erase_if(judged.outside, [&](std::size_t i) { return !counts[i]; });
        auto verdict = outside_.judge(coordinates, judged, in, figure_, control_.name);
        failure = std::move(verdict.fault);
        if (!failure.empty()) return false;
        judged.outside.clear();
        judged.unreached = bound.unreached;
        if (unreached.empty())
            unreached = outside_.judge(coordinates, judged, in, figure_, control_.name).fault;
        if (first.points == 0) {
            first = bound;
            warning = std::move(verdict.warning);
            outside_.of_part = true;
        }
        std::vector<Point2> moved(control_.poses.size() == control_.frames ? 0 : in.size());
        for (std::size_t i = 0; i < control_.poses.size(); ++i) {
            const std::size_t layer = i / control_.frames, frame = i % control_.frames;
            const auto target = out.subspan(frame * in.size(), in.size());
            if (!clone(binding, i, frame, moved.empty() ? target : std::span(moved))) return false;
            for (std::size_t k = 0; k < moved.size(); ++k) {
                if (roles[k].layer == layer) target[k] = moved[k];
            }
        }
        constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
        for (std::size_t frame = 0; frame < control_.frames; ++frame) {
            for (const std::size_t i : bound.unreached) out[frame * in.size() + i] = {nowhere, nowhere};
        }
        return true;
    }

    cageform::BindReport first;
    std::string failure, warning, unreached, pose_warning;

private:
    bool clone(const cageform::Binding<double, 2>& binding, std::size_t pose, std::size_t frame,
               std::span<Point2> moved) {
        const std::string name = control_.name_of(frame);
        std::string collapsed;
        const auto handles = control_.poses_all_handles
                                 ? Expected<std::vector<Point2>>(control_.poses[pose])
                                 : pose_of_handles(binding, control_.poses[pose], name, collapsed);
        if (pose_warning.empty()) pose_warning = collapsed;
        if (!handles) {
            failure = to_string(handles.error());
            return false;
        }
        const auto& weights = control_.weights;
        const auto status = weights.empty()
                                ? cageform::clone(binding, *handles, moved)
                                : cageform::clone_rational(binding, *handles, std::span(weights), moved);
        if (status != cageform::Status::ok)
            failure = (weights.empty() ? name : control_.weights_name) + ": " + cageform::to_string(status);
        return status == cageform::Status::ok;
    }

    const std::string& figure_;
    const FigureControl& control_;
    OutsideChoice outside_;
    cageform::Running running_;
    cageform::BindOptions options_;
};

} // namespace

MovedFigure move_figure(const SvgDocument& document, const std::string& figure, const FigureControl& control,
                        const OutsideChoice& outside, const DeformOptions& options,
                        const cageform::ParallelFor& parallel) {
    MovedFigure result;
    if (!control.coordinates.closed_form()) {
        // Points arrive in several batches; solve once.
        ProgressBar bar("solving");
        const auto evaluation = control.coordinates.solve({parallel, bar.callback()});
        result.bound.status = evaluation.status;
        result.bound.cage = control.coordinates.cage_report();
        result.bound.solver = evaluation.solver;
        if (evaluation.status != cageform::Status::ok) throw Failure(control.describe_faults(result.bound));
        warn_of_coarse_grid(control.name, evaluation.solver);
    }
    BatchMover mover(figure, control, outside, parallel);
    const FrameDeformer deformer = [&](std::span<const Point2> in, std::span<const PointRole> roles,
                                       std::span<Point2> out) { return mover.move(in, roles, out); };
    auto drawing = animate(document, deformer, control.frames, options);
    fail_if(mover.failure);
    result.drawing = value_or_fail(std::move(drawing));
    if (mover.first.points != 0) result.bound = mover.first;
    for (const std::string& each : {mover.warning, mover.unreached, mover.pose_warning}) warn(each);
    const DeformReport& report = result.drawing.report;
    print_warnings(report.warnings);
    if (report.cut_off > 0) {
        warn(detail::counted(report.cut_off, "shape") + (report.cut_off == 1 ? " is" : " are") +
             " cut off at the edge of the picture; --fit enlarges it");
    }
    if (report.coarse > 0) {
        warn(std::to_string(report.coarse) + " of " + std::to_string(report.segments) +
             " segments do not meet --flatness");
    }
    return result;
}

std::vector<std::vector<Point2>> move_points(const std::vector<Point2>& points, const std::string& figure,
                                             const FigureControl& control, const OutsideChoice& outside) {
    OutsideChoice of_part = outside;
    of_part.of_part = true;
    BatchMover mover(figure, control, std::move(of_part), cageform::SerialFor{});
    std::vector<Point2> moved(control.frames * points.size());
    if (!mover.move(points, std::vector<PointRole>(points.size()), moved)) throw Failure(mover.failure);
    fail_if(mover.unreached);
    warn(mover.warning);
    std::vector<std::vector<Point2>> frames;
    for (auto at = moved.begin(); at != moved.end(); at += std::ptrdiff_t(points.size()))
        frames.emplace_back(at, at + std::ptrdiff_t(points.size()));
    return frames;
}

void add_text_as_paths(CommandLine& line, bool& text_as_paths) {
    line.add_flag(
        "--text-as-paths", text_as_paths,
        "deform the outlines of letters (as rsvg-convert draws them); otherwise a text moves as a whole");
}

void add_threads(CommandLine& line, std::size_t& threads) {
    line.add("--threads", threads, "the number of threads that bind; 0: all processors")
        .range(0, 1024)
        .show_default();
}

} // namespace cageform_support
