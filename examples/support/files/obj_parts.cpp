#include "files/obj_parts.hpp"

#include "files/csv.hpp"
#include "files/input_file.hpp"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>

namespace cageform_examples {

namespace {

namespace fs = std::filesystem;

/// Returns all words after the first as one name.
std::string name_of(std::span<const std::string_view> words) {
    std::string name;
    for (const std::string_view word : words.subspan(1)) (name += name.empty() ? "" : " ") += word;
    return name;
}

/// A line with one space between its words.
std::string single_spaced(const std::string& line) {
    std::istringstream stream(line);
    std::string name;
    for (std::string word; stream >> word;) (name += name.empty() ? "" : " ") += word;
    return name;
}

/// The file of a name inside a folder; one of another folder is looked for by the last part of its path.
/// Links do not lead out of the folder either.
std::optional<fs::path> file_inside(const fs::path& folder, std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    const fs::path named(name);
    std::error_code error;
    const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, error);
    if (error || named.filename().empty()) return std::nullopt;
    for (const fs::path& candidate : {folder / named, folder / named.filename()}) {
        const fs::path place = fs::weakly_canonical(candidate, error);
        if (error) continue;
        const bool inside =
            std::mismatch(root.begin(), root.end(), place.begin(), place.end()).first == root.end();
        if (inside && fs::is_regular_file(place, error)) return candidate;
    }
    return std::nullopt;
}

double within(double x, double most) {
    return std::isfinite(x) ? std::clamp(x, 0.0, most) : 0;
}

/// A material as tinyobjloader has read it.
ObjMaterial taken(const tinyobj::material_t& read) {
    ObjMaterial material;
    material.name = single_spaced(read.name);
    constexpr double brightest = 1e4;
    double gloss = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        material.colour[k] = within(read.diffuse[k], 1);
        material.emission[k] = within(read.emission[k], brightest);
        gloss = std::max(gloss, within(read.specular[k], 1));
    }
    material.opacity = within(read.dissolve, 1);
    material.metallic = within(read.metallic, 1);
    if (read.roughness > 0 || read.metallic > 0) {
        material.roughness = within(read.roughness, 1);
    } else if (gloss > 0) {
        // The exponent of Blinn and Phong as a roughness: Walter et al., Microfacet models (2007), sec.
        // 5.2, whose
        // alpha is the square of glTF's.
        material.roughness = std::pow(2 / (within(read.shininess, 1e6) + 2), 0.25);
    } else {
        material.roughness = 1;
    }
    return material;
}

class PartReader {
public:
    explicit PartReader(const ObjFile& file)
        : file_(file)
        , folder_(fs::path(file.name).parent_path()) {}

    ObjParts read() {
        bool has_objects = false;
        std::vector<std::string_view> words;
        std::size_t line = 1;
        for (detail::ObjScanner scanner(file_.text); scanner.next(words, line);)
            has_objects |= words[0] == "o";
        for (const std::string& name : material_files(file_)) read_library(name);

        const std::string_view of_object = has_objects ? "o" : "g";
        std::string object = fs::path(file_.name).stem().string(), material;
        for (detail::ObjScanner scanner(file_.text); scanner.next(words, line);) {
            if (words[0] == of_object && words.size() > 1) object = name_of(words);
            if (words[0] == "usemtl") material = name_of(words);
            if (words[0] != "f") continue;
            parts_.face_objects.push_back(number_of(object, objects_, parts_.objects.size()));
            if (parts_.face_objects.back() == parts_.objects.size()) parts_.objects.push_back(object);
            parts_.face_materials.push_back(number_of(material, used_, parts_.materials.size()));
            if (parts_.face_materials.back() == parts_.materials.size()) add_material(material, line);
        }
        return std::move(parts_);
    }

private:
    static std::uint32_t number_of(const std::string& name, std::map<std::string, std::uint32_t>& known,
                                   std::size_t next) {
        return known.insert({name, std::uint32_t(next)}).first->second;
    }

    void warn(const std::string& text) { parts_.warnings.push_back(file_.name + ": " + text); }

    void read_library(const std::string& name) {
        const auto path = file_inside(folder_, name);
        if (!path)
            return warn("its materials, " + detail::quoted(name) +
                        ", are not in its folder: a default material is used");
        const auto text = read_file(path->string());
        if (!text) return warn(text.error().message);
        std::map<std::string, int> numbers;
        std::vector<tinyobj::material_t> read;
        std::istringstream stream(*text);
        std::string ignored, fault;
        tinyobj::LoadMtl(&numbers, &read, &stream, &ignored, &fault);
        for (const tinyobj::material_t& one : read) {
            ObjMaterial material = taken(one);
            if (!one.diffuse_texname.empty()) add_texture(material, path->parent_path(), one.diffuse_texname);
            library_.insert({material.name, std::move(material)}); // the first of a name
        }
    }

    void add_texture(ObjMaterial& material, const fs::path& folder, const std::string& name) {
        auto found = file_inside(folder, name);
        if (!found) found = file_inside(folder_, name);
        if (!found) {
            return warn("the texture " + detail::quoted(name) + " of the material " +
                        detail::quoted(material.name) + " is not in its folder");
        }
        material.texture = found->string();
        // The picture is multiplied by Kd, which some programs leave black.
        if (material.colour == std::array<double, 3>{}) material.colour = {1, 1, 1};
    }

    void add_material(const std::string& name, std::size_t line) {
        if (const auto found = library_.find(name); found != library_.end()) {
            parts_.materials.push_back(found->second);
            return;
        }
        if (!name.empty() && !library_.empty())
            warn("none of its material files defines the material " + detail::quoted(name) + " (line " +
                 std::to_string(line) + "): a default material is used");
        parts_.materials.emplace_back().name = name.empty() ? "clay" : name;
    }

    const ObjFile& file_;
    fs::path folder_;
    ObjParts parts_;
    std::map<std::string, std::uint32_t> objects_, used_;
    std::map<std::string, ObjMaterial> library_;
};

} // namespace

ObjParts read_parts(const ObjFile& file) {
    return PartReader(file).read();
}

std::vector<std::string> material_files(const ObjFile& file) {
    std::vector<std::string> names;
    std::vector<std::string_view> words;
    std::size_t line = 1;
    const fs::path folder = fs::path(file.name).parent_path();
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) {
        if (words[0] != "mtllib" || words.size() < 2) continue;
        const std::string whole = name_of(words); // one name with spaces, or several names
        if (words.size() == 2 || file_inside(folder, whole))
            names.push_back(whole);
        else
            names.insert(names.end(), words.begin() + 1, words.end());
    }
    return names;
}

} // namespace cageform_examples
