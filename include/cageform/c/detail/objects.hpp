// The objects behind the opaque pointers of the C interface, and the validation of arguments.
#pragma once

#include <cageform/c/cageform.h>
#include <cageform/clip/clip_blob.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/view.hpp>
#include <cageform/figure/figure.hpp>

#include <cstdint>
#include <cstring>
#include <new>
#include <type_traits>
#include <utility>
#include <variant>

namespace cageform::inline CAGEFORM_ABI::detail::c {

static_assert(CAGEFORM_NONE == ~std::size_t{0}, "CAGEFORM_NONE must equal the library's `none`");

/// Returns the code of a status. Compilers warn about a missing case.
constexpr cageform_status code_of(Status status) noexcept {
    switch (status) {
#define CAGEFORM_STATUS_CASE(code, NAME, name)                                                               \
    case Status::name: return CAGEFORM_##NAME;
        CAGEFORM_STATUSES(CAGEFORM_STATUS_CASE)
#undef CAGEFORM_STATUS_CASE
    }
    return CAGEFORM_FAILED;
}

/// The first member of every object. Its kind is a magic number, so that objects of another kind, and
/// most freed ones, are rejected.
struct Object {
    enum class Kind : std::uint64_t {
        figure = 0x6366'6967'7572'6501u,
        player,
        bytes,
        coordinates,
        binding,
        made_cage,
        samples,
        pins,
        skeleton,
        wrap,
        none
    };

    Kind kind;
    void (*destroy)(Object*) noexcept;
};

template <class X>
void destroy_allocated(Object* object) noexcept {
    delete static_cast<X*>(object);
}

template <class T, std::size_t D>
struct Type {};
template <class... All>
struct Types {};
/// The scalars and dimensions that are compiled. A program may define a shorter list before it includes this.
#if !defined(CAGEFORM_C_TYPES)
#define CAGEFORM_C_TYPES Type<float, 2>, Type<double, 2>, Type<float, 3>, Type<double, 3>
#endif
template <template <class, std::size_t> class X, class... T, std::size_t... D>
std::variant<X<T, D>...> any_of(Types<Type<T, D>...>);

/// A variant of X for all of these types.
template <template <class, std::size_t> class X>
using OfAnyType = decltype(any_of<X>(Types<CAGEFORM_C_TYPES>{}));

/// Calls use(x) with the value of a variant.
template <class Variant, class Use>
cageform_status with(Variant& any, const Use& use) {
    cageform_status status = CAGEFORM_FAILED;
    const auto use_if_held = [&](auto* x) { return x != nullptr && (status = use(*x), true); };
    [&]<std::size_t... N>(std::index_sequence<N...>) {
        (void)(... || use_if_held(std::get_if<N>(&any)));
    }(std::make_index_sequence<std::variant_size_v<std::remove_const_t<Variant>>>());
    return status;
}

template <class X>
inline constexpr std::uint32_t scalar_code =
    std::is_same_v<typename X::scalar, float> ? CAGEFORM_FLOAT : CAGEFORM_DOUBLE;

/// Calls make<T, D>(), which returns a status code, for a scalar and a dimension.
template <class Make>
cageform_status with_type(std::uint32_t scalar, std::size_t dimension, const Make& make) {
    if (scalar > CAGEFORM_DOUBLE) return CAGEFORM_CHOICE_UNKNOWN;
    cageform_status status = CAGEFORM_DIMENSION_DIFFERS;
    const auto make_if_given = [&]<class T, std::size_t D>(Type<T, D>) {
        if (dimension == D && (scalar == CAGEFORM_FLOAT) == std::is_same_v<T, float>)
            status = make.template operator()<T, D>();
    };
    [&]<class... All>(Types<All...>) { (make_if_given(All{}), ...); }(Types<CAGEFORM_C_TYPES>{});
    return status;
}

/// Runs f, which returns a status code; exceptions become codes.
template <class F>
cageform_status guarded(const F& f) noexcept {
#if defined(__cpp_exceptions)
    try {
        cageform_status code = CAGEFORM_OK;
        const Status status = guard_memory([&] { code = f(); });
        return status == Status::ok ? code : code_of(status);
    } catch (...) {
        return CAGEFORM_FAILED;
    }
#else
    return f();
#endif
}

/// Checks that a pointer refers to an object of a kind.
template <class X>
cageform_status check_object(const X* object) noexcept {
    if (object == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return object->kind == X::its_kind ? CAGEFORM_OK : CAGEFORM_OBJECT_OF_ANOTHER_KIND;
}

/// Copies a struct that begins with its size. If `given` is null, `own` has the defaults.
template <class S>
cageform_status read_struct(const S* given, S& own) noexcept {
    own = S{};
    if (given == nullptr) return CAGEFORM_OK;
    std::size_t size = 0;
    std::memcpy(&size, given, sizeof(size));
    if (size < sizeof(size)) return CAGEFORM_SIZE_NOT_SET;
    std::memcpy(static_cast<void*>(&own), given, size < sizeof(S) ? size : sizeof(S));
    return CAGEFORM_OK;
}
/// Writes the fields of a struct that the caller's size includes.
template <class S>
cageform_status write_struct(S own, S* out) noexcept {
    if (out == nullptr) return CAGEFORM_ARGUMENT_NULL;
    if (out->size < sizeof(own.size)) return CAGEFORM_SIZE_NOT_SET;
    own.size = out->size;
    std::memcpy(static_cast<void*>(out), &own, own.size < sizeof(S) ? own.size : sizeof(S));
    return CAGEFORM_OK;
}

/// Checks points or an output. Sets `stride` to the bytes between points.
template <class P>
cageform_status check_points(const P& points, std::size_t dimension, std::size_t& stride) noexcept {
    stride = 0;
    if (points.count == 0) return CAGEFORM_OK;
    if (points.data == nullptr) return CAGEFORM_ARGUMENT_NULL;
    if (points.scalar > CAGEFORM_DOUBLE) return CAGEFORM_CHOICE_UNKNOWN;
    if (points.dimension != dimension) return CAGEFORM_DIMENSION_DIFFERS;
    const std::size_t number = points.scalar == CAGEFORM_FLOAT ? sizeof(float) : sizeof(double);
    const std::size_t size = number * dimension;
    stride = points.stride != 0 ? points.stride : size;
    if (reinterpret_cast<std::uintptr_t>(points.data) % number != 0 || stride % number != 0)
        return CAGEFORM_POINTS_MISALIGNED;
    const bool fits = stride >= size && points.bytes >= size &&
                      points.count - 1 <= (points.bytes - size) / stride && points.bytes <= PTRDIFF_MAX;
    return fits ? CAGEFORM_OK : CAGEFORM_POINTS_LEAVE_MEMORY;
}
/// Returns points of the scalar T as a view. If the points are invalid, returns an empty view and sets
/// `status`, unless it already contains an error.
template <class T, std::size_t D, class P>
auto view_of(const P& points, cageform_status& status) noexcept {
    using Number =
        std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(points.data)>>, const T, T>;
    std::size_t stride = 0;
    if (status == CAGEFORM_OK) status = check_points(points, D, stride);
    constexpr bool is_float = std::is_same_v<T, float>;
    if (status == CAGEFORM_OK && points.count > 0 && (points.scalar == CAGEFORM_FLOAT) != is_float)
        status = CAGEFORM_SCALAR_DIFFERS;
    return StridedPoints<Number, D>(static_cast<Number*>(points.data),
                                    status == CAGEFORM_OK ? points.count : 0,
                                    static_cast<std::ptrdiff_t>(stride));
}

/// An output of either scalar with D numbers an element. Discards values if the caller passed none.
template <std::size_t D>
class AnyOutput {
public:
    cageform_status set(const cageform_output* output, std::size_t count) noexcept {
        if (output == nullptr) return CAGEFORM_OK;
        output_ = *output;
        const cageform_status status = check_points(output_, D, stride_);
        if (status != CAGEFORM_OK) return status;
        return output_.count < count ? code_of(Status::output_too_small) : CAGEFORM_OK;
    }
    template <class T>
    void store(std::size_t n, const T* numbers) const noexcept {
        if (output_.data == nullptr) return;
        std::byte* const at = static_cast<std::byte*>(output_.data) + n * stride_;
        for (std::size_t k = 0; k < D; ++k) {
            if (output_.scalar == CAGEFORM_DOUBLE)
                reinterpret_cast<double*>(at)[k] = static_cast<double>(numbers[k]);
            else
                reinterpret_cast<float*>(at)[k] = static_cast<float>(numbers[k]);
        }
    }

private:
    cageform_output output_{};
    std::size_t stride_ = 0;
};

/// Makes an object and calls fill(object), which returns a status code.
template <class X, class Fill>
cageform_status make_filled(X** made, const Fill& fill) {
    struct Guard {
        X* object;
        ~Guard() { delete object; }
    } guard{new (std::nothrow) X{}};
    if (guard.object == nullptr) return CAGEFORM_OUT_OF_MEMORY;
    guard.object->kind = X::its_kind;
    guard.object->destroy = destroy_allocated<X>;
    const cageform_status status = fill(*guard.object);
    if (status == CAGEFORM_OK) *made = std::exchange(guard.object, nullptr);
    return status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c

struct cageform_figure : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::figure;

    cageform::detail::c::OfAnyType<cageform::PackedFigureView> view;
};
