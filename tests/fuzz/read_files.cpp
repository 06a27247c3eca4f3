// Feeds texts to the readers of files of the examples, and what they take to what follows: for libFuzzer.
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -Iinclude
//             -Iexamples/support -isystem /usr/include/eigen3 tests/fuzz/read_files.cpp
//             examples/support/{cli/{clip_motion,landmarks,mesh_cage,mesh_folds,pins,pose_operations},files/{bind_report,cage_file,clip_file,curved_cage,gltf_*,lattice_file,marker_file,medit_file,mesh_file,moved_normals,obj_file,obj_parts,ply_file,ply_mesh,point_table,site_file,stl_file},io/*,svg/*}.cpp
//             -lpugixml -lz -ltinyobjloader_double -o fuzz_read_files
//     mkdir corpus && ./fuzz_read_files --reader=obj --seeds=corpus && ./fuzz_read_files --reader=obj corpus
//
// tests/gltf/make_models.py writes more seeds of glTF files.
// Readers: cage (CSV), clip, css, gltf, landmarks, lottie, markers, medit, obj, pins, ply, points (CSV), poses, stl. SVG has a driver of its own.
#include "cli/landmarks.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/mesh_folds.hpp"
#include "cli/pins.hpp"
#include "files/cage_file.hpp"
#include "files/clip_file.hpp"
#include "files/gltf_skeleton.hpp"
#include "files/lottie_file.hpp"
#include "files/marker_file.hpp"
#include "files/medit_file.hpp"
#include "files/obj_parts.hpp"
#include "files/ply_mesh.hpp"
#include "files/stl_file.hpp"

#include <cageform/exchange/css.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace cageform_support;

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "line %d: %s\n", __LINE__, #condition);                                         \
        std::abort();                                                                                        \
    }

template <class T>
bool taken(const Expected<T>& result) {
    REQUIRE(result || !result.error().message.empty());
    return bool(result);
}

void read_cage(const std::string& text) {
    auto blocks = parse_cage_csv(text, "file.csv");
    if (!taken(blocks)) return;
    const CageFile cage = make_cage("file.csv", std::move(*blocks));
    for (const auto& handles : cage.handles) {
        for (const std::size_t i : handles) REQUIRE(i < cage.vertices.size());
    }
    bool finite = true;
    for (const Point2& p : cage.vertices) finite = finite && std::isfinite(p.x) && std::isfinite(p.y);
    REQUIRE(!finite || taken(make_pose(cage, cage)));
    (void)check(cage.polygon<float>());
    (void)check(cage.polygon<double>());
    cageform::BindReport report;
    report.cage = check(cage.complex<double>());
    report.status = report.cage.status;
    REQUIRE(describe_faults("file.csv", report).size() < 4000);
}

constexpr std::size_t vertices = 4; ///< of the cages that clips move

void read_clip(const std::string& text) {
    const auto clip = parse_clip(text, "file.csv", vertices);
    if (!taken(clip)) return;
    REQUIRE(clip->length > 0 && std::isfinite(clip->length));
    for (const ClipControl& control : clip->controls) {
        REQUIRE(control.rows.size() >= 2);
        for (const auto& share : control.shares) REQUIRE(share.vertex < vertices);
    }
}

/// Checks that pins are finite, and their weights positive.
template <std::size_t D>
void read_pins_in(const std::string& text) {
    const std::vector<cageform::Vec<double, D>> figure(5);
    const auto pins = parse_pins<D>(text, "file.csv", std::span(figure));
    if (taken(pins)) {
        for (const auto& pin : *pins) {
            REQUIRE(is_finite(pin.place) && is_finite(pin.target) && pin.weight > 0);
            REQUIRE(!pin.turn || is_finite(*pin.turn));
        }
        (void)contradiction(*pins);
    }
    const auto pin = parse_pin<D>(text, std::span(figure));
    if (taken(pin)) REQUIRE(is_finite(pin->place) && is_finite(pin->target));
}
void read_pins(const std::string& text) {
    read_pins_in<2>(text);
    read_pins_in<3>(text);
}

