// The library as the page calls it: WebAssembly without threads, exceptions or a file system.
//
// The page writes numbers into page_input() and calls a function, which returns a count, a status or the
// address of numbers in memory. Figures in the plane are bound in double, as in the programs; the mesh is
// bound in float. If a status is not 0, page_message() returns the fault.

#include "pins.hpp"
#include "plane.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/binding/skin_weights.hpp>
#include <cageform/clone/glsl.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/enclose/make_cage.hpp>
#include <cageform/enclose/make_cage_3d.hpp>

#include <cstdint>
#include <string>

namespace {

using cageform::Status;
using cageform_page::Pins;
using cageform_page::Plane;
using cageform_page::Point2;
using Point3 = cageform::Vec<float, 3>;

std::vector<double> input;
std::vector<double> output; // results of functions
std::string message;

int refuse(Status status) {
    message = cageform::to_string(status);
    return status == Status::ok ? 0 : 1;
}

/// Reads page_input() from its beginning.
class Reader {
public:
    double number() { return input[at_++]; }
    std::size_t count() { return std::size_t(number()); }
    std::vector<std::size_t> counts(std::size_t size) {
        std::vector<std::size_t> all(size);
        for (std::size_t& n : all) n = count();
        return all;
    }
    /// Points in the layout of the input.
    template <std::size_t D>
    std::span<const cageform::Vec<double, D>> points(std::size_t size) {
        static_assert(sizeof(cageform::Vec<double, D>) == D * sizeof(double));
        const auto* first = reinterpret_cast<const cageform::Vec<double, D>*>(input.data() + at_);
        at_ += D * size;
        return {first, size};
    }

private:
    std::size_t at_ = 0;
};

// ---- figures in the plane ----

enum Type { mean_value, harmonic, green, sibson, lattice, curved };
std::array<Plane, 6> planes;

cageform::AnyCoordinates<double, 2> coordinates_of(int type, const cageform::Polygon<double>& cage) {
    switch (type) {
    case harmonic: return cageform::HarmonicCoordinates<double, 2>(cage);
    case green: return cageform::GreenCoordinates<double, 2>(cage);
    case sibson: return cageform::SibsonCoordinates<double, 2>(cage.vertices());
    default: return cageform::MeanValueCoordinates<double, 2>(cage);
    }
}

/// Makes the first `count` handles, the points of a pose, the output.
void tell_points(std::span<const Point2> handles, std::size_t count) {
    output.clear();
    for (const Point2& p : handles.first(count)) output.insert(output.end(), {p[0], p[1]});
}

/// Reads segments, each two ends and a radius.
std::vector<cageform::DrawnSegment<double>> read_segments(Reader& reader, std::size_t count) {
    std::vector<cageform::DrawnSegment<double>> drawn;
    for (std::size_t i = 0; i < count; ++i) {
        const auto ends = reader.points<2>(2);
        drawn.push_back({ends[0], ends[1], reader.number()});
    }
    return drawn;
}

// ---- the mesh ----

/// A figure in space, bound in float.
struct Space {
    std::unique_ptr<cageform::MeanValueCoordinates<float, 3>> coordinates;
    cageform::Binding<float, 3> binding;
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<Point3> pose, places, normals;
    std::vector<std::array<float, 4>> displacements;
    cageform::SkinWeights skin;
};
Space space;

/// Returns the vertices' normals: means of the adjacent faces', weighted by area.
void find_normals() {
    space.normals.assign(space.places.size(), Point3{});
    for (const auto& [a, b, c] : space.faces) {
        const auto& p = space.places;
        const Point3 normal = cross(p[b] - p[a], p[c] - p[a]);
        for (const std::uint32_t corner : {a, b, c}) space.normals[corner] = space.normals[corner] + normal;
    }
}

std::vector<Point3> narrow(std::span<const cageform::Vec<double, 3>> points) {
    std::vector<Point3> narrowed;
    for (const auto& p : points) narrowed.push_back(cageform::vec_cast<float>(p));
    return narrowed;
}

std::vector<std::array<std::uint32_t, 3>> read_faces(Reader& reader, std::size_t size) {
    std::vector<std::array<std::uint32_t, 3>> faces(size);
    for (auto& face : faces) {
        for (std::uint32_t& corner : face) corner = std::uint32_t(reader.count());
    }
    return faces;
}

} // namespace

