#include "files/gltf_document.hpp"

#include "files/gltf_compression.hpp"
#include "io/base64.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <map>

namespace cageform_support {

namespace {

constexpr std::size_t deepest_json = 256;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, 4);
    return word;
}

/// Whether JSON text nests deeper than the recursive functions of nlohmann-json can handle.
bool is_too_deep(std::string_view text) {
    std::size_t depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\') ++i;
            in_string = c != '"';
        } else if (c == '"') {
            in_string = true;
        } else if (c == '[' || c == '{') {
            if (++depth > deepest_json) return true;
        } else if ((c == ']' || c == '}') && depth > 0) {
            --depth;
        }
    }
    return false;
}

/// A non-negative integer property; `otherwise` if it is absent.
std::size_t whole(const GltfJson& object, const char* key, std::size_t otherwise, const std::string& user) {
    const auto found = object.find(key);
    if (found == object.end()) return otherwise;
    const auto number = gltf_index(*found);
    if (!number) throw GltfFault(user + ": \"" + key + "\" is not a whole number of 0 or more");
    return *number;
}

std::size_t whole(const GltfJson& object, const char* key, const std::string& user) {
    if (!object.contains(key)) throw GltfFault(user + ": \"" + key + "\" is missing");
    return whole(object, key, 0, user);
}

std::string name_of(const char* array, std::size_t index) {
    std::string name = array;
    name.resize(name.size() - (name == "meshes" ? 2 : 1)); // the plural
    return name + ' ' + std::to_string(index);
}

/// A text property; empty if it is absent.
std::string text_of(const GltfJson& object, const char* key, const std::string& user) {
    const auto found = object.find(key);
    if (found == object.end()) return {};
    if (!found->is_string()) throw GltfFault(user + ": \"" + key + "\" is not a text");
    return found->get<std::string>();
}

/// Extensions that change neither positions of vertices nor the structure that is read here.
bool is_harmless(std::string_view extension) {
    for (const std::string_view prefix :
         {"KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_", "EXT_lights_",
          "KHR_audio", "KHR_xmp", "KHR_animation_pointer", "MSFT_packing_", "KHR_node_visibility",
          "KHR_mesh_quantization", "EXT_materials_", "KHR_draco_mesh_compression", "EXT_meshopt_compression",
          "AGI_", "CESIUM_primitive_outline"}) {
        if (extension.starts_with(prefix)) return true;
    }
    return false;
}

} // namespace

struct GltfDocument::Layout {
    int type = 0; // componentType
    std::size_t size = 0, components = 0;
    bool normalised = false;

    std::size_t bytes() const {
        if (components < 9 || size == 4) return size * components;
        return components == 9 ? (size == 1 ? 12 : 24) : size * components; // 3.6.2.4: columns of MAT3
    }
    /// Offset of a component in an element; columns of matrices are padded to four bytes.
    std::size_t offset(std::size_t k) const {
        if (components != 9 || size == 4) return k * size;
        return k / 3 * (size == 1 ? 4 : 8) + k % 3 * size;
    }
    double number(const char* at) const {
        const auto as = [&]<class T>(T value) {
            std::memcpy(&value, at, sizeof(T));
            if constexpr (std::is_integral_v<T>) { // 3.6.2.2
                if (normalised) return std::max(double(value) / double(std::numeric_limits<T>::max()), -1.0);
            }
            return double(value);
        };
        switch (type) {
        case 5120: return as(std::int8_t{});
        case 5121: return as(std::uint8_t{});
        case 5122: return as(std::int16_t{});
        case 5123: return as(std::uint16_t{});
        case 5125: return as(std::uint32_t{});
        default: return as(float{});
        }
    }
};

Expected<GltfDocument> GltfDocument::parse(std::string bytes, const std::string& path) {
    GltfDocument document;
    document.path_ = path;
    try {
        document.read_container(std::move(bytes));
        document.check_extensions();
        document.load_buffers();
        document.decode_views();
        document.decode_primitives();
    } catch (const GltfFault& fault) {
        return FileError{path + ": " + fault.what()};
    } catch (const GltfJson::exception& fault) {
        return json_error(path, fault);
    }
    return document;
}

void GltfDocument::read_container(std::string bytes) {
    file_size_ = bytes.size();
    is_binary_ = bytes.starts_with("glTF");
    if (!is_binary_) {
        text_ = std::move(bytes);
        if (text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
    } else { // 4.4
        if (bytes.size() < 20) throw GltfFault("ends within the header of 20 bytes");
        if (const auto version = word_at(bytes, 4); version != 2)
            throw GltfFault("is a GLB file of version " + std::to_string(version) + "; version 2 is read");
        const std::size_t length = word_at(bytes, 8), json_size = word_at(bytes, 12);
        if (length > bytes.size())
            throw GltfFault("ends after " + std::to_string(bytes.size()) + " of " + std::to_string(length) +
                            " bytes");
        if (word_at(bytes, 16) != 0x4e4f534a) throw GltfFault("the first chunk is not JSON");
        if (json_size > length - 20) throw GltfFault("the chunk of JSON is longer than the file");
        text_ = bytes.substr(20, json_size);
        std::size_t at = 20 + (json_size + 3) / 4 * 4;
        if (length >= at + 8 && word_at(bytes, at + 4) == 0x004e4942) {
            const std::size_t size = word_at(bytes, at);
            if (size > length - at - 8) throw GltfFault("the binary chunk is longer than the file");
            buffers_.push_back({bytes.substr(at + 8, size), {}, false, false});
        }
    }
    if (is_too_deep(text_))
        throw GltfFault("the JSON is nested deeper than " + std::to_string(deepest_json) + " levels");
    json = GltfJson::parse(text_);
    if (!json.is_object()) throw GltfFault("the JSON is not an object");
    const auto asset = json.find("asset");
    if (asset == json.end() || !asset->is_object() || !asset->contains("version"))
        throw GltfFault("has no asset with a version");
    const auto& version = (*asset)["version"];
    if (!version.is_string()) throw GltfFault("its version is not a text, such as \"2.0\"");
    if (!version.get_ref<const std::string&>().starts_with("2."))
        throw GltfFault("is glTF of version " + version.dump() + "; version 2.0 is read");
}

void GltfDocument::check_extensions() const {
    for (const GltfJson& extension : array("extensionsRequired")) {
        if (!extension.is_string()) throw GltfFault("\"extensionsRequired\" is not a list of names");
        if (!is_harmless(extension.get_ref<const std::string&>()))
            throw GltfFault("requires the extension " + detail::quoted(extension.get<std::string>()) +
                            ", which is not supported");
    }
}

void GltfDocument::load_buffers() {
    const GltfJson& list = array("buffers");
    for (std::size_t i = 0; i < list.size(); ++i) load_buffer(object("buffers", i, "the document"), i);
}

void GltfDocument::load_buffer(const GltfJson& buffer, std::size_t index) {
    const std::string user = name_of("buffers", index);
    const std::size_t size = whole(buffer, "byteLength", user);
    const auto uri = buffer.find("uri");
    if (uri == buffer.end()) {
        const auto extensions = buffer.find("extensions");
        const bool is_fallback =
            extensions != buffer.end() && extensions->contains("EXT_meshopt_compression");
        if (index < buffers_.size()) { // the binary chunk, which may be padded
            auto& bytes = buffers_[index].bytes;
            if (size > bytes.size())
                throw GltfFault(user + ": the file has " + std::to_string(bytes.size()) + " of " +
                                std::to_string(size) + " bytes");
            bytes.resize(size);
        } else if (is_fallback) {
            buffers_.resize(index + 1); // filled by decode_views()
        } else {
            throw GltfFault(user + ": its data are missing");
        }
        return;
    }
    if (!uri->is_string()) throw GltfFault(user + ": \"uri\" is not a text");
    const auto& text = uri->get_ref<const std::string&>();
    Buffer loaded;
    if (text.starts_with("data:")) {
        const std::size_t comma = text.find(";base64,");
        auto bytes =
            comma == std::string::npos ? std::nullopt : from_base64(std::string_view(text).substr(comma + 8));
        if (!bytes) throw GltfFault(user + ": its data URI is not base64");
        loaded = {std::move(*bytes), {}, true, false};
    } else {
        loaded = {read_beside(text, user), text, false, false};
    }
    if (loaded.bytes.size() < size)
        throw GltfFault(user + ": has " + std::to_string(loaded.bytes.size()) + " of " +
                        std::to_string(size) + " bytes");
    buffers_.resize(std::max(buffers_.size(), index + 1));
    buffers_[index] = std::move(loaded);
}

std::string GltfDocument::read_beside(const std::string& uri, const std::string& user) const {
    const std::filesystem::path name = std::filesystem::path(detail::percent_decoded(uri)).lexically_normal();
    if (detail::has_scheme(uri) || name.is_absolute() || name.empty() || *name.begin() == "..")
        throw GltfFault(user + ": " + detail::quoted(uri) +
                        " is not in the folder of the document or a subfolder");
    auto bytes = read_file((std::filesystem::path(path_).parent_path() / name).string(), largest_mesh_file);
    if (!bytes) throw GltfFault(user + ": " + bytes.error().message);
    return std::move(*bytes);
}

const GltfJson& GltfDocument::array(const char* name) const {
    static const GltfJson none = GltfJson::array();
    const auto found = json.find(name);
    if (found == json.end()) return none;
    if (!found->is_array()) throw GltfFault(std::string("\"") + name + "\" is not a list");
    return *found;
}

const GltfJson& GltfDocument::object(const char* array_name, GltfIndex index, const std::string& user) const {
    const GltfJson& list = array(array_name);
    if (index >= list.size())
        throw GltfFault(user + ": there is no " + name_of(array_name, index) + "; the document has " +
                        std::to_string(list.size()));
    if (!list[index].is_object()) throw GltfFault(name_of(array_name, index) + " is not an object");
    return list[index];
}

GltfDocument::Layout GltfDocument::layout(const GltfJson& accessor, const std::string& user) const {
    static const std::map<std::string, std::size_t> types{
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
    const auto type = accessor.find("type");
    const auto known =
        type != accessor.end() && type->is_string() ? types.find(type->get<std::string>()) : types.end();
    if (known == types.end()) throw GltfFault(user + ": \"type\" is none of SCALAR, VEC2, VEC3 …");
    Layout layout;
    layout.components = known->second;
    const std::size_t number = whole(accessor, "componentType", user);
    switch (number) {
    case 5120:
    case 5121: layout.size = 1; break;
    case 5122:
    case 5123: layout.size = 2; break;
    case 5125:
    case 5126: layout.size = 4; break;
    default: throw GltfFault(user + ": there is no componentType " + std::to_string(number));
    }
    layout.type = int(number);
    const auto normalised = accessor.find("normalized");
    layout.normalised = normalised != accessor.end() && *normalised == true;
    return layout;
}

GltfDocument::Elements GltfDocument::elements(const GltfJson& view_holder, const Layout& layout,
                                              std::size_t count, const std::string& user) const {
    const std::size_t index = whole(view_holder, "bufferView", user);
    const GltfJson& view = object("bufferViews", index, user);
    const std::string name = name_of("bufferViews", index);
    Elements found;
    found.count = count;
    found.element_bytes = layout.bytes();
    found.buffer = whole(view, "buffer", name);
    (void)object("buffers", found.buffer, name);
    const std::size_t view_begin = whole(view, "byteOffset", 0, name),
                      view_size = whole(view, "byteLength", name),
                      offset = whole(view_holder, "byteOffset", 0, user);
    found.stride = whole(view, "byteStride", found.element_bytes, name);
    const std::size_t size = buffers_[found.buffer].bytes.size();
    if (view_begin > size || view_size > size - view_begin)
        throw GltfFault(name + ": ends after byte " + std::to_string(size) + ", the end of " +
                        name_of("buffers", found.buffer));
    if (found.stride < found.element_bytes || found.stride > 65536)
        throw GltfFault(user + ": the \"byteStride\" of " + name + " is " + std::to_string(found.stride) +
                        ", and an element has " + std::to_string(found.element_bytes) + " bytes");
    const bool fits = count == 0 || (offset <= view_size && found.element_bytes <= view_size - offset &&
                                     count - 1 <= (view_size - offset - found.element_bytes) / found.stride);
    if (!fits) throw GltfFault(user + ": its " + std::to_string(count) + " elements do not fit into " + name);
    found.begin = view_begin + offset;
    return found;
}

bool GltfDocument::uses(std::string_view extension) const {
    const GltfJson& list = array("extensionsUsed");
    return std::find(list.begin(), list.end(), extension) != list.end();
}

std::size_t GltfDocument::count(GltfIndex index, const std::string& user) const {
    const std::string name = name_of("accessors", index);
    return whole(object("accessors", index, user), "count", name);
}

GltfNumbers GltfDocument::numbers(GltfIndex index, std::initializer_list<std::string_view> types,
                                  const std::string& user) const {
    const GltfJson& accessor = object("accessors", index, user);
    const std::string name = name_of("accessors", index);
    const Layout of = layout(accessor, name);
    const std::string type = accessor["type"].get<std::string>();
    if (std::find(types.begin(), types.end(), type) == types.end())
        throw GltfFault(user + ": " + name + " is of the type " + type + ", not " +
                        std::string(*types.begin()));
    const std::size_t total = whole(accessor, "count", name);
    GltfNumbers read{of.type, of.components, {}};
    const auto sparse = accessor.find("sparse");
    if (accessor.contains("bufferView")) {
        const Elements own = elements(accessor, of, total, name);
        read.numbers.reserve(total * of.components);
        for (std::size_t i = 0; i < total; ++i) {
            for (std::size_t k = 0; k < of.components; ++k)
                read.numbers.push_back(of.number(own.at(*this, i) + of.offset(k)));
        }
    } else { // 3.6.2.3: zeros
        constexpr std::size_t most_zeros = std::size_t{1} << 24;
        if (total > most_zeros / of.components)
            throw GltfFault(name + ": has " + std::to_string(total) + " elements and no bufferView");
        read.numbers.resize(total * of.components);
    }
    if (sparse == accessor.end()) return read;
    const std::size_t changed = whole(*sparse, "count", name + ", sparse");
    if (!sparse->contains("indices") || !sparse->contains("values"))
        throw GltfFault(name + ": \"sparse\" has no indices or no values");
    const GltfJson &of_indices = (*sparse)["indices"], &of_values = (*sparse)["values"];
    Layout index_layout =
        layout({{"type", "SCALAR"}, {"componentType", of_indices.value("componentType", 0u)}},
               name + ", sparse indices");
    const Elements places = elements(of_indices, index_layout, changed, name + ", sparse indices");
    const Elements values = elements(of_values, of, changed, name + ", sparse values");
    double before = -1;
    for (std::size_t i = 0; i < changed; ++i) {
        const double place = index_layout.number(places.at(*this, i));
        if (!(place < double(total)) || !(place > before))
            throw GltfFault(name + ": a sparse index is out of range or does not ascend");
        before = place;
        for (std::size_t k = 0; k < of.components; ++k)
            read.numbers[std::size_t(place) * of.components + k] =
                of.number(values.at(*this, i) + of.offset(k));
    }
    return read;
}

std::vector<std::uint32_t> GltfDocument::indices(GltfIndex index, const std::string& user) const {
    const Layout of = layout(object("accessors", index, user), name_of("accessors", index));
    if (of.type != 5121 && of.type != 5123 && of.type != 5125)
        throw GltfFault(user + ": " + name_of("accessors", index) + " does not hold unsigned integers");
    const GltfNumbers read = numbers(index, {"SCALAR"}, user);
    return {read.numbers.begin(), read.numbers.end()};
}

void GltfDocument::decode_views() {
    constexpr const char* extension = "EXT_meshopt_compression";
    const std::size_t views = array("bufferViews").size();
    bool is_any = false;
    for (std::size_t i = 0; i < views; ++i) {
        const std::string user = name_of("bufferViews", i);
        (void)object("bufferViews", i, user);
        GltfJson& view = json["bufferViews"][i];
        if (!view.contains("extensions") || !view["extensions"].contains(extension)) continue;
        is_any = true;
        const GltfJson packed = view["extensions"][extension];
        const std::size_t buffer = whole(packed, "buffer", user),
                          begin = whole(packed, "byteOffset", 0, user),
                          size = whole(packed, "byteLength", user);
        if (buffer >= buffers_.size() || begin > buffers_[buffer].bytes.size() ||
            size > buffers_[buffer].bytes.size() - begin)
            throw GltfFault(user + ": its compressed data are not in the file");
        const std::string filter = text_of(packed, "filter", user);
        const auto decoded = decode_meshopt(std::string_view(buffers_[buffer].bytes).substr(begin, size),
                                            whole(packed, "count", user), whole(packed, "byteStride", user),
                                            text_of(packed, "mode", user), filter.empty() ? "NONE" : filter);
        if (!decoded) throw GltfFault(user + ": " + decoded.error().message);
        const GltfJson fresh = json["bufferViews"][add_bytes(*decoded)];
        json["bufferViews"].erase(json["bufferViews"].size() - 1);
        GltfJson& changed = json["bufferViews"][i];
        for (const char* key : {"buffer", "byteOffset", "byteLength"}) changed[key] = fresh[key];
        changed["extensions"].erase(extension);
        if (changed["extensions"].empty()) changed.erase("extensions");
    }
    if (is_any) drop_extension(extension);
}

void GltfDocument::decode_primitives() {
    constexpr const char* extension = "KHR_draco_mesh_compression";
    bool is_any = false;
    for (std::size_t m = 0; m < array("meshes").size(); ++m) {
        (void)object("meshes", m, "the document");
        if (!json["meshes"][m].contains("primitives")) continue;
        GltfJson& primitives = json["meshes"][m]["primitives"];
        if (!primitives.is_array()) throw GltfFault(name_of("meshes", m) + ": has no list of primitives");
        for (std::size_t p = 0; p < primitives.size(); ++p) {
            GltfJson& primitive = primitives[p];
            if (!primitive.is_object() || !primitive.contains("extensions") ||
                !primitive["extensions"].contains(extension))
                continue;
            is_any = true;
            decode_primitive(primitive, name_of("meshes", m) + ", " + name_of("primitives", p));
        }
    }
    if (is_any) drop_extension(extension);
}

void GltfDocument::decode_primitive(GltfJson& primitive, const std::string& user) {
    constexpr const char* extension = "KHR_draco_mesh_compression";
    const GltfJson packed = primitive["extensions"][extension];
    const std::string view_name = user + ", " + extension;
    if (!packed.contains("attributes") || !packed["attributes"].is_object())
        throw GltfFault(view_name + ": \"attributes\" are missing");
    const GltfJson& view = object("bufferViews", whole(packed, "bufferView", view_name), view_name);
    Layout of_bytes;
    of_bytes.type = 5121;
    of_bytes.size = of_bytes.components = 1;
    const Elements bytes = elements(packed, of_bytes, whole(view, "byteLength", view_name), view_name);
    std::vector<DracoAccessor> wanted;
    std::vector<std::size_t> accessors;
    std::size_t vertices = 0;
    for (const auto& [name, id] : packed["attributes"].items()) {
        const std::size_t accessor = whole(primitive["attributes"], name.c_str(), user);
        const Layout of = layout(object("accessors", accessor, user), name_of("accessors", accessor));
        vertices = count(accessor, user);
        wanted.push_back(
            {std::uint32_t(whole(packed["attributes"], name.c_str(), view_name)), of.type, of.components});
        accessors.push_back(accessor);
    }
    const std::size_t index_accessor = whole(primitive, "indices", user);
    const auto decoded =
        decode_draco({bytes.at(*this, 0), bytes.count}, wanted, vertices, count(index_accessor, user));
    if (!decoded) throw GltfFault(view_name + ": " + decoded.error().message);
    for (std::size_t k = 0; k < accessors.size(); ++k) {
        GltfJson& accessor = json["accessors"][accessors[k]];
        const std::size_t bytes_each = decoded->attributes[k].size() / std::max<std::size_t>(vertices, 1);
        accessor["bufferView"] = add_view(decoded->attributes[k], bytes_each, Use::vertices);
        accessor.erase("byteOffset");
    }
    GltfJson& accessor = json["accessors"][index_accessor];
    const Layout of_indices = layout(accessor, name_of("accessors", index_accessor));
    std::string indices;
    for (const std::uint32_t index : decoded->indices) {
        if (of_indices.size < 4 && index >> 8 * of_indices.size != 0)
            throw GltfFault(view_name + ": an index exceeds the componentType of " +
                            name_of("accessors", index_accessor));
        indices.append(reinterpret_cast<const char*>(&index), of_indices.size);
    }
    accessor["bufferView"] = add_view(indices, of_indices.size, Use::indices);
    accessor.erase("byteOffset");
    primitive["extensions"].erase(extension);
    if (primitive["extensions"].empty()) primitive.erase("extensions");
}

void GltfDocument::drop_extension(const char* extension) {
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
        if (!json.contains(list)) continue;
        GltfJson& names = json[list];
        names.erase(std::remove(names.begin(), names.end(), extension), names.end());
        if (names.empty()) json.erase(list);
    }
    repacks_ = true;
}

GltfIndex GltfDocument::add_bytes(std::string_view contents) {
    return add_view(contents, 0, Use::other);
}

GltfIndex GltfDocument::add_view(std::string_view bytes, std::size_t element_bytes, Use use) {
    if (added_ == gltf_none) { // the first buffer that is not a fallback without data
        for (added_ = 0; added_ < buffers_.size() && buffers_[added_].bytes.empty();) ++added_;
        if (added_ >= buffers_.size()) {
            added_ = buffers_.size();
            buffers_.emplace_back();
            json["buffers"].push_back({{"byteLength", 0}});
        }
    }
    Buffer& buffer = buffers_[added_];
    const std::size_t begin = (buffer.bytes.size() + 3) / 4 * 4; // 3.6.2.4
    // vertex attributes begin at multiples of four
    const std::size_t padded = use == Use::vertices ? (element_bytes + 3) / 4 * 4 : element_bytes;
    GltfJson view = {{"buffer", added_}, {"byteOffset", begin}, {"byteLength", bytes.size()}};
    buffer.bytes.resize(begin);
    if (padded == element_bytes) {
        buffer.bytes.append(bytes);
    } else {
        for (std::size_t at = 0; at < bytes.size(); at += element_bytes) {
            buffer.bytes.append(bytes.substr(at, element_bytes));
            buffer.bytes.append(padded - element_bytes, '\0');
        }
        view["byteLength"] = buffer.bytes.size() - begin;
    }
    buffer.is_changed = true;
    if (use == Use::vertices) view["byteStride"] = padded;
    if (use != Use::other) view["target"] = int(use);
    return append("bufferViews", std::move(view));
}

/// Whether elements with one stride alternate, such as positions and normals of interleaved vertices.
bool GltfDocument::Elements::alternate_with(const Elements& other) const {
    const std::size_t a = begin % stride, b = other.begin % stride;
    return stride == other.stride && (a + element_bytes <= b || b + other.element_bytes <= a) &&
           a + element_bytes <= stride + b && b + other.element_bytes <= stride + a;
}

void GltfDocument::find_shared() {
    constexpr std::size_t most_open = 64; // if more accessors overlap, all of them count as shared
    const GltfJson& all = array("accessors");
    std::vector<std::pair<Elements, std::size_t>> sorted;
    is_shared_.assign(all.size(), false);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::string name = name_of("accessors", i);
        is_shared_[i] = !all[i].is_object() || !all[i].contains("bufferView");
        if (is_shared_[i]) continue;
        const Elements own = elements(all[i], layout(all[i], name), whole(all[i], "count", name), name);
        if (own.count > 0) sorted.push_back({own, i});
    }
    std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
        return std::pair(a.first.buffer, a.first.begin) < std::pair(b.first.buffer, b.first.begin);
    });
    std::vector<std::size_t> open;               // of `sorted`: elements that end after the current begin
    std::pair<std::size_t, std::size_t> crowded; // buffer and end of accessors left out of `open`
    for (std::size_t n = 0; n < sorted.size(); ++n) {
        const auto& [own, accessor] = sorted[n];
        const std::size_t begin = own.begin, buffer = own.buffer;
        open.erase(std::remove_if(open.begin(), open.end(),
                                  [&](std::size_t o) {
                                      return sorted[o].first.buffer != buffer ||
                                             sorted[o].first.end() <= begin;
                                  }),
                   open.end());
        const bool is_crowded = crowded.first == buffer && begin < crowded.second;
        if (is_crowded) is_shared_[accessor] = true;
        for (const std::size_t o : open) {
            if (open.size() < most_open && own.alternate_with(sorted[o].first)) continue;
            is_shared_[accessor] = is_shared_[sorted[o].second] = true;
        }
        open.push_back(n);
        if (open.size() <= most_open) continue;
        std::size_t end = is_crowded ? crowded.second : 0;
        for (const std::size_t o : open) end = std::max(end, sorted[o].first.end());
        crowded = {buffer, end};
        open.clear();
    }
}

bool GltfDocument::overwrite(GltfIndex index, std::string_view values, std::size_t element_bytes) {
    if (is_shared_.empty()) find_shared();
    const GltfJson& accessor = json["accessors"][index];
    const std::string name = name_of("accessors", index);
    const Layout of = layout(accessor, name);
    const std::size_t total = whole(accessor, "count", name);
    if (index >= is_shared_.size() || is_shared_[index] || accessor.contains("sparse") || of.type != 5126 ||
        of.bytes() != element_bytes || total * element_bytes != values.size())
        return false;
    const Elements own = elements(accessor, of, total, name);
    Buffer& buffer = buffers_[own.buffer];
    for (std::size_t i = 0; i < total; ++i) {
        char* const at = buffer.bytes.data() + own.begin + i * own.stride;
        if (std::memcmp(at, values.data() + i * element_bytes, element_bytes) == 0) continue;
        std::memcpy(at, values.data() + i * element_bytes, element_bytes);
        buffer.is_changed = true;
    }
    return true;
}

FileError json_error(const std::string& path, const GltfJson::exception& fault) {
    const std::string_view text = fault.what(); // "[json.exception.parse_error.101] parse error at line 1, …"
    const bool is_syntax = text.find(".parse_error.") != std::string_view::npos;
    return {
        path + ": is not a valid glTF document" +
        (is_syntax ? ": " + std::string(text.substr(text.find(']') + 2)) : ": a property has a wrong type")};
}

} // namespace cageform_support
