// The implementation of `wrap`: checks, alignment, samples, stages, report.
#pragma once

#include <cageform/fit/detail/check_surface.hpp>
#include <cageform/fit/detail/find_wrap.hpp>
#include <cageform/fit/detail/lattice_matrix.hpp>
#include <cageform/fit/detail/target_noise.hpp>
#include <cageform/fit/detail/wrap_cage.hpp>
#include <cageform/fit/detail/wrap_frame.hpp>
#include <cageform/fit/detail/wrap_stage.hpp>
#include <cageform/fit/detail/wrap_stages.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

class WrapFinder {
    using Point = Vec<double, 3>;

public:
    WrapFinder(const WrapInput& input, WrapReport& report)
        : source_(input.source)
        , target_(input.target)
        , options_(input.options)
        , cage_(input.cage)
        , report_(report) {}

    Status run(const Running& running) {
        if (const Status status = check(); status != Status::ok) return status;
        frame_.emplace(source_.vertices(), source_.faces(), target_.vertices(), options_);
        const WrapFrame& frame = *frame_;
        report_.height = frame.height;
        report_.alignment = frame.first.transform();
        if (!(frame.height > 0) || !is_finite(frame.first.scale) || !is_finite(frame.first.shift))
            return Status::figure_has_no_size;
        std::vector<WrapOptions::Stage> stages = wrap_stages(options_, cage_ != nullptr);
        Status status = set_points(frame);
        if (status == Status::ok && cage_ == nullptr && !stages.empty() &&
            is_too_large(options_, stages.front().cells,
                         bounds_of(std::span<const Point>(scene_.source.rest))))
            status = Status::too_many_handles;
        if (status != Status::ok) return status;
        const bool has_lattice =
            std::any_of(stages.begin(), stages.end(), [](const auto& stage) { return stage.cells > 0; });
        status = set_scene(frame, has_lattice ? 1.0 / 50 : 1.0 / 35, running.subtask(0, 0.1));
        if (status != Status::ok) return status;
        if (!leave_out_large(stages)) return Status::too_many_handles;
        for (std::size_t n = 0; n < stages.size() && status == Status::ok; ++n) {
            const double from = 0.1 + 0.85 * double(n) / double(stages.size()),
                         to = 0.1 + 0.85 * double(n + 1) / double(stages.size());
            status = run_stage(frame, stages, n, running.subtask(from, to));
            if (report_.ended != WrapReport::End::stages) break;
        }
        if (status == Status::ok && refines() && lattice_) {
            report_.ended = WrapReport::End::stages;
            status = refine_contacts(*lattice_, running.subtask(0.95, 0.99));
        }
        if (status != Status::ok && status != Status::cancelled) return status;
        measure();
        has_result_ = true;
        if (status == Status::ok && (report_.unmatched_source > 0.5 || report_.unmatched_target > 0.5))
            status = Status::fit_not_reached;
        return running.end(status);
    }

