#include "render.hpp"

#include <cerrno>
#include <cstring>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cageform_examples {

std::string run_rsvg(std::vector<std::string> options, int in, int out) {
    options.insert(options.begin(), "rsvg-convert");
    std::vector<char*> arguments;
    for (std::string& word : options) arguments.push_back(word.data());
    arguments.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (in >= 0) posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
    pid_t child = 0;
    const int spawned = posix_spawnp(&child, "rsvg-convert", &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (spawned == ENOENT) return "rsvg-convert (librsvg2-bin) is not installed";
    if (spawned != 0) return "cannot start rsvg-convert: " + std::string(std::strerror(spawned));
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
    const bool good = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    return good ? "" : "rsvg-convert could not render it";
}

void add_png(OutputFiles& outputs, AtomicFile& svg, int width) {
    AtomicFile& png = outputs.add(std::filesystem::path(svg.path()).replace_extension(".png"));
    if (svg.finish() || png.error()) return;
    const std::string fault = run_rsvg({"--background-color", "white", "--keep-aspect-ratio", "--width",
                                        std::to_string(width), "--", svg.temporary().string()},
                                       -1, png.descriptor());
    if (!fault.empty()) png.refuse(fault);
}

} // namespace cageform_examples