/// Checks that landmarks are finite, and their weights positive.
void read_landmarks(const std::string& text) {
    const std::vector<Point3> vertices{{0, 0, 0}, {1, 2, 3}};
    Landmarks landmarks;
    const std::string why = parse_landmarks(text, "file.csv", {vertices, vertices}, landmarks);
    REQUIRE(!why.empty() || !landmarks.marks.empty());
    (void)parse_landmark(text, {vertices, vertices}, landmarks);
    REQUIRE(landmarks.names.size() == landmarks.marks.size());
    for (const auto& mark : landmarks.marks)
        REQUIRE(cageform::is_finite(mark.from) && cageform::is_finite(mark.to) && mark.weight > 0);
}

/// Checks that points that stay give the text, and moved points can be read again.
void read_points(const std::string& text) {
    const auto table = parse_point_table(text, "file.csv");
    if (!taken(table)) return;
    REQUIRE(to_text(*table, table->points) == text);
    std::vector<Point3> moved;
    for (const Point3& p : table->points) moved.push_back({-p[1], p[2] + 1, p[0]});
    const auto again = parse_point_table(to_text(*table, moved), "file.csv");
    REQUIRE(taken(again) && again->points == moved && again->segments == table->segments);
    Landmarks landmarks;
    REQUIRE(add_landmarks(*table, *again, landmarks).empty());
}

void read_markers(const std::string& text) {
    const auto clip = parse_markers(text, "file.csv");
    if (!taken(clip)) return;
    REQUIRE(clip->has_pins() && clip->length > 0 && std::isfinite(clip->length));
    for (const ClipControl& marker : clip->controls) {
        REQUIRE(marker.pin && marker.rows.size() >= 2);
        REQUIRE(marker.rows.front().time == 0 && marker.rows.back().time == clip->length);
        for (std::size_t k = 0; k < marker.rows.size(); ++k) {
            REQUIRE(k == 0 || marker.rows[k].time > marker.rows[k - 1].time);
            REQUIRE(std::isfinite(marker.rows[k].move[0]) && std::isfinite(marker.rows[k].move[1]));
        }
    }
}

void read_poses(const std::string& text) {
    const auto clip = parse_pose_clip(text, "file.csv", vertices);
    if (!taken(clip)) return;
    const auto motion = make_clip<float>(*clip);
    const auto exact = make_clip<double>(*clip);
    auto cursor = motion.make_cursor();
    auto exact_cursor = exact.make_cursor();
    std::vector<cageform::Vec<float, 3>> pose(vertices);
    std::vector<Point3> exact_pose(vertices);
    for (const PoseKey& key : clip->keys) {
        motion.sample(float(key.time), cursor, pose);
        exact.sample(key.time, exact_cursor, exact_pose);
        for (std::size_t i = 0; i < vertices; ++i) {
            for (std::size_t k = 0; k < 3; ++k) REQUIRE(std::isfinite(float(key.places[i][k])));
        }
    }
    (void)pose_clip_text(*clip, "again");
    const std::vector<double> values(clip->keys.size() * 3, 1.0);
    (void)gltf_track(*clip, values, 3);
}

/// Checks the parts that glTF files get, and their triangles.
void check_parts(const MeshFile& file) {
    if (single_precision_fault(file)) return;
    const auto gltf = gltf_figure(file, "fuzz", GltfMotion::keep);
    if (!taken(gltf)) return;
    const ObjParts parts = read_parts(file);
    std::vector<std::size_t> written(parts.materials.size()), read(written); // triangles of a material
    for (const std::uint32_t face : file.triangle_faces) ++read[parts.face_materials[face]];
    for (const GltfSurface& surface : gltf->surfaces) {
        REQUIRE(gltf_normals(surface, file, {file.vertices}).size() == surface.corners.size());
        for (const GltfJson& primitive : gltf->document.json["meshes"][surface.mesh]["primitives"]) {
            const auto indices = gltf->document.indices(primitive["indices"].get<GltfIndex>(), "a primitive");
            written.at(primitive["material"].get<std::size_t>()) += indices.size() / 3;
            for (const std::uint32_t index : indices) REQUIRE(index < surface.corners.size());
        }
    }
    REQUIRE(written == read);
}

