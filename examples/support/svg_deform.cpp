#include "svg_curves.hpp"
#include "svg_shapes.hpp"
#include "svg_style.hpp"
#include "svg_walk.hpp"
#include "svg_xml.hpp"

#include <cmath>

namespace cageform_examples {

namespace detail {

void warn_of_fixed_paint(const SvgDocument& document, std::vector<std::string>& warnings) {
    const pugi::xml_node root = root_element(document.xml);
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        const std::string kind = local_name(node);
        const bool gradient = kind == "linearGradient" || kind == "radialGradient";
        const char* const units = gradient ? "gradientUnits" : "patternUnits";
        if (!gradient && kind != "pattern") continue;
        if (attribute_text(node, units) != "userSpaceOnUse") continue;
        warnings.push_back(label(document, node) + ": is in user space and stays where it is");
    }
}

} // namespace detail

SvgResult<DeformReport> deform(SvgDocument& document, const Deformer& deformer,
                               const DeformOptions& options) {
    DeformReport report;
    SvgDocument work = detail::copy_of(document);
    const auto view = view_box(work);
    if (!view) return view.error();
    detail::adapt_style_sheets(work, report.warnings);
    auto drawn = detail::drawn_shapes(work, report.warnings);
    if (!drawn) return drawn.error();
    detail::warn_of_fixed_paint(work, report.warnings);

    const double diagonal = std::hypot(view->width, view->height);
    const bool given = options.tolerance > 0 && std::isfinite(options.tolerance);
    const double tolerance = given ? options.tolerance : 2e-5 * diagonal;
    std::vector<Path> paths;
    paths.reserve(drawn->size());
    for (detail::DrawnShape& shape : *drawn) paths.push_back(std::move(shape.path));
    detail::CurveDeformer curves(deformer, tolerance, diagonal, options.max_halvings, report);
    if (!curves.run(paths)) return SvgError{work.name + ": " + curves.failure()};

    for (std::size_t i = 0; i < paths.size(); ++i) {
        const Affine2& m = (*drawn)[i].to_root;
        const double scale = std::hypot(std::hypot(m.a, m.b), std::hypot(m.c, m.d));
        int decimals = 0;
        while (decimals < 15 && 20 * scale > tolerance * std::pow(10.0, decimals)) ++decimals;
        if (options.decimals >= 0) decimals = options.decimals;
        const Path local = transformed(std::move(paths[i]), (*drawn)[i].from_root);
        const bool good = detail::in_range(local);
        if (!good) return detail::error_at(work, (*drawn)[i].node, "coordinates out of range");
        detail::write_shape((*drawn)[i].node, write_path_data(local, decimals));
    }
    report.shapes = paths.size();
    document = std::move(work);
    return report;
}

} // namespace cageform_examples
