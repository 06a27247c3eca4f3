// Wrap beside non-rigid ICP (Amberg, Romdhani, Vetter 2007): how close, how faithful, how long?
//
//     bench_wrap SOURCE.obj TARGET.obj [--clothes CLOTHES.obj] [--truth TRUTH.obj] [--finest 24]
//         [--cage 120]
//
// Prints a row for each method; with --cage also for a cage of so many vertices about source and clothes, and
// for this cage and a lattice. Lengths are percent of the target's height.
//
//     to target, to source  Mean distance of the wrapped source's vertices from the target, and back.
//     truth                 Mean distance of corresponding vertices. The file TRUTH is the target with the
//                           vertices of the source.
//     turned                Number of faces of the source whose normal is opposite to that of TRUTH.
//     own skin              Share of the clothes' vertices that passed through the wrapped source.
//     in target             Share of the clothes' vertices that were outside the source and are inside the
//                           target.
//     seconds               Time of the processor.
//
// The peer starts from the alignment of the wrap. Its clothes follow the nearest face.
#include "nonrigid_icp.hpp"

#include <cageform/coordinates/mean_value.hpp>
#include <cageform/enclose/make_cage_3d.hpp>
#include <cageform/fit/wrap.hpp>

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <string>

namespace {

using cageform::ClosestPlaces;
using cageform::SurfaceMesh;
using Point = cageform::Vec<double, 3>;
using Points = std::vector<Point>;

SurfaceMesh read_obj(const std::string& path) {
    tinyobj::ObjReader reader;
    if (!reader.ParseFromFile(path)) throw std::runtime_error(path + ": " + reader.Error());
    const auto& numbers = reader.GetAttrib().vertices;
    Points vertices;
    for (std::size_t i = 0; i + 2 < numbers.size(); i += 3)
        vertices.push_back({double(numbers[i]), double(numbers[i + 1]), double(numbers[i + 2])});
    std::vector<std::array<int, 3>> faces;
    for (const auto& shape : reader.GetShapes()) {
        const auto& corners = shape.mesh.indices;
        for (std::size_t c = 0; c + 2 < corners.size(); c += 3)
            faces.push_back(
                {corners[c].vertex_index, corners[c + 1].vertex_index, corners[c + 2].vertex_index});
    }
    return {vertices, faces};
}

struct Figures {
    SurfaceMesh source, target, clothes, truth;
    double height = 1;
};

double share_inside(const ClosestPlaces& surface, const Points& clothes,
                    const std::vector<char>& was_outside) {
    const auto is_outside = surface.are_outside(clothes);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < clothes.size(); ++i)
        inside += was_outside[i] != 0 && is_outside[i] == 0 ? 1 : 0;
    return clothes.empty() ? 0 : 100 * double(inside) / double(clothes.size());
}

void print_row(const char* name, const Figures& of, const Points& wrapped, const Points& clothes,
               double seconds) {
    const ClosestPlaces before(of.source.vertices(), of.source.faces()),
        target(of.target.vertices(), of.target.faces()), after(wrapped, of.source.faces());
    const auto was_outside = before.are_outside(of.clothes.vertices());
    const double percent = 100 / of.height;
    std::printf("%-15s %9.3f %9.3f", name, percent * target.distances(wrapped).mean,
                percent * after.distances(of.target.vertices()).mean);
    if (of.truth.vertices().empty()) {
        std::printf(" %7s %7s", "-", "-");
    } else {
        double sum = 0;
        std::size_t turned = 0;
        const auto truth = of.truth.vertices();
        for (std::size_t i = 0; i < wrapped.size(); ++i) {
            const auto d = wrapped[i] - truth[i];
            sum += std::sqrt(dot(d, d)) / double(wrapped.size());
        }
        for (const auto& [a, b, c] : of.source.faces()) {
            const auto normal = cross(wrapped[b] - wrapped[a], wrapped[c] - wrapped[a]);
            turned += dot(normal, cross(truth[b] - truth[a], truth[c] - truth[a])) < 0 ? 1 : 0;
        }
        std::printf(" %7.2f %7zu", percent * sum, turned);
    }
    std::printf(" %8.2f %9.2f %8.1f\n", share_inside(after, clothes, was_outside),
                share_inside(target, clothes, was_outside), seconds);
}

double processor_seconds() {
    return double(std::clock()) / CLOCKS_PER_SEC;
}

