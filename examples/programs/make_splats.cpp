// Makes a scene of 3D Gaussian splatting from a mesh, as input for deform_splats.
//
//     make_splats character.obj -o scene.ply
//     make_splats character.obj -o scene.ply --count 1000000 --degree 1 --seed 7

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "splats/surface_splats.hpp"

#include <cmath>
#include <iostream>

using namespace cageform_support;

int run_program(int argc, char** argv) {
    CommandLine line("Makes a scene of 3D Gaussian splatting from a mesh: flat splats on its faces, with "
                     "colour bands and a view-dependent gloss.");
    line.set_examples(
        {"model.obj -o scene.ply", "model.obj -o scene.ply --count 1000000 --degree 1 --seed 7"});
    std::string path, out;
    SurfaceSplatOptions options;
    std::size_t seed = options.seed;
    bool is_strict = false;
    line.add("mesh", path, "the mesh to cover").required();
    line.add("-o,--output", out, "the PLY file to write").required().ends_with({".ply"});
    line.add("--count", options.count, "the number of splats").range(1, 20000000).show_default();
    line.add("--degree", options.degree, "the degree of spherical harmonics: 0 has no view dependence")
        .range(0, 3)
        .show_default();
    line.add("--seed", seed, "the seed of the random positions").show_default();
    add_strict(line, is_strict);
    line.set_footer(splat_format + std::string("\n") + mesh_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    options.seed = seed;

    const auto mesh = load_mesh_figure(path, is_strict);
    if (const double area = area_of(mesh); !(area > 0) || !std::isfinite(area))
        return fail(path + ": its faces have no area");
    fail_if(single_precision_fault(mesh));
    fail_if(rounding_fault(path, mesh.vertices));
    fail_if(fault_of_outputs({out}));
    const SplatFile scene = splats_on(mesh, options);
    OutputFiles outputs;
    AtomicFile& file = outputs.add(out);
    file.write(scene.header_text(scene.size()));
    file.write(scene.rows);
    fail_if(outputs.commit());
    if (const std::string others = describe_others(mesh, {"v", "f"}); !others.empty())
        note(path + ": not used: " + others);
    std::cout << printable(out) << ": " << scene.size() << " splats of degree " << scene.layout.degree()
              << '\n';
    return 0;
}
