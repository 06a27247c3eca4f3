#pragma once

// SVG documents: reading, finding the shapes, deforming them, writing back. The XML is pugixml's; what is
// not touched is written as it was read, comments, white space and character references included.
//
// Deformed shapes: path, rect, circle, ellipse, line, polyline and polygon. They are deformed wherever they
// are drawn: in g, a, switch, nested svg, copies for `use`, and clip paths or masks of drawn elements. Each
// use of an element of the same file becomes a group with its own copy. A clip path or mask is copied if
// elements under different transforms share it, or if it is in units of their boxes. Each shape becomes a
// <path> in its place. Shapes that do not move are not rewritten.
//
// Affine followers: gradients and patterns of a shape, in user space or in units of its box (paint.hpp),
// and a whole text, image or foreignObject follow the affine map that fits the motion of their points
// best, by least squares. Under a strong bend this fit is poor. An element with a filter moves as a whole, by
// the best affine map of its shapes. If a shape has a stroke or markers, the element only turns and shifts.
// Regions of filters, of their primitives and of masks are enlarged to hold the moved shapes; lights follow.
// The region of a mask, a nested svg or a used symbol that clips becomes a clip path. Markers of a fixed
// direction turn with their shape.
//
// Unchanged: the width of strokes. Shapes under a transform without inverse stay. A filter does not turn
// on an svg element. A filter on another element does not turn if elements outside share a clip path or mask
// with the content of the element. Warnings name both. Warnings also name every unknown property, attribute
// or element, and every one that should change with the pose but does not (properties.hpp). If a transform makes a stroke's pen elliptical, the pen turns with the shape.
//
// Markers stand at the vertices of the file. If deformation adds vertices to a path, an unpainted second
// path after it carries the markers.
//
// The part of an attribute that cannot be read is left out, as browsers do, with a warning. Cages and poses
// are read strictly: there it is an error.
//
// Style sheets stay as they are, but for geometry and transforms, which become attributes. If an element's
// matching rules change (a rect has become a path, a copy stands elsewhere), its style attribute keeps the
// values that the earlier rules gave.

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

/// The parsed file. Text and attribute values are kept escaped, exactly as in the file.
struct SvgDocument {
    pugi::xml_document xml;
    std::string name;                                   // for messages: the file's name
    std::unordered_map<std::size_t, std::size_t> lines; // xml_node::hash_value() -> line in the file
    /// The boxes of texts in their own user space, as far as they were measured: xml_node::hash_value() ->
    /// x0, y0, x1, y1
    std::unordered_map<std::size_t, std::array<double, 4>> text_boxes;
};

struct ViewBox {
    double x = 0;
    double y = 0;
    double width = 0;
    double height = 0;
};

/// A shape as it is drawn, in the user space of the root element (the units of its viewBox).
struct SvgShape {
    std::string label; // such as: rect "wall" (line 12)
    Path path;
    bool is_circle = false; // a circle element: four arcs, or no path where it has no radius
};

/// Maps `in` to `out`, of the same length, both in root user space; false stops the deformation. Has to be
/// a pure function of the point: curves meet because the same point always goes to the same place.
using Deformer = std::function<bool(std::span<const Point2> in, std::span<Point2> out)>;

/// The role of a point in the drawing.
struct PointRole {
    std::size_t layer = 0; // as DeformOptions::layers has them
    bool is_seen = true;   // false: in a clip path or mask, hidden, transparent, unpainted or clipped off
};

/// Works as Deformer, into several frames: out[f * in.size() + i] is where point i is in frame f.
///
///   roles   of each point
using FrameDeformer =
    std::function<bool(std::span<const Point2> in, std::span<const PointRole> roles, std::span<Point2> out)>;

struct DeformOptions {
    double tolerance =
        0; // user units of the root; 0 takes 2e-5 of the viewBox's diagonal, which is invisible
    int max_halvings = 8; // of a piece that misses the tolerance
    bool fit = false;     // grow the viewBox, and the size, to what has moved
    int decimals = -1;    // written; negative takes what makes rounding a twentieth of the tolerance
    /// Identifiers of elements: what is drawn in the first is layer 1, and so on; all else is layer 0.
    std::vector<std::string> layers = {};
};

struct DeformReport {
    std::size_t shapes = 0;
    std::size_t points = 0;   // handed to the deformer
    std::size_t batches = 0;  // calls of the deformer
    std::size_t segments = 0; // written
    std::size_t coarse = 0;   // of these, accepted outside the tolerance after `max_halvings`
    std::size_t cut_off = 0;  // shapes that now reach further beyond the viewBox than they did
    std::vector<std::string> warnings;
};

namespace detail {

pugi::xml_node root_element(pugi::xml_node node);

/// "svg:" where the root is <svg:svg>, else empty: what the names of SVG's elements begin with.
std::string name_prefix(pugi::xml_node node);

std::string attribute_text(pugi::xml_node node, const char* name);

void set_attribute(pugi::xml_node node, const char* name, const std::string& raw);

/// A copy that knows the lines of its elements.
SvgDocument copy_of(const SvgDocument& document);

} // namespace detail

/// A document from the text of a file.
///
///   name     stands before every message
///   fails    where the text is empty, is not XML, has no <svg> as its only root, or nests too deeply
///   encodings other than UTF-8 are read too, with lines unknown; writing is always UTF-8
Expected<SvgDocument> parse_svg(std::string_view text, std::string name);

/// Works as parse_svg(), from a file, packed by gzip or not; fails also where it cannot be read or
/// unpacked.
Expected<SvgDocument> load_svg(const std::filesystem::path& path);

/// The document's text in UTF-8; untouched parts are as they were read, but for the space inside tags, the
/// kind of quotes, and <a></a> for <a/>.
std::string to_text(const SvgDocument& document);

/// The viewBox of the root; without a valid one its width and height; without these 300 x 150, as in CSS.
ViewBox view_box(const SvgDocument& document);

namespace detail {

/// The viewBox of an element; nothing where it is not four numbers.
std::optional<ViewBox> view_box_of(pugi::xml_node node);

/// A shape found by the walk. Other requested elements (text, an image) have the outline of their box as
/// path.
struct DrawnShape {
    pugi::xml_node node;
    Affine2 to_root;
    Affine2 from_root;
    Path path;                  // in root user space
    std::string fill = "black"; // as CSS has them here, inherited
    std::string stroke = "none";
    double stroke_width = 1; // in its own user space
    double fill_opacity = 1, stroke_opacity = 1;
    bool has_fill = true, has_stroke = false; // that is not transparent
    double miter_limit = 4;
    bool has_miters = true;             // stroke-linejoin
    bool has_square_caps = false;       // stroke-linecap
    bool has_dashes = false;            // stroke-dasharray
    bool even_odd = false;              // fill-rule
    bool is_visible = true;             // visibility
    bool is_transparent = false;        // itself or what it stands in
    std::array<std::string, 3> markers; // the ids of those at its start, between and at its end
    int level = 0;                      // of clip paths and masks that it stands in; 0 is the picture itself
    bool clips = false;                 // stands in a clip path
    bool is_box = false;                // text or an image
    std::optional<std::size_t> carrier; // the text that it holds letters of, which has others beside them
    bool is_extent = false; // about where letters stand on a path: says how far they reach, is not written
};

/// Returns the drawn shapes in document order. The document is changed without changing its appearance:
/// every `use` becomes a group with a copy, and clip paths and masks needed under several transforms are
/// copied.
Expected<std::vector<DrawnShape>> drawn_shapes(SvgDocument& document, std::vector<std::string>& warnings);

/// Makes the element a <path> of this data; `d` takes the place of the first attribute it replaces.
void write_shape(pugi::xml_node node, const std::string& data);

} // namespace detail

/// All drawn shapes in document order, uses expanded, without what is in clip paths and masks. Fails where an
/// attribute cannot be read: of a cage or a pose every corner counts.
Expected<std::vector<SvgShape>> shapes(const SvgDocument& document);

/// A cage: the loops of the first shape that is made of closed polygons only, in root user space.
///
///   returns   the loops in the order and orientation drawn, all their corners, the first not repeated at the
///             end: a pose has to match its cage corner by corner, so nothing is merged or sorted
///   counts    a polygon, a closed path of lines, a rect without round corners, a polyline that returns
///   fails     where no shape is one; the message says what the first shape is instead
Expected<std::vector<std::vector<Point2>>> first_polygon(const SvgDocument& document);

/// A cage of curves: the subpaths of the first shape that has a closed one, in root user space.
///
///   returns   them in the order and direction drawn, with the degrees of their segments; each ends exactly
///             where it begins. Arcs are cubics of at most 45 degrees
///   closing   the line that Z adds is left out where it is no longer than the coincidence tolerance of the
///             shape's control points
///   fails     where there is no such shape, or another subpath of it is open; the message has its number,
///             counted from 0
Expected<std::vector<Subpath>> first_outline(const SvgDocument& document);

/// The points of every subpath, in root user space, in the order drawn; fails where one has curves.
Expected<std::vector<std::vector<Point2>>> straight_lines(const SvgDocument& document);

/// A figure's vertices: the end points of all segments in root user space, in document order. The point
/// where a subpath returns to its start is not repeated: a polygon of 30 corners gives 30.
Expected<std::vector<Point2>> figure_vertices(const SvgDocument& document);

/// Deforms every shape of the document, see the head of this file.
///
///   document   changed only on success
///   deformer   called with all points of the document at once, then with those of the pieces that
///              have to be halved, at most 1 + max_halvings times
///   accuracy   every sample of a deformed curve is within the tolerance of the path written, before the
///              rounding to `decimals`; features narrower than a 64th of the viewBox's diagonal may be missed
///   left       a shape out of range stays as it is, with a warning; so does a shape for which the deformer
///              gives a point that is not finite
///   fails      where copies are too many or nested too deeply, or when the deformer returns false
Expected<DeformReport> deform(SvgDocument& document, const Deformer& deformer,
                              const DeformOptions& options = {});

/// When an animation has which value: attributes, empty where an animation goes steadily.
struct AnimationTiming {
    std::string times = {}, splines = {};
    bool adds = false; // to the animations before it
};

/// A document whose attributes change from frame to frame. It shows the first.
struct AnimatedSvg {
    /// An attribute in every frame: as numbers, transforms or paths.
    struct Track {
        pugi::xml_node node;
        std::string attribute;
        double scale = 1; // upper bound of the factor from the attribute's units to root units
        std::vector<double> numbers = {};
        std::vector<Affine2> maps = {};
        std::vector<Point2> places = {}; // of maps: corners about all that they move
        std::vector<Path> paths = {};
        int decimals = 6; // of numbers and paths where a frame is shown
    };

    SvgDocument document;
    std::vector<Track> tracks;
    DeformReport report;

    /// Writes the attributes of a frame.
    void show(std::size_t frame);

    /// Adds the animations that play all frames, equally far apart, again and again: the first comes after
    /// the last. They replace those of an earlier call.
    ///
    ///   tolerance   the largest distance, in root units, between a played frame and the exact one; key
    ///               frames that this allows are left out
    ///   returns     the number of key frames, of all attributes
    std::size_t play(double seconds, double tolerance);

    /// Adds one animation, without end, to an element.
    ///   type     of a transform: translate, rotate, skewX or scale; else empty
    ///   values   with semicolons between them
    static pugi::xml_node append_animation(pugi::xml_node node, const std::string& attribute,
                                           const std::string& type, double seconds, const std::string& values,
                                           const AnimationTiming& timing = {});

private:
    std::vector<pugi::xml_node> animations_; // that play() has added
};

/// Works as deform(), in several frames. The pieces of a path are the same in all; the picture fits all
/// frames.
///
///   frames   at least one
Expected<AnimatedSvg> animate(const SvgDocument& document, const FrameDeformer& deformer, std::size_t frames,
                              const DeformOptions& options = {});

} // namespace cageform_support
