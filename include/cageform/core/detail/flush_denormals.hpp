// Treats denormal numbers as zero.
#pragma once

#include <cageform/config.hpp>

#include <cstdint>

namespace cageform::inline CAGEFORM_ABI::detail {

#if defined(__GNUC__) && defined(__SSE__) && !defined(__wasm__)
using FloatMode = unsigned;
inline constexpr FloatMode flushes_denormals = 0x8040; ///< MXCSR: flush results to zero, treat operands as
                                                       ///< zero
inline FloatMode float_mode() noexcept {
    return __builtin_ia32_stmxcsr();
}
inline void set_float_mode(FloatMode mode) noexcept {
    __builtin_ia32_ldmxcsr(mode);
}
#elif defined(__GNUC__) && defined(__aarch64__)
using FloatMode = std::uint64_t;
inline constexpr FloatMode flushes_denormals = FloatMode{1} << 24; ///< FPCR: one bit for both
inline FloatMode float_mode() noexcept {
    FloatMode mode = 0;
    __asm__ volatile("mrs %0, fpcr" : "=r"(mode));
    return mode;
}
inline void set_float_mode(FloatMode mode) noexcept {
    __asm__ volatile("msr fpcr, %0" : : "r"(mode));
}
#else
using FloatMode = unsigned;
inline constexpr FloatMode flushes_denormals = 0;
inline FloatMode float_mode() noexcept {
    return 0;
}
inline void set_float_mode(FloatMode /*mode*/) noexcept {}
#endif

/// Treats denormals as zero on the constructing thread for its lifetime, then restores the previous
/// mode. Harmonic functions fall below float's smallest normal number, 1e-38, far from their boundary
/// data. Some processors then need hundreds of cycles per addition, for differences far below any
/// tolerance. Supports 64-bit ARM and x86 with SSE; elsewhere it does nothing.
class FlushDenormals {
public:
    FlushDenormals() noexcept { set_float_mode(before_ | flushes_denormals); }
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;
    ~FlushDenormals() { set_float_mode(before_); }

private:
    FloatMode before_ = float_mode();
};

} // namespace cageform::inline CAGEFORM_ABI::detail
