#include "svg/affine_parts.hpp"
#include "svg/css_geometry.hpp"
#include "svg/curves.hpp"
#include "svg/paint.hpp"
#include "svg/walk.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace cageform_support {

namespace detail {

int decimals_for(const Affine2& to_root, double tolerance) {
    const double scale = largest_scale(to_root);
    int enough = 0;
    while (enough < 15 && 20 * scale > tolerance * std::pow(10.0, enough)) ++enough;
    return enough;
}

/// Adds a transform track for an element: its transform is preceded by P⁻¹ best P, where P maps the parent's
/// user space to the root.
///
///   best   #frames, in root user space
///   box    content of the element, in its own user space
void add_transform_track(pugi::xml_node node, const Affine2& to_root, const std::vector<Affine2>& best,
                         const Box& box, std::vector<AnimatedSvg::Track>& tracks) {
    const auto own = parse_transform(attribute_text(node, "transform"));
    if (!own) return;
    const auto from_root = inverse(to_root), before = inverse(*own);
    if (!from_root || !before) return;
    const auto corners = box.corners();
    AnimatedSvg::Track track{.node = node,
                             .attribute = "transform",
                             .scale = largest_scale(compose(to_root, *before)),
                             .places = {corners.begin(), corners.end()}};
    for (const Affine2& map : best)
        track.maps.push_back(compose(*own, compose(compose(*from_root, map), to_root)));
    tracks.push_back(std::move(track));
}

/// Moves an element into a group that takes over its clip path and mask: these are deformed separately.
void wrap_with_clips(const Drawing& drawing, const StyleSheets& styles, pugi::xml_node node) {
    const auto is_its = [&](const Reference& each) { return each.node == node && !is_filter(each); };
    if (std::none_of(drawing.references.begin(), drawing.references.end(), is_its)) return;
    pugi::xml_node group = node.parent().insert_child_before((name_prefix(node) + 'g').c_str(), node);
    for (const char* property : {"clip-path", "mask"}) {
        const std::string value = styles.value(node, property).text;
        if (referenced_id(value).empty()) continue;
        styles.set(group, property, value);
        styles.set(node, property, "none");
    }
    if (const auto own = node.attribute("transform")) group.append_copy(own); // applies to the clip path
    node.remove_attribute("transform");
    group.append_move(node);
}

/// Whether a filled path has area. A straight line has none, and must not get any when it bends.
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

/// Enlarges the viewBox of the root to a box, and its width and height in proportion.
void grow_view_box(pugi::xml_node root, const ViewBox& view, const Box& to) {
    set_view_box(root, to, 6);
    const auto grow = [&](const char* name, double factor) {
        const std::string text = attribute_text(root, name);
        const auto size = read_quantity(trimmed(text));
        if (!size || size->unit == "%") return;
        set_attribute(root, name, format_number(size->value * factor, 6) + escaped(size->unit));
    };
    grow("width", to.width() / view.width);
    grow("height", to.height() / view.height);
}

/// Whether any element has a length in percent of the picture. Deformed shapes have none.
bool has_percentages(pugi::xml_node root) {
    for (pugi::xml_node node = next_node(root, root); node; node = next_node(node, root)) {
        const std::string kind = local_name(node);
        if (kind.empty() || kind == "stop") continue;
        if (kind == "style" && std::string_view(node.text().get()).find('%') != std::string_view::npos)
            return true;
        bool in_user_space = !kind.ends_with("Gradient"), has_percent = false;
        for (const pugi::xml_attribute attribute : node.attributes()) {
            const std::string_view value = attribute.value();
            in_user_space = in_user_space || value == "userSpaceOnUse";
            has_percent = has_percent || value.find('%') != std::string_view::npos;
        }
        if (in_user_space && has_percent) return true;
    }
    return false;
}

/// Moves the content of the root into a nested svg of the given size, so that percentages stay the same.
void keep_percentages(pugi::xml_node root, const ViewBox& view) {
    pugi::xml_node inner = root.append_child(root.name());
    while (root.first_child() != inner) inner.append_move(root.first_child());
    set_box(inner, box_of(view), 12);
    set_view_box(inner, box_of(view), 12);
    set_attribute(inner, "overflow", "visible");
}

void drop_markers(const StyleSheets& styles, pugi::xml_node node) {
    styles.set(node, "marker", "none");
    for (const char* property : marker_properties) styles.set(node, property, "none");
}

/// Adds a copy of a path that shows only its markers. Its paints are kept, since markers may use them.
pugi::xml_node add_marked_path(const StyleSheets& styles, pugi::xml_node node) {
    pugi::xml_node marked = node.parent().insert_child_after(node.name(), node);
    for (const pugi::xml_attribute attribute : node.attributes()) {
        if (std::string_view(attribute.name()) != "id") marked.append_copy(attribute);
    }
    for (const auto& [property, value] : styles.values(node)) { // rules may match the id
        if (value.source == StyleValue::Source::sheet) styles.set(marked, property, value.text);
    }
    for (const char* property : {"fill-opacity", "stroke-opacity"}) styles.set(marked, property, "0");
    return marked;
}

/// Whether a map is not a similarity, so that it makes pens elliptical.
bool is_skewed(const Affine2& map) {
    const double largest = largest_scale(map);
    return largest * largest > (1 + 1e-6) * std::abs(map.a * map.d - map.b * map.c);
}

/// The rotation or reflection about `centre` that is nearest to a map (its polar factor); the identity if the
/// map does not rotate.
Affine2 turn_of(const Affine2& map, const Point2& centre) {
    const double side = map.a * map.d < map.b * map.c ? -1 : 1;
    const double x = map.a + side * map.d, y = map.b - side * map.c, length = std::hypot(x, y);
    if (!(length > 0) || (side > 0 && x > 0 && std::abs(y) <= 1e-9 * length)) return {};
    Affine2 turn{x / length, y / length, -side * y / length, side * x / length, 0, 0};
    const Point2 there = apply(turn, centre);
    turn.e = centre.x - there.x;
    turn.f = centre.y - there.y;
    return turn;
}

/// Whether a filter has a visible direction: an offset or a drop shadow.
bool has_direction(const StyleSheets& styles, const Reference& filter) {
    if (!filter.target)
        return styles.value(filter.node, "filter").text.find("drop-shadow(") != std::string::npos;
    return std::any_of(filter.target.begin(), filter.target.end(), [](pugi::xml_node primitive) {
        const std::string kind = local_name(primitive);
        const auto is_zero = [&](const char* name) {
            const std::string text = attribute_text(primitive, name);
            return text.empty() ? kind == "feOffset" : text == "0";
        };
        return (kind == "feOffset" || kind == "feDropShadow") && !(is_zero("dx") && is_zero("dy"));
    });
}

/// Whether a filter draws noise, which is fixed in user space.
bool has_noise(const Reference& filter) {
    return std::any_of(filter.target.begin(), filter.target.end(),
                       [](pugi::xml_node primitive) { return local_name(primitive) == "feTurbulence"; });
}

bool is_shift(const Affine2& map) {
    return std::abs(map.a - 1) + std::abs(map.b) + std::abs(map.c) + std::abs(map.d - 1) <= 1e-9;
}

/// Deforms a document.
class DocumentMover {
public:
    DocumentMover(SvgDocument& work, const FrameDeformer& deformer, std::size_t frames,
                  const DeformOptions& options, AnimatedSvg& result)
        : work_(work)
        , deformer_(deformer)
        , frames_(frames)
        , options_(options)
        , result_(result)
        , styles_(work)
        , ids_(root_element(work.xml)) {}

