#include "files/pose_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cageform_support {

namespace detail {

/// Upper bound of the bytes of a line with this many numbers.
constexpr std::size_t longest_row(std::size_t numbers) {
    return 65536 + 512 * numbers;
}

/// Parses a clip in space or in the plane.
Expected<cageform::CageClip<double, 3>> motion_of_clip(std::string_view text, const std::string& name,
                                                       std::span<const cageform::Vec<double, 3>> rest) {
    const auto clip = parse_pose_clip(text, name, rest.size());
    if (!clip) return clip.error();
    return make_clip<double>(*clip);
}
Expected<cageform::CageClip<double, 2>> motion_of_clip(std::string_view text, const std::string& name,
                                                       std::span<const cageform::Vec<double, 2>> rest) {
    const auto clip = parse_clip(text, name, rest.size());
    if (!clip) return clip.error();
    if (clip->has_pins())
        return FileError{
            name + ": a clip of pins cannot be used here: convert it to keys by animate_svg --save-clip"};
    std::vector<Point2> vertices;
    for (const auto& p : rest) vertices.push_back({p[0], p[1]});
    return make_clip(*clip, vertices);
}

} // namespace detail

template <std::size_t D>
PoseRows<D>::PoseRows(const std::string& path, std::span<const cageform::Vec<double, D>> rest, double rate)
    : path_(path)
    , rest_(rest.begin(), rest.end())
    , rate_(rate)
    , lines_(path, detail::longest_row(D * rest.size()))
    , error_(lines_.error()) {
    std::string_view line;
    if (!next_line(line)) {
        if (error_.empty()) error_ = path_ + ": holds no poses";
        return;
    }
    first_ = line;
    constexpr std::array<std::string_view, 6> of_clips{"length", "late", "ground", "control", "pin", "pose"};
    const std::string_view word = detail::cells_of(line).front();
    if (std::find(of_clips.begin(), of_clips.end(), word) != of_clips.end()) read_clip();
}

template <std::size_t D>
void PoseRows<D>::read_clip() {
    std::string text(lines_.line() - 1, '\n'); // keeps line numbers
    text += *std::exchange(first_, std::nullopt) + '\n';
    lines_.read_rest(text);
    error_ = lines_.error();
    if (!error_.empty()) return;
    auto clip = detail::motion_of_clip(text, path_, std::span<const cageform::Vec<double, D>>(rest_));
    if (!clip) {
        error_ = to_string(clip.error());
        return;
    }
    clip_ = std::move(*clip);
    const double rows = std::ceil((clip_->end() - clip_->begin()) * rate_ - 1e-9);
    if (rows > 1e9)
        error_ = path_ + ": --rate gives more than 1000000000 poses";
    else
        clip_rows_ = std::size_t(std::max(rows, 1.0));
}

template <std::size_t D>
bool PoseRows<D>::next_line(std::string_view& line) {
    while (error_.empty() && lines_.next(line)) {
        if (filter_.take(line)) return true;
    }
    if (error_.empty()) error_ = lines_.error();
    return false;
}

template <std::size_t D>
void PoseRows<D>::skip(std::size_t count) {
    if (clip_) {
        row_ += std::min(count, clip_rows_ - row_);
        return;
    }
    std::string_view line;
    for (; count > 0 && (std::exchange(first_, std::nullopt) || next_line(line)); --count) ++row_;
}

template <std::size_t D>
bool PoseRows<D>::next(PoseRow& row) {
    row.row = row_;
    row.line = 0;
    row.text.clear();
    if (!error_.empty() || (clip_ && row_ == clip_rows_)) return false;
    if (!clip_) {
        std::string_view line;
        if (const auto first = std::exchange(first_, std::nullopt))
            row.text = *first;
        else if (next_line(line))
            row.text = line;
        else
            return false;
        row.line = lines_.line();
    }
    ++row_;
    return true;
}

template <std::size_t D>
Expected<typename PoseRows<D>::Pose> PoseRows<D>::pose_of(const PoseRow& row) const {
    Pose pose(rest_.size());
    if (clip_) {
        auto cursor = clip_->make_cursor();
        clip_->sample(clip_->begin() + double(row.row) / rate_, cursor, pose);
        return pose;
    }
    const auto refuse = [&](const std::string& why) {
        return detail::row_fault(path_, row.line, row.text, why);
    };
    const auto cells = detail::cells_of(row.text, D * pose.size());
    const std::size_t numbers = cells.size();
    if (numbers != D * pose.size())
        return refuse(detail::counted(numbers, "number") + ", but a pose of the figure's cage has " +
                      std::to_string(D * pose.size()) + ": " + (D == 3 ? "x,y,z" : "x,y") + " of " +
                      std::to_string(pose.size()) + " vertices");
    for (std::size_t n = 0; n < numbers; ++n) {
        const std::string why = detail::parse_finite(cells[n], pose[n / D][n % D]);
        if (!why.empty()) return refuse("column " + std::to_string(n + 1) + ": " + why);
    }
    return pose;
}

template <std::size_t D>
std::string PoseRows<D>::name_of(const PoseRow& row) const {
    if (!clip_) return path_ + ":" + std::to_string(row.line);
    return path_ + " after " + detail::short_number(double(row.row) / rate_) + " s";
}

template class PoseRows<2>;
template class PoseRows<3>;

} // namespace cageform_support
