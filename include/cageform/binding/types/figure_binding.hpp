// A bound figure: points, normals and tangents, handedness, and the labels of its handles.
#pragma once

#include <cageform/binding/tangents.hpp>
#include <cageform/binding/types/bind_options.hpp>
#include <cageform/figure/binding.hpp>
#include <cageform/figure/figure.hpp>

#include <string_view>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The input of `bind` for a figure: `FigurePoints{points, normals, tangents}`. Tangents, or normals
/// and tangents, may be omitted. Refers to lvalue arguments and stores temporaries.
///
///   points    as for `bind`
///   normals   of any length, one per point
///   tangents  3D: one per point, as for `tangents_of`. With four numbers, the sign of the fourth is the
///             handedness of the texture, as in glTF
template <class Points, class Normals = NoVectors, class Tangents = NoVectors>
struct FigurePoints {
    Points points;
    Normals normals{};
    Tangents tangents{};
};
template <class Points>
FigurePoints(Points&&) -> FigurePoints<Points>;
template <class Points, class Normals>
FigurePoints(Points&&, Normals&&) -> FigurePoints<Points, Normals>;
template <class Points, class Normals, class Tangents>
FigurePoints(Points&&, Normals&&, Tangents&&) -> FigurePoints<Points, Normals, Tangents>;

/// A bound figure, made by `bind`. `clone` deforms it (clone/clone_figure.hpp); `pack` packs it for run time.
template <Scalar T, std::size_t D>
class FigureBinding {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    Binding<T, D> points;
    /// Unit tangents, in 3D also bitangents; empty without normals.
    std::array<Binding<T, D>, D - 1> tangents;
    std::vector<std::int8_t> handedness; ///< #points; empty unless tangents were given

    bool has_normals() const noexcept { return tangents[0].handle_count() != 0; }

    /// Sets one label per handle, of any length; `pack` and `rebind_cage` keep them.
    ///
    ///   labels   any range whose elements convert to std::string_view
    ///   returns  labels_do_not_match, out_of_memory (labels are then unchanged), or ok
    template <class Labels>
    Status set_labels(const Labels& labels) {
        const std::size_t count = points.handle_count();
        if (std::size(labels) != count) return Status::labels_do_not_match;
        return detail::guard_memory([&] {
            std::size_t end = 0;
            for (const std::string_view label : labels) end += label.size();
            if (end > 0xFFFFFFFFu) return Status::out_of_memory;
            std::vector<std::uint32_t> made(count + 1 + (end + 3) / 4);
            end = 0;
            std::size_t handle = 0;
            for (const std::string_view label : labels) {
                char* const text = reinterpret_cast<char*>(made.data() + count + 1);
                if (!label.empty()) std::memcpy(text + end, label.data(), label.size());
                end += label.size();
                made[++handle] = static_cast<std::uint32_t>(end);
            }
            labels_ = std::move(made);
            labelled_ = count;
            return Status::ok;
        });
    }
    /// Returns the labels, or none if `points` was replaced by a binding with another number of handles.
    HandleLabels labels() const noexcept {
        if (labels_.empty() || labelled_ != points.handle_count()) return {};
        return {labels_.data(), reinterpret_cast<const char*>(labels_.data() + points.handle_count() + 1)};
    }
    /// Returns the labels as they are stored in a packed figure.
    std::span<const std::byte> label_bytes() const noexcept { return std::as_bytes(std::span(labels_)); }

    PackedFigureView<T, D> view() const noexcept {
        PackedFigureView<T, D> view;
        view.points = points.view();
        for (std::size_t k = 0; k + 1 < D && has_normals(); ++k) view.tangents[k] = tangents[k].view();
        if (!handedness.empty() && handedness.size() == points.point_count())
            view.handedness = handedness.data();
        view.labels = labels();
        return view;
    }

private:
    std::vector<std::uint32_t> labels_; // #handles + 1 begins, then characters; or empty
    std::size_t labelled_ = 0;          // #handles when they were set
};

struct FigureBindReport {
    Status status = Status::ok; ///< that of the points; if ok, that of the vectors
    BindReport points;
    BindReport vectors; ///< of tangents and bitangents; `points` is 0 without normals
    double seconds = 0; ///< wall-clock time, including the solver's
};

} // namespace cageform::inline CAGEFORM_ABI
