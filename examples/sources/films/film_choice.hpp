#pragma once

// The options of all film programs: --stills, --gif, --frames and --rate.

#include "cli/command_line.hpp"
#include "io/atomic_file.hpp"
#include "pictures/render.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

struct FilmChoice {
    std::string stills, gif; // empty: none
    int frames = 0;
    double rate = 25;

    void add_options(CommandLine& line, int usual_frames, const std::string& kind) {
        frames = usual_frames;
        line.add("--stills", stills,
                 "also write every frame, " + kind + ": this name followed by 000, 001, …");
        line.add("--gif", gif, "also write a film that repeats without end, if ffmpeg is installed")
            .ends_with({".gif"});
        line.add("--frames", frames, "the number of frames").range(2, 999).show_default();
        line.add("--rate", rate, "the frames per second of the film").range(1.0, 25.0).show_default();
    }

    bool is_given() const { return !stills.empty() || !gif.empty(); }

    /// The path of a frame with an ending such as ".png".
    std::filesystem::path still(int n, const std::string& ending) const {
        const std::string number = std::to_string(n);
        return stills + std::string(3 - number.size(), '0') + number + ending;
    }

    /// Checks whether the files can be written, before a long computation; returns the error, if any.
    ///
    ///   others   other files that the program writes; empty paths are ignored
    std::optional<std::string> fault(std::vector<std::filesystem::path> others,
                                     const std::string& ending) const {
        others.emplace_back(gif);
        if (!stills.empty()) others.push_back(still(0, ending));
        return fault_of_outputs(others);
    }

    /// Writes the SVG documents of all frames, and their film.
    ///
    ///   png     whether single frames are rendered too
    ///   width   of a frame, in pixels
    ///   end     is_start: the last frame equals the first, and the film omits it
    enum class End { is_another, is_start };
    void write(OutputFiles& outputs, const std::vector<std::string>& documents, bool png, int width,
               End end = End::is_another) const {
        for (int n = 0; !stills.empty() && n < int(documents.size()) && !outputs.error(); ++n)
            add_svg(outputs, still(n, ".svg"), documents[std::size_t(n)], png ? width : 0);
        if (gif.empty()) return;
        Film film(outputs, gif, rate, width);
        const std::size_t played = documents.size() - (end == End::is_start ? 1 : 0);
        for (std::size_t n = 0; n < played && !outputs.error(); ++n) film.add_frame(documents[n]);
    }
};

} // namespace cageform_sources
