// Makes tiles for bind_tiles: random points on the faces of a mesh, uniform by area, as binary PLY files.
//
//     make_tiles character.obj --points 100000000 --tiles 64 -o 'tiles/%02d.ply'
//
// A tile contains consecutive faces of the mesh. Points depend on the mesh, the number of points and --seed,
// not on the number of tiles.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/row_range.hpp"
#include "files/obj_file.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string mesh, output, rows;
    std::size_t points = 100000, tiles = 1, seed = 1;
    bool is_strict = false;
};

/// A random number in [0, 1), a function of `n` (Steele, Lea, Flood, Fast Splittable Pseudorandom Number
/// Generators, OOPSLA 2014, fig. 16).
double random_at(std::uint64_t n) {
    n = (n + 1) * 0x9E3779B97F4A7C15U;
    n = (n ^ (n >> 30)) * 0xBF58476D1CE4E5B9U;
    n = (n ^ (n >> 27)) * 0x94D049BB133111EBU;
    return double((n ^ (n >> 31)) >> 11) * 0x1p-53;
}

/// Points on the faces of a mesh, in the order of the faces.
class FacePoints {
public:
    FacePoints(const MeshFile& mesh, std::size_t count, std::size_t seed)
        : mesh_(mesh)
        , count_(count)
        , seed_(std::uint64_t{seed} << 40) {
        double area = 0;
        for (const auto& [a, b, c] : mesh.triangles) {
            const auto& p = mesh.vertices;
            const Point3 normal = cross(p[b] - p[a], p[c] - p[a]);
            area += 0.5 * std::sqrt(dot(normal, normal));
            ends_.push_back(area);
        }
    }
    double area() const { return ends_.empty() ? 0 : ends_.back(); }

    /// Point n, from the n-th of `count` strips of equal area.
    Point3 at(std::size_t n) const {
        const auto random = [&](std::uint64_t k) { return random_at((seed_ + n) * 3 + k); };
        const double place = (double(n) + random(0)) / double(count_) * area();
        const auto found = std::upper_bound(ends_.begin(), ends_.end() - 1, place) - ends_.begin();
        const auto& [a, b, c] = mesh_.triangles[std::size_t(found)];
        const double root = std::sqrt(random(1)), side = random(2);
        const auto& p = mesh_.vertices;
        return p[a] + (root * (1 - side)) * (p[b] - p[a]) + (root * side) * (p[c] - p[a]);
    }

private:
    const MeshFile& mesh_;
    std::size_t count_;
    std::uint64_t seed_;
    std::vector<double> ends_; // cumulative areas of triangles
};

std::optional<std::string> write_tile(const FacePoints& points, std::size_t begin, std::size_t end,
                                      const std::string& path) {
    AtomicFile file(path);
    file.write("ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(end - begin) +
               "\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
    std::string block;
    for (std::size_t n = begin; n < end && !file.error(); ++n) {
        const Point3 point = points.at(n);
        for (int k = 0; k < 3; ++k) {
            auto bits = std::bit_cast<std::uint32_t>(float(point[std::size_t(k)]));
            for (int byte = 0; byte < 4; ++byte, bits >>= 8) block += char(bits & 0xffU);
        }
        if (block.size() < 65536 && n + 1 < end) continue;
        file.write(block);
        block.clear();
    }
    return file.commit();
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Makes files of random points on the faces of a mesh, for bind_tiles.");
    line.set_examples({"character.obj --points 1000000 --tiles 8 -o 'tiles/%02d.ply'"});
    Arguments given;
    line.add("mesh", given.mesh, "a mesh with faces").required();
    line.add("--points", given.points, "the number of points in all tiles").show_default();
    line.add("--tiles", given.tiles, "the number of files").range(1, 1000000).show_default();
    add_rows(line, given.rows);
    line.add("--seed", given.seed, "the seed of the random positions").range(0, 1000000).show_default();
    line.add("-o,--output", given.output,
             "the files to write; with several a path with %d, or %03d, for the number of a tile")
        .required()
        .ends_with({".ply"})
        .check(RowPath::fault);
    add_strict(line, given.is_strict);
    line.set_footer(mesh_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    const RowRange rows = RowRange::of(given.rows.empty() ? ":" : given.rows).value_or(RowRange{});
    const RowPath path(given.output);
    if (!path.has_place() && given.tiles > 1)
        return fail("--output " + given.output + ": write %d in place of the number of a tile");
    const auto mesh = load_mesh_figure(given.mesh, given.is_strict);
    fail_if(rounding_fault(given.mesh, mesh.vertices));
    const FacePoints points(mesh, given.points, given.seed);
    if (!(points.area() > 0 && std::isfinite(points.area())))
        return fail(mesh.name + ": its faces have no area, so no points lie on them");
    const auto first_of = [&](std::size_t tile) {
        return given.points / given.tiles * tile + std::min(tile, given.points % given.tiles);
    };
    for (std::size_t tile = rows.first; tile < std::min(rows.end, given.tiles); ++tile) {
        fail_if(write_tile(points, first_of(tile), first_of(tile + 1), path.of(tile)));
    }
    return 0;
}
