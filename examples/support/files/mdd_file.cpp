#include "files/mdd_file.hpp"

#include "io/input_file.hpp"

#include <bit>

namespace cageform_support {

Expected<MddFile> load_mdd(const std::string& path, std::size_t vertices) {
    const auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    const auto word = [&](std::size_t at) {
        std::uint32_t result = 0;
        for (std::size_t k = 0; k < 4; ++k)
            result = result << 8 | static_cast<unsigned char>((*bytes)[at + k]);
        return result;
    };
    if (bytes->size() < 8)
        return FileError{path + ": is no MDD file: it has " + std::to_string(bytes->size()) + " bytes"};
    const std::uint64_t frames = word(0), points = word(4);
    if (points != vertices) {
        return FileError{path + " has " + std::to_string(points) + " vertices, the figure " +
                         std::to_string(vertices) + ": give an MDD file of that figure"};
    }
    const std::uint64_t begin = 8 + 4 * frames, needed = begin + 12 * frames * points;
    if (bytes->size() != needed) {
        return FileError{path + ": has " + std::to_string(bytes->size()) + " bytes, but " +
                         std::to_string(frames) + " frames of " + std::to_string(points) + " vertices take " +
                         std::to_string(needed)};
    }
    MddFile file{std::vector<std::vector<Point3>>(frames, std::vector<Point3>(vertices)), {}};
    std::size_t at = begin;
    for (std::size_t t = 0; t < frames; ++t) {
        file.times.push_back(double(std::bit_cast<float>(word(8 + 4 * t))));
        for (std::size_t i = 0; i < vertices; ++i) {
            for (std::size_t k = 0; k < 3; ++k, at += 4)
                file.frames[t][i][k] = double(std::bit_cast<float>(word(at)));
        }
    }
    return file;
}

} // namespace cageform_support
