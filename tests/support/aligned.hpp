// Memory that packed data is put into, to be harmed.
#pragma once

#include <cageform/figure/types/blob.hpp>

#include <cstddef>
#include <cstring>

namespace cageform_tests {

/// Memory aligned as blobs want it.
class Aligned {
public:
    explicit Aligned(std::span<const std::byte> bytes)
        : lines_((bytes.size() + 63) / 64)
        , size_(bytes.size()) {
        if (!bytes.empty()) std::memcpy(data(), bytes.data(), bytes.size());
    }
    std::byte* data() { return reinterpret_cast<std::byte*>(lines_.data()); }
    std::span<std::byte> bytes() { return {data(), size_}; }
    template <class X>
    void set(std::size_t offset, X x) {
        std::memcpy(data() + offset, &x, sizeof(x));
    }
    cageform::BlobHeader header() {
        cageform::BlobHeader header;
        std::memcpy(&header, data(), sizeof(header));
        return header;
    }
    /// With the checksum that its bytes have; blobs, clips and figures have it in the same place.
    void seal() {
        set(offsetof(cageform::BlobHeader, checksum),
            cageform::hash_memory(std::span<const std::byte>(bytes()).subspan(32)));
    }

private:
    std::vector<cageform::Lanes<double>> lines_;
    std::size_t size_;
};

} // namespace cageform_tests
