// A whole figure by one call: its points, normals and tangents are bound, and packed for a game.
#pragma once

#include <cageform/binding/bind_vectors.hpp>
#include <cageform/binding/figure.hpp>
#include <cageform/binding/pack.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// What is bound of a figure: `FigurePoints{points, normals, tangents}`, the last or the last two
/// left out where there are none. Refers to what it is given, and keeps what is given as a
/// temporary.
///
///   points    as for `bind`
///   normals   of any length, one for every point
///   tangents  in space, one for every point, as `tangents_of` takes them; where they have four
///             numbers, the sign of the fourth is the handedness of the texture, as glTF has it
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

/// A bound figure, made by `bind_figure`. `clone` moves it (clone/clone_figure.hpp), `pack_figure`
/// makes of it what a game ships.
template <Scalar T, std::size_t D>
class FigureBinding {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    Binding<T, D> points;
    std::array<Binding<T, D>, D - 1> tangents; ///< unit tangents, in space bitangents; empty without normals
    std::vector<std::int8_t> handedness;       ///< #points; empty without tangents of its own

    bool has_normals() const noexcept { return tangents[0].handle_count() != 0; }

    /// Names for the handles, of any length, as many as there are; kept by `pack_figure` and
    /// `rebind_cage`.
    ///
    ///   labels   any range of what std::string_view is made of
    ///   returns  labels_do_not_match; out_of_memory; the labels are then as they were
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
    /// None where `points` was replaced by a binding of more or fewer handles.
    HandleLabels labels() const noexcept {
        if (labels_.empty() || labelled_ != points.handle_count()) return {};
        return {labels_.data(), reinterpret_cast<const char*>(labels_.data() + points.handle_count() + 1)};
    }
    /// As they lie in a packed figure.
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
    std::vector<std::uint32_t> labels_; // where they begin, #handles + 1, and characters; or none
    std::size_t labelled_ = 0;          // #handles of that time
};

struct FigureBindReport {
    Status status = Status::ok; ///< of the points, or else of the vectors
    BindReport points;
    BindReport vectors; ///< of tangents and bitangents; of no points where there are no normals
    double seconds = 0; ///< wall-clock time, the solver's included
};

template <Scalar T, std::size_t D>
struct FigureBindResult {
    FigureBinding<T, D> figure; ///< empty unless the report's status is ok
    FigureBindReport report;
};

struct FigurePackOptions {
    /// Of the weights. The order and the tolerance are those of the points; tangents take the order
    /// over.
    PackOptions weights{};
    /// The largest change of a unit tangent, in radians where it turns; with points that have a
    /// tolerance or none. 0: ten times that of the points over the size of the figure, 1 at most,
    /// since a point that is off by d beside others that are not turns a surface whose features are
    /// a tenth of the figure by ten times d; none where the points have none.
    double tangent_tolerance = 0;
    /// Clips that move the figure, as `pack_clip` packs them, each of a name of its own and of as
    /// many vertices as there are handles, or handles that are points.
    std::span<const FigureClipData> clips{};
    /// Levels of less detail, 9 at most: packed figures of the same handles, without levels of their
    /// own (PackedFigure::bytes).
    std::span<const std::span<const std::byte>> levels{};
    /// What else is to be in the figure, under tags of its own.
    std::span<const FigurePartData> parts{};
};

struct FigurePackReport {
    Status status = Status::ok;
    FigureTag culprit;            ///< the part that the status is about; 0: the figure as a whole
    std::size_t culprit_clip = 0; ///< with FigureTags::clips: the one of them
    PackReport points;
    std::array<PackReport, 2> vectors; ///< of tangents and bitangents
    std::size_t bytes = 0;             ///< of the figure
    double seconds = 0;
};

template <Scalar T, std::size_t D>
struct FigurePackResult {
    PackedFigure<T, D> figure; ///< empty unless the report's status is ok
    FigurePackReport report;
};

namespace detail {

/// A figure as it is bound, read where it lies.
template <Scalar T, std::size_t D>
struct FigureInput {
    PointReader<T> points;
    std::array<PointReader<T>, D - 1> tangents; ///< of no points where there are no normals
    std::vector<std::int8_t> handedness;        ///< of tangents of the figure's own

