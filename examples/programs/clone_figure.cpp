// Writes poses of a packed figure, one file per pose: rows of a table, or a clip at equal time steps.
//
//     clone_figure character.figure --poses poses.csv --rows 0:1000 -o 'out/%06d.ply'
//     clone_figure character.figure --poses walk.csv --rate 24 --mesh character.obj -o 'out/%04d.obj'
//
// The figure is an output of bind_mesh or bind_tiles, or any packed figure or binding, in 2D or 3D. Rows are
// independent: each task of a farm runs this program with its own rows (integrations/farms). Files are
// bitwise equal for any split of the rows and any number of threads.
//
// Exit status 75 is a temporary failure, such as a full disk: repeat the command, with --skip-existing to
// keep finished files. Files are written atomically.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/progress_bar.hpp"
#include "cli/row_range.hpp"
#include "files/figure_parts.hpp"
#include "files/pose_rows.hpp"
#include "files/posed_file.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/parallel/threads.hpp>
#include <cageform/runtime.hpp>

#include <chrono>
#include <iostream>

#include <nlohmann/json.hpp>

namespace {

using namespace cageform_support;
using cageform::Status;
using cageform::Vec;

struct Arguments {
    std::string figure, poses, rows = ":", mesh, out;
    double rate = 30;
    std::size_t threads = 1;
    bool ascii = false, skip_existing = false, json = false, flips_faces = false;

    /// The format of outputs without a mesh.
    PosedFormat format() const {
        const std::string ending = lowercase_extension(out);
        return ending == ".obj"   ? PosedFormat::obj
               : ending == ".npy" ? PosedFormat::npy
               : ascii            ? PosedFormat::ply_text
                                  : PosedFormat::ply;
    }
    /// The mesh's own format, if the extension is of it; --ascii writes a new file.
    PosedFormat format_of(const MeshFile& of_mesh) const {
        return !ascii && fault_of_extension(of_mesh, out).empty() ? PosedFormat::mesh : format();
    }
};

/// Result of one row.
struct Outcome {
    std::string path, fault, warning;
    bool skipped = false, may_retry = false;
    bool at_output = false; // whether writing failed: other rows would fail too
    std::size_t bytes = 0;
    double seconds = 0;
};

/// Additional parts of a figure of bind_mesh (support/files/figure_parts.hpp).
template <class T, std::size_t D>
struct MeshParts {
    std::string fault; ///< why they cannot be used; empty if they can
    Vec<double, D> origin{};
    /// Three independent vectors per point, and their rest values; empty if the file has none.
    std::vector<cageform::PackedBindingView<T, D>> frames;
    std::vector<std::vector<Vec<T, D>>> frames_at_rest;
};

template <class T, std::size_t D>
MeshParts<T, D> mesh_parts(const cageform::PackedFigureView<T, D>& figure) {
    MeshParts<T, D> parts;
    if (const auto place = figure.part("ORIG"); place.size() == sizeof(parts.origin))
        std::memcpy(&parts.origin, place.data(), place.size());
    else if (!place.empty())
        parts.fault = "the part ORIG has the wrong size";
    if (!is_finite(parts.origin)) parts.fault = "the origin of the figure is not finite";
    if constexpr (D == 3) {
        const auto blob = figure.part("NRM1");
        if (blob.empty() || !figure.has_normals()) return parts;
        const auto across = cageform::open_blob<T, D>(blob);
        if (!across || across.value.point_count() != figure.point_count() ||
            across.value.handle_count() != figure.handle_count()) {
            parts.fault = "the part NRM1 does not belong to the figure";
            return parts;
        }
        parts.frames = {figure.tangents[0], figure.tangents[1], across.value};
        for (const auto& vectors : parts.frames) {
            auto& at_rest = parts.frames_at_rest.emplace_back(figure.point_count());
            const Status status = cageform::clone(vectors, figure.rest_handles(), at_rest);
            if (status != Status::ok) parts.fault = std::string("normals: ") + cageform::to_string(status);
        }
    }
    return parts;
}

/// Writes poses of a packed figure.
template <class T, std::size_t D>
class Cloner {
public:
    /// `has_faces`: whether the file has faces.
    Cloner(const Arguments& given, const cageform::PackedFigureView<T, D>& figure,
           const MeshParts<T, D>& parts, PosedFile file, bool has_faces)
        : given_(given)
        , figure_(figure)
        , parts_(parts)
        , file_(std::move(file))
        , names_(given.out) {
        std::vector<Vec<T, D>> points(figure.point_count());
        if (has_faces && clone(figure, figure.rest_handles(), points) == Status::ok) rest_ = places(points);
    }

