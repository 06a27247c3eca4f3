// Corrections of interpolated weights next to treated corners.
#pragma once

#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/corners/corner_functions.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The corrections of the weights of some points, added after the weights of all functions are known.
class CornerSamples {
public:
    /// Adds point `i`, at `p` in lattice units, with its interpolation stencil.
    void add(const grid::CornerFunctions& corners, std::size_t i, const Vec<double, 2>& p,
             const grid::CutStencil<2>& stencil) {
        const auto correction = corners.correction(p, stencil);
        if (correction.first != grid::CornerFunctions::Correction::none) points_.push_back({i, correction});
    }
    /// Allocates the corrections of all functions.
    void reserve(std::size_t handles) {
        handles_ = handles;
        corrections_.resize(points_.size() * handles);
    }

    /// Computes the corrections of functions `first` … first + count − 1.
    void sample(const grid::CornerFunctions::Coefficients& coefficients, std::size_t first,
                std::size_t count) noexcept {
        for (std::size_t n = 0; n < points_.size(); ++n) {
            std::array<double, grid::CornerFunctions::width> more{};
            grid::CornerFunctions::apply(points_[n].correction, coefficients, more);
            for (std::size_t k = 0; k < count; ++k) corrections_[n * handles_ + first + k] = more[k];
        }
    }

    /// Adds to each point the largest share, at most 1, of its correction that keeps its weights in [0, 1].
    /// Smaller shares mean that the grid is too coarse for the corner. They are valid, because the
    /// corrections of a point sum to 0 and preserve its position.
    ///
    ///   tolerance  of the solver; clamping may change weights by this amount
    template <Scalar T>
    void finish(double tolerance, BlockView<T> rows) const noexcept {
        for (std::size_t n = 0; n < points_.size(); ++n) {
            const std::size_t i = points_[n].point, lane = i % lane_count<T>;
            const double* const correction = corrections_.data() + n * handles_;
            auto* const row = rows.block(i / lane_count<T>);
            double share = 1;
            for (std::size_t k = 0; k < handles_; ++k) {
                const double w = row[k][lane], room = tolerance + (correction[k] < 0 ? w : 1 - w);
                if (room < share * std::fabs(correction[k])) share = room / std::fabs(correction[k]);
            }
            for (std::size_t k = 0; k < handles_; ++k)
                row[k][lane] = static_cast<T>(std::clamp(row[k][lane] + share * correction[k], 0.0, 1.0));
        }
    }

private:
    struct Corrected {
        std::size_t point;
        grid::CornerFunctions::Correction correction;
    };
    std::size_t handles_ = 0;
    Buffer<Corrected> points_;
    std::vector<double> corrections_; ///< #handles per point
};

} // namespace cageform::inline CAGEFORM_ABI::detail
