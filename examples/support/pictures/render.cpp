#include "pictures/render.hpp"

#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cageform_support {

/// Starts a program on the PATH; `package` is its Debian package. Output -1 is inherited. Returns the error;
/// empty on success.
static std::string start(std::vector<std::string> words, const char* package, int input, int output,
                         pid_t& child) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    if (output >= 0) posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    const int spawned = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (spawned == ENOENT) return words[0] + " (" + package + ") is not installed";
    return spawned == 0 ? "" : "cannot start " + words[0] + ": " + std::strerror(spawned);
}

static bool ends_well(pid_t child) {
    int status = 0;
    while (waitpid(child, &status, 0) < 0) {
        if (errno != EINTR) return false;
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string run_rsvg(std::vector<std::string> options, int in, int out) {
    options.insert(options.begin(), "rsvg-convert");
    pid_t child = 0;
    const std::string fault = start(std::move(options), "librsvg2-bin", in, out, child);
    return !fault.empty() || ends_well(child) ? fault : "rsvg-convert could not render it";
}

/// Prints a note if an SVG links to a file.
static void note_linked_file(const pugi::xml_document& svg, const std::filesystem::path& picture) {
    for (pugi::xml_node node = svg.first_child(); node; node = detail::next_node(node, svg)) {
        const std::string kind = detail::local_name(node), link = detail::reference_of(node);
        if (link.empty() || link.starts_with('#') || link.starts_with("data:")) continue;
        if (kind.empty() || kind == "a") continue; // not drawn
        note(picture.string() + " does not show " + link + ", a file that the drawing links to");
        return;
    }
}

static std::string render_picture(int svg, int width, int png) {
    return run_rsvg({"--background-color", "white", "--keep-aspect-ratio", "--width", std::to_string(width)},
                    svg, png);
}

std::filesystem::path png_of(const std::filesystem::path& svg) {
    return std::filesystem::path(svg).replace_extension(".png");
}

void add_svg(OutputFiles& outputs, const std::filesystem::path& path, std::string_view text, int png_width) {
    AtomicFile& svg = outputs.add(path);
    svg.write(text);
    const bool is_written = !svg.finish(); // commit() returns the error
    if (png_width == 0) return;
    AtomicFile& png = outputs.add(png_of(path));
    if (!is_written || png.error()) return;
    const int file = open(svg.temporary().c_str(), O_RDONLY | O_CLOEXEC);
    if (file < 0) return png.refuse(std::strerror(errno));
    pugi::xml_document drawing;
    if (drawing.load_file(svg.temporary().c_str())) note_linked_file(drawing, png.path());
    const std::string fault = render_picture(file, png_width, png.descriptor());
    close(file);
    if (!fault.empty()) png.refuse(fault);
}

Film::Film(OutputFiles& outputs, const std::string& path, double rate, int width)
    : file_(outputs.add(path))
    , width_(width) {
    if (file_.error()) return;
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
        file_.refuse(std::strerror(errno));
        return;
    }
    pipe_ = ends[1];
    std::vector<std::string> words{
        "ffmpeg",     "-hide_banner", "-loglevel",           "error", "-nostdin", "-y", "-f",
        "image2pipe", "-framerate",   text_of("%.6g", rate), "-c:v",  "png",      "-i", "pipe:0"};
    const std::string ending = lowercase_extension(path);
    if (ending == ".gif") { // with one palette for all frames
        words.insert(words.end(), {"-vf",
                                   "fps=" + text_of("%.6g", std::min(rate, 25.0)) +
                                       ",split[a][b];[a]palettegen[p];[b][p]paletteuse",
                                   "-loop", "0", "-f", "gif"});
    } else if (ending == ".mp4") { // common players need an even width and height
        words.insert(words.end(), {"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p",
                                   "-movflags", "+faststart", "-f", "mp4"});
    } else {
        words.insert(words.end(), {"-plays", "0", "-f", "apng"});
    }
    words.push_back("file:/dev/fd/1"); // a descriptor, so that ffmpeg cannot recreate a removed file
    const std::string fault = start(words, "ffmpeg", ends[0], file_.descriptor(), ffmpeg_);
    close(ends[0]);
    if (fault.empty()) return;
    ffmpeg_ = 0;
    file_.refuse(fault);
}

void Film::add_frame(const std::string& svg) {
    if (file_.error()) return;
    pugi::xml_document drawing;
    if (is_first_ && drawing.load_string(svg.c_str())) note_linked_file(drawing, file_.path());
    is_first_ = false;
    std::FILE* const text = std::tmpfile();
    if (text == nullptr) return file_.refuse(std::strerror(errno));
    const bool written = std::fwrite(svg.data(), 1, svg.size(), text) == svg.size() && std::fflush(text) == 0;
    std::rewind(text);
    const std::string fault = written ? render_picture(fileno(text), width_, pipe_)
                                      : "a frame cannot be written to a temporary file";
    std::fclose(text);
    if (!fault.empty()) file_.refuse(fault);
}

void Film::add_frame(const Picture& picture) {
    const std::string png = picture.png();
    const auto before = std::signal(SIGPIPE, SIG_IGN); // if ffmpeg has exited, write() fails
    for (std::size_t done = 0; done < png.size() && !file_.error();) {
        const ssize_t count = write(pipe_, png.data() + done, png.size() - done);
        if (count < 0 && errno != EINTR) file_.refuse("ffmpeg could not make it");
        if (count > 0) done += std::size_t(count);
    }
    std::signal(SIGPIPE, before);
}

void Film::finish() {
    if (pipe_ >= 0) close(pipe_);
    pipe_ = -1;
    if (ffmpeg_ == 0) return;
    if (!ends_well(ffmpeg_)) file_.refuse("ffmpeg could not make it");
    ffmpeg_ = 0;
}

} // namespace cageform_support