#if defined(__wasm__)
#define PAGE_EXPORT(name) extern "C" __attribute__((export_name(#name)))
/// Receives the fraction done of a long computation.
extern "C" __attribute__((import_module("page"), import_name("progress"))) void page_progress(double done);
#else // used natively, by a test
#define PAGE_EXPORT(name) extern "C"
extern "C" inline void page_progress(double) {}
#endif

namespace {

cageform::Running with_progress() {
    cageform::Running running;
    running.progress = [](double done) {
        page_progress(done);
        return true; // the page stops the thread instead
    };
    return running;
}

} // namespace

/// Returns memory for `numbers` doubles, which the next call reads.
PAGE_EXPORT(page_input) double* page_input(std::size_t numbers) {
    input.resize(numbers);
    return input.data();
}
PAGE_EXPORT(page_output) const double* page_output() {
    return output.data();
}
PAGE_EXPORT(page_message) const char* page_message() {
    return message.c_str();
}

/// Makes coordinates of a type on a cage. In: sizes of the loops, vertices.
PAGE_EXPORT(page_cage) int page_cage(int type, std::size_t loops, std::size_t vertices) {
    Reader reader;
    const auto sizes = reader.counts(loops);
    const cageform::Polygon<double> cage(reader.points<2>(vertices), sizes);
    Plane plane{.coordinates = coordinates_of(type, cage), .is_sites = type == sibson};
    Status status = plane.coordinates.cage_report().status;
    if (status == Status::ok) status = plane.coordinates.solve().status;
    if (status == Status::ok) planes[std::size_t(type)] = std::move(plane);
    return refuse(status);
}

/// Out: the origin and the two columns of a box about the drawing, for a lattice. In: segments, each two ends
/// and a radius.
PAGE_EXPORT(page_box) int page_box(std::size_t segments) {
    Reader reader;
    std::vector<Point2> corners; // of boxes around the strokes
    for (const auto& segment : read_segments(reader, segments)) {
        for (const Point2& p : {segment.a, segment.b}) {
            for (const double r : {-segment.radius, segment.radius})
                corners.insert(corners.end(), {{p[0] + r, p[1] + r}, {p[0] + r, p[1] - r}});
        }
    }
    const auto box = cageform::box_around(corners);
    if (box) {
        const auto& [u, v] = box.value.columns;
        const auto& origin = box.value.translation;
        output = {origin[0], origin[1], u[0], u[1], v[0], v[1]};
    }
    return refuse(box.status());
}

/// Makes the coordinates of a lattice. In: the points, the degree and the number of knots of each axis, with
/// its knots; origin and columns of the box; the falloff. Out: the points at rest.
PAGE_EXPORT(page_lattice) int page_lattice() {
    Reader reader;
    std::array<cageform::LatticeAxis, 2> axes;
    for (auto& axis : axes) {
        axis = {reader.count(), reader.count(), {}};
        axis.knots.resize(reader.count());
        for (double& knot : axis.knots) knot = reader.number();
    }
    const auto frame = reader.points<2>(3);
    cageform::Transform<double, 2> box;
    box.translation = frame[0];
    box.columns = {frame[1], frame[2]};
    cageform::LatticeCoordinates<double, 2> coordinates(axes, box, reader.number());
    const Status status = coordinates.cage_report().status;
    if (status == Status::ok) {
        const std::size_t still = coordinates.frame_handles();
        tell_points(coordinates.handles(), coordinates.handles().size() - still);
        planes[lattice] = {.coordinates = std::move(coordinates), .frame_handles = still};
    }
    return refuse(status);
}

/// Makes the coordinates of a cage of curves, posed as cubics. In: the numbers of edges of the loops; the
/// degree of each edge; the control points of one edge after the other, with both ends; centre and radius of
/// a disk, radius 0 for none. Out: the control points at rest.
PAGE_EXPORT(page_curves) int page_curves(std::size_t loops, std::size_t edges) {
    Reader reader;
    const auto sizes = reader.counts(loops), degrees = reader.counts(edges);
    std::vector<cageform::CurvedPolygon<double>::Loop> curves(loops);
    for (std::size_t k = 0, e = 0; k < loops; ++k) {
        for (std::size_t i = 0; i < sizes[k]; ++i) {
            const auto points = reader.points<2>(degrees[e++] + 1);
            curves[k].emplace_back(points.begin(), points.end());
        }
    }
    cageform::CurvedGreenOptions<double> options;
    const Point2 centre = reader.points<2>(1)[0];
    if (const double radius = reader.number(); radius > 0) options.disk = {centre, radius};
    cageform::CurvedGreenCoordinates<double> coordinates(cageform::CurvedPolygon<double>(std::move(curves)),
                                                         options);
    const Status status = coordinates.cage_report().status;
    if (status == Status::ok) {
        tell_points(coordinates.handles(), 3 * edges);
        planes[curved] = {.coordinates = std::move(coordinates)};
    }
    return refuse(status);
}

