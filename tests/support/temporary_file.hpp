#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>

namespace cageform_tests {

/// A temporary file, removed by the destructor. Its name has a random number because tests run in parallel.
///
///   name   the end of the file's name, with the extension
struct TemporaryFile {
    TemporaryFile(const std::string& text, const std::string& name)
        : path((std::filesystem::temp_directory_path() /
                ("cageform-" + std::to_string(std::random_device()()) + '-' + name))
                   .string()) {
        std::ofstream(path, std::ios::binary) << text;
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() { std::filesystem::remove(path); }

    std::string path;
};

} // namespace cageform_tests
