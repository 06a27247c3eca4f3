// How close is a fitted skeleton to a motion, and how long does it take? Prints a row for each number and
// kind of bones.
//
//     bench_skeleton MOTION [--bones 8,12,20,30] [--kind rigid|similar|stretched] [--influences K]
//                           [--rounds 10] [--moves 8] [--threads N] [--every N] [--keys DISTANCE]
//     bench_skeleton MOTION --planted SEED,… [--bones 12] [--rounds 10,60]
//
// MOTION is frames.npy (float32, #frames · #vertices · 3) with faces in frames_faces.npy (int32, #faces · 3),
// or a game model, .md3. The first frame is the rest pose. Distances are relative to the figure's size.
// Seconds are processor time, then elapsed time. --every uses each N-th frame; --keys also makes keys within
// DISTANCE and counts them.
//
// --planted uses only the rest pose of MOTION and moves it by a known skeleton, one per seed, with 12 bones
// at random vertices. Each vertex follows the four nearest bones, with weights exp(−d²/2(0.12 size)²). In 40
// frames each bone rotates about two random axes by 0.8 sin(2πt/40) and 0.8 sin(4πt/40) radians. A random
// shift of 0.05 size along each axis is added. A fit of 12 bones can be exact.
#include <cageform/parallel/threads.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <random>
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

/// Reads the numbers and the shape of a numpy file, version 1, C order.
template <class Number>
std::vector<Number> read_npy(const std::string& path, std::vector<std::size_t>& shape) {
    const std::string bytes = bytes_of(path);
    const std::size_t begin = 10 + number_at<std::uint16_t>(bytes, 8);
    const std::string head = bytes.substr(0, begin);
    const std::string kind = std::is_same_v<Number, float> ? "<f4" : "<i4";
    const std::size_t at = head.find("'shape': (");
    if (head.substr(0, 6) != "\x93NUMPY" || head.find(kind) == std::string::npos || at == std::string::npos)
        throw std::runtime_error(path + ": not an array of " + kind);
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
        throw std::runtime_error(path + ": not an array of #frames · #vertices · 3");
    for (std::size_t n = 0; n + 2 < places.size(); n += 3) {
        if (n % (3 * shape[1]) == 0) motion.frames.emplace_back();
        motion.frames.back().push_back({double(places[n]), double(places[n + 1]), double(places[n + 2])});
    }
    const auto faces = read_npy<std::int32_t>(path.substr(0, path.size() - 4) + "_faces.npy", shape);
    for (std::size_t n = 0; n + 2 < faces.size(); n += 3)
        motion.faces.push_back({faces[n], faces[n + 1], faces[n + 2]});
    return motion;
}
/// Reads all surfaces of a Quake III vertex animation, version 15.
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

/// Rotates about a unit axis.
Point turned(const Point& p, const Point& axis, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return c * p + (s * cross(axis, p) + ((1 - c) * dot(axis, p)) * axis);
}
/// Moves the rest pose by twelve bones at random vertices.
Motion planted(const Motion& of, std::uint32_t seed) {
    const std::vector<Point>& rest = of.frames[0];
    const double size = bounds_of(std::span<const Point>(rest)).diagonal();
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto vector = [&] {
        const double x = normal(random), y = normal(random), z = normal(random);
        return Point{x, y, z};
    };
    constexpr std::size_t frame_count = 40;
    Motion result{{frame_count, std::vector<Point>(rest.size(), Point{})}, of.faces};
    struct Bone {
        Point place;
        std::array<Point, 2> axes;
        std::array<Point, frame_count> shifts;
    };
    std::array<Bone, 12> bones;
    for (Bone& bone : bones) {
        bone.place = rest[random() % rest.size()];
        for (Point& axis : bone.axes) {
            axis = vector();
            axis = (1 / cageform::detail::length(axis)) * axis;
        }
        for (Point& shift : bone.shifts) shift = (0.05 * size) * vector();
    }
    for (std::size_t i = 0; i < rest.size(); ++i) {
        std::array<std::pair<double, const Bone*>, bones.size()> order;
        for (std::size_t j = 0; j < bones.size(); ++j) {
            const Point d = rest[i] - bones[j].place;
            order[j] = {dot(d, d), &bones[j]};
        }
        std::sort(order.begin(), order.end());
        std::array<double, 4> weights;
        double sum = 0;
        for (std::size_t k = 0; k < weights.size(); ++k) // the first weight is 1, so that not all are 0
            sum += weights[k] = std::exp((order[0].first - order[k].first) / (2 * 0.12 * 0.12 * size * size));
        for (std::size_t t = 0; t < frame_count; ++t) {
            for (std::size_t k = 0; k < weights.size(); ++k) {
                const Bone& bone = *order[k].second;
                const double phase = 2 * 3.14159265358979323846 * double(t) / double(frame_count);
                Point p = rest[i] - bone.place;
                p = turned(p, bone.axes[0], 0.8 * std::sin(phase));
                p = turned(p, bone.axes[1], 0.8 * std::sin(2 * phase));
                result.frames[t][i] =
                    result.frames[t][i] + (weights[k] / sum) * (p + (bone.place + bone.shifts[t]));
            }
        }
    }
    return result;
}

