// Exact wide integers, and floating-point numbers with 120 accurate bits, independent of floating-point
// compiler flags.
#pragma once

#include <cageform/config.hpp>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The upper and lower halves of the product of two 64-bit numbers.
struct Product64 {
    std::uint64_t high, low;
};
inline Product64 multiply(std::uint64_t a, std::uint64_t b) noexcept {
    constexpr std::uint64_t half = 0xffffffffu;
    const std::uint64_t ll = (a & half) * (b & half), lh = (a & half) * (b >> 32),
                        hl = (a >> 32) * (b & half);
    const std::uint64_t middle = (ll >> 32) + (lh & half) + (hl & half);
    return {(a >> 32) * (b >> 32) + (lh >> 32) + (hl >> 32) + (middle >> 32), (middle << 32) | (ll & half)};
}

/// A 320-bit integer in two's complement. For coordinates of 61 bits and a sign, in_sphere in 3D needs 312
/// bits and a circumcentre 250. Larger results wrap around.
class WideInt {
public:
    static constexpr std::size_t limbs = 10;

    WideInt() noexcept = default;
    WideInt(std::int64_t x) noexcept { // NOLINT(google-explicit-constructor): implicit, as between numbers
        const auto bits = std::uint64_t(x);
        limb_[0] = std::uint32_t(bits);
        limb_[1] = std::uint32_t(bits >> 32);
        for (std::size_t k = 2; k < limbs; ++k) limb_[k] = x < 0 ? ~0u : 0u;
    }

    friend WideInt operator+(WideInt a, const WideInt& b) noexcept {
        std::uint64_t carry = 0;
        for (std::size_t k = 0; k < limbs; ++k) {
            carry += std::uint64_t(a.limb_[k]) + b.limb_[k];
            a.limb_[k] = std::uint32_t(carry);
            carry >>= 32;
        }
        return a;
    }
    friend WideInt operator-(WideInt a) noexcept {
        std::uint64_t carry = 1;
        for (std::uint32_t& limb : a.limb_) {
            carry += std::uint64_t(std::uint32_t(~limb));
            limb = std::uint32_t(carry);
            carry >>= 32;
        }
        return a;
    }
    friend WideInt operator-(const WideInt& a, const WideInt& b) noexcept { return a + -b; }
    friend WideInt operator*(WideInt a, WideInt b) noexcept {
        const bool negative = (a.sign() < 0) != (b.sign() < 0);
        if (a.sign() < 0) a = -a;
        if (b.sign() < 0) b = -b;
        const std::size_t used_a = a.used(), used_b = b.used();
        WideInt product;
        for (std::size_t i = 0; i < used_a; ++i) {
            std::uint64_t carry = 0;
            for (std::size_t k = 0; i + k < limbs && (k < used_b || carry != 0); ++k) {
                carry += std::uint64_t(a.limb_[i]) * b.limb_[k] + product.limb_[i + k];
                product.limb_[i + k] = std::uint32_t(carry);
                carry >>= 32;
            }
        }
        return negative ? -product : product;
    }
    int sign() const noexcept {
        if ((limb_[limbs - 1] >> 31) != 0) return -1;
        return used() != 0 ? 1 : 0;
    }
    std::uint64_t word(std::size_t k) const noexcept {
        return std::uint64_t(limb_[2 * k]) | (std::uint64_t(limb_[2 * k + 1]) << 32);
    }

private:
    std::size_t used() const noexcept {
        std::size_t n = limbs;
        while (n > 0 && limb_[n - 1] == 0) --n;
        return n;
    }

    std::uint32_t limb_[limbs]{};
};

/// A 128-bit floating-point number: ± (high 2^64 + low) 2^exponent with the top bit of `high` set, or 0.
/// Sums, products and quotients have an error of at most 2^-120 of the largest operand or result.
class WideFloat {
public:
    WideFloat() noexcept = default;
    WideFloat(std::int64_t x) noexcept // NOLINT(google-explicit-constructor): implicit, as between numbers
        : negative_(x < 0)
        , exponent_(-64)
        , high_(x < 0 ? ~std::uint64_t(x) + 1 : std::uint64_t(x)) {
        normalise();
    }
    explicit WideFloat(WideInt x) noexcept
        : negative_(x.sign() < 0) {
        if (negative_) x = -x;
        std::size_t top = WideInt::limbs / 2;
        while (top > 0 && x.word(top - 1) == 0) --top;
        if (top == 0) return;
        high_ = x.word(top - 1);
        low_ = top > 1 ? x.word(top - 2) : 0;
        const int shift = std::countl_zero(high_);
        const std::uint64_t rest = top > 2 ? x.word(top - 3) : 0;
        exponent_ = 64 * (std::int64_t(top) - 2);
        normalise();
        if (shift > 0) low_ |= rest >> (64 - shift);
    }

