// Compressed glTF: what the libraries encode is decoded; broken streams are refused or decoded, within bounds of memory.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include "files/gltf_compression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#ifdef CAGEFORM_HAS_MESHOPT
#include <meshoptimizer.h>
#endif
#ifdef CAGEFORM_HAS_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#endif

namespace gltf_compression_tests {

using namespace cageform_support;
using cageform_tests::Random;

namespace {

template <class T>
T number_at(const std::string& bytes, std::size_t k) {
    T number;
    std::memcpy(&number, bytes.data() + k * sizeof(T), sizeof(T));
    return number;
}

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// The triangles, each turned so that its indices are the least in lexicographic order.
[[maybe_unused]] Triangles turned(Triangles triangles) {
    for (auto& t : triangles) t = std::min({t, {t[1], t[2], t[0]}, {t[2], t[0], t[1]}});
    return triangles;
}
[[maybe_unused]] Triangles sorted(Triangles triangles) {
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

/// Changes up to four random bytes, or cuts the end off.
[[maybe_unused]] std::string damaged(std::string stream, Random& random) {
    for (std::size_t n = 1 + random.below(4); n-- > 0;) {
        // Half of the changes are in the first bytes, which hold the counts.
        const std::size_t place =
            random.below(random.below(2) == 0 ? std::min<std::size_t>(40, stream.size()) : stream.size());
        stream[place] = static_cast<char>(random.below(2) == 0 ? random.bits() : 255 * random.below(2));
    }
    if (random.below(8) == 0) stream.resize(random.below(stream.size()));
    return stream;
}

} // namespace

TEST_CASE("a build without a library refuses its files and names a command", "[examples][gltf]") {
    if (!has_draco()) {
        const auto refused = decode_draco("DRACO", {}, 3, 3);
        REQUIRE(!refused);
        CHECK_THAT(refused.error().message,
                   containing("KHR_draco_mesh_compression is not supported by this build"));
    }
    if (!has_meshopt()) {
        const auto refused = decode_meshopt("", 3, 4, "ATTRIBUTES", "NONE");
        REQUIRE(!refused);
        CHECK_THAT(refused.error().message,
                   containing("EXT_meshopt_compression is not supported by this build"));
    }
}

#ifdef CAGEFORM_HAS_MESHOPT

namespace {

/// A random buffer view, and its stream.
struct MeshoptView {
    std::string mode, stream, bytes;
    std::size_t count, stride;

    explicit MeshoptView(Random& random)
        : mode(std::array{"ATTRIBUTES", "TRIANGLES", "INDICES"}[random.below(3)]) {
        if (mode == "ATTRIBUTES") {
            stride = 4 * (1 + random.below(64));
            count = 1 + random.below(600);
            bytes.resize(count * stride);
            const std::size_t range = std::size_t(1) << random.below(9); // smooth or noisy
            for (std::size_t k = 0; k < bytes.size(); ++k)
                bytes[k] =
                    static_cast<char>(std::size_t(k < stride ? 0 : bytes[k - stride]) + random.below(range));
            stream.resize(meshopt_encodeVertexBufferBound(count, stride));
            stream.resize(meshopt_encodeVertexBuffer(data(), stream.size(), bytes.data(), count, stride));
            return;
        }
        stride = 2 + 2 * random.below(2);
        count = 3 * (1 + random.below(400));
        const std::size_t vertices = 3 + random.below(stride == 2 ? 60000 : 1000000);
        std::vector<unsigned> indices(count);
        for (std::size_t k = 0; k < count; ++k)
            indices[k] = unsigned(random.below(3) == 0 ? random.below(vertices) : k / 2 % vertices);
        const bool triangles = mode == "TRIANGLES";
        stream.resize(triangles ? meshopt_encodeIndexBufferBound(count, vertices)
                                : meshopt_encodeIndexSequenceBound(count, vertices));
        stream.resize(triangles ? meshopt_encodeIndexBuffer(data(), stream.size(), indices.data(), count)
                                : meshopt_encodeIndexSequence(data(), stream.size(), indices.data(), count));
        for (const unsigned index : indices) bytes.append(reinterpret_cast<const char*>(&index), stride);
    }

private:
    unsigned char* data() { return reinterpret_cast<unsigned char*>(stream.data()); }
};

/// The triangles of a decoded view. The encoder turns them.
Triangles triangles_of(const std::string& bytes, std::size_t stride) {
    Triangles triangles(bytes.size() / stride / 3);
    for (std::size_t k = 0; k < 3 * triangles.size(); ++k)
        triangles[k / 3][k % 3] =
            stride == 2 ? number_at<std::uint16_t>(bytes, k) : number_at<std::uint32_t>(bytes, k);
    return turned(triangles);
}

} // namespace

TEST_CASE("meshopt streams are decoded to the encoded bytes", "[examples][gltf]") {
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const MeshoptView view(random);
        CAPTURE(view.mode, view.count, view.stride);
        const auto decoded = decode_meshopt(view.stream, view.count, view.stride, view.mode, "NONE");
        REQUIRE(decoded);
        const bool equal = view.mode == "TRIANGLES"
                               ? triangles_of(*decoded, view.stride) == triangles_of(view.bytes, view.stride)
                               : *decoded == view.bytes;
        REQUIRE(equal);
        CHECK(!decode_meshopt(view.stream, view.count + 192, view.stride, view.mode, "NONE"));
    }
}

namespace {

constexpr std::size_t filtered_count = 257;

/// Random vectors of length 1, with four numbers each, of which `size` are not zero.
std::vector<float> unit_vectors(Random& random, std::size_t size) {
    std::vector<float> vectors;
    for (std::size_t i = 0; i < filtered_count; ++i) {
        std::array<double, 4> v{};
        double square = 0;
        for (std::size_t k = 0; k < size; ++k) {
            v[k] = random.uniform(-1, 1);
            square += v[k] * v[k];
        }
        for (const double x : v) vectors.push_back(float(x / std::sqrt(square)));
    }
    return vectors;
}

/// Encodes filtered elements, and decodes them with their filter.
std::string unfiltered(const std::string& filtered, const std::string& filter) {
    const std::size_t stride = filtered.size() / filtered_count;
    std::string stream(meshopt_encodeVertexBufferBound(filtered_count, stride), '\0');
    stream.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(stream.data()), stream.size(),
                                             filtered.data(), filtered_count, stride));
    const auto decoded = decode_meshopt(stream, filtered_count, stride, "ATTRIBUTES", filter);
    REQUIRE(decoded);
    return *decoded;
}

} // namespace

TEST_CASE("the filter OCTAHEDRAL restores normals", "[examples][gltf]") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const auto normals = unit_vectors(random, 3);
        std::string filtered(4 * filtered_count, '\0');
        meshopt_encodeFilterOct(filtered.data(), filtered_count, 4, 8, normals.data());
        const std::string bytes = unfiltered(filtered, "OCTAHEDRAL");
        filtered.resize(8 * filtered_count);
        meshopt_encodeFilterOct(filtered.data(), filtered_count, 8, 16, normals.data());
        const std::string words = unfiltered(filtered, "OCTAHEDRAL");
        for (std::size_t k = 0; k < 4 * filtered_count; ++k) {
            if (k % 4 == 3) continue; // not a component of the normal
            REQUIRE(std::abs(number_at<std::int8_t>(bytes, k) / 127.0 - double(normals[k])) < 0.03);
            REQUIRE(std::abs(number_at<std::int16_t>(words, k) / 32767.0 - double(normals[k])) < 1e-4);
        }
    }
}

TEST_CASE("the filter QUATERNION restores rotations", "[examples][gltf]") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const auto rotations = unit_vectors(random, 4);
        std::string filtered(8 * filtered_count, '\0');
        meshopt_encodeFilterQuat(filtered.data(), filtered_count, 8, 16, rotations.data());
        const std::string decoded = unfiltered(filtered, "QUATERNION");
        for (std::size_t i = 0; i < filtered_count; ++i) { // q and −q are the same rotation
            double product = 0;
            for (std::size_t k = 4 * i; k < 4 * i + 4; ++k)
                product += number_at<std::int16_t>(decoded, k) / 32767.0 * double(rotations[k]);
            REQUIRE(std::abs(std::abs(product) - 1) < 1e-3);
        }
    }
}

TEST_CASE("the filter EXPONENTIAL restores floats exactly", "[examples][gltf]") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        std::vector<std::uint32_t> words; // mantissas of 24 bits, exponents of 8 bits
        std::vector<float> expected;
        for (std::size_t k = 0; k < 3 * filtered_count; ++k) {
            const int mantissa = int(random.below(1 << 24)) - (1 << 23);
            const int exponent = int(random.below(200)) - 100;
            words.push_back((std::uint32_t(mantissa) & 0xffffff) | std::uint32_t(exponent) << 24);
            expected.push_back(std::ldexp(float(mantissa), exponent));
        }
        const std::string decoded = unfiltered(
            std::string(reinterpret_cast<const char*>(words.data()), 4 * words.size()), "EXPONENTIAL");
        for (std::size_t k = 0; k < expected.size(); ++k)
            REQUIRE(number_at<float>(decoded, k) == expected[k]);
    }
}

TEST_CASE("properties of a meshopt view outside the extension's ranges are refused", "[examples][gltf]") {
    constexpr auto most = std::numeric_limits<std::size_t>::max();
    const std::string stream(1000, '\xa0');
    const auto fault = [&](std::size_t count, std::size_t stride, const char* mode, const char* filter) {
        const auto decoded = decode_meshopt(stream, count, stride, mode, filter);
        REQUIRE(!decoded);
        return decoded.error().message;
    };
    for (const std::size_t stride : {std::size_t(0), std::size_t(3), std::size_t(260), most}) {
        CHECK_THAT(fault(1, stride, "ATTRIBUTES", "NONE"), containing("byteStride"));
        CHECK_THAT(fault(3, stride, "TRIANGLES", "NONE"), containing("byteStride"));
        CHECK_THAT(fault(3, stride, "INDICES", "NONE"), containing("byteStride"));
    }
    CHECK_THAT(fault(1, 12, "ATTRIBUTES", "OCTAHEDRAL"), containing("not 4 or 8"));
    CHECK_THAT(fault(1, 4, "ATTRIBUTES", "QUATERNION"), containing("not 8"));
    CHECK_THAT(fault(1, 4, "ATTRIBUTES", "COLOR"), containing("unknown filter"));
    CHECK_THAT(fault(3, 4, "TRIANGLES", "EXPONENTIAL"), containing("takes no filter"));
    CHECK_THAT(fault(3, 4, "POINTS", "NONE"), containing("unknown mode"));
    CHECK_THAT(fault(4, 4, "TRIANGLES", "NONE"), containing("multiple of 3"));
    for (const char* mode : {"ATTRIBUTES", "TRIANGLES", "INDICES"}) {
        for (const std::size_t count : {std::size_t(300000), most / 3 * 3, std::size_t(1) << 62})
            CHECK_THAT(fault(count / 3 * 3, 4, mode, "NONE"), containing("too short"));
        CHECK(!decode_meshopt("", 3, 4, mode, "NONE"));
    }
}

TEST_CASE("the most elements of a meshopt stream are decoded", "[examples][gltf]") {
    for (std::size_t count = 64; count <= 5000; count += 64) { // equal bytes take two bits per 16 of them
        const std::string bytes(count * 4, '\7');
        std::string stream(meshopt_encodeVertexBufferBound(count, 4), '\0');
        stream.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(stream.data()),
                                                 stream.size(), bytes.data(), count, 4));
        REQUIRE(decode_meshopt(stream, count, 4, "ATTRIBUTES", "NONE").value_or("") == bytes);
    }
}

TEST_CASE("damaged meshopt streams are decoded or refused", "[examples][gltf]") {
    std::size_t refused = 0, count = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const MeshoptView view(random);
        const auto size_of = [&](const std::string& stream, std::size_t elements, const std::string& filter) {
            const auto decoded = decode_meshopt(stream, elements, view.stride, view.mode, filter);
            if (decoded) REQUIRE(decoded->size() == elements * view.stride);
            if (!decoded) REQUIRE(!decoded.error().message.empty());
            ++count;
            refused += decoded ? 0 : 1;
            return decoded ? decoded->size() : 0;
        };
        const std::size_t step = 1 + view.stream.size() / 500;
        for (std::size_t size = random.below(step); size < view.stream.size(); size += step)
            REQUIRE(size_of(view.stream.substr(0, size), view.count, "NONE") == 0);
        const std::string filter =
            view.mode == "ATTRIBUTES" && view.stride == 8 && random.below(2) == 0 ? "QUATERNION" : "NONE";
        for (std::size_t n = 0; n < 1000; ++n)
            (void)size_of(damaged(view.stream, random), view.count - 3 * random.below(2) * (view.count / 6),
                          filter);
    }
    CHECK(refused > count / 4);
    CHECK(refused < count);
}

#endif

#ifdef CAGEFORM_HAS_DRACO

namespace {

/// A random triangle mesh with attributes, and its stream. The encoder changes the order of vertices and triangles.
/// The last attribute is the number of each vertex before encoding.
struct DracoMesh {
    Triangles triangles;
    std::vector<DracoAccessor> accessors;
    std::vector<std::string> values; // as the accessors
    std::string stream;
    std::size_t encoded_vertices = 0, encoded_indices = 0;

    /// A grid with random holes.
    ///
    ///   bits   of quantised positions, normals and texture coordinates; 0 keeps floats
    DracoMesh(Random& random, std::size_t columns, int bits, bool sequential, bool metadata = false) {
        const std::size_t vertices = add_grid(random, columns);
        mesh_.set_num_points(std::uint32_t(vertices));
        std::vector<std::array<float, 3>> normals(vertices);
        for (auto& normal : normals) normal = random_unit(random);
        add<float>(draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 5126, 3,
                   [&](std::size_t, std::size_t) { return float(random.uniform(-100, 100)); });
        add<float>(draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 5126, 3,
                   [&](std::size_t i, std::size_t k) { return normals[i][k]; });
        add<float>(draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, 5126, 2,
                   [&](std::size_t, std::size_t) { return float(random.uniform(-2, 2)); });
        add<std::uint8_t>(draco::GeometryAttribute::COLOR, draco::DT_UINT8, 5121, 4,
                          [&](std::size_t, std::size_t) { return std::uint8_t(random.bits()); });
        add<std::int16_t>(draco::GeometryAttribute::GENERIC, draco::DT_INT16, 5122, 4,
                          [&](std::size_t, std::size_t) { return std::int16_t(random.bits()); });
        add<std::uint32_t>(draco::GeometryAttribute::GENERIC, draco::DT_UINT32, 5125, 1,
                           [](std::size_t i, std::size_t) { return std::uint32_t(i); });
        if (metadata) add_metadata(random);
        encode(bits, sequential, int(random.below(11)));
    }

    Expected<DracoPrimitive> decoded() const {
        return decode_draco(stream, accessors, encoded_vertices, encoded_indices);
    }

private:
    draco::Mesh mesh_;

    /// Returns the number of vertices in triangles; the encoder drops all others.
    std::size_t add_grid(Random& random, std::size_t columns) {
        const std::size_t vertices = columns * (2 + random.below(columns));
        for (std::uint32_t i = 0; i + columns + 1 < vertices; ++i) {
            if ((i + 1) % columns == 0 || (random.below(16) == 0 && !triangles.empty())) continue;
            const auto below = i + std::uint32_t(columns);
            triangles.push_back({i, i + 1, below});
            triangles.push_back({i + 1, below + 1, below});
        }
        std::vector<std::uint32_t> number(vertices, 0);
        for (const auto& triangle : triangles) {
            for (const std::uint32_t i : triangle) number[i] = 1;
        }
        std::uint32_t used = 0;
        for (std::uint32_t& n : number) n = n != 0 ? used++ : 0;
        for (auto& triangle : triangles) {
            for (std::uint32_t& i : triangle) i = number[i];
            mesh_.AddFace({draco::PointIndex(triangle[0]), draco::PointIndex(triangle[1]),
                           draco::PointIndex(triangle[2])});
        }
        return used;
    }

    static std::array<float, 3> random_unit(Random& random) {
        std::array<double, 3> v{};
        for (double& x : v) x = random.uniform(-1, 1);
        const double length = std::hypot(v[0], v[1], v[2]);
        return {float(v[0] / length), float(v[1] / length), float(v[2] / length)};
    }

    template <class T, class Make>
    void add(draco::GeometryAttribute::Type type, draco::DataType draco_type, int component_type,
             std::size_t components, Make make) {
        const std::uint32_t vertices = mesh_.num_points();
        auto attribute = std::make_unique<draco::PointAttribute>();
        attribute->Init(type, std::int8_t(components), draco_type, false, vertices);
        std::string bytes;
        std::vector<T> value(components);
        for (std::uint32_t i = 0; i < vertices; ++i) {
            for (std::size_t k = 0; k < components; ++k) value[k] = make(i, k);
            attribute->SetAttributeValue(draco::AttributeValueIndex(i), value.data());
            bytes.append(reinterpret_cast<const char*>(value.data()), components * sizeof(T));
        }
        const int id = mesh_.AddAttribute(std::move(attribute));
        accessors.push_back({mesh_.attribute(id)->unique_id(), component_type, components});
        values.push_back(std::move(bytes));
    }

    void add_metadata(Random& random) {
        auto metadata = std::make_unique<draco::GeometryMetadata>();
        metadata->AddEntryString("name", std::string(random.below(300), 'x'));
        auto child = std::make_unique<draco::Metadata>();
        child->AddEntryInt("number", 7);
        child->AddSubMetadata("inner", std::make_unique<draco::Metadata>());
        metadata->AddSubMetadata("outer", std::move(child));
        metadata->AddSubMetadata("other", std::make_unique<draco::Metadata>());
        mesh_.AddMetadata(std::move(metadata));
        auto of_attribute = std::make_unique<draco::AttributeMetadata>();
        of_attribute->AddEntryDouble("scale", 0.5);
        mesh_.AddAttributeMetadata(1, std::move(of_attribute));
    }

    void encode(int bits, bool sequential, int speed) {
        draco::Encoder encoder;
        encoder.SetEncodingMethod(sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                             : draco::MESH_EDGEBREAKER_ENCODING);
        encoder.SetSpeedOptions(speed, speed);
        encoder.SetTrackEncodedProperties(true);
        for (const auto type : {draco::GeometryAttribute::POSITION, draco::GeometryAttribute::NORMAL,
                                draco::GeometryAttribute::TEX_COORD}) {
            if (bits != 0) encoder.SetAttributeQuantization(type, bits);
        }
        draco::EncoderBuffer buffer;
        REQUIRE(encoder.EncodeMeshToBuffer(mesh_, &buffer).ok());
        stream.assign(buffer.data(), buffer.size());
        encoded_vertices = encoder.num_encoded_points();
        encoded_indices = 3 * encoder.num_encoded_faces();
    }
};

/// The largest difference of an attribute's floats from those of the mesh, whose vertices have other numbers.
double largest_difference(const DracoMesh& mesh, const DracoPrimitive& decoded, std::size_t attribute) {
    const std::size_t components = mesh.accessors[attribute].components;
    double largest = 0;
    for (std::size_t i = 0; i < mesh.encoded_vertices; ++i) {
        const auto vertex = number_at<std::uint32_t>(decoded.attributes.back(), i);
        for (std::size_t k = 0; k < components; ++k) {
            const double difference =
                double(number_at<float>(decoded.attributes[attribute], components * i + k)) -
                double(number_at<float>(mesh.values[attribute], components * vertex + k));
            largest = std::max(largest, std::abs(difference));
        }
    }
    return largest;
}

std::string varint(std::uint64_t number) {
    std::string bytes;
    for (; number > 127; number >>= 7) bytes += static_cast<char>(128 | (number & 127));
    return bytes + static_cast<char>(number);
}

/// The first bytes of a stream of version 2.2 with a mesh.
std::string draco_header(bool edgebreaker, bool metadata = false) {
    return std::string("DRACO\2\2\1", 8) + char(edgebreaker) + '\0' + (metadata ? '\x80' : '\0');
}

} // namespace

TEST_CASE("Draco streams are decoded to the encoded mesh", "[examples][gltf]") {
    for (std::uint64_t seed = 1; seed <= 120; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const int bits = seed % 3 == 0 ? 0 : 8 + int(random.below(9));
        CAPTURE(bits);
        const DracoMesh mesh(random, 2 + random.below(20), bits, seed % 2 == 0, seed % 5 == 0);
        const auto decoded = mesh.decoded();
        REQUIRE(decoded);
        REQUIRE(decoded->attributes.size() == mesh.accessors.size());
        const auto& numbers = decoded->attributes.back();
        REQUIRE(numbers.size() == 4 * mesh.encoded_vertices);
        Triangles triangles(decoded->indices.size() / 3);
        for (std::size_t k = 0; k < decoded->indices.size(); ++k)
            triangles[k / 3][k % 3] = number_at<std::uint32_t>(numbers, decoded->indices[k]);
        const bool equal = sorted(turned(triangles)) == sorted(turned(mesh.triangles));
        REQUIRE(equal);
        for (std::size_t i = 0; i < mesh.encoded_vertices; ++i) {
            const auto vertex = number_at<std::uint32_t>(numbers, i);
            REQUIRE(decoded->attributes[3].substr(4 * i, 4) == mesh.values[3].substr(4 * vertex, 4));
            REQUIRE(decoded->attributes[4].substr(8 * i, 8) == mesh.values[4].substr(8 * vertex, 8));
        }
        const double steps = std::ldexp(1.0, bits) - 1; // of the largest extent: at most 200, 4
        CHECK(largest_difference(mesh, *decoded, 0) <= (bits == 0 ? 0 : 200 / steps * 0.51));
        CHECK(largest_difference(mesh, *decoded, 1) <= (bits == 0 ? 0 : 4 / steps));
        CHECK(largest_difference(mesh, *decoded, 2) <= (bits == 0 ? 0 : 4 / steps * 0.51));
    }
}

TEST_CASE("Draco attributes are converted to the accessor's type, or refused", "[examples][gltf]") {
    Random random(1);
    const DracoMesh mesh(random, 12, 11, false);
    const auto decoded = mesh.decoded();
    REQUIRE(decoded);
    const auto as = [&](std::size_t attribute, int component_type, std::size_t components) {
        const DracoAccessor accessor{mesh.accessors[attribute].unique_id, component_type, components};
        return decode_draco(mesh.stream, std::span(&accessor, 1), mesh.encoded_vertices,
                            mesh.encoded_indices);
    };
    const auto wide = as(3, 5123, 4), single = as(3, 5126, 4);
    REQUIRE(wide);
    REQUIRE(single);
    for (std::size_t k = 0; k < 4 * mesh.encoded_vertices; ++k) {
        const auto colour = number_at<std::uint8_t>(decoded->attributes[3], k);
        CHECK(number_at<std::uint16_t>(wide->attributes[0], k) == colour);
        CHECK(number_at<float>(single->attributes[0], k) == float(colour));
    }
    const auto fault = [](const Expected<DracoPrimitive>& refused) {
        REQUIRE(!refused);
        return refused.error().message;
    };
    for (const int type : {5120, 5121, 5123, 5125}) // negative and large numbers
        CHECK_THAT(fault(as(4, type, 4)), containing("outside the range of its accessor's componentType"));
    CHECK_THAT(fault(as(0, 5123, 3)), containing("holds floats, but its accessor holds integers"));
    CHECK_THAT(fault(as(0, 5126, 2)), containing("has 3 components, but its accessor has 2"));
    CHECK(!as(3, 5124, 4));
    const DracoAccessor missing{77, 5126, 3};
    CHECK_THAT(
        fault(decode_draco(mesh.stream, std::span(&missing, 1), mesh.encoded_vertices, mesh.encoded_indices)),
        containing("attribute 77 of the Draco stream does not exist"));
    CHECK_THAT(fault(decode_draco(mesh.stream, {}, mesh.encoded_vertices + 1, mesh.encoded_indices)),
               containing(" vertices, but its accessors have "));
    CHECK_THAT(fault(decode_draco(mesh.stream, {}, mesh.encoded_vertices, mesh.encoded_indices + 3)),
               containing(" triangles, but its accessors have "));
    CHECK_THAT(fault(decode_draco(mesh.stream, {}, mesh.encoded_vertices, mesh.encoded_indices + 1)),
               containing("are not triangles"));
}

TEST_CASE("Draco headers of other kinds are refused", "[examples][gltf]") {
    Random random(2);
    const DracoMesh mesh(random, 5, 11, false);
    const auto fault = [&](std::size_t place, char byte) {
        std::string stream = mesh.stream;
        stream[place] = byte;
        const auto refused =
            decode_draco(stream, mesh.accessors, mesh.encoded_vertices, mesh.encoded_indices);
        REQUIRE(!refused);
        return refused.error().message;
    };
    CHECK_THAT(fault(0, 'd'), containing("no header"));
    CHECK_THAT(fault(5, 1), containing("version 1.2, not 2.2"));
    CHECK_THAT(fault(6, 3), containing("version 2.3, not 2.2"));
    CHECK_THAT(fault(7, 0), containing("not a mesh"));
    CHECK_THAT(fault(8, 2), containing("not a mesh"));
    CHECK_THAT(fault(10, '\x80'), containing("metadata"));
}

TEST_CASE("Draco counts are refused before memory is taken for them", "[examples][gltf]") {
    const auto fault = [](const std::string& stream, std::size_t vertices, std::size_t triangles) {
        const auto refused = decode_draco(stream, {}, vertices, 3 * triangles);
        REQUIRE(!refused);
        return refused.error().message;
    };
    const std::size_t many = 1000000000;
    const std::string tail(1000, '\1');
    CHECK_THAT(fault(draco_header(true) + '\0' + varint(many) + varint(many) + tail, many, many),
               containing("too short for its counts"));
    // Tables of 200 attributes.
    CHECK_THAT(
        fault(draco_header(true) + '\0' + varint(100000) + varint(100000) + '\xc8' + tail, 100000, 100000),
        containing("too short for its counts"));
    // A mesh without compression, with 200 attributes of 255 components.
    std::string stream = draco_header(false) + varint(2000) + varint(6000) + '\1';
    stream += std::string(2000 * 6, '\0') + '\1' + varint(200);
    for (std::uint64_t k = 0; k < 200; ++k) stream += std::string("\4\2\xff\0", 4) + varint(k);
    CHECK_THAT(fault(stream + std::string(200, '\0'), 6000, 2000), containing("too short for its counts"));
    // Metadata whose nodes claim as many children as there are bytes left.
    stream = draco_header(false, true) + '\0';
    for (std::size_t k = 0; k < 900; ++k) stream += std::string(k > 0 ? 2 : 1, '\0') + varint(1000000);
    CHECK_THAT(fault(stream + std::string(1000000, '\0'), 3, 1), containing("metadata"));
}

TEST_CASE("damaged Draco streams are decoded or refused", "[examples][gltf]") {
    constexpr std::array<std::size_t, 6> bytes_per_vertex{12, 12, 8, 4, 8, 4};
    std::size_t refused = 0, count = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const DracoMesh mesh(random, 2 + random.below(8), seed % 3 == 0 ? 0 : 8, seed % 2 == 0,
                             seed % 7 == 0);
        const auto decodes = [&](const std::string& stream) {
            const auto decoded =
                decode_draco(stream, mesh.accessors, mesh.encoded_vertices, mesh.encoded_indices);
            ++count;
            if (!decoded) {
                REQUIRE(!decoded.error().message.empty());
                ++refused;
                return false;
            }
            REQUIRE(decoded->indices.size() == mesh.encoded_indices);
            for (const std::uint32_t i : decoded->indices) REQUIRE(i < mesh.encoded_vertices);
            for (std::size_t k = 0; k < mesh.accessors.size(); ++k)
                REQUIRE(decoded->attributes[k].size() == mesh.encoded_vertices * bytes_per_vertex[k]);
            return true;
        };
        REQUIRE(decodes(mesh.stream));
        const std::size_t step = 1 + mesh.stream.size() / 200;
        for (std::size_t size = random.below(step); size < mesh.stream.size(); size += step)
            (void)decodes(mesh.stream.substr(0, size));
        REQUIRE(!decodes(mesh.stream.substr(0, mesh.stream.size() / 2)));
        for (std::size_t n = 0; n < 200; ++n) (void)decodes(damaged(mesh.stream, random));
    }
    CHECK(refused > count / 4);
    CHECK(refused < count);
}

#endif

} // namespace gltf_compression_tests
