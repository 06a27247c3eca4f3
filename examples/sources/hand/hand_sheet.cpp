// Draws the hand in all poses, its control points, inflation on and off and three builds, and measures them.
//
//     hand_sheet out
//
// writes the pictures of hand_pictures.hpp, and prints one line per property (hand_acceptance.hpp).

#include "bound_hand.hpp"
#include "cli/command_line.hpp"
#include "hand_acceptance.hpp"
#include "hand_pictures.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"

#include <cstdio>

using namespace cageform_sources;

int run_program(int argc, char** argv) {
    CommandLine line(
        "Draws a hand in all its poses and builds, and measures how its skin follows its control points.");
    line.set_examples({"out"});
    std::string folder;
    line.add("folder", folder,
             "where hand_layers.png, hand_points.png, hand_poses.png, hand_bend.png, hand_inflation.png, "
             "hand_builds.png, hand_influence.png and hand_locality.png are written")
        .required();
    if (const auto code = line.parse(argc, argv)) return *code;

    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail("cannot make the folder " + folder + ": " + error.message());
    const BoundHand bound;
    if (bound.report.status != cageform::Status::ok) return fail(cageform::to_string(bound.report.status));
    const HandBuilder builder(bound);
    if (!builder.skin) return fail(std::string("the builds: ") + cageform::to_string(builder.skin.status()));
    const AcceptanceCount count = print_acceptance(bound, builder);

    OutputFiles outputs;
    draw_hand(bound, builder, folder, outputs);
    fail_if(outputs.commit());
    std::printf("%zu of %zu lines are missed\n", count.missed, count.lines);
    return 0;
}
