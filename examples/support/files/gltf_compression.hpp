#pragma once

// Decodes compressed parts of glTF files: EXT_meshopt_compression by meshoptimizer, and
// KHR_draco_mesh_compression by Draco.
//
// Both libraries are optional when the programs are built. Errors are sentences without the names of the file
// and of its element.

#include "io/expected.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// Whether this build decodes KHR_draco_mesh_compression.
bool has_draco();
/// Whether this build decodes EXT_meshopt_compression.
bool has_meshopt();

/// Decodes a buffer view of EXT_meshopt_compression.
///
///   source   the `byteLength` bytes of the extension's `buffer` at `byteOffset`
///   count    number of elements
///   stride   bytes per element, `byteStride` of the extension
///   mode     ATTRIBUTES, TRIANGLES or INDICES
///   filter   NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL; NONE if the file does not name a filter
///   returns  count · stride bytes
///   fails    if the build has no decoder, or a property is outside the extension's ranges. Also fails if
///            the stream does not hold the elements.
Expected<std::string> decode_meshopt(std::string_view source, std::size_t count, std::size_t stride,
                                     const std::string& mode, const std::string& filter);

/// An accessor whose values are in a Draco stream.
struct DracoAccessor {
    std::uint32_t unique_id = 0; // the value of the attribute in the extension's `attributes`
    int component_type = 0;      // as in glTF: 5120 (BYTE) to 5126 (FLOAT), without 5124
    std::size_t components = 0;  // 1 to 4
};

/// A decoded primitive.
struct DracoPrimitive {
    std::vector<std::uint32_t> indices;  // three per triangle, each less than the number of vertices
    std::vector<std::string> attributes; // as the accessors: little-endian, without padding
};

/// Decodes a primitive of KHR_draco_mesh_compression.
///
///   source     the bytes of the extension's buffer view
///   vertices   `count` of the primitive's accessors
///   indices    `count` of the accessor of indices
///   fails      if the build has no decoder or the stream is broken. Also fails if the counts or components
///              of the stream are not those of the accessors. Floats for accessors of integers also fail.
Expected<DracoPrimitive> decode_draco(std::string_view source, std::span<const DracoAccessor> accessors,
                                      std::size_t vertices, std::size_t indices);

} // namespace cageform_support
