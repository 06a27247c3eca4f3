#include "svg_walk.hpp"

#include "svg_curves.hpp"
#include "svg_shapes.hpp"
#include "svg_style.hpp"
#include "svg_xml.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace cageform_examples {

namespace detail {

constexpr std::size_t max_svg_copies = 1'000'000; // nodes copied for `use` and shared clip paths

/// Walks what is drawn, in document order. The document is changed on the way, without changing what it
/// shows: every `use` becomes a group with a copy, and, where references are followed, clip paths and
/// masks needed under several transforms are copied. Give it a copy of the user's document.
class ShapeCollector {
public:
    ShapeCollector(SvgDocument& document, bool follow_references)
        : document_(document)
        , follow_references_(follow_references) {}

    std::optional<SvgError> collect() {
        const pugi::xml_node root = root_element(document_.xml);
        for (pugi::xml_node node = root; node; node = next_node(node, root)) {
            if (node.attribute("id")) ids_.try_emplace(attribute_text(node, "id"), node);
        }
        const auto view = view_box(document_);
        if (!view) return view.error();
        const Viewport viewport{view->width, view->height};
        if (visit_references(root, {}, viewport, 0)) visit_children(root, {}, viewport, 0);
        return error_;
    }

    std::vector<DrawnShape> shapes;
    std::vector<std::string> warnings;

private:
    struct Claim { // a clip path or mask whose content is deformed under this transform
        Affine2 to_root;
        std::string id;
    };

    bool fail(pugi::xml_node node, const std::string& why) {
        if (!error_) error_ = error_at(document_, node, why);
        return false;
    }

    bool fail_in(pugi::xml_node node, const std::string& attribute, const SvgError& error) {
        if (!error_) error_ = error_in(document_, node, attribute, error);
        return false;
    }

    void warn(pugi::xml_node node, const std::string& why) {
        warnings.push_back(label(document_, node) + ": " + why);
    }

    bool visit(pugi::xml_node node, const Affine2& parent, const Viewport& viewport, int depth) {
        const std::string kind = local_name(node);
        if (depth > max_svg_depth) return fail(node, "elements are nested too deeply");
        if (kind == "use") return visit_use(node, parent, viewport, depth);
        if (!is_group(kind) && !is_shape(kind) && !is_fixed(kind)) return true;

        // Pages and hidden layers need not lie in the cage. To be read (a cage, say) a shape may be hidden.
        if (follow_references_ &&
            (attribute_text(node, "display") == "none" || style_property(node, "display") == "none")) {
            warn(node, "is not displayed and stays as it is");
            return true;
        }
        Affine2 to_root = parent;
        if (!apply_transform(node, to_root)) return false;
        if (!visit_references(node, to_root, viewport, depth)) return false;
        if (is_shape(kind)) return add_shape(node, to_root, viewport);
        if (is_fixed(kind)) {
            warn(node, "cannot be deformed and stays as it is");
            return true;
        }
        if (kind != "svg") return visit_children(node, to_root, viewport, depth);

        const double x = length(node, "x", viewport.width, 0);
        const double y = length(node, "y", viewport.height, 0);
        Viewport inner{length(node, "width", viewport.width, viewport.width),
                       length(node, "height", viewport.height, viewport.height)};
        to_root = compose(to_root, {1, 0, 0, 1, x, y});
        if (!enter_view_box(node, to_root, inner)) return false;
        return visit_children(node, to_root, inner, depth);
    }

    bool visit_children(pugi::xml_node node, const Affine2& to_root, const Viewport& viewport, int depth) {
        for (pugi::xml_node child = node.first_child(); child;) {
            const pugi::xml_node next = child.next_sibling();
            if (!visit(child, to_root, viewport, depth + 1)) return false;
            child = next;
        }
        return true;
    }

    bool apply_transform(pugi::xml_node node, Affine2& to_root) {
        const auto map = parse_transform(attribute_text(node, "transform"));
        if (!map) return fail_in(node, "transform", map.error());
        to_root = compose(to_root, *map);
        if (!style_property(node, "transform").empty()) warn(node, "a transform in a style is not read");
        return true;
    }

    /// Maps the element's viewBox into `viewport`, which then becomes the viewBox's size.
    bool enter_view_box(pugi::xml_node node, Affine2& to_root, Viewport& viewport) {
        if (!node.attribute("viewBox")) return true;
        const auto v = parse_numbers(attribute_text(node, "viewBox"));
        if (!v || v->size() != 4) return fail(node, "viewBox is not four numbers");
        const Viewport box{(*v)[2], (*v)[3]};
        if (!(box.width > 0 && box.height > 0)) return true; // nothing is drawn, so nothing matters
        double sx = viewport.width / box.width;
        double sy = viewport.height / box.height;
        const std::string fit = attribute_text(node, "preserveAspectRatio");
        const auto says = [&](std::string_view word) { return fit.find(word) != std::string::npos; };
        if (!says("none")) sx = sy = says("slice") ? std::max(sx, sy) : std::min(sx, sy);
        const double along_x = says("xMin") ? 0 : says("xMax") ? 1 : 0.5;
        const double along_y = says("YMin") ? 0 : says("YMax") ? 1 : 0.5;
        const double x = (viewport.width - sx * box.width) * along_x - sx * (*v)[0];
        const double y = (viewport.height - sy * box.height) * along_y - sy * (*v)[1];
        to_root = compose(to_root, {sx, 0, 0, sy, x, y});
        viewport = box;
        return true;
    }

