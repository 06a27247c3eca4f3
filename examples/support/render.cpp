#include "render.hpp"

#include <cerrno>
#include <cstring>
#include <vector>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cageform_examples {

std::optional<std::string> render_png(const std::filesystem::path& svg, const std::filesystem::path& png,
                                      int width) {
    auto temporary = png;
    temporary += ".tmp" + std::to_string(getpid());
    std::vector<std::string> words{"rsvg-convert", "--background-color",  "white",    "--keep-aspect-ratio",
                                   "--width",      std::to_string(width), "--output", temporary.string(),
                                   "--",           svg.string()};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);

    std::error_code ignored;
    pid_t child = 0;
    const int spawned = posix_spawnp(&child, "rsvg-convert", nullptr, nullptr, arguments.data(), environ);
    if (spawned == ENOENT)
        return "cannot write " + png.string() + ": rsvg-convert (librsvg2-bin) is not installed";
    if (spawned != 0) return "cannot start rsvg-convert: " + std::string(std::strerror(spawned));
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        std::filesystem::remove(temporary, ignored);
        return "rsvg-convert could not render " + svg.string();
    }
    std::error_code error;
    std::filesystem::rename(temporary, png, error);
    if (!error) return std::nullopt;
    std::filesystem::remove(temporary, ignored);
    return "cannot write " + png.string() + ": " + error.message();
}

} // namespace cageform_examples
