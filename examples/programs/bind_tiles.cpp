// Binds files of points (tiles) to one cage and packs each into a figure, as bind_mesh does with a mesh.
// Tiles are read and written in pieces and can have any size. Memory is bounded and printed before the start.
//
//     bind_tiles cage.obj --points 'tiles/*.ply' -o 'out/*.figure' --largest 16 --format half
//     bind_tiles cage.obj --points 'tiles/*.ply' -o 'out/*.figure' --rows 0:100 --threads 4
//     bind_tiles cage.obj --points scan.ply -o scan.figure --coordinates harmonic --solution cage.solution
//
// Tiles are sorted by name; --rows selects those of this process. A figure depends only on its tile and the
// options, not on other tiles, threads, memory or rows. If a complete figure of the same points and options
// exists, its tile is skipped, so a farm can restart any task.
//
// Exit status 0: all tiles are done. 1: invalid options, or a tile that cannot be bound. 75: a temporary
// failure such as a full disk; try again. A failing tile does not stop the others.

#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/motion_choice.hpp"
#include "cli/progress_bar.hpp"
#include "cli/tile_list.hpp"
#include "cli/weight_choice.hpp"
#include "files/bind_report.hpp"
#include "files/figure_stream.hpp"
#include "files/point_file.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"
#include "io/messages.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/parallel/threads.hpp>

#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <iostream>
#include <mutex>
#include <sstream>
#include <thread>

namespace {

using namespace cageform_support;
using cageform::Status;
using Point = cageform::Vec<float, 3>;

struct Arguments {
    std::string cage, solution, saved_solution;
    TileChoice tiles;
    MotionChoice moves;
    WeightChoice weights; // distance relative to the cage's size
    OutsideChoice outside;
    CoordinatesChoice choice;
    std::size_t memory = 2048, threads = 1; // memory in MB
    bool json = false, is_strict = false;
};

/// Shared, immutable data of all tiles.
struct Job {
    ChosenCoordinates<float, 3> coordinates;
    std::string cage, outside;
    double size = 0; // of the cage: the diagonal of its box
    cageform::BindOptions bind;
    cageform::PackOptions pack;
    std::vector<double> poses;
    std::uint64_t parameters = 0; // hash of everything except the points that affects the output
    std::size_t piece = 0;        // points per batch
    bool is_strict = false;       // whether non-finite points are an error
};

/// The number of points per batch. It depends only on the cage, because it affects the output.
std::size_t points_of_piece(std::size_t handles) {
    constexpr std::size_t weights = std::size_t{32} << 20, most = 65536, whole = 1024;
    const std::size_t points = weights / (sizeof(float) * std::max<std::size_t>(handles, 1));
    return std::clamp(points / whole * whole, whole, most);
}

/// Peak memory per tile in bytes: weights of a batch, bound and packed; its points in all representations;
/// the table of products of handles.
std::size_t bytes_of_tile(std::size_t piece, std::size_t handles) {
    constexpr std::size_t of_point = 400, of_files = std::size_t{4} << 20;
    return piece * (2 * sizeof(float) * handles + of_point) + handles * handles * sizeof(double) + of_files;
}

/// Result of one tile.
struct Outcome {
    TileRecord record;
    std::uint64_t bytes = 0; // of the figure
    double seconds = 0;
    bool was_done = false;
    std::uint64_t first_not_finite = 0;
    std::string error; // empty: none
    bool may_retry = false;
};

/// "3 points, first number 17 counted from 0,": invalid points in a message.
std::string points_at(const std::vector<std::size_t>& points, std::uint64_t first) {
    return std::to_string(points.size()) + (points.size() == 1 ? " point" : " points") + ", first number " +
           std::to_string(first + points[0]) + " counted from 0,";
}

/// Returns why a batch cannot be bound; empty if it can.
///
///   first  index of its first point in the tile
std::string fault_of_piece(const Job& job, const cageform::BindReport& report, std::uint64_t first) {
    if (report.status != Status::ok) return describe_mesh_faults(job.cage, report);
    if (!report.not_finite.empty() && job.is_strict)
        return points_at(report.not_finite, first) + " are not finite in float";
    if (!report.outside.empty() && job.outside == "refuse")
        return points_at(report.outside, first) + " lie outside the cage " + job.cage +
               "; use --outside to choose their treatment";
    if (!report.outside.empty() && job.outside == "extend" && !job.coordinates.has_extension())
        return points_at(report.outside, first) + " lie outside the cage " + job.cage +
               ", where these coordinates are not defined";
    if (!report.unreached.empty())
        return points_at(report.unreached, first) + " get no weights: " +
               (job.coordinates.closed_form() ? "they are too far from the cage"
                                              : "the grid is too coarse; raise --resolution");
    return {};
}

/// Binds and packs one tile.
class TileBinder {
public:
    TileBinder(const Job& job, const Tile& tile)
        : job_(job)
        , tile_(tile) {}

