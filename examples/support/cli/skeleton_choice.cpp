#include "cli/skeleton_choice.hpp"

#include "cli/progress_bar.hpp"
#include "files/gltf_skeleton.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/binding/skin_weights.hpp>
#include <cageform/parallel/threads.hpp>

#include <cmath>
#include <sstream>

namespace cageform_support {

namespace {

using cageform::Status;

std::string percent(double share) {
    std::ostringstream text;
    text.precision(3);
    text << 100 * share << " %";
    return text.str();
}

/// The error of a fit.
std::string why_not(const FigureFrames& frames, const cageform::SkeletonReport& report) {
    if (report.status != Status::frame_not_finite)
        return frames.name + ": " + cageform::to_string(report.status);
    const bool is_rest = report.frame == frames.places.size(), has_file = !is_rest && !frames.files.empty();
    const bool is_alone = has_file && frames.files.size() == frames.places.size();
    std::string text = (has_file ? frames.files[is_alone ? report.frame : 0] : frames.name) + ": ";
    if (!is_alone) text += (is_rest ? "the rest" : "frame " + std::to_string(report.frame)) + ", ";
    return text + "v " + std::to_string(report.vertex + 1) + ": " + cageform::to_string(report.status);
}

/// Rounds to single precision as glTF files do, so that measured errors are those of players.
void round_to_single(FittedMotion& motion) {
    const auto round = [](auto& values) {
        for (auto& value : values) {
            for (std::size_t k = 0; k < sizeof(value) / sizeof(double); ++k)
                value[k] = rounded_to_single(value[k]);
        }
    };
    round(motion.skeleton.joints);
    for (auto& bone : motion.keys.bones) {
        const auto round_all = [&](auto& channel) {
            round(channel.values);
            round(channel.in_tangents);
            round(channel.out_tangents);
        };
        round_all(bone.translation);
        round_all(bone.rotation);
        round_all(bone.scale);
        round_all(bone.axes);
    }
}

/// Measures the error of the played keys.
void measure(const FigureFrames& frames, FittedMotion& motion) {
    PackingLoss& loss = motion.loss;
    loss.size = cageform::bounds_of(std::span<const Point3>(used_positions(frames.rest, frames.triangles)))
                    .diagonal();
    if (!(loss.size > 0)) loss.size = cageform::bounds_of(std::span(frames.places[0])).diagonal();
    loss.poses = frames.places.size();
    std::vector<double> largest(frames.rest.size(), 0.0);
    cageform::FittedSkeleton<double> played = motion.skeleton;
    played.frames = 1;
    double squares = 0;
    for (std::size_t t = 0; t < frames.places.size(); ++t) {
        played.maps = motion.keys.maps(motion.skeleton, frames.times[t]);
        auto& places = motion.played.emplace_back();
        for (std::size_t i = 0; i < frames.rest.size(); ++i) {
            const Point3& rest = frames.rest[i];
            places.push_back(played.place(0, i, rounded_to_single(rest)));
            const Point3 d = places[i] - frames.places[t][i];
            const double distance = std::hypot(d[0], d[1], d[2]);
            squares += distance * distance;
            largest[i] = std::max(largest[i], distance);
            if (distance <= loss.largest) continue;
            loss.largest = distance;
            loss.vertex = i;
            loss.time = frames.times[t];
        }
    }
    loss.largest += single_precision_error(used_positions(frames.rest, frames.triangles));
    for (const double distance : largest) loss.mean += distance / double(largest.size());
    motion.rms = std::sqrt(squares / (double(largest.size()) * double(loss.poses)));
    if (loss.size > 0) motion.rms /= loss.size;
}

/// Prints a note on the error of players that read only four joints per vertex, if the file has more.
void note_loss_of_four(const FigureFrames& frames, const FittedMotion& motion) {
    const std::size_t sets = joint_sets(motion.skeleton.skin);
    if (sets <= 1) return;
    FittedMotion of_four = motion;
    of_four.played.clear();
    of_four.loss = {};
    of_four.skeleton.skin = first_set(motion.skeleton.skin);
    measure(frames, of_four);
    note(frames.name + ": " + describe_sets(sets) + "such a player is off by " + describe(of_four.loss));
}

/// The error if the figure is farther off than `asked`.
Failure too_far(const FigureFrames& frames, const FittedMotion& motion, double asked, bool searches) {
    return Failure(frames.name + ": " +
                   (searches ? "no number of bones that its vertices allow keeps it within " +
                                   percent(asked) + ": with " + count_bones(motion)
                             : count_bones(motion) + (motion.skeleton.bones == 1 ? " does" : " do") +
                                   " not keep it within " + percent(asked) + ":") +
                   " it is off by " + describe(motion.loss) + "; use a larger --max-distance, " +
                   (searches ? "" : "--bones auto, ") + "more --influences or --kind similar");
}

} // namespace

std::string parse_share(const std::string& word, double& share) {
    const bool is_percent = word.ends_with('%');
    const std::string number = is_percent ? word.substr(0, word.size() - 1) : word;
    if (const std::string why = detail::parse_number(number, share); !why.empty()) return why;
    if (is_percent) share /= 100;
    return share >= 0 && share <= 1 ? std::string()
                                    : detail::quoted(word) + " is not a fraction such as 0.002 or 0.2%";
}

CommandOption add_share(CommandLine& line, const std::string& name, double& share, const std::string& help) {
    return line.add_parsed(name, share, parse_share, help);
}

std::vector<CommandOption> SkeletonChoice::add_options(CommandLine& line) {
    const CommandOption moves =
        line.add("--kind", kind,
                 "how bones move: rigid (rotation), similar (also one scale factor, which children inherit) "
                 "or stretched (any affine map, by two nodes per bone; not every player supports it)")
            .one_of({"rigid", "similar", "stretched"})
            .show_default();
    const CommandOption most =
        line.add("--influences", influences, "the largest number of bones per vertex; engines use 4, some 8")
            .range(1, 8)
            .show_default();
    return {moves, most, line.add_flag("--flat", flat, "no hierarchy: bones have no parents"),
            line.add_flag("--tangents", tangents,
                          "cubic keys where they need fewer numbers; Blender ignores the tangents and shows "
                          "another motion")};
}

std::string SkeletonChoice::fault_of_bones(const std::string& word) {
    if (word == "auto") return {};
    double number = 0;
    const std::string why = detail::parse_number(word, number);
    constexpr auto most = cageform::SkeletonOptions::largest_bones;
    if (why.empty() && number >= 1 && number <= double(most) && number == std::floor(number)) return {};
    return detail::quoted(word) + " is neither \"auto\" nor a number of bones from 1 to " +
           std::to_string(most);
}

cageform::SkinWeights stored_skin(const cageform::SkinWeights& skin, const std::string& weights) {
    cageform::SkinWeights result = skin;
    const auto take = [&](const auto& integers) {
        using Integer = typename std::decay_t<decltype(integers)>::value_type;
        for (std::size_t n = 0; n < integers.size(); ++n)
            result.weights[n] = float(integers[n]) / float(std::numeric_limits<Integer>::max());
    };
    if (weights == "unorm8") take(cageform::to_normalised<std::uint8_t>(skin));
    if (weights == "unorm16") take(cageform::to_normalised<std::uint16_t>(skin));
    return result;
}

FittedMotion fit_motion(const SkeletonChoice& choice, const FigureFrames& frames,
                        const std::string& weights) {
    FittedMotion motion;
    const bool searches = choice.bones == "auto";
    const double asked =
        choice.distance > 0 || !searches ? choice.distance : SkeletonChoice::default_distance;
    constexpr double of_keys = 0.2; // fraction of the distance
    cageform::SkeletonOptions options;
    options.bones = searches ? 0 : std::stoul(choice.bones);
    options.influences = choice.influences;
    options.kind = choice.kind == "rigid"     ? cageform::BoneKind::rigid
                   : choice.kind == "similar" ? cageform::BoneKind::similar
                                              : cageform::BoneKind::stretched;
    options.max_distance = (1 - of_keys) * asked;
    {
        ProgressBar bar(searches ? "as many bones as needed" : choice.bones + " bones");
        auto fitted =
            cageform::fit_skeleton(frames.rest, frames.places, frames.triangles, options,
                                   {.parallel = cageform::ThreadedFor{}, .progress = bar.callback()});
        motion.report = fitted.report;
        if (!fitted) throw Failure(why_not(frames, fitted.report));
        motion.skeleton = std::move(fitted.value);
    }
    if (options.bones > motion.report.bones) {
        warn(frames.name + ": " + std::to_string(options.bones) + " bones were requested, but only " +
             count_bones(motion) + (motion.report.bones == 1 ? " is" : " are") + " useful");
    }
    make_sums_exact(motion.skeleton.skin);
    motion.skeleton.skin = stored_skin(motion.skeleton.skin, weights);
    if (choice.flat) {
        for (std::uint32_t& parent : motion.skeleton.parents)
            parent = cageform::FittedSkeleton<double>::no_parent;
    }
    {
        ProgressBar bar("keys");
        constexpr double unasked = 1e-4;
        const double distance = asked > 0 ? of_keys * asked : unasked;
        auto made = cageform::fit_skeleton_keys(motion.skeleton, frames.rest, frames.times,
                                                {distance, choice.tangents}, {.progress = bar.callback()});
        motion.keys_report = made.report;
        if (!made && made.report.status == Status::value_not_finite && !choice.flat) {
            throw Failure(frames.name + ": a bone with children has no size in some frame (" +
                          cageform::to_string(made.report.status) + "): use --flat");
        }
        if (!made) throw Failure(frames.name + ": " + cageform::to_string(made.report.status));
        motion.keys = std::move(made.value);
    }
    round_to_single(motion);
    measure(frames, motion);
    note_loss_of_four(frames, motion);
    if (asked > 0 && motion.loss.share() > asked) throw too_far(frames, motion, asked, searches);
    return motion;
}

std::string count_bones(const FittedMotion& motion) {
    return detail::counted(motion.skeleton.bones, "bone");
}

std::string describe_loss(const FittedMotion& motion) {
    std::ostringstream text;
    text.precision(3);
    text << "off by " << describe(motion.loss) << "; " << 100 * motion.rms
         << " % in the root mean square; 99 % of the faces turned wrongly by " << motion.report.turn
         << " degrees at most";
    return text.str();
}

std::string describe(const FittedMotion& motion) {
    std::ostringstream text;
    text.precision(3);
    const auto& keys = motion.keys_report;
    text << "bones: " << motion.report.bones << ", " << motion.report.mean_influences
         << " a vertex in the mean\n"
         << "keys: " << keys.keys << " in " << motion.skeleton.frames << " frames, " << keys.numbers
         << " numbers; off by at most " << 100 * keys.max_distance << " % of the figure's size\n"
         << describe_loss(motion) << "\ntime: " << motion.report.seconds << " s, keys " << keys.seconds
         << " s\n";
    return text.str();
}

} // namespace cageform_support