    /// Warns if vertices of the mesh are far from the points of the figure at rest.
    void compare(const MeshFile& mesh) const {
        std::size_t farthest = 0;
        double largest = 0;
        for (std::size_t i = 0; i < rest_.size(); ++i) {
            double square = 0;
            for (std::size_t k = 0; k < D; ++k) square += std::pow(rest_[i][k] - mesh.vertices[i][k], 2);
            if (square > largest) farthest = i;
            largest = std::max(largest, square);
        }
        if (std::sqrt(largest) > 0.02 * size_of(mesh))
            warn(given_.mesh + ": v " + std::to_string(farthest + 1) + " is " +
                 detail::short_number(std::sqrt(largest)) + " from point " + std::to_string(farthest) +
                 " of " + given_.figure + " at rest: is this the mesh that was bound?");
    }

    /// Computes and writes a row. Thread-safe.
    Outcome write(const PoseRows<D>& poses, const PoseRow& row) const {
        const auto start = std::chrono::steady_clock::now();
        Outcome outcome;
        outcome.path = names_.of(row.row);
        std::error_code none;
        if (given_.skip_existing && std::filesystem::is_regular_file(outcome.path, none)) {
            outcome.skipped = true;
            return outcome;
        }
        std::vector<Vec<T, D>> pose(figure_.handle_count());
        const auto points = posed(poses, row, pose, outcome);
        if (!outcome.fault.empty()) return outcome;
        if constexpr (D == 3) {
            if (outcome.warning.empty() && !rest_.empty())
                outcome.warning = describe_winding(poses.name_of(row), "the figure",
                                                   side_of(rest_, places(points)), given_.flips_faces);
        }
        if constexpr (D == 3 && std::is_same_v<T, float>) {
            if (const std::string why = rounding_fault(poses.name_of(row), places(points)); !why.empty())
                outcome.warning += (outcome.warning.empty() ? "" : "; ") + why;
        }
        Status of_normals = Status::ok;
        const auto written = file_contents(points, pose, of_normals);
        if (!written) {
            outcome.fault = poses.name_of(row) + ": " + to_string(written.error());
            return outcome;
        }
        const std::string& contents = *written;
        if (of_normals != Status::ok)
            outcome.warning +=
                (outcome.warning.empty() ? "" : "; ") + poses.name_of(row) +
                ": its normals are computed from the faces: " + cageform::to_string(of_normals);
        AtomicFile out(outcome.path);
        out.write(contents);
        if (const auto why = out.commit()) {
            outcome.fault = *why;
            outcome.at_output = true;
            outcome.may_retry = out.may_retry();
            return outcome;
        }
        outcome.bytes = contents.size();
        outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return outcome;
    }

private:
    /// Returns the bytes of a file, with points in the coordinates of the mesh file.
    Expected<std::string> file_contents(std::span<const Vec<T, D>> points, std::span<const Vec<T, D>> pose,
                                        Status& of_normals) const {
        if (parts_.origin == Vec<double, D>{}) return file_.contents(points, jacobians(pose, of_normals));
        return file_.contents(std::span<const Vec<double, D>>(places(points)), jacobians(pose, of_normals));
    }

    /// Points in the coordinates of the mesh file.
    std::vector<Vec<double, D>> places(std::span<const Vec<T, D>> points) const {
        std::vector<Vec<double, D>> result;
        for (const auto& p : points) result.push_back(cageform::vec_cast<double>(p) + parts_.origin);
        return result;
    }

    /// Returns the Jacobians at all points; empty if not needed or not available.
    std::vector<Jacobian3> jacobians(std::span<const Vec<T, D>> pose, Status& status) const {
        std::vector<Jacobian3> result;
        if constexpr (D == 3) {
            if (parts_.frames.empty() || !file_.has_normals()) return result;
            result.assign(figure_.point_count(), {Point3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
            std::vector<Vec<T, D>> posed(figure_.point_count());
            for (std::size_t n = 0; n < parts_.frames.size(); ++n) {
                const auto& rest = parts_.frames_at_rest[n];
                status = clone(parts_.frames[n], pose, posed);
                if (status != Status::ok) return {};
                for (std::size_t i = 0; i < posed.size(); ++i) {
                    const Point3 change = cageform::vec_cast<double>(posed[i] - rest[i]); // 0 at rest
                    for (std::size_t k = 0; k < D; ++k)
                        result[i][k] = result[i][k] + double(rest[i][k]) * change;
                }
            }
        }
        return result;
    }

    std::vector<Vec<T, D>> posed(const PoseRows<D>& poses, const PoseRow& row, std::vector<Vec<T, D>>& pose,
                                 Outcome& outcome) const {
        std::vector<Vec<T, D>> points;
        const auto refuse = [&](const std::string& why) { outcome.fault = poses.name_of(row) + ": " + why; };
        auto vertices = poses.pose_of(row);
        if (!vertices) {
            outcome.fault = to_string(vertices.error());
            return points;
        }
        for (auto& vertex : *vertices) vertex = vertex - parts_.origin;
        const auto report = cageform::pose_handles(figure_.points, *vertices, pose);
        Status status = report.status;
        points.resize(figure_.point_count());
        if (status == Status::ok) status = clone(figure_, pose, points);
        if (status != Status::ok) {
            refuse(cageform::to_string(status));
            return points;
        }
        if (report.collapsed_faces > 0)
            outcome.warning = poses.name_of(row) + ": " + std::to_string(report.collapsed_faces) +
                              " faces of the cage have no area, so the figure is deformed incorrectly";
        std::vector<Vec<T, D>> rest; // non-finite points do not move
        for (std::size_t i = 0; i < points.size() && outcome.fault.empty(); ++i) {
            if (is_finite(points[i])) continue;
            if (rest.empty()) {
                rest.resize(points.size());
                (void)clone(figure_, figure_.rest_handles(), rest);
            }
            if (is_finite(rest[i]))
                refuse("point " + std::to_string(i) +
                       " exceeds the range of the figure's scalar: the pose is too large");
        }
        return points;
    }

    const Arguments& given_;
    cageform::PackedFigureView<T, D> figure_;
    const MeshParts<T, D>& parts_;
    PosedFile file_;
    RowPath names_;
    std::vector<Vec<double, D>> rest_; // #points, as places(); empty if the file has no faces
};

void print_line(const PoseRow& row, const Outcome& outcome) {
    nlohmann::ordered_json line = {{"row", row.row}, {"file", outcome.path}};
    line["status"] = !outcome.fault.empty() ? "failed" : outcome.skipped ? "skipped" : "written";
    if (!outcome.fault.empty()) {
        line["error"] = outcome.fault;
    } else if (!outcome.skipped) {
        line["bytes"] = outcome.bytes;
        line["seconds"] = outcome.seconds;
    }
    constexpr auto replace = nlohmann::ordered_json::error_handler_t::replace;
    std::cout << line.dump(-1, ' ', false, replace) << '\n';
}

/// Prints why a file cannot be read; returns the exit status.
template <class File>
int fail_to_read(const File& file) {
    fail(file.error());
    return file.may_retry() ? exit_temporary_failure : 1;
}

template <class T, std::size_t D>
int write_rows(const Arguments& given, const Cloner<T, D>& cloner, PoseRows<D>& poses, const RowRange& rows) {
    poses.skip(rows.first);
    const cageform::ThreadedFor threads{unsigned(given.threads)};
    const std::size_t together = 4 * std::max<std::size_t>(given.threads, 1); // rows in memory
    std::size_t done = 0, failed = 0;
    constexpr std::size_t most_messages = 20;
    std::vector<PoseRow> batch(together);
    std::vector<Outcome> outcomes(together);
    for (bool more = true; more;) {
        std::size_t count = 0;
        while (count < together && poses.row() < rows.end && poses.next(batch[count])) ++count;
        more = count == together;
        threads(count, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) outcomes[n] = cloner.write(poses, batch[n]);
        });
        bool stops = false, may_retry = false;
        for (std::size_t n = 0; n < count; ++n) {
            const Outcome& outcome = outcomes[n];
            if (given.json) print_line(batch[n], outcome);
            warn(outcome.warning);
            ++done;
            if (outcome.fault.empty()) continue;
            if (++failed <= most_messages && !(stops && outcome.at_output)) fail(outcome.fault);
            stops = stops || outcome.at_output;
            may_retry = may_retry || outcome.may_retry;
        }
        if (given.json && !std::cout.flush()) return 1;
        if (may_retry)
            note("this failure may be temporary: repeat the command, with --skip-existing to keep finished "
                 "files");
        if (stops) return may_retry ? exit_temporary_failure : 1;
    }
    if (failed > most_messages) note("and " + std::to_string(failed - most_messages) + " more");
    if (failed > 0)
        note(std::to_string(failed) + " of " + std::to_string(done) + " rows failed; the others are done");
    if (!poses.error().empty()) return fail_to_read(poses);
    if (done == 0 && rows.first < rows.end)
        note(given.poses + ": has " + std::to_string(poses.row()) + " rows: none to write");
    return failed > 0 ? 1 : 0;
}

template <class T, std::size_t D>
int run_figure(const Arguments& given, const cageform::PackedFigureView<T, D>& figure, const RowRange& rows) {
    const auto parts = mesh_parts(figure);
    if (!parts.fault.empty()) return fail(given.figure + ": " + parts.fault);
    const std::size_t scalar_bytes = parts.origin == Vec<double, D>{} ? sizeof(T) : sizeof(double);
    std::vector<Vec<double, D>> rest;
    const auto handles = figure.handle_view();
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (handles.is_point(i)) rest.push_back(cageform::to_vec<double>(handles.rest[i]) + parts.origin);
    }
    PoseRows<D> poses(given.poses, rest, given.rate);
    if (!poses.error().empty()) return fail_to_read(poses);
    if (given.mesh.empty()) {
        if (lowercase_extension(given.out) == ".stl")
            return fail("-o " + given.out + ": needs --mesh, an STL file");
        const auto packed = figure.template part_as<std::array<std::uint32_t, 3>>("TRIS");
        std::vector<std::array<std::uint32_t, 3>> triangles(packed.begin(), packed.end());
        for (auto& triangle : triangles) {
            if (given.flips_faces) std::swap(triangle[1], triangle[2]);
            for (const std::uint32_t corner : triangle) {
                if (corner >= figure.point_count())
                    return fail(given.figure + ": a triangle refers to a point that does not exist");
            }
        }
        const bool has_faces = !triangles.empty() && given.format() != PosedFormat::npy;
        if (given.flips_faces && !has_faces)
            return fail("--flip-faces: " + given.figure + " is written without faces");
        PosedFile file(given.format(), D, scalar_bytes, figure.point_count(), triangles);
        return write_rows(given, Cloner<T, D>(given, figure, parts, std::move(file), has_faces), poses, rows);
    }
    if constexpr (D == 3) {
        auto mesh = load_mesh(given.mesh, StrayVertices::leave_out); // bind_mesh warns
        if (!mesh) return fail(to_string(mesh.error()));
        if (mesh->vertices.size() != figure.point_count())
            return fail(given.mesh + ": has " + std::to_string(mesh->vertices.size()) +
                        " vertices, the figure " + std::to_string(figure.point_count()) + " points");
        const PosedFormat format = given.format_of(*mesh);
        if (lowercase_extension(given.out) == ".stl" && format != PosedFormat::mesh)
            return fail(fault_of_extension(*mesh, given.out));
        const bool has_faces = format != PosedFormat::npy;
        if (given.flips_faces && !has_faces)
            return fail("--flip-faces: " + given.mesh + " is written without faces");
        if (given.flips_faces && format == PosedFormat::mesh) fail_if(fault_of_reversing(*mesh));
        if (given.flips_faces) *mesh = with_faces_reversed(std::move(*mesh));
        PosedFile file(format, scalar_bytes, *mesh);
        const std::string others = format == PosedFormat::mesh  ? ""
                                   : format == PosedFormat::npy ? describe_others(*mesh, {"v"})
                                                                : describe_others(*mesh, {"v", "f"});
        if (!others.empty())
            note(given.mesh + ": not written: " + others + "; " +
                 (extensions_of(*mesh)[0] == ".glb" ? "deform_mesh keeps"
                                                    : extensions_of(*mesh)[0] + " files keep") +
                 " all");
        const Cloner<T, D> cloner(given, figure, parts, std::move(file), has_faces);
        cloner.compare(*mesh);
        return write_rows(given, cloner, poses, rows);
    } else {
        return fail("--mesh: " + given.figure + " is a figure in the plane; a mesh is in space");
    }
}

/// Opens the figure as one of these scalars and dimensions.
template <class T, std::size_t D>
std::optional<int> try_figure(const Arguments& given, std::span<const std::byte> bytes,
                              const RowRange& rows) {
    const auto opened = cageform::open<T, D>(bytes);
    if (opened.report.status == Status::blob_kind_differs) return std::nullopt;
    if (!opened) return fail(given.figure + ": " + cageform::to_string(opened.report.status));
    return run_figure<T, D>(given, opened.value, rows);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Writes poses of a packed figure, one file per pose: rows of a table, or a clip.");
    line.set_examples(
        {"character.figure --poses poses.csv --rows 0:1000 -o 'out/%06d.ply'",
         "character.figure --poses walk.csv --rate 24 --mesh character.obj -o 'out/%04d.obj'",
         "character.figure --poses poses.csv --rows 5000:6000 --skip-existing --json -o 'out/%06d.npy'"});
    Arguments given;
    line.add("figure", given.figure, "the packed figure that bind_mesh or bind_tiles writes").required();
    line.add("--poses", given.poses, "a table of poses of its cage, or a clip: a CSV file").required();
    add_rows(line, given.rows);
    line.add("-o,--output", given.out,
             "the files to write, with %06d where the row's number goes: .ply, .obj, .npy, an array of the "
             "points, or .stl with such a --mesh")
        .required()
        .ends_with({".ply", ".obj", ".npy", ".stl"})
        .check([](const std::string& text) -> std::string {
            const std::string why = RowPath::fault(text);
            return why.empty() ? why : "\"" + text + "\" " + why;
        });
    line.add("--mesh", given.mesh,
             "the mesh that was bound: outputs in its format keep all its contents, other .ply and .obj "
             "files its faces. By default outputs have the triangles of the figure, if any");
    line.add("--rate", given.rate, "poses of a clip per second").range(1e-3, 1e6).show_default();
    add_flip_faces(line, given.flips_faces);
    line.add_flag("--ascii", given.ascii, "write .ply files as text, not as bytes");
    line.add_flag("--skip-existing", given.skip_existing, "skip existing files");
    line.add_flag("--json", given.json, "print a line of JSON per row: its file, status, bytes and seconds");
    line.add("--threads", given.threads, "the number of rows to compute in parallel")
        .range(1, 1024)
        .show_default();
    line.set_footer(pose_table_format + std::string("\n") + pose_clip_format + "\n" + clip_format + "\n" +
                    mesh_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    const RowRange rows = *RowRange::of(given.rows);
    if (given.ascii && given.format() != PosedFormat::ply_text)
        return fail("--ascii: only .ply files can be text or bytes; .obj files are text, .npy files bytes");
    if (!RowPath(given.out).has_place() && rows.end - rows.first != 1)
        return fail("-o " + given.out +
                    ": several rows would have one name: write %06d where the row's number goes, " +
                    "or give one row, such as --rows 0:1");

    InputFile file(given.figure);
    const auto bytes = file.map();
    if (!file.error().empty()) return fail_to_read(file);
    if (bytes.empty()) return fail(given.figure + ": is empty, or no regular file");
    if (const auto code = try_figure<float, 3>(given, bytes, rows)) return *code;
    if (const auto code = try_figure<double, 3>(given, bytes, rows)) return *code;
    if (const auto code = try_figure<float, 2>(given, bytes, rows)) return *code;
    if (const auto code = try_figure<double, 2>(given, bytes, rows)) return *code;
    return fail(given.figure + ": the scalar type or dimension of the figure is not supported");
}