/// Checks the document of a mesh: at rest and with faces reversed twice it has the bytes of the file; written
/// with moved vertices, it is read with these, up to single precision.
void check_document(const MeshFile& file, const std::string& bytes,
                    Expected<MeshFile> (*parse)(std::string bytes)) {
    const auto same = file.document->moved(file, {file.vertices}, "same");
    REQUIRE(taken(same) && same->files.size() == 1 && same->files.front().bytes == bytes);
    for (const auto& triangle : file.triangles) {
        for (const std::uint32_t i : triangle) REQUIRE(i < file.vertices.size());
    }
    if (fault_of_reversing(file).empty()) {
        const MeshFile turned = with_faces_reversed(file);
        const auto again = turned.document->moved(turned, {file.vertices}, "turned");
        REQUIRE(taken(again) && taken(parse(again->files.front().bytes)));
    }
    auto moved = file.vertices;
    for (Point3& p : moved) p = {p[1], -p[2], 0.5 * p[0]};
    const std::vector<Jacobian3> jacobians(moved.size(), {Point3{0, 0, 0.5}, {1, 0, 0}, {0, -1, 0}});
    const auto written = file.document->moved(file, {moved, jacobians}, "moved");
    if (!taken(written)) return;
    const auto again = parse(written->files.front().bytes);
    REQUIRE(taken(again) && again->faces.size() == file.faces.size());
    const auto check = [&](const Point3& is, const Point3& wanted) {
        for (std::size_t k = 0; k < 3; ++k) REQUIRE(is[k] == wanted[k] || is[k] == double(float(wanted[k])));
    };
    for (std::size_t f = 0; f < file.faces.size(); ++f) {
        for (std::size_t n = 0; n < file.faces[f].corners.size(); ++n)
            check(again->vertices[again->faces[f].corners[n].vertex], moved[file.faces[f].corners[n].vertex]);
    }
    if (file.faces.empty()) {
        REQUIRE(again->vertices.size() == moved.size());
        for (std::size_t i = 0; i < moved.size(); ++i) check(again->vertices[i], moved[i]);
    }
    check_parts(file);
}

void read_ply(const std::string& text) {
    const auto parse = [](std::string bytes) { return parse_ply(std::move(bytes), "file.ply"); };
    const auto file = parse(text);
    if (taken(file)) check_document(*file, text, parse);
    (void)taken(parse_ply(text, "file.ply", StrayVertices::leave_out));
}

void read_stl(const std::string& text) {
    const auto parse = [](std::string bytes) { return parse_stl(std::move(bytes), "file.stl"); };
    const auto file = parse(text);
    if (taken(file)) check_document(*file, text, parse);
}

void read_obj(const std::string& text) {
    const auto file = parse_obj(text, "file.obj");
    if (!taken(file)) return;
    REQUIRE(to_text(*file, file->vertices) == text);
    REQUIRE(pose_difference(*file, *file).empty());
    for (const auto& triangle : file->triangles) {
        for (const std::uint32_t i : triangle) REQUIRE(i < file->vertices.size());
    }
    auto moved = file->vertices;
    for (Point3& p : moved) p = {p[1], -p[2], 2 * p[0]};
    REQUIRE(taken(parse_obj(to_text(*file, moved), "again.obj")));
    check_parts(*file);
}

/// Reads a document, and reads it again with moved vertices.
void read_gltf(const std::string& text) {
    const std::string name = text.starts_with("glTF") ? "file.glb" : "file.gltf";
    const auto mesh = parse_gltf(text, name);
    if (!taken(mesh)) return;
    for (const auto& triangle : mesh->triangles) {
        for (const std::uint32_t i : triangle) REQUIRE(i < mesh->vertices.size());
    }
    std::vector<Point3> moved = mesh->vertices, guides = mesh->guides;
    const Jacobian3 jacobian{{{0, 0, 2}, {1, 0, 0}, {0, -1, 0}}};
    for (std::vector<Point3>* places : {&moved, &guides}) {
        for (Point3& p : *places) p = p[0] * jacobian[0] + p[1] * jacobian[1] + p[2] * jacobian[2];
    }
    const std::vector<Jacobian3> jacobians(moved.size(), jacobian);
    for (const bool drops_skins : {false, true}) {
        const auto written = mesh->document->moved(*mesh, {moved, jacobians, guides, drops_skins}, name);
        if (!taken(written)) continue; // numbers beyond single precision, or a singular transform
        const auto again = parse_gltf(written->files[0].bytes, name);
        if (taken(again)) REQUIRE(again->vertices.size() == moved.size());
    }
}