/// Binds points. In: points. Out: how many are outside, not reached, or not finite; the least weight.
PAGE_EXPORT(page_bind) int page_bind(std::size_t type, std::size_t batch, std::size_t points) {
    Reader reader;
    const auto report = planes[type].bind(batch, reader.points<2>(points));
    output = {double(report.outside.size()), double(report.unreached.size()),
              double(report.not_finite.size()), report.least_weight.value};
    return refuse(report.status);
}

/// Moves bound points. In: a pose of the vertices. Returns the address of the points, or 0.
PAGE_EXPORT(page_clone) const Point2* page_clone(std::size_t type, std::size_t batch, std::size_t vertices) {
    Reader reader;
    const Status status = planes[type].clone(batch, reader.points<2>(vertices));
    return refuse(status) == 0 ? planes[type].places.data() : nullptr;
}

/// Out: the weight of a vertex at every bound point.
PAGE_EXPORT(page_weights) std::size_t page_weights(std::size_t type, std::size_t batch, std::size_t vertex) {
    const auto& binding = planes[type].bindings[batch];
    output.resize(binding.point_count());
    for (std::size_t i = 0; i < output.size(); ++i) output[i] = binding.weight(i, vertex);
    return output.size();
}

/// Makes a cage for the drawing. In: segments, each two ends and a radius. Out: loops, clearance, seconds,
/// sizes of the loops, vertices.
PAGE_EXPORT(page_make_cage)
int page_make_cage(std::size_t segments, std::size_t vertices) {
    Reader reader;
    const auto drawn = read_segments(reader, segments);
    const auto [cage, report] = cageform::make_cage(drawn, {.vertices = vertices}, with_progress());
    output = {double(cage.loops().size()), report.clearance, report.seconds};
    for (const auto& loop : cage.loops()) output.push_back(double(loop.size()));
    for (const auto& p : cage.vertices()) output.insert(output.end(), {p[0], p[1]});
    return refuse(report.status);
}

/// Compiles a track of Bézier keys to cubic pieces. In: keys, each time, value, kind, in-handle, out-handle.
/// Out: the largest error, then the pieces, each with its begin and four coefficients. Returns their number.
PAGE_EXPORT(page_fit) int page_fit(std::size_t keys, double tolerance) {
    std::vector<cageform::Key> track(keys);
    Reader reader;
    for (cageform::Key& key : track) {
        key.time = reader.number();
        key.value = reader.number();
        key.kind = static_cast<cageform::KeyKind>(reader.count());
        key.in_handle = reader.points<2>(1)[0];
        key.out_handle = reader.points<2>(1)[0];
    }
    cageform::TrackOptions options;
    options.tolerance = tolerance;
    const auto [compiled, report] = cageform::compile<double>(track, options);
    if (refuse(report.status) != 0) return -1;
    output = {report.sup_error};
    for (const auto& piece : compiled.curve.pieces())
        output.insert(output.end(), {piece.begin, piece.c0, piece.c1, piece.c2, piece.c3});
    return int(compiled.curve.pieces().size());
}

/// Makes a cage for a mesh. In: points, faces. Out: the numbers of vertices and faces, the clearance; then
/// both.
PAGE_EXPORT(page_make_shell)
int page_make_shell(std::size_t points, std::size_t faces, std::size_t vertices) {
    Reader reader;
    const auto places = reader.points<3>(points);
    const auto [cage, report] =
        cageform::make_cage(places, read_faces(reader, faces), {.vertices = vertices}, with_progress());
    output = {double(cage.size()), double(cage.faces().size()), report.clearance};
    for (const auto& p : cage.vertices()) output.insert(output.end(), {p[0], p[1], p[2]});
    for (const auto& [a, b, c] : cage.faces()) output.insert(output.end(), {double(a), double(b), double(c)});
    return refuse(report.status);
}