    /// Returns the error, if any. If moved() is false, nothing moves and the document should be left
    /// unchanged.
    std::optional<FileError> run() {
        view_ = view_box(work_);
        diagonal_ = std::hypot(view_.width, view_.height);
        const bool given = options_.tolerance > 0 && std::isfinite(options_.tolerance);
        tolerance_ = given ? options_.tolerance : 2e-5 * diagonal_;
        styles_.report.check(work_);
        auto rest = walk(work_, styles_, ids_, {.boxes = true}, result_.report.warnings);
        if (!rest) return rest.error();
        for (std::string& line : styles_.report.lines()) result_.report.warnings.push_back(std::move(line));
        rest_ = std::move(*rest);
        seen_before_ = seen_boxes(rest_);
        auto roles = roles_of(rest_.shapes);
        if (!roles) return roles.error();
        std::vector<Path> paths;
        paths.reserve(rest_.shapes.size());
        for (const DrawnShape& shape : rest_.shapes) paths.push_back(shape.path);
        CurveDeformer curves(deformer_, frames_, tolerance_, diagonal_, options_.max_halvings,
                             result_.report);
        if (!curves.run(paths, std::move(*roles))) return FileError{work_.name + ": " + curves.failure()};
        result_.report.shapes = paths.size();
        moves_.resize(paths.size());
        for (std::size_t i = 0; i < paths.size(); ++i) {
            const auto& text_on_path = rest_.shapes[i].text_on_path;
            moves_[i] = text_on_path && moves_[*text_on_path];
            if (curves.is_lost(i))
                result_.report.warnings.push_back(
                    label(work_, rest_.shapes[i].node) +
                    ": stays unchanged, since a deformed point is out of range or not finite");
            for (std::size_t f = 0; f < frames_ && !moves_[i]; ++f) moves_[i] = curves.motion(i, f).moved();
        }
        if (!moved()) return std::nullopt;
        if (const auto error = record_frames(curves)) return error;
        return write(curves);
    }

