// PLY files and other files of points: any encoding and block size; broken files are reported.
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/temporary_file.hpp"

#include "files/ply_file.hpp"
#include "files/point_file.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>

namespace ply_file_tests {

using namespace cageform_support;
using cageform_tests::Random;
using cageform_tests::TemporaryFile;

namespace {

constexpr std::array type_names{"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
constexpr std::array new_names{"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};

template <class X>
void append_number(std::string& text, double number, PlyEncoding encoding) {
    auto bytes = std::bit_cast<std::array<char, sizeof(X)>>(X(number));
    if ((encoding == PlyEncoding::big_endian) == (std::endian::native == std::endian::little))
        std::reverse(bytes.begin(), bytes.end());
    text.append(bytes.data(), bytes.size());
}

void append(std::string& text, PlyType type, double number, PlyEncoding encoding) {
    if (encoding == PlyEncoding::ascii) {
        std::array<char, 40> digits{};
        (void)std::snprintf(digits.data(), digits.size(), "%.17g ", number);
        text += digits.data();
        return;
    }
    switch (type) {
    case PlyType::int8: return append_number<std::int8_t>(text, number, encoding);
    case PlyType::uint8: return append_number<std::uint8_t>(text, number, encoding);
    case PlyType::int16: return append_number<std::int16_t>(text, number, encoding);
    case PlyType::uint16: return append_number<std::uint16_t>(text, number, encoding);
    case PlyType::int32: return append_number<std::int32_t>(text, number, encoding);
    case PlyType::uint32: return append_number<std::uint32_t>(text, number, encoding);
    case PlyType::float32: return append_number<float>(text, number, encoding);
    case PlyType::float64: return append_number<double>(text, number, encoding);
    }
}

/// A random number of a type, including its limits.
double number_of(Random& random, PlyType type) {
    const std::size_t bits = 8 * bytes_of(type);
    if (type == PlyType::float32) return double(float(random.uniform(-1e6, 1e6)));
    if (type == PlyType::float64) return random.uniform(-1e12, 1e12);
    const bool is_signed = std::size_t(type) % 2 == 0;
    const double least = is_signed ? -std::ldexp(1.0, int(bits) - 1) : 0;
    const double most = std::ldexp(1.0, int(bits) - (is_signed ? 1 : 0)) - 1;
    const auto choice = random.below(8);
    return choice == 0 ? least : choice == 1 ? most : std::floor(random.uniform(least, most));
}

/// A file with elements of random properties, and the expected result of reading them.
struct RandomFile {
    std::string text;
    std::vector<PlyElement> elements;
    std::vector<std::vector<std::vector<std::vector<double>>>> numbers; // by element, record and property

    explicit RandomFile(Random& random) {
        const auto encoding = PlyEncoding(random.below(3));
        constexpr std::array encodings{"ascii", "binary_little_endian", "binary_big_endian"};
        text = std::string("ply\nformat ") + encodings[std::size_t(encoding)] + " 1.0\ncomment by a test\n";
        const std::size_t count = 1 + random.below(3);
        for (std::size_t e = 0; e < count; ++e) {
            PlyElement element;
            element.name = "element_" + std::to_string(e);
            element.count = random.below(40);
            text += "element " + element.name + ' ' + std::to_string(element.count) + '\n';
            const std::size_t properties = 1 + random.below(6);
            for (std::size_t p = 0; p < properties; ++p) {
                PlyProperty property{"p" + std::to_string(p), PlyType(random.below(8)), {}};
                const auto name = [&](PlyType type) {
                    return std::string(random.below(2) == 0 ? type_names[std::size_t(type)]
                                                            : new_names[std::size_t(type)]);
                };
                if (random.below(4) == 0) property.count = PlyType(random.below(6));
                text += "property " +
                        (property.count ? "list " + name(*property.count) + ' ' : std::string()) +
                        name(property.type) + ' ' + property.name + '\n';
                element.properties.push_back(property);
            }
            elements.push_back(element);
        }
        text += "end_header\n";
        for (const PlyElement& element : elements) {
            auto& records = numbers.emplace_back();
            for (std::uint64_t n = 0; n < element.count; ++n) {
                auto& record = records.emplace_back();
                for (const PlyProperty& property : element.properties) {
                    auto& all = record.emplace_back();
                    const std::size_t values = property.count ? random.below(5) : 1;
                    if (property.count) {
                        all.push_back(double(values));
                        append(text, *property.count, double(values), encoding);
                    }
                    for (std::size_t k = 0; k < values; ++k) {
                        all.push_back(number_of(random, property.type));
                        append(text, property.type, all.back(), encoding);
                    }
                }
                if (encoding == PlyEncoding::ascii) text += random.below(3) == 0 ? "\r\n" : "\n";
            }
        }
    }
};

/// Why a text is not a PLY file with points, without the file's name; empty if it is one.
std::string fault_of(const std::string& text, const std::string& name = "test.ply") {
    const TemporaryFile file(text, name);
    PointFile points(file.path);
    std::vector<double> numbers;
    while (points.read(7, numbers) > 0) continue;
    if (points.error().empty()) return {};
    CHECK(points.error().starts_with(file.path + ": "));
    return points.error().substr(std::min(points.error().size(), file.path.size() + 2));
}

const std::string xyz = "property float x\nproperty float y\nproperty float z\n";

} // namespace

TEST_CASE("PLY files of any layout are read in blocks of any size", "[examples][ply]") {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const RandomFile made(random);
        const TemporaryFile file(made.text, "test.ply");
        PlyReader reader(file.path);
        REQUIRE(reader.error() == "");
        CHECK(reader.header().comments == std::vector<std::string>{"by a test"});
        REQUIRE(reader.header().elements.size() == made.elements.size());
        for (std::size_t e = 0; e < made.elements.size(); ++e) {
            if (random.below(3) == 0) continue; // this one is skipped
            std::vector<std::size_t> chosen;
            std::vector<std::string> names;
            for (std::size_t n = random.below(5); n > 0; --n) {
                chosen.push_back(random.below(made.elements[e].properties.size()));
                names.push_back("p" + std::to_string(chosen.back()));
            }
            REQUIRE(reader.begin(made.elements[e].name, names));
            std::vector<double> expected, found;
            for (const auto& record : made.numbers[e]) {
                for (const std::size_t p : chosen)
                    expected.insert(expected.end(), record[p].begin(), record[p].end());
            }
            std::uint64_t records = 0;
            while (const std::size_t more = reader.read(1 + random.below(9), found)) records += more;
            CHECK(reader.error().empty());
            CHECK(records == made.elements[e].count);
            CHECK(found == expected);
        }
        CHECK(reader.hash_to_end() == cageform::hash_memory(std::span<const char>(made.text)));
    }
}

TEST_CASE("truncated or corrupted PLY files are read or refused", "[examples][ply]") {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        RandomFile made(random);
        const bool cuts = random.below(2) == 0;
        if (cuts) {
            made.text.resize(random.below(made.text.size()));
        } else {
            for (int n = 0; n < 3; ++n) made.text[random.below(made.text.size())] = char(random.below(256));
        }
        const TemporaryFile file(made.text, "test.ply");
        PlyReader reader(file.path);
        std::uint64_t records = 0, expected = 0;
        for (const auto& element : made.elements) {
            expected += element.count;
            if (!reader.begin(element.name, {"p0"})) break;
            std::vector<double> numbers;
            while (const std::size_t more = reader.read(5, numbers)) records += more;
        }
        if (!reader.error().empty()) CHECK(reader.error().starts_with(file.path + ": "));
        // Spaces and the last line break may be missing at the end of an ASCII file.
        if (cuts) CHECK((!reader.error().empty() || records == expected));
    }
}

TEST_CASE("faults of a PLY file are reported", "[examples][ply]") {
    const std::string ascii = "ply\nformat ascii 1.0\n", binary = "ply\nformat binary_little_endian 1.0\n";
    CHECK(fault_of(ascii + "element vertex 1\n" + xyz + "end_header\n1 2 3\n").empty());
    CHECK(fault_of(
              "ply\r\nformat ascii 1.0\r\nelement vertex 1\r\nproperty float x\r\nproperty int y\r\nproperty "
              "uchar z\r\nend_header\r\n1 2 3")
              .empty());
    CHECK(fault_of(binary + "element vertex 0\n" + xyz + "end_header\n").empty());
    CHECK(fault_of("") == "is no PLY file: it does not begin with \"ply\"");
    CHECK(fault_of("plywood") == "is no PLY file: it does not begin with \"ply\"");
    CHECK(fault_of("ply\n") == "its header has no line \"end_header\"");
    CHECK(fault_of("ply\nend_header\n") == "its header has no line \"format\"");
    CHECK(fault_of("ply\nformat octal 1.0\nend_header\n") ==
          "line 2: the format is none of ascii, binary_little_endian, binary_big_endian");
    CHECK(fault_of(ascii + "vertex 3\n") == "line 3: \"vertex\" is not a keyword of a PLY file's header");
    CHECK(fault_of(ascii + "element vertex\n") ==
          "line 3: \"element vertex\" does not declare a new element and its number of records");
    CHECK(fault_of(ascii + "element vertex -1\n").starts_with("line 3: "));
    CHECK(fault_of(ascii + "element vertex 99999999999999999999\n").starts_with("line 3: "));
    CHECK(fault_of(ascii + "property float x\n") ==
          "line 3: \"property float x\" does not declare a property of an element");
    CHECK(fault_of(ascii + "element vertex 1\nproperty half x\n") ==
          "line 4: \"property half x\" has a type that PLY files do not have");
    CHECK(fault_of(ascii + "element vertex 1\nproperty list float int x\n").starts_with("line 4: "));
    CHECK(fault_of(ascii + "element vertex 1\n" + xyz + "property float x\n").starts_with("line 7: "));
    CHECK(fault_of(ascii + "element face 1\nproperty float x\nend_header\n1\n") == "has no element vertex");
    CHECK(fault_of(ascii + "element vertex 1\nproperty float x\nproperty float z\nend_header\n1 2\n") ==
          "its element vertex has no property y");
    CHECK(fault_of(ascii + "element vertex 2\n" + xyz + "end_header\n1 2 3\n") == "is cut off in vertex 1");
    CHECK(fault_of(ascii + "element vertex 1\n" + xyz + "end_header\n1 2\n") ==
          "line 8: too few numbers for vertex 0");
    CHECK(fault_of(ascii + "element vertex 1\n" + xyz + "end_header\n1 2 3 4\n") ==
          "line 8: too many numbers for vertex 0");
    CHECK(fault_of(ascii + "element vertex 1\n" + xyz + "end_header\n1 two 3\n").starts_with("line 8: "));
    CHECK(fault_of(binary + "element vertex 2\n" + xyz + "end_header\n" + std::string(23, '\0')) ==
          "is cut off: it is too short for the 2 records of its element vertex");
    CHECK(fault_of(binary + "element vertex 200000000000\n" + xyz + "end_header\n" + std::string(24, '\0')) ==
          "is cut off: it is too short for the 200000000000 records of its element vertex");
    CHECK(fault_of(binary + "element face 1\nproperty list char int i\nelement vertex 0\n" + xyz +
                   "end_header\n\xff") == "face 0: the list i has a negative length");
    CHECK(fault_of(binary + "element face 1\nproperty list uint int i\nelement vertex 0\n" + xyz +
                   "end_header\n" + std::string(40, '\xff')) == "is cut off in face 0");
    PlyReader none("no_such_file.ply"), folder(".");
    CHECK(none.error() == "no_such_file.ply: no such file");
    CHECK(folder.error() == ".: is a folder");
    CHECK(!none.may_retry());
}

TEST_CASE("points are read from OBJ files and numpy arrays", "[examples][ply][points]") {
    const auto points_of = [](const std::string& text, const std::string& path) {
        const TemporaryFile file(text, path);
        PointFile points(file.path);
        std::vector<double> numbers;
        while (points.read(2, numbers) > 0) continue;
        CHECK(points.error().empty());
        CHECK(points.hash_to_end() == cageform::hash_memory(std::span<const char>(text)));
        return numbers;
    };
    CHECK(points_of("# a comment\nv 1 2 3\r\nvn 0 0 1\n  v\t4  5 6 0.5\nf 1 2 3\nv 7 8 9",
                    "points_test.obj") == std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9});
    CHECK(points_of("o nothing", "points_test.obj").empty());
    CHECK(fault_of("", "points_test.obj") == "is empty");
    CHECK(fault_of("v 1 2\n", "points_test.obj").starts_with("line 1: "));
    CHECK(fault_of("v 1 2 3\nv 1 x 2\n", "points_test.obj").starts_with("line 2: "));
    CHECK(fault_of(std::string("\0\n", 2), "points_test.obj") ==
          "line 1: is no text, so this is no OBJ file");

    const auto array = [](const std::string& type, const std::string& shape, const auto& numbers) {
        std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }";
        header.resize(117, ' ');
        header += '\n';
        std::string text = "\x93NUMPY\x01" + std::string(1, '\0') + char(118) + std::string(1, '\0') + header;
        text.append(reinterpret_cast<const char*>(numbers.data()), sizeof(numbers));
        return text;
    };
    const std::array<float, 9> singles{1, 2, 3, 4, 5, 6, 7, 8, 9};
    const std::array<double, 6> doubles{1, 2, 3, 4, 5, 0.1};
    CHECK(points_of(array("<f4", "(3, 3)", singles), "points_test.npy") ==
          std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9});
    CHECK(points_of(array("<f8", "(2, 3)", doubles), "points_test.npy") ==
          std::vector<double>{1, 2, 3, 4, 5, 0.1});
    CHECK(points_of(array("<f4", "(0, 3)", singles), "points_test.npy").empty());
    CHECK(fault_of(array("<f4", "(4, 3)", singles), "points_test.npy") ==
          "is cut off: it is too short for its 4 points");
    for (const char* const shape : {"(3, 4)", "(9,)", "(3, 3, 1)", "(-1, 3)", "(99999999999999999999, 3)"})
        CHECK(fault_of(array("<f4", shape, singles), "points_test.npy").starts_with("is no array of N x 3"));
    CHECK(fault_of(array("<i4", "(3, 3)", singles), "points_test.npy").starts_with("is no array of N x 3"));
    CHECK(fault_of("", "points_test.npy") == "is no .npy file");
    CHECK(fault_of("\x93NUMPY\x02" + std::string(5, '\xff'), "points_test.npy") ==
          "is cut off in its header");
}

} // namespace ply_file_tests