/// Binds a mesh. In: vertices and faces of the cage, points, faces of the mesh.
PAGE_EXPORT(page_mesh)
int page_mesh(std::size_t vertices, std::size_t cage_faces, std::size_t points, std::size_t faces) {
    Reader reader;
    const auto corners = narrow(reader.points<3>(vertices));
    const cageform::TriangleMesh<float> cage(corners, read_faces(reader, cage_faces));
    const auto figure = narrow(reader.points<3>(points));
    space.faces = read_faces(reader, faces);
    space.coordinates = std::make_unique<cageform::MeanValueCoordinates<float, 3>>(cage);
    auto [binding, report] = cageform::bind(*space.coordinates, figure);
    space.binding = std::move(binding);
    space.places = figure;
    space.skin = {};
    output = {double(report.outside.size()), report.seconds};
    return refuse(report.status);
}

/// Moves the mesh. In: a pose of the cage. Returns the address of the points, in float; page_mesh_normals()
/// returns that of the normals.
PAGE_EXPORT(page_mesh_clone) const Point3* page_mesh_clone(std::size_t vertices) {
    Reader reader;
    space.pose.resize(vertices);
    const auto pose = reader.points<3>(vertices);
    for (std::size_t i = 0; i < vertices; ++i) space.pose[i] = cageform::vec_cast<float>(pose[i]);
    return refuse(cageform::clone(space.binding, space.pose, space.places)) == 0 ? space.places.data()
                                                                                 : nullptr;
}
PAGE_EXPORT(page_mesh_normals) const Point3* page_mesh_normals() {
    find_normals();
    return space.normals.data();
}

/// Out: the weight of a vertex of the cage at every point of the mesh.
PAGE_EXPORT(page_mesh_field) std::size_t page_mesh_field(std::size_t vertex) {
    output.resize(space.binding.point_count());
    for (std::size_t i = 0; i < output.size(); ++i) output[i] = double(space.binding.weight(i, vertex));
    return output.size();
}

/// Makes a skin of the mesh for the graphics card. Returns 0 on success; then page_mesh_joints() and
/// page_mesh_weights() return joints and weights, `influences` per point.
PAGE_EXPORT(page_mesh_skin) int page_mesh_skin(std::size_t influences) {
    auto [skin, report] = cageform::skin_weights(space.binding, {.influences = influences});
    space.skin = std::move(skin);
    output = {report.seconds, report.weight_error.value};
    return refuse(report.status);
}
PAGE_EXPORT(page_mesh_joints) const std::uint16_t* page_mesh_joints() {
    return space.skin.joints.data();
}
PAGE_EXPORT(page_mesh_weights) const float* page_mesh_weights() {
    return space.skin.weights.data();
}

/// Returns the library's text for the vertex shader of a skin.
PAGE_EXPORT(page_glsl) const char* page_glsl() {
    static const std::string text = std::string(cageform::glsl::displacements) + cageform::glsl::skin;
    return text.c_str();
}

// ---- pins, which move the cage by the figure ----

namespace {

Pins<double, 2> plane_pins; // of one type at a time
Pins<float, 3> space_pins;

/// Samples the inside of a cage. Out: the samples. Returns how many numbers they are, 0 on a fault.
template <class C>
std::size_t sample_inside(const C& coordinates, std::size_t samples) {
    cageform::PoseSampleOptions options;
    options.samples = samples;
    const auto [made, report] = pose_samples(coordinates, options);
    if (refuse(report.status) != 0) return 0;
    cageform_page::write_samples(made, output);
    return output.size();
}
/// In: places at rest, whether each turns, held points. Out: the pin at fault.
template <std::size_t D, class P, class C>
int set_pins(P& pins, const C& coordinates, std::size_t count, std::size_t held, bool turns) {
    Reader reader;
    const auto places = reader.points<D>(count);
    std::vector<std::uint8_t> turned(turns ? count : 0);
    for (std::uint8_t& flag : turned) flag = std::uint8_t(reader.count());
    std::vector<std::uint32_t> points(held);
    for (std::uint32_t& point : points) point = std::uint32_t(reader.count());
    const Status status = pins.set(coordinates, places, turned, points);
    output = {double(pins.culprit())};
    return refuse(status);
}
/// In: targets, turns if some pins turn, a pose. Out: whether the pose has settled, the largest miss, the
/// iterations, how many clusters are folded; the pose.
template <std::size_t D, class P>
int solve_pins(P& pins, std::size_t count, std::size_t vertices, bool turns) {
    Reader reader;
    const auto targets = reader.points<D>(count);
    std::vector<cageform::PoseTurn<D>> angles(turns ? count : 0);
    for (auto& angle : angles) {
        for (double& x : angle.v) x = reader.number();
    }
    const auto report = pins.solve(targets, angles, reader.points<D>(vertices));
    output = {double(report.settled), report.miss, double(report.iterations), double(report.folded)};
    pins.for_each_point([](const auto& p) {
        for (const auto x : p.v) output.push_back(double(x));
    });
    return refuse(report.status);
}
/// In: a pose. Out: the place of each pin, and the matrix of the pose there, column after column.
template <std::size_t D, class P>
int locate_pins(P& pins, std::size_t vertices) {
    Reader reader;
    const Status status = pins.locate(reader.points<D>(vertices));
    output.clear();
    for (std::size_t pin = 0; status == Status::ok && pin < pins.places().size(); ++pin) {
        for (const auto x : pins.places()[pin].v) output.push_back(double(x));
        for (std::size_t k = 0; k < D * D; ++k) output.push_back(double(pins.jacobians()[pin * D * D + k]));
    }
    return refuse(status);
}

} // namespace

PAGE_EXPORT(page_pins_sample) std::size_t page_pins_sample(std::size_t type, std::size_t samples) {
    return sample_inside(planes[type].coordinates, samples);
}
/// Takes samples, which another instance may have made; there are no pins then. In: the samples.
PAGE_EXPORT(page_pins_take) int page_pins_take(std::size_t type) {
    return refuse(plane_pins.take(planes[type].coordinates, planes[type].frame_handles,
                                  cageform_page::read_samples<double, 2>(input.data())));
}
PAGE_EXPORT(page_pins_set)
int page_pins_set(std::size_t type, std::size_t count, std::size_t held, bool turns) {
    return set_pins<2>(plane_pins, planes[type].coordinates, count, held, turns);
}
/// Starts from a pose. In: the pose.
PAGE_EXPORT(page_pins_begin) int page_pins_begin(std::size_t vertices) {
    Reader reader;
    return refuse(plane_pins.begin(reader.points<2>(vertices)));
}
PAGE_EXPORT(page_pins_solve) int page_pins_solve(std::size_t count, std::size_t vertices, bool turns) {
    return solve_pins<2>(plane_pins, count, vertices, turns);
}
PAGE_EXPORT(page_pins_count) std::size_t page_pins_count() {
    return plane_pins.count();
}
PAGE_EXPORT(page_pins_locate) int page_pins_locate(std::size_t vertices) {
    return locate_pins<2>(plane_pins, vertices);
}
/// Finds what a pose takes to a place. In: where to start, the place, the pose. Out: the point at rest, how
/// far off it is.
PAGE_EXPORT(page_pins_find) void page_pins_find(std::size_t type, std::size_t vertices) {
    Reader reader;
    const auto ends = reader.points<2>(2);
    const auto found =
        plane_pins.find(planes[type].coordinates, ends[0], ends[1], reader.points<2>(vertices));
    output = {found.at[0], found.at[1], found.miss};
}

/// Pins in space, as in the plane.
PAGE_EXPORT(page_mesh_pins_sample) std::size_t page_mesh_pins_sample(std::size_t samples) {
    return sample_inside(*space.coordinates, samples);
}
PAGE_EXPORT(page_mesh_pins_take) int page_mesh_pins_take() {
    return refuse(
        space_pins.take(*space.coordinates, 0, cageform_page::read_samples<float, 3>(input.data())));
}
PAGE_EXPORT(page_mesh_pins_set) int page_mesh_pins_set(std::size_t count, std::size_t held, bool turns) {
    return set_pins<3>(space_pins, *space.coordinates, count, held, turns);
}
PAGE_EXPORT(page_mesh_pins_begin) int page_mesh_pins_begin(std::size_t vertices) {
    Reader reader;
    return refuse(space_pins.begin(reader.points<3>(vertices)));
}
PAGE_EXPORT(page_mesh_pins_solve)
int page_mesh_pins_solve(std::size_t count, std::size_t vertices, bool turns) {
    return solve_pins<3>(space_pins, count, vertices, turns);
}
PAGE_EXPORT(page_mesh_pins_count) std::size_t page_mesh_pins_count() {
    return space_pins.count();
}
PAGE_EXPORT(page_mesh_pins_locate) int page_mesh_pins_locate(std::size_t vertices) {
    return locate_pins<3>(space_pins, vertices);
}
