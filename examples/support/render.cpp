#include "render.hpp"

#include <cerrno>
#include <cstring>
#include <vector>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cageform_examples {

void add_png(OutputFiles& outputs, AtomicFile& svg, int width) {
    AtomicFile& png = outputs.add(std::filesystem::path(svg.path()).replace_extension(".png"));
    if (svg.finish() || png.error()) return;
    std::vector<std::string> words{"rsvg-convert", "--background-color",  "white", "--keep-aspect-ratio",
                                   "--width",      std::to_string(width), "--",    svg.temporary().string()};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, png.descriptor(), STDOUT_FILENO);
    pid_t child = 0;
    const int spawned = posix_spawnp(&child, "rsvg-convert", &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (spawned == ENOENT) return png.refuse("rsvg-convert (librsvg2-bin) is not installed");
    if (spawned != 0) return png.refuse("cannot start rsvg-convert: " + std::string(std::strerror(spawned)));
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) png.refuse("rsvg-convert could not render it");
}

} // namespace cageform_examples