    /// Converts the poses to the space of the target. Writes nothing if there is no pose.
    template <class T>
    void write(Wrap<T>& wrap) const {
        if (!has_result_ || !frame_) return;
        const Similarity back = frame_->unit.inverse();
        if (cage_ == nullptr) {
            wrap.first = transform_of<T>(frame_->first);
        } else {
            const std::vector<Point> rest = unit_cage(*frame_);
            const auto& pose = is_undone_ || cage_pose_.empty() ? rest : cage_pose_;
            for (std::size_t i = 0; i < pose.size(); ++i)
                wrap.pose.push_back(
                    vec_cast<T>(cage_->is_point[i] != 0 ? back(pose[i]) : back.linear(pose[i])));
        }
        if (!lattice_ || is_undone_) return;
        Transform<T, 3> box = transform_of<T>(back);
        for (std::size_t k = 0; k < 3; ++k) box.columns[k] = T(lattice_->extent()[k]) * box.columns[k];
        box.translation = vec_cast<T>(back(lattice_->lower()));
        wrap.lattice.emplace(lattice_->axes(), box);
        for (const Point& p : lattice_pose_) wrap.lattice_pose.push_back(vec_cast<T>(back(p)));
    }

private:
    template <class T>
    static Transform<T, 3> transform_of(const Similarity& of) noexcept {
        const Transform<double, 3> from = of.transform();
        Transform<T, 3> to{{}, vec_cast<T>(from.translation)};
        for (std::size_t k = 0; k < 3; ++k) to.columns[k] = vec_cast<T>(from.columns[k]);
        return to;
    }
    Status refuse(Status status, std::size_t culprit) noexcept {
        report_.culprit = culprit;
        return status;
    }
    Status check() {
        for (const bool of_target : {false, true}) {
            report_.of_target = of_target;
            const Status status = check_surface(of_target ? target_ : source_, report_.culprit);
            if (status != Status::ok) return status;
        }
        report_.of_target = false;
        for (std::size_t n = 0; n < options_.landmarks.size(); ++n) {
            const Landmark& mark = options_.landmarks[n];
            if (!is_finite(mark.from) || !is_finite(mark.to) || !is_finite(mark.weight))
                return refuse(Status::value_not_finite, n);
            if (!(mark.weight > 0)) return refuse(Status::weights_not_positive, n);
        }
        for (std::size_t n = 0; n < options_.follow.size(); ++n) {
            if (!is_finite(options_.follow[n])) return refuse(Status::value_not_finite, n);
        }
        bool are_options_valid =
            options_.samples > 0 && options_.floor >= 0 && options_.floor < 1 && options_.residual >= 0;
        for (const WrapOptions::Stage& stage : wrap_stages(options_, cage_ != nullptr)) {
            are_options_valid = are_options_valid && stage.normal_length >= 0 &&
                                is_finite(stage.normal_length) && stage.cells <= 96 &&
                                (stage.cells > 0 || cage_ != nullptr);
            for (const double x : stage.stiffness)
                are_options_valid = are_options_valid && x > 0 && is_finite(x);
        }
        return are_options_valid ? Status::ok : Status::value_not_finite;
    }

