// The functions of the C interface that a game calls.
#pragma once

#include <cageform/c/detail/clone_view.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/pose/types/pose_blob.hpp>
#include <cageform/version.hpp>

struct cageform_player : cageform::detail::c::Object {
    static constexpr Kind its_kind = Kind::player;
    /// A clip, its cursor, and the pose at a time.
    template <class T, std::size_t D>
    struct Playing {
        using scalar = T;
        static constexpr std::size_t dimension = D;

        cageform::CageClipView<T, D> clip;
        cageform::CurveCursor<T> cursor;
        std::span<cageform::Vec<T, D>> pose;
    };

    cageform::detail::c::OfAnyType<Playing> playing;
    std::string_view name;
};

namespace cageform::inline CAGEFORM_ABI::detail::c {

inline constexpr const char* own_text(cageform_status status) noexcept {
    switch (status) {
#define CAGEFORM_TEXT_CASE(code, NAME, name, text)                                                           \
    case CAGEFORM_##NAME: return text;
        CAGEFORM_C_STATUSES(CAGEFORM_TEXT_CASE)
#undef CAGEFORM_TEXT_CASE
#define CAGEFORM_TEXT_CASE(code, NAME, name)                                                                 \
    case CAGEFORM_##NAME: return to_string(Status::name);
        CAGEFORM_STATUSES(CAGEFORM_TEXT_CASE)
#undef CAGEFORM_TEXT_CASE
    default: return "unknown status";
    }
}
inline constexpr const char* own_name(cageform_status status) noexcept {
    switch (status) {
#define CAGEFORM_NAME_CASE(code, NAME, name, text)                                                           \
    case CAGEFORM_##NAME: return #name;
        CAGEFORM_C_STATUSES(CAGEFORM_NAME_CASE)
#undef CAGEFORM_NAME_CASE
#define CAGEFORM_NAME_CASE(code, NAME, name)                                                                 \
    case CAGEFORM_##NAME: return #name;
        CAGEFORM_STATUSES(CAGEFORM_NAME_CASE)
#undef CAGEFORM_NAME_CASE
    default: return "unknown";
    }
}

/// The size of an object, rounded up to a multiple of 64 bytes; `more` bytes of make_object follow it.
template <class X>
constexpr std::size_t object_bytes = (sizeof(X) + 63) / 64 * 64;

/// Makes an object in the caller's memory, or in allocated memory if `memory` is null. `more` bytes follow
/// the object.
template <class X, class Fill>
cageform_status make_object(void* memory, std::size_t bytes, std::size_t more, const Fill& fill,
                            X** made) noexcept {
    constexpr std::size_t line = 64, own = object_bytes<X>;
    static_assert(alignof(X) <= line);
    const bool is_callers = memory != nullptr;
    if (is_callers && (bytes < own + more || reinterpret_cast<std::uintptr_t>(memory) % line != 0))
        return CAGEFORM_MEMORY_TOO_SMALL;
    if (!is_callers) memory = ::operator new(own + more, std::align_val_t{line}, std::nothrow);
    if (memory == nullptr) return CAGEFORM_OUT_OF_MEMORY;
    X* const object = ::new (memory) X{};
    object->kind = X::its_kind;
    object->destroy =
        is_callers ? [](Object* x) noexcept { static_cast<X*>(x)->~X(); } : [](Object* x) noexcept {
            static_cast<X*>(x)->~X();
            ::operator delete(static_cast<void*>(x), std::align_val_t{line});
        };
    fill(*object, static_cast<std::byte*>(memory) + own);
    *made = object;
    return CAGEFORM_OK;
}
/// The scalar and the dimension in the header of packed data; float in 3D if there is no known header.
struct BlobType {
    std::uint32_t scalar = CAGEFORM_FLOAT, dimension = 3;