    bool moved() const { return std::find(moves_.begin(), moves_.end(), true) != moves_.end(); }

private:
    struct Moved {                  // a deformed shape, by frame
        std::vector<Path> paths;    // in its own user space
        std::vector<Path> marked;   // the same with the vertices of the file; only with markers
        std::vector<Affine2> maps;  // best affine map; if none exists, that of the frame before
        std::vector<Affine2> turns; // rotation of an elliptical pen
        std::vector<Box> boxes;     // in its own user space
        bool has_map = false, gains_inside = false, pen_not_rotated = false;
    };

    /// The role of the points of each shape; fails if a layer has no shape.
    Expected<std::vector<PathRole>> roles_of(const std::vector<DrawnShape>& shapes) const {
        std::vector<PathRole> roles;
        for (const Box& box : seen_before_)
            roles.push_back({0, box.grown(1e-9 * diagonal_)}); // for rounding errors
        for (std::size_t n = 0; n < options_.layers.size(); ++n) {
            bool found = false;
            for (std::size_t i = 0; i < shapes.size(); ++i) {
                for (pugi::xml_node up = shapes[i].node; up; up = up.parent()) {
                    if (attribute_text(up, "id") != options_.layers[n]) continue;
                    roles[i].layer = n + 1;
                    found = true;
                }
            }
            if (!found) {
                return FileError{work_.name + ": the figure has no shape in \"" + options_.layers[n] + '"'};
            }
        }
        return roles;
    }

    std::optional<FileError> record_frames(const CurveDeformer& curves) {
        std::vector<DrawnShape>& shapes = rest_.shapes;
        moved_.resize(shapes.size());
        regions_.resize(rest_.references.size());
        find_filter_maps(curves);
        for (const Reference& reference : rest_.references) referring_.insert(reference.node.hash_value());
        for (const DrawnShape& shape : shapes) {
            has_inside_at_rest_.push_back(has_inside(shape.path));
            boxes_at_rest_.push_back(bounds(shape.path, shape.from_root));
        }
        for (std::size_t r = 0; r < rest_.references.size(); ++r) {
            const Reference& reference = rest_.references[r];
            regions_[r].before =
                bounds(shapes, reference.first, reference.end, reference.level, reference.from_root);
        }
        seen_after_.resize(shapes.size());
        for (std::size_t f = 0; f < frames_; ++f) {
            for (std::size_t i = 0; i < shapes.size(); ++i) {
                if (!moves_[i]) continue;
                if (auto error = add_frame(curves, i, f)) return error;
            }
            for (std::size_t r = 0; r < rest_.references.size(); ++r) add_region_frame(curves, r, f);
            const std::vector<Box> after = seen_boxes(rest_);
            for (std::size_t i = 0; i < shapes.size(); ++i) seen_after_[i].add(after[i]);
        }
        return std::nullopt;
    }

    /// Adds a frame of a shape that moves.
    std::optional<FileError> add_frame(const CurveDeformer& curves, std::size_t i, std::size_t f) {
        DrawnShape& shape = rest_.shapes[i];
        shape.path = curves.path(i, f);
        Moved& moved = moved_[i];
        const auto best = curves.motion(i, f).best_map();
        moved.has_map = moved.has_map || best;
        moved.maps.push_back(best ? *best : moved.maps.empty() ? Affine2() : moved.maps.back());
        if (shape.is_box || shape.is_extent) return std::nullopt;
        Affine2 from_root = shape.from_root;
        if (shape.has_stroke && !shape.clips && is_skewed(shape.to_root)) {
            const Point2 centre = apply(shape.to_root, boxes_at_rest_[i].centre());
            Affine2 turn = turn_of(unfiltered(i, f, moved.maps.back()), centre);
            if (referring_.count(shape.node.hash_value()) != 0) {
                moved.pen_not_rotated = moved.pen_not_rotated || !(turn == Affine2());
                turn = {};
            }
            moved.turns.push_back(turn);
            from_root = compose(from_root, *inverse(turn));
        }
        if (shape.text_on_path && moves_[*shape.text_on_path]) { // undo the motion of the text
            const auto undone = inverse(moved_[*shape.text_on_path].maps.back());
            from_root = compose(from_root, undone.value_or(Affine2()));
        } else {
            from_root = compose(from_root, unfiltered(i, f, {}));
        }
        Path local = transformed(shape.path, from_root);
        if (!in_range(local)) return error_at(work_, shape.node, "coordinates out of range");
        moved.boxes.push_back(bounds(local));
        moved.paths.push_back(std::move(local));
        if (!shape.markers[1].empty())
            moved.marked.push_back(transformed(curves.path_of_vertices(i, f), from_root));
        moved.gains_inside = moved.gains_inside || (!has_inside_at_rest_[i] && has_inside(shape.path));
        return std::nullopt;
    }

    /// Adds a frame of the region of a clip path, mask or filter.
    void add_region_frame(const CurveDeformer& curves, std::size_t r, std::size_t f) {
        const Reference& reference = rest_.references[r];
        const std::size_t by = reference.first < reference.end ? filter_of_[reference.first] : none;
        const bool goes_along = by != none && (by == r || rest_.references[by].node != reference.node);
        const Affine2 back = goes_along ? unfiltered(reference.first, f, {}) : Affine2();
        regions_[r].after.push_back(bounds(rest_.shapes, reference.first, reference.end, reference.level,
                                           compose(reference.from_root, back)));
        const Motion motion = motion_of(reference, curves, f);
        const auto best = motion.best_map();
        regions_[r].moved = regions_[r].moved || motion.moved();
        regions_[r].maps.push_back(best ? std::optional(compose(back, *best)) : std::nullopt);
    }

    Motion motion_of(const Reference& reference, const CurveDeformer& curves, std::size_t frame) const {
        Motion motion;
        for (std::size_t i = reference.first; i < reference.end; ++i) {
            if (rest_.shapes[i].level == reference.level) motion.add(curves.motion(i, frame));
        }
        return motion;
    }

    /// Finds the map of each element with a filter: the best affine map of its shapes. With strokes or
    /// markers, only the map's rotation and the shift of the centre are used. The shapes get the remaining
    /// deformation.
    void find_filter_maps(const CurveDeformer& curves) {
        filter_of_.assign(rest_.shapes.size(), none);
        filter_maps_.resize(rest_.references.size());
        for (std::size_t k = rest_.references.size(); k-- > 0;) { // outer elements first
            const Reference& r = rest_.references[k];
            if (r.first < r.end && filter_of_[r.first] != none) continue; // moves with an outer element
            const auto first = rest_.shapes.begin() + std::ptrdiff_t(r.first);
            const auto end = rest_.shapes.begin() + std::ptrdiff_t(r.end);
            if (!is_filter(r) || first == end || (first->is_box && first->node == r.node)) continue;
            const bool has_stroke = std::any_of(
                first, end, [](const DrawnShape& shape) { return shape.has_stroke || has_markers(shape); });
            const Point2 centre = bounds(rest_.shapes, r.first, r.end, r.level, {}).centre();
            std::vector<Affine2> maps;
            for (std::size_t f = 0; f < frames_; ++f) {
                auto best = motion_of(r, curves, f).best_map();
                if (best && has_stroke) {
                    const Point2 there = apply(*best, centre);
                    const Affine2 turn = turn_of(*best, centre);
                    best = compose({1, 0, 0, 1, there.x - centre.x, there.y - centre.y}, turn);
                }
                maps.push_back(best && inverse(*best) ? *best : maps.empty() ? Affine2() : maps.back());
            }
            const bool only_shifts = std::all_of(maps.begin(), maps.end(), is_shift);
            if (only_shifts && !has_noise(r)) continue;
            if (can_move_as_whole(r)) {
                for (std::size_t i = r.first; i < r.end; ++i) {
                    filter_of_[i] = k;
                    moves_[i] = true;
                }
                filter_maps_[k] = std::move(maps);
            } else if (!only_shifts && has_direction(styles_, r)) {
                result_.report.warnings.push_back(
                    label(work_, r.node) +
                    (local_name(r.node) == "svg"
                         ? ": its filter does not turn, since its element is an svg"
                         : ": its filter does not turn: other elements share its clip path or mask"));
            }
        }
    }

    /// Whether an element can move with its content: no other element may use its clip paths and masks.
    bool can_move_as_whole(const Reference& filter) const {
        if (local_name(filter.node) == "svg") return false;
        return std::all_of(rest_.references.begin(), rest_.references.end(), [&](const Reference& r) {
            if (is_filter(r) || r.first_inside == r.end_inside) return true;
            const bool is_inside = r.node != filter.node && is_in(r.node, filter.node);
            const bool is_held =
                r.first_inside >= filter.first && r.end_inside <= filter.end && !is_in(filter.node, r.target);
            return is_inside == is_held;
        });
    }

    /// Removes the map of the enclosing element with a filter from a shape's map.
    Affine2 unfiltered(std::size_t shape, std::size_t frame, const Affine2& map) const {
        const std::size_t by = filter_of_[shape];
        return by == none ? map : compose(*inverse(filter_maps_[by][frame]), map);
    }

    std::optional<FileError> write(const CurveDeformer& curves) {
        std::vector<bool> has_transform_track(rest_.shapes.size());
        if (frames_ > 1) {
            for (AffinePart& part : affine_parts(rest_, curves, frames_, tolerance_)) {
                for (std::size_t f = 0; f < frames_; ++f)
                    part.maps[f] = unfiltered(part.first, f, part.maps[f]);
                add_transform_track(part.node, part.to_root, part.maps, part.box, result_.tracks);
                for (std::size_t i = part.first; i < part.end; ++i) has_transform_track[i] = true;
            }
        }
        PaintFollower paint(work_, styles_, ids_, tolerance_, result_.tracks);
        for (std::size_t i = 0; i < rest_.shapes.size(); ++i) {
            if (moves_[i] && !rest_.shapes[i].is_extent && !has_transform_track[i]) write_shape_of(i, paint);
        }
        for (std::size_t k = 0; k < filter_maps_.size(); ++k) {
            if (filter_maps_[k].empty()) continue;
            const Reference& r = rest_.references[k];
            wrap_with_clips(rest_, styles_, r.node);
            add_transform_track(r.node, r.to_root, filter_maps_[k], regions_[k].before, result_.tracks);
        }
        auto& warnings = result_.report.warnings;
        follow_regions(work_, rest_, regions_, result_.tracks, warnings);
        warnings.insert(warnings.end(), paint.warnings.begin(), paint.warnings.end());
        fit();
        // Animated elements will get children; add placeholders, so that selectors match as in the result.
        std::vector<pugi::xml_node> animations;
        const std::string name = name_prefix(root_element(work_.xml)) + "animate";
        for (const auto& track : result_.tracks) {
            if (frames_ > 1) animations.push_back(pugi::xml_node(track.node).append_child(name.c_str()));
        }
        result_.show(0); // selectors may match attributes
        styles_.settle(warnings);
        for (pugi::xml_node animation : animations) animation.parent().remove_child(animation);
        return std::nullopt;
    }

    /// Writes a deformed shape, its paints and markers.
    void write_shape_of(std::size_t i, PaintFollower& paint) {
        const DrawnShape& shape = rest_.shapes[i];
        Moved& moved = moved_[i];
        for (std::size_t f = 0; f < frames_; ++f) moved.maps[f] = unfiltered(i, f, moved.maps[f]);
        if (shape.is_box) {
            wrap_with_clips(rest_, styles_, shape.node);
            if (moved.has_map)
                add_transform_track(shape.node, shape.to_root, moved.maps, boxes_at_rest_[i], result_.tracks);
            return;
        }
        if (moved.pen_not_rotated)
            result_.report.warnings.push_back(
                label(work_, shape.node) + ": the pen of its stroke is not rotated, since the transform is "
                                           "skewed and it has a clip path, a mask or a filter");
        for (std::size_t f = 0; f < moved.turns.size(); ++f) // the map without the rotation
            moved.maps[f] = compose(*inverse(moved.turns[f]), moved.maps[f]);
        if (moved.gains_inside) styles_.set(shape.node, "fill", "none");
        if (moved.has_map && !shape.clips) paint.follow(shape, moved.maps, boxes_at_rest_[i], moved.boxes);
        const std::string kind = local_name(shape.node);
        const bool takes_markers = kind != "rect" && kind != "circle" && kind != "ellipse";
        if (takes_markers && has_markers(shape)) turn_markers(shape, moved.maps);
        const bool adds_vertices = takes_markers && !shape.markers[1].empty() && has_other_vertices(moved);
        if (adds_vertices) write_path(add_marked_path(styles_, shape.node), i, std::move(moved.marked));
        if (adds_vertices || (!takes_markers && has_markers(shape))) drop_markers(styles_, shape.node);
        write_path(shape.node, i, std::move(moved.paths));
    }

    /// Rotates markers with a fixed direction by the rotation of the shape's best map. Shapes with equal
    /// rotations share a copy.
    void turn_markers(const DrawnShape& shape, const std::vector<Affine2>& maps) {
        AnimatedSvg::Track track{.node = {}, .attribute = "orient", .scale = largest_scale(shape.to_root)};
        std::string name;
        bool turns = false;
        for (const Affine2& map : maps) {
            const Affine2 turn = turn_of(compose(compose(shape.from_root, map), shape.to_root), {});
            double angle = std::atan2(turn.b, turn.a) * 180 / std::numbers::pi;
            if (!track.numbers.empty()) // nearest to the last angle
                angle += 360 * std::round((track.numbers.back() - angle) / 360);
            track.numbers.push_back(angle);
            name += ' ' + format_number(angle, 3);
            turns = turns || std::abs(angle) > 1e-3;
        }
        for (std::size_t k = 0; turns && k < shape.markers.size(); ++k) {
            const std::string& id = shape.markers[k];
            pugi::xml_node marker = id.empty() ? pugi::xml_node() : ids_.find(id);
            const std::string orient = attribute_text(marker, "orient");
            if (local_name(marker) != "marker" || orient.starts_with("auto")) continue;
            std::string& copy_id = turned_markers_[id + name];
            if (copy_id.empty()) {
                pugi::xml_node copy = marker.parent().insert_copy_after(marker, marker);
                drop_ids(copy);
                copy_id = ids_.name(copy, id);
                result_.tracks.push_back(track);
                result_.tracks.back().node = copy;
                for (double& angle : result_.tracks.back().numbers) angle += angle_of(orient).value_or(0);
            }
            styles_.set(shape.node, marker_properties[k], "url(#" + copy_id + ')');
        }
    }

    /// Whether the deformed path has other vertices than the original.
    static bool has_other_vertices(const Moved& moved) {
        for (std::size_t f = 0; f < moved.paths.size(); ++f) {
            if (write_path_data(moved.paths[f], 17) != write_path_data(moved.marked[f], 17)) return true;
        }
        return false;
    }

