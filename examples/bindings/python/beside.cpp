// Runs the same binds and clones as the Python package, for its test and its benchmark.
#include <cageform/binding/pack.hpp>
#include <cageform/cageform.hpp>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

namespace {

template <class Item>
std::vector<Item> read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    std::vector<Item> items(bytes.size() / sizeof(Item));
    std::copy_n(bytes.data(), items.size() * sizeof(Item), reinterpret_cast<char*>(items.data()));
    return items;
}

void write(const std::string& path, const void* data, std::size_t bytes) {
    std::ofstream(path, std::ios::binary).write(static_cast<const char*>(data), std::streamsize(bytes));
}

template <class Action>
double seconds(const Action& action) {
    const auto start = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class T>
int run(const std::string& folder, int repeats) {
    using Point = std::array<T, 3>;
    const auto vertices = read<std::array<double, 3>>(folder + "/vertices");
    const auto faces = read<std::array<std::uint32_t, 3>>(folder + "/faces");
    const auto points = read<Point>(folder + "/points"), pose = read<Point>(folder + "/pose");
    const cageform::MeanValueCoordinates<T, 3> coordinates(vertices, faces);
    auto [figure, report] = cageform::bind(coordinates, cageform::FigurePoints{points});
    if (report.status != cageform::Status::ok) return std::puts(to_string(report.status)), 1;

    std::vector<Point> out(points.size());
    std::vector<T> weights;
    for (std::size_t n = 0; n < points.size(); ++n)
        for (std::size_t handle = 0; handle < pose.size(); ++handle)
            weights.push_back(figure.points.weight(n, handle));
    cageform::FigurePackOptions options;
    options.weights.tolerance = 1e-3;
    const auto packed = pack(figure, options);
    if (!packed || clone(figure.points, pose, out) != cageform::Status::ok) return 1;
    write(folder + "/clone", out.data(), out.size() * sizeof(Point));
    write(folder + "/weights", weights.data(), weights.size() * sizeof(T));
    write(folder + "/figure", packed.value.bytes().data(), packed.value.bytes().size());

    std::printf("bind");
    for (int n = 0; n < repeats; ++n)
        std::printf(" %.9f", seconds([&] {
                        static_cast<void>(cageform::bind(coordinates, cageform::FigurePoints{points}));
                    }));
    std::printf("\nclone");
    for (int n = 0; n < 20 * repeats; ++n)
        std::printf(" %.9f", seconds([&] { static_cast<void>(clone(figure.points, pose, out)); }));
    std::printf("\n");
    return 0;
}

} // namespace

int main(int count, char** arguments) {
    const std::string scalar = count == 4 ? arguments[2] : "";
    if (scalar == "float32") return run<float>(arguments[1], std::stoi(arguments[3]));
    if (scalar == "float64") return run<double>(arguments[1], std::stoi(arguments[3]));
    std::puts("usage: beside FOLDER float32|float64 REPEATS\n"
              "FOLDER contains arrays as bytes: vertices (double) and faces (triangles) of a cage, points,\n"
              "pose. Writes clone, weights and figure (a packed file) to FOLDER. Prints the seconds of each\n"
              "bind and clone.");
    return 2;
}