    BlobType(const void* data, std::size_t bytes) noexcept {
        std::uint64_t magic = 0;
        if (bytes >= sizeof(magic)) std::memcpy(&magic, data, sizeof(magic));
        const auto read = [&](auto header) {
            if (magic != header.magic || bytes < sizeof(header)) return;
            std::memcpy(&header, data, sizeof(header));
            scalar = header.scalar_bytes == sizeof(double) ? CAGEFORM_DOUBLE : CAGEFORM_FLOAT;
            dimension = header.dimension == 2 ? 2 : 3;
        };
        read(BlobHeader{});
        read(FigureHeader{});
        read(ClipHeader{});
        read(PoseBlobHeader{});
    }
};

/// Returns the bytes of a player beyond those of the object.
template <class T, std::size_t D>
std::size_t playing_bytes(const CageClipView<T, D>& clip) noexcept {
    return clip.cursor_rows() * sizeof(Lanes<T>) + clip.vertex_count() * sizeof(Vec<T, D>);
}

template <class T, std::size_t D>
cageform_status play(const CageClipView<T, D>& clip, std::string_view name,
                     const cageform_play_options& options, cageform_player** made) {
    const std::size_t rows = clip.cursor_rows() * sizeof(Lanes<T>);
    return make_object(
        options.memory, options.memory_bytes, playing_bytes(clip),
        [&](cageform_player& player, std::byte* memory) {
            auto* const lanes = reinterpret_cast<Lanes<T>*>(memory);
            for (std::size_t n = 0; n < clip.cursor_rows(); ++n)
                ::new (static_cast<void*>(lanes + n)) Lanes<T>{};
            auto* const points = reinterpret_cast<Vec<T, D>*>(memory + rows);
            for (std::size_t n = 0; n < clip.vertex_count(); ++n)
                ::new (static_cast<void*>(points + n)) Vec<T, D>{};
            player.playing = cageform_player::Playing<T, D>{
                clip, clip.make_cursor(std::span<Lanes<T>>(lanes, clip.cursor_rows())),
                std::span<Vec<T, D>>(points, clip.vertex_count())};
            player.name = name;
        },
        made);
}

} // namespace cageform::inline CAGEFORM_ABI::detail::c

extern "C" {

uint32_t cageform_abi_version(void) {
    return CAGEFORM_C_ABI;
}
const char* cageform_version(void) {
    return CAGEFORM_VERSION_STRING;
}
const char* cageform_status_text(cageform_status status) {
    return cageform::detail::c::own_text(status);
}
const char* cageform_status_name(cageform_status status) {
    return cageform::detail::c::own_name(status);
}

cageform_status cageform_free(void* object) {
    using cageform::detail::c::Object;
    if (object == nullptr) return CAGEFORM_OK;
    auto* const its = static_cast<Object*>(object);
    if (its->kind < Object::Kind::figure || its->kind >= Object::Kind::none)
        return CAGEFORM_OBJECT_OF_ANOTHER_KIND;
    const auto destroy = its->destroy;
    *const_cast<volatile Object::Kind*>(&its->kind) = Object::Kind::none;
    destroy(its);
    return CAGEFORM_OK;
}

size_t cageform_figure_bytes(void) {
    return cageform::detail::c::object_bytes<cageform_figure>;
}

cageform_status cageform_open(const void* data, size_t bytes, const cageform_open_options* options,
                              cageform_figure** figure, size_t* culprit) {
    namespace c = cageform::detail::c;
    if (culprit != nullptr) *culprit = 0;
    if (data == nullptr || figure == nullptr) return CAGEFORM_ARGUMENT_NULL;
    cageform_open_options own;
    const cageform_status status = c::read_struct(options, own);
    if (status != CAGEFORM_OK) return status;
    const cageform::BlobExpectation expected{own.cage_hash, own.figure_hash,
                                             own.skip_checksum != 0 ? cageform::BlobCheck::structure
                                                                    : cageform::BlobCheck::all};
    const c::BlobType type(data, bytes);
    return c::with_type(type.scalar, type.dimension, [&]<class T, std::size_t D>() {
        const std::span memory(static_cast<const std::byte*>(data), bytes);
        const auto opened = cageform::open<T, D>(memory, expected);
        if (culprit != nullptr) *culprit = opened.report.culprit.number;
        if (opened.report.status != cageform::Status::ok) return c::code_of(opened.report.status);
        return c::make_object(
            own.memory, own.memory_bytes, 0,
            [&](cageform_figure& made, std::byte*) { made.view = opened.value; }, figure);
    });
}

cageform_status cageform_open_level(const cageform_figure* figure, size_t level,
                                    const cageform_open_options* options, cageform_figure** opened) {
    namespace c = cageform::detail::c;
    cageform_open_options own;
    cageform_status status = c::check_object(figure);
    if (status == CAGEFORM_OK && opened == nullptr) status = CAGEFORM_ARGUMENT_NULL;
    if (status == CAGEFORM_OK) status = c::read_struct(options, own);
    if (status != CAGEFORM_OK) return status;
    return c::with(figure->view, [&](const auto& view) {
        const auto found = cageform::open_level(view, level);
        if (!found) return c::code_of(found.status());
        return c::make_object(
            own.memory, own.memory_bytes, 0,
            [&](cageform_figure& made, std::byte*) { made.view = found.value; }, opened);
    });
}

cageform_status cageform_figure_describe(const cageform_figure* figure, cageform_figure_info* info) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(figure); code != CAGEFORM_OK) return code;
    return c::with(figure->view, [&](const auto& view) {
        using View = std::remove_cvref_t<decltype(view)>;
        cageform_figure_info its{};
        its.points = view.point_count();
        its.handles = view.handle_count();
        its.vertices = its.handles - view.handle_view().vector_count();
        its.clips = view.clip_count();
        its.levels = view.level_count();
        its.scalar = c::scalar_code<View>;
        its.dimension = View::dimension;
        its.has_normals = view.has_normals() ? 1 : 0;
        its.has_tangents = view.has_tangents() ? 1 : 0;
        its.has_labels = view.labels.begin != nullptr ? 1 : 0;
        const auto origin = view.template part_as<double>("ORIG");
        if (origin.size() == View::dimension) std::copy(origin.begin(), origin.end(), its.origin);
        return c::write_struct(its, info);
    });
}