/// Wraps and prints a row. Returns the wrap.
///
///   coordinates  those of a cage, or nothing
template <class... C>
cageform::Wrap<double> wrap_row(const char* name, const Figures& of, unsigned finest,
                                const C&... coordinates) {
    cageform::WrapOptions options;
    options.finest = finest;
    options.follow = of.clothes.vertices();
    const double start = processor_seconds();
    const auto [wrap, report] = cageform::wrap(coordinates..., of.source, of.target, options);
    const double seconds = processor_seconds() - start;
    if (report.status != cageform::Status::ok) throw std::runtime_error(to_string(report.status));
    Points wrapped(of.source.vertices().size()), clothes(of.clothes.vertices().size());
    if (move(wrap, coordinates..., of.source.vertices(), wrapped) != cageform::Status::ok ||
        move(wrap, coordinates..., of.clothes.vertices(), clothes) != cageform::Status::ok)
        throw std::runtime_error("the wrap cannot be applied");
    print_row(name, of, wrapped, clothes, seconds);
    return wrap;
}

void wrap_by_cage(const Figures& of, unsigned finest, std::size_t cage_vertices) {
    Points enclosed(of.source.vertices().begin(), of.source.vertices().end());
    std::vector<SurfaceMesh::Face> faces(of.source.faces().begin(), of.source.faces().end());
    const auto first = std::uint32_t(enclosed.size());
    enclosed.insert(enclosed.end(), of.clothes.vertices().begin(), of.clothes.vertices().end());
    for (const auto& [a, b, c] : of.clothes.faces()) faces.push_back({a + first, b + first, c + first});
    const auto [cage, report] = cageform::make_cage(enclosed, faces, {.vertices = cage_vertices});
    if (report.status != cageform::Status::ok) throw std::runtime_error(to_string(report.status));
    const cageform::MeanValueCoordinates coordinates(cage);
    wrap_row("cage", of, 0, coordinates);
    wrap_row("cage, lattice", of, finest, coordinates);
}

void compare(const Figures& of, unsigned finest, std::size_t cage_vertices) {
    std::printf("%-15s %9s %9s %7s %7s %8s %9s %8s\n", "", "to target", "to source", "truth", "turned",
                "own skin", "in target", "seconds");
    const auto wrap = wrap_row("wrap", of, finest);
    if (cage_vertices > 0) wrap_by_cage(of, finest, cage_vertices);

    Points aligned, aligned_clothes;
    for (const auto& p : of.source.vertices())
        aligned.push_back(wrap.first.map_vector(p) + wrap.first.translation);
    for (const auto& p : of.clothes.vertices())
        aligned_clothes.push_back(wrap.first.map_vector(p) + wrap.first.translation);
    const double start = processor_seconds();
    const auto peer =
        cageform_bench::nonrigid_icp(aligned, of.source.faces(), of.target.vertices(), of.target.faces());
    const double peer_seconds = processor_seconds() - start;
    const auto followed =
        cageform_bench::follow_faces(aligned, of.source.faces(), peer.vertices, aligned_clothes);
    print_row("non-rigid ICP", of, peer.vertices, followed, peer_seconds);
}

int run(const std::vector<std::string>& arguments) {
    Figures figures;
    std::vector<std::string> files;
    unsigned finest = 24;
    std::size_t cage_vertices = 0;
    for (std::size_t n = 0; n < arguments.size(); ++n) {
        const bool has_value = n + 1 < arguments.size();
        if (arguments[n] == "--clothes" && has_value)
            figures.clothes = read_obj(arguments[++n]);
        else if (arguments[n] == "--truth" && has_value)
            figures.truth = read_obj(arguments[++n]);
        else if (arguments[n] == "--finest" && has_value)
            finest = unsigned(std::strtoul(arguments[++n].c_str(), nullptr, 10));
        else if (arguments[n] == "--cage" && has_value)
            cage_vertices = std::strtoul(arguments[++n].c_str(), nullptr, 10);
        else
            files.push_back(arguments[n]);
    }
    if (files.size() != 2) {
        std::fputs("usage: bench_wrap SOURCE.obj TARGET.obj [--clothes FILE] [--truth FILE] [--finest CELLS] "
                   "[--cage VERTICES]\n",
                   stderr);
        return 2;
    }
    figures.source = read_obj(files[0]);
    figures.target = read_obj(files[1]);
    if (!figures.truth.vertices().empty() &&
        figures.truth.vertices().size() != figures.source.vertices().size())
        throw std::runtime_error("the truth has another number of vertices than the source");
    double low = 1e300, high = -1e300;
    for (const auto& p : figures.target.vertices()) {
        low = std::fmin(low, p[1]);
        high = std::fmax(high, p[1]);
    }
    figures.height = high - low;
    compare(figures, finest, cage_vertices);
    return 0;
}

} // namespace

int main(int count, char** arguments) {
    try {
        return run({arguments + 1, arguments + count});
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_wrap: %s\n", error.what());
        return 1;
    }
}
