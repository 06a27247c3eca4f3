// Feeds bytes to the decoders of compressed glTF, with the libraries under the sanitizers too: for libFuzzer. SOURCES are
// those of Debian's packages: Draco built by its CMakeLists.txt, and src/*.cpp of meshoptimizer, with the same flags
// and -fsanitize=fuzzer-no-link instead of fuzzer.
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=fuzzer,address,undefined -fno-sanitize=vptr -DCAGEFORM_HAS_DRACO
//             -DCAGEFORM_HAS_MESHOPT -Iexamples/support tests/fuzz/compressed_gltf.cpp
//             examples/support/files/gltf_compression.cpp SOURCES/libdraco.a SOURCES/libmeshoptimizer.a -o fuzz_gltf
//     mkdir corpus && ./fuzz_gltf --seeds=corpus && ./fuzz_gltf -max_len=4096 -rss_limit_mb=2500 corpus
//
// An input is a kind (a byte), two numbers (four bytes each: vertices and triangles, or count and stride) and a stream.
#include "files/gltf_compression.hpp"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace {

using namespace cageform_support;

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "line %d: %s\n", __LINE__, #condition);                                         \
        std::abort();                                                                                        \
    }

constexpr std::size_t head = 9; ///< bytes before the stream
constexpr std::array modes{"ATTRIBUTES", "TRIANGLES", "INDICES"};
constexpr std::array filters{"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
constexpr std::size_t meshopt_kinds = modes.size() * filters.size(); ///< later kinds are Draco

void read_draco(std::string_view stream, std::size_t vertices, std::size_t indices, bool again = true) {
    static constexpr std::array<DracoAccessor, 3> accessors{{{0, 5126, 3}, {1, 5126, 3}, {2, 5121, 4}}};
    const auto decoded = decode_draco(stream, accessors, vertices, indices);
    if (decoded) {
        REQUIRE(decoded->indices.size() == indices);
        for (const std::uint32_t i : decoded->indices) REQUIRE(i < vertices);
        REQUIRE(decoded->attributes.size() == accessors.size());
        REQUIRE(decoded->attributes[0].size() == 12 * vertices &&
                decoded->attributes[2].size() == 4 * vertices);
        return;
    }
    // Goes on with the number of vertices that the stream has: mutations change it often.
    unsigned long in_stream = 0;
    char comma = 0;
    if (again && std::sscanf(decoded.error().message.c_str(), "the Draco stream has %lu vertices%c",
                             &in_stream, &comma) == 2)
        read_draco(stream, in_stream, indices, false);
}

void read(std::string_view input) {
    if (input.size() < head) return;
    std::array<std::uint32_t, 2> numbers{};
    std::memcpy(numbers.data(), input.data() + 1, sizeof numbers);
    const std::size_t kind = static_cast<unsigned char>(input[0]) % (2 * meshopt_kinds);
    // In memory of its own: a sanitizer sees what is read beyond.
    const std::string stream(input.substr(head));
    if (kind >= meshopt_kinds) return read_draco(stream, numbers[0], std::size_t(numbers[1]) * 3);
    const auto decoded = decode_meshopt(stream, numbers[0], numbers[1], modes[kind / filters.size()],
                                        filters[kind % filters.size()]);
    REQUIRE(!decoded || decoded->size() == std::size_t(numbers[0]) * numbers[1]);
}

std::string input(std::size_t kind, std::size_t first, std::size_t second, const std::string& stream) {
    const std::array<std::uint32_t, 2> numbers{std::uint32_t(first), std::uint32_t(second)};
    return char(kind) + std::string(reinterpret_cast<const char*>(numbers.data()), sizeof numbers) + stream;
}

/// A wavy grid of 12 × 12 vertices with a hole.
std::string draco_seed(int speed, int bits, bool sequential) {
    constexpr std::uint32_t columns = 12;
    draco::Mesh mesh;
    mesh.set_num_points(columns * columns);
    for (std::uint32_t i = 0; i + columns + 1 < columns * columns; ++i) {
        if (i % columns == columns - 1 || i == 50) continue;
        mesh.AddFace({draco::PointIndex(i), draco::PointIndex(i + 1), draco::PointIndex(i + columns)});
        mesh.AddFace(
            {draco::PointIndex(i + 1), draco::PointIndex(i + columns + 1), draco::PointIndex(i + columns)});
    }
    const auto add = [&](draco::GeometryAttribute::Type type, draco::DataType numbers, std::int8_t components,
                         auto value) {
        auto attribute = std::make_unique<draco::PointAttribute>();
        attribute->Init(type, components, numbers, false, columns * columns);
        for (std::uint32_t i = 0; i < columns * columns; ++i) {
            const auto v = value(i);
            attribute->SetAttributeValue(draco::AttributeValueIndex(i), v.data());
        }
        mesh.AddAttribute(std::move(attribute));
    };
    add(draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, [](std::uint32_t i) {
        return std::array{float(i % columns), float(i / columns), float(i * i % 7) / 7};
    });
    add(draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3,
        [](std::uint32_t i) { return std::array{i % 2 == 0 ? 0.6f : 0.0f, 0.0f, i % 2 == 0 ? 0.8f : 1.0f}; });
    add(draco::GeometryAttribute::COLOR, draco::DT_UINT8, 4, [](std::uint32_t i) {
        return std::array{std::uint8_t(i), std::uint8_t(i / 2), std::uint8_t(7 * i), std::uint8_t(255)};
    });
    draco::Encoder encoder;
    encoder.SetEncodingMethod(sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                         : draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetTrackEncodedProperties(true);
    if (bits != 0) {
        encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
        encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, bits);
    }
    draco::EncoderBuffer buffer;
    REQUIRE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    return input(meshopt_kinds, encoder.num_encoded_points(), encoder.num_encoded_faces(),
                 std::string(buffer.data(), buffer.size()));
}

std::string meshopt_seed(std::size_t kind) {
    const std::size_t mode = kind / filters.size();
    const std::size_t count = 150, stride = mode == 0 ? 8 : 4;
    std::array<unsigned, 2 * count> numbers{};
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = unsigned(mode == 0 ? k * 77777 : k % 40);
    std::string stream(10000, '\0');
    auto* to = reinterpret_cast<unsigned char*>(stream.data());
    stream.resize(mode == 0   ? meshopt_encodeVertexBuffer(to, stream.size(), numbers.data(), count, stride)
                  : mode == 1 ? meshopt_encodeIndexBuffer(to, stream.size(), numbers.data(), count)
                              : meshopt_encodeIndexSequence(to, stream.size(), numbers.data(), count));
    return input(kind, count, stride, stream);
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
    std::string seeds;
    for (int n = 1; n < *count; ++n) {
        const std::string argument = (*arguments)[n], folder = "--seeds=";
        if (argument.starts_with(folder)) seeds = argument.substr(folder.size());
    }
    if (seeds.empty()) return 0;
    std::vector<std::string> inputs;
    for (std::size_t kind = 0; kind < meshopt_kinds; ++kind) inputs.push_back(meshopt_seed(kind));
    for (int speed = 0; speed <= 10; speed += 2) {
        for (const int bits : {0, 9}) {
            inputs.push_back(draco_seed(speed, bits, false));
            inputs.push_back(draco_seed(speed, bits, true));
        }
    }
    for (std::size_t n = 0; n < inputs.size(); ++n) {
        std::FILE* const file = std::fopen((seeds + "/" + std::to_string(n)).c_str(), "wb");
        REQUIRE(file != nullptr);
        REQUIRE(std::fwrite(inputs[n].data(), 1, inputs[n].size(), file) == inputs[n].size());
        REQUIRE(std::fclose(file) == 0);
    }
    std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    read(std::string_view(reinterpret_cast<const char*>(data), size));
    return 0;
}
