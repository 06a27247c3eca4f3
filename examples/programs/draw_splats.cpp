// Renders a scene of 3D Gaussian splatting in software.
//
//     draw_splats scene.ply -o scene.png --view 60,20
//     draw_splats posed.ply --beside posed.obj -o both.png

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "files/obj_parts.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/splat_picture.hpp"
#include "pictures/view_choice.hpp"
#include "splats/splat_file.hpp"

#include <cageform/parallel/threads.hpp>

#include <optional>

using namespace cageform_support;

int run_program(int argc, char** argv) {
    CommandLine line(
        "Draws a scene of 3D Gaussian splatting to a PNG file. The camera is in front of all splats.");
    line.set_examples({"scene.ply -o scene.png --view 60,20", "posed.ply --beside posed.obj -o both.png"});
    std::string path, beside, out;
    int width = 1600, height = 1000;
    bool strict = false;
    ViewChoice view;
    line.add("scene", path, "the PLY file of splats to draw").required();
    line.add("-o,--output", out, "the PNG file to write").required().ends_with({".png"});
    line.add("--beside", beside, "also draw this mesh, left of the splats, with the same view");
    view.add_options(line);
    line.add("--width", width, "the picture's width in pixels").range(16, 16384).show_default();
    line.add("--height", height, "its height").range(16, 16384).show_default();
    line.add_flag("--strict", strict, "refuse a scene or a figure with invalid splats or vertices");
    line.set_footer(splat_format + std::string("\n") + mesh_formats);
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto scene = value_or_fail(load_splats(path, strict));
    warn(scene.warning);
    std::optional<MeshFile> mesh;
    if (!beside.empty()) {
        mesh = load_mesh_figure(beside, strict);
    }
    fail_if(fault_of_outputs({out}));
    const MeshView left = mesh ? MeshView{mesh->vertices, mesh->triangles} : MeshView{};
    const Picture picture =
        draw_splats(scene, mesh ? &left : nullptr, std::size_t(width), std::size_t(height), view.sight,
                    {.parallel = cageform::ThreadedFor{}, .progress = {}});
    OutputFiles outputs;
    picture.write_png(outputs.add(out));
    return commit(outputs);
}
