#include "files/gltf_compression.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <exception>
#include <limits>
#include <utility>

#ifdef CAGEFORM_HAS_MESHOPT
#include <meshoptimizer.h>
#endif
#ifdef CAGEFORM_HAS_DRACO
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#endif

namespace cageform_support {

namespace {

[[maybe_unused]] FileError unsupported(const std::string& extension, const std::string& library) {
    return {extension + " is not supported by this build (" + library +
            "); decompress the file with \"npx @gltf-transform/cli copy in.glb out.glb\""};
}

} // namespace

// ---- EXT_meshopt_compression ----------------------------------------------------------------------

#ifdef CAGEFORM_HAS_MESHOPT

namespace {

/// The checks that the library leaves to assertions or to its caller. Returns an empty text, or an error.
std::string meshopt_fault(std::size_t count, std::size_t stride, const std::string& mode,
                          const std::string& filter) {
    const std::string bytes = std::to_string(stride);
    if (mode == "ATTRIBUTES") {
        if (stride == 0 || stride > 256 || stride % 4 != 0)
            return "byteStride " + bytes + " is not 4, 8, … 256, as the mode ATTRIBUTES requires";
        if (filter == "OCTAHEDRAL" && stride != 4 && stride != 8)
            return "byteStride " + bytes + " is not 4 or 8, as the filter OCTAHEDRAL requires";
        if (filter == "QUATERNION" && stride != 8)
            return "byteStride " + bytes + " is not 8, as the filter QUATERNION requires";
        if (filter != "NONE" && filter != "OCTAHEDRAL" && filter != "QUATERNION" && filter != "EXPONENTIAL")
            return "unknown filter \"" + filter + "\"";
        return {};
    }
    if (mode != "TRIANGLES" && mode != "INDICES") return "unknown mode \"" + mode + "\"";
    if (stride != 2 && stride != 4)
        return "byteStride " + bytes + " is not 2 or 4, as the mode " + mode + " requires";
    if (filter != "NONE")
        return "the mode " + mode + " takes no filter, but the filter is \"" + filter + "\"";
    if (mode == "TRIANGLES" && count % 3 != 0)
        return "count " + std::to_string(count) + " is not a multiple of 3, as the mode TRIANGLES requires";
    return {};
}

/// The most elements that a stream of a size can hold (appendix A of the extension: bitstreams). Attributes
/// take at least two bits per 16 bytes of equal position in their elements, a triangle and an index one byte.
std::size_t most_elements(std::size_t source, std::size_t stride, const std::string& mode) {
    if (mode == "TRIANGLES") return source < 17 ? 0 : 3 * std::min(source - 17, SIZE_MAX / 3);
    if (mode == "INDICES") return source < 5 ? 0 : source - 5;
    const std::size_t frame = 1 + std::max<std::size_t>(32, stride); // header and tail
    return source < frame ? 0 : (source - frame) / stride * 64;
}

int decode_meshopt_stream(std::string& bytes, std::string_view source, std::size_t count, std::size_t stride,
                          const std::string& mode) {
    const auto* from = reinterpret_cast<const unsigned char*>(source.data());
    if (mode == "ATTRIBUTES") {
        constexpr unsigned char version_0 =
            0xa0; // the only one of the extension; the library may know others
        if (from[0] != version_0) return -1;
        return meshopt_decodeVertexBuffer(bytes.data(), count, stride, from, source.size());
    }
    if (mode == "TRIANGLES")
        return meshopt_decodeIndexBuffer(bytes.data(), count, stride, from, source.size());
    return meshopt_decodeIndexSequence(bytes.data(), count, stride, from, source.size());
}

} // namespace

bool has_meshopt() {
    return true;
}

Expected<std::string> decode_meshopt(std::string_view source, std::size_t count, std::size_t stride,
                                     const std::string& mode, const std::string& filter) {
    if (std::string fault = meshopt_fault(count, stride, mode, filter); !fault.empty())
        return FileError{std::move(fault)};
    if (source.empty() || count > most_elements(source.size(), stride, mode))
        return FileError{"the meshopt stream of " + std::to_string(source.size()) +
                         " bytes is too short for " + std::to_string(count) + " elements"};
    std::string bytes;
    try {
        bytes.resize(count * stride);
    } catch (const std::exception&) {
        return FileError{std::to_string(count) + " elements of the meshopt stream do not fit in memory"};
    }
    if (decode_meshopt_stream(bytes, source, count, stride, mode) != 0)
        return FileError{"the meshopt stream is broken, or does not hold " + std::to_string(count) +
                         " elements"};
    if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), count, stride);
    if (filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), count, stride);
    if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), count, stride);
    return bytes;
}

#else

bool has_meshopt() {
    return false;
}

Expected<std::string> decode_meshopt(std::string_view, std::size_t, std::size_t, const std::string&,
                                     const std::string&) {
    return unsupported("EXT_meshopt_compression", "libmeshoptimizer");
}

#endif

// ---- KHR_draco_mesh_compression -------------------------------------------------------------------

#ifdef CAGEFORM_HAS_DRACO

namespace {

/// What a stream must hold, and why it does not.
struct DracoExpectation {
    std::size_t vertices = 0, triangles = 0, bytes = 0;
    std::string fault;

    /// Whether a stream of this size can hold so many numbers. Draco allocates about ten bytes per number
    /// that its headers count. Long runs of equal values take no bytes: a level grid of a million vertices
    /// has 50 numbers per byte. Other meshes have about 10.
    bool plausible(std::uint64_t numbers) {
        constexpr std::uint64_t any_stream = 1 << 24, per_byte = 64;
        constexpr std::uint64_t most = 1 << 28; // the library computes offsets of eight-byte numbers as int
        if (numbers > any_stream && (numbers - any_stream) / per_byte > bytes)
            fault = "the Draco stream of " + std::to_string(bytes) + " bytes is too short for its counts";
        else if (numbers >= most)
            fault = "the Draco stream is too large for its decoder";
        return fault.empty();
    }
    bool equal(const char* what, std::size_t in_stream, std::size_t in_accessors) {
        if (in_stream != in_accessors)
            fault = "the Draco stream has " + std::to_string(in_stream) + ' ' + what +
                    ", but its accessors have " + std::to_string(in_accessors);
        return fault.empty();
    }
};

/// A decoder that checks counts before the library allocates memory for them.
template <class Decoder>
class CheckedDracoDecoder : public Decoder {
public:
    explicit CheckedDracoDecoder(DracoExpectation& expected)
        : expected_(expected) {}

protected:
    bool InitializeDecoder() override {
        if (!Decoder::InitializeDecoder()) return false;
        if constexpr (std::is_same_v<Decoder, draco::MeshSequentialDecoder>) {
            return true; // its counts are compared with the stream's size by the library
        } else {
            draco::DecoderBuffer ahead = *this->buffer();
            std::uint32_t vertices = 0, triangles = 0;
            std::uint8_t attribute_tables = 0; // each has a number per corner
            return draco::DecodeVarint(&vertices, &ahead) && draco::DecodeVarint(&triangles, &ahead) &&
                   ahead.Decode(&attribute_tables) &&
                   expected_.equal("triangles", triangles, expected_.triangles) &&
                   expected_.plausible(std::uint64_t(triangles) * 3 * (1u + attribute_tables));
        }
    }
    bool DecodeGeometryData() override {
        return Decoder::DecodeGeometryData() &&
               expected_.equal("triangles", this->mesh()->num_faces(), expected_.triangles) &&
               expected_.equal("vertices", this->mesh()->num_points(), expected_.vertices);
    }
    bool DecodeAllAttributes() override {
        std::uint64_t components = 0;
        for (int k = 0; k < this->mesh()->num_attributes(); ++k)
            components += this->mesh()->attribute(k)->num_components();
        return expected_.plausible(components * expected_.vertices) && Decoder::DecodeAllAttributes();
    }

private:
    DracoExpectation& expected_;
};

bool skip_bytes(draco::DecoderBuffer& buffer, std::uint64_t bytes) {
    if (bytes > std::uint64_t(buffer.remaining_size())) return false;
    buffer.Advance(std::int64_t(bytes));
    return true;
}

bool skip_metadata_name(draco::DecoderBuffer& buffer) {
    std::uint8_t bytes = 0;
    return buffer.Decode(&bytes) && skip_bytes(buffer, bytes);
}

/// Skips a tree of entries, whose nodes are in depth-first order.
bool skip_metadata_tree(draco::DecoderBuffer& buffer) {
    std::uint64_t nodes = 1;
    for (std::uint64_t node = 0; node < nodes; ++node) {
        std::uint32_t entries = 0, children = 0, bytes = 0;
        if (node > 0 && !skip_metadata_name(buffer)) return false;
        if (!draco::DecodeVarint(&entries, &buffer)) return false;
        for (std::uint32_t k = 0; k < entries; ++k) {
            if (!skip_metadata_name(buffer) || !draco::DecodeVarint(&bytes, &buffer) ||
                !skip_bytes(buffer, bytes))
                return false;
        }
        if (!draco::DecodeVarint(&children, &buffer)) return false;
        nodes += children;
    }
    return true;
}

/// Skips the metadata of attributes and of the mesh. The library's reader takes memory in proportion to the
/// depth times the size, and glTF has no use for metadata.
bool skip_metadata(draco::DecoderBuffer& buffer) {
    std::uint32_t attributes = 0, id = 0;
    if (!draco::DecodeVarint(&attributes, &buffer)) return false;
    for (std::uint32_t k = 0; k < attributes; ++k) {
        if (!draco::DecodeVarint(&id, &buffer) || !skip_metadata_tree(buffer)) return false;
    }
    return skip_metadata_tree(buffer);
}

constexpr std::size_t draco_header = 11; // bytes: "DRACO", version (2), type, method, flags (2)

/// The stream without its metadata. Fails for a stream that is not a mesh of version 2.2.
Expected<std::string> without_metadata(std::string_view source) {
    if (source.size() < draco_header || !source.starts_with("DRACO"))
        return FileError{"the Draco stream has no header"};
    if (source.size() > std::size_t(std::numeric_limits<std::int32_t>::max()))
        return FileError{"the Draco stream is larger than 2 GB"};
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(source[k]); };
    if (byte(5) != draco::kDracoMeshBitstreamVersionMajor ||
        byte(6) != draco::kDracoMeshBitstreamVersionMinor)
        return FileError{"the Draco stream has version " + std::to_string(byte(5)) + '.' +
                         std::to_string(byte(6)) + ", not 2.2"};
    if (byte(7) != draco::TRIANGULAR_MESH || byte(8) > draco::MESH_EDGEBREAKER_ENCODING)
        return FileError{"the Draco stream is not a mesh of triangles"};
    std::string stream(source.substr(0, draco_header));
    constexpr unsigned char metadata_flag = METADATA_FLAG_MASK >> 8; // in the last byte
    if ((byte(draco_header - 1) & metadata_flag) != 0) {
        stream.back() = static_cast<char>(byte(draco_header - 1) & ~metadata_flag);
        draco::DecoderBuffer buffer;
        buffer.Init(source.data(), source.size(), draco::kDracoMeshBitstreamVersion);
        buffer.Advance(draco_header);
        if (!skip_metadata(buffer)) return FileError{"the metadata of the Draco stream is broken"};
        source.remove_prefix(std::size_t(buffer.decoded_size()) - draco_header);
    }
    stream += source.substr(draco_header);
    return stream;
}

template <class Decoder>
bool decode_mesh(const std::string& stream, DracoExpectation& expected, draco::Mesh& mesh) {
    draco::DecoderBuffer buffer;
    buffer.Init(stream.data(), stream.size());
    const draco::DecoderOptions options;
    CheckedDracoDecoder<Decoder> decoder(expected);
    return decoder.Decode(options, &buffer, &mesh).ok();
}

/// Appends the values of the vertices as numbers of type T. Fails if a number is outside the range of T.
template <class T>
bool append_values(const draco::PointAttribute& from, std::size_t vertices, std::string& bytes) {
    static_assert(std::endian::native == std::endian::little, "glTF is little-endian");
    constexpr bool is_float = std::is_floating_point_v<T>;
    using Wide = std::conditional_t<is_float, T, std::int64_t>; // the library converts signs without a check
    const std::size_t components = from.num_components();
    std::vector<Wide> values(components);
    bytes.resize(vertices * components * sizeof(T));
    char* to = bytes.data();
    for (std::size_t vertex = 0; vertex < vertices; ++vertex) {
        const auto value = from.mapped_index(draco::PointIndex(std::uint32_t(vertex)));
        if (value.value() >= from.size() ||
            !from.ConvertValue<Wide>(value, static_cast<std::int8_t>(components), values.data()))
            return false;
        for (const Wide number : values) {
            if constexpr (!is_float) {
                if (!std::in_range<T>(number)) return false;
            }
            const T typed = static_cast<T>(number);
            std::memcpy(to, &typed, sizeof(T));
            to += sizeof(T);
        }
    }
    return true;
}

bool append_values(int component_type, const draco::PointAttribute& from, std::size_t vertices,
                   std::string& bytes) {
    switch (component_type) {
    case 5120: return append_values<std::int8_t>(from, vertices, bytes);
    case 5121: return append_values<std::uint8_t>(from, vertices, bytes);
    case 5122: return append_values<std::int16_t>(from, vertices, bytes);
    case 5123: return append_values<std::uint16_t>(from, vertices, bytes);
    case 5125: return append_values<std::uint32_t>(from, vertices, bytes);
    case 5126: return append_values<float>(from, vertices, bytes);
    default: return false;
    }
}

/// The values of an accessor.
Expected<std::string> attribute_bytes(const draco::Mesh& mesh, const DracoAccessor& accessor) {
    const std::string name = "attribute " + std::to_string(accessor.unique_id) + " of the Draco stream";
    const draco::PointAttribute* const from = mesh.GetAttributeByUniqueId(accessor.unique_id);
    if (from == nullptr) return FileError{name + " does not exist"};
    if (from->num_components() != accessor.components)
        return FileError{name + " has " + std::to_string(from->num_components()) +
                         " components, but its accessor has " + std::to_string(accessor.components)};
    const bool in_floats = from->data_type() == draco::DT_FLOAT32;
    if (from->data_type() > draco::DT_UINT32 && !in_floats)
        return FileError{name + " holds numbers that glTF does not have"};
    if (in_floats && accessor.component_type != 5126)
        return FileError{name + " holds floats, but its accessor holds integers"};
    const bool mapped = from->is_mapping_identity() || from->indices_map_size() >= mesh.num_points();
    std::string bytes;
    if (!mapped || !append_values(accessor.component_type, *from, mesh.num_points(), bytes))
        return FileError{name + " holds numbers outside the range of its accessor's componentType"};
    return bytes;
}

/// As decode_draco(). The library may throw, such as std::bad_alloc.
Expected<DracoPrimitive> decode_primitive(std::string_view source, std::span<const DracoAccessor> accessors,
                                          std::size_t vertices, std::size_t indices) {
    const auto stream = without_metadata(source);
    if (!stream) return stream.error();
    DracoExpectation expected{vertices, indices / 3, stream->size(), {}};
    draco::Mesh mesh;
    const bool edgebreaker = (*stream)[8] == draco::MESH_EDGEBREAKER_ENCODING;
    if (!(edgebreaker ? decode_mesh<draco::MeshEdgebreakerDecoder>(*stream, expected, mesh)
                      : decode_mesh<draco::MeshSequentialDecoder>(*stream, expected, mesh)))
        return FileError{expected.fault.empty() ? "the Draco stream is broken" : expected.fault};
    DracoPrimitive primitive;
    primitive.indices.reserve(indices);
    for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
        for (const draco::PointIndex& vertex : mesh.face(face)) {
            if (vertex.value() >= vertices)
                return FileError{"the Draco stream has an index " + std::to_string(vertex.value()) +
                                 ", but only " + std::to_string(vertices) + " vertices"};
            primitive.indices.push_back(vertex.value());
        }
    }
    for (const DracoAccessor& accessor : accessors) {
        auto bytes = attribute_bytes(mesh, accessor);
        if (!bytes) return bytes.error();
        primitive.attributes.push_back(std::move(*bytes));
    }
    return primitive;
}

} // namespace

bool has_draco() {
    return true;
}

Expected<DracoPrimitive> decode_draco(std::string_view source, std::span<const DracoAccessor> accessors,
                                      std::size_t vertices, std::size_t indices) {
    if (indices % 3 != 0)
        return FileError{std::to_string(indices) + " indices of a Draco stream are not triangles"};
    try {
        return decode_primitive(source, accessors, vertices, indices);
    } catch (const std::exception&) {
        return FileError{"the Draco stream is broken, or does not fit in memory"};
    }
}

#else

bool has_draco() {
    return false;
}

Expected<DracoPrimitive> decode_draco(std::string_view, std::span<const DracoAccessor>, std::size_t,
                                      std::size_t) {
    return unsupported("KHR_draco_mesh_compression", "libdraco");
}

#endif

} // namespace cageform_support
