#include "io/messages.hpp"

#include "catch.hpp"

#include <cstddef>
#include <random>
#include <string>

namespace guard_tests {

using namespace cageform_support;

namespace {

/// Whether a text is UTF-8 without control characters, except tabs and line breaks followed by two spaces.
bool is_plain(const std::string& text) {
    for (std::size_t at = 0; at < text.size();) {
        const auto byte = [&](std::size_t k) {
            return at + k < text.size() ? unsigned(text[at + k]) & 0xff : 0;
        };
        const std::size_t count = byte(0) < 0x80 ? 1 : byte(0) < 0xe0 ? 2 : byte(0) < 0xf0 ? 3 : 4;
        if (count == 1 && byte(0) != '\t' && (byte(0) < 0x20 || byte(0) == 0x7f) &&
            text.compare(at, 3, "\n  ") != 0)
            return false;
        if (count > 1 && (byte(0) < 0xc2 || byte(0) > 0xf4)) return false;
        for (std::size_t k = 1; k < count; ++k) {
            if (byte(k) < 0x80 || byte(k) > 0xbf) return false;
        }
        if (byte(0) == 0xc2 && byte(1) < 0xa0) return false;
        if (byte(0) == 0xe0 && byte(1) < 0xa0) return false;
        if (byte(0) == 0xed && byte(1) > 0x9f) return false;
        if (byte(0) == 0xf0 && byte(1) < 0x90) return false;
        if (byte(0) == 0xf4 && byte(1) > 0x8f) return false;
        at += count;
    }
    return true;
}

} // namespace

TEST_CASE("plain text is printed unchanged", "[examples][guard]") {
    for (const std::string text : {"", "cat.svg", "a \"b\" \\x1b",
                                   "K\xc3\xa4"
                                   "fig \xe2\x88\x91 \xf0\x9f\x90\x88",
                                   "1\t2", "the cage:\n  vertex 3\n  and 2 more"}) {
        CAPTURE(text);
        CHECK(is_plain(text));
        CHECK(printable(text) == text);
    }
}

TEST_CASE("control characters and invalid UTF-8 are printed as numbers", "[examples][guard]") {
    CHECK(printable("\x1b[31mred") == "\\x1b[31mred");
    CHECK(printable("a\nb\r\x7f\x08") == "a\\x0ab\\x0d\\x7f\\x08");
    CHECK(printable(std::string("\0", 1)) == "\\x00");
    CHECK(printable("\xc2\x9b"
                    "1m") == "\\xc2\\x9b1m"); // a control of eight bits
    CHECK(printable("\xff.svg") == "\\xff.svg");
    CHECK(printable("\xc0\x9b") == "\\xc0\\x9b");                   // longer than need be
    CHECK(printable("\xed\xa0\x80") == "\\xed\\xa0\\x80");          // half a pair
    CHECK(printable("\xf4\x90\x80\x80") == "\\xf4\\x90\\x80\\x80"); // beyond Unicode
    CHECK(printable("\xef\xbf\xbf") == "\\xef\\xbf\\xbf");          // no character
    CHECK(printable("\xe2\x88") == "\\xe2\\x88");                   // cut off
}

TEST_CASE("printed text is always plain, and plain text is unchanged", "[examples][guard][property]") {
    const unsigned seed = GENERATE(range(0U, 20U));
    CAPTURE(seed);
    std::mt19937 random(seed);
    // Bytes near the limits of UTF-8 are chosen often.
    const std::string borders = "\x1b\n  \t\x7f\x80\x8f\x90\x9f\xa0\xbf\xc0\xc2\xe0\xed\xef\xf0\xf4\xf8";
    for (int n = 0; n < 2000; ++n) {
        std::string text(random() % 8, ' ');
        for (char& c : text)
            c = random() % 4 == 0 ? char(random() % 256) : borders[random() % borders.size()];
        const std::string shown = printable(text);
        CAPTURE(n);
        CHECK(is_plain(shown));
        CHECK(printable(shown) == shown);
        if (is_plain(text) && text.find("\xef\xbf") == text.npos) CHECK(shown == text);
    }
}

} // namespace guard_tests