    void write_path(pugi::xml_node node, std::size_t index, std::vector<Path> paths) {
        const DrawnShape& shape = rest_.shapes[index];
        const std::vector<Affine2>& turns = moved_[index].turns;
        const auto turned = [](const Affine2& map) { return !(map == Affine2()); };
        if (std::any_of(turns.begin(), turns.end(), turned))
            add_transform_track(node, shape.to_root, turns, boxes_at_rest_[index], result_.tracks);
        Affine2 to_root = shape.to_root; // of the frame with the largest scale
        for (std::size_t f = 0; f < frames_; ++f) {
            const Affine2 there = compose(*inverse(unfiltered(index, f, {})), shape.to_root);
            if (largest_scale(there) > largest_scale(to_root)) to_root = there;
        }
        write_shape(node, {}); // show() writes the data
        result_.tracks.push_back(
            {.node = node,
             .attribute = "d",
             .scale = largest_scale(to_root),
             .paths = std::move(paths),
             .decimals = options_.decimals >= 0 ? options_.decimals : decimals_for(to_root, tolerance_)});
    }

    void fit() {
        const Box window = box_of(view_);
        Box all = window;
        for (std::size_t i = 0; i < rest_.shapes.size(); ++i) {
            if (seen_after_[i].empty() || seen_before_[i].within(window).empty()) continue; // was not visible
            Box reach = window; // parts that were cut off before may stay cut off
            reach.add(seen_before_[i]);
            if (reach.grown(1e-3 * diagonal_).contains(seen_after_[i])) continue;
            ++result_.report.cut_off;
            all.add(seen_after_[i]);
        }
        if (!options_.fit || result_.report.cut_off == 0) return;
        if (has_percentages(root_element(work_.xml))) keep_percentages(root_element(work_.xml), view_);
        grow_view_box(root_element(work_.xml), view_, all.grown(1e-3 * diagonal_));
        result_.report.cut_off = 0;
    }

    SvgDocument& work_;
    const FrameDeformer& deformer_;
    std::size_t frames_;
    const DeformOptions& options_;
    AnimatedSvg& result_;
    StyleSheets styles_;
    IdTable ids_;
    ViewBox view_;
    double diagonal_ = 0, tolerance_ = 0;
    std::map<std::string, std::string> turned_markers_; // ids of copies, by marker and angles
    Drawing rest_;                                      // its paths are those of the frame processed last
    std::vector<bool> moves_;
    std::vector<Moved> moved_;
    static constexpr std::size_t none = std::size_t(-1);
    std::vector<std::size_t> filter_of_; // #shapes: reference of the enclosing element that moves, or none
    std::vector<std::vector<Affine2>> filter_maps_; // #references · #frames
    std::set<std::size_t> referring_;               // elements with references, by hash
    std::vector<bool> has_inside_at_rest_;          // #shapes
    std::vector<Box> boxes_at_rest_;                // each in its own user space
    std::vector<MovedRegion> regions_;              // of the references
    std::vector<Box> seen_before_, seen_after_;
};

} // namespace detail

Expected<AnimatedSvg> animate(const SvgDocument& document, const FrameDeformer& deformer, std::size_t frames,
                              const DeformOptions& options) {
    AnimatedSvg result;
    result.document = detail::copy_of(document);
    detail::DocumentMover mover(result.document, deformer, frames, options, result);
    if (auto error = mover.run()) return std::move(*error);
    if (!mover.moved()) result.document = detail::copy_of(document);
    return result;
}

Expected<DeformReport> deform(SvgDocument& document, const Deformer& deformer, const DeformOptions& options) {
    const FrameDeformer one_frame = [&](std::span<const Point2> in, std::span<const PointRole>,
                                        std::span<Point2> out) { return deformer(in, out); };
    auto deformed = animate(document, one_frame, 1, options);
    if (!deformed) return deformed.error();
    document = std::move(deformed->document);
    return std::move(deformed->report);
}

} // namespace cageform_support
