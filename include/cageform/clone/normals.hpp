// Normals, tangents and Jacobians of a clone, every frame, from the vectors that `bind_vectors` bound.
#pragma once

#include <cageform/clone/clone.hpp>

#include <array>
#include <cmath>
#include <limits>

namespace cageform::inline CAGEFORM_ABI {

/// A view over square matrices that lie at regular distances in memory, column after column. Owns nothing and copies nothing.
///
///   matrix_stride  bytes from a matrix to the next
///   column_stride  bytes from a column to the next of its matrix (16 for float columns padded to four, as std430 has them)
template <class T, std::size_t D>
class StridedMatrices {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    constexpr StridedMatrices(T* data, std::size_t size, std::ptrdiff_t matrix_stride = D * D * sizeof(T),
                              std::ptrdiff_t column_stride = D * sizeof(T)) noexcept
        : data_(data)
        , size_(size)
        , matrix_stride_(matrix_stride)
        , column_stride_(column_stride) {}

    constexpr std::size_t size() const noexcept { return size_; }

    /// One column of all matrices.
    StridedPoints<T, D> column(std::size_t k) const noexcept {
        auto* const bytes =
            reinterpret_cast<std::byte*>(data_) + static_cast<std::ptrdiff_t>(k) * column_stride_;
        return {reinterpret_cast<T*>(bytes), size_, matrix_stride_};
    }

private:
    T* data_;
    std::size_t size_;
    std::ptrdiff_t matrix_stride_;
    std::ptrdiff_t column_stride_;
};

namespace detail {

/// The view of a binding, or what is one.
template <class B>
auto view_of(const B& binding) noexcept {
    if constexpr (requires { binding.view(); }) {
        return binding.view();
    } else {
        return binding;
    }
}

/// The vectors of a view at rest, D rows a block.
template <class View>
const auto* rest_of(const View& view) noexcept {
    if constexpr (requires { view.rest.data; }) {
        return view.rest.data;
    } else {
        return view.rest;
    }
}

/// What a view's places stand for; null: they are in order.
template <class View>
const std::uint32_t* order_of(const View& view) noexcept {
    if constexpr (requires { view.order; }) {
        return view.order;
    } else {
        return nullptr;
    }
}

template <class View>
bool same_order(const View& a, const View& b) noexcept {
    const auto *of_a = order_of(a), *of_b = order_of(b);
    if (of_a == of_b) return true;
    if (of_a == nullptr || of_b == nullptr) return false;
    for (std::size_t i = 0; i < a.point_count(); ++i) {
        if (of_a[i] != of_b[i]) return false;
    }
    return true;
}

/// The vectors of a few blocks, cloned in the order of their places.
template <class View>
class VectorTile {
public:
    using T = typename View::scalar;
    static constexpr std::size_t D = View::dimension;
    static constexpr std::size_t blocks = 32;

    explicit VectorTile(View view) noexcept
        : view_(view) {
        if constexpr (requires { view_.order; }) view_.order = nullptr;
    }

    template <class Pose>
    void load(const Pose& pose, std::size_t begin, std::size_t end) noexcept {
        Window window{moved_[0], begin * lane_count<T>, view_.point_count()};
        clone_blocks(view_, pose, window, CloneOptions<T>{}, begin, end);
        first_ = begin;
    }

    /// The moved vectors of a block, a row an axis, and those at rest.
    const Lanes<T>& moved_row(std::size_t block, std::size_t axis) const noexcept {
        return moved_[axis][block - first_];
    }
    const Lanes<T>& rest_row(std::size_t block, std::size_t axis) const noexcept {
        return rest_of(view_)[block * D + axis];
    }
    /// The moved vector at a place, and that at rest.
    Vec<T, D> moved(std::size_t place) const noexcept {
        Vec<T, D> v{};
        for (std::size_t k = 0; k < D; ++k) v[k] = moved_row(place / lane_count<T>, k)[place % lane_count<T>];
        return v;
    }
    Vec<T, D> rest(std::size_t place) const noexcept {
        return block_point<D>(BlockView<const T>{rest_of(view_), D, view_.point_count()}, place);
    }

private:
    /// Writes the points of the tile into its memory, an axis after the other.
    struct Window {
        Lanes<T>* memory;
        std::size_t first, count;

        std::size_t size() const noexcept { return count; }
        /// As StridedPoints: point 0's place, were it in the tile.
        T* plain_axis(std::size_t k) const noexcept { return memory[k * blocks].v - first; }
        Vec<T, D> operator[](std::size_t i) const noexcept {
            Vec<T, D> v{};
            for (std::size_t k = 0; k < D; ++k) v[k] = plain_axis(k)[i];
            return v;
        }
        void store(std::size_t i, const Vec<T, D>& v) const noexcept {
            for (std::size_t k = 0; k < D; ++k) plain_axis(k)[i] = v[k];
        }
    };

    View view_;
    std::size_t first_ = 0; ///< block
    Lanes<T> moved_[D][blocks];
};

/// Blocks [begin, end) of a clone into one column of matrices.
template <class View, class Pose, class S, std::size_t D>
void clone_column(const View& view, const Pose& pose, const StridedPoints<S, D>& column, std::size_t begin,
                  std::size_t end) noexcept {
    struct Column : StridedPoints<S, D> { // of this namespace, so that views declared later are found
        explicit Column(const StridedPoints<S, D>& points) noexcept
            : StridedPoints<S, D>(points) {}
    };
    Column out(column);
    clone_blocks(view, pose, out, CloneOptions<typename View::scalar>{}, begin, end);
}

/// A vector as a pose moves it: that it came from one of the size of `rest` leaves roundings of that size in it, and what is
/// smaller has no direction.
template <Scalar T, std::size_t D>
struct Direction {
    static constexpr T some_roundings = 64 * epsilon<T>;

    Vec<T, D> along{}; ///< its largest component ±1, so that squares neither vanish nor overflow
    T doubt = 1;       ///< the size of errors of `along`