    /// Converts the source, the followers near it, and the landmarks to the units of the wrap.
    Status set_points(const WrapFrame& frame) {
        constexpr double reach = 1, most = 1e4;
        const Similarity of_source = frame.unit.after(frame.first);
        for (const Point& p : source_.vertices()) scene_.source.rest.push_back(of_source(p));
        const auto box = bounds_of(std::span<const Point>(scene_.source.rest));
        if (!(box.diagonal() < most)) return Status::too_many_handles;
        const auto is_near = [&](const Point& p, double distance) {
            return is_finite(p) && box.widened(distance).covers({p, p});
        };
        for (const Point& p : options_.follow) {
            if (is_near(of_source(p), reach)) scene_.followers.rest.push_back(of_source(p));
        }
        report_.far_followers = options_.follow.size() - scene_.followers.size();
        scene_.source_faces.assign(source_.faces().begin(), source_.faces().end());
        double weights = 0;
        for (const Landmark& mark : options_.landmarks) weights += mark.weight;
        for (std::size_t n = 0; n < options_.landmarks.size(); ++n) {
            const Landmark& mark = options_.landmarks[n];
            scene_.marks.rest.push_back(of_source(mark.from));
            scene_.mark_targets.push_back(frame.unit(mark.to));
            scene_.mark_weights.push_back(mark.weight / weights);
            if (!is_near(scene_.marks.rest.back(), most) || !is_near(scene_.mark_targets.back(), most))
                return refuse(Status::value_not_finite, n);
        }
        return Status::ok;
    }
    ///   spacing  of the samples at first; they become fewer if there are more than the options allow
    Status set_scene(const WrapFrame& frame, double spacing, const Running& running) {
        constexpr double least_noise = 1e-3;
        std::vector<Point> target;
        for (const Point& p : target_.vertices()) target.push_back(frame.unit(p));
        scene_.target = ClosestPlaces(target, target_.faces());
        report_.skipped_faces = scene_.target.skipped_faces();
        choose_back_places(scene_, target_.faces());
        const ClosestPlaces source(scene_.source.rest, scene_.source_faces);
        GridSamples samples;
        scene_.shell = 2 * spacing;
        Status status = sample_shell(scene_, source, spacing, running.subtask(0, 0.5), samples);
        while (status == Status::ok && samples.places.size() > options_.samples) {
            spacing *= (std::max)(1.01, std::cbrt(double(samples.places.size()) / double(options_.samples)));
            samples = {};
            status = sample_shell(scene_, source, spacing, running.subtask(0.5, 1), samples);
        }
        if (status != Status::ok) return status;
        if (cage_ != nullptr) status = keep_reached(frame, samples);
        if (status != Status::ok) return status;
        scene_.samples.rest = std::move(samples.places);
        scene_.neighbours = std::move(samples.neighbours);
        report_.samples = scene_.samples.rest.size();
        find_guarded(source);
        for (MovedPoints* points : {&scene_.source, &scene_.followers, &scene_.samples, &scene_.marks})
            points->start();
        report_.start = scene_.target.distances(scene_.source.rest);

        std::vector<double> edges;
        for (const auto& f : target_.faces()) {
            const auto e = target[f[1]] - target[f[0]];
            edges.push_back(std::sqrt(dot(e, e)));
        }
        const double edge = quantile(edges, 0.5);
        const double noise = surface_noise(target, scene_.target.normals(), edge, shuffled(target.size()));
        report_.noise = noise > least_noise ? noise : 0;
        return Status::ok;
    }
    /// Removes samples where the cage has no derivatives, as outside the cage of harmonic coordinates.
    Status keep_reached(const WrapFrame& frame, GridSamples& samples) const {
        DenseRows rows;
        const Status status = unit_evaluate(frame)(samples.places, true, rows);
        if (status != Status::ok) return status;
        std::vector<std::uint32_t> number(samples.places.size(), no_vertex);
        GridSamples kept;
        for (std::size_t n = 0; n < number.size(); ++n) {
            const auto of = std::span(rows.weights).subspan(3 * n * rows.handles, 3 * rows.handles);
            if (std::all_of(of.begin(), of.end(), [](double w) { return w == 0; })) continue;
            number[n] = std::uint32_t(kept.places.size());
            kept.places.push_back(samples.places[n]);
        }
        for (const auto& [a, b] : samples.neighbours) {
            if (number[a] != no_vertex && number[b] != no_vertex)
                kept.neighbours.push_back({number[a], number[b]});
        }
        samples = std::move(kept);
        return samples.places.empty() ? Status::samples_missing : Status::ok;
    }
    void find_guarded(const ClosestPlaces& source) {
        for (std::uint32_t i = 0; i < scene_.followers.rest.size(); ++i) {
            const Point& p = scene_.followers.rest[i];
            const ClosestPlaces::Place at = source.find(p);
            const auto corner =
                std::size_t(std::max_element(at.weights.begin(), at.weights.end()) - at.weights.begin());
            const std::uint32_t vertex = scene_.source_faces[at.face][corner];
            const auto away = p - scene_.source.rest[vertex];
            if (dot(p - at.place, at.normal) > 0 && dot(away, source.normals()[vertex]) > 0)
                scene_.guarded.push_back({i, vertex});
        }
    }

