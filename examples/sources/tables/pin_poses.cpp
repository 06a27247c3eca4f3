// Compares poses by pins with least-squares poses of the cage for the same targets.
//
//     pin_poses cat.svg --cage cat_cage.svg --pinned "212,740 645,740 915,165:760,60" -o cat_pins_
//     pin_poses character.obj --cage character_cage.obj --pinned "0 0,0.9,0 0.9,1.3,0:0.6,1.9,0.2" -o man_
//
// PoseSolver keeps the inside as rigid as possible. Least squares considers all poses of the cage that take
// the pins to their targets. It chooses the one with the smallest displacements of vertices, d = Wᵀ (W Wᵀ)⁻¹
// (t − W H). The program draws each pose by both methods, and prints the distortion of the inside.

#include "cli/auto_cage.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/pinned_figure.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/cage_picture.hpp"
#include "pictures/mesh_picture.hpp"
#include "pictures/render.hpp"
#include "pictures/view_choice.hpp"
#include "svg/document.hpp"

#include <cageform/binding/pose_samples.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/folds.hpp>

#include <Eigen/Dense>

#include <cstdio>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string figure, cage, out;
    std::vector<std::string> poses; // the pins of each pose, as given
    CoordinatesChoice choice;
    PinChoice pins;
    ViewChoice view;
    bool is_strict = false;
};

template <std::size_t D>
std::vector<Pin<D>> pins_in(const std::string& words,
                            std::span<const cageform::Vec<double, D>> vertices = {}) {
    std::vector<Pin<D>> pins;
    for (const std::string_view word : detail::parts_of(words, ' ')) {
        if (word.empty()) continue;
        pins.push_back(value_or_fail(parse_pin<D>(word, vertices)));
    }
    if (pins.empty()) throw Failure("--pinned " + detail::quoted(words) + ": a pose has no pins");
    return pins;
}

/// The smallest displacements of all handles that take the pins to their targets, as far as the weights
/// allow.
template <std::size_t D>
std::vector<cageform::Vec<double, D>> least_moves(const ChosenCoordinates<double, D>& coordinates,
                                                  const std::vector<Pin<D>>& pins) {
    std::vector<cageform::Vec<double, D>> places;
    for (const Pin<D>& pin : pins) places.push_back(pin.place);
    const auto bound = coordinates.bind(places);
    const auto rows = Eigen::Index(pins.size()), columns = Eigen::Index(bound.value.handle_count());
    Eigen::MatrixXd weights(rows, columns), ways(rows, Eigen::Index(D));
    for (Eigen::Index n = 0; n < rows; ++n) {
        for (Eigen::Index i = 0; i < columns; ++i)
            weights(n, i) = bound.value.weight(std::size_t(n), std::size_t(i));
        const auto way = pins[std::size_t(n)].target - pins[std::size_t(n)].place;
        for (std::size_t k = 0; k < D; ++k) ways(n, Eigen::Index(k)) = way[k];
    }
    const Eigen::MatrixXd moves = weights.completeOrthogonalDecomposition().solve(ways);
    std::vector<cageform::Vec<double, D>> result(bound.value.handle_count());
    for (std::size_t i = 0; i < result.size(); ++i) {
        for (std::size_t k = 0; k < D; ++k) result[i][k] = moves(Eigen::Index(i), Eigen::Index(k));
    }
    return result;
}

/// Prints the distortion at samples of a cage's inside.
template <std::size_t D>
class Inside {
public:
    /// Returns why it cannot be measured; empty if it can.
    template <class Pose>
    std::string print(const ChosenCoordinates<double, D>& coordinates, const Pose& pose,
                      const std::string& name) {
        if (axes_[0].point_count() == 0) {
            const auto samples = pose_samples(coordinates);
            auto bound = coordinates.bind_jacobians(samples.value.points);
            if (!bound) return cageform::to_string(bound.report.status);
            axes_ = std::move(bound.value);
        }
        const auto folds = cageform::report_folds(axes_, pose);
        std::printf("%s: stretch %.2f to %.2f, %.2g %% of the inside folded\n", printable(name).c_str(),
                    folds.least_stretch, folds.largest_stretch,
                    100 * double(folds.count) / double(axes_[0].point_count()));
        return {};
    }

private:
    std::array<cageform::Binding<double, D>, D> axes_;
};

/// Draws and measures the poses of one figure.
class PoseSheet {
public:
    PoseSheet(const Arguments& given, const SvgDocument& figure, const CageFile& cage)
        : given_(given)
        , figure_(figure)
        , cage_(cage)
        , control_(control_of(given.choice, cage)) {
        control_.pose_name = "the pose by pins";
        outside_.cage_is_made = CageChoice::of(given.cage).is_auto;
    }

    /// Draws both poses; an empty reason is success.
    std::string add(std::size_t number, OutputFiles& outputs) {
        auto pins = pins_in<2>(given_.poses[number]);
        auto pinned = value_or_fail(
            PinnedFigure::make(control_, {given_.choice, given_.pins, outside_, cage_.vertices, {}}, pins));
        const auto pose = value_or_fail(pinned.settled());
        const std::string name = given_.out + std::to_string(number + 1);
        std::string why = draw(pins, pose, name + ".svg", outputs);
        auto least = pinned.rest();
        const auto moves = least_moves(control_.coordinates, pins);
        for (std::size_t i = 0; i < least.size(); ++i)
            least[i] = {least[i].x + moves[i][0], least[i].y + moves[i][1]};
        if (why.empty()) why = draw(pins, least, name + "_least.svg", outputs);
        return why;
    }

private:
    /// Draws a pose, and prints the distortion at the samples of the inside.
    std::string draw(const std::vector<Pin<2>>& pins, const std::vector<Point2>& pose,
                     const std::string& path, OutputFiles& outputs) {
        control_.poses = {pose};
        auto moved = move_figure(figure_, given_.figure, control_, outside_, {});
        SvgDocument& document = moved.drawing.document;
        const auto view = view_box(document);
        draw_pins(document, pins, std::hypot(view.width, view.height));
        outputs.add(path).write(to_text(document));
        return inside_.print(control_.coordinates, pose, path);
    }

    const Arguments& given_;
    const SvgDocument& figure_;
    const CageFile& cage_;
    FigureControl control_;
    OutsideChoice outside_;
    Inside<2> inside_;
};

/// Draws the poses of a mesh side by side, one picture per method.
int draw_in_space(const Arguments& given) {
    const auto figure = load_mesh_figure(given.figure, given.is_strict);
    const auto cage = load_or_make_cage(given.cage, figure);
    const auto coordinates = make_coordinates<double>(given.choice, cage);
    const auto faults = [&](const cageform::BindReport& report) {
        return describe_mesh_faults(cage.name, report);
    };
    const auto bound = coordinates.bind(figure.vertices);
    if (!bound) return fail(faults(bound.report));
    std::array<std::vector<std::vector<Point3>>, 2> moved;
    Inside<3> inside;
    for (std::size_t n = 0; n < given.poses.size(); ++n) {
        auto pins = pins_in<3>(given.poses[n], figure.vertices);
        const auto moves = least_moves(coordinates, pins);
        auto pinned = value_or_fail(PinnedCage<double, 3>::make(
            coordinates, {cage.name, given.choice.name, faults}, {std::move(pins), {}}, given.pins, {}));
        std::array poses{pinned.rest(), pinned.rest()};
        if (const auto done = pinned.settle(pinned.targets(), pinned.turns(), poses[0]); !done)
            return fail(to_string(done.error()));
        for (std::size_t i = 0; i < moves.size(); ++i) poses[1][i] = poses[1][i] + moves[i];
        for (const std::size_t k : {0u, 1u}) {
            auto& out = moved[k].emplace_back(figure.vertices.size());
            const auto status = cageform::clone(bound.value, poses[k], out);
            if (status != cageform::Status::ok) return fail(cageform::to_string(status));
            fail_if(inside.print(coordinates, poses[k],
                                 std::to_string(n + 1) + (k == 0 ? " by pins" : " by least moves")));
        }
    }
    OutputFiles outputs;
    for (const std::size_t k : {0u, 1u}) {
        std::vector<MeshScene> scenes;
        for (const auto& vertices : moved[k]) scenes.push_back({{vertices, figure.triangles}, {}});
        draw_meshes(scenes, 260 * scenes.size(), 330, given.view.sight)
            .write_png(outputs.add(given.out + (k == 0 ? "all.png" : "all_least.png")));
    }
    return commit(outputs);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Draws poses of a figure by pins. Beside each it draws the pose with the least moves of the "
        "cage that take the pins to the same targets.");
    line.set_examples({"cat.svg --cage auto --pinned \"212,740 645,740 915,165:760,60\" -o cat_pins_"});
    Arguments given;
    line.add("figure", given.figure, "the SVG or OBJ file to deform").required();
    line.add("--cage", given.cage,
             "its cage: an SVG or CSV file, for a mesh an OBJ file" + std::string(auto_cage_help))
        .required();
    line.add_text(
            "--pinned", [&](const std::string& words) { given.poses.push_back(words); },
            "the pins of a pose, as --pin of deform_svg takes them, with blanks between them; one pose for "
            "each --pinned")
        .in_order()
        .required();
    line.add("-o,--output", given.out,
             "the prefix of the output files: 1.svg, 1_least.svg, 2.svg, …; for a mesh all.png, "
             "all_least.png")
        .required();
    given.choice.in_plane = given.choice.in_space = true;
    given.choice.add_options(line);
    given.view.add_options(line);
    add_strict(line, given.is_strict);
    line.set_footer(pins_format + std::string("\n") + cage_formats + "\n" + mesh_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    given.pins.solving.settled_step = 1e-6;
    if (lowercase_extension(given.figure) == ".obj") return draw_in_space(given);

    const auto figure = value_or_fail(load_svg(given.figure));
    const auto cage = load_or_make_cage(given.cage, figure, given.choice.edges());
    PoseSheet sheet(given, figure, cage);
    OutputFiles outputs;
    for (std::size_t n = 0; n < given.poses.size(); ++n) {
        fail_if(sheet.add(n, outputs));
    }
    return commit(outputs);
}
