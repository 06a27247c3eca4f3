// The functions that an engine calls every frame, compiled once per level of processors. LEVEL is its name.
#include <cageform/clone/clone.hpp>
#include <cageform/figure/types/blob.hpp>

#define CAGEFORM_TEST_JOIN_EXPANDED(a, b) a##b
#define CAGEFORM_TEST_JOIN(a, b) CAGEFORM_TEST_JOIN_EXPANDED(a, b)
#define CAGEFORM_TEST_TEXT_EXPANDED(a) #a
#define CAGEFORM_TEST_TEXT(a) CAGEFORM_TEST_TEXT_EXPANDED(a)

bool CAGEFORM_TEST_JOIN(clone_, LEVEL)(const std::byte* packed, std::size_t bytes, const float* pose,
                                       std::size_t handles, float* out, std::size_t points);
const char* CAGEFORM_TEST_JOIN(namespace_, LEVEL)();

bool CAGEFORM_TEST_JOIN(clone_, LEVEL)(const std::byte* packed, std::size_t bytes, const float* pose,
                                       std::size_t handles, float* out, std::size_t points) {
    const auto opened = cageform::open_blob<float, 3>({packed, bytes});
    return opened.status() == cageform::Status::ok &&
           cageform::clone(opened.value, cageform::StridedPoints<const float, 3>(pose, handles),
                           cageform::StridedPoints<float, 3>(out, points)) == cageform::Status::ok;
}

const char* CAGEFORM_TEST_JOIN(namespace_, LEVEL)() {
    return CAGEFORM_TEST_TEXT(CAGEFORM_ABI);
}
