// The main function of all programs.

#include "io/messages.hpp"

#include <filesystem>

int main(int argc, char** argv) {
    const std::filesystem::path path(argc > 0 ? argv[0] : "");
    const std::string name = (path.extension() == ".exe" ? path.stem() : path.filename()).string();
    return cageform_support::guarded(name.c_str(), [&] { return run_program(argc, argv); });
}