    explicit operator double() const noexcept {
        const double value =
            std::ldexp(double(high_), int(exponent_ + 64)) + std::ldexp(double(low_), int(exponent_));
        return negative_ ? -value : value;
    }

    friend WideFloat operator-(WideFloat a) noexcept {
        a.negative_ = !a.negative_;
        return a;
    }
    friend WideFloat operator+(WideFloat a, WideFloat b) noexcept {
        if (b.high_ == 0) return a;
        if (a.high_ == 0) return b;
        if (a.exponent_ < b.exponent_ ||
            (a.exponent_ == b.exponent_ && (a.high_ < b.high_ || (a.high_ == b.high_ && a.low_ < b.low_)))) {
            const WideFloat c = a;
            a = b;
            b = c;
        }
        b.shift_down(a.exponent_ - b.exponent_);
        if (a.negative_ != b.negative_) {
            const std::uint64_t borrow = a.low_ < b.low_ ? 1 : 0;
            a.low_ -= b.low_;
            a.high_ -= b.high_ + borrow;
            a.normalise();
            return a;
        }
        a.low_ += b.low_;
        const std::uint64_t carry = a.low_ < b.low_ ? 1 : 0;
        const std::uint64_t before = a.high_;
        a.high_ += b.high_ + carry;
        if (a.high_ < before || (carry != 0 && a.high_ == before)) {
            a.shift_down(1);
            a.high_ |= std::uint64_t(1) << 63;
        }
        return a;
    }
    friend WideFloat operator-(const WideFloat& a, const WideFloat& b) noexcept { return a + -b; }
    friend WideFloat operator*(const WideFloat& a, const WideFloat& b) noexcept {
        if (a.high_ == 0 || b.high_ == 0) return {};
        const Product64 top = multiply(a.high_, b.high_);
        WideFloat result;
        result.negative_ = a.negative_ != b.negative_;
        result.exponent_ = a.exponent_ + b.exponent_ + 128;
        result.high_ = top.high;
        result.low_ = top.low;
        for (const std::uint64_t word : {multiply(a.high_, b.low_).high, multiply(a.low_, b.high_).high}) {
            result.low_ += word;
            if (result.low_ < word) ++result.high_;
        }
        result.normalise();
        return result;
    }
    /// Returns 1 / a, by Newton's iteration from the quotient in double.
    friend WideFloat inverse(const WideFloat& a) noexcept {
        WideFloat scaled = a;
        scaled.exponent_ = -127; // in [1, 2)
        WideFloat x(std::int64_t(0x1p62 / double(scaled)));
        x.exponent_ -= 62;
        const WideFloat two(2);
        for (int round = 0; round < 2; ++round) x = x * (two - scaled * x);
        x.exponent_ -= a.exponent_ + 127;
        return x;
    }

private:
    void normalise() noexcept {
        if (high_ == 0) {
            high_ = low_;
            low_ = 0;
            exponent_ -= 64;
        }
        if (high_ == 0) {
            *this = {};
            return;
        }
        const int shift = std::countl_zero(high_);
        if (shift == 0) return;
        high_ = (high_ << shift) | (low_ >> (64 - shift));
        low_ <<= shift;
        exponent_ -= shift;
    }
    void shift_down(std::int64_t bits) noexcept {
        exponent_ += bits;
        if (bits >= 128) {
            high_ = low_ = 0;
        } else if (bits >= 64) {
            low_ = high_ >> (bits - 64);
            high_ = 0;
        } else if (bits > 0) {
            low_ = (low_ >> bits) | (high_ << (64 - bits));
            high_ >>= bits;
        }
    }

    bool negative_ = false;
    std::int64_t exponent_ = 0;
    std::uint64_t high_ = 0, low_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
