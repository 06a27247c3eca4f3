// Deforms a scene of 3D Gaussian splatting by a pose of a cage, of a lattice or of points.
//
//     deform_splats scene.ply --cage lattice:8x8x8 --twist all:y,0,2,90 -o twisted.ply
//     deform_splats scene.ply --cage auto:60 --split 2 -o look.ply --report
//     deform_splats scene.ply --cage cage.obj --pose pose.obj --coordinates harmonic -o posed.ply
//
// With the Jacobian J of the deformation, a covariance Σ becomes J Σ Jᵀ, and view-dependent colours rotate by
// the rotation of J. The opacity does not change.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/mesh_control.hpp"
#include "cli/progress_bar.hpp"
#include "files/bind_report.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "splats/posed_splats.hpp"
#include "splats/splat_file.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/jacobians.hpp>
#include <cageform/parallel/threads.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string scene, out;
    MeshControlChoice control;
    double split = 0; // 0: no splits
    std::size_t threads = 0;
    bool strict = false, report = false;
};

constexpr std::size_t most_bytes = std::size_t{16} << 20; // of weights per batch, so that they stay in cache
constexpr std::size_t grain = 256;                        // splats per task
constexpr int most_splits = 6;                            // per splat

/// Adds the seconds of its lifetime.
class Clock {
public:
    explicit Clock(double& seconds)
        : seconds_(seconds) {}
    Clock(const Clock&) = delete;
    Clock& operator=(const Clock&) = delete;
    ~Clock() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    double& seconds_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Whether all three fit single precision, the format of files.
bool is_float(const Point3& p) {
    return std::all_of(p.v, p.v + 3, [](double x) { return std::isfinite(float(x)); });
}

struct Seconds {
    double read = 0, control = 0, bind = 0, frame = 0, write = 0;
};

/// Triangles that represent splats for make_cage: in the plane of the two longest axes, with corners at one
/// standard deviation.
MeshFile triangles_of(const SplatFile& scene) {
    MeshFile mesh;
    mesh.name = scene.name;
    mesh.vertices.reserve(3 * scene.size());
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const auto [row, place, factor, size, opacity] = part_of(scene, i);
        std::array<std::size_t, 3> axes{0, 1, 2};
        std::sort(axes.begin(), axes.end(), [&axis = factor](std::size_t a, std::size_t b) {
            return dot(axis[a], axis[a]) > dot(axis[b], axis[b]);
        });
        const auto first = std::uint32_t(mesh.vertices.size());
        for (const auto& [along, across] : {std::pair{1.0, 0.0}, {-0.5, 0.866}, {-0.5, -0.866}})
            mesh.vertices.push_back(place + along * factor[axes[0]] + across * factor[axes[1]]);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

/// Binds and moves splats, in batches.
class SplatMover {
public:
    SplatMover(const Arguments& given, const MeshControl& control, SplatFile& scene, Seconds& seconds)
        : given_(given)
        , control_(control)
        , scene_(scene)
        , seconds_(seconds)
        , options_(given.control.outside.bind_options(control.coordinates))
        , handles_(control.handles)
        , threads_{unsigned(given.threads)} {
        report.cage = control.coordinates.cage_report();
    }

    /// Moves all splats. Stops if `fault` is not empty or the status of the report is not ok.
    void move() {
        ProgressBar bar("binding");
        const cageform::Running running{.parallel = threads_, .progress = bar.callback()};
        {
            const Clock clock(seconds_.bind);
            const auto evaluation = control_.coordinates.solve(running.subtask(0, 0.3));
            report.status = evaluation.status;
            report.solver = evaluation.solver;
        }
        const std::size_t count = scene_.size();
        const std::size_t most = batch_size();
        for (std::size_t first = 0; first < count && is_well(); first += most) {
            std::vector<SplatPart> batch(std::min(most, count - first));
            threads_(batch.size(), grain, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) batch[i] = part_of(scene_, first + i);
            });
            move_batch(batch, first, running);
            (void)running.keep_going(0.3 + 0.7 * double(first) / double(count));
        }
        for (int n = 0; n < most_splits && !parts_.empty(); ++n) {
            is_last_split_ = n + 1 == most_splits;
            const std::vector<SplatPart> parts = std::move(parts_);
            parts_.clear();
            for (std::size_t first = 0; first < parts.size() && is_well(); first += most) {
                const auto begin = parts.begin() + std::ptrdiff_t(first);
                move_batch({begin, begin + std::ptrdiff_t(std::min(most, parts.size() - first))}, first,
                           running);
            }
        }
    }

    cageform::BindReport report; // of splats, not of parts
    std::string fault, warning;
    std::size_t split = 0; // number of split splats
    cageform::Extreme stretch;

private:
    bool is_well() const { return fault.empty() && report.status == cageform::Status::ok; }

