// Bindings, poses and clips out of thin air, without bind time: every number is made of whole ones, and is
// the same on every machine.
#pragma once

#include <cageform/clip/clip_blob.hpp>
#include <cageform/figure/figure.hpp>

#include <utility>

namespace made_up {

using cageform::Vec;
using cageform::WeightFormat;

class Numbers {
public:
    explicit Numbers(std::uint32_t seed) noexcept
        : state_(seed) {}

    std::uint32_t next() noexcept {
        state_ = state_ * 1664525u + 1013904223u;
        return state_ >> 16;
    }
    std::uint32_t below(std::uint32_t end) noexcept { return next() % end; }
    /// In [-1, 1): sixteen bits, so that float holds them.
    template <class T>
    T fraction() noexcept {
        return T(int(next()) - 32768) / T(32768);
    }

private:
    std::uint32_t state_;
};

template <class T, std::size_t D>
std::vector<Vec<T, D>> points(std::size_t count, std::uint32_t seed) {
    Numbers numbers(seed);
    std::vector<Vec<T, D>> points(count);
    for (auto& p : points) {
        for (std::size_t k = 0; k < D; ++k) p[k] = 4 * numbers.fraction<T>();
    }
    return points;
}

template <class T, std::size_t D>
cageform::Binding<T, D> binding(std::size_t points, std::size_t handles, std::uint32_t seed) {
    Numbers numbers(seed);
    const auto blocks = cageform::block_count<T>(points);
    std::vector<cageform::Lanes<T>> weights(blocks * handles), rest(blocks * D);
    for (auto& row : weights) {
        for (T& w : row.v) w = numbers.fraction<T>() / T(handles);
    }
    for (auto& row : rest) {
        for (T& x : row.v) x = 4 * numbers.fraction<T>();
    }
    return {std::move(weights), std::move(rest), made_up::points<T, D>(handles, seed + 1000), points};
}

/// With rows for some handles of each block and points in an order of their own, if `sparse`.
template <class T, std::size_t D>
cageform::PackedBinding<T, D> packed_binding(WeightFormat format, bool sparse, std::size_t points,
                                             std::size_t handles, std::uint32_t seed) {
    Numbers numbers(seed);
    constexpr auto lanes = cageform::lane_count<T>;
    const auto blocks = cageform::block_count<T>(points);
    const auto has_row = [sparse](std::size_t block, std::size_t handle) {
        return !sparse || (handle * handle + block) % 5 < 2;
    };
    cageform::BlobHeader header;
    header.format = std::uint32_t(format);
    header.handles = handles;
    header.points = points;
    header.row_begin = header.order = sparse ? 1 : 0;
    for (std::size_t b = 0; b < blocks; ++b) {
        for (std::size_t h = 0; h < handles; ++h) header.rows += has_row(b, h) ? 1 : 0;
    }
    cageform::PackedBinding<T, D> packed(header);
    const auto view = packed.view();
    const auto put = []<class X>(const X* part, std::size_t n, X x) { const_cast<X*>(part)[n] = x; };
    const auto put_row = [&]<class Make>(const cageform::Lanes<T>* part, std::size_t n, const Make& make) {
        for (std::size_t lane = 0; lane < lanes; ++lane) put(part[n].v, lane, T(make()));
    };
    if (sparse) {
        std::size_t row = 0;
        for (std::size_t b = 0; b < blocks; ++b) {
            put(view.row_begin, b, std::uint32_t(row));
            for (std::size_t h = 0; h < handles; ++h) {
                if (has_row(b, h)) put(view.row_handle, row++, std::uint16_t(h));
            }
        }
        put(view.row_begin, blocks, std::uint32_t(row));
        for (std::size_t i = 0; i < points; ++i) put(view.order, i, std::uint32_t(points - 1 - i));
    }
    for (std::size_t n = 0; n < header.rows * lanes; ++n) {
        const auto write = [&](auto weight) {
            std::memcpy(const_cast<std::byte*>(view.weights) + n * sizeof(weight), &weight, sizeof(weight));
        };
        switch (format) {
        case WeightFormat::scalar: write(T(numbers.fraction<T>() / T(handles))); break;
        case WeightFormat::half: // 2^-7 … 2^-2, of both signs
            write(std::uint16_t((numbers.below(2) << 15) | ((8 + numbers.below(5)) << 10) |
                                numbers.below(1024)));
            break;
        case WeightFormat::int16: write(std::int16_t(int(numbers.below(65535)) - 32767)); break;
        case WeightFormat::int8: write(std::int8_t(int(numbers.below(255)) - 127)); break;
        }
    }
    for (std::size_t b = 0; b < blocks; ++b) {
        for (std::size_t k = 0; k < D; ++k)
            put_row(view.rest, b * D + k, [&] { return 4 * numbers.fraction<T>(); });
        if (view.scale == nullptr) continue;
        const T unit = format == WeightFormat::half    ? T(1)
                       : format == WeightFormat::int16 ? T(32767)
                                                       : T(127);
        put(view.scale, b, T(1 + numbers.fraction<T>() / 4) / (unit * T(handles)));
        for (std::size_t k = 0; k <= D; ++k)
            put_row(view.residual, b * (D + 1) + k, [&] { return numbers.fraction<T>() / 64; });
    }
    for (std::size_t h = 0; h < handles; ++h) {
        Vec<T, D> place{};
        for (std::size_t k = 0; k < D; ++k) place[k] = 4 * numbers.fraction<T>();
        put(view.rest_handles, h, place);
        if (view.affine_fit == nullptr) continue;
        Vec<T, D + 1> fit{};
        for (std::size_t k = 0; k <= D; ++k) fit[k] = numbers.fraction<T>() / T(handles);
        put(view.affine_fit, h, fit);
    }
    packed.seal();
    return packed;
}

/// A clip of some vertices, each of its curves with knots of its own.
template <class T, std::size_t D>
cageform::CageClip<T, D> clip(std::size_t vertices, cageform::Extrapolation outside, std::uint32_t seed) {
    Numbers numbers(seed);
    std::vector<cageform::PiecewiseCubic<T>> curves;
    for (std::size_t n = 0; n < vertices * D; ++n) {
        std::vector<cageform::CubicPiece<T>> pieces;
        T time = numbers.fraction<T>();
        const std::size_t count = 1 + numbers.below(5);
        for (std::size_t i = 0; i < count; ++i) {
            pieces.push_back({time, 4 * numbers.fraction<T>(), numbers.fraction<T>(), numbers.fraction<T>(),
                              numbers.fraction<T>()});
            time += T(1 + numbers.below(7)) / T(4);
        }
        curves.push_back({std::move(pieces), time});
    }
    return {curves, outside, outside};
}

/// The part of a figure that holds one clip.
template <class T>
std::vector<cageform::Lanes<double>> clip_part(const cageform::PackedClip<T, 3>& clip,
                                               std::string_view name) {
    const std::uint64_t count = 1;
    const cageform::FigureClip line{64, clip.bytes().size(), 32, std::uint32_t(name.size())};
    std::vector<cageform::Lanes<double>> memory(1 + clip.bytes().size() / 64);
    std::byte* const data = std::as_writable_bytes(std::span(memory)).data();
    std::memset(data, 0, 64);
    std::memcpy(data, &count, 8);
    std::memcpy(data + 8, &line, sizeof(line));
    std::memcpy(data + 32, name.data(), name.size());
    std::memcpy(data + 64, clip.bytes().data(), clip.bytes().size());
    return memory;
}

/// A figure whose points and tangents are of one binding each, with labels A, B, … of the handles and a
/// clip called play.
template <class T>
cageform::PackedFigure<T, 3> figure(WeightFormat format, bool sparse, std::size_t points, std::size_t handles,
                                    std::uint32_t seed) {
    using cageform::FigureTags;
    const auto binding = packed_binding<T, 3>(format, sparse, points, handles, seed);
    std::vector<std::int8_t> signs(points);
    for (std::size_t i = 0; i < points; ++i) signs[i] = i % 3 == 0 ? -1 : 1;
    std::vector<std::uint32_t> labels(handles + 1 + (handles + 3) / 4);
    for (std::size_t h = 0; h < handles; ++h) {
        const char letter = char('A' + h % 26);
        labels[h + 1] = std::uint32_t(h + 1);
        std::memcpy(reinterpret_cast<char*>(labels.data() + handles + 1) + h, &letter, 1);
    }
    const cageform::PackedClip<T, 3> played(
        clip<T, 3>(handles, cageform::Extrapolation::cycle_with_offset, seed).view());
    const auto clips = clip_part<T>(played, "play");
    const cageform::FigurePartData parts[] = {
        {FigureTags::points, binding.bytes()},
        {FigureTags::tangents, binding.bytes()},
        {FigureTags::bitangents, binding.bytes()},
        {FigureTags::handedness, std::as_bytes(std::span(signs))},
        {FigureTags::labels, std::as_bytes(std::span(labels))},
        {FigureTags::clips, std::as_bytes(std::span(clips))},
    };
    return cageform::PackedFigure<T, 3>(parts);
}

/// A loop that cuts its range anywhere and goes backwards.
struct Backwards {
    std::size_t longest = 7;

    template <class Body>
    void operator()(std::size_t count, std::size_t, Body&& body) const {
        for (std::size_t end = count, step = 1; end > 0; step = step % longest + 1) {
            const std::size_t begin = end > step ? end - step : 0;
            body(begin, end);
            end = begin;
        }
    }
};

} // namespace made_up