    // ---- use ----

    bool visit_use(pugi::xml_node use, const Affine2& parent, const Viewport& viewport, int depth) {
        const std::string reference = reference_of(use);
        const auto found = reference.starts_with('#') ? ids_.find(reference.substr(1)) : ids_.end();
        if (found == ids_.end()) {
            warn(use, "refers to nothing in this file (\"" + reference + "\") and stays as it is");
            return true;
        }
        const pugi::xml_node target = found->second;
        const std::string kind = local_name(target);
        bool cyclic = std::find(active_.begin(), active_.end(), target) != active_.end();
        for (pugi::xml_node node = use; node; node = node.parent()) cyclic = cyclic || node == target;
        if (cyclic) return fail(use, "uses itself through \"" + reference + '"');

        const bool flat = local_name(use.parent()) == "clipPath"; // which may hold no group
        const bool usable = is_shape(kind) || is_fixed(kind) ||
                            (!flat && (is_group(kind) || kind == "use" || kind == "symbol"));
        const bool has_content = std::any_of(use.begin(), use.end(), [](pugi::xml_node child) {
            const std::string name = local_name(child);
            return is_shape(name) || is_fixed(name) || is_group(name) || name == "use";
        });
        if (!usable || has_content) {
            warn(use, "cannot be expanded and stays as it is");
            return true;
        }
        if (!count_copies(target)) return fail(use, "the uses of this file expand to too much");

        const double x = length(use, "x", viewport.width, 0);
        const double y = length(use, "y", viewport.height, 0);
        std::string transform = use.attribute("transform").value();
        if (x != 0 || y != 0) {
            transform += transform.empty() ? "" : " ";
            transform += "translate(" + format_number(x, 17) + ' ' + format_number(y, 17) + ')';
        }
        const std::string width = use.attribute("width").value();
        const std::string height = use.attribute("height").value();
        std::vector<std::string> dropped = {"x", "y", "width", "height", "href"};
        for (const pugi::xml_attribute attribute : use.attributes()) {
            if (std::string_view(attribute.name()).ends_with(":href")) dropped.emplace_back(attribute.name());
        }
        for (const std::string& name : dropped) use.remove_attribute(name.c_str());

        if (flat) {
            pugi::xml_node copy = use.parent().insert_copy_after(target, use);
            drop_ids(copy);
            transform += std::string(transform.empty() ? "" : " ") + copy.attribute("transform").value();
            for (const pugi::xml_attribute attribute : use.attributes()) {
                if (!copy.attribute(attribute.name())) copy.append_copy(attribute);
            }
            if (!transform.empty()) set_attribute(copy, "transform", transform);
            if (use.attribute("id")) ids_[attribute_text(use, "id")] = copy;
            use.parent().remove_child(use);
            return visit(copy, parent, viewport, depth);
        }

        if (!transform.empty()) set_attribute(use, "transform", transform);
        use.set_name((name_prefix(use) + 'g').c_str());
        const pugi::xml_node copy = use.append_copy(target);
        drop_ids(copy);
        if (kind == "svg") {
            if (!width.empty()) set_attribute(copy, "width", width);
            if (!height.empty()) set_attribute(copy, "height", height);
        }
        if (kind == "symbol" && !symbol_to_group(copy, width, height, viewport)) return false;
        active_.push_back(target);
        const bool good = visit(use, parent, viewport, depth);
        active_.pop_back();
        return good;
    }

    bool symbol_to_group(pugi::xml_node copy, const std::string& width, const std::string& height,
                         const Viewport& viewport) {
        if (!width.empty()) set_attribute(copy, "width", width);
        if (!height.empty()) set_attribute(copy, "height", height);
        Viewport inner{length(copy, "width", viewport.width, viewport.width),
                       length(copy, "height", viewport.height, viewport.height)};
        Affine2 m;
        if (!enter_view_box(copy, m, inner)) return false;
        std::string transform = copy.attribute("transform").value();
        if (!(m == Affine2())) {
            transform += transform.empty() ? "matrix(" : " matrix(";
            for (const double value : {m.a, m.b, m.c, m.d, m.e, m.f}) {
                transform += format_number(value, 17) + ' ';
            }
            transform.back() = ')';
            set_attribute(copy, "transform", transform);
        }
        const auto unused = {"viewBox", "preserveAspectRatio", "x", "y", "width", "height", "refX", "refY"};
        for (const char* name : unused) copy.remove_attribute(name);
        copy.set_name((name_prefix(copy) + 'g').c_str());
        return true;
    }

    bool count_copies(pugi::xml_node top) {
        for (pugi::xml_node node = top; node; node = next_node(node, top)) ++copies_;
        return copies_ <= max_svg_copies;
    }

    static void drop_ids(pugi::xml_node top) {
        for (pugi::xml_node node = top; node; node = next_node(node, top)) node.remove_attribute("id");
    }

    // ---- clip paths and masks ----

    bool visit_references(pugi::xml_node node, const Affine2& to_root, const Viewport& viewport, int depth) {
        if (!follow_references_) return true;
        const auto good = [&](const char* property, const std::string& kind, const char* units) {
            const std::string id = referenced_id(node, property);
            const auto found = ids_.find(id);
            if (id.empty() || found == ids_.end() || local_name(found->second) != kind) return true;
            return visit_reference(node, property, id, units, found->second, to_root, viewport, depth);
        };
        return good("clip-path", "clipPath", "clipPathUnits") && good("mask", "mask", "maskContentUnits");
    }

    bool visit_reference(pugi::xml_node node, const char* property, const std::string& id, const char* units,
                         pugi::xml_node target, const Affine2& to_root, const Viewport& viewport, int depth) {
        if (attribute_text(target, units) == "objectBoundingBox") {
            warn(target, "is in units of the bounding box and stays as it is");
            return true;
        }
        if (std::find(active_.begin(), active_.end(), target) != active_.end()) {
            return fail(node, "refers to itself through \"#" + id + '"');
        }
        std::vector<Claim>& claims = claims_[target.hash_value()];
        const auto same = std::find_if(claims.begin(), claims.end(),
                                       [&](const Claim& claim) { return claim.to_root == to_root; });
        if (same != claims.end()) {
            if (same->id != id) set_referenced_id(node, property, id, same->id);
            return true;
        }

        pugi::xml_node content = target;
        std::string content_id = id;
        if (!claims.empty()) {
            if (!count_copies(target)) return fail(node, "the clip paths of this file expand to too much");
            content = target.parent().insert_copy_after(target, target);
            drop_ids(content);
            for (std::size_t i = claims.size() + 1; ids_.count(content_id) != 0; ++i) {
                content_id = id + '-' + std::to_string(i);
            }
            ids_[content_id] = content;
            set_attribute(content, "id", content_id);
            set_referenced_id(node, property, id, content_id);
        }
        claims.push_back({to_root, content_id});
        if (attribute_text(content, "maskUnits") == "userSpaceOnUse") {
            warn(content, "is deformed inside, but the rectangle that limits it stays");
        }

        Affine2 inner = to_root;
        if (local_name(content) == "clipPath" && !apply_transform(content, inner)) return false;
        active_.push_back(target);
        const bool good = visit_references(content, inner, viewport, depth + 1) &&
                          visit_children(content, inner, viewport, depth + 1);
        active_.pop_back();
        return good;
    }

    // ---- shapes ----

    double length(pugi::xml_node node, const char* name, double whole, double otherwise) {
        const auto value = length_of(document_, node, name, whole, otherwise);
        if (value) return *value;
        if (!error_) error_ = value.error();
        return otherwise;
    }

    bool add_shape(pugi::xml_node node, const Affine2& to_root, const Viewport& viewport) {
        auto read = shape_path(document_, node, viewport);
        if (!read) {
            error_ = read.error();
            return false;
        }
        Path path = std::move(*read);
        if (path.empty()) return true;
        const std::optional<Affine2> from_root = inverse(to_root);
        if (!from_root) {
            warn(node, "has a transform without inverse and stays as it is");
            return true;
        }
        path = transformed(std::move(path), to_root);
        if (!in_range(path)) return fail(node, "coordinates out of range");
        shapes.push_back({node, to_root, *from_root, std::move(path)});
        return true;
    }

    SvgDocument& document_;
    bool follow_references_;
    std::map<std::string, pugi::xml_node> ids_;
    std::unordered_map<std::size_t, std::vector<Claim>> claims_; // by the node they were first found on
    std::vector<pugi::xml_node> active_; // used elements, clip paths and masks that we are inside of
    std::size_t copies_ = 0;
    std::optional<SvgError> error_;
};

SvgResult<std::vector<DrawnShape>> collect_shapes(SvgDocument& document, bool follow_references,
                                                  std::vector<std::string>& warnings) {
    ShapeCollector collector(document, follow_references);
    if (std::optional<SvgError> error = collector.collect()) return *error;
    warnings.insert(warnings.end(), collector.warnings.begin(), collector.warnings.end());
    return std::move(collector.shapes);
}

SvgResult<std::vector<DrawnShape>> drawn_shapes(SvgDocument& document, std::vector<std::string>& warnings) {
    return collect_shapes(document, true, warnings);
}

} // namespace detail

} // namespace cageform_examples