    std::size_t batch_size() const {
        constexpr std::size_t bindings = 4; // the position and three axes
        return most_bytes / (bindings * sizeof(double) * (control_.coordinates.handles().count + 1)) + 1;
    }

    /// Moves splats or parts of splats.
    ///
    ///   first   index of the first splat
    void move_batch(const std::vector<SplatPart>& batch, std::size_t first,
                    const cageform::Running& running) {
        std::vector<Point3> places(batch.size());
        std::transform(batch.begin(), batch.end(), places.begin(),
                       [](const auto& part) { return part.place; });
        std::vector<Matrix3> jacobians(batch.size());
        if (!bind(places, jacobians, first, batch, running)) return;
        const Clock clock(seconds_.frame);
        std::vector<SingularValues> posed(batch.size());
        std::vector<double> stretches(batch.size());
        threads_(batch.size(), grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const auto& j = jacobians[i];
                stretches[i] = HUGE_VAL;
                if (!is_float(places[i]) || !is_float(j[0]) || !is_float(j[1]) || !is_float(j[2])) continue;
                posed[i] = posed_shape(batch[i], j);
                stretches[i] = stretch_of(batch[i], posed[i]);
                if (!splits(stretches[i])) write_posed(scene_, batch[i], places[i], j, posed[i]);
            }
        });
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const SplatPart& part = batch[i];
            if (!std::isfinite(stretches[i])) {
                fault = scene_.name + ": splat " + std::to_string(part.row) +
                        " (counted from 0) leaves the range of single precision in the pose";
                return;
            }
            if (part.opacity >= 1) stretch.raise({stretches[i], first + i});
            if (splits(stretches[i])) cut(part, posed[i]);
        }
    }

    bool splits(double length) const {
        return std::isinf(length) || (given_.split > 0 && length > given_.split && !is_last_split_);
    }

    /// Queues the halves of a part.
    void cut(const SplatPart& part, const SingularValues& posed) {
        split += part.opacity >= 1 ? 1 : 0;
        const std::size_t bytes = scene_.layout.row_bytes, from = part.row * bytes;
        const auto halves = halves_of(part, posed, scene_.size());
        parts_.insert(parts_.end(), halves.begin(), halves.end());
        scene_.rows += scene_.rows.substr(from, bytes);
    }

    /// Clones positions; false on failure.
    bool bind(std::vector<Point3>& places, std::vector<Matrix3>& jacobians, std::size_t first,
              const std::vector<SplatPart>& batch, const cageform::Running& running) {
        const auto& coordinates = control_.coordinates;
        const cageform::Running silent{.parallel = running.parallel};
        cageform::Result<cageform::Binding<double, 3>, cageform::BindReport> bound;
        cageform::Result<std::array<cageform::Binding<double, 3>, 3>, cageform::BindReport> axes;
        {
            const Clock clock(seconds_.bind);
            bound = coordinates.bind(places, options_, silent);
            if (batch[0].opacity >= 1) {
                if (first == 0) report.solver = bound.report.solver;
                add_batch(report, bound.report, first);
            }
            report.status = bound.report.status;
            if (report.status != cageform::Status::ok) return false;
            axes = coordinates.bind_jacobians(places, options_, silent);
            report.status = axes.report.status;
            if (report.status != cageform::Status::ok) return false;
        }
        if (handles_.empty()) {
            const auto& pose = control_.pose;
            auto posed = pose_of_handles(bound.value, pose.vertices, pose.name, warning);
            if (!posed) {
                fault = to_string(posed.error());
                return false;
            }
            handles_ = std::move(*posed);
        }
        const Clock clock(seconds_.frame);
        auto status = cageform::clone(bound.value, handles_, places, {}, threads_);
        if (status == cageform::Status::ok) {
            const cageform::StridedMatrices<double, 3> matrices(jacobians[0][0].v, jacobians.size());
            status = cageform::clone_jacobians(axes.value, handles_, matrices, threads_);
        }
        if (status != cageform::Status::ok) fault = control_.pose.name + ": " + cageform::to_string(status);
        return status == cageform::Status::ok;
    }

    const Arguments& given_;
    const MeshControl& control_;
    SplatFile& scene_;
    Seconds& seconds_;
    cageform::BindOptions options_;
    std::vector<Point3> handles_; // pose of all handles
    cageform::ThreadedFor threads_;
    std::vector<SplatPart> parts_; // queue of parts to move
    bool is_last_split_ = false;
};

std::string words_of(const Arguments& given, const SplatMover& mover, const SplatFile& scene,
                     std::size_t splats, const Seconds& seconds) {
    const auto& [read, control, bind, frame, write] = seconds;
    const auto number = [](double x) { return detail::short_number(x); };
    std::string text = "splats: " + std::to_string(splats) + " of degree " +
                       std::to_string(scene.layout.degree()) + ", " + std::to_string(scene.layout.row_bytes) +
                       " bytes each\n";
    if (!scene.others.empty()) text += "unchanged: " + scene.others + '\n';
    if (mover.stretch.point != cageform::Extreme::none)
        text += "longest: " + number(mover.stretch.value) + " times its length at rest, splat " +
                std::to_string(mover.stretch.point) + "\n";
    if (given.split > 0)
        text += "split: " + std::to_string(mover.split) + " splats, which are " +
                std::to_string(scene.size() - splats + mover.split) + " now\n";
    return text + "seconds: read " + number(read) + ", cage and pose " + number(control) + ", bind " +
           number(bind) + ", frame " + number(frame) + ", write " + number(write) + "\n";
}

int deform_scene(const Arguments& given, SplatFile& scene, Seconds& seconds) {
    const std::size_t splats = scene.size();
    std::vector<Point3> places(splats);
    for (std::size_t i = 0; i < splats; ++i) places[i] = scene.place(i);
    const MeshControl control = [&] {
        const Clock clock(seconds.control);
        const CageChoice word = CageChoice::of(given.control.cage);
        const bool is_made = word.is_auto || word.is_lattice;
        return read_mesh_control(given.control, is_made ? triangles_of(scene) : MeshFile{}, places);
    }();
    fail_if(given.control.save_fault(control));
    fail_if(fault_of_outputs({given.out, given.control.save_pose}));
    const auto& [coordinates, cage] = std::tie(control.coordinates, control.cage);
    print_notes(cage.name, coordinates.cage_report(), coordinates.note);

    SplatMover mover(given, control, scene, seconds);
    mover.move();
    fail_if(mover.fault);
    if (mover.report.status != cageform::Status::ok) return fail(control.describe_faults(mover.report));
    warn_of_coarse_grid(cage.name, mover.report.solver);
    given.control.outside.check(coordinates, mover.report, places, scene.name, cage.name);
    warn(mover.warning);

    {
        const Clock clock(seconds.write);
        OutputFiles outputs;
        AtomicFile& out = outputs.add(given.out);
        out.write(scene.header_text(scene.size()));
        out.write(scene.before);
        out.write(scene.rows);
        out.write(scene.after);
        if (!given.control.save_pose.empty())
            outputs.add(given.control.save_pose).write(control.saved_pose());
        fail_if(outputs.commit());
    }
    if (given.report)
        std::cout << words_of(given, mover, scene, splats, seconds) << describe(mover.report)
                  << control.on_pins;
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Deforms a scene of 3D Gaussian splatting by a pose of a cage, of a lattice or of "
                     "points. Splats move, rotate and stretch, and view-dependent colours rotate.");
    line.set_examples({"scene.ply --cage lattice:8x8x8 --twist all:y,0,2,90 -o twisted.ply",
                       "scene.ply --cage auto:60 --split 2 -o look.ply --report",
                       "scene.ply --cage cage.obj --pose pose.obj --coordinates harmonic -o posed.ply"});
    Arguments given;
    line.add("scene", given.scene, "the PLY file of splats to deform").required();
    given.control.add_options(line);
    line.add("-o,--output", given.out, "the PLY file to write").required().ends_with({".ply"});
    line.add("--split", given.split,
             "split splats that become more than this factor longer than at rest, recursively up to six "
             "times. Splits follow bends and keep mass, mean and covariance. 0: no splits")
        .check([](const std::string& word) {
            double bound = 0;
            const bool is_number = detail::parse_number(word, bound).empty();
            return is_number && (bound == 0 || (bound >= 1.01 && bound <= 1e9))
                       ? std::string()
                       : detail::quoted(word) + " is neither 0 nor a number from 1.01 to 1e9";
        })
        .show_default("0");
    given.control.outside.has_splats = true;
    given.control.outside.add_options(line);
    given.control.of_sites.with_weights = false; // weighted sites have no gradients
    given.control.of_sites.add_options(line);
    line.add("--threads", given.threads, "the number of threads; 0: all processors")
        .range(0, 1024)
        .show_default()
        .rarely_needed();
    line.add_flag("--strict", given.strict, "refuse a scene with invalid splats");
    line.add_flag("--report", given.report,
                  "print the numbers of splats and splits, the seconds and the bind report");
    given.control.choice.add_options(line);
    line.set_footer(splat_format + std::string("\n") + mesh_formats + "\n" + lattice_format + "\n" +
                    pose_operations_format + "\n" + pins_format + "\n" + site_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    fail_if(given.control.fault());

    Seconds seconds;
    auto scene = [&] {
        const Clock clock(seconds.read);
        return load_splats(given.scene, given.strict);
    }();
    if (!scene) return fail(to_string(scene.error()));
    if (!scene->warning.empty()) warn(scene->warning);
    return deform_scene(given, *scene, seconds);
}