    bool has_normals() const noexcept { return bool(tangents[0].read); }
};

/// Tangents of three numbers, from those with a handedness.
template <class Tangents>
auto without_sign(const Tangents& tangents, std::vector<std::int8_t>& handedness) {
    using S = range_scalar_t<Tangents>;
    std::vector<Vec<S, 3>> result(std::size(tangents));
    handedness.assign(result.size(), 1);
    for (std::size_t i = 0; i < result.size(); ++i) {
        const auto t = to_vec<S>(tangents[i]);
        result[i] = {t[0], t[1], t[2]};
        if constexpr (range_dimension<Tangents> == 4) handedness[i] = t[3] < 0 ? -1 : 1;
    }
    return result;
}

/// What is left of a bind when the coordinates have solved, where they do.
template <class C>
Status bind_parts(const C& coordinates, FigureInput<typename C::scalar, C::dimension>& input,
                  const BindOptions& options, const Running& running,
                  FigureBindResult<typename C::scalar, C::dimension>& result) {
    using T = typename C::scalar;
    auto& [figure, report] = result;
    const Running first = running.part(0, input.has_normals() ? 0.4 : 1), second = running.part(0.4, 1);
    auto points =
        bind_points(bind_input(coordinates, input.points), options, Binding<T, C::dimension>{}, first);
    report.points = std::move(points.report);
    if (report.points.status != Status::ok) return report.points.status;
    if constexpr (GradientCoordinates<C>) {
        if (input.has_normals()) {
            auto vectors = bind_each_vector(coordinates, input.points, input.tangents, options, second);
            report.vectors = std::move(vectors.report);
            if (report.vectors.status != Status::ok) return report.vectors.status;
            figure.tangents = std::move(vectors.bindings);
        }
    }
    figure.points = std::move(points.binding);
    figure.handedness = std::move(input.handedness);
    return Status::ok;
}

/// Coordinates that solve do so once, for weights and gradients.
template <class C>
Status bind_read_figure(const C& coordinates, FigureInput<typename C::scalar, C::dimension>& input,
                        const BindOptions& options, const Running& running,
                        FigureBindResult<typename C::scalar, C::dimension>& result) {
    if constexpr (requires(C solved) { solved.solve(running); }) {
        if (input.has_normals() && coordinates.cage_report().status == Status::ok) {
            C solved = coordinates;
            const Evaluation solution = solved.solve(running.part(0, 0.7));
            BindReport& report = result.report.points;
            report.cage = coordinates.cage_report();
            report.points = input.points.size;
            report.solver = solution.solver;
            report.status = solution.status;
            if (report.status == Status::out_of_memory) // of functions kept; there may be enough for a group
                return bind_parts(coordinates, input, options, running, result);
            if (report.status != Status::ok) return report.status;
            return bind_parts(solved, input, options, running.part(0.7, 1), result);
        }
    }
    return bind_parts(coordinates, input, options, running, result);
}

/// The normals of a figure as tangents, and what is read of them: read(tangents, handedness).
template <Scalar T, class Figure, class Read>
Status read_tangents(const Figure& figure, const Read& read) {
    std::vector<std::int8_t> handedness;
    if (std::size(figure.normals) != std::size(figure.points)) return Status::vectors_do_not_match;
    if constexpr (is_wanted<decltype(figure.tangents)>) {
        if (std::size(figure.tangents) != std::size(figure.points)) return Status::vectors_do_not_match;
        const auto own = without_sign(figure.tangents, handedness);
        const auto tangents = tangents_of(figure.normals, own);
        return read(tangents, std::move(handedness));
    } else {
        const auto tangents = tangents_of(figure.normals);
        return read(tangents, std::move(handedness));
    }
}

// What a figure may have, apart: compilers name the one that is not met.
template <class P, class C>
concept PointsFor = PointRangeIn<P, C::dimension> &&(C::dimension == 2 || C::dimension == 3);
template <class N, class C>
concept NormalsFor = !is_wanted<N> || (GradientCoordinates<C> && PointRangeIn<N, C::dimension>);
template <class G, class N, class C>
concept TangentsFor =
    !is_wanted<G> || (is_wanted<N> && C::dimension == 3 && (PointRangeIn<G, 3> || PointRangeIn<G, 4>));

} // namespace detail

/// Binds a figure to the cage of `coordinates`: its points as `bind` does, its normals and tangents
/// as `bind_vectors` does with what `tangents_of` makes of them, to the bit.
///
///   figure   see FigurePoints
///   options  as for `bind`, of points and vectors
///   returns  the figure and its report, which lists bad points and vectors, and no reason to
///            refuse the others
///   cost     that of `bind` and `bind_vectors`; but coordinates that solve do so once, where they
///            have not before, and keep their functions meanwhile (half of SolverMemory::block for
///            each group)
///   fails    vectors_do_not_match; as `bind` and `bind_vectors`
template <CageCoordinates C, class P, class N, class G>
    requires(detail::PointsFor<P, C>&& detail::NormalsFor<N, C>&& detail::TangentsFor<G, N, C>)