cageform_status cageform_figure_rest(const cageform_figure* figure, cageform_output handles) {
    namespace c = cageform::detail::c;
    cageform_status status = c::check_object(figure);
    if (status != CAGEFORM_OK) return status;
    return c::with(figure->view, [&]<class T, std::size_t D>(const cageform::PackedFigureView<T, D>& view) {
        const auto out = c::view_of<T, D>(handles, status);
        if (status != CAGEFORM_OK) return status;
        if (out.size() < view.handle_count()) return c::code_of(cageform::Status::output_too_small);
        for (std::size_t i = 0; i < view.handle_count(); ++i) out.store(i, view.points.rest_handles[i]);
        return status;
    });
}

cageform_status cageform_figure_label(const cageform_figure* figure, size_t handle, const char** text,
                                      size_t* length) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(figure); code != CAGEFORM_OK) return code;
    if (text == nullptr || length == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::with(figure->view, [&](const auto& view) {
        if (handle >= view.handle_count()) return cageform_status(CAGEFORM_INDEX_OUT_OF_BOUNDS);
        const std::string_view label = view.label(handle);
        *text = label.data();
        *length = label.size();
        return cageform_status(CAGEFORM_OK);
    });
}
cageform_status cageform_figure_find_handle(const cageform_figure* figure, const char* text, size_t length,
                                            size_t* handle) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(figure); code != CAGEFORM_OK) return code;
    if ((text == nullptr && length > 0) || handle == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::with(figure->view, [&](const auto& view) {
        const std::size_t found = view.find_handle({text, length});
        *handle = found < view.handle_count() ? found : CAGEFORM_NONE;
        return cageform_status(CAGEFORM_OK);
    });
}

cageform_status cageform_clone(const cageform_figure* figure, cageform_points pose, cageform_output points,
                               const cageform_output* normals, const cageform_output* tangents,
                               const cageform_running* running) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(figure); code != CAGEFORM_OK) return code;
    if (normals == nullptr && tangents != nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::with(figure->view, [&](const auto& view) {
        return c::clone_view(view, pose, points, normals, tangents, running);
    });
}

cageform_status cageform_clone_transposed(const cageform_figure* figure, cageform_points gradients,
                                          cageform_output handles, const cageform_running* running) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(figure); code != CAGEFORM_OK) return code;
    return c::with(figure->view, [&](const auto& view) {
        return c::clone_view_transposed(view.points, gradients, handles, running);
    });
}

cageform_status cageform_pose_handles(const cageform_figure* figure, cageform_points vertices,
                                      cageform_output handles) {
    namespace c = cageform::detail::c;
    cageform_status status = c::check_object(figure);
    if (status != CAGEFORM_OK) return status;
    return c::with(figure->view, [&]<class T, std::size_t D>(const cageform::PackedFigureView<T, D>& view) {
        const auto source = c::view_of<T, D>(vertices, status);
        const auto out = c::view_of<T, D>(handles, status);
        return status != CAGEFORM_OK ? status : c::code_of(pose_handles(view, source, out).status);
    });
}