    Direction(const Vec<T, D>& v, const Vec<T, D>& rest) noexcept {
        const T size = largest_component(v), before = largest_component(rest);
        if (!is_finite(v) || !(size > some_roundings * before) || !(size > 0)) return;
        for (std::size_t k = 0; k < D; ++k) along[k] = v[k] / size;
        doubt = some_roundings * (before > size ? before / size : T(1));
    }
    bool exists() const noexcept { return doubt < 1; }
    Vec<T, D> unit() const noexcept { return (1 / std::sqrt(dot(along, along))) * along; }

private:
    static T largest_component(const Vec<T, D>& v) noexcept {
        T largest = 0;
        for (std::size_t k = 0; k < D; ++k) {
            const T size = v[k] < 0 ? -v[k] : v[k];
            largest = size > largest ? size : largest;
        }
        return largest;
    }
};

/// The unit normal across two tangents, and the first of unit length; false where they are parallel to rounding.
template <Scalar T>
bool frame_across(const Direction<T, 3>& t, const Direction<T, 3>& b, Vec<T, 3>& normal,
                  Vec<T, 3>& tangent) noexcept {
    if (!t.exists() || !b.exists()) return false;
    const auto across = cross(t.along, b.along);
    const T length2 = dot(across, across), doubt = t.doubt + b.doubt;
    if (!(length2 > doubt * doubt)) return false;
    normal = (1 / std::sqrt(length2)) * across;
    tangent = t.unit();
    return true;
}

/// The frame of a place as the pose moves it; where it has none, that at rest; else zero.
template <class Tile>
void frame_of_place(const Tile& along, const Tile& across, std::size_t place,
                    Vec<typename Tile::T, 3>& normal, Vec<typename Tile::T, 3>& tangent) noexcept {
    using T = typename Tile::T;
    const auto t = along.rest(place), b = across.rest(place);
    normal = tangent = {};
    if (frame_across<T>({along.moved(place), t}, {across.moved(place), b}, normal, tangent)) return;
    (void)frame_across<T>({t, t}, {b, b}, normal, tangent);
}

/// The same for a whole block, a row an axis. Places where there is any doubt take the careful way above.
template <class Tile>
void frames_of_block(const Tile& along, const Tile& across, std::size_t block, std::size_t points,
                     Lanes<typename Tile::T> (&normal)[3], Lanes<typename Tile::T> (&tangent)[3]) noexcept {
    using T = typename Tile::T;
    using P = Simd<T>;
    P t[3], b[3], t_rest[3], b_rest[3];
    for (std::size_t k = 0; k < 3; ++k) {
        t[k] = P::load(along.moved_row(block, k));
        b[k] = P::load(across.moved_row(block, k));
        t_rest[k] = P::load(along.rest_row(block, k));
        b_rest[k] = P::load(across.rest_row(block, k));
    }
    const P n[3] = {t[1] * b[2] - t[2] * b[1], t[2] * b[0] - t[0] * b[2], t[0] * b[1] - t[1] * b[0]};
    const auto square = [](const P* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
    const P nn = square(n), tt = square(t), bb = square(b);
    // No less than a hundredth of what they were, no more than half a degree from parallel, all squares within range.
    const P some(T(1e-4)), least((std::numeric_limits<T>::min)() * T(1e12)),
        most((std::numeric_limits<T>::max)() * T(1e-12));
    const auto clear = (some * square(t_rest) <= tt) & (some * square(b_rest) <= bb) &
                       (some * (tt * bb) <= nn) & (least <= nn) & (nn <= most) & (least <= tt) &
                       (tt <= most) & (least <= bb) & (bb <= most);
    Lanes<T> is_clear, of_n, of_t;
    select<T>(clear, P(T(1)), P(T(0))).store(is_clear);
    select<T>(clear, nn, P(T(1))).store(of_n);
    select<T>(clear, tt, P(T(1))).store(of_t);
    for (T& x : of_n.v) x = 1 / std::sqrt(x);
    for (T& x : of_t.v) x = 1 / std::sqrt(x);
    for (std::size_t k = 0; k < 3; ++k) {
        (n[k] * P::load(of_n)).store(normal[k]);
        (t[k] * P::load(of_t)).store(tangent[k]);
    }
    const std::size_t first = block * lane_count<T>;
    for (std::size_t lane = 0; lane < lane_count<T> && first + lane < points; ++lane) {
        if (is_clear[lane] != T(0)) continue;
        Vec<T, 3> of_place, tangent_of_place;
        frame_of_place(along, across, first + lane, of_place, tangent_of_place);
        for (std::size_t k = 0; k < 3; ++k) {
            normal[k][lane] = of_place[k];
            tangent[k][lane] = tangent_of_place[k];
        }
    }
}

/// Runs body(i, normal, tangent) for all points.
template <class View, class Pose, class Parallel, class Body>
void for_moved_frames(const Pose& pose, const Parallel& parallel_for, const View& tangents,
                      const View& bitangents, const Body& body) noexcept {
    using T = typename View::scalar;
    const std::size_t points = tangents.point_count();
    parallel_for(block_count<T>(points), clone_grain, [&](std::size_t begin, std::size_t end) {
        VectorTile<View> along(tangents), across(bitangents);
        for (std::size_t from = begin; from < end; from += VectorTile<View>::blocks) {
            const std::size_t to =
                end - from < VectorTile<View>::blocks ? end : from + VectorTile<View>::blocks;
            along.load(pose, from, to);
            across.load(pose, from, to);
            for (std::size_t block = from; block < to; ++block) {
                Lanes<T> normal[3], tangent[3];
                frames_of_block(along, across, block, points, normal, tangent);
                const std::size_t first = block * lane_count<T>;
                for (std::size_t lane = 0; lane < lane_count<T> && first + lane < points; ++lane) {
                    const std::size_t place = first + lane;
                    body(order_of(tangents) != nullptr ? order_of(tangents)[place] : place,
                         Vec<T, 3>{normal[0][lane], normal[1][lane], normal[2][lane]},
                         Vec<T, 3>{tangent[0][lane], tangent[1][lane], tangent[2][lane]});
                }
            }
        }
    });
}

/// Runs body(tile, place, i) for all points: `i` is the point that lies at `place`.
template <class View, class Pose, class Parallel, class Body>
void for_moved_vectors(const Pose& pose, const Parallel& parallel_for, const Body& body,
                       const View& view) noexcept {
    using T = typename View::scalar;
    parallel_for(block_count<T>(view.point_count()), clone_grain, [&](std::size_t begin, std::size_t end) {
        VectorTile<View> tile(view);
        constexpr std::size_t step = VectorTile<View>::blocks;
        for (std::size_t from = begin; from < end; from += step) {
            const std::size_t to = end - from < step ? end : from + step;
            tile.load(pose, from, to);
            const std::size_t last = to * lane_count<T>, count = view.point_count();
            for (std::size_t place = from * lane_count<T>; place < last && place < count; ++place)
                body(tile, place, order_of(view) != nullptr ? order_of(view)[place] : place);
        }
    });
}

} // namespace detail

/// A Binding, or a view that `clone` reads, of dimension `D`; for packed ones include clone/clone_packed.hpp too.
template <class B, std::size_t D>
concept VectorBinding = requires(const B& binding) {
    typename B::scalar;
    requires B::dimension == D;
    { binding.point_count() } -> std::convertible_to<std::size_t>;
    { binding.handle_count() } -> std::convertible_to<std::size_t>;
};

/// The normals of the moved figure, of unit length: n' = cross(t', b') / |…|, t' and b' being two bound tangents as the pose
/// moves them (`bind_vectors`, `tangents_of`). They are those of the deformed surface itself, not of its triangles.
///
///   tangents, bitangents  bindings of vectors with cross(tangent, bitangent) along the normal, of the same points, in the
///                         same order
///   pose                  as for `clone`
///   normals               out, any MutablePointRange of at least #points places
///   degenerate            where the tangents are moved onto one line or to nothing (to some roundings of what they were), the normal at rest;
///                         where they are so at rest, zero
///   returns               as `clone`; `normals` is then untouched
///   cost                  that of two clones, and a square root a point; no allocation
///
/// A pose that mirrors turns normals as it turns the winding of triangles: they stay cross(t', b').
template <VectorBinding<3> B, PointRange Pose, class Out, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == 3 &&
             range_dimension<std::remove_reference_t<Out>> == 3)
Status clone_normals(const B& tangents, const B& bitangents, const Pose& pose, Out&& normals,
                     const Parallel& parallel_for = {})
noexcept {
    const auto t = detail::view_of(tangents), b = detail::view_of(bitangents);
    using T = typename B::scalar;
    CAGEFORM_ASSERT(t.point_count() == b.point_count() && t.handle_count() == b.handle_count() &&
                        detail::same_order(t, b),
                    "tangents and bitangents of the same points");
    const Status status = detail::check_clone(t, pose, normals, CloneOptions<T>{});
    if (status != Status::ok) return status;
    detail::for_moved_frames(
        pose, parallel_for, t, b,
        [&](std::size_t i, const Vec<T, 3>& normal, const Vec<T, 3>&) { store_point(normals, i, normal); });
    return Status::ok;
}

/// The same in the plane, from one binding: the moved tangent, turned counter-clockwise by 90 degrees.
template <VectorBinding<2> B, PointRange Pose, class Out, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == 2 &&
             range_dimension<std::remove_reference_t<Out>> == 2)
Status clone_normals(const B& tangents, const Pose& pose, Out&& normals, const Parallel& parallel_for = {})
noexcept {
    const auto t = detail::view_of(tangents);
    using T = typename B::scalar;
    const Status status = detail::check_clone(t, pose, normals, CloneOptions<T>{});
    if (status != Status::ok) return status;
    detail::for_moved_vectors(
        pose, parallel_for,
        [&](const auto& along, std::size_t place, std::size_t i) {
            const auto rest = along.rest(place);
            detail::Direction<T, 2> direction(along.moved(place), rest);
            if (!direction.exists()) direction = {rest, rest};
            const auto unit = direction.exists() ? direction.unit() : Vec<T, 2>{};
            store_point(normals, i, Vec<T, 2>{-unit[1], unit[0]});
        },
        t);
    return Status::ok;
}

/// Normals as `clone_normals`, and with them the moved tangents, of unit length and orthogonal to the normals.
///
///   unit_tangents  out, at least #points places. For tangents of four numbers (glTF) a StridedPoints of 16 bytes' stride:
///                  the fourth, the sign of the texture's handedness, is not touched, and no pose changes it
///   degenerate     where the normal is that at rest, so is the tangent
template <VectorBinding<3> B, PointRange Pose, class Out, class TangentsOut, class Parallel = SerialFor>
    requires(MutablePointRange<std::remove_reference_t<Out>>&& range_dimension<Pose> == 3 &&
             range_dimension<std::remove_reference_t<Out>> == 3 &&
             MutablePointRange<std::remove_reference_t<TangentsOut>> &&
             range_dimension<std::remove_reference_t<TangentsOut>> == 3)
Status clone_tangent_frames(const B& tangents, const B& bitangents, const Pose& pose, Out&& normals,
                            TangentsOut&& unit_tangents, const Parallel& parallel_for = {})
noexcept {
    const auto t = detail::view_of(tangents), b = detail::view_of(bitangents);
    using T = typename B::scalar;
    CAGEFORM_ASSERT(t.point_count() == b.point_count() && t.handle_count() == b.handle_count() &&
                        detail::same_order(t, b),
                    "tangents and bitangents of the same points");
    if (std::size(unit_tangents) < t.point_count()) return Status::output_too_small;
    const Status status = detail::check_clone(t, pose, normals, CloneOptions<T>{});
    if (status != Status::ok) return status;
    detail::for_moved_frames(pose, parallel_for, t, b,
                             [&](std::size_t i, const Vec<T, 3>& normal, const Vec<T, 3>& tangent) {
                                 store_point(normals, i, normal);
                                 store_point(unit_tangents, i, tangent);
                             });
    return Status::ok;
}

/// The Jacobians of the deformation at all points, for those who deform more than points: a splat of covariance Σ becomes one
/// of J Σ Jᵀ.
///
///   columns    bindings of the D axes (`bind_jacobians`)
///   jacobians  out, at least #points matrices: column k is where axis k goes
///   returns    as `clone`; `jacobians` is then untouched
///   cost       that of D clones; no allocation. The unmoved pose gives the identity, to the bit
template <class B, std::size_t D, PointRange Pose, class S, class Parallel = SerialFor>
    requires(VectorBinding<B, D>&& range_dimension<Pose> == D)
Status clone_jacobians(const std::array<B, D>& columns, const Pose& pose,
                       const StridedMatrices<S, D>& jacobians, const Parallel& parallel_for = {})
noexcept {
    using T = typename B::scalar;
    const auto first = detail::view_of(columns[0]);
    const Status status = detail::check_clone(first, pose, jacobians.column(0), CloneOptions<T>{});
    if (status != Status::ok) return status;
    for (const B& column : columns) {
        CAGEFORM_ASSERT(column.point_count() == first.point_count() &&
                            column.handle_count() == first.handle_count(),
                        "columns of the same points");
        (void)column;
    }
    parallel_for(
        block_count<T>(first.point_count()), detail::clone_grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = 0; k < D; ++k)
                detail::clone_column(detail::view_of(columns[k]), pose, jacobians.column(k), begin, end);
        });
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI
