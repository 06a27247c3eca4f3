// 20. A cage of curves: Green coordinates for edges that are Bézier curves. The user moves control points, as
// in any drawing program. A few of them bend a figure smoothly, and straight edges can bend too.
#include <cageform/cageform.hpp>

#include <cmath>
#include <cstdio>

using Point = cageform::Vec<double, 2>;
using Points = std::vector<Point>;
using Curves = cageform::CurvedPolygon<double>;
using Coordinates = cageform::CurvedGreenCoordinates<double>;

/// Binds points and moves them by a pose of the control points; prints errors.
Points moved(const Coordinates& coordinates, const Points& points, const Points& pose) {
    const auto [binding, report] = cageform::bind(coordinates, points);
    if (report.status != cageform::Status::ok) {
        std::puts(to_string(report.status));
        return points;
    }
    Points handles(binding.handle_count()), out(points.size());
    const auto posed = pose_handles(binding, pose, handles); // computes the normals of the legs
    if (posed.status != cageform::Status::ok || clone(binding, handles, out) != cageform::Status::ok)
        std::puts(to_string(posed.status));
    return out;
}

/// The control points at rest: the first half of the handles. The second half are the normals of the legs,
/// the lines between neighbouring control points.
Points control_points(const Coordinates& coordinates) {
    const auto handles = coordinates.handles();
    return Points(handles.begin(), handles.begin() + handles.size() / 2);
}

/// The angle at the first of three points, in degrees.
double angle(const Points& p) {
    const Point a = p[1] - p[0], b = p[2] - p[0];
    return std::atan2(cross(a, b), dot(a, b)) * 180 / 3.14159265358979323846;
}

int main() {
    // A square of lines. In poses its edges are cubics: three control points for each, its start first.
    const cageform::Polygon<double> square(Points{{0, 0}, {6, 0}, {6, 6}, {0, 6}});
    const Coordinates lines{Curves(square)};
    Points pose = control_points(lines);
    std::printf("a square has %zu control points and as many legs\n", pose.size());

    // The lower edge bends: its two inner control points move down. Angles are preserved.
    pose[1][1] = pose[2][1] = -2;
    const Points corner = moved(lines, {{3, 1}, {3.001, 1}, {3, 1.001}}, pose);
    std::printf("a point above the bent edge moves down by %.3f, and 90 degrees stay %.1f\n",
                1 - corner[0][1], angle(corner));

    // Curves at rest: a leaf of two cubics. Each starts at the end of the previous one.
    const Curves leaf({{{{0, 0}, {2, -2}, {6, -2}, {8, 0}}, {{8, 0}, {6, 2}, {2, 2}, {0, 0}}}});
    const Coordinates curves{leaf};
    pose = control_points(curves);
    // The tip, control point 3, moves up with its neighbours.
    for (const std::size_t i : {2u, 3u, 4u}) pose[i][1] += 2;
    const Points vein{{1, 0}, {4, 0}, {7, 0}};
    const Points bent = moved(curves, vein, pose);
    std::printf("%zu control points bend a leaf: its vein moves up by %.2f, %.2f and %.2f\n", pose.size(),
                bent[0][1], bent[1][1], bent[2][1]);

    // With the function of a disk around the cage, points on a curve stay closer to it.
    const Coordinates in_disk{leaf, {.disk = cageform::CurvedGreenDisk<double>{{4, 0}, 4.001}}};
    const Points on_curve{{4, -1.5}}; // in the middle of the lower curve
    const Point posed = 0.125 * pose[0] + 0.375 * pose[1] + 0.375 * pose[2] + 0.125 * pose[3];
    const auto miss = [&](const Coordinates& coordinates) {
        const Point off = moved(coordinates, on_curve, pose)[0] - posed;
        return std::hypot(off[0], off[1]);
    };
    std::printf("a point on the lower curve is off its posed position by %.3f, with a disk by %.3f\n",
                miss(curves), miss(in_disk));
}

//> a square has 12 control points and as many legs
//> a point above the bent edge moves down by 0.503, and 90 degrees stay 90.0
//> 6 control points bend a leaf: its vein moves up by 0.38, 1.00 and 1.62
//> a point on the lower curve is off its posed position by 0.329, with a disk by 0.259