    Outcome run() {
        const auto start = std::chrono::steady_clock::now();
        try {
            if (!is_done()) bind();
        } catch (const std::bad_alloc&) {
            refuse("out of memory: use fewer --threads", true);
        } catch (const std::exception& error) {
            refuse(error.what(), false);
        }
        outcome_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return std::move(outcome_);
    }

private:
    void refuse(const std::string& why, bool may_retry) {
        outcome_.error = why;
        outcome_.may_retry = may_retry;
    }

    /// Whether a complete figure of these points and options exists.
    bool is_done() {
        std::error_code none;
        if (!std::filesystem::is_regular_file(tile_.output, none)) return false;
        const auto record = read_tile_record(tile_.output);
        if (!record || record->parameters_hash != job_.parameters) return false;
        InputFile points(tile_.points);
        if (points.hash_to_end() != record->points_hash) return false;
        if (record->not_finite > 0 && job_.is_strict) return false;
        outcome_.record = *record;
        outcome_.bytes = std::filesystem::file_size(tile_.output, none);
        return outcome_.was_done = true;
    }

    void bind() {
        PointFile points(tile_.points);
        if (!points.error().empty()) return refuse(points.error(), points.may_retry());
        FigureStream figure(tile_.output);
        std::vector<double> numbers;
        std::vector<Point> piece;
        std::uint64_t first = 0;
        do {
            numbers.clear();
            const std::size_t count = points.read(job_.piece, numbers);
            if (!points.error().empty()) return refuse(points.error(), points.may_retry());
            if (count == 0 && first > 0) break;
            piece.resize(count);
            for (std::size_t n = 0; n < 3 * count; ++n) piece[n / 3][n % 3] = float(numbers[n]);
            if (!append(piece, first, figure)) return;
            first += count;
        } while (piece.size() == job_.piece);
        const auto hash = points.hash_to_end();
        if (!hash) return refuse(points.error(), points.may_retry());
        outcome_.record.points_hash = *hash;
        outcome_.record.parameters_hash = job_.parameters;
        if (!figure.finish(outcome_.record)) return refuse(figure.error(), figure.may_retry());
        outcome_.bytes = figure.bytes();
    }

    bool append(const std::vector<Point>& piece, std::uint64_t first, FigureStream& figure) {
        auto bound = job_.coordinates.bind(piece, job_.bind, std::move(recycled_));
        const std::string why = fault_of_piece(job_, bound.report, first);
        if (!why.empty()) {
            refuse(tile_.points + ": " + why, bound.report.status == Status::out_of_memory);
            return false;
        }
        outcome_.record.outside += bound.report.outside.size();
        const auto& bad = bound.report.not_finite;
        if (outcome_.record.not_finite == 0 && !bad.empty()) outcome_.first_not_finite = first + bad[0];
        outcome_.record.not_finite += bad.size();
        const auto packed = cageform::pack(bound.value, job_.pack);
        if (packed.report.status == Status::format_too_coarse) {
            std::ostringstream least;
            least.precision(3);
            least << packed.report.distance.value / job_.size;
            refuse(tile_.points + ": " + to_string(packed.report.status) + ", " + least.str() +
                       " is the smallest possible: raise --max-distance or choose another --format",
                   false);
            return false;
        }
        if (packed.report.status != Status::ok) {
            refuse(tile_.points + ": " + to_string(packed.report.status),
                   packed.report.status == Status::out_of_memory);
            return false;
        }
        const cageform::Extreme& loss = packed.report.distance;
        if (loss.point != cageform::Extreme::none && loss.value >= outcome_.record.distance) {
            outcome_.record.distance = loss.value;
            outcome_.record.farthest = first + loss.point;
        }
        recycled_ = std::move(bound.value);
        if (figure.append(packed.value.bytes(), piece)) return true;
        refuse(figure.error(), figure.may_retry());
        return false;
    }

