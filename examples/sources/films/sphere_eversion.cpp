// A sphere eversion without tears or creases: a sheet of stages, a film, the curve of its volume. Initially
// the outside is red and the inside blue; bands of the surface are cut out.
//
//     sphere_eversion -o eversion.png --volume volume.svg --gif eversion.gif
//     sphere_eversion -o twisted.png --cage lattice:6x6x6 --twist all:z,-1,1,120
//
// With --cage, every stage is bound to the cage and deformed. The program prints the smallest determinant of
// the deformation; if it is positive, the stage remains an immersion.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/pose_choice.hpp"
#include "double_curve.hpp"
#include "eversion.hpp"
#include "files/obj_file.hpp"
#include "film_choice.hpp"
#include "io/messages.hpp"
#include "pictures/mesh_picture.hpp"
#include "pictures/plot.hpp"
#include "pictures/view_choice.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/folds.hpp>

#include <iostream>

namespace {

using namespace cageform_sources;

struct Arguments {
    std::string out, volume, cage;
    int stages = 12, columns = 4, tile = 320, bands = 8, rows = 72;
    FilmChoice film;
    CoordinatesChoice choice;
    OutsideChoice outside;
    PoseChoice operations;
    ViewChoice view;

    std::size_t net_rows() const { return std::size_t(rows); }
    std::size_t net_columns() const { return 2 * net_rows(); }
};

/// A cage around all stages, and its pose.
struct Control {
    ChosenCoordinates<double, 3> coordinates;
    MeshFile cage;
    std::vector<Point3> pose;
};

/// All stages as one figure, for making cages.
MeshFile all_stages() {
    const Eversion eversion;
    MeshFile figure;
    figure.name = "the eversion";
    for (int n = 0; n <= 24; ++n) {
        const auto first = std::uint32_t(figure.vertices.size());
        const auto mesh = eversion_mesh(eversion.stage(n / 24.0), 24, 48);
        figure.vertices.insert(figure.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
        for (const auto& [a, b, c] : mesh.triangles)
            figure.triangles.push_back({first + a, first + b, first + c});
    }
    return figure;
}

std::optional<Control> read_control(const Arguments& given, const MeshFile& all_stages) {
    const bool is_posed = !given.operations.operations.empty();
    if (given.cage.empty()) {
        if (is_posed)
            throw Failure("operations such as --twist pose a cage: give --cage, such as lattice:6x6x6");
        return std::optional<Control>();
    }
    auto cage = load_or_make_cage(given.cage, all_stages);
    std::vector<Point3> pose = first_pose(cage.vertices);
    if (is_posed) {
        const auto parts = cage_parts(cage);
        pose = given.operations.posed(cage.vertices, cage.lattice, nullptr, &parts);
    }
    auto coordinates = make_coordinates<double>(given.choice, cage);
    note(coordinates.note);
    const auto bound = coordinates.bind(all_stages.vertices, given.outside.bind_options(coordinates));
    if (!bound) throw Failure(describe_mesh_faults(cage.name, bound.report));
    given.outside.check(coordinates, bound.report, all_stages.vertices, all_stages.name, cage.name);
    return std::optional<Control>(Control{std::move(coordinates), std::move(cage), std::move(pose)});
}

/// A stage to draw.
struct Tile {
    std::vector<Point3> vertices;
    std::vector<SpaceLine> lines;
};

class StageRenderer {
public:
    StageRenderer(const Arguments& given, std::optional<Control> control)
        : given_(given)
        , control_(std::move(control))
        , front_((given.net_rows() + 1) * given.net_columns(), {0.86f, 0.24f, 0.17f})
        , back_(front_.size(), {0.22f, 0.42f, 0.82f}) {
        for (const auto& triangle : eversion_triangles(given.net_rows(), given.net_columns())) {
            if (is_shown(triangle[0] % given.net_columns())) shown_.push_back(triangle);
        }
    }

    /// The stage at a time, deformed by the cage if there is one.
    Tile tile(double time) const {
        EversionMesh mesh = eversion_mesh(eversion_.stage(time), given_.net_rows(), given_.net_columns());
        if (const std::string why = move_by_cage(mesh.vertices); !why.empty()) throw Failure(why);
        Tile tile{std::move(mesh.vertices), {}};
        for (const auto& [a, b] : double_curve(tile.vertices, shown_))
            tile.lines.push_back({{a, b}, 1.5, {1.0f, 0.88f, 0.45f}});
        return tile;
    }

    /// Draws a tile. All tiles have the same scale.
    Picture draw(const Tile& tile) {
        if (stage_.empty()) {
            for (int n = 0; n <= 24; ++n) {
                auto mesh = eversion_mesh(eversion_.stage(n / 24.0), 16, 32);
                if (const std::string why = move_by_cage(mesh.vertices); !why.empty()) throw Failure(why);
                for (const Point3& p : mesh.vertices)
                    stage_.push_back(1.04 * p); // a margin for stages between these
            }
            if (control_) add_cage();
        }
        const MeshScene scene{{tile.vertices, shown_, front_, back_}, {stage_, cage_triangles_}, tile.lines};
        const auto side = std::size_t(given_.tile);
        return draw_meshes(std::span(&scene, 1), side, side, given_.view.sight);
    }

    /// The smallest ratio of volumes, deformed to rest, around points of a stage. Fails if Jacobians are not
    /// available.
    double least_determinant(double time) const {
        const auto rest = eversion_mesh(eversion_.stage(time), 48, 96).vertices;
        const auto columns =
            control_->coordinates.bind_jacobians(rest, given_.outside.bind_options(control_->coordinates));
        if (!columns) throw Failure(cageform::to_string(columns.report.status));
        std::string warning;
        const auto handles =
            value_or_fail(pose_of_handles(columns.value[0], control_->pose, control_->cage.name, warning));
        return cageform::report_folds(columns.value, handles).least_determinant;
    }

    bool has_cage() const { return control_.has_value(); }
    EversionStage stage(double time) const { return eversion_.stage(time); }

private:
    /// Adds the edges of the cage's faces to the picture, as triangles without area.
    void add_cage() {
        for (const MeshFace& face : control_->cage.faces) {
            for (std::size_t k = 0; k < face.corners.size(); ++k) {
                const std::uint32_t next = face.corners[(k + 1) % face.corners.size()].vertex;
                const std::uint32_t corner = face.corners[k].vertex;
                cage_triangles_.push_back({corner, corner, next});
            }
        }
        stage_.insert(stage_.begin(), control_->pose.begin(), control_->pose.end());
    }

    /// Whether a column of quads is within a band.
    bool is_shown(std::size_t column) const {
        const double place = given_.bands * (double(column) + 0.5) / double(given_.net_columns());
        return given_.bands == 0 || std::fabs(place - std::round(place)) < 0.3; // 60 % of the surface
    }

    /// Binds points and moves them; returns an error message, or empty.
    std::string move_by_cage(std::vector<Point3>& points) const {
        if (!control_) return {};
        const auto bound =
            control_->coordinates.bind(points, given_.outside.bind_options(control_->coordinates));
        if (!bound) return describe_mesh_faults(control_->cage.name, bound.report);
        std::string warning;
        const auto handles = pose_of_handles(bound.value, control_->pose, control_->cage.name, warning);
        if (!handles) return to_string(handles.error());
        const auto status = cageform::clone(bound.value, *handles, points);
        return status == cageform::Status::ok ? "" : cageform::to_string(status);
    }

    const Arguments& given_;
    std::optional<Control> control_;
    Eversion eversion_;
    std::vector<std::array<std::uint32_t, 3>> shown_, cage_triangles_;
    std::vector<Colour> front_, back_;
    std::vector<Point3> stage_; // the cage's pose and points of all stages, all inside the view
};

/// The curve of the signed volume, as an SVG.
std::string volume_curve(const StageRenderer& theatre) {
    const Axis x{0, 1, 60, 620}, y{-2.6, 2.6, 330, 20};
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 370\" font-size=\"13\" "
                      "font-family=\"DejaVu Sans, sans-serif\">\n<g stroke=\"#ddd\">\n",
                numbers;
    const auto at = [](double a, double b) { return text_of("%.2f", a) + "," + text_of("%.2f", b); };
    for (const auto& [value, number] : marks_of(y, 6)) {
        svg += "<path d=\"M" + at(x.begin, y.at(value)) + " H" + text_of("%.2f", x.end) + "\"/>\n";
        numbers += "<text x=\"52\" y=\"" + text_of("%.2f", y.at(value) + 4) + "\" text-anchor=\"end\">" +
                   number + "</text>\n";
    }
    for (const auto& [value, number] : marks_of(x, 5))
        numbers += "<text x=\"" + text_of("%.2f", x.at(value)) + "\" y=\"346\" text-anchor=\"middle\">" +
                   number + "</text>\n";
    svg += "</g>\n<path fill=\"none\" stroke=\"#b03020\" stroke-width=\"2\" d=\"";
    constexpr int steps = 240;
    for (int n = 0; n <= steps; ++n) {
        const double time = double(n) / steps;
        svg += (n == 0 ? "M" : " L") +
               at(x.at(time), y.at(volume_of(eversion_mesh(theatre.stage(time), 48, 96))));
    }
    return svg + "\"/>\n" + numbers +
           "<text x=\"340\" y=\"364\" text-anchor=\"middle\">time; the signed volume is 0 "
           "halfway</text>\n</svg>\n";
}

/// Prints properties of a stage, and of the cage's deformation there.
void print_stage(const StageRenderer& theatre, double time) {
    constexpr std::size_t rows = 100, columns = 180;
    const EversionStage stage = theatre.stage(time);
    const EversionMesh mesh = eversion_mesh(stage, rows, columns);
    const double size = size_of(mesh);
    std::cout << "time " << text_of("%.3f", time) << ": size " << text_of("%.4f", size) << ", volume "
              << text_of("%+.4f", volume_of(mesh)) << ", least area factor "
              << text_of("%.4f", least_area_factor(stage, rows, columns) / (size * size));
    if (theatre.has_cage()) {
        std::cout << ", least determinant " << text_of("%.3f", theatre.least_determinant(time));
    }
    std::cout << '\n';
}

/// The largest displacement of a vertex between two frames, relative to the largest distance from the origin.
double largest_step(const std::vector<Point3>& before, const std::vector<Point3>& after) {
    const auto length = [](const Point3& v) { return std::hypot(v[0], v[1], v[2]); };
    double step = 0, size = 0;
    for (std::size_t i = 0; i < after.size(); ++i) {
        step = std::max(step, length(after[i] - before[i]));
        size = std::max(size, length(after[i]));
    }
    return step / size;
}

int play(const Arguments& given, StageRenderer theatre) {
    const auto side = std::size_t(given.tile), count = std::size_t(given.stages),
               columns = std::min(std::size_t(given.columns), count);
    Picture sheet(columns * side, (count + columns - 1) / columns * side);
    for (std::size_t n = 0; n < count; ++n) {
        const double time = double(n) / double(count - 1);
        const auto tile = theatre.tile(time);
        auto picture = theatre.draw(tile);
        picture.text({10, double(side) - 14}, text_of("%.2f", time), 2, {0.35f, 0.35f, 0.35f});
        sheet.place(picture, n % columns * side, n / columns * side);
        print_stage(theatre, time);
    }

    OutputFiles outputs;
    sheet.write_png(outputs.add(given.out));
    if (!given.volume.empty()) outputs.add(given.volume).write(volume_curve(theatre));
    std::optional<Film> film;
    if (!given.film.gif.empty()) film.emplace(outputs, given.film.gif, given.film.rate, given.tile);
    std::vector<Point3> before;
    double largest = 0; // step of a vertex between two frames, relative to the size
    for (int n = 0; given.film.is_given() && n < given.film.frames && !outputs.error(); ++n) {
        const auto tile = theatre.tile(double(n) / (given.film.frames - 1));
        if (n > 0) largest = std::max(largest, largest_step(before, tile.vertices));
        before = tile.vertices;
        const auto picture = theatre.draw(tile);
        if (film) film->add_frame(picture);
        if (given.film.stills.empty()) continue;
        AtomicFile& file = outputs.add(given.film.still(n, ".png"));
        picture.write_png(file);
        (void)file.finish(); // commit() reports the error
    }
    if (film) film->finish();
    fail_if(outputs.commit());
    if (given.film.is_given())
        std::cout << given.film.frames << " frames: between two frames a vertex moves by at most "
                  << text_of("%.2f", 100 * largest) << " % of the size\n";
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Turns a sphere inside out, without a tear or a crease, and draws it cut into bands. The outside is "
        "red, the inside blue; self-intersections are yellow.");
    line.set_examples({"-o eversion.png --volume volume.svg", "-o eversion.png --gif eversion.gif",
                       "-o strip.png --columns 12 --tile 160 --stills turn_ --frames 60",
                       "-o twisted.png --cage lattice:6x6x6 --twist all:z,-1,1,120",
                       "-o bent.png --cage box --coordinates harmonic --bend all:zx,-1,1,60"});
    Arguments given;
    given.view.sight = {.turn = 25, .rise = 30, .z_is_up = true};
    given.choice.in_space = true;
    line.add("-o,--output", given.out, "the sheet of stages, a PNG file").required().ends_with({".png"});
    line.add("--stages", given.stages, "stages on the sheet").range(2, 60).show_default();
    line.add("--columns", given.columns, "stages in a row").range(1, 60).show_default();
    line.add("--tile", given.tile, "the width and height of a stage and of a frame, in pixels")
        .range(32, 1000)
        .show_default();
    line.add("--bands", given.bands, "the number of bands between meridians; 0: the whole surface")
        .range(0, 24)
        .show_default();
    line.add("--rows", given.rows, "the number of quads from pole to pole").range(16, 200).show_default();
    line.add("--volume", given.volume, "also write the curve of the signed volume").ends_with({".svg"});
    given.film.add_options(line, 120, "PNG files");
    line.add("--cage", given.cage,
             "a cage that moves every stage: an OBJ file" + std::string(auto_cage_help));
    given.operations.add_options(line);
    given.outside.add_options(line);
    given.choice.add_options(line);
    given.view.add_options(line);
    line.set_footer(mesh_formats + std::string("\n") + lattice_format + "\n" + pose_operations_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    fail_if(given.outside.fault());

    auto control = read_control(given, all_stages());
    fail_if(given.film.fault({given.out, given.volume}, ".png"));
    return play(given, StageRenderer(given, std::move(control)));
}