cageform_status cageform_figure_find_clip(const cageform_figure* figure, const char* name, size_t length,
                                          size_t* clip) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(figure); code != CAGEFORM_OK) return code;
    if ((name == nullptr && length > 0) || clip == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::with(figure->view, [&](const auto& view) {
        const std::size_t found = view.find_clip({name, length});
        *clip = found < view.clip_count() ? found : CAGEFORM_NONE;
        return cageform_status(CAGEFORM_OK);
    });
}

cageform_status cageform_play(const cageform_figure* figure, size_t clip,
                              const cageform_play_options* options, cageform_player** player) {
    namespace c = cageform::detail::c;
    cageform_play_options own;
    cageform_status status = c::check_object(figure);
    if (status == CAGEFORM_OK && player == nullptr) status = CAGEFORM_ARGUMENT_NULL;
    if (status == CAGEFORM_OK) status = c::read_struct(options, own);
    if (status != CAGEFORM_OK) return status;
    return c::with(figure->view, [&](const auto& view) {
        if (clip >= view.clip_count()) return cageform_status(CAGEFORM_INDEX_OUT_OF_BOUNDS);
        return c::play(view.clip(clip), view.clip_name(clip), own, player);
    });
}

cageform_status cageform_player_bytes(const cageform_figure* figure, size_t clip, size_t* bytes) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(figure); code != CAGEFORM_OK) return code;
    if (bytes == nullptr) return CAGEFORM_ARGUMENT_NULL;
    return c::with(figure->view, [&](const auto& view) {
        if (clip >= view.clip_count()) return cageform_status(CAGEFORM_INDEX_OUT_OF_BOUNDS);
        const auto its = view.clip(clip);
        *bytes = c::object_bytes<cageform_player> + c::playing_bytes(its);
        return cageform_status(CAGEFORM_OK);
    });
}

cageform_status cageform_play_bytes(const void* data, size_t bytes, const cageform_play_options* options,
                                    cageform_player** player) {
    namespace c = cageform::detail::c;
    if (data == nullptr || player == nullptr) return CAGEFORM_ARGUMENT_NULL;
    cageform_play_options own;
    const cageform_status status = c::read_struct(options, own);
    if (status != CAGEFORM_OK) return status;
    const c::BlobType type(data, bytes);
    return c::with_type(type.scalar, type.dimension, [&]<class T, std::size_t D>() {
        const auto opened = cageform::open_clip<T, D>({static_cast<const std::byte*>(data), bytes},
                                                      own.skip_checksum != 0 ? cageform::BlobCheck::structure
                                                                             : cageform::BlobCheck::all);
        if (!opened) return c::code_of(opened.status());
        return c::play(opened.value, {}, own, player);
    });
}

cageform_status cageform_player_describe(const cageform_player* player, cageform_clip_info* info) {
    namespace c = cageform::detail::c;
    if (const auto code = c::check_object(player); code != CAGEFORM_OK) return code;
    return c::with(player->playing, [&](const auto& playing) {
        using Playing = std::remove_cvref_t<decltype(playing)>;
        cageform_clip_info its{};
        its.vertices = playing.clip.vertex_count();
        its.begin = playing.clip.begin();
        its.end = playing.clip.end();
        its.scalar = c::scalar_code<Playing>;
        its.dimension = Playing::dimension;
        its.name = player->name.data();
        its.name_length = player->name.size();
        return c::write_struct(its, info);
    });
}

cageform_status cageform_player_sample(cageform_player* player, double time, cageform_output pose) {
    namespace c = cageform::detail::c;
    cageform_status status = c::check_object(player);
    if (status != CAGEFORM_OK) return status;
    return c::with(player->playing, [&]<class T, std::size_t D>(cageform_player::Playing<T, D>& playing) {
        const auto out = c::view_of<T, D>(pose, status);
        if (status != CAGEFORM_OK) return status;
        if (out.size() < playing.pose.size()) return c::code_of(cageform::Status::output_too_small);
        if (!cageform::is_finite(static_cast<T>(time))) return c::code_of(cageform::Status::value_not_finite);
        playing.clip.sample(time, playing.cursor, playing.pose);
        for (std::size_t i = 0; i < playing.pose.size(); ++i) out.store(i, playing.pose[i]);
        return status;
    });
}

} // extern "C"
