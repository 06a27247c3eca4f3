#pragma once

// Renders SVG to PNG by rsvg-convert, and films by ffmpeg. Both are started without a shell.

#include "io/atomic_file.hpp"
#include "pictures/picture.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace cageform_support {

/// The path of an SVG with the extension .png.
std::filesystem::path png_of(const std::filesystem::path& svg);

/// Adds an SVG file to the outputs and, if asked, its picture: another output png_of(path).
///
///   png_width   of the picture, in pixels; white background. 0: no picture. A note on stderr names a linked
///               file, which is not rendered
///   fails       if rsvg-convert is missing or fails; commit() then returns the error, and nothing is written
void add_svg(OutputFiles& outputs, const std::filesystem::path& path, std::string_view text, int png_width);

/// Runs rsvg-convert. It gets no file name, so it does not read files that the SVG references.
///
///   options   such as --format svg
///   in, out   descriptors of the SVG and the output
///   returns   the error (not installed, cannot render); empty on success
std::string run_rsvg(std::vector<std::string> options, int in, int out);

/// A repeating film; the extension selects .gif, .mp4, else animated PNG. Frames go from rsvg-convert, or
/// from memory, to ffmpeg through a pipe, without temporary files.
///
///   rate    frames per second; at most 25 in GIF
///   width   of SVG frames, in pixels; white background
///   notes   as add_svg(), for the first frame
///   fails   if a program is missing or fails; commit() of the outputs then returns the error, and nothing is
///           written
class Film {
public:
    Film(OutputFiles& outputs, const std::string& path, double rate, int width);
    Film(const Film&) = delete;
    Film& operator=(const Film&) = delete;
    ~Film() { finish(); }

    void add_frame(const std::string& svg);
    void add_frame(const Picture& picture);
    void finish(); ///< after the last frame

private:
    AtomicFile& file_;
    int width_;
    int pipe_ = -1; ///< to ffmpeg
    pid_t ffmpeg_ = 0;
    bool is_first_ = true; ///< whether the next frame is the first
};

} // namespace cageform_support