void read_medit(const std::string& text) {
    const auto file = parse_medit(text, "file.mesh");
    if (!taken(file)) return;
    REQUIRE(to_text(*file, file->vertices) == text);
    for (const auto& triangle : file->triangles) {
        for (const std::uint32_t i : triangle) REQUIRE(i < file->vertices.size());
    }
    auto moved = file->vertices;
    for (Point3& p : moved) p = {p[1], -p[2], 0.5 * p[0]};
    const auto again = parse_medit(to_text(*file, moved), "again.mesh");
    REQUIRE(taken(again));
    REQUIRE(again->vertices == moved && again->tetrahedra == file->tetrahedra);
    const auto ours = parse_medit(medit_text(moved, file->tetrahedra), "ours.mesh");
    REQUIRE(taken(ours) && ours->vertices == moved);
    const MeshFolds folds = folds_of_cells(*file, moved, {});
    REQUIRE(!describe(folds, false).empty());
    REQUIRE(folds.step.step >= 0 && folds.step.step <= 1);
}

void read_lottie(const std::string& text) {
    using Json = nlohmann::ordered_json;
    const Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded()) return;
    try {
        for (const LottieCurve& curve : lottie_curves(json)) REQUIRE(!describe(curve).empty());
    } catch (const Json::exception&) {
    } catch (const std::length_error&) {}
}

void read_css(const std::string& text) {
    const auto easing = cageform::parse_css_easing(text);
    REQUIRE(easing.report.error_at <= text.size());
    if (easing.status() != cageform::Status::ok) return;
    const auto written = cageform::to_css(easing.value);
    // An easing whose keys are level, or differ by too much, has no text.
    if (written.status() != cageform::Status::ok) return;
    const auto again = cageform::parse_css_easing(written.value);
    REQUIRE(again.status() == cageform::Status::ok && again.value.points == easing.value.points);
}

/// Bytes of single-precision numbers, little-endian.
std::string floats(std::initializer_list<float> numbers) {
    std::string bytes;
    for (const float x : numbers) bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
    return bytes;
}

