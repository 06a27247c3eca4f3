#pragma once

// SVG documents: parse, find shapes, deform, write. pugixml parses the XML. Parts that do not change are
// written as they were read, including comments, white space and character references.
//
// Deformed shapes: path, rect, circle, ellipse, line, polyline and polygon, wherever they are drawn: in g, a,
// switch, nested svg, targets of `use`, and clip paths and masks of drawn elements. Each use of an element of
// the same file becomes a group with its own copy. A clip path or mask is copied if elements under different
// transforms share it, or if it uses objectBoundingBox units. Each shape becomes a <path>. Shapes that do not
// move are not rewritten.
//
// Affine motion: gradients and patterns (paint.hpp) follow the affine map that fits the motion of their
// shape's points best, by least squares. Texts, images and foreignObjects move as a whole by such a map.
// Under strong bending this fit is poor. An element with a filter moves as a whole, by the best affine map of
// its shapes; only by a rotation and a translation if one has a stroke or markers. Regions of filters, filter
// primitives and masks are enlarged to hold the moved shapes; light sources move with the shapes. The
// clipping region of a mask, a nested svg or a used symbol becomes a clip path. Markers with a fixed
// direction rotate with their shape.
//
// Not deformed: stroke widths. Shapes under a singular transform stay unchanged. A filter does not rotate if
// its element is an svg, or if elements outside share a clip path or mask with the content of its element. A
// warning names it if it has an offset or a drop shadow. Warnings also name every unknown property, attribute
// or element, and every one that should change with the pose but does not (properties.hpp). If a transform
// makes a stroke's pen elliptical, the pen rotates with the shape.
//
// Markers are drawn at the vertices of the file. If the deformation adds vertices to a path, an unpainted
// second path carries the markers.
//
// Invalid parts of attributes are ignored, as in browsers, with a warning. For cages and poses they are
// errors.
//
// Style sheets are kept, except geometry and transforms, which become attributes. An element may then match
// other rules: a rect has become a path, or a copy has another parent. Its style attribute then gets the
// values of the earlier rules.

#include "svg/path.hpp"

#include <pugixml.hpp>

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace cageform_support {

/// A parsed file. Text and attribute values stay escaped, as in the file.
struct SvgDocument {
    pugi::xml_document xml;
    std::string name;                                   // of the file, for messages
    std::unordered_map<std::size_t, std::size_t> lines; // xml_node::hash_value() -> line in the file
    /// Measured boxes of texts in their own user space: xml_node::hash_value() -> x0, y0, x1, y1
    std::unordered_map<std::size_t, std::array<double, 4>> text_boxes;
};

struct ViewBox {
    double x = 0;
    double y = 0;
    double width = 0;
    double height = 0;
};

/// A drawn shape in the user space of the root element (the units of its viewBox).
struct SvgShape {
    std::string label; // such as: rect "wall" (line 12)
    Path path;
    bool is_circle = false; // a circle element: four arcs, or no path if the radius is 0
};

/// Maps points `in` to `out`, of equal length, in root user space; false stops the deformation. It has to be
/// a pure function of the point: curves stay connected because equal points have equal images.
using Deformer = std::function<bool(std::span<const Point2> in, std::span<Point2> out)>;

/// Layer and visibility of a point.
struct PointRole {
    std::size_t layer = 0; // index into DeformOptions::layers, from 1; 0: none
    bool is_seen = true;   // false: in a clip path or mask, hidden, transparent, unpainted or clipped off
};

/// As Deformer, into several frames: out[f * in.size() + i] is point i in frame f.
///
///   roles   #in
using FrameDeformer =
    std::function<bool(std::span<const Point2> in, std::span<const PointRole> roles, std::span<Point2> out)>;

struct DeformOptions {
    double tolerance = 0; // in root user units; 0: 2e-5 of the diagonal of the viewBox
    int max_halvings = 8; // of a piece outside the tolerance
    bool fit = false;     // enlarge the viewBox and the size to hold the moved shapes
    int decimals = -1;    // of coordinates; negative: rounding errors of at most 1/20 of the tolerance
    /// Ids of elements: content of the first is layer 1 and so on; all else is layer 0.
    std::vector<std::string> layers = {};
};

struct DeformReport {
    std::size_t shapes = 0;
    std::size_t points = 0;   // passed to the deformer
    std::size_t batches = 0;  // calls of the deformer
    std::size_t segments = 0; // written
    std::size_t coarse = 0;   // segments outside the tolerance after `max_halvings`
    std::size_t cut_off = 0;  // shapes that extend farther beyond the viewBox than before
    std::vector<std::string> warnings;
};

namespace detail {

pugi::xml_node root_element(pugi::xml_node node);

/// Namespace prefix of SVG elements: "svg:" if the root is <svg:svg>, else empty.
std::string name_prefix(pugi::xml_node node);

std::string attribute_text(pugi::xml_node node, const char* name);

void set_attribute(pugi::xml_node node, const char* name, const std::string& raw);

/// A copy, with line numbers.
SvgDocument copy_of(const SvgDocument& document);

} // namespace detail

/// Parses a document.
///
///   name       prefix of every message
///   encoding   any that pugixml detects; line numbers only in UTF-8; output is always UTF-8
///   fails      if the text is empty, not XML, nested too deeply, or <svg> is not its only root
Expected<SvgDocument> parse_svg(std::string_view text, std::string name);

/// As parse_svg(), from a file, also compressed by gzip; fails also if it cannot be read or decompressed.
Expected<SvgDocument> load_svg(const std::filesystem::path& path);

/// The document as UTF-8 text. Unchanged parts are as they were read, except white space inside tags, the
/// kind of quotes, and <a></a> for <a/>.
std::string to_text(const SvgDocument& document);

/// The viewBox of the root; if invalid, its width and height; else 300 x 150, as in CSS.
ViewBox view_box(const SvgDocument& document);

namespace detail {

/// The viewBox of an element; nothing if invalid.
std::optional<ViewBox> view_box_of(pugi::xml_node node);

/// A shape found by walk(). Texts and images, if requested, have the outline of their box as path.
struct DrawnShape {
    pugi::xml_node node;
    Affine2 to_root;
    Affine2 from_root;
    Path path;                  // in root user space
    std::string fill = "black"; // computed values, as for the fields below
    std::string stroke = "none";
    double stroke_width = 1; // in its own user space
    double fill_opacity = 1, stroke_opacity = 1;
    bool has_fill = true, has_stroke = false; // visible
    double miter_limit = 4;
    bool has_miters = true;                  // stroke-linejoin
    bool has_square_caps = false;            // stroke-linecap
    bool has_dashes = false;                 // stroke-dasharray
    bool even_odd = false;                   // fill-rule
    bool is_visible = true;                  // visibility
    bool is_transparent = false;             // itself or an ancestor
    std::array<std::string, 3> markers;      // ids: start, mid, end
    int level = 0;                           // number of enclosing clip paths and masks
    bool clips = false;                      // inside a clip path
    bool is_box = false;                     // text or an image
    std::optional<std::size_t> text_on_path; // index of the text, part of which follows this path
    bool is_extent = false;                  // extent of letters on a path: not written
};

/// Returns the drawn shapes in document order. Changes the document without changing its appearance: every
/// `use` becomes a group with a copy, and clip paths and masks in use under several transforms are copied.
Expected<std::vector<DrawnShape>> drawn_shapes(SvgDocument& document, std::vector<std::string>& warnings);

/// Converts the element to a <path> with this data; `d` replaces the first geometry attribute.
void write_shape(pugi::xml_node node, const std::string& data);

} // namespace detail

/// All drawn shapes in document order, uses expanded, without clip paths and masks. Fails on an invalid
/// attribute, since cages and poses have to be exact.
Expected<std::vector<SvgShape>> shapes(const SvgDocument& document);

/// A cage: the loops of the first shape that consists of closed polygons, in root user space.
///
///   shapes    a polygon, a closed path of lines, a rect without round corners, a closed polyline
///   returns   loops in document order and orientation with all corners, the first not repeated. Nothing is
///             merged or sorted, since a pose has to match its cage corner by corner
///   fails     if there is no such shape; the message describes the first shape
Expected<std::vector<std::vector<Point2>>> first_polygon(const SvgDocument& document);

/// A cage of curves: the subpaths of the first shape with a closed subpath, in root user space.
///
///   returns   subpaths in document order and direction, with the degrees of their segments; each ends
///             exactly at its start. Arcs become cubics of at most 45 degrees
///   closing   the line that Z adds is dropped if it is not longer than the coincidence tolerance of the
///             shape's control points
///   fails     if there is no such shape, or another of its subpaths is open; the message has its number,
///             counted from 0
Expected<std::vector<Subpath>> first_outline(const SvgDocument& document);

/// The vertices of every subpath, in root user space, in document order; fails if a subpath has curves.
Expected<std::vector<std::vector<Point2>>> straight_lines(const SvgDocument& document);

/// A figure's vertices: the end points of all segments in root user space, in document order. The start of a
/// closed subpath is not repeated.
Expected<std::vector<Point2>> figure_vertices(const SvgDocument& document);

/// Deforms all shapes, as described at the top of this file.
///
///   document   changed only on success
///   deformer   called with all points of the document, then with those of halved pieces: at most 1 +
///              max_halvings times
///   accuracy   all samples of a deformed curve, except DeformReport::coarse segments, are within the
///              tolerance of the path before rounding to `decimals`; features narrower than 1/64 of the
///              diagonal of the viewBox may be missed
///   skipped    shapes out of range, and shapes with a point whose image is not finite, with a warning
///   fails      if copies or points are too many; if elements are nested too deeply; if a layer has no shape.
///              Fails also if a coordinate is out of range in its element, or the deformer returns false
Expected<DeformReport> deform(SvgDocument& document, const Deformer& deformer,
                              const DeformOptions& options = {});

/// Timing attributes of an animation; empty for constant speed.
struct AnimationTiming {
    std::string times = {}, splines = {};
    bool adds = false; // additive="sum"
};

/// A document whose attributes change from frame to frame. Initially it shows frame 0.
struct AnimatedSvg {
    /// The values of an attribute: numbers, transforms or paths, one per frame.
    struct Track {
        pugi::xml_node node;
        std::string attribute;
        double scale = 1; // upper bound of the scale from the attribute's units to root units
        std::vector<double> numbers = {};
        std::vector<Affine2> maps = {};
        std::vector<Point2> places = {}; // of maps: corners of the content's box, before the map
        std::vector<Path> paths = {};
        int decimals = 6; // of numbers and paths in show()
    };

    SvgDocument document;
    std::vector<Track> tracks;
    DeformReport report;

    /// Sets the attributes to a frame.
    void show(std::size_t frame);

    /// Adds animations that repeat all frames at equal intervals. Replaces those of an earlier call.
    ///
    ///   tolerance   largest distance, in root units, between a played and an exact frame; key frames are
    ///               removed within it
    ///   returns     number of key frames of all attributes
    std::size_t play(double seconds, double tolerance);

    /// Adds one repeating animation to an element.
    ///
    ///   type     of a transform: translate, rotate, skewX or scale; else empty
    ///   values   separated by semicolons
    static pugi::xml_node append_animation(pugi::xml_node node, const std::string& attribute,
                                           const std::string& type, double seconds, const std::string& values,
                                           const AnimationTiming& timing = {});

private:
    std::vector<pugi::xml_node> animations_; // added by play()
};

/// As deform(), for several frames. A path has the same pieces in all frames; `fit` holds all frames.
///
///   frames   at least one
Expected<AnimatedSvg> animate(const SvgDocument& document, const FrameDeformer& deformer, std::size_t frames,
                              const DeformOptions& options = {});

} // namespace cageform_support