FigureBindResult<typename C::scalar, C::dimension> bind_figure(const C& coordinates,
                                                               const FigurePoints<P, N, G>& figure,
                                                               const BindOptions& options = {},
                                                               const Running& running = {}) {
    using T = typename C::scalar;
    FigureBindResult<T, C::dimension> result;
    detail::run_into(result.report, [&] {
        detail::FigureInput<T, C::dimension> input{detail::read_points<T>(figure.points), {}, {}};
        const auto bind_input = [&] {
            return detail::bind_read_figure(coordinates, input, options, running, result);
        };
        if constexpr (detail::is_wanted<N>) {
            return detail::read_tangents<T>(figure, [&](const auto& tangents, auto&& handedness) {
                for (std::size_t k = 0; k < tangents.size(); ++k)
                    input.tangents[k] = detail::read_points<T>(tangents[k]);
                input.handedness = std::move(handedness);
                return bind_input();
            });
        } else {
            return bind_input();
        }
    });
    return result;
}

namespace detail {

template <Scalar T, std::size_t D>
Status check_tags(std::span<const FigurePartData> parts, FigureTag& culprit) noexcept {
    constexpr std::size_t own = 6 + FigureTags::most_levels;
    if (parts.size() > FigureHeader::most_parts - own) return Status::too_many_parts;
    for (std::size_t n = 0; n < parts.size(); ++n) {
        bool taken = FigureTags::has(parts[n].tag) || parts[n].tag == FigureTag{};
        for (std::size_t m = 0; m < n; ++m) taken = taken || parts[m].tag == parts[n].tag;
        culprit = parts[n].tag;
        if (taken) return Status::tag_taken;
    }
    culprit = {};
    return Status::ok;
}

/// Whether what a figure has besides bindings goes with them.
template <Scalar T, std::size_t D>
Status check_tables(const FigureBinding<T, D>& figure, FigureTag& culprit) noexcept {
    culprit = FigureTags::handedness;
    if (!figure.handedness.empty() && figure.handedness.size() != figure.points.point_count())
        return Status::vectors_do_not_match;
    culprit = FigureTags::labels;
    if (!figure.label_bytes().empty() && figure.labels().begin == nullptr) return Status::labels_do_not_match;
    culprit = {};
    return Status::ok;
}

/// Whether the clips and levels of a figure are of its cage.
template <Scalar T, std::size_t D>
Status check_motion(const HandleView<T, D>& handles, const FigurePackOptions& options,
                    FigurePackReport& report) noexcept {
    report.culprit = FigureTags::clips;
    for (std::size_t n = 0; n < options.clips.size(); ++n) {
        report.culprit_clip = n;
        const Status status = check_clip_of(open_clip<T, D>(options.clips[n].bytes), handles);
        if (status != Status::ok) return status;
        for (const FigureClipData& other : options.clips.first(n)) {
            if (other.name == options.clips[n].name) return Status::name_taken;
        }
    }
    report.culprit_clip = 0;
    report.culprit = {};
    if (options.levels.size() > FigureTags::most_levels) return Status::too_many_parts;
    for (std::size_t n = 0; n < options.levels.size(); ++n) {
        report.culprit = FigureTags::level(n + 1);
        const auto level = open_figure_within<T, D>(options.levels[n], {}, false);
        if (level.status != Status::ok) return level.status;
        if (!same_handles(level.figure.handle_view(), handles)) return Status::blob_of_another_cage;
    }
    report.culprit = {};
    return Status::ok;
}

/// The part of a figure that its clips are.
inline std::vector<Lanes<double>> packed_clips(std::span<const FigureClipData> clips) {
    const auto whole = [](std::size_t bytes) { return (bytes + 63) / 64 * 64; };
    const std::uint64_t count = clips.size();
    std::size_t name = sizeof(count) + clips.size() * sizeof(FigureClip), end = name;
    for (const FigureClipData& clip : clips) end += clip.name.size();
    end = whole(end);
    std::vector<FigureClip> lines;
    for (const FigureClipData& clip : clips) {
        lines.push_back({end, clip.bytes.size(), static_cast<std::uint32_t>(name),
                         static_cast<std::uint32_t>(clip.name.size())});
        name += clip.name.size();
        end += whole(clip.bytes.size());
    }
    std::vector<Lanes<double>> memory(end / 64);
    std::byte* const data = std::as_writable_bytes(std::span(memory)).data();
    if (end > 0) std::memset(data, 0, end);
    std::memcpy(data, &count, sizeof(count));
    std::memcpy(data + sizeof(count), lines.data(), lines.size() * sizeof(FigureClip));
    for (std::size_t n = 0; n < clips.size(); ++n) {
        if (!clips[n].name.empty())
            std::memcpy(data + lines[n].name, clips[n].name.data(), lines[n].name_bytes);
        std::memcpy(data + lines[n].offset, clips[n].bytes.data(), clips[n].bytes.size());
    }
    return memory;
}

template <Scalar T, std::size_t D>
Status pack_parts(const FigureBinding<T, D>& figure, const FigurePackOptions& options, const Running& running,
                  FigurePackResult<T, D>& result) {
    FigurePackReport& report = result.report;
    Status status = check_tags<T, D>(options.parts, report.culprit);
    if (status == Status::ok) status = check_tables(figure, report.culprit);
    if (status == Status::ok) status = check_motion(figure.points.handle_view(), options, report);
    if (status != Status::ok) return status;
    std::vector<FigurePartData> parts;
    PackOptions how = options.weights;
    const std::size_t vectors = figure.has_normals() ? D - 1 : 0;
    const auto part = [&](std::size_t n) {
        return running.part(double(n) / double(vectors + 1), double(n + 1) / double(vectors + 1));
    };
    const bool own_tolerance = vectors > 0 && options.tangent_tolerance != 0;
    if (own_tolerance && how.tolerance == 0) // sparse, for an order that tangents can take over
        how.threshold = (std::max)(how.threshold, (std::numeric_limits<double>::min)());
    auto points = pack(figure.points, how, part(0));
    how.threshold = options.weights.threshold;
    report.points = std::move(points.report);
    report.culprit = FigureTags::points;
    if (report.points.status != Status::ok) return report.points.status;
    parts.push_back({report.culprit, points.binding.bytes()});
    const auto view = points.binding.view();
    if (view.order != nullptr) how.order = {view.order, view.points};
    const double size = report.points.size, widest = 10 * how.tolerance;
    if (own_tolerance)
        how.tolerance = options.tangent_tolerance;
    else if (how.tolerance > 0)
        how.tolerance = widest < size ? widest / size : 1;
    std::array<PackedBinding<T, D>, D - 1> tangents;
    for (std::size_t k = 0; k < vectors; ++k) {
        report.culprit = k == 0 ? FigureTags::tangents : FigureTags::bitangents;
        auto packed = pack(figure.tangents[k], how, part(k + 1));
        report.vectors[k] = std::move(packed.report);
        if (report.vectors[k].status != Status::ok) return report.vectors[k].status;
        tangents[k] = std::move(packed.binding);
        if (!bindings_match(view, tangents[k].view())) return Status::bindings_differ;
        parts.push_back({report.culprit, tangents[k].bytes()});
    }
    if (!figure.handedness.empty())
        parts.push_back({FigureTags::handedness, std::as_bytes(std::span(figure.handedness))});
    const auto labels = figure.label_bytes();
    if (!labels.empty()) parts.push_back({FigureTags::labels, labels});
    std::vector<Lanes<double>> clips;
    if (!options.clips.empty()) {
        clips = packed_clips(options.clips);
        parts.push_back({FigureTags::clips, std::as_bytes(std::span(clips))});
    }
    for (std::size_t n = 0; n < options.levels.size(); ++n)
        parts.push_back({FigureTags::level(n + 1), options.levels[n]});
    parts.insert(parts.end(), options.parts.begin(), options.parts.end());
    report.culprit = {};
    result.figure = PackedFigure<T, D>(parts);
    report.bytes = result.figure.bytes().size();
    return Status::ok;
}

} // namespace detail

/// Packs a figure for `open_figure`: its bindings as `pack` does, the tangents in the order of the
/// points, its labels, clips and levels, and parts of the user's.
///
///   returns  the packed figure and its report; fails as `pack`, with the part in
///            FigurePackReport::culprit; tag_taken, name_taken, too_many_parts; of a clip or level, as
///            `open_clip` and `open_figure`, and blob_of_another_cage; bindings_differ,
///            vectors_do_not_match, labels_do_not_match, where the parts of the figure were replaced
///            by others that are of different points or handles
///   cost     that of `pack` for each binding, and a copy of all parts
template <Scalar T, std::size_t D>
FigurePackResult<T, D> pack_figure(const FigureBinding<T, D>& figure, const FigurePackOptions& options = {},
                                   const Running& running = {}) {
    FigurePackResult<T, D> result;
    detail::run_into(result.report,
                     [&] { return detail::pack_parts<T, D>(figure, options, running, result); });
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI
