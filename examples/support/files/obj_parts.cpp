#include "files/obj_parts.hpp"

#include "files/obj_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>

namespace cageform_support {

namespace {

namespace fs = std::filesystem;

/// Joins all words after the first.
std::string name_of(std::span<const std::string_view> words) {
    std::string name;
    for (const std::string_view word : words.subspan(1)) (name += name.empty() ? "" : " ") += word;
    return name;
}

/// Collapses white space.
std::string single_spaced(const std::string& line) {
    std::istringstream stream(line);
    std::string name;
    for (std::string word; stream >> word;) (name += name.empty() ? "" : " ") += word;
    return name;
}

/// Finds a file inside a folder; of a path to another folder, only the file name is used. Links out of the
/// folder are not followed.
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

/// Statements and their equivalents in glTF.
///
///   fate   carried: written. counted: counted in reports. warned: a warning names it if unused
struct Statement {
    std::string_view words, place;
    enum { carried, counted, warned } fate = carried;
};
constexpr Statement statements[] = {
    {"v", "POSITION; three more numbers of a vertex: COLOR_0, from sRGB to linear"},
    {"vn", "NORMAL, of unit length"},
    {"vt", "TEXCOORD_0, of two numbers; v becomes 1 - v"},
    {"f", "primitives; faces of more than three corners are cut into triangles"},
    {"o", "a node and a mesh"},
    {"g", "in a file without `o`, a node and a mesh; else not needed"},
    {"s", "not needed: vertices without normals get smooth ones"},
    {"usemtl mtllib newmtl", "a primitive and its material"},
    {"Kd", "baseColorFactor; white if Kd is black or missing and there is a picture"},
    {"d Tr", "the fourth number of baseColorFactor, and alphaMode BLEND below 1"},
    {"Ks Ns", "approximated: roughnessFactor, where there is no Pr or Pm"},
    {"Pr Pm", "roughnessFactor, metallicFactor"},
    {"Ke", "emissiveFactor, KHR_materials_emissive_strength above 1"},
    {"map_Kd", "baseColorTexture"},
    {"map_d", "alphaMode BLEND, if it is the picture of map_Kd; else dropped with a warning",
     Statement::warned},
    {"map_Ke", "emissiveTexture"},
    {"norm", "normalTexture"},
    {"Ka Kt Tf Ni illum sharpness Ps Pc Pcr aniso anisor", "dropped; `--report` counts them",
     Statement::counted},
};

const Statement* find_statement(std::string_view keyword) {
    for (const Statement& statement : statements) {
        const std::string words = ' ' + std::string(statement.words) + ' ';
        if (words.find(' ' + std::string(keyword) + ' ') != words.npos) return &statement;
    }
    return nullptr;
}

constexpr double brightest = 1e4, sharpest = 1e6; // upper bounds of Ke and Ns

double within(double x, double most) {
    return std::isfinite(x) ? std::clamp(x, 0.0, most) : 0;
}

/// The statements of one material in an MTL file, without options of images: tinyobjloader misreads an
/// image's name after an option with fewer numbers than allowed.
struct MaterialText {
    std::string text;
    std::vector<std::string> keywords;
    std::vector<std::string> faults; ///< of numbers, for warnings
    bool has_colour = false;
    std::optional<double> halo; ///< the number of `d -halo`, which tinyobjloader reads as 0
};

bool is_option(std::string_view word) {
    return word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])) != 0;
}

/// Whether an image option takes one word or number; others take one to three numbers.
bool takes_word(std::string_view option) {
    for (const std::string_view one : {"-blendu", "-blendv", "-cc", "-clamp", "-imfchan", "-type", "-bm",
                                       "-boost", "-texres", "-colorspace"}) {
        if (option == one) return true;
    }
    return false;
}

/// Checks the numbers of a statement. Returns a warning, or empty. Clears an invalid statement, so that the
/// default is used.
std::string check_numbers(const std::vector<std::string_view>& words, std::string& statement) {
    struct Numbers {
        std::string_view keyword;
        std::size_t count;
        double most;
    };
    constexpr Numbers all[] = {{"Kd", 3, 1}, {"Ks", 3, 1}, {"Ke", 3, brightest}, {"d", 1, 1},
                               {"Tr", 1, 1}, {"Pr", 1, 1}, {"Pm", 1, 1},         {"Ns", 1, sharpest}};
    const auto* const used =
        std::find_if(std::begin(all), std::end(all), [&](const Numbers& n) { return n.keyword == words[0]; });
    if (used == std::end(all)) return {};
    const std::string name = detail::quoted(statement) + ": ";
    const std::size_t first = words.size() > 2 && words[1] == "-halo" ? 2 : 1;
    const std::size_t count = std::min(words.size() - first, used->count);
    std::string why, outside;
    if (count < used->count)
        why = count == 0 ? "a number is missing" : std::to_string(count) + " of 3 numbers";
    const bool is_grey = count == 1 && used->count == 3;
    for (std::size_t k = 0; k < count; ++k) {
        const std::string_view word = words[first + k];
        double number = 0;
        if (const std::string fault = detail::parse_finite(word, number); !fault.empty()) {
            statement.clear();
            why = fault + (word.find(',') != word.npos ? " (decimal commas are not read)" : "");
            break;
        }
        if (number < 0 || number > used->most)
            outside = detail::quoted(word) + " is not from 0 to " + detail::short_number(used->most);
    }
    if (!statement.empty() && is_grey) {
        for (int k = 0; k < 2; ++k) (statement += ' ') += words[first];
        return name + why + ": the number is taken for all three" + (outside.empty() ? "" : "; " + outside);
    }
    if (!why.empty()) statement.clear();
    if (!why.empty()) return name + why + ": the default is used";
    return outside.empty() ? outside : name + outside + ": the nearest number in this range is used";
}

/// Splits an MTL file into its materials.
std::vector<MaterialText> materials_in(std::string_view text, const std::string& path) {
    std::vector<MaterialText> materials;
    std::vector<std::string_view> words;
    std::size_t line = 1;
    for (detail::ObjScanner scanner(text); scanner.next(words, line);) {
        if (words[0] == "newmtl") materials.emplace_back();
        if (materials.empty()) continue;
        MaterialText& material = materials.back();
        const bool is_picture = words[0].starts_with("map_") || words[0] == "norm";
        std::size_t name = 1; // index of the word after the options
        while (is_picture && name + 1 < words.size() && is_option(words[name])) {
            material.keywords.push_back(std::string(words[0]) + ' ' + std::string(words[name]));
            const bool has_word = takes_word(words[name]);
            double number = 0;
            for (std::size_t k = 0; ++name + 1 < words.size() && k < (has_word ? 1u : 3u); ++k) {
                if (!has_word && !detail::parse_number(words[name], number).empty()) break;
            }
        }
        std::string statement(words[0]);
        for (; name < words.size(); ++name) (statement += ' ') += words[name];
        if (const std::string why = check_numbers(words, statement); !why.empty())
            material.faults.push_back(path + ':' + std::to_string(line) + ": " + why);
        material.text += statement + '\n';
        if (words[0] == "newmtl") continue;
        material.keywords.emplace_back(words[0]);
        material.has_colour |= words[0] == "Kd" && !statement.empty();
        double number = 0;
        if (statement.starts_with("d -halo ") && detail::parse_number(words[2], number).empty())
            material.halo = number;
    }
    return materials;
}

/// Converts a material of tinyobjloader.
ObjMaterial taken(const tinyobj::material_t& read, const MaterialText& text) {
    ObjMaterial material;
    material.name = single_spaced(read.name);
    double gloss = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (text.has_colour) material.colour[k] = within(read.diffuse[k], 1);
        material.emission[k] = within(read.emission[k], brightest);
        gloss = std::max(gloss, within(read.specular[k], 1));
    }
    material.opacity = within(text.halo ? *text.halo : double(read.dissolve), 1);
    material.metallic = within(read.metallic, 1);
    if (read.roughness > 0 || read.metallic > 0) {
        material.roughness = within(read.roughness, 1);
    } else if (gloss > 0) {
        // Roughness from the Blinn-Phong exponent: Walter et al., Microfacet models (2007), section 5.2;
        // alpha is the square of glTF's roughness.
        material.roughness = std::pow(2 / (within(read.shininess, sharpest) + 2), 0.25);
    } else {
        material.roughness = 1;
    }
    return material;
}

class PartReader {
public:
    explicit PartReader(const MeshFile& file)
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
            if (words[0] != "f") {
                // x y z, then w or r g b: programs disagree on other counts.
                const bool has_more =
                    words[0] == "v" && words.size() != 4 && words.size() != 5 && words.size() != 7;
                count_unused(has_more ? "v with " + std::to_string(words.size() - 1) + " numbers"
                                      : std::string(words[0]));
                continue;
            }
            parts_.face_objects.push_back(number_of(object, objects_, parts_.objects.size()));
            if (parts_.face_objects.back() == parts_.objects.size()) parts_.objects.push_back(object);
            parts_.face_materials.push_back(number_of(material, used_, parts_.materials.size()));
            if (parts_.face_materials.back() == parts_.materials.size()) add_material(material, line);
        }
        if (file_.text.empty()) { // of another format
            parts_.objects.push_back(object);
            parts_.face_objects.resize(file_.faces.size());
            parts_.face_materials.resize(file_.faces.size());
            add_material({}, 0);
        }
        warn_of_unused();
        if (file_.has_bytes_as_colours)
            warn("some colours of vertices are above 1: all are taken as numbers from 0 to 255");
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
        const auto text = read_text(path->string());
        if (!text) return warn(text.error().message);
        if (const std::string_view format = detail::other_format(*text); !format.empty())
            warn(path->string() + " looks like a file of the format " + std::string(format));
        const auto materials = materials_in(*text, path->string());
        if (materials.empty())
            warn(path->string() + " defines no material (statements newmtl): a default material is used");
        for (const MaterialText& one : materials) read_material(one, path->parent_path());
    }

    /// Parses each material separately, since tinyobjloader's default colour depends on the material before.
    void read_material(const MaterialText& text, const fs::path& folder) {
        std::map<std::string, int> numbers;
        std::vector<tinyobj::material_t> read;
        std::istringstream stream{text.text};
        std::string ignored, fault;
        tinyobj::LoadMtl(&numbers, &read, &stream, &ignored, &fault);
        if (read.empty()) return;
        ObjMaterial material = taken(read[0], text);
        const auto picture = [&](const std::string& name) {
            return name.empty() ? std::string() : find_texture(material, folder, name);
        };
        material.texture = picture(read[0].diffuse_texname);
        material.emission_texture = picture(read[0].emissive_texname);
        material.normal_texture = picture(read[0].normal_texname);
        material.opaque_texture =
            material.texture.empty() || read[0].alpha_texname != read[0].diffuse_texname;
        // The image is multiplied by Kd, which some programs omit or set to black.
        constexpr std::array<double, 3> black{}, white{1, 1, 1};
        if (!material.texture.empty() && (!text.has_colour || material.colour == black))
            material.colour = white;
        Library entry{std::move(material), text.keywords, text.faults};
        if (!entry.material.opaque_texture) std::erase(entry.keywords, "map_d");
        library_.insert({entry.material.name, std::move(entry)}); // the first definition counts
    }

    std::string find_texture(const ObjMaterial& material, const fs::path& folder, const std::string& name) {
        auto found = file_inside(folder, name);
        if (!found) found = file_inside(folder_, name);
        if (found) return found->string();
        warn("the texture " + detail::quoted(name) + " of the material " + detail::quoted(material.name) +
             " is not in its folder");
        return {};
    }

    void add_material(const std::string& name, std::size_t line) {
        if (const auto found = library_.find(name); found != library_.end()) {
            parts_.materials.push_back(found->second.material);
            for (const std::string& keyword : found->second.keywords) count_unused(keyword);
            const auto& faults = found->second.faults;
            parts_.warnings.insert(parts_.warnings.end(), faults.begin(), faults.end());
            return;
        }
        if (!name.empty() && !library_.empty())
            warn("none of its material files defines the material " + detail::quoted(name) + " (line " +
                 std::to_string(line) + "): a default material is used");
        ObjMaterial& material = parts_.materials.emplace_back();
        material.name = name.empty() ? "clay" : name;
        if (!file_.colours.empty()) material.colour = {1, 1, 1}; // multiplied by vertex colours
    }

    void count_unused(std::string_view keyword) {
        const Statement* const known = find_statement(keyword);
        if (known == nullptr || known->fate != Statement::carried) ++parts_.unused[std::string(keyword)];
    }

    /// Warns of unused shapes and images. Unused numbers of materials, which most files have, appear only in
    /// reports.
    void warn_of_unused() {
        std::string names;
        for (const auto& [keyword, count] : parts_.unused) {
            const Statement* const known = find_statement(keyword);
            if (known == nullptr || known->fate == Statement::warned)
                (names += names.empty() ? "" : ", ") +=
                    detail::quoted(keyword) + " (" + std::to_string(count) + ")";
        }
        if (!names.empty()) warn("glTF has no equivalent of these statements: " + names);
    }

    const MeshFile& file_;
    fs::path folder_;
    ObjParts parts_;
    std::map<std::string, std::uint32_t> objects_, used_;
    struct Library {
        ObjMaterial material;
        std::vector<std::string> keywords; // of all statements
        std::vector<std::string> faults;   // of its numbers
    };
    std::map<std::string, Library> library_;
};

} // namespace

ObjParts read_parts(const MeshFile& file) {
    return PartReader(file).read();
}

std::string statement_table() {
    std::string text = "| in OBJ and MTL files | in glTF files |\n|---|---|\n";
    for (const Statement& statement : statements) {
        std::string words = "| `";
        for (const char c : statement.words) words += c == ' ' ? "`, `" : std::string(1, c);
        text += words + "` | " + std::string(statement.place) + " |\n";
    }
    return text +
           "| all others, and options of pictures | dropped with a warning that names and counts them |\n";
}

std::string describe_unused(const ObjParts& of_file) {
    std::string text;
    for (const auto& [keyword, count] : of_file.unused)
        text += (text.empty() ? "statements without equivalent in glTF: " : ", ") + detail::quoted(keyword) +
                ' ' + std::to_string(count);
    return text.empty() ? text : text + '\n';
}

std::vector<std::string> material_files(const MeshFile& file) {
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

std::string describe_materials(const MeshFile& file, const std::string& copy) {
    const auto folder_of = [](const std::string& path) {
        return fs::absolute(path).lexically_normal().parent_path();
    };
    const auto materials = material_files(file);
    if (materials.empty() || folder_of(copy) == folder_of(file.name)) return {};
    return copy + " names its materials as " + file.name + " does: " + detail::quoted(materials[0]) +
           (materials.size() > 1 ? " and more" : "") +
           " (and their textures), which must be in the same folder";
}

} // namespace cageform_support
