// Feeds text to the reader and the deformation of SVG documents, and what they wrote to the reader again:
// for libFuzzer.
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 -Iexamples/support tests/fuzz/svg.cpp examples/support/svg/*.cpp
//             examples/support/{cli/guard,files/{input_file,atomic_file},pictures/render}.cpp -lpugixml -lz
//             -o fuzz_svg
//     mkdir corpus && ./fuzz_svg -max_len=4096 -timeout=60 corpus examples/data
#include "svg/document.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using namespace cageform_support;

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "line %d: %s\n", __LINE__, #condition);                                         \
        std::abort();                                                                                        \
    }

/// Pieces of SVG, which a mutation inserts.
constexpr std::array pieces{
    R"x(<svg viewBox="0 0 9 9">)x",
    R"x(<svg x="1" width="5%" height="2" viewBox="0 0 3 4" overflow="visible">)x",
    "</svg>",
    R"x(<g id="a" transform="scale(2)rotate(9)">)x",
    R"x(<g filter="url(#f)" mask="url(#m)">)x",
    "</g>",
    R"x(<use href="#a" x="1"/>)x",
    R"x(<use xlink:href="#s" width="9"/>)x",
    R"x(<symbol id="s" viewBox="0 0 2 1">)x",
    "</symbol>",
    R"x(<rect id="b" x="1" width="3" height="2e1" rx="1" fill="url(#l)"/>)x",
    R"x(<circle r="4" stroke="url(#r) red"/>)x",
    R"x(<path id="a" d="M1 2C1 2 3 4 5 6A1 2 3 0 1 9 9z"/>)x",
    R"x(<polyline points="0,0 1e99,1 2,3" marker-mid="url(#k)"/>)x",
    R"x(<line x2="0"/>)x",
    R"x(<linearGradient id="l" href="#r" gradientUnits="userSpaceOnUse" x2="10%"><stop offset="0"/></linearGradient>)x",
    R"x(<radialGradient id="r" gradientTransform="matrix(1 2 3 4 5 6)" xlink:href="#l"/>)x",
    R"x(<pattern id="l" width=".1" height="20%" patternContentUnits="objectBoundingBox"><rect fill="url(#l)"/></pattern>)x",
    R"x(<clipPath id="c" clipPathUnits="objectBoundingBox"><use href="#b"/><rect width="1" height="1"/></clipPath>)x",
    R"x(<clipPath id="c" clip-path="url(#d)"><text>x</text><path d="M0 0L1 1V9"/></clipPath>)x",
    R"x(<mask id="m" maskUnits="userSpaceOnUse" x="1"><g fill="url(#r)"><circle r="1" mask="url(#m)"/></g></mask>)x",
    R"x(<filter id="f" x="-1e9" width="3"><feOffset/></filter>)x",
    R"x( clip-path="url(#c)")x",
    R"x( style="fill:url('#l');stroke-width:3;clip-path:url(#c)!important")x",
    R"x( class="k l")x",
    R"x( id="c")x",
    R"x( transform="scale(0)")x",
    R"x( transform="scale(1e-200)")x",
    R"x( transform="translate(1e300)")x",
    R"x( display="none")x",
    R"x( xmlns:xlink="x")x",
    R"x(<text x="1 2" y="3" font-size="9" text-anchor="end">ab<tspan x="3">c</tspan></text>)x",
    R"x(<image width="9" height="4"/>)x",
    R"x(<text font-size="2"><textPath href="#a" startOffset="20%">on it</textPath></text>)x",
    R"x(<switch><foreignObject requiredExtensions="e" width="1" height="1"/>)x",
    R"x(<feSpotLight x="1" pointsAtY="9"/>)x",
    R"x(<foreignObject width="1%" height="1"/>)x",
    "<style>",
    "</style>",
    ".k{fill:url(#l)}",
    "g > .k, * #a rect{stroke:url(#r)!important;display:inline}",
    "rect ~ :not(.k, g + [width^='3' i]):nth-last-of-type(-2n + 3):hover{fill:red;transform:rotate(9deg)}",
    "*{x:1em;rx:20%;d:path('M1 2h3');transform-origin:right 3px;scale:2;--own:url(#a)}",
    "@media print{rect{translate:3px}}@supports(a){}",
    R"x( style="width:calc(2px*(1 + 3%))")x",
    R"x( style="transform:skew(9deg,.1turn)translate3d(1px,2%,0);transform-box:fill-box;transform-origin:top")x",
    R"x( clip-path="inset(10% 1px round 3px / 20%) fill-box")x",
    R"x( style="clip-path:polygon(evenodd,0 0,100% 1em,50% 9px)")x",
    R"x( fill="context-stroke" stroke="context-fill")x",
    R"x(<!DOCTYPE svg [<!ENTITY e "<g>&f;</g>"><!ENTITY f '<rect width="3" height="&h;"/>'><!ENTITY h "2">]>)x",
    "&e;",
    "&h;",
    R"x( xmlns="http://www.w3.org/2000/svg" xmlns:s="http://www.w3.org/2000/svg")x",
    R"x(<s:g><rect width="3" height="4"/></s:g>)x",
    "@media print{",
    "/*",
    "*/",
    "<![CDATA[",
    "]]>",
    "<!--",
    "-->",
    "&quot;",
    "&#x3b;",
    "&amp;",
    "url(#",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "none",
    "inherit",
    "100%",
    "\"",
    "'",
    ";",
    "{",
    "}",
    "(",
    ")",
    "<",
    ">",
    "/>",
    "#"};

bool wave(std::span<const Point2> in, std::span<Point2> out) {
    for (std::size_t i = 0; i < in.size(); ++i) {
        const Point2& p = in[i];
        out[i] = {p.x + (std::abs(p.y) < 1e3 ? std::cos(p.y) : 0),
                  2 * p.y + (std::abs(p.x) < 1e3 ? std::sin(p.x) : 0)};
    }
    return true;
}

/// At rest, waved, and twice as far.
bool three_frames(std::span<const Point2> in, std::span<const PointRole>, std::span<Point2> out) {
    std::copy(in.begin(), in.end(), out.begin());
    (void)wave(in, out.subspan(in.size(), in.size()));
    return wave(out.subspan(in.size(), in.size()), out.subspan(2 * in.size()));
}

bool rest(std::span<const Point2> in, std::span<Point2> out) {
    std::copy(in.begin(), in.end(), out.begin());
    return true;
}

} // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
    std::minstd_rand random(seed);
    if (random() % 3 == 0) return LLVMFuzzerMutate(data, size, max_size);
    std::string text(reinterpret_cast<const char*>(data), size);
    for (std::size_t k = 1 + random() % 3; k > 0; --k) {
        std::size_t at = random() % (text.size() + 1);
        if (random() % 2 == 0) at = std::min(text.find_first_of("<> ", at), text.size());
        if (random() % 8 == 0) {
            text.erase(at, 1 + random() % 20);
        } else if (random() % 8 == 0) {
            text.insert(at, text.substr(random() % (text.size() + 1), random() % 200));
        } else {
            text.insert(at, pieces[random() % pieces.size()]);
        }
    }
    size = std::min(text.size(), max_size);
    std::memcpy(data, text.data(), size);
    return size;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static std::size_t written = 0, runs = 0;
    if (++runs % 100'000 == 0) std::fprintf(stderr, "%zu of %zu were deformed\n", written, runs);
    auto document = parse_svg({reinterpret_cast<const char*>(data), size}, "fuzz.svg");
    if (!document) {
        REQUIRE(!document.error().message.empty());
        return 0;
    }
    (void)static_cast<bool>(first_polygon(*document));
    (void)static_cast<bool>(figure_vertices(*document));
    const std::string before = to_text(*document);
    const auto still = deform(*document, rest, {.max_halvings = 2});
    REQUIRE(to_text(*document) == before); // what does not move stays
    const auto report = deform(*document, wave, {.max_halvings = 2, .fit = size % 2 == 0});
    REQUIRE(!report || still);
    const auto untouched = parse_svg(before, "frames.svg");
    REQUIRE(untouched);
    auto frames = animate(*untouched, three_frames, 3, {.max_halvings = 1, .fit = size % 2 == 0});
    REQUIRE(!frames || still);
    for (std::size_t f = 0; frames && f < 3; ++f) {
        frames->show(f);
        const std::string text = to_text(frames->document);
        REQUIRE(parse_svg(text, "frame.svg"));
    }
    if (frames) {
        frames->play(1, 0.01);
        REQUIRE(parse_svg(to_text(frames->document), "played.svg"));
    }
    if (!report) {
        REQUIRE(to_text(*document) == before);
        return 0;
    }
    ++written;
    const std::string text = to_text(*document);
    auto again = parse_svg(text, "again.svg");
    REQUIRE(again);
    const std::string twice = to_text(*again); // pugixml writes an empty doctype in two ways
    const auto third = parse_svg(twice, "third.svg");
    REQUIRE(third);
    REQUIRE(to_text(*third) == twice);
    REQUIRE(deform(*again, wave, {.max_halvings = 2}));
    return 0;
}