    Bounds<double, 3> lattice_box() const {
        Bounds<double, 3> box = bounds_of(std::span<const Point>(scene_.samples.now));
        for (const MovedPoints* points : {&scene_.source, &scene_.followers, &scene_.marks}) {
            if (points->size() > 0) box.include(bounds_of(std::span<const Point>(points->now)));
        }
        return box;
    }
    /// Removes lattices with too many handles near samples. Returns false if none remains, and no cage.
    bool leave_out_large(std::vector<WrapOptions::Stage>& stages) {
        const auto box = lattice_box();
        const bool begins_with_lattice = !stages.empty() && stages.front().cells > 0;
        std::erase_if(stages, [&](const WrapOptions::Stage& stage) {
            if (stage.cells == 0) return false;
            if (!is_too_large(options_, stage.cells, box) &&
                lattice_handles(box, stage.cells) <= options_.handles)
                return false;
            if (report_.left_out == 0) report_.left_out = stage.cells;
            return true;
        });
        return !(begins_with_lattice && stages.empty());
    }
    /// Returns the number of handles near samples.
    std::size_t lattice_handles(const Bounds<double, 3>& box, unsigned cells) const {
        const WrapLattice lattice(box, 1.0 / cells);
        LatticeRows rows;
        (void)lattice.weights(scene_.samples.now, rows);
        std::vector<char> is_used(lattice.size());
        for (std::size_t n = 0; n < rows.size(); ++n)
            rows.for_each(n, [&](std::size_t i, double /*w*/) { is_used[i] = 1; });
        return std::size_t(std::count(is_used.begin(), is_used.end(), char{1}));
    }
    Status run_stage(const WrapFrame& frame, const std::vector<WrapOptions::Stage>& stages, std::size_t n,
                     const Running& running) {
        WrapStageOptions options{stages[n], options_.floor, options_.residual};
        options.is_last = n + 1 == stages.size();
        options.noise = options.is_last ? report_.noise : 0;
        if (options.is_last && stages[n].cells > 0) options.vertices = scene_.source.size();
        options.first_by_landmarks = n == 0 && options_.other_pose && !options_.landmarks.empty();
        options.guards_followers = n > 0;
        if (stages[n].cells == 0) {
            cage_pose_ = unit_cage(frame);
            const WrapCage basis(cage_pose_, unit_evaluate(frame));
            return run_basis(basis, options, cage_pose_, running, true);
        }
        if (!lattice_) {
            lattice_.emplace(lattice_box(), 1.0 / stages[n].cells);
            lattice_pose_ = lattice_->rest();
        }
        WrapLattice& lattice = *lattice_;
        while (lattice.cell() > 1.01 / stages[n].cells) lattice.refine(lattice_pose_);
        return run_basis(lattice, options, lattice_pose_, running, options.is_last && !refines());
    }
    bool refines() const noexcept { return options_.refine_contacts && cage_ == nullptr; }
    /// Halves the cells of the lattice near vertices that are off the target, with finer samples there. All
    /// other handles are held.
    Status refine_contacts(WrapLattice& lattice, const Running& running) {
        constexpr double off = 0.002, reach = 0.04, spacing = 1.0 / 100;
        WrapStageOptions options{{2 * unsigned(std::lround(1 / lattice.cell())), {1e-7}, 0.03},
                                 options_.floor};
        options.is_last = true;
        LatticeRows rows;
        if (const Status status = lattice.weights(scene_.source.now, rows); status != Status::ok)
            return status;
        std::vector<Point> places;
        scene_.target.set_normal_length(0);
        std::uint32_t guess = no_vertex;
        for (std::size_t i = 0; i < scene_.source.size(); ++i) {
            const Point moved = rows.product(i, lattice_pose_);
            const ClosestPlaces::Place at = scene_.target.find(moved, {}, guess);
            guess = at.face;
            if (dot(moved - at.place, moved - at.place) > off * off) places.push_back(scene_.source.now[i]);
        }
        WrapStageSolver<WrapLattice> finisher(scene_, lattice, options, running);
        if (places.empty()) return finisher.finish(lattice_pose_);
        lattice.refine(lattice_pose_);
        const NearPoints near_places(places);
        std::vector<char> is_free;
        is_free.reserve(lattice.size());
        for (const Point& p : lattice.rest()) is_free.push_back(near_places.has(p, reach) ? 1 : 0);
        if (std::size_t(std::count(is_free.begin(), is_free.end(), char{1})) > options_.handles) {
            report_.left_out = options.stage.cells;
            return finisher.finish(lattice_pose_);
        }
        options.free_handles = &is_free;
        GridSamples fine;
        const double wide = reach + 2 * lattice.cell();
        const auto box = bounds_of(std::span<const Point>(places)).widened(wide);
        const auto make_test = [&] { return [&](const Point& p) { return near_places.has(p, wide); }; };
        Status status = sample_grid(box, spacing, make_test, running.subtask(0, 0.1), fine);
        if (status != Status::ok) return status;
        MovedPoints samples = std::exchange(scene_.samples, {std::move(fine.places), {}, {}});
        auto neighbours = std::exchange(scene_.neighbours, std::move(fine.neighbours));
        scene_.samples.start();
        status = run_basis(lattice, options, lattice_pose_, running.subtask(0.1, 1), false);
        scene_.samples = std::move(samples);
        scene_.neighbours = std::move(neighbours);
        if (status != Status::ok && status != Status::cancelled) return status;
        const Status moved = finisher.finish(lattice_pose_);
        return moved != Status::ok ? moved : status;
    }
    template <class Basis>
    Status run_basis(const Basis& basis, const WrapStageOptions& options, std::vector<Point>& pose,
                     const Running& running, bool is_finished) {
        WrapStageSolver<Basis> solver(scene_, basis, options, running);
        const Status status = solver.run(pose, report_, report_.ended);
        const bool ends = is_finished || status == Status::cancelled ||
                          (report_.ended != WrapReport::End::stages && !refines());
        if (ends && (status == Status::ok || status == Status::cancelled)) {
            const Status moved = solver.finish(pose);
            if (moved != Status::ok) return moved;
        }
        return status;
    }

