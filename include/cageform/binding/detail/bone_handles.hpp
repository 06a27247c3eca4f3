// The handles of bones, and the weights of points for them.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/detail/simplex.hpp>

#include <array>
#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The handles of bones at rest, and the coordinates of points in each bone's frame.
template <Scalar T, std::size_t D>
class BoneHandles {
public:
    /// Reads the frames of bones. Adds errors to the report, by bone or handle.
    BoneHandles(std::span<const Transform<T, D>> bones, CageReport& report) {
        for (const auto& bone : bones) {
            add(bone.translation, HandleKind::point, report);
            for (const auto& axis : bone.columns) add(axis, HandleKind::vector, report);
        }
        for (std::size_t b = 0; b < bones.size() && report.status == Status::ok; ++b)
            invert(bones[b], b, report);
    }

    HandleView<T, D> view() const noexcept { return {rest_.data(), rest_.size(), kinds_.data(), nullptr}; }

    /// Calls set(handle, weight) for the D + 1 handles of a bone with the weight `share`: share, and
    /// share · A⁻¹ (p − o).
    template <class Set>
    void weigh(std::size_t bone, double share, const Vec<T, D>& p, const Set& set) const {
        const std::size_t first = bone * (D + 1);
        const auto away = vec_cast<double>(p) - vec_cast<double>(rest_[first]);
        set(first, static_cast<T>(share));
        for (std::size_t k = 0; k < D; ++k)
            set(first + 1 + k, static_cast<T>(share * dot(inverse_[bone * D + k], away)));
    }

private:
    void add(const Vec<T, D>& handle, HandleKind kind, CageReport& report) {
        if (!is_finite(handle)) report.add(CageFaultKind::vertex_not_finite, rest_.size());
        rest_.push_back(handle);
        kinds_.push_back(kind);
    }
    /// Computes A⁻¹. Its rows are the gradients of the barycentric coordinates for the axes' end points.
    void invert(const Transform<T, D>& bone, std::size_t b, CageReport& report) {
        std::array<Vec<double, D>, D + 1> corners{};
        double size = 0;
        for (const auto& axis : bone.columns) size = std::fmax(size, length(vec_cast<double>(axis)));
        for (std::size_t k = 0; k < D && size > 0; ++k)
            corners[k] = (1 / size) * vec_cast<double>(bone.columns[k]);
        const auto rows = simplex_gradients<D>(corners);
        bool spans = !rows.empty();
        // The product is 1 / sine of the angle to the other axes.
        for (std::size_t k = 0; k < D && spans; ++k) {
            spans = 64 * double(epsilon<T>) * length(rows[k]) * length(corners[k]) < 1;
            inverse_.push_back((1 / size) * rows[k]);
        }
        if (!spans) report.add(CageFaultKind::bone_axes_dependent, b);
    }

    std::vector<Vec<T, D>> rest_;
    std::vector<HandleKind> kinds_;
    std::vector<Vec<double, D>> inverse_; ///< D rows per bone
};

/// Bones and the given weights of points.
template <Scalar T, std::size_t D, Scalar W>
struct BoneShares {
    const BoneHandles<T, D>& handles;
    std::span<const W> shares; ///< point after point
    bool restore;              ///< divides the weights of a point by their sum

    /// Computes the weights of point `i` of a batch, and its state. Returns the largest change of a
    /// given weight.
    Extreme weigh(const Batch<T>& batch, std::size_t i) const {
        const std::size_t bones = handles.view().count / (D + 1);
        const auto row = shares.subspan(i * bones, bones);
        double sum = 0, largest = 0;
        for (const W share : row) {
            sum += double(share);
            largest = std::fmax(largest, std::fabs(double(share)));
        }
        const double factor = restore ? 1 / sum : 1;
        const bool weighs = is_finite(sum) && is_finite(factor) && (!restore || sum > 0);
        batch.states[i] = weighs ? PointState::inside : PointState::unreached;
        if (!weighs) return {};
        const auto p = block_point<D>(batch.points, i);
        for (std::size_t b = 0; b < bones; ++b)
            handles.weigh(b, factor * double(row[b]), p, [&](std::size_t h, T w) { batch.rows(i, h) = w; });
        return {std::fabs(factor - 1) * largest, i};
    }
};

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI
