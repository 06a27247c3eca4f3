// The main function of all programs.

#include "io/messages.hpp"

#include <filesystem>

int main(int argc, char** argv) {
    const std::string name = std::filesystem::path(argv[0]).stem().string();
    return cageform_support::guarded(name.c_str(), [&] { return run_program(argc, argv); });
}