    std::vector<Point> unit_cage(const WrapFrame& frame) const {
        const Similarity of_source = frame.unit.after(frame.first);
        std::vector<Point> rest;
        rest.reserve(cage_->rest.size());
        for (std::size_t i = 0; i < cage_->rest.size(); ++i)
            rest.push_back(cage_->is_point[i] != 0 ? of_source(cage_->rest[i])
                                                   : of_source.linear(cage_->rest[i]));
        return rest;
    }
    /// Evaluates the cage at points in the units of the wrap.
    EvaluateCage unit_evaluate(const WrapFrame& frame) const {
        const Similarity back = frame.unit.after(frame.first).inverse();
        return [this, back](std::span<const Point> points, bool derivatives, DenseRows& rows) {
            std::vector<Point> places;
            for (const Point& p : points) places.push_back(back(p));
            const Status status = cage_->evaluate(places, derivatives, rows);
            if (status != Status::ok || !derivatives) return status;
            const auto axes = back.transform().columns;
            for (std::size_t n = 0; n < points.size(); ++n) {
                for (std::size_t i = 0; i < rows.handles; ++i) {
                    Point g;
                    for (std::size_t c = 0; c < 3; ++c) g[c] = rows.weights[(3 * n + c) * rows.handles + i];
                    for (std::size_t k = 0; k < 3; ++k)
                        rows.weights[(3 * n + k) * rows.handles + i] = dot(axes[k], g);
                }
            }
            return Status::ok;
        };
    }

    void measure() {
        scene_.target.set_normal_length(0);
        report_.to_target = scene_.target.distances(scene_.source.now);
        if (report_.to_target.mean > report_.start.mean) return_to_start();
        const ClosestPlaces wrapped(scene_.source.now, scene_.source_faces);
        std::vector<Point> used;
        for (std::size_t i = 0; i < scene_.target.vertices().size(); ++i) {
            const Point& normal = scene_.target.normals()[i];
            if (dot(normal, normal) > 0) used.push_back(scene_.target.vertices()[i]);
        }
        report_.to_source = wrapped.distances(used);
        for (std::size_t n = 0; n < scene_.marks.size(); ++n) {
            const auto d = scene_.marks.now[n] - scene_.mark_targets[n];
            if (report_.missed != WrapReport::none && !(dot(d, d) > report_.miss * report_.miss)) continue;
            report_.miss = std::sqrt(dot(d, d));
            report_.missed = n;
        }
        report_.folded_vertices = add_stretches(scene_.source);
        report_.folded_followers = add_stretches(scene_.followers);
        report_.folded_samples = add_stretches(scene_.samples);
    }
    std::size_t add_stretches(const MovedPoints& points) {
        std::size_t folded = 0;
        for (const auto& j : points.jacobians) {
            const Vec<double, 2> squares = squared_stretches(j);
            if (squares[1] == 0) continue; // the cage does not reach this point
            folded += determinant(j) > 0 ? 0 : 1;
            report_.least_stretch =
                (std::min)(report_.least_stretch, std::copysign(std::sqrt(squares[0]), determinant(j)));
            report_.largest_stretch = (std::max)(report_.largest_stretch, std::sqrt(squares[1]));
        }
        return folded;
    }
    /// A fit that is worse than the start is undone.
    void return_to_start() {
        for (MovedPoints* points : {&scene_.source, &scene_.followers, &scene_.samples, &scene_.marks})
            points->start();
        report_.to_target = report_.start;
        is_undone_ = true;
    }

    const SurfaceMesh &source_, &target_;
    const WrapOptions& options_;
    const WrapCageInput* cage_;
    WrapReport& report_;
    WrapScene scene_;
    std::vector<Point> cage_pose_, lattice_pose_; ///< in the units of the wrap
    std::optional<WrapLattice> lattice_;
    std::optional<WrapFrame> frame_;
    bool is_undone_ = false, has_result_ = false;
};

template <class T>
Status find_wrap(const WrapInput& input, const Running& running, Result<Wrap<T>, WrapReport>& result) {
    WrapFinder finder(input, result.report);
    const Status status = finder.run(running);
    finder.write(result.value);
    return status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail
