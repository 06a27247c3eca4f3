#include "splats/splat_file.hpp"

#include "files/ply_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"
#include "splats/harmonics.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <tuple>
#include <utility>

namespace cageform_support {

static_assert(std::endian::native == std::endian::little, "rows have the byte order of the file");

namespace {

constexpr std::size_t number_bytes = sizeof(float);

struct Property {
    std::size_t offset = 0;
    bool is_float = false;
};

/// The parsed header: the scene without rows, and the properties of splats by name.
struct Header : PlyHeader {
    SplatFile scene;
    std::map<std::string, Property, std::less<>> properties;
    std::size_t splats = 0; // index of the element of splats
};

/// Parses the header and removes it from `bytes`.
Expected<Header> read_header(std::string_view& bytes, const std::string& name) {
    const auto fails = [&](const std::string& why) { return FileError{name + ": " + why}; };
    std::string_view line;
    const auto next = [&] {
        if (bytes.find('\n') == bytes.npos || !take_line(bytes, line)) return false;
        if (line.ends_with('\r')) line.remove_suffix(1);
        return true;
    };
    if (!next() || line != "ply") return fails("is no PLY file: it does not begin with ply");
    Header header;
    SplatFile& scene = header.scene;
    for (std::size_t number = 2; next() && !is_end_of_ply_header(line); ++number) {
        const auto words = ply_words(line);
        if (const std::string why = parse_ply_line(line, header); !why.empty())
            return fails("line " + std::to_string(number) + ": " + why);
        if (words.size() > 1 && words[0] == "element" && words[1] == "vertex")
            scene.element_at = scene.header.size();
        else if (!words.empty() && words[0] != "format")
            scene.header.emplace_back(line);
    }
    if (!is_end_of_ply_header(line)) return fails("the header is cut off: it has no end_header");
    const PlyElement* const splats = header.find("vertex");
    if (!header.encoding || splats == nullptr)
        return fails(std::string("the header has no line ") +
                     (header.encoding ? "element vertex" : "format"));
    if (header.encoding != PlyEncoding::little_endian)
        return fails("the format is not binary_little_endian: convert it");
    header.splats = std::size_t(splats - header.elements.data());
    for (const PlyProperty& property : splats->properties) {
        if (property.count)
            return fails("the property " + property.name + " is a list: a splat has single numbers");
        header.properties[property.name] = {scene.layout.row_bytes, property.type == PlyType::float32};
        scene.layout.row_bytes += bytes_of(property.type);
    }
    return header;
}

/// Whether find_numbers() uses a property.
bool is_of_splat(std::string_view property) {
    constexpr std::string_view names[] = {"x",       "y",     "z",       "nx",     "ny",  "nz",
                                          "opacity", "f_dc_", "f_rest_", "scale_", "rot_"};
    return std::any_of(std::begin(names), std::end(names), [&](std::string_view name) {
        return property == name || (name.ends_with('_') && property.starts_with(name) &&
                                    property.find_first_not_of("0123456789", name.size()) == property.npos);
    });
}

/// Finds the offsets of the numbers of a splat. Returns the error; empty on success.
std::string find_numbers(Header& header) {
    if (header.properties.contains("packed_position"))
        return "is a compressed PLY of SuperSplat: export it as an uncompressed PLY";
    SplatLayout& layout = header.scene.layout;
    std::string why;
    const auto find = [&](const std::string& property) -> std::size_t {
        const auto found = header.properties.find(property);
        if (found == header.properties.end()) {
            if (why.empty()) why = "a splat has no property " + property;
            return 0;
        }
        if (!found->second.is_float && why.empty()) why = "the property " + property + " is not a float";
        return found->second.offset;
    };
    const auto find_all = [&](const std::string& prefix, auto& offsets) {
        for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = find(prefix + std::to_string(i));
    };
    layout.place = {find("x"), find("y"), find("z")};
    find_all("f_dc_", layout.colour);
    layout.opacity = find("opacity");
    find_all("scale_", layout.scales);
    find_all("rot_", layout.rotation);
    std::size_t rest = 0;
    for (const auto& property : header.properties) rest += property.first.starts_with("f_rest_") ? 1 : 0;
    if (why.empty() && rest != 0 && rest != 9 && rest != 24 && rest != 45)
        why = std::to_string(rest) + " properties f_rest_: degrees 0 to 3 have 0, 9, 24 or 45";
    layout.rest.resize(rest);
    find_all("f_rest_", layout.rest);
    if (header.properties.contains("nx") && header.properties.contains("ny") &&
        header.properties.contains("nz"))
        layout.normal = {find("nx"), find("ny"), find("nz")};
    return why;
}

/// The name of the property at an offset.
std::string name_at(const Header& header, std::size_t offset) {
    for (const auto& [name, property] : header.properties) {
        if (property.offset == offset) return name;
    }
    return {};
}

/// Offsets of all numbers that a pose may change, ascending.
std::vector<std::size_t> offsets_of(const SplatLayout& layout) {
    std::vector<std::size_t> offsets{layout.opacity};
    for (const auto& some : {std::span<const std::size_t>(layout.place),
                             {layout.colour},
                             {layout.scales},
                             {layout.rotation},
                             {layout.rest},
                             {layout.normal}})
        offsets.insert(offsets.end(), some.begin(), some.end());
    std::sort(offsets.begin(), offsets.end());
    return offsets;
}

/// Lists the properties and elements that no pose changes, for SplatFile::others.
std::string others_of(const Header& header) {
    const auto offsets = offsets_of(header.scene.layout);
    std::string text;
    const auto add = [&](const std::string& one) { (text += text.empty() ? "" : ", ") += one; };
    for (const auto& [name, property] : header.properties) {
        if (!std::binary_search(offsets.begin(), offsets.end(), property.offset)) add(detail::quoted(name));
    }
    for (const PlyElement& element : header.elements) {
        if (element.name != "vertex")
            add(std::to_string(element.count) + " of " + detail::quoted(element.name));
    }
    return text;
}

/// Splats with invalid numbers.
struct NumberFaults {
    std::vector<std::size_t> splats; // ascending
    std::string first;               // "splat 3 (counted from 0): x is not a finite number"
};

constexpr double largest_scale = 88; // its exponential is finite in single precision

double farthest_coordinate(const Point3& p) {
    return std::max({std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])});
}

/// The box around the splats that single precision resolves: up to 1e7 times the median distance from the
/// median position along each axis. The medians are those of a sample of at most 1000 splats.
struct NearPlaces {
    explicit NearPlaces(const SplatFile& scene) {
        const std::size_t step = scene.size() / 1000 + 1;
        std::vector<double> numbers;
        const auto median = [&](const auto& number_of) {
            numbers.clear();
            for (std::size_t i = 0; i < scene.size(); i += step) {
                if (const Point3 place = scene.place(i); cageform::is_finite(place))
                    numbers.push_back(number_of(place));
            }
            const auto half = numbers.begin() + std::ptrdiff_t(numbers.size() / 2);
            std::nth_element(numbers.begin(), half, numbers.end());
            return numbers.empty() ? 0.0 : *half;
        };
        for (std::size_t k = 0; k < 3; ++k) middle[k] = median([&](const Point3& place) { return place[k]; });
        const double size = median([&](const Point3& place) { return farthest_coordinate(place - middle); });
        if (size > 0) reach = 1e7 * size;
    }

    Point3 middle;
    double reach = HUGE_VAL; // along each axis
};

/// Returns the error if a number of a splat is invalid; else empty. Infinite opacities (opaque, transparent)
/// and scales of -inf (flat) are valid.
std::string fault_of(const SplatLayout& layout, std::size_t offset, double number, const NearPlaces& nearby) {
    const auto& [place, scales] = std::tie(layout.place, layout.scales);
    const bool is_scale = std::find(scales.begin(), scales.end(), offset) != scales.end();
    if (std::isinf(number) && (offset == layout.opacity || (is_scale && number < 0))) return {};
    if (!std::isfinite(number)) return " is not a finite number";
    if (is_scale && number > largest_scale)
        return " is " + detail::short_number(number) + ": such a splat is beyond single precision";
    const auto axis = std::size_t(std::find(place.begin(), place.end(), offset) - place.begin());
    if (axis < 3 && std::fabs(number - nearby.middle[axis]) > nearby.reach)
        return " is " + detail::short_number(number) + ": over 1e7 median distances from the median";
    return {};
}

NumberFaults number_faults(const SplatFile& scene, const Header& header) {
    const SplatLayout& layout = scene.layout;
    const auto offsets = offsets_of(layout);
    const NearPlaces nearby(scene);
    NumberFaults faults;
    for (std::size_t i = 0; i < scene.size(); ++i) {
        const char* const row = scene.rows.data() + i * layout.row_bytes;
        bool is_usual = farthest_coordinate(scene.place(i) - nearby.middle) <= nearby.reach;
        for (const std::size_t offset : layout.scales) is_usual &= scene.number(i, offset) <= largest_scale;
        for (const std::size_t offset : offsets) {
            std::uint32_t bits = 0;
            std::memcpy(&bits, row + offset, number_bytes);
            is_usual &= (bits & 0x7f800000U) != 0x7f800000U;
        }
        for (std::size_t n = 0; !is_usual && n < offsets.size(); ++n) {
            const std::string why = fault_of(layout, offsets[n], scene.number(i, offsets[n]), nearby);
            if (why.empty()) continue;
            if (faults.splats.empty())
                faults.first =
                    "splat " + std::to_string(i) + " (counted from 0): " + name_at(header, offsets[n]) + why;
            faults.splats.push_back(i);
            break;
        }
    }
    return faults;
}

/// Removes rows; indices are ascending.
void remove_rows(SplatFile& scene, std::span<const std::size_t> splats) {
    std::string kept;
    std::size_t next = 0;
    const std::size_t bytes = scene.layout.row_bytes;
    for (const std::size_t splat : splats) {
        kept.append(scene.rows, next * bytes, (splat - next) * bytes);
        next = splat + 1;
    }
    scene.rows = kept.append(scene.rows, next * bytes);
}

/// Size of all records of an element at the beginning of `bytes`; nothing if they are cut off.
std::optional<std::size_t> bytes_of_records(const PlyElement& element, std::string_view bytes) {
    if (const auto each = element.record_bytes()) {
        if (*each > 0 && element.count > bytes.size() / *each) return std::nullopt;
        return std::size_t(element.count) * *each;
    }
    std::size_t at = 0;
    for (std::uint64_t record = 0; record < element.count; ++record) {
        for (const PlyProperty& property : element.properties) {
            std::uint64_t numbers = 1;
            if (property.count) {
                const std::size_t width = bytes_of(*property.count);
                if (bytes.size() - at < width) return std::nullopt;
                numbers = 0;
                std::memcpy(&numbers, bytes.data() + at, width);
                at += width;
                const std::uint64_t sign = std::uint64_t{1} << (8 * width - 1);
                const bool is_signed = *property.count == PlyType::int8 ||
                                       *property.count == PlyType::int16 || *property.count == PlyType::int32;
                if (is_signed && (numbers & sign) != 0) return std::nullopt; // a negative length
            }
            if (numbers > (bytes.size() - at) / bytes_of(property.type)) return std::nullopt;
            at += std::size_t(numbers) * bytes_of(property.type);
        }
    }
    return at;
}

} // namespace

std::size_t SplatLayout::degree() const {
    std::size_t degree = 0;
    while (3 * harmonics_of(degree) < rest.size()) ++degree;
    return degree;
}

double SplatFile::number(std::size_t splat, std::size_t offset) const {
    float value = 0;
    std::memcpy(&value, rows.data() + splat * layout.row_bytes + offset, number_bytes);
    return double(value);
}

void SplatFile::set(std::size_t splat, std::size_t offset, double value) {
    const auto rounded = float(value);
    std::memcpy(rows.data() + splat * layout.row_bytes + offset, &rounded, number_bytes);
}

Point3 SplatFile::vector(std::size_t splat, std::span<const std::size_t> offsets) const {
    return {number(splat, offsets[0]), number(splat, offsets[1]), number(splat, offsets[2])};
}

void SplatFile::set(std::size_t splat, std::span<const std::size_t> offsets, const Point3& value) {
    for (std::size_t k = 0; k < 3; ++k) set(splat, offsets[k], value[k]);
}

SplatShape SplatFile::shape(std::size_t splat) const {
    SplatShape shape{{}, vector(splat, layout.scales)};
    for (std::size_t k = 0; k < 4; ++k) shape.rotation[k] = number(splat, layout.rotation[k]);
    return shape;
}

void SplatFile::set(std::size_t splat, const SplatShape& shape) {
    set(splat, layout.scales, shape.log_scales);
    for (std::size_t k = 0; k < 4; ++k) set(splat, layout.rotation[k], shape.rotation[k]);
}

std::string SplatFile::header_text(std::size_t splats) const {
    std::string text = "ply\nformat binary_little_endian 1.0\n";
    const std::string element = "element vertex " + std::to_string(splats) + '\n';
    for (std::size_t i = 0; i < header.size(); ++i) {
        if (i == element_at) text += element;
        text += header[i] + '\n';
    }
    return text + "end_header\n";
}

Expected<SplatFile> parse_splats(std::string bytes, std::string name, bool strict) {
    std::string_view left(bytes);
    auto header = read_header(left, name);
    if (!header) return header.error();
    const auto fails = [&](const std::string& why) { return FileError{name + ": " + why}; };
    if (const std::string why = find_numbers(*header); !why.empty()) return fails(why);
    SplatFile scene = header->scene;
    scene.others = others_of(*header);
    const std::size_t row = scene.layout.row_bytes;
    const std::uint64_t splats = header->elements[header->splats].count;
    if (splats == 0) return fails("has no splats");
    const bool is_alone = header->elements.size() == 1;
    for (std::size_t e = 0; e < header->elements.size(); ++e) {
        const PlyElement& element = header->elements[e];
        const auto size = bytes_of_records(element, left);
        if (!size && e == header->splats) {
            return fails("is cut off: the header declares " + std::to_string(splats) + " splats of " +
                         std::to_string(row) + " bytes, but only " + std::to_string(left.size()) +
                         " bytes follow");
        }
        if (!size) return fails("is cut off in its element " + detail::quoted(element.name));
        if (!is_alone)
            (e < header->splats    ? scene.before
             : e == header->splats ? scene.rows
                                   : scene.after)
                .append(left.substr(0, *size));
        left.remove_prefix(*size);
    }
    if (!left.empty())
        return fails("is too long: " + std::to_string(left.size()) + " bytes follow the declared records");
    if (is_alone) { // avoids a copy, since scenes are large
        bytes.erase(0, bytes.size() - std::size_t(splats) * row);
        scene.rows = std::move(bytes);
    }
    scene.name = name;
    const NumberFaults faults = number_faults(scene, *header);
    if (faults.splats.empty()) return scene;
    if (strict || faults.splats.size() == splats) return fails(faults.first);
    remove_rows(scene, faults.splats);
    scene.warning = name + ": " + std::to_string(faults.splats.size()) + " of " + std::to_string(splats) +
                    " splats are left out, first " + faults.first + "; --strict refuses the file";
    if (!scene.before.empty() || !scene.after.empty())
        scene.warning += "; numbers of splats in other elements are not updated";
    return scene;
}

Expected<SplatFile> load_splats(const std::filesystem::path& path, bool strict) {
    std::error_code none;
    if (std::filesystem::is_regular_file(
            path, none)) { // a pipe can be read only once, so it must not need conversion
        PlyReader reader(path.string());
        std::vector<PlyElement> elements = reader.header().elements;
        bool is_plain = reader.header().encoding == PlyEncoding::little_endian, has_doubles = false;
        for (PlyElement& element : elements) {
            for (PlyProperty& property : element.properties) {
                if (element.name != "vertex" || !is_of_splat(property.name)) continue;
                is_plain &= property.type == PlyType::float32;
                has_doubles |= property.type == PlyType::float64;
                property.type = PlyType::float32;
            }
        }
        if (reader.error().empty() && !is_plain) {
            auto converted = little_endian_bytes(reader, elements);
            if (!converted) return FileError{reader.error()};
            auto scene = parse_splats(std::move(*converted), path.string(), strict);
            if (!scene || !has_doubles) return scene;
            std::vector<Point3> places;
            for (std::size_t i = 0; i < scene->size(); ++i) places.push_back(scene->place(i));
            if (const std::string why = rounding_fault(path.string(), places); !why.empty())
                scene->warning += (scene->warning.empty() ? "" : "; ") + why;
            return scene;
        }
    }
    auto bytes = read_file(path.string());
    if (!bytes) return bytes.error();
    return parse_splats(std::move(*bytes), path.string(), strict);
}

SplatFile empty_scene(std::size_t highest) {
    std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n";
    const auto add = [&](const std::string& property) { text += "property float " + property + '\n'; };
    for (const char* property : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"})
        add(property);
    for (std::size_t i = 0; i < 3 * harmonics_of(highest); ++i) add("f_rest_" + std::to_string(i));
    for (const char* property :
         {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
        add(property);
    text += "end_header\n";
    std::string_view left(text);
    auto header = read_header(left, "a scene");
    (void)find_numbers(*header);
    return header->scene;
}

void append(SplatFile& scene, const Splat& splat) {
    const std::size_t i = scene.size();
    const SplatLayout& layout = scene.layout;
    scene.rows.resize(scene.rows.size() + layout.row_bytes);
    scene.set(i, layout.place, splat.place);
    scene.set(i, splat.shape);
    scene.set(i, layout.opacity, splat.opacity);
    for (std::size_t channel = 0; channel < 3; ++channel) {
        scene.set(i, layout.colour[channel], splat.colour[channel]);
        const std::size_t count = layout.rest.size() / 3;
        for (std::size_t k = 0; k < count; ++k)
            scene.set(i, layout.rest[channel * count + k], splat.harmonics[channel][k]);
    }
}

double opacity_of(double logit) {
    return 1 / (1 + std::exp(-logit));
}

double logit_of(double opacity) {
    return std::log(opacity / (1 - opacity));
}

} // namespace cageform_support
