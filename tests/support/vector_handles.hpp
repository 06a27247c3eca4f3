// Coordinate types whose handles are not all points: what a newcomer adds, by adding a file.
#pragma once

#include "cages.hpp"

#include <cageform/coordinates/coordinate.hpp>

namespace cageform_tests {

using cageform::BlockView;
using cageform::Evaluation;
using cageform::HandleKind;
using cageform::PointState;

/// Bones without a cage, whose shares fall with the distance of their origins.
template <class T, std::size_t D>
class BoneCoordinates {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr bool has_extension = true;
    static constexpr bool closed_form = true;

    explicit BoneCoordinates(const std::vector<Vec<T, D>>& origins) {
        for (const auto& origin : origins) {
            handles_.push_back(origin);
            kinds_.push_back(HandleKind::point);
            for (std::size_t k = 0; k < D; ++k) {
                handles_.push_back({});
                handles_.back()[k] = 1;
                kinds_.push_back(HandleKind::vector);
            }
        }
    }

    std::span<const Vec<T, D>> handles() const noexcept { return handles_; }
    std::span<const HandleKind> handle_kinds() const noexcept { return kinds_; }
    const cageform::CageReport& cage_report() const noexcept { return report_; }

    /// ω of every bone at a place.
    std::vector<double> shares(const Vec<T, D>& p) const {
        std::vector<double> result;
        double sum = 0;
        for (std::size_t h = 0; h < handles_.size(); h += D + 1) {
            const auto away = cageform::vec_cast<double>(handles_[h] - p);
            result.push_back(1 / (0.1 + dot(away, away)));
            sum += result.back();
        }
        for (double& share : result) share /= sum;
        return result;
    }
    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const cageform::Running& = {}) const {
        for (std::size_t i = 0; i < points.blocks() * BlockView<T>::lanes; ++i) {
            if (i < states.size() && states[i] != PointState::not_finite) states[i] = PointState::inside;
            fill(cageform::block_point<D>(points, i), [&](std::size_t h, T w) { weights(i, h) = w; });
        }
        return {};
    }
    Vec<T, D> nearest_boundary(const Vec<T, D>& p, std::span<T> row) const {
        fill(p, [&](std::size_t h, T w) { row[h] = w; });
        return p;
    }

private:
    template <class Set>
    void fill(const Vec<T, D>& p, const Set& set) const {
        const auto share = shares(p);
        for (std::size_t bone = 0; bone < share.size(); ++bone) {
            const std::size_t h = bone * (D + 1);
            set(h, T(share[bone]));
            for (std::size_t k = 0; k < D; ++k)
                set(h + 1 + k, T(share[bone] * double(p[k] - handles_[h][k])));
        }
    }

    std::vector<Vec<T, D>> handles_;
    std::vector<HandleKind> kinds_;
    cageform::CageReport report_;
};

} // namespace cageform_tests
