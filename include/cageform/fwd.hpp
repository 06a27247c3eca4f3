// Names only, for headers that pass cageform's types along.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

enum class [[nodiscard]] Status : std::uint8_t;
enum class PointState : std::uint8_t;
template <class T, std::size_t D>
struct Vec;
template <class T, std::size_t D>
class StridedPoints;
struct CageReport;
struct BindOptions;
struct BindReport;

} // namespace cageform::inline CAGEFORM_ABI
