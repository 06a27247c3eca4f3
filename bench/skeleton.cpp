// How near is a fitted skeleton to a motion, and in what time? Prints a row for each number and kind of
// bones.
//
//     bench_skeleton MOTION [--bones 8,12,20,30] [--kind rigid|similar|stretched] [--influences K]
//                           [--threads N] [--keys DISTANCE]
//
// MOTION is frames.npy of float32, #frames · #vertices · 3, whose first frame is the rest, with the faces in
// frames_faces.npy of int32, #faces · 3; or the model of a game, .md3, whose first frame is the rest.
// Distances are shares of the figure's size; --keys makes keys
// that are so far off besides, and counts them.
#include <cageform/core/threads.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>

namespace {

using Point = cageform::Vec<double, 3>;

struct Motion {
    std::vector<std::vector<Point>> frames;
    std::vector<std::array<std::int32_t, 3>> faces;
};

std::string bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error(path + ": cannot be read");
    return {std::istreambuf_iterator<char>(file), {}};
}
template <class Number>
Number number_at(const std::string& bytes, std::size_t at) {
    Number result{};
    if (at + sizeof result > bytes.size()) throw std::runtime_error("the file ends early");
    std::memcpy(&result, bytes.data() + at, sizeof result);
    return result;
}

/// The numbers of a file of numpy, version 1, in the order of C, and its shape.
template <class Number>
std::vector<Number> read_npy(const std::string& path, std::vector<std::size_t>& shape) {
    const std::string bytes = bytes_of(path);
    const std::size_t begin = 10 + number_at<std::uint16_t>(bytes, 8);
    const std::string head = bytes.substr(0, begin);
    const std::string kind = std::is_same_v<Number, float> ? "<f4" : "<i4";
    const std::size_t at = head.find("'shape': (");
    if (head.substr(0, 6) != "\x93NUMPY" || head.find(kind) == std::string::npos || at == std::string::npos)
        throw std::runtime_error(path + ": is no array of " + kind);
    std::istringstream sizes(head.substr(at + 10));
    shape.clear();
    for (std::size_t size = 0; sizes >> size; sizes.get()) shape.push_back(size);
    std::vector<Number> numbers((bytes.size() - begin) / sizeof(Number));
    std::memcpy(numbers.data(), bytes.data() + begin, numbers.size() * sizeof(Number));
    return numbers;
}
Motion read_arrays(const std::string& path) {
    Motion motion;
    std::vector<std::size_t> shape;
    const auto places = read_npy<float>(path, shape);
    if (shape.size() != 3 || shape[2] != 3)
        throw std::runtime_error(path + ": is not #frames · #vertices · 3");
    for (std::size_t n = 0; n + 2 < places.size(); n += 3) {
        if (n % (3 * shape[1]) == 0) motion.frames.emplace_back();
        motion.frames.back().push_back({double(places[n]), double(places[n + 1]), double(places[n + 2])});
    }
    const auto faces = read_npy<std::int32_t>(path.substr(0, path.size() - 4) + "_faces.npy", shape);
    for (std::size_t n = 0; n + 2 < faces.size(); n += 3)
        motion.faces.push_back({faces[n], faces[n + 1], faces[n + 2]});
    return motion;
}
/// All surfaces of a vertex animation of Quake III, version 15.
Motion read_md3(const std::string& path) {
    const std::string bytes = bytes_of(path);
    const auto word = [&](std::size_t at) { return std::size_t(number_at<std::uint32_t>(bytes, at)); };
    Motion motion;
    motion.frames.resize(word(76));
    std::size_t surface = word(100);
    for (std::size_t n = word(84); n > 0; --n, surface += word(surface + 104)) {
        const std::size_t vertices = word(surface + 80), triangles = surface + word(surface + 88);
        const auto first = std::int32_t(motion.frames.at(0).size());
        for (std::size_t f = 0; f < word(surface + 84); ++f) {
            motion.faces.emplace_back();
            for (std::size_t k = 0; k < 3; ++k)
                motion.faces.back()[k] = first + std::int32_t(word(triangles + 12 * f + 4 * k));
        }
        for (std::size_t t = 0; t < motion.frames.size(); ++t) {
            for (std::size_t i = 0; i < vertices; ++i) {
                const std::size_t at = surface + word(surface + 100) + 8 * (t * vertices + i);
                Point p{};
                for (std::size_t k = 0; k < 3; ++k)
                    p[k] = double(number_at<std::int16_t>(bytes, at + 2 * k)) / 64;
                motion.frames[t].push_back(p);
            }
        }
    }
    return motion;
}

int run(int argc, char** argv) {
    if (argc < 2) throw std::runtime_error("give the file of a motion");
    const std::string path = argv[1];
    std::string list = "8,12,20,30", kind;
    cageform::SkeletonOptions options;
    unsigned threads = 1;
    double key_distance = -1;
    for (int n = 2; n + 1 < argc; n += 2) {
        const std::string option = argv[n], value = argv[n + 1];
        if (option == "--bones")
            list = value;
        else if (option == "--kind")
            kind = value;
        else if (option == "--influences")
            options.influences = std::stoul(value);
        else if (option == "--threads")
            threads = unsigned(std::stoul(value));
        else if (option == "--keys")
            key_distance = std::stod(value);
        else
            throw std::runtime_error("there is no option " + option);
    }
    const Motion motion =
        path.size() > 4 && path.substr(path.size() - 4) == ".md3" ? read_md3(path) : read_arrays(path);
    if (motion.frames.empty()) throw std::runtime_error(path + ": holds no frame");
    std::printf("%zu frames, %zu vertices, %u threads\n", motion.frames.size(), motion.frames[0].size(),
                threads);
    std::vector<double> times;
    for (std::size_t t = 0; t < motion.frames.size(); ++t) times.push_back(double(t) / 30);
    constexpr const char* kinds[] = {"rigid", "similar", "stretched"};
    for (std::size_t k = 0; k < 3; ++k) {
        if (!kind.empty() && kind != kinds[k]) continue;
        options.kind = cageform::BoneKind(k);
        std::istringstream numbers(list);
        for (std::string word; std::getline(numbers, word, ',');) {
            options.bones = std::stoul(word);
            cageform::Running running;
            running.parallel = cageform::ThreadedFor{threads};
            const auto [skeleton, report] =
                cageform::fit_skeleton(motion.frames[0], motion.frames, motion.faces, options, running);
            if (report.status != cageform::Status::ok) throw std::runtime_error(to_string(report.status));
            std::printf("%3zu %-9s  rms %.1e  largest %.1e  turned %4.1f  %5.2f s", report.bones, kinds[k],
                        report.rms, report.max_distance, report.turn, report.seconds);
            if (key_distance >= 0) {
                const auto [keys, made] =
                    cageform::fit_skeleton_keys(skeleton, motion.frames[0], times, key_distance);
                if (made.status != cageform::Status::ok) throw std::runtime_error(to_string(made.status));
                std::printf("  %zu keys, %zu numbers for %zu, off by %.1e, %.2f s", made.keys, made.numbers,
                            9 * skeleton.bones * skeleton.frames, made.max_distance, made.seconds);
            }
            std::printf("\n");
        }
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_skeleton: %s\n", error.what());
        return 1;
    }
}
