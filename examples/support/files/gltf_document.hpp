#pragma once

// glTF 2.0 documents: JSON and buffers, read from .gltf or .glb files or made by a program.
//
// The JSON is kept as it is, so that a document can be changed in part and written again. tinygltf would
// rebuild it from its own classes: unknown properties, their order and encoded images would be lost.
// Section numbers refer to the glTF 2.0 specification.

#include "files/mesh_file.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace cageform_support {

using GltfJson = nlohmann::ordered_json;

/// An error in a document. The functions of GltfDocument throw it; parse_gltf() and others that return
/// Expected catch it.
struct GltfFault : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Index of an object in an array of the document.
using GltfIndex = std::size_t;
inline constexpr GltfIndex gltf_none = ~std::size_t{0};
/// The value of a JSON number that is an integer and at least 0; nothing for other values.
inline std::optional<GltfIndex> gltf_index(const GltfJson& value) {
    const bool is_index =
        value.is_number_integer() && (value.is_number_unsigned() || value.get<std::int64_t>() >= 0);
    return is_index ? std::optional(value.get<GltfIndex>()) : std::nullopt;
}

/// The elements of an accessor.
struct GltfNumbers {
    int component_type = 0;      ///< as in the file (5.1.3)
    std::size_t components = 0;  ///< per element
    std::vector<double> numbers; ///< #elements · components; normalised integers are in [0, 1] or [-1, 1]
    std::size_t count() const { return components == 0 ? 0 : numbers.size() / components; }
};

class GltfDocument {
public:
    enum class Use : std::uint16_t { vertices = 34962, indices = 34963, other = 0 }; // 5.11.5

    GltfJson json;

    /// A new document.
    explicit GltfDocument(const std::string& generator)
        : json{{"asset", {{"version", "2.0"}, {"generator", generator}}}} {}

    /// Parses the contents of a .gltf or .glb file and reads its buffers. Buffers may be embedded, data URIs,
    /// or files in the folder of `path` and its subfolders. Compressed buffer views and primitives
    /// (EXT_meshopt_compression, KHR_draco_mesh_compression) are decoded.
    ///
    ///   path    of the file, and prefix of messages
    ///   fails   on invalid containers, JSON and buffers, and if a required extension is not supported
    static Expected<GltfDocument> parse(std::string bytes, const std::string& path);

    // ---- reading; these functions throw GltfFault ----

    /// The array of the root object; empty if there is none.
    const GltfJson& array(const char* name) const;
    /// An object of an array of the root; `user` names the object that refers to it.
    const GltfJson& object(const char* array_name, GltfIndex index, const std::string& user) const;
    /// The numbers of an accessor.
    ///
    ///   types   the allowed types, such as "VEC3"
    GltfNumbers numbers(GltfIndex accessor, std::initializer_list<std::string_view> types,
                        const std::string& user) const;
    /// The elements of an accessor of unsigned integers.
    std::vector<std::uint32_t> indices(GltfIndex accessor, const std::string& user) const;
    /// Number of elements of an accessor.
    std::size_t count(GltfIndex accessor, const std::string& user) const;

    /// Whether "extensionsUsed" names an extension.
    bool uses(std::string_view extension) const;
    std::size_t file_size() const { return file_size_; } ///< in bytes, without other files

    // ---- writing ----

    /// Appends an accessor with N numbers per element and its own buffer view; returns its index.
    ///
    ///   bounds   whether to write min and max of each component, as for positions and times
    template <class T, std::size_t N>
    GltfIndex add(std::span<const std::array<T, N>> values, Use use, bool bounds = false,
                  bool normalised = false) {
        GltfJson accessor = {{"bufferView", add_view(values, use)},
                             {"componentType", component_type<T>()},
                             {"count", values.size()},
                             {"type", type_of(N)}};
        if (normalised) accessor["normalized"] = true;
        if (bounds) set_bounds(accessor, values);
        return append("accessors", std::move(accessor));
    }
    template <class T, std::size_t N>
    GltfIndex add(const std::vector<std::array<T, N>>& values, Use use, bool bounds = false,
                  bool normalised = false) {
        return add(std::span<const std::array<T, N>>(values), use, bounds, normalised);
    }

    /// Appends raw bytes, such as an image, with their own buffer view; returns its index.
    GltfIndex add_bytes(std::string_view contents);

    /// Appends to an array of the root object; returns the index.
    GltfIndex append(const char* array_name, GltfJson value) {
        json[array_name].push_back(std::move(value));
        return json[array_name].size() - 1;
    }

    /// Replaces the elements of an accessor by floats. Floats whose bytes no other accessor uses are replaced
    /// in place; other elements get a new buffer view. Sets min and max if the accessor has them.
    template <std::size_t N>
    void replace(GltfIndex accessor, std::span<const std::array<float, N>> values, Use use) {
        GltfJson& own = json["accessors"][accessor];
        if (!overwrite(accessor, {reinterpret_cast<const char*>(values.data()), values.size_bytes()},
                       4 * N)) {
            own["bufferView"] = add_view(values, use);
            own["componentType"] = component_type<float>();
            for (const char* key : {"byteOffset", "normalized", "sparse"}) own.erase(key);
        }
        if (own.contains("min") || own.contains("max")) set_bounds(own, values);
    }

    /// The files of the document: one, and for .gltf also its buffers, unless they are data URIs.
    ///
    ///   path    of the output, .gltf or .glb
    ///   fails   if the buffers are larger than largest_mesh_file, or an image cannot be copied
    Expected<std::vector<WrittenFile>> files(const std::filesystem::path& path) const;

private:
    struct Buffer {
        std::string bytes;
        std::string uri;      // of a file; empty: embedded
        bool is_data = false; // embedded as a data URI
        bool is_changed = false;
    };
    /// Position of an accessor's elements in a buffer.
    struct Elements {
        std::size_t buffer = 0, begin = 0, stride = 0, count = 0, element_bytes = 0;
        std::size_t end() const { return begin + (count - 1) * stride + element_bytes; }
        bool alternate_with(const Elements& other) const;
        const char* at(const GltfDocument& document, std::size_t i) const {
            return document.buffers_[buffer].bytes.data() + begin + i * stride;
        }
    };
    struct Layout; // component type and number of components of an accessor

    GltfDocument() = default;
    void read_container(std::string bytes);
    void load_buffers();
    void load_buffer(const GltfJson& buffer, std::size_t index);
    std::string read_beside(const std::string& uri, const std::string& user) const;
    void check_extensions() const;
    void decode_views();
    void decode_primitives();
    void decode_primitive(GltfJson& primitive, const std::string& user);
    void drop_extension(const char* extension);
    Layout layout(const GltfJson& accessor, const std::string& user) const;
    Elements elements(const GltfJson& view_holder, const Layout& layout, std::size_t count,
                      const std::string& user) const;
    bool overwrite(GltfIndex accessor, std::string_view values, std::size_t element_bytes);
    void find_shared();
    GltfIndex add_view(std::string_view bytes, std::size_t element_bytes, Use use);
    template <class T, std::size_t N>
    GltfIndex add_view(std::span<const std::array<T, N>> values, Use use) {
        static_assert(std::endian::native == std::endian::little, "glTF is little-endian");
        return add_view({reinterpret_cast<const char*>(values.data()), values.size_bytes()},
                        sizeof(std::array<T, N>), use);
    }
    std::string json_text(const GltfJson& whole_json, int new_indent) const;
    std::string packed_bytes(GltfJson& whole_json) const;
    std::vector<WrittenFile> copied_images(const std::filesystem::path& path, GltfJson& whole_json) const;
    std::vector<WrittenFile> glb_files(const std::filesystem::path& path, GltfJson whole_json) const;
    void write_buffers(std::size_t first, const std::filesystem::path& path, GltfJson& whole_json,
                       std::vector<WrittenFile>& files) const;
    std::vector<WrittenFile> gltf_files(const std::filesystem::path& path, GltfJson whole_json) const;

    static const char* type_of(std::size_t components) {
        return components == 1   ? "SCALAR"
               : components == 2 ? "VEC2"
               : components == 3 ? "VEC3"
               : components == 4 ? "VEC4"
                                 : "MAT4";
    }
    template <class T>
    static int component_type() {
        if constexpr (std::is_same_v<T, float>) {
            return 5126;
        } else {
            static_assert(std::is_unsigned_v<T>);
            return sizeof(T) == 1 ? 5121 : sizeof(T) == 2 ? 5123 : 5125;
        }
    }
    template <class T, std::size_t N>
    static void set_bounds(GltfJson& accessor, std::span<const std::array<T, N>> values) {
        GltfJson low = GltfJson::array(), high = GltfJson::array();
        for (std::size_t k = 0; k < N; ++k) {
            const auto [least, most] = std::minmax_element(
                values.begin(), values.end(), [k](const auto& a, const auto& b) { return a[k] < b[k]; });
            low.push_back((*least)[k]);
            high.push_back((*most)[k]);
        }
        accessor["min"] = std::move(low);
        accessor["max"] = std::move(high);
    }

    std::string path_;
    std::string text_; // JSON of the file as read
    bool is_binary_ = false;
    std::size_t file_size_ = 0;
    std::vector<Buffer> buffers_;
    std::size_t added_ = gltf_none; // index of the buffer for new data; gltf_none if there is none yet
    bool repacks_ = false;          // whether buffers hold compressed data, which are not written
    std::vector<bool> is_shared_;   // #accessors: whether others use the same bytes; empty before replace()
};

namespace detail {

/// Decodes percent-encoded bytes of a URI, such as %41 (RFC 3986, section 2.1).
std::string percent_decoded(std::string_view uri);

/// Whether a URI has a scheme, such as "https:", and is therefore no path.
bool has_scheme(const std::string& uri);

} // namespace detail

/// The error of nlohmann-json in a document, without its codes.
FileError json_error(const std::string& path, const GltfJson::exception& fault);

/// Adds the files of a document to the outputs. Returns the sum of their bytes; fails as
/// GltfDocument::files().
Expected<std::size_t> save_gltf(const GltfDocument& document, const std::string& path, OutputFiles& outputs);

} // namespace cageform_support