std::size_t number_of(const std::string& word) {
    if (word.empty() || word.size() > 9 || word.find_first_not_of("0123456789") != std::string::npos)
        throw std::runtime_error("\"" + word + "\" is not a number");
    return std::stoul(word);
}
std::vector<std::size_t> numbers_of(const std::string& list) {
    std::vector<std::size_t> numbers;
    std::istringstream words(list);
    for (std::string word; std::getline(words, word, ',');) numbers.push_back(number_of(word));
    return numbers;
}

struct Arguments {
    std::string kind;
    std::vector<std::size_t> bones, rounds, seeds;
    cageform::SkeletonOptions options;
    unsigned threads = 1;
    std::size_t every = 1;
    double key_distance = -1;
};

void print_row(const Motion& motion, const std::vector<Point>& rest, const Arguments& given,
               const cageform::SkeletonOptions& options) {
    constexpr const char* kinds[] = {"rigid", "similar", "stretched"};
    cageform::Running running;
    running.parallel = cageform::ThreadedFor{given.threads};
    const auto start = std::clock();
    const auto [skeleton, report] =
        cageform::fit_skeleton(rest, motion.frames, motion.faces, options, running);
    const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
    if (report.status != cageform::Status::ok) throw std::runtime_error(to_string(report.status));
    std::printf("%3zu %-9s  rms %.1e  largest %.1e  turned %4.1f  %5.2f s, %5.2f s", report.bones,
                kinds[std::size_t(options.kind)], report.rms, report.max_distance, report.turn, seconds,
                report.seconds);
    if (given.rounds.size() > 1) std::printf("  %zu rounds", options.rounds);
    if (given.key_distance >= 0) {
        std::vector<double> times;
        for (std::size_t t = 0; t < motion.frames.size(); ++t) times.push_back(double(t) / 30);
        const auto [keys, made] = cageform::fit_skeleton_keys(skeleton, rest, times, {given.key_distance});
        if (made.status != cageform::Status::ok) throw std::runtime_error(to_string(made.status));
        std::printf("  %zu keys, %zu numbers for %zu, off by %.1e, %.2f s", made.keys, made.numbers,
                    9 * skeleton.bones * skeleton.frames, made.max_distance, made.seconds);
    }
    std::printf("\n");
    std::fflush(stdout);
}
void print_rows(const Motion& motion, const std::vector<Point>& rest, const Arguments& given) {
    std::printf("%zu frames, %zu vertices, %u threads\n", motion.frames.size(), rest.size(), given.threads);
    constexpr const char* kinds[] = {"rigid", "similar", "stretched"};
    cageform::SkeletonOptions options = given.options;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!given.kind.empty() && given.kind != kinds[k]) continue;
        options.kind = cageform::BoneKind(k);
        for (const std::size_t bones : given.bones) {
            options.bones = bones;
            for (const std::size_t rounds : given.rounds) {
                options.rounds = rounds;
                print_row(motion, rest, given, options);
            }
        }
    }
}

int run(int argc, char** argv) {
    if (argc < 2) throw std::runtime_error("missing MOTION");
    const std::string path = argv[1];
    Arguments given;
    for (int n = 2; n < argc; n += 2) {
        const std::string option = argv[n];
        if (n + 1 == argc) throw std::runtime_error("option " + option + " has no value");
        const std::string value = argv[n + 1];
        if (option == "--bones")
            given.bones = numbers_of(value);
        else if (option == "--kind" && (value == "rigid" || value == "similar" || value == "stretched"))
            given.kind = value;
        else if (option == "--influences")
            given.options.influences = number_of(value);
        else if (option == "--rounds")
            given.rounds = numbers_of(value);
        else if (option == "--moves")
            given.options.moves = number_of(value);
        else if (option == "--threads")
            given.threads = unsigned(number_of(value));
        else if (option == "--every")
            given.every = number_of(value);
        else if (option == "--keys")
            given.key_distance = std::stod(value);
        else if (option == "--planted")
            given.seeds = numbers_of(value);
        else
            throw std::runtime_error("invalid option " + option + " " + value);
    }
    if (given.every == 0) throw std::runtime_error("--every must be at least 1");
    Motion motion =
        path.size() > 4 && path.substr(path.size() - 4) == ".md3" ? read_md3(path) : read_arrays(path);
    if (motion.frames.empty()) throw std::runtime_error(path + ": no frames");
    const std::vector<Point> rest = motion.frames[0];
    if (!given.seeds.empty()) {
        if (given.bones.empty()) given.bones = {12};
        if (given.rounds.empty()) given.rounds = {10, 60};
        if (given.kind.empty()) given.kind = "rigid";
        for (const std::size_t seed : given.seeds) {
            std::printf("12 bones planted, seed %zu: ", seed);
            print_rows(planted(motion, std::uint32_t(seed)), rest, given);
        }
        return 0;
    }
    if (given.bones.empty()) given.bones = {8, 12, 20, 30};
    if (given.rounds.empty()) given.rounds = {given.options.rounds};
    std::vector<std::vector<Point>> frames;
    for (std::size_t t = 0; t < motion.frames.size(); t += given.every) frames.push_back(motion.frames[t]);
    motion.frames = std::move(frames);
    print_rows(motion, rest, given);
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
