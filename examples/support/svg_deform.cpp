#include "svg_curves.hpp"
#include "svg_paint.hpp"
#include "svg_walk.hpp"

#include <algorithm>
#include <cmath>

namespace cageform_examples {

namespace detail {

bool write_moved(const DrawnShape& shape, const Path& moved, double tolerance, int decimals) {
    const double scale = largest_scale(shape.to_root);
    int enough = 0;
    while (enough < 15 && 20 * scale > tolerance * std::pow(10.0, enough)) ++enough;
    const Path local = transformed(moved, shape.from_root);
    if (!in_range(local)) return false;
    write_shape(shape.node, write_path_data(local, decimals >= 0 ? decimals : enough));
    return true;
}

/// Moves a text or an image as a whole: its transform is P⁻¹ best P before its own one, where P is that of what it
/// stands in.
void carry(const DrawnShape& shape, const Affine2& best) {
    const auto own = parse_transform(attribute_text(shape.node, "transform"));
    if (!own) return;
    const Affine2 local = compose(compose(shape.from_root, best), shape.to_root);
    pugi::xml_node node = shape.node;
    set_attribute(node, "transform", write_transform(compose(*own, local)));
}

/// Whether a path that is filled shows: a line has no inside, and what it is bent to must not get one.
bool has_inside(const Path& path) {
    return std::any_of(path.begin(), path.end(), [](const Subpath& subpath) {
        const Point2& a = subpath.start;
        Point2 far = a;
        double length = 0;
        const auto each = [&](const auto& visit) {
            for (const Segment& s : subpath.segments) {
                for (const Point2& p : {s.p1, s.p2, s.p3}) visit(p);
            }
        };
        each([&](const Point2& p) {
            const double d = std::hypot(p.x - a.x, p.y - a.y);
            if (d > length) far = p;
            length = std::max(length, d);
        });
        bool beside = false;
        each([&](const Point2& p) {
            const double cross = (far.x - a.x) * (p.y - a.y) - (far.y - a.y) * (p.x - a.x);
            beside = beside || std::abs(cross) > 1e-9 * length * length;
        });
        return beside;
    });
}

/// The box of each shape that is seen, by what clips it; empty for others.
std::vector<Box> seen(const Drawing& drawing, const std::vector<DrawnShape>& shapes) {
    std::vector<Box> boxes;
    boxes.reserve(shapes.size());
    for (const DrawnShape& shape : shapes) {
        boxes.push_back(shape.level == 0 ? painted_box(shape, {}) : Box());
    }
    for (const Reference& r : drawing.references) {
        if (r.level != 0 || local_name(r.target) != "clipPath" || r.first_inside == r.end_inside) continue;
        const Box clip = bounds(shapes, r.first_inside, r.end_inside, 1, {});
        for (std::size_t i = r.first; i < r.end; ++i) boxes[i] = boxes[i].within(clip);
    }
    return boxes;
}

/// Grows the viewBox of the root to a box; its width and height too, so that nothing gets smaller.
void grow_view_box(pugi::xml_node root, const ViewBox& view, const Box& to) {
    const auto write = [&](double v) { return format_number(v, 6); };
    set_attribute(root, "viewBox",
                  write(to.x0) + ' ' + write(to.y0) + ' ' + write(to.width()) + ' ' + write(to.height()));
    const auto grow = [&](const char* name, double factor) {
        const std::string text(trimmed(attribute_text(root, name)));
        const std::size_t unit = std::min(text.find_first_not_of("+-.0123456789"), text.size());
        const auto number = parse_length(text.substr(0, unit), 0);
        if (!number || text.substr(unit) == "%") return;
        set_attribute(root, name, format_number(*number * factor, 6) + text.substr(unit));
    };
    grow("width", to.width() / view.width);
    grow("height", to.height() / view.height);
}

/// Markers stand at vertices, and the path written has others.
void settle_markers(const SvgDocument& document, const StyleSheets& styles, const DrawnShape& shape,
                    std::vector<std::string>& warnings) {
    const std::string kind = local_name(shape.node);
    const bool has_none = kind == "rect" || kind == "circle" || kind == "ellipse";
    if (has_none && (shape.marks_ends || shape.marks_vertices)) {
        for (const char* property : {"marker-start", "marker-mid", "marker-end"}) {
            styles.set(shape.node, property, "none");
        }
    } else if (shape.marks_vertices) {
        warnings.push_back(label(document, shape.node) +
                           ": its markers stand at vertices, also at those that were added");
    }
}

} // namespace detail

SvgResult<DeformReport> deform(SvgDocument& document, const Deformer& deformer,
                               const DeformOptions& options) {
    DeformReport report;
    SvgDocument work = detail::copy_of(document);
    const pugi::xml_node root = detail::root_element(work.xml);
    const auto view = view_box(work);
    if (!view) return view.error();
    detail::adapt_style_sheets(work, report.warnings);
    const detail::StyleSheets styles(root);
    detail::IdTable ids(root);
    auto rest = detail::walk(work, styles, ids, {.boxes = true}, report.warnings);
    if (!rest) return rest.error();
    for (const std::string& rule : styles.unread) {
        report.warnings.push_back("style sheet: \"" + rule + "\" refers to an element and is not read");
    }

    const double diagonal = std::hypot(view->width, view->height);
    const bool given = options.tolerance > 0 && std::isfinite(options.tolerance);
    const double tolerance = given ? options.tolerance : 2e-5 * diagonal;
    std::vector<detail::DrawnShape>& shapes = rest->shapes;
    std::vector<Path> paths;
    paths.reserve(shapes.size());
    for (const detail::DrawnShape& shape : shapes) paths.push_back(shape.path);
    detail::CurveDeformer curves(deformer, tolerance, diagonal, options.max_halvings, report);
    if (!curves.run(paths)) return SvgError{work.name + ": " + curves.failure()};
    report.shapes = shapes.size();
    const std::vector<detail::Motion>& motions = curves.motions();
    if (std::none_of(motions.begin(), motions.end(), [](const auto& motion) { return motion.moved(); })) {
        return report; // and the document stays as it is
    }

    detail::PaintFollower paint(work, styles, ids, tolerance);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const detail::DrawnShape& shape = shapes[i];
        if (!motions[i].moved()) continue;
        const auto best = motions[i].best_map();
        if (shape.is_box) {
            if (best) detail::carry(shape, *best);
            continue;
        }
        detail::settle_markers(work, styles, shape, report.warnings);
        if (!detail::has_inside(shape.path) && detail::has_inside(paths[i])) {
            styles.set(shape.node, "fill", "none");
        }
        if (best && !shape.clips) {
            paint.follow(shape, *best, detail::bounds(shape.path, shape.from_root),
                         detail::bounds(paths[i], shape.from_root));
        }
        if (!detail::write_moved(shape, paths[i], tolerance, options.decimals)) {
            return detail::error_at(work, shape.node, "coordinates out of range");
        }
    }
    detail::follow_regions(work, *rest, paths, motions, report.warnings);
    report.warnings.insert(report.warnings.end(), paint.warnings.begin(), paint.warnings.end());

    const std::vector<detail::Box> before = detail::seen(*rest, shapes);
    for (std::size_t i = 0; i < shapes.size(); ++i) shapes[i].path = std::move(paths[i]);
    const std::vector<detail::Box> after = detail::seen(*rest, shapes);
    const detail::Box window{view->x, view->y, view->x + view->width, view->y + view->height};
    detail::Box all = window;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        if (after[i].empty() || before[i].within(window).empty()) continue; // was not seen
        detail::Box reach = window; // what was cut off before may stay so
        reach.add(before[i]);
        if (reach.grown(1e-3 * diagonal).contains(after[i])) continue;
        ++report.cut_off;
        all.add(after[i]);
    }
    if (options.fit && report.cut_off > 0) {
        detail::grow_view_box(root, *view, all.grown(1e-3 * diagonal));
        report.cut_off = 0;
    }
    document = std::move(work);
    return report;
}

} // namespace cageform_examples
