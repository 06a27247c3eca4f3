#pragma once

// SVG to PNG through librsvg's own program, and PNGs to films through ffmpeg; both started without a shell.

#include "io/atomic_file.hpp"
#include "pictures/picture.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace cageform_support {

/// The name of an SVG with the ending .png.
std::filesystem::path png_of(const std::filesystem::path& svg);

/// Adds a picture to the outputs: `svg`, which is one of them, under the name png_of() it.
///
///   svg     is finished; a note on stderr names a file that it shows by a link: the picture does not
///   width   of the picture, in pixels; on white
///   fails   where rsvg-convert is not there or cannot render the file: then commit() says so, and nothing
///           is written
void add_png(OutputFiles& outputs, AtomicFile& svg, int width);

/// Runs librsvg's program. It is given no name of a file, and so reads no files that the SVG names.
///
///   options   such as --format svg
///   in, out   descriptors that it reads an SVG from, and writes to
///   returns   empty, or why there is nothing: it is not installed, or cannot render what it read
std::string run_rsvg(std::vector<std::string> options, int in, int out);

/// A film that repeats without end, by the ending of its name: .gif, .mp4, else an animated PNG. Frames go
/// from rsvg-convert, or from memory, to ffmpeg by a pipe: nothing lies about in between.
///
///   rate    frames a second; a GIF has 25 at most
///   width   of frames that are SVGs, in pixels; on white
///   notes   as add_png() does, by the first frame
///   fails   where a program is not there or fails: then the outputs' commit() says so, and nothing is
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
    bool is_first_ = true; ///< the frame that comes next
};

} // namespace cageform_support
