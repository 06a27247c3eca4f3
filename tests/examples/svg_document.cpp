#include "io/atomic_file.hpp"
#include "svg/document.hpp"
#include "svg/shapes.hpp"
#include "svg/style.hpp"
#include "svg/xml.hpp"

#include "support/larger.hpp"
#include "svg_texts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace svg_document_tests {

using namespace cageform_support;
using svg_texts::deformed;
using svg_texts::parsed;
using Result = svg_texts::Deformed;
namespace fs = std::filesystem;

namespace {

const std::string head = R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">)";

std::string svg(std::string_view content) {
    return head + std::string(content) + "</svg>";
}

bool contains(std::string_view text, std::string_view part) {
    return text.find(part) != std::string_view::npos;
}

bool identity(std::span<const Point2> in, std::span<Point2> out) {
    std::copy(in.begin(), in.end(), out.begin());
    return true;
}

/// Moves all points by less than the output's precision, so that unmoved shapes are written too.
bool hardly(std::span<const Point2> in, std::span<Point2> out) {
    std::transform(in.begin(), in.end(), out.begin(),
                   [](const Point2& p) { return Point2{p.x + 1e-9, p.y}; });
    return true;
}

bool shift(std::span<const Point2> in, std::span<Point2> out) {
    std::transform(in.begin(), in.end(), out.begin(), [](const Point2& p) { return Point2{p.x + 100, p.y}; });
    return true;
}

Point2 waved(const Point2& p) {
    return {p.x, p.y + std::sin(p.x)};
}

bool wave(std::span<const Point2> in, std::span<Point2> out) {
    std::transform(in.begin(), in.end(), out.begin(), waved);
    return true;
}

std::string error_of(std::string_view text) {
    SvgDocument document = parsed(text);
    const std::string before = to_text(document);
    const auto report = deform(document, identity);
    INFO(text);
    REQUIRE_FALSE(report);
    CHECK(to_text(document) == before);
    return to_string(report.error());
}

std::vector<SvgShape> shapes_of(std::string_view text) {
    const auto all = shapes(parsed(text));
    INFO(text);
    INFO((all ? std::string() : to_string(all.error())));
    REQUIRE(all);
    return *all;
}

/// The first shape as drawn, in the user space of the root, to four decimals.
std::string drawn(std::string_view content) {
    const auto all = shapes_of(svg(content));
    REQUIRE_FALSE(all.empty());
    return write_path_data(all.front().path, 4);
}

std::vector<std::string> warnings_of(std::string_view content) {
    return deformed(svg(content), hardly).report.warnings;
}

Point2 on_cubic(const Point2& a, const Segment& s, double t) {
    const double u = 1 - t;
    const auto mix = [&](double p, double q, double r, double v) {
        return u * (u * (u * p + t * q) + t * (u * q + t * r)) +
               t * (u * (u * q + t * r) + t * (u * r + t * v));
    };
    return {mix(a.x, s.p1.x, s.p2.x, s.p3.x), mix(a.y, s.p1.y, s.p2.y, s.p3.y)};
}

std::vector<Point2> samples(const Path& path, int steps) {
    std::vector<Point2> points;
    for (const Subpath& subpath : path) {
        Point2 from = subpath.start;
        for (const Segment& s : subpath.segments) {
            for (int i = 0; i <= steps; ++i)
                points.push_back(on_cubic(from, s, static_cast<double>(i) / steps));
            from = s.p3;
        }
    }
    return points;
}

/// A temporary folder for one test.
class Folder {
public:
    Folder()
        : path_(fs::temp_directory_path() / ("cageform-svg-" + std::to_string(std::random_device()()))) {
        fs::create_directories(path_);
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    const fs::path& path() const { return path_; }
    std::ptrdiff_t count() const {
        return std::distance(fs::directory_iterator(path_), fs::directory_iterator());
    }

private:
    fs::path path_;
};

std::string content_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void put(const fs::path& path, std::string_view text) {
    std::ofstream(path, std::ios::binary) << text;
}

/// A document with almost every feature, for tests that all of them are preserved.
const std::string rich = R"xml(<?xml version="1.0" encoding="UTF-8"?>
<?xml-stylesheet href="none.css"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "svg11.dtd" [ <!ENTITY grey "fill:#888"> ]>
<!-- before the root -->
<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 200 100">
  <title>a &amp; b &lt;c&gt; &#8364; é</title>
  <style><![CDATA[ .hero { fill: "red" } ]]></style>
  <defs>
    <linearGradient id="paint"><stop offset="0" stop-color="#123456"/></linearGradient>
    <linearGradient id="fixed" gradientUnits="userSpaceOnUse" x1="0" x2="200"/>
    <path id="leaf" d="M0 0 C 5 -5 10 -5 15 0 Z"/>
    <clipPath id="window"><rect width="60" height="60"/></clipPath>
  </defs>

  <g id="all" class="hero" transform="translate(10 10)" clip-path="url(#window)">
	<rect id="house" x="1" y="2" width="30" height="20" rx="3" fill="url(#paint)" style="fill:#888" data-note="kept"/>
    <circle cx="20" cy="30" r="10" stroke="black"/> <!-- a comment -->
    <use xlink:href="#leaf" x="5" y="50" fill="green"/><use href="#leaf" transform="rotate(45)"/>
    <text x="3" y="4">hello   <tspan>world</tspan></text>
  </g>
  <path d="M 150 10 H 190 V 50 Z M 160 20 h 5 v 5 z"/>
</svg>
<!-- after the root -->
)xml";

} // namespace

TEST_CASE("each kind of wrong file has its own message", "[examples][svg_document][load]") {
    const Folder folder;
    const auto message = [&](const fs::path& path) {
        const auto document = load_svg(path);
        REQUIRE_FALSE(document);
        return to_string(document.error());
    };
    const fs::path file = folder.path() / "a.svg";
    CHECK(contains(message(file), "a.svg: no such file"));
    CHECK(contains(message(folder.path()), "is a folder"));
    put(file, "");
    CHECK(message(file) == "a.svg: the file is empty");
    put(file, " \n");
    CHECK(message(file) == "a.svg: the file is empty");
    put(file, "hello");
    CHECK(message(file) == "a.svg: not XML: there is no element");
    put(file, "<svg>\n<g>\n</h>\n</svg>");
    CHECK(contains(message(file), "a.svg: not XML: "));
    CHECK(contains(message(file), "(line 3, column "));
    put(file, "<html/>");
    CHECK(message(file) == "a.svg: not SVG: the root element is <html>");
    put(file, "<svg/><svg/>");
    CHECK(message(file) == "a.svg: not XML: two root elements");
    put(file, "<svg/>and more");
    CHECK(message(file) == "a.svg: not XML: text outside the root element");
    put(file, std::string_view("<svg>\n\0</svg>", 13));
    CHECK(message(file) == "a.svg: not XML: null character (line 2, column 1)");
    put(file, rich);
    const auto document = load_svg(file);
    REQUIRE(document);
    CHECK(document->name == "a.svg");
}

TEST_CASE("an unchanged document is written as it was read", "[examples][svg_document][save]") {
    CHECK(to_text(parsed(rich)) == rich);
    const std::string once = deformed(rich, wave).text;
    CHECK(to_text(parsed(once)) == once);
    for (const std::string_view kept :
         {"<?xml-stylesheet href=\"none.css\"?>", "<!ENTITY grey \"fill:#888\">", "<!-- before the root -->",
          "a &amp; b &lt;c&gt; &#8364; é", "<![CDATA[ .hero { fill: \"red\" } ]]>",
          "<linearGradient id=\"paint\"><stop offset=\"0\" stop-color=\"#123456\"/></linearGradient>",
          "<path id=\"leaf\" d=\"M0 0 C 5 -5 10 -5 15 0 Z\"/>", "<!-- a comment -->",
          "\n\t<path id=\"house\"", "style=\"fill:#888\" data-note=\"kept\"/>",
          "hello   <tspan>world</tspan>", "<!-- after the root -->\n"}) {
        CAPTURE(kept);
        CHECK(contains(once, kept));
    }
    // single quotes may contain double quotes
    CHECK(to_text(parsed("<svg a='say \"x\"' b='y'/>")) == "<svg a=\"say &quot;x&quot;\" b=\"y\"/>");
}

TEST_CASE("other encodings are written as UTF-8", "[examples][svg_document][load]") {
    const std::string latin = "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><svg><title>\xe9</title></svg>";
    CHECK(to_text(parsed(latin)) ==
          "<?xml version=\"1.0\" encoding=\"UTF-8\"?><svg><title>\xc3\xa9</title></svg>");
    std::string utf16 = "\xff\xfe";
    for (const char c : std::string("<svg><path d=\"M0 0L1 1\"/></svg>")) utf16 += {c, '\0'};
    CHECK(to_text(parsed(utf16)) == "<svg><path d=\"M0 0L1 1\"/></svg>");
    CHECK(shapes_of(utf16).size() == 1);
    CHECK(to_text(parsed("\xef\xbb\xbf<svg/>")) == "<svg/>");
}

TEST_CASE("every basic shape becomes the path of the SVG specification", "[examples][svg_document][shapes]") {
    CHECK(drawn(R"(<rect x="1" y="2" width="3" height="4"/>)") == "M1 2 L4 2 L4 6 L1 6 Z");
    CHECK(drawn(R"(<rect width="10%" height="5mm"/>)") == "M0 0 L10 0 L10 18.8976 L0 18.8976 Z");
    CHECK(drawn(R"(<line x1="1" y1="2" x2="3"/>)") == "M1 2 L3 0");
    CHECK(drawn(R"(<polyline points="0,0 1,0 1,1"/>)") == "M0 0 L1 0 L1 1");
    CHECK(drawn(R"(<polygon points="0,0 1,0 1,1"/>)") == "M0 0 L1 0 L1 1 Z");
    CHECK(drawn("<polygon points=\"0,0&#10;1,0&#x9;1,1\"/>") == "M0 0 L1 0 L1 1 Z");
    CHECK(drawn(R"(<path d="M1 1h2v2z"/>)") == "M1 1 L3 1 L3 3 Z");
    CHECK(drawn(R"(<circle cx="5" cy="6" r="2"/>)").substr(0, 4) == "M7 6");
    CHECK(drawn(R"(<ellipse rx="2"/>)") == drawn(R"(<circle r="2"/>)"));
    for (const Point2& p :
         samples(shapes_of(svg(R"(<ellipse cx="1" cy="2" rx="30" ry="20"/>)"))[0].path, 50)) {
        CHECK(std::abs(std::hypot((p.x - 1) / 30, (p.y - 2) / 20) - 1) < 3e-4);
    }

    const std::string round = drawn(R"(<rect width="10" height="8" rx="2" ry="3"/>)");
    CHECK(round == write_path_data(*parse_path_data("M2 0H8A2 3 0 0 1 10 3V5A2 3 0 0 1 8 8H2A2 3 0 0 1 0 5V3"
                                                    "A2 3 0 0 1 2 0Z"),
                                   4));
    CHECK(drawn(R"(<rect width="10" height="8" rx="2"/>)") ==
          drawn(R"(<rect width="10" height="8" ry="2"/>)"));
    CHECK(drawn(R"(<rect width="10" height="8" rx="99" ry="1"/>)") ==
          drawn(R"(<rect width="10" height="8" rx="5" ry="1"/>)"));
    CHECK(drawn(R"(<rect width="4" height="4" rx="2" ry="0"/>)") == "M0 0 L4 0 L4 4 L0 4 Z");
    CHECK(shapes_of(svg(R"(<rect width="10" height="8" rx="5" ry="4"/>)"))[0].path[0].segments.size() == 4);

    CHECK(shapes_of(svg(R"(<rect width="5"/><ellipse rx="0" ry="3"/><path/><path d="none"/><polygon/>)"))
              .empty());
    const auto flat = shapes_of(svg(R"(<circle/>)")); // listed, so that no site is lost unseen
    REQUIRE(flat.size() == 1);
    CHECK((flat[0].is_circle && flat[0].path.empty()));
}

TEST_CASE("transforms accumulate through groups, viewBoxes and nested documents",
          "[examples][svg_document][transform]") {
    const std::string_view line = R"(<path d="M1 1L2 2"/>)";
    const auto within = [&](const std::string& before, const std::string& after) {
        return drawn(before + std::string(line) + after);
    };
    CHECK(within("<g transform='translate(10 0)'><a transform='scale(2)'><switch>", "</switch></a></g>") ==
          "M12 2 L14 4");
    CHECK(drawn(R"x(<path transform="rotate(90)" d="M1 0L2 0"/>)x") == "M0 1 L0 2");
    CHECK(within("<svg x='5' y='6'>", "</svg>") == "M6 7 L7 8");
    CHECK(within("<svg x='5' width='20' height='20' viewBox='0 0 10 10'>", "</svg>") == "M7 2 L9 4");
    CHECK(within("<svg width='20' height='40' viewBox='0 0 10 10'>", "</svg>") == "M2 12 L4 14");
    CHECK(within("<svg width='20' height='40' viewBox='0 0 10 10' preserveAspectRatio='none'>", "</svg>") ==
          "M2 4 L4 8");
    CHECK(within("<svg width='20' height='40' viewBox='0 0 10 10' preserveAspectRatio='xMinYMax'>",
                 "</svg>") == "M2 22 L4 24");
    CHECK(within("<svg width='20' height='40' viewBox='0 0 10 10' preserveAspectRatio='xMaxYMin slice'>",
                 "</svg>") == "M-16 4 L-12 8");
    CHECK(within("<svg width='50%' height='50%' viewBox='5 5 10 10'>", "</svg>") == "M-20 -20 L-15 -15");
    CHECK(
        drawn(R"(<svg width="20" height="20" viewBox="0 0 10 10"><rect width="50%" height="100%"/></svg>)") ==
        "M0 0 L10 0 L10 20 L0 20 Z");

    const auto view = view_box(parsed(R"(<svg viewBox="-1,-2 30 40" width="7"/>)"));
    CHECK(view.x == -1);
    CHECK(view.height == 40);
    CHECK(view_box(parsed(R"(<svg width="2in" height="96"/>)")).width == 192);
    CHECK(view_box(parsed("<svg/>")).width == 300);
    CHECK(view_box(parsed(R"(<svg viewBox="1 2 3" width="70" height="9"/>)")).width == 70);
}

TEST_CASE("only drawn elements are shapes", "[examples][svg_document][shapes]") {
    const std::string_view hidden = R"(<defs><path d="M0 0L1 1"/></defs><symbol><path d="M0 0L1 1"/></symbol>
        <pattern><path d="M0 0L1 1"/></pattern><marker><path d="M0 0L1 1"/></marker>
        <clipPath><path d="M0 0L1 1"/></clipPath><mask><path d="M0 0L1 1"/></mask><x:path xmlns:x="y" d="M0 0L1 1"/>)";
    CHECK(shapes_of(svg(hidden)).empty());
    const std::string text = svg(hidden);
    CHECK(deformed(text, shift).text == text);
    CHECK(deformed(text, shift).report.batches == 0);
    CHECK(shapes_of(svg(R"(<g display="none"><path style="display:none" d="M0 0L1 1"/></g>)")).size() == 1);
    CHECK(shapes_of(
              R"(<s:svg xmlns:s="http://www.w3.org/2000/svg"><s:path d="M0 0L1 1"/><path d="M0 0"/></s:svg>)")
              .size() == 1);
    const auto all = shapes_of(rich);
    REQUIRE(all.size() == 5);
    CHECK(all[0].label == "rect \"house\" (line 16)");
    CHECK(contains(all[2].label, "line"));
}

TEST_CASE("an element becomes a path in its place and keeps its other attributes",
          "[examples][svg_document][deform]") {
    CHECK(deformed(svg(R"(<rect id="a" x="1" y="2" class="k" width="3" height="4" fill="red"/>)"), hardly)
              .text == svg(R"(<path id="a" d="M1 2 L4 2 L4 6 L1 6 Z" class="k" fill="red"/>)"));
    CHECK(deformed(svg(R"x(<path pathLength="3" d="M0 0L1 1" marker-end="url(#m)"/>)x"), shift).text ==
          svg(R"x(<path pathLength="3" d="M100 0 L101 1" marker-end="url(#m)"/>)x"));
    CHECK(deformed(svg(R"(<line/>)"), shift).text == svg(R"(<path d="M100 0 L100 0"/>)"));
    CHECK(deformed(svg(R"(<line x1="1" d="junk"/>)"), shift).text == svg(R"(<path d="M101 0 L100 0"/>)"));
    // the transform is kept, so its inverse is applied to the data
    CHECK(
        deformed(svg(R"x(<g transform="scale(2)"><line transform="rotate(90)" x2="10" y1="5"/></g>)x"), shift)
            .text ==
        svg(R"x(<g transform="scale(2)"><path transform="rotate(90)" d="M0 -45 L10 -50"/></g>)x"));
    CHECK(contains(
        deformed(R"(<s:svg xmlns:s="http://www.w3.org/2000/svg"><s:line x2="1"/></s:svg>)", shift).text,
        R"(<s:path d="M100 0 L101 0"/>)"));
    CHECK_FALSE(contains(deformed(svg(R"(<path sodipodi:type="star" d="M0 0L1 1"/>)"), shift).text, "star"));
}

TEST_CASE("an element that has not moved stays as written", "[examples][svg_document][deform]") {
    const Result all = deformed(rich, identity);
    CHECK(all.text == rich);
    CHECK(all.report.shapes == shapes_of(rich).size() + 2); // the text's box and the clip path's content
    const auto right_half = [](std::span<const Point2> in, std::span<Point2> out) {
        std::transform(in.begin(), in.end(), out.begin(),
                       [](const Point2& p) { return Point2{p.x, p.x > 50 ? p.y + 1 : p.y}; });
        return true;
    };
    CHECK(deformed(svg(R"(<rect width="9" height="9"/><line x1="60" x2="70"/>)"), right_half).text ==
          svg(R"(<rect width="9" height="9"/><path d="M60 1 L70 1"/>)"));
}

TEST_CASE("the identity leaves every shape where it is", "[examples][svg_document][deform][property]") {
    const Result result = deformed(rich, hardly, {.decimals = 6});
    const auto before = shapes_of(rich);
    const auto after = shapes_of(result.text);
    REQUIRE(before.size() == after.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
        CAPTURE(before[i].label);
        const auto p = samples(before[i].path, 12);
        const auto q = samples(after[i].path, 12);
        REQUIRE(p.size() == q.size()); // nothing was split
        for (std::size_t k = 0; k < p.size(); ++k) CHECK(std::hypot(p[k].x - q[k].x, p[k].y - q[k].y) < 2e-6);
        REQUIRE(before[i].path.size() == after[i].path.size());
        for (std::size_t k = 0; k < before[i].path.size(); ++k) {
            CHECK(before[i].path[k].closed == after[i].path[k].closed);
        }
    }
    CHECK(result.report.batches == 1);
    CHECK(result.report.coarse == 0);
    CHECK(deformed(result.text, hardly, {.decimals = 6}).report.shapes == result.report.shapes);
}

TEST_CASE("lines stay lines, and closed paths stay closed", "[examples][svg_document][deform]") {
    const auto turn = [](std::span<const Point2> in, std::span<Point2> out) {
        for (std::size_t i = 0; i < in.size(); ++i) out[i] = {-in[i].y, in[i].x};
        return true;
    };
    CHECK(deformed(svg(R"(<path d="M0 0H90V80H0Z"/>)"), turn).text ==
          svg(R"(<path d="M0 0 L0 90 L-80 90 L-80 0 Z"/>)"));
    CHECK(deformed(svg(R"(<path d="M5 5M1 1L2 2L3 1Z L9 9"/>)"), shift).text ==
          svg(R"(<path d="M105 5 M101 1 L102 2 L103 1 Z M101 1 L109 9"/>)"));
    const auto all = shapes_of(deformed(svg(R"(<circle cx="50" cy="50" r="40"/>)"), wave).text);
    REQUIRE(all[0].path.size() == 1);
    CHECK(all[0].path[0].closed);
    CHECK_FALSE(all[0].path[0].segments.back().is_line()); // the last curve ends at the start
}

TEST_CASE("the written path is within the tolerance of the deformed curve",
          "[examples][svg_document][deform][property]") {
    // The wave keeps x, so a point is compared with the exact curve at the same x.
    const auto tolerance = GENERATE(1e-1, 1e-2, 1e-3, 1e-5);
    CAPTURE(tolerance);
    const DeformOptions options{.tolerance = tolerance, .max_halvings = 12, .decimals = 12};
    const std::string line =
        svg(R"x(<g transform="scale(2) rotate(10)"><line x1="-3" y1="1" x2="45" y2="7"/></g>)x");
    const Result result = deformed(line, wave, options);
    const Subpath original = shapes_of(line)[0].path[0];
    const Point2 a = original.start;
    const Point2 b = original.segments[0].p3;
    const auto all = shapes_of(result.text);
    const auto points = samples(all[0].path, 40);
    double worst = 0;
    for (const Point2& p : points) {
        const double y = a.y + (b.y - a.y) * (p.x - a.x) / (b.x - a.x);
        worst = cageform_tests::larger(worst, std::abs(p.y - waved({p.x, y}).y));
    }
    CHECK(worst <= 1.5 * tolerance); // vertical distance, also between the samples
    CHECK(result.report.coarse == 0);
    CHECK(result.report.segments == all[0].path[0].segments.size());

    // A period per sample: the wave is zero at all samples, and must not be mistaken for a straight line.
    const double length = 6 * 2 * std::numbers::pi;
    const Result aliased = deformed(svg("<line x2=\"" + format_number(length, 15) + "\"/>"), wave, options);
    double highest = 0;
    for (const Point2& p : samples(shapes_of(aliased.text)[0].path, 20))
        highest = cageform_tests::larger(highest, p.y);
    CHECK(highest == Approx(1).epsilon(0).margin(tolerance));
}

TEST_CASE("refinement needs few calls and has a limit", "[examples][svg_document][deform]") {
    std::string many;
    for (int i = 0; i < 300; ++i) many += "<circle cx='" + std::to_string(i % 90) + "' cy='50' r='8'/>";
    std::size_t calls = 0;
    std::size_t points = 0;
    const Result result = deformed(svg(many), [&](std::span<const Point2> in, std::span<Point2> out) {
        ++calls;
        points += in.size();
        return wave(in, out);
    });
    CHECK(calls <= 9);
    CHECK(result.report.batches == calls);
    CHECK(result.report.points == points);
    CHECK(result.report.shapes == 300);

    const auto torn = [](std::span<const Point2> in, std::span<Point2> out) {
        for (std::size_t i = 0; i < in.size(); ++i) out[i] = {in[i].x, in[i].x < 33.3 ? 0.0 : 50.0};
        return true;
    };
    const Result broken = deformed(svg("<line x2='100'/>"), torn, {.max_halvings = 5});
    CHECK(broken.report.coarse > 0);
    CHECK(broken.report.batches == 6);
}

TEST_CASE("an element that cannot be deformed stays, and the others are not affected",
          "[examples][svg_document][deform][error][property]") {
    const unsigned seed = GENERATE(range(1u, 13u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto path = [&](const std::string& id, double far) {
        std::string text = "<path id=\"" + id + "\" d=\"M";
        for (int k = 0; k < 7; ++k) {
            if (k == 1) text += 'C';
            const double x = 5 + double(random() % 900) / 10, y = 5 + double(random() % 900) / 10;
            text += format_number(x + (k == 3 ? far : 0), 17) + ' ' + format_number(y, 17) + ' ';
        }
        return text + "Z\"/>";
    };
    std::vector<std::string> elements;
    for (int n = 0; n < 6; ++n) elements.push_back(path("p" + std::to_string(n), 0));
    const std::array bad{path("bad", 1e20),
                         path("bad", -1e99),
                         path("bad", 1e301),
                         path("bad", 400), // where the deformer fails
                         std::string(R"(<rect id="bad" x="-1e15" width="2e15" height="9"/>)"),
                         std::string(R"(<g transform="scale(1e12) "><circle id="bad" cx="7" r="3"/></g>)")};
    const std::string& spoilt = bad[seed % bad.size()];
    const auto torn = [&](std::span<const Point2> in, std::span<Point2> out) {
        for (std::size_t i = 0; i < in.size(); ++i) out[i] = in[i].x > 110 ? Point2{NAN, 0} : waved(in[i]);
        return true;
    };
    const auto shown = [&](const std::string& before) {
        std::string content = before;
        for (const std::string& element : elements) content += element + '\n';
        return deformed(svg(content), torn);
    };
    const Result alone = shown("");
    REQUIRE(alone.report.warnings.empty());
    std::swap(elements[seed % 5], elements[5]); // the order does not matter
    const Result beside = shown(spoilt);
    REQUIRE(beside.report.warnings.size() == 1);
    CHECK(contains(beside.report.warnings[0], "\"bad\" (line 1)"));
    CHECK(contains(beside.report.warnings[0], "stays unchanged"));
    CHECK(contains(beside.text, spoilt));
    for (int n = 0; n < 6; ++n) {
        const auto begin = alone.text.find("<path id=\"p" + std::to_string(n));
        const std::string moved = alone.text.substr(begin, alone.text.find('>', begin) - begin);
        CAPTURE(moved);
        CHECK(moved.size() > 60);
        CHECK(contains(beside.text, moved));
    }
}

namespace {

/// The visible points that a deformer receives, and the number of the others. Nothing moves.
std::pair<std::vector<Point2>, std::size_t> seen_points(std::string_view text) {
    std::pair<std::vector<Point2>, std::size_t> found;
    const FrameDeformer look = [&](std::span<const Point2> in, std::span<const PointRole> roles,
                                   std::span<Point2> out) {
        for (std::size_t i = 0; i < in.size(); ++i) {
            if (roles[i].is_seen) found.first.push_back(in[i]);
            out[i] = in[i];
        }
        found.second += in.size() - found.first.size();
        return true;
    };
    INFO(text);
    REQUIRE(animate(parsed(text), look, 1));
    return found;
}

} // namespace

TEST_CASE("invisible points are recognized", "[examples][svg_document][deform][seen]") {
    const std::string fades = "<linearGradient id='fades'><stop stop-color='#a1b2c300'/><stop offset='1' "
                              "stop-opacity='0'/></linearGradient><linearGradient id='takes' href='#fades'/>";
    const std::string shows =
        "<radialGradient id='shows' color='#123'><stop stop-opacity='0'/><stop offset='.5' "
        "stop-color='currentColor'/></radialGradient><pattern id='tiles' width='9' height='9'><path "
        "d='M0 0h5v5z'/></pattern><pattern id='bare' width='9' height='9'/><linearGradient id='empty'/>";
    const std::string clips =
        "<clipPath id='nothing'/><clipPath id='hidden' visibility='hidden'><path d='M0 "
        "0h99v99z'/></clipPath>"
        "<clipPath id='all'><path d='M0 0h99v99H0z'/></clipPath><clipPath id='twice' "
        "clip-path='url(#nothing)'>"
        "<path d='M0 0h99v99H0z'/></clipPath><clipPath id='letters'><text x='15' y='25'>abc</text></clipPath>"
        "<mask id='clear'><rect width='99' height='99' fill='none'/></mask><mask id='open'><rect "
        "width='99' "
        "height='99' fill='#fff'/></mask><g clip-path='url(#nothing)'><clipPath id='inside'><path "
        "d='M0 0h99v99H0z'/></clipPath></g>";
    const auto is_seen = [&](const std::string& attributes, const std::string& group) {
        const auto [seen, others] =
            seen_points(svg("<defs>" + fades + shows + "</defs>" + clips + group + "<path " + attributes +
                            " d='M20 20H60V70z'/>" + (group.starts_with("<svg") ? "</svg>" : "</g>")));
        return !seen.empty();
    };
    for (const char* paint : {"hsl(9 20% 30% / 0)",
                              "hsla(9, 20%, 30%, 0%)",
                              "rgb(1 2 3/0%)",
                              "RGBA(1,2,3,0)",
                              "hwb(9 1% 2% / 0)",
                              "lab(9% 1 2 / none)",
                              "lch(9% 1 2/ 0)",
                              "oklab(.5 .1 .1 / 0)",
                              "oklch(.5 .1 .1 / 0.0)",
                              "color(display-p3 1 0 0 / 0)",
                              "Transparent",
                              "NONE",
                              "#0000",
                              "url(#gone)",
                              "url(#gone) none",
                              "url(#gone) rgb(0 0 0 / 0)",
                              "url(#fades)",
                              "url(#takes)",
                              "url(#empty) red",
                              "url(#bare)",
                              "url(#all)"}) {
        CAPTURE(paint);
        CHECK_FALSE(is_seen("fill='" + std::string(paint) + '\'', "<g>"));
        CHECK_FALSE(is_seen("fill='none' stroke='" + std::string(paint) + '\'', "<g>"));
        CHECK(is_seen("stroke='red' fill='" + std::string(paint) + '\'', "<g>"));
        if (contains(paint, "url(") || contains(paint, "NONE")) continue; // no colours
        CHECK_FALSE(is_seen("fill='CurrentColor'", "<g color='" + std::string(paint) + "'>"));
    }
    for (const char* paint : {"hsl(9 20% 30% / .01)", "hsl(9, 20%, 30%)", "rgb(0 0 0)", "color(srgb 0 0 0)",
                              "currentColor", "url(#gone) #123", "url(#gone) currentColor", "url(#shows)",
                              "url(#tiles)", "url(other.svg#fades)", "var(--ink)", "inherit"}) {
        CAPTURE(paint);
        CHECK(is_seen("fill='" + std::string(paint) + '\'', "<g>"));
    }
    for (const char* group :
         {"<g clip-path='url(#nothing)'>", "<g clip-path='url(#hidden)'>", "<g clip-path='url(#twice)'>",
          "<g mask='url(#clear)'>", "<g style='clip-path:circle(0 at 3px 4px)'>", "<g opacity='0%'>",
          "<g visibility='Hidden'>", "<g visibility='collapse'>", "<svg width='0' height='50'>",
          "<svg viewBox='0 0 90 0'>", "<svg width='9' height='9'>"}) {
        CAPTURE(group);
        CHECK_FALSE(is_seen("", group));
    }
    for (const char* group :
         {"<g clip-path='url(#all)'>", "<g clip-path='url(#gone)'>", "<g clip-path='url(#letters)'>",
          "<g clip-path='url(#inside)'>", "<g mask='url(#open)'>", "<g mask='url(#nothing)'>",
          "<g opacity='1%'>", "<svg width='9' height='9' overflow='visible'>"}) {
        CAPTURE(group);
        CHECK(is_seen("", group));
    }
    CHECK(is_seen("visibility='VISIBLE'", "<g visibility='hidden'>"));
    CHECK(seen_points("<svg xmlns='http://www.w3.org/2000/svg'><path d='M900 900h5v5z'/></svg>").second == 0);
}

TEST_CASE("the points of a clipped shape are visible inside the clipping box",
          "[examples][svg_document][deform][seen]"
          "[property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto number = [&](unsigned from, unsigned to) {
        return from + 0.3137 + double(random() % (to - from));
    };
    const double x = number(5, 35), y = number(5, 35), across = number(30, 60), down = number(30, 60);
    const auto text = [](double v) { return format_number(v, 4); };
    const std::string box =
        "x='" + text(x) + "' y='" + text(y) + "' width='" + text(across) + "' height='" + text(down) + '\'';
    const std::string view =
        "viewBox='" + text(x) + ' ' + text(y) + ' ' + text(across) + ' ' + text(down) + '\'';
    const std::string star = "<path d='M2 50L98 3L40 97L3 8L97 60z' fill='#369'/>";
    const std::string rect = "<rect fill='#fff' " + box + "/>";
    const auto [all, none] = seen_points(svg(star));
    CHECK(none == 0);
    std::vector<Point2> expected;
    std::copy_if(all.begin(), all.end(), std::back_inserter(expected), [&](const Point2& p) {
        return p.x >= x && p.x <= x + across && p.y >= y && p.y <= y + down;
    });
    REQUIRE(expected.size() > 3);
    REQUIRE(expected.size() < all.size());
    for (const std::string& content :
         {"<clipPath id='c'>" + rect + "</clipPath><g clip-path='url(#c)'>" + star + "</g>",
          "<mask id='c'>" + rect + "</mask><g mask='url(#c)'>" + star + "</g>",
          "<svg " + view + ' ' + box + '>' + star + "</svg>"}) {
        const auto [seen, others] = seen_points(svg(content));
        CHECK(seen == expected);
    }
}

TEST_CASE("a stopped deformation changes nothing", "[examples][svg_document][deform][error]") {
    SvgDocument document = parsed(rich);
    const auto stopped = deform(document, [](std::span<const Point2>, std::span<Point2>) { return false; });
    REQUIRE_FALSE(stopped);
    CHECK(stopped.error().message == "test.svg: the deformation was stopped");
    CHECK(to_text(document) == rich);
}

TEST_CASE("a use element becomes a group with its own copy", "[examples][svg_document][use]") {
    const std::string defs =
        R"(<defs><path id="p" class="c" d="M0 0L1 1"/><g id="g"><use href="#p" x="2"/></g></defs>)";
    CHECK(
        deformed(
            svg(defs + R"x(<use id="u" href="#p" x="3" y="4" width="9" transform="scale(2)" fill="red"/>)x"),
            shift)
            .text ==
        svg(defs +
            R"x(<g id="u" transform="scale(2) translate(3 4)" fill="red"><path class="c" d="M50 0 L51 1"/></g>)x"));
    CHECK(deformed(svg(defs + R"(<use xlink:href="#g"/>)"), hardly).text ==
          svg(defs + R"x(<g><g><g transform="translate(2 0)"><path class="c" d="M0 0 L1 1"/></g></g></g>)x"));
    CHECK(drawn(defs + R"(<use href="#g" x="1"/>)") == "M3 0 L4 1");

    const std::string symbol =
        R"(<symbol id="s" viewBox="0 0 10 10" fill="red"><path d="M0 0L10 10"/></symbol>)";
    CHECK(drawn(symbol + R"(<use href="#s" x="1" width="20" height="30"/>)") == "M1 5 L21 25");
    CHECK(drawn(symbol + R"(<use href="#s"/>)") == "M0 0 L100 100");
    CHECK(deformed(svg(symbol + R"(<use href="#s" width="20" height="20"/>)"), hardly).text ==
          svg(symbol +
              R"x(<g><g fill="red" transform="matrix(2 0 0 2 0 0)"><path d="M0 0 L10 10"/></g></g>)x"));
    const std::string inner =
        R"(<svg id="n" width="5" height="5" viewBox="0 0 10 10"><path d="M0 0L10 10"/></svg>)";
    CHECK(drawn("<defs>" + inner + R"(</defs><use href="#n" x="1" width="20" height="20"/>)") ==
          "M1 0 L21 20");

    // a shape used twice is deformed twice, each time where it is drawn
    const auto all = shapes_of(deformed(svg(defs + R"(<use href="#p"/><use href="#p" x="30"/>)"), wave).text);
    REQUIRE(all.size() == 2);
    CHECK(std::abs(all[1].path[0].start.y - std::sin(30.0)) < 1e-3);
}

TEST_CASE("use elements that cannot be expanded are reported", "[examples][svg_document][use][error]") {
    const std::string line = R"(<path d="M0 0 L1 1"/>)";
    for (const std::string& within :
         {R"(<g id="a">)" + line + R"(<use href="#a"/></g>)",
          R"(<defs><g id="a"><use href="#b"/></g><g id="b">)" + line +
              R"(<use href="#a"/></g></defs><use href="#a"/>)",
          line + R"(<use id="a" href="#a"/><use href="#a"/>)"}) { // browsers do not draw it
        CAPTURE(within);
        const Result result = deformed(svg(within), hardly);
        REQUIRE(result.report.warnings.size() == 1);
        CHECK(contains(result.report.warnings[0], "uses itself through \"#"));
        CHECK(shapes_of(result.text).size() == 1);
    }
    const auto missing = warnings_of(R"(<use id="u" href="#none"/><use href="other.svg#x"/><use/>)");
    REQUIRE(missing.size() == 3);
    CHECK(missing[0] == "use \"u\" (line 1): refers to nothing in this file (\"#none\") and stays unchanged");
    CHECK(warnings_of(R"(<linearGradient id="l"/><use href="#l"/>)").size() == 1);
    CHECK(warnings_of(R"(<use href="#t"><path id="t" d="M0 0L1 1"/></use>)").size() == 1);

    std::string laughs = R"(<defs><path id="u0" d="M0 0L1 1"/>)";
    for (int i = 1; i < 40; ++i) {
        const std::string use = "<use href='#u" + std::to_string(i - 1) + "'/>";
        laughs += "<g id='u" + std::to_string(i) + "'>" + use + use + "</g>";
    }
    CHECK(contains(error_of(svg(laughs + "</defs><use href='#u39'/>")), "expand to too many elements"));
}

TEST_CASE("clip paths and masks move with the clipped element", "[examples][svg_document][clip]") {
    const std::string clip = R"(<clipPath id="c"><rect width="9" height="9"/></clipPath>)";
    const std::string shifted = R"(<clipPath id="c"><path d="M100 0 L109 0 L109 9 L100 9 Z"/></clipPath>)";
    const std::string there = R"( d="M100 0 L101 1"/>)";
    CHECK(deformed(svg(clip + R"x(<path clip-path="url(#c)" d="M0 0L1 1"/>)x"), shift).text ==
          svg(shifted + R"x(<path clip-path="url(#c)")x" + there));
    CHECK(deformed(svg(clip + R"x(<path style="fill:red; clip-path: url('#c')" d="M0 0L1 1"/>)x"), shift)
              .text == svg(shifted + R"x(<path style="fill:red; clip-path: url('#c')")x" + there));
    CHECK(deformed(svg(clip + R"(<path d="M0 0L1 1"/>)"), shift).text == svg(clip + "<path" + there));

    // a use with the same transform shares the copy, with another transform it gets a copy with its own id
    const std::string used = R"x(<g clip-path="url(#c)"/><g clip-path="url(#c)"/>)x";
    CHECK(deformed(svg(clip + used), shift).text == svg(shifted + used));
    CHECK(
        deformed(
            svg(clip +
                R"x(<g id="c-2" clip-path="url(#c)"/><g transform="scale(2)" style="clip-path:url(#c)"/>)x"),
            shift)
            .text ==
        svg(shifted + R"(<clipPath id="c-3"><path d="M50 0 L59 0 L59 9 L50 9 Z"/></clipPath>)" +
            R"x(<g id="c-2" clip-path="url(#c)"/><g transform="scale(2)" style="clip-path:url(#c-3)"/>)x"));

    // a use in a clip path must not become a group
    CHECK(contains(
        deformed(svg(R"x(<rect id="r" transform="scale(2)" width="5" height="5"/>
              <clipPath id="c"><use href="#r" x="1" clip-rule="evenodd"/></clipPath><g clip-path="url(#c)"/>)x"),
                 shift)
            .text,
        R"x(<path transform="translate(1 0) scale(2)" d="M50 0 L55 0 L55 5 L50 5 Z" clip-rule="evenodd"/>)x"));
    CHECK(contains(
        deformed(svg(R"x(<mask id="m"><g><rect width="5" height="5"/></g></mask><g mask="url(#m)"/>)x"),
                 shift)
            .text,
        R"(<mask id="m"><g><path d="M100 0)"));
    const auto own = warnings_of(
        R"x(<clipPath id="c"><path clip-path="url(#c)" d="M0 0"/></clipPath><g clip-path="url(#c)"/>)x");
    REQUIRE(own.size() == 1);
    CHECK(contains(own[0], "refers to itself through \"#c\""));
    CHECK(warnings_of(R"x(<g clip-path="url(#none)" mask="none"/><g clip-path="url(x.svg#a)"/>)x").empty());
}

TEST_CASE("elements that cannot be deformed are reported", "[examples][svg_document][warnings]") {
    const auto all = warnings_of(R"x(<text id="t">x</text><image/><foreignObject/>
<path id="flat" transform="scale(0)" d="M0 0L1 1"/><g style="transform: turn(2)"/>
<style>
g:hover { fill: url(#a) } :hover { fill: red }</style>)x");
    REQUIRE(all.size() == 6);
    CHECK(all[0] == "text \"t\" (line 1): keeps its letters, and moves and turns as a whole");
    CHECK(all[1] == "image (line 1): cannot be deformed and stays unchanged"); // has no size
    CHECK(contains(all[2], "foreignObject"));
    CHECK(all[3] == "path \"flat\" (line 2): has a transform without inverse and stays unchanged");
    CHECK(all[4] == "style (line 4): \"g:hover\" refers to an element and is not read");
    CHECK(all[5] == "g (line 2): the property \"transform\" is not deformed: turn(2)");
}

TEST_CASE("unreadable parts are reported with their place, and the rest is deformed",
          "[examples][svg_document][error]") {
    struct Case {
        std::string written, read; // in the same way as browsers
        std::string fault;
    };
    const std::vector<Case> cases = {
        {"<path id='p' d='M9 9H20V30L 7 x'/>", "<path id='p' d='M9 9H20V30'/>",
         "path \"p\": d at 1:15: expected a number (line 2)"},
        {"<path d='L9 9'/>", "", "path: d at 1:1: a path begins with M (line 2)"},
        {"<g transform='turn(1)'><path d='M9 9H20'/></g>", "<path d='M9 9H20'/>",
         "g: transform at 1:1: no transform turn with 1 number (line 2)"},
        {"<use href='#u' transform='turn(1)' x='2'/>", "<use href='#u' x='2'/>",
         "use: transform at 1:1: no transform turn with 1 number (line 2)"},
        {"<use href='#bad'/>", "<path d='M5 5H9'/>", "path: d at 1:9: expected a number (line 1)"},
        {"<rect x='3 apples' width='5' height='5'/>", "<rect width='5' height='5'/>",
         "rect: x at 1:2: unknown unit \" apples\" (line 2)"},
        {"<circle r='?'/>", "", "circle: r at 1:1: expected a number (line 2)"},
        {"<polygon points='1 2 3 4 5 9 7'/>", "<polygon points='1 2 3 4 5 9'/>",
         "polygon: points: the number of coordinates is odd (line 2)"},
        {"<polyline points='1 2 3 9 x 5'/>", "", "polyline: points at 1:9: expected a number (line 2)"},
        {"<svg viewBox='1 2'><path d='M9 9H20'/></svg>", "<svg><path d='M9 9H20'/></svg>",
         "svg: viewBox is not four numbers (line 2)"}};
    const auto document = [&](const std::string& content) {
        return "<svg viewBox='0 0 90 90'><defs><path id='u' d='M1 2H9'/><path id='bad' d='M5 "
               "5H9L1'/></defs>\n" +
               content + "<ellipse cx='40' cy='40' rx='20' ry='9'/></svg>";
    };
    const auto drawn_by = [](const Result& result) {
        SvgDocument work = parsed(result.text);
        std::vector<std::string> ignored;
        std::string all;
        const auto shapes = detail::drawn_shapes(work, ignored);
        REQUIRE(shapes);
        for (const auto& shape : *shapes) all += write_path_data(shape.path, 3) + '\n';
        return all;
    };
    for (const auto& [written, read, fault] : cases) {
        CAPTURE(written);
        const Result result = deformed(document(written), wave);
        CHECK(result.report.warnings ==
              std::vector{"test.svg: " + fault + "; the faulty part is ignored, as in browsers"});
        CHECK(drawn_by(result) == drawn_by(deformed(document(read), wave)));
        const auto strict = shapes(parsed(document(written))); // of a cage or a pose every corner is needed
        REQUIRE_FALSE(strict);
        CHECK(to_string(strict.error()) == "test.svg: " + fault);
    }
    for (const std::string faulty : {"0 0 9", "0 0 9 9 9", "0 0 9px 9px", "none"}) { // of the root
        const std::string text =
            "<svg viewBox='" + faulty + "' width='80' height='70'><path d='M9 9H20'/></svg>";
        const Result result = deformed(text, wave);
        CHECK(result.report.warnings ==
              std::vector<std::string>{"test.svg: svg: viewBox is not four numbers "
                                       "(line 1); the faulty part is ignored, as in browsers"});
        CHECK(drawn_by(result) ==
              drawn_by(deformed("<svg viewBox='0 0 80 70'><path d='M9 9H20'/></svg>", wave)));
        CHECK_FALSE(shapes(parsed(text)));
    }
}

TEST_CASE("markers are at the moved vertices of the original path",
          "[examples][svg_document][markers][property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto at = [&] {
        return std::to_string(5 + random() % 90) + ' ' + std::to_string(5 + random() % 90) + ' ';
    };
    std::string data;
    for (int subpath = 0; subpath < 3; ++subpath) {
        data += 'M' + at();
        for (int k = 0; k < 4; ++k) {
            switch (random() % 4) {
            case 0: data += 'C' + at() + at() + at(); break;
            case 1: data += "A20 30 0 1 " + std::to_string(random() % 2) + ' ' + at(); break;
            case 2: data += 'Q' + at() + at(); break;
            default: data += 'L' + at();
            }
        }
        if (subpath > 0) data += 'Z';
    }
    const Deformer slope = [](std::span<const Point2> in, std::span<Point2> out) {
        std::transform(in.begin(), in.end(), out.begin(), [](const Point2& p) {
            return Point2{p.x + 0.003 * p.y * p.y, p.y - 0.002 * p.x * p.y};
        });
        return true;
    };
    const auto moved = [&](const Point2& p) {
        Point2 q;
        slope({&p, 1}, {&q, 1});
        return q;
    };
    SvgDocument document = parsed(svg(
        R"(<style>#line { stroke: red; marker-mid: url(#m) }</style><marker id="m" orient="auto"/><path id="line" d=")" +
        data + R"("/>)"));
    REQUIRE(deform(document, slope));
    const pugi::xml_node line = svg_texts::by_id(document, "line");
    const pugi::xml_node marked = line.next_sibling();
    const detail::StyleSheets styles(document);
    const auto value = [&](pugi::xml_node node, const char* name) { return styles.value(node, name).text; };
    CHECK(value(line, "marker-mid") == "none");
    CHECK(value(marked, "marker-mid") == "url(#m)");
    CHECK(value(marked, "stroke") == "red"); // a marker may take it
    CHECK(value(marked, "stroke-opacity") == "0");
    CHECK(value(marked, "fill-opacity") == "0");

    struct Vertex {
        Point2 at, leaves, arrives; // with the directions of the path, if the markers have them
    };
    const auto direction = [](const Point2& from, const Point2& to) {
        const double length = std::hypot(to.x - from.x, to.y - from.y);
        return Point2{(to.x - from.x) / length, (to.y - from.y) / length};
    };
    const auto vertices = [&](const Path& path, const auto& map) {
        std::vector<Vertex> all;
        for (const Subpath& subpath : path) {
            all.push_back({map(subpath.start), {}, {}});
            Point2 from = subpath.start;
            for (const Segment& s : subpath.segments) {
                const bool is_closing = &s == &subpath.segments.back() && subpath.has_closing_line;
                if (s.goes_on) all.pop_back();
                if (!s.goes_on && !is_closing)
                    all.back().leaves = direction(map(from), map(place_on(from, s, 1e-6)));
                const Point2 before = map(place_on(from, s, 1 - 1e-6));
                all.push_back({map(s.p3), {}, is_closing ? Point2() : direction(before, map(s.p3))});
                from = s.p3;
            }
        }
        return all;
    };
    const auto written =
        vertices(*parse_path_data(marked.attribute("d").value()), [](const Point2& p) { return p; });
    const auto wanted = vertices(*parse_path_data(data), moved);
    REQUIRE(written.size() == wanted.size());
    CHECK(vertices(*parse_path_data(line.attribute("d").value()), moved).size() > wanted.size());
    const auto apart = [](const Point2& a, const Point2& b) { return std::hypot(a.x - b.x, a.y - b.y); };
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        CAPTURE(i, data);
        CHECK(apart(written[i].at, wanted[i].at) < 1e-3);
        CHECK(apart(written[i].leaves, wanted[i].leaves) < 0.06);
        CHECK(apart(written[i].arrives, wanted[i].arrives) < 0.06);
    }
}

TEST_CASE("a path that needs no more vertices keeps its markers", "[examples][svg_document][markers]") {
    CHECK(deformed(svg(R"x(<path marker-mid="url(#m)" d="M0 0L1 1L2 0"/>)x"), shift).text ==
          svg(R"x(<path marker-mid="url(#m)" d="M100 0 L101 1 L102 0"/>)x"));
    CHECK(
        deformed(svg(R"x(<polygon points="0,0 1,1 2,0" marker-end="url(#m)" marker-mid="url(#m)"/>)x"), shift)
            .text ==
        svg(R"x(<path d="M100 0 L101 1 L102 0 Z" marker-end="url(#m)" marker-mid="url(#m)"/>)x"));
}

TEST_CASE("a stroke skewed by a group rotates with the shape", "[examples][svg_document][property]") {
    const unsigned seed = GENERATE(range(1u, 9u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    const Affine2 group{2, share(random), share(random), 1, 20 * share(random), 9};
    const bool mirrors = seed % 2 == 0;
    const double angle = 3 * share(random), c = std::cos(angle), s = std::sin(angle);
    const Affine2 pose{c, s, mirrors ? s : -s, mirrors ? -c : c, 30, -20};
    const std::string text =
        "<g transform='" + detail::write_transform(group, 6) +
        "'><path id='a' d='M3 4H20Q30 9 20 30Z' fill='none' stroke='red' transform='rotate(7)'/></g>";
    const auto shape_of = [](const SvgDocument& document) {
        SvgDocument work = detail::copy_of(document);
        std::vector<std::string> ignored;
        const auto shapes = detail::drawn_shapes(work, ignored);
        REQUIRE(shapes);
        REQUIRE(shapes->size() == 1);
        return shapes->front();
    };
    SvgDocument document = parsed(svg(text));
    const auto rest = shape_of(document);
    REQUIRE(deform(document, svg_texts::by(pose), {.decimals = 9}));
    const auto moved = shape_of(document);
    CHECK(write_path_data(moved.path, 3) == write_path_data(transformed(rest.path, pose), 3));
    const Affine2 wanted = compose(pose, rest.to_root);
    for (const double t : {0.0, 0.5, 1.0, 2.5}) { // the pen is as wide in every direction
        const auto reach = [t](const Affine2& m) {
            return std::hypot(m.a * std::cos(t) + m.b * std::sin(t), m.c * std::cos(t) + m.d * std::sin(t));
        };
        CHECK(reach(moved.to_root) == Approx(reach(wanted)));
    }
}

TEST_CASE("a cage is the first closed polygon", "[examples][svg_document][cage]") {
    const auto loops_of = [](std::string_view content) {
        const auto loops = first_polygon(parsed(svg(content)));
        INFO(content);
        INFO((loops ? std::string() : to_string(loops.error())));
        REQUIRE(loops);
        return *loops;
    };
    using Loop = std::vector<Point2>;
    const Loop triangle = {{0, 0}, {4, 0}, {4, 4}};
    CHECK(loops_of(R"(<polygon points="0,0 4,0 4,4"/>)") == std::vector<Loop>{triangle});
    CHECK(loops_of(R"(<path d="M0 0H4V4Z"/>)") == std::vector<Loop>{triangle});
    CHECK(loops_of(R"(<path d="M0 0H4V4L0 0Z"/>)") == std::vector<Loop>{triangle});
    // Coincident corners are kept: they may be two vertices of a pose.
    CHECK(loops_of(R"(<path d="M0 0H4H4V4Z"/>)") == std::vector<Loop>{{{0, 0}, {4, 0}, {4, 0}, {4, 4}}});
    CHECK(loops_of(R"(<polyline points="0,0 4,0 4,4 0,0"/>)") == std::vector<Loop>{triangle});
    CHECK(loops_of(R"x(<g transform="scale(4)"><polygon points="0,0 1,0 1,1"/></g>)x") ==
          std::vector<Loop>{triangle});
    CHECK(loops_of(R"(<rect width="2" height="3"/>)") == std::vector<Loop>{{{0, 0}, {2, 0}, {2, 3}, {0, 3}}});
    CHECK(loops_of(R"(<path d="M0 0L1 1"/><circle r="3"/><rect width="2" height="3" rx="1"/>
                      <polygon points="0,0 4,0 4,4"/><rect width="9" height="9"/>)") ==
          std::vector<Loop>{triangle});
    const auto ring = loops_of(R"(<path d="M3 1h.5v.5zM0 0H4V4zM2 1v.5h.5z"/>)");
    REQUIRE(ring.size() == 3);
    CHECK(ring[0][0] == Point2{3, 1});
    CHECK(ring[1] == triangle);
    CHECK(ring[2][0] == Point2{2, 1});

    const auto message = [](std::string_view content) {
        const auto loops = first_polygon(parsed(svg(content)));
        REQUIRE_FALSE(loops);
        return to_string(loops.error());
    };
    CHECK(message("") == "test.svg: no closed polygon: there is no shape");
    CHECK(message(R"(<path id="p" d="M0 0H1V1"/>)") ==
          "test.svg: no closed polygon: the first shape is an open path: path \"p\" (line 1)");
    CHECK(contains(message(R"(<circle r="1"/><line/>)"), "the first shape is a path with curves: circle"));
    CHECK(contains(message(R"(<path d="M0 0H1Z"/>)"), "a path of fewer than three corners"));
    CHECK(contains(message(R"(<path d="M0 0"/>)"), "an empty path"));
    CHECK(contains(message(R"(<path d="M0 0H1V1zM3 3H4"/>)"), "an open path"));
    CHECK(contains(message(R"(<path d="x"/>)"), "d at 1:1"));
}

TEST_CASE("a figure's vertices are the ends of its segments", "[examples][svg_document][figure]") {
    const auto vertices_of = [](std::string_view content) {
        const auto vertices = figure_vertices(parsed(svg(content)));
        REQUIRE(vertices);
        return *vertices;
    };
    std::string points;
    for (int i = 0; i < 30; ++i) points += std::to_string(i) + ',' + std::to_string(i * i % 17) + ' ';
    CHECK(vertices_of("<polygon points=\"" + points + "\"/>").size() == 30);
    CHECK(vertices_of("<polyline points=\"" + points + "\"/>").size() == 30);
    CHECK(vertices_of("<circle r=\"5\"/>").size() == 4);
    CHECK(vertices_of("").empty());
    const std::vector<Point2> expected = {{10, 0}, {11, 0}, {11, 1}, {5, 5}, {6, 7}};
    CHECK(vertices_of(
              R"x(<g transform="translate(10)"><path d="M0 0H1V1Z M9 9"/></g><path d="M5 5Q9 9 6 7"/>)x") ==
          expected);
}

TEST_CASE("saving replaces the whole file or changes nothing", "[examples][svg_document][save]") {
    const Folder folder;
    const SvgDocument document = parsed(rich);
    const fs::path file = folder.path() / "out.svg";
    const auto save = [&](const fs::path& path) { return write_file_atomically(path, to_text(document)); };
    CHECK_FALSE(save(file));
    CHECK(content_of(file) == rich);
    put(file, "old");
    CHECK_FALSE(save(file));
    CHECK(content_of(file) == rich);
    CHECK(folder.count() == 1);

    const auto missing = save(folder.path() / "no" / "out.svg");
    REQUIRE(missing);
    CHECK(contains(*missing, "cannot write"));
    const auto below_file = save(file / "out.svg");
    REQUIRE(below_file);
    fs::create_directory(folder.path() / "taken");
    const auto onto_folder = save(folder.path() / "taken");
    REQUIRE(onto_folder);
    CHECK(contains(*onto_folder, "not a regular file"));
    CHECK(folder.count() == 2);
    CHECK(content_of(file) == rich);

    std::error_code unsupported;
    fs::create_symlink(file, folder.path() / "link.svg", unsupported);
    if (!unsupported) {
        CHECK_FALSE(write_file_atomically(folder.path() / "link.svg", "new"));
        CHECK(fs::is_symlink(folder.path() / "link.svg"));
        CHECK(content_of(file) == "new");
        fs::remove(file);
        CHECK_FALSE(write_file_atomically(folder.path() / "link.svg", rich)); // where it leads nowhere
        CHECK(fs::is_symlink(folder.path() / "link.svg"));
        CHECK(content_of(file) == rich);
        OutputFiles outputs;
        fs::remove(file);
        outputs.add(file).write("one");
        outputs.add(folder.path() / "link.svg").write("two");
        CHECK(outputs.commit());
        CHECK_FALSE(fs::exists(file));
        put(file, rich);
        fs::remove(folder.path() / "link.svg");
    }

    fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
    const auto locked = write_file_atomically(folder.path() / "new.svg", "text");
    fs::permissions(folder.path(), fs::perms::owner_all);
    if (locked) CHECK(folder.count() == 2); // a superuser may write nevertheless
}

TEST_CASE("a written document can be read", "[examples][svg_document][save]") {
    const Folder folder;
    REQUIRE_FALSE(write_file_atomically(folder.path() / "out.svg", rich));
    const auto again = load_svg(folder.path() / "out.svg");
    REQUIRE(again);
    CHECK(to_text(*again) == rich);
}

TEST_CASE("an input file is not overwritten, whatever its path", "[examples][save]") {
    const Folder folder;
    const fs::path input = folder.path() / "in.svg";
    fs::create_directory(folder.path() / "sub");
    put(input, rich);
    std::error_code unsupported;
    fs::create_symlink(input, folder.path() / "link", unsupported);
    fs::create_symlink(folder.path() / "link", folder.path() / "link_of_link", unsupported);
    fs::create_hard_link(input, folder.path() / "hard", unsupported);
    fs::create_directory_symlink(folder.path(), folder.path() / "sub" / "up", unsupported);
    const bool read_first = GENERATE(true, false);
    const std::string read_as = GENERATE("in.svg", "./in.svg", "link", "hard");
    const fs::path path = folder.path() / read_as;
    const std::string name =
        GENERATE("in.svg", "./in.svg", "sub/../in.svg", "link", "link_of_link", "hard", "sub/up/in.svg");
    CAPTURE(read_first, read_as, name);
    if (!fs::exists(path) || !fs::exists(folder.path() / name)) return;
    const std::ptrdiff_t count = folder.count();
    {
        OutputFiles outputs;
        if (read_first) REQUIRE(load_svg(path));
        outputs.add(folder.path() / "other").write("new");
        outputs.add(folder.path() / name).write("new");
        if (!read_first) REQUIRE(load_svg(path));
        CHECK(outputs.error().has_value() == read_first);
        const auto why = outputs.commit();
        REQUIRE(why);
        CHECK(*why == "cannot write " + (folder.path() / name).string() + ": it is the same file as " +
                          path.string() + ", which is read");
    }
    CHECK(content_of(input) == rich);
    CHECK(folder.count() == count);
    // Other files are overwritten, even if the file system has reused the number of a deleted input.
    CHECK_FALSE(write_file_atomically(folder.path() / "copy", rich));
    fs::remove(input);
    fs::remove(folder.path() / "hard");
    put(folder.path() / "late", "old");
    CHECK_FALSE(write_file_atomically(folder.path() / "late", "new"));
}

TEST_CASE("several outputs are written together or not at all", "[examples][save]") {
    const Folder folder;
    const fs::path a = folder.path() / "a", b = folder.path() / "b";
    put(a, "old");
    fs::create_directory(folder.path() / "taken");
    for (const std::string name : {"taken", "no/b", "a", "./a", "taken/../a", "link"}) { // what comes second
        std::error_code unsupported;
        if (name == "link") fs::create_symlink(a, folder.path() / name, unsupported);
        if (unsupported) continue;
        CAPTURE(name);
        {
            OutputFiles outputs;
            outputs.add(a).write("new");
            outputs.add(folder.path() / name).write("second");
            REQUIRE(outputs.error());
            const auto why = outputs.commit();
            REQUIRE(why);
            CHECK(contains(*why, "cannot write " + (folder.path() / name).string()));
            if (name.ends_with("a") || name == "link")
                CHECK(contains(*why, "the same file as " + a.string()));
        }
        CHECK(content_of(a) == "old");
        CHECK(folder.count() == (name == "link" ? 3 : 2));
    }
    {
        OutputFiles outputs; // the same file, not yet created
        outputs.add(b).write("one");
        outputs.add(folder.path() / "taken" / ".." / "b").write("two");
        CHECK(outputs.commit());
    }
    CHECK_FALSE(fs::exists(b));
    OutputFiles outputs;
    outputs.add(a).write("new");
    AtomicFile& second = outputs.add(b);
    second.write("second");
    CHECK_FALSE(outputs.error());
    CHECK_FALSE(second.finish());
    CHECK(content_of(second.temporary()) == "second");
    CHECK(content_of(a) == "old");
    CHECK_FALSE(outputs.commit());
    CHECK(content_of(a) == "new");
    CHECK(content_of(b) == "second");
    CHECK(folder.count() == 4);
}

TEST_CASE("if one output cannot be written the others are restored", "[examples][save]") {
    const Folder folder;
    const fs::path old = folder.path() / "old", fresh = folder.path() / "fresh", bad = folder.path() / "bad";
    for (const std::size_t last : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) { // the one that fails
        CAPTURE(last);
        put(old, "old");
        fs::permissions(old, fs::perms::owner_read);
        const auto time = fs::last_write_time(old);
        std::vector<fs::path> paths{old, fresh};
        paths.insert(paths.begin() + std::ptrdiff_t(last), bad);
        {
            OutputFiles outputs;
            for (const fs::path& path : paths) outputs.add(path).write("new");
            REQUIRE_FALSE(outputs.error());
            fs::create_directory(bad); // after it was checked
            const auto why = outputs.commit();
            REQUIRE(why);
            CHECK(contains(*why, "cannot write " + bad.string()));
            CHECK_FALSE(contains(*why, old.string()));
            CHECK_FALSE(contains(*why, fresh.string()));
        }
        CHECK(content_of(old) == "old");
        CHECK(fs::last_write_time(old) == time);
        CHECK(fs::status(old).permissions() == fs::perms::owner_read);
        CHECK(folder.count() == 2); // outdated and wrong
        fs::remove(bad);
        fs::remove(old);
    }
}

TEST_CASE("documents too deep or too large are refused", "[examples][svg_document][robust]") {
    const auto nested = [](std::size_t depth) {
        std::string text = "<svg>";
        for (std::size_t i = 0; i < depth; ++i) text += "<g transform='translate(1)'>";
        text += "<path d='M0 0L1 1'/>";
        for (std::size_t i = 0; i < depth; ++i) text += "</g>";
        return text + "</svg>";
    };
    CHECK(shapes_of(nested(900))[0].path[0].start == Point2{900, 0});
    CHECK(deformed(nested(900), shift).report.shapes == 1);
    for (const std::size_t depth : {std::size_t{1001}, std::size_t{100'000}}) {
        const auto document = parse_svg(nested(depth), "deep.svg");
        REQUIRE_FALSE(document);
        CHECK(contains(to_string(document.error()), "nested too deeply"));
    }
    // each document is not deep, but its expansion is
    std::string chain = "<svg><defs><path id='u0' d='M0 0L1 1'/>";
    for (int i = 1; i < 600; ++i) {
        chain += "<g id='u" + std::to_string(i) + "'><use href='#u" + std::to_string(i - 1) + "'/></g>";
    }
    CHECK(contains(error_of(chain + "</defs><use href='#u599'/></svg>"), "nested too deeply"));

    std::string long_path = "M0 0";
    for (int i = 0; i < 20'000; ++i) long_path += "h1v1";
    const Result result = deformed(svg("<path d='" + long_path + "'/>"), shift);
    CHECK(result.report.segments == 40'000);

    // Where rounding errors exceed the tolerance more subdivision does not help.
    const Result far = deformed(svg("<path d='M1 2A1 2 3 0 1 9 1e9z'/>"), wave, {.tolerance = 1e-9});
    CHECK(far.report.coarse > 0);
    CHECK(far.report.points < 20'000);
}

TEST_CASE("mutated documents do not crash the program", "[examples][svg_document][fuzz]") {
    const unsigned seed = 11;
    CAPTURE(seed);
    std::mt19937 random(seed);
    const std::vector<std::string> pieces = {"<g>",
                                             "</g>",
                                             "<use href=\"#all\"/>",
                                             "<use href=\"#leaf\" x=\"1e300\"/>",
                                             "clip-path=\"url(#window)\"",
                                             " transform=\"scale(1e-200)\"",
                                             " transform=\"rotate(9)\"",
                                             "\"",
                                             "<",
                                             "&",
                                             "1e308",
                                             "<!--",
                                             "]]>",
                                             "%",
                                             "NaN",
                                             "<svg viewBox=\"0 0 1e-300 1\">",
                                             "<rect width=\"9\" height=\"1e99\"/>",
                                             "<style>rect{",
                                             "id=\"leaf\"",
                                             "-",
                                             "0"};
    std::size_t loaded = 0;
    std::size_t succeeded = 0;
    for (int i = 0; i < 2500; ++i) {
        std::string text = rich;
        const std::size_t changes = 1 + random() % 4;
        for (std::size_t k = 0; k < changes; ++k) {
            const std::size_t at = random() % text.size();
            switch (random() % 4) {
            case 0: text[at] = static_cast<char>(random() % 256); break;
            case 1: text.erase(at, 1 + random() % 20); break;
            default: text.insert(at, pieces[random() % pieces.size()]); break;
            }
        }
        auto document = parse_svg(text, "mutated.svg");
        if (!document) continue;
        ++loaded;
        (void)static_cast<bool>(first_polygon(*document));
        (void)static_cast<bool>(first_outline(*document));
        (void)static_cast<bool>(figure_vertices(*document));
        const auto report = deform(*document, wave, {.max_halvings = 2});
        if (!report) continue;
        ++succeeded;
        const std::string written = to_text(*document);
        INFO(text << "\n----\n" << written);
        auto again = parse_svg(written, "again.svg");
        REQUIRE(again);
        REQUIRE(to_text(*again) == written);
        std::vector<std::string> ignored; // the unreadable part, which did not move
        REQUIRE(detail::drawn_shapes(*again, ignored));
    }
    CHECK(loaded > 300); // otherwise only the XML parser is tested
    CHECK(succeeded > 150);
}

} // namespace svg_document_tests