    const Job& job_;
    const Tile& tile_;
    Outcome outcome_;
    cageform::Binding<float, 3> recycled_;
};

/// One line of JSON for a tile.
std::string json_of(const Job& job, const Tile& tile, const Outcome& outcome) {
    nlohmann::ordered_json line;
    line["row"] = tile.row;
    line["tile"] = tile.points;
    line["output"] = tile.output;
    line["state"] = !outcome.error.empty() ? "failed" : outcome.was_done ? "was done" : "done";
    line["seconds"] = outcome.seconds;
    if (outcome.error.empty()) {
        line["points"] = outcome.record.points;
        line["bytes"] = outcome.bytes;
        line["weights_a_point"] = outcome.record.weights_per_point;
        line["largest_distance"] = outcome.record.distance;
        line["largest_distance_of_cage"] = outcome.record.distance / job.size;
        line["farthest_point"] = outcome.record.farthest;
        line["outside"] = outcome.record.outside;
        line["not_finite"] = outcome.record.not_finite;
    } else {
        line["error"] = outcome.error;
        line["try_again"] = outcome.may_retry;
    }
    return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string text_of(const Job& job, const Tile& tile, const Outcome& outcome) {
    std::ostringstream line;
    line.precision(3);
    line << printable(tile.points) << ": " << outcome.record.points << " points, " << outcome.bytes
         << " bytes, " << outcome.record.weights_per_point << " weights per point, error at most "
         << outcome.record.distance << " (" << 100 * outcome.record.distance / job.size
         << " % of the cage), ";
    if (outcome.record.outside > 0) line << outcome.record.outside << " outside, ";
    if (outcome.record.not_finite > 0) line << outcome.record.not_finite << " not finite, ";
    if (outcome.was_done)
        line << "was done";
    else
        line << outcome.seconds << " s";
    return line.str();
}

/// Binds tiles in parallel; returns the exit status.
int bind_all(const Job& job, const std::vector<Tile>& tiles, std::size_t threads, bool json) {
    std::atomic<std::size_t> next{0};
    std::mutex lock;
    bool failed = false, passes = false;
    const auto work = [&] {
        for (std::size_t n = next++; n < tiles.size(); n = next++) {
            const Outcome outcome = TileBinder(job, tiles[n]).run();
            const std::lock_guard guard(lock);
            if (!outcome.error.empty()) {
                (void)fail(outcome.error);
                (outcome.may_retry ? passes : failed) = true;
            } else if (outcome.record.not_finite > 0 && !outcome.was_done) {
                warn(tiles[n].points + ": " + std::to_string(outcome.record.not_finite) + " of " +
                     std::to_string(outcome.record.points) +
                     " points are not finite in float, first number " +
                     std::to_string(outcome.first_not_finite) +
                     " counted from 0: no pose moves them; --strict refuses the file");
            }
            if (json)
                std::cout << json_of(job, tiles[n], outcome) << std::endl;
            else if (outcome.error.empty())
                std::cout << text_of(job, tiles[n], outcome) << std::endl;
        }
    };
    std::vector<std::thread> others;
    while (others.size() + 1 < std::min(threads, tiles.size())) others.emplace_back(work);
    work();
    for (std::thread& other : others) other.join();
    return passes ? exit_temporary_failure : failed ? 1 : 0;
}

/// Hash of everything except the points that affects the bytes of a figure.
std::uint64_t hash_of_parameters(const Arguments& given, const MeshFile& cage, const Job& job) {
    std::ostringstream text;
    text.precision(17);
    const CoordinatesChoice& c = given.choice;
    const auto& multigrid = c.harmonic.multigrid;
    text << "bind_tiles 1 " << job.piece << ' ' << c.name << ' ' << c.faces << ' ' << c.divisions << ' '
         << c.resolution << ' ' << c.is_uniform << ' ' << c.harmonic.accuracy << ' ' << multigrid.tolerance
         << ' ' << given.outside.word << ' ' << given.outside.falloff << ' '
         << int(job.pack.format.value_or(cageform::WeightFormat::scalar)) << ' ' << job.pack.largest << ' '
         << job.pack.tolerance << ' ' << cage.lattice.has_value() << '\n';
    std::uint64_t hash = cageform::hash_memory(std::span<const char>(text.str()));
    hash = cageform::hash_memory(std::span<const char>(cage.text), hash);
    hash = cageform::hash_memory(std::span<const Point3>(cage.vertices), hash);
    return cageform::hash_memory(std::span<const double>(job.poses), hash);
}

/// Prints the peak memory and returns the number of threads that fit into the limit.
///
///   of_solver   out: the bytes that remain for the solver, if there is one
std::size_t plan_memory(const Arguments& given, const Job& job, std::size_t tiles, std::size_t& of_solver) {
    constexpr std::size_t mega = 1000000, of_program = 32 * mega;
    const std::size_t each = bytes_of_tile(job.piece, job.coordinates.handles().count);
    const std::size_t all = given.memory * mega;
    const bool solves = !job.coordinates.closed_form();
    const std::size_t least = of_program + each + (solves ? each : 0);
    if (all < least)
        throw Failure("--memory " + std::to_string(given.memory) + ": a tile takes " +
                      std::to_string(least / mega + 1) + " MB with this cage, for any number of points");
    const std::size_t room = (all - of_program - (solves ? (all - of_program) / 2 : 0)) / each;
    const std::size_t threads = std::clamp<std::size_t>(std::min({given.threads, room, tiles}), 1, 1024);
    of_solver = solves ? all - of_program - threads * each : 0;
    note("memory: at most " + std::to_string((of_program + threads * each + of_solver) / mega + 1) +
         " MB: " + std::to_string(each / mega + 1) + " MB for each of " + std::to_string(threads) +
         (threads == 1 ? " tile" : " tiles") + " at a time" +
         (solves ? ", and the solver up to " + std::to_string(of_solver / mega) + " MB" : ""));
    if (threads < std::min(given.threads, tiles))
        note("--threads " + std::to_string(given.threads) + ": no more fit into --memory " +
             std::to_string(given.memory));
    return threads;
}

/// Solves or loads the functions, and saves them on request; returns the exit status.
int solve(const Arguments& given, std::size_t threads, const Job& job, std::optional<InputFile>& solution) {
    ProgressBar bar("solving");
    const cageform::Running running{cageform::ThreadedFor{unsigned(threads)}, bar.callback()};
    cageform::Evaluation solved;
    if (!given.solution.empty()) {
        solution.emplace(given.solution);
        const auto bytes = solution->map();
        if (!solution->error().empty()) {
            const int code = fail(solution->error());
            return solution->may_retry() ? exit_temporary_failure : code;
        }
        solved = job.coordinates.load_solution(bytes, running);
        if (solved.status != Status::ok)
            return fail(given.solution + ": " + to_string(solved.status) + "; this cage is " + job.cage +
                        " with --accuracy " + detail::short_number(given.choice.harmonic.accuracy) +
                        "; --save-solution writes a matching one");
    } else {
        solved = job.coordinates.solve(running);
    }
    if (solved.status != Status::ok) {
        cageform::BindReport refused;
        refused.status = solved.status;
        refused.solver = solved.solver;
        return fail(describe_mesh_faults(job.cage, refused));
    }
    warn_of_coarse_grid(job.cage, solved.solver);
    if (given.saved_solution.empty()) return 0;
    const auto [bytes, saved] = job.coordinates.save_solution();
    if (saved.status != Status::ok) return fail(given.saved_solution + ": " + to_string(saved.status));
    AtomicFile file(given.saved_solution);
    file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (const auto why = file.commit()) {
        const int code = fail(*why);
        return file.may_retry() ? exit_temporary_failure : code;
    }
    return 0;
}

void add_options(CommandLine& line, Arguments& given) {
    line.add("cage", given.cage, "the cage: a closed mesh, or a .lattice.json file").required();
    given.tiles.add_options(line);
    given.moves.add_options(line);
    given.choice.with_normals = given.choice.in_space = true;
    given.choice.limits_memory = false; // --memory limits the whole program
    given.choice.add_options(line);
    given.outside.add_options(line);
    given.weights.add_options(line, "the cage's size", "", "float");
    line.add("--save-solution", given.saved_solution,
             "harmonic: write the solution for the cage to this file, for other processes")
        .ends_with({".solution"});
    line.add("--solution", given.solution, "harmonic: read a file of --save-solution instead of solving");
    line.add("--threads", given.threads, "the number of tiles to bind in parallel")
        .range(1, 1024)
        .show_default();
    line.add("--memory", given.memory,
             "the memory limit in MB; the program prints the requirement before it starts")
        .range(64, 1 << 30)
        .show_default();
    line.add_flag("--strict", given.is_strict, "refuse a file with a point that is not finite in float");
    line.add_flag("--json", given.json,
                  "print a line of JSON for each tile: its row, files, state, seconds, points, bytes, "
                  "weights per point, and the largest distance");
}

/// The selected tiles. Fails if options conflict, or a file cannot be written.
std::vector<Tile> checked_tiles(const Arguments& given) {
    fail_if(given.outside.fault());
    fail_if(given.weights.fault(given.choice, given.moves.is_given()));
    const bool has_solution = !given.solution.empty() || !given.saved_solution.empty();
    if (has_solution &&
        (given.choice.name != "harmonic" || given.choice.resolution != 0 || given.choice.is_uniform))
        throw Failure("--solution and --save-solution need --coordinates harmonic with --accuracy");
    auto tiles = given.tiles.tiles();
    std::vector<std::string> inputs = given.moves.poses;
    for (const std::string& path : {given.cage, given.moves.clip, given.solution}) {
        if (!path.empty()) inputs.push_back(path);
    }
    std::vector<std::string> outputs;
    if (!given.saved_solution.empty()) outputs.push_back(given.saved_solution);
    fail_if(fault_of_tiles(tiles, inputs, outputs));
    return tiles;
}

/// The coordinates of a cage, and the options of its tiles.
Job job_of(const Arguments& given, const MeshFile& cage) {
    Job job;
    job.size = cageform::bounds_of(std::span<const Point3>(cage.vertices)).diagonal();
    job.cage = cage.name;
    job.coordinates = make_coordinates<float>(given.choice, cage);
    if (job.coordinates.cage_report().status != Status::ok) {
        cageform::BindReport refused;
        refused.cage = job.coordinates.cage_report();
        refused.status = refused.cage.status;
        throw Failure(describe_mesh_faults(cage.name, refused));
    }
    job.piece = points_of_piece(job.coordinates.handles().count);
    job.pack.format = given.weights.format.value_or(cageform::WeightFormat::scalar);
    job.pack.largest = given.weights.largest;
    job.pack.tolerance = given.weights.distance * job.size;
    job.outside = given.outside.word;
    job.is_strict = given.is_strict;
    return job;
}

/// The poses of all handles in a motion, in which errors are measured.
std::vector<double> poses_of(const Job& job, const MeshFile& cage, const PoseClip& motion) {
    if (motion.keys.empty()) return {};
    const auto bound = job.coordinates.bind(std::span(cage.vertices).first(1), job.bind);
    if (!bound) throw Failure(describe_mesh_faults(cage.name, bound.report));
    return poses_of_handles(bound.value, motion, sample_poses(motion));
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Binds files of points to a cage, each in bounded memory, and packs each into a figure.");
    line.set_examples(
        {"cage.obj --points 'tiles/*.ply' -o 'out/*.figure' --largest 16 --format half",
         "cage.obj --points 'tiles/*.ply' -o 'out/*.figure' --rows 0:100 --threads 4 --json",
         "cage.obj --points scan.ply -o scan.figure --max-distance 0.01 --clip clip.csv --format int8"});
    Arguments given;
    add_options(line, given);
    line.set_footer(point_file_format + std::string("\n") + ply_format + "\n" + mesh_formats + "\n" +
                    lattice_format + "\n" + pose_clip_format + "\n" + pose_operations_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    given.moves.order_poses();
    const auto tiles = checked_tiles(given);
    const auto cage = value_or_fail(load_mesh_cage(given.cage));
    fail_if(single_precision_fault(cage));
    fail_if(rounding_fault(cage.name, cage.vertices));
    const auto motion = given.moves.motion(cage);
    std::optional<InputFile> solution; // must outlive the coordinates
    Job job = job_of(given, cage);
    std::size_t of_solver = 0;
    const std::size_t threads = plan_memory(given, job, tiles.size(), of_solver);
    if (of_solver > 0) {
        given.choice.memory = of_solver;
        job.coordinates = make_coordinates<float>(given.choice, cage);
    }
    job.bind = given.outside.bind_options(job.coordinates);
    print_notes(cage.name, job.coordinates.cage_report(), job.coordinates.note);
    if (const int code = solve(given, threads, job, solution); code != 0) return code;
    job.poses = poses_of(job, cage, motion);
    job.pack.poses = job.poses;
    job.parameters = hash_of_parameters(given, cage, job);
    return bind_all(job, tiles, threads, given.json);
}