struct Reader {
    void (*read)(const std::string&);
    std::vector<std::string> seeds;
};
const std::map<std::string, Reader>& readers() {
    static const std::map<std::string, Reader> all{
        {"css",
         {read_css,
          {"cubic-bezier(0.8, -.3,+2e-1,1.3)", "/* a */ Ease-In-Out ", "cubic-bezier(1e-400,1e308,1,-1e999)",
           "linear", "cubic-bezier(0,0,1.0000000000000001,1"}}},
        {"cage",
         {read_cage,
          {"x,y\n0,0\n4,0\n4,4\n0,4\n\n1,1\n1,2\n2,2\n\n# chain\n0,0\n3,1\n\n# point 0.5\n3,3\n",
           "1e308,-1e308\n1e-320,+2\r\n nan,inf\n\n# point -1e400\n,\n", "0,0\n1,0\n0,1\n"}}},
        {"clip",
         {read_clip,
          {"# "
           "a\nlength,2.4\nlate,legs,0.6\nground,744,166\n\ncontrol,tail\nvertices,1:0.5,3,2\npivot,775,400\n"
           "time,x,y,turn,kind\n0.0,0,0,-6,ease\n1.2,0,1e9,6,hold\n2.4,0,0,-6,linear\n",
           "length,1e308\ncontrol,\nvertices,4\n-1e308,0,0,0,automatic\n1e-308,1,nan,inf,automatic\n"}}},
        {"pins",
         {read_pins,
          {"915,165:=760,+6e1@-40", "3:+0.2,0.4,-1@30,y", "x,y,tx,ty\n# a\n1,2,3,4\n1,2,3,4,,2\n1,2,3,4,5\n",
           "vertex,x,y,z\n1,2,3,4\n1,2,3,4,5,6\n4,2,3,4,0,0,90,1e-308\n1,2,3,4,5,6,,,,0.5\n"}}},
        {"landmarks",
         {read_landmarks,
          {"vertex,x,y,z\n0,1,2,3\n1,1\r\n# a\n1,2,3,4,5,6,0.5\n", "0,1e308,-1e308,nan\n", "1:=0,+1,2",
           "0,0,-1\n"}}},
        {"points",
         {read_points,
          {"name,x,y,z\n\"a, b\", 1 ,+2,3e0\r\n\n# c\nd,4,5,6,7\n",
           "a,,0,1,2,3,4,5,0,0,90\nb,a,0,1,2,3,4,5,0,0,1e-320", "1,2,3\n1,inf,3\n", "id,Z,X,Y,z\n1,2,3,4,5\n",
           "a,b,c\n,1,2\n"}}},
        {"markers",
         {read_markers,
          {"late,a,0.5\nground,1,2\ntime,a x,a y,b,\nrest,1,2,3,4\n0,1,2,,\n0.5,,,4,4\n1,2,2,5,6\n",
           "-1e308,1,2\n1e308,3,4\n", "0,1,2\n1e-320,-1e308,2\n2,1e308,2\n"}}},
        {"poses",
         {read_poses,
          {"length,2\npose,0\n0,0,0\n1,0,0\n0,1,0\n0,0,1\npose,1,ease\n0,0,1\n1,0,1\n0,1,1\n0,0,2\n",
           "# a\nlength,3e38\npose,0,linear\n3e38,0,0\n1e-45,0,0\n0,1e39,0\n0,0,1\npose,1e-40,smooth\n0,0,1\n"
           "1,0,1\n0,1,1\n0,0,2\n"}}},
        {"gltf",
         {read_gltf,
          {R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"skin":)"
           R"(0},{"translation":[0,1,0],"children":[2]},{"mesh":0,"scale":[-1,2,1]}],"skins":[{"joints":)"
           R"([1,2]}],"meshes":[{"weights":[0.5],"primitives":[{"attributes":{"POSITION":0,"NORMAL":0},")"
           R"(targets":[{"POSITION":1}]}]}],"animations":[{"samplers":[{"input":2,"output":1}],"channels)"
           R"(":[{"sampler":0,"target":{"node":1,"path":"translation"}}]}],"accessors":[{"bufferView":0,)"
           R"("componentType":5126,"count":3,"type":"VEC3"},{"count":3,"componentType":5126,"type":"VEC3)"
           R"(","sparse":{"count":1,"indices":{"bufferView":0,"componentType":5121},"values":{"bufferVie)"
           R"(w":0}}},{"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR"}],"bufferViews":[{")"
           R"(buffer":0,"byteLength":48}],"buffers":[{"byteLength":48,"uri":"data:;base64,AAAAAAAAAAAAAA)"
           R"(AAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/"}]})"}}},
        {"medit",
         {read_medit,
          {"MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 "
           "0\nTetrahedra\n2\n"
           "1 2 3 4 0\n1 3 2 4 0\nTriangles 1 1 2 3 0\nEnd\n",
           "# a\nMeshVersionFormatted 1 Dimension\r\n3 Vertices 5 1e308 -1e308 1e-320 1 +1 .5 1 2 2 2 2 2 1 "
           "0 0 0 0 0 0 0 "
           "Edges 1 1 2 nan Quadrilaterals 1 1 2 3 4 0\nTetrahedra 1 1 2 3 5 -7"}}},
        {"obj",
         {read_obj,
          {"v 0 0 0\nv 1 0 0\nv 0 1 0 1 1 1\r\nv 0 0 1\nvn 0 0 1\nvt 0 1\nf 1 3 2\nf 1/1/1 2//1 4/1\nf -1 -2 "
           "-3\n"
           "f 1 2 3 4\n",
           "\xef\xbb\xbfo a\n#x\nv 1e308 -1e308 \\\n1e-308\nv 1e39 +1 .5\nv 2 2 2\nf 1 2 3 # c\ns "
           "off\nusemtl m\n",
           "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 1 0\nv 0 2 0\nv 0 0 0\nf 1 2 3 4 5\nf 1 6 1\n"}}},
        {"ply",
         {read_ply,
          {"ply\nformat ascii 1.0\ncomment a\nelement vertex 4\nproperty float x\nproperty double "
           "y\nproperty "
           "float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty "
           "uchar green\nproperty uchar blue\nelement face 2\nproperty list uchar int "
           "vertex_indices\nelement "
           "edge 1\nproperty int vertex1\nend_header\n0 0 0 0 0 1 255 0 0\n1 0 0 0 0 1 0 0 0\r\n1 1e3 .5 1 0 "
           "0 0 "
           "0 7\n0 1 0 0 0 1 0 0 0\n3 0 1 2\n4 0 1 2 3\n7\n",
           "ply\nformat binary_little_endian 1.0\nelement tristrips 1\nproperty list int int "
           "vertex_index\nelement vertex 3\nproperty float z\nproperty float x\nproperty float "
           "y\nend_header\n" +
               std::string("\4\0\0\0\0\0\0\0\1\0\0\0\2\0\0\0\xff\xff\xff\xff", 20) +
               floats({0, 1, 2, 3, -4, 5, 6, 7, 1e-38F}),
           "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty short "
           "y\nproperty "
           "float z\nproperty list uchar uchar k\nelement face 1\nproperty list uchar uchar "
           "vertex_indices\nend_header\n" +
               std::string("\0\1\0\2\x3f\x80\0\0\0\0\3\0\2\x3f\x80\0\0\1\7\0\0\0\0\0\0\0\0\0\3\0\1\2", 32)}}},
        {"stl",
         {read_stl,
          {"solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1e0 0 0\n   vertex -0 1 "
           "0\n  endloop\n endfacet\nendsolid a b\nSOLID\nfacet normal 0 0 0\nouter loop\nvertex 0 0 "
           "0\nvertex "
           "0 0 0\nvertex nan 0 1\nendloop\nendfacet\n",
           std::string(80, 's') + std::string("\2\0\0\0", 4) + floats({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) +
               "ab" + floats({0, 0, 0, 0, 0, 0, 1e38F, 0, 0, -0.0F, 1e-40F, 7}) + std::string(2, '\0')}}},
        {"lottie",
         {read_lottie,
          {R"({"layers":[{"nm":"ball","ks":{"r":{"a":1,"k":[{"t":0,"s":[0],"e":[90],"i":{"x":[0.8],"y":[1]},)"
           R"("o":{"x":[0.2],"y":[0]}},{"t":30,"s":[90],"h":1},{"t":31}]},"p":{"k":[{"t":0,"s":[1,2,3],)"
           R"("to":[1,0,0],"ti":[0,0,0],"i":{"x":0.5,"y":1},"o":{"x":0.5,"y":0}},{"t":1e9,"s":[4,5,6]}]}}}]})",
           R"({"k":[{"t":-1e308,"s":1e308,"o":{"x":null,"y":[]}},{"t":1e308,"s":-1e308}]})", "[[[[{}]]]]"}}}};
    return all;
}

const Reader* chosen = nullptr;

} // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
    std::string seeds;
    for (int n = 1; n < *count; ++n) {
        const std::string argument = (*arguments)[n], reader = "--reader=", folder = "--seeds=";
        if (argument.starts_with(reader)) chosen = &readers().at(argument.substr(reader.size()));
        if (argument.starts_with(folder)) seeds = argument.substr(folder.size());
    }
    REQUIRE(chosen != nullptr);
    if (seeds.empty()) return 0;
    for (std::size_t n = 0; n < chosen->seeds.size(); ++n) {
        std::FILE* const file = std::fopen((seeds + "/" + std::to_string(n)).c_str(), "wb");
        REQUIRE(file != nullptr);
        REQUIRE(std::fwrite(chosen->seeds[n].data(), 1, chosen->seeds[n].size(), file) ==
                chosen->seeds[n].size());
        REQUIRE(std::fclose(file) == 0);
    }
    std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    chosen->read(std::string(reinterpret_cast<const char*>(data), size));
    return 0;
}
