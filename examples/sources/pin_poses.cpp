// Poses of a figure by pins, beside the least moves of its cage that take the pins to the same targets.
//
//     pin_poses cat.svg --cage cat_cage.svg --pinned "212,740 645,740 915,165:760,60" -o cat_pins_
//
// The pins move the cage so that the inside stays as rigid as it can. Least squares solve for the pins alone:
// among all poses of the cage that take them to their targets they choose the one whose vertices move least,
// d = Wᵀ (W Wᵀ)⁻¹ (t − W H). Every pose is drawn both ways, with the pins, and what becomes of the inside is
// printed.

#include "cli/auto_cage.hpp"
#include "cli/guard.hpp"
#include "cli/pinned_figure.hpp"
#include "files/csv.hpp"
#include "pictures/cage_picture.hpp"
#include "pictures/render.hpp"
#include "svg/document.hpp"

#include <cageform/clone/folds.hpp>
#include <cageform/pose/pose_samples.hpp>

#include <Eigen/Dense>

#include <cstdio>

namespace {

using namespace cageform_examples;

struct Arguments {
    std::string figure, cage, out;
    std::vector<std::string> poses; // of each the words of its pins
    CoordinatesChoice choice;
    PinChoice pins;
};

SvgResult<std::vector<Pin<2>>> pins_in(const std::string& words) {
    std::vector<Pin<2>> pins;
    for (const std::string_view word : detail::parts_of(words, ' ')) {
        if (word.empty()) continue;
        auto pin = parse_pin<2>(word);
        if (!pin) return pin.error();
        pins.push_back(std::move(*pin));
    }
    if (pins.empty()) return SvgError{"--pinned " + detail::quoted(words) + ": a pose has no pins"};
    return pins;
}

/// The pose of least moves that takes the pins to their targets, as nearly as the weights allow.
std::vector<Point2> least_moves(const FigureControl& control, const std::vector<Pin<2>>& pins,
                                const std::vector<Point2>& rest) {
    std::vector<cageform::Vec<double, 2>> places;
    for (const Pin<2>& pin : pins) places.push_back(pin.place);
    const auto bound = control.coordinates.bind(places);
    const auto rows = Eigen::Index(pins.size()), columns = Eigen::Index(rest.size());
    Eigen::MatrixXd weights(rows, columns), ways(rows, 2);
    for (Eigen::Index n = 0; n < rows; ++n) {
        for (Eigen::Index i = 0; i < columns; ++i)
            weights(n, i) = bound.value.weight(std::size_t(n), std::size_t(i));
        const auto way = pins[std::size_t(n)].target - pins[std::size_t(n)].place;
        ways.row(n) << way[0], way[1];
    }
    const Eigen::MatrixXd moves = weights.completeOrthogonalDecomposition().solve(ways);
    std::vector<Point2> pose = rest;
    for (std::size_t i = 0; i < pose.size(); ++i) {
        pose[i].x += moves(Eigen::Index(i), 0);
        pose[i].y += moves(Eigen::Index(i), 1);
    }
    return pose;
}

/// Draws and measures the poses of one figure.
class PoseSheet {
public:
    PoseSheet(const Arguments& given, const SvgDocument& figure, const CageFile& cage)
        : given_(given)
        , figure_(figure)
        , cage_(cage)
        , control_(control_of(given.choice, cage)) {
        control_.pose_name = "the pose by pins";
        outside_.cage_is_made = CageWord::of(given.cage).is_auto;
    }

    /// Draws both poses; an empty reason is success.
    std::string add(std::size_t number, OutputFiles& outputs) {
        auto pins = pins_in(given_.poses[number]);
        if (!pins) return to_string(pins.error());
        auto pinned =
            PinnedFigure::make(control_, {given_.choice, given_.pins, outside_, cage_.vertices, {}}, *pins);
        if (!pinned) return to_string(pinned.error());
        const auto pose = pinned->settled();
        if (!pose) return to_string(pose.error());
        const std::string name = given_.out + std::to_string(number + 1);
        std::string why = draw(*pins, *pose, name + ".svg", outputs);
        if (why.empty())
            why = draw(*pins, least_moves(control_, *pins, pinned->rest()), name + "_least.svg", outputs);
        return why;
    }

private:
    /// Draws a pose, and prints what becomes of the samples of the inside.
    std::string draw(const std::vector<Pin<2>>& pins, const std::vector<Point2>& pose,
                     const std::string& path, OutputFiles& outputs) {
        control_.poses = {pose};
        auto moved = move_figure(figure_, given_.figure, control_, outside_, {});
        if (!moved) return to_string(moved.error());
        SvgDocument& document = moved->drawing.document;
        if (const auto view = view_box(document))
            draw_pins(document, pins, std::hypot(view->width, view->height));
        outputs.add(path).write(to_text(document));
        if (axes_[0].point_count() == 0) {
            const auto samples = pose_samples(control_.coordinates);
            auto bound = control_.coordinates.bind_jacobians(samples.value.points);
            if (!bound) return cageform::to_string(bound.report.status);
            axes_ = std::move(bound.value);
        }
        const auto folds = cageform::report_folds(axes_, pose);
        std::printf("%s: stretch %.2f to %.2f, %.2g %% of the inside folded\n", printable(path).c_str(),
                    folds.least_stretch, folds.largest_stretch,
                    100 * double(folds.count) / double(axes_[0].point_count()));
        return {};
    }

    const Arguments& given_;
    const SvgDocument& figure_;
    const CageFile& cage_;
    FigureControl control_;
    OutsideChoice outside_;
    std::array<cageform::Binding<double, 2>, 2> axes_;
};

int run_program(int argc, char** argv) {
    CommandLine line("Draws poses of a figure by pins, beside those of the least moves of its cage that take "
                     "the pins to the same targets.");
    line.set_examples({"cat.svg --cage auto --pinned \"212,740 645,740 915,165:760,60\" -o cat_pins_"});
    Arguments given;
    line.add("figure", given.figure, "the SVG file to deform").required();
    line.add("--cage", given.cage, "its cage, an SVG or CSV file" + std::string(auto_cage_help)).required();
    line.add_text(
            "--pinned", [&](const std::string& words) { given.poses.push_back(words); },
            "the pins of a pose, as --pin of deform_svg takes them, with blanks between them; one pose for "
            "each --pinned")
        .in_order()
        .required();
    line.add("-o,--output", given.out, "what the names of the files begin with: 1.svg, 1_least.svg, 2.svg, …")
        .required();
    given.choice.in_plane = true;
    given.choice.add_options(line);
    line.set_footer(pins_format + std::string("\n") + cage_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    given.pins.solving.settled_step = 1e-6;

    const auto figure = load_svg(given.figure);
    if (!figure) return fail(to_string(figure.error()));
    const auto cage = load_or_make_cage(given.cage, *figure, given.choice.edges());
    if (!cage) return fail(to_string(cage.error()));
    PoseSheet sheet(given, *figure, *cage);
    OutputFiles outputs;
    for (std::size_t n = 0; n < given.poses.size(); ++n) {
        if (const std::string why = sheet.add(n, outputs); !why.empty()) return fail(why);
    }
    if (const auto error = outputs.commit()) return fail(*error);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return guarded("pin_poses", [&] { return run_program(argc, argv); });
}
