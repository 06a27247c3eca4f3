// The points of a lattice inside a cage.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/core/types/bounds.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <cmath>
#include <cstddef>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Samples and their neighbours on a lattice.
template <Scalar T, std::size_t D>
struct SamplePoints {
    std::vector<Vec<T, D>> points;
    std::vector<std::array<std::uint32_t, 2>> neighbours; ///< pairs; empty without a lattice
};

/// Whether coordinates need no solver; AnyCoordinates report it at run time.
template <class C>
bool is_closed_form(const C& coordinates) noexcept {
    if constexpr (CageCoordinates<C>)
        return C::closed_form;
    else
        return coordinates.closed_form();
}

/// A lattice of cells in a box; a sample is the centre of a cell.
template <class C>
class SampleLattice {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

public:
    SampleLattice(const C& coordinates, const Bounds<double, D>& box)
        : coordinates_(coordinates)
        , box_(box) {}

    /// Finds about `count` points inside. First estimates the fraction of the box that is inside with a
    /// lattice of `count` points, refined until enough are inside.
    Status find(std::size_t count, SamplePoints<T, D>& found, const Running& running) {
        constexpr std::size_t most = std::size_t{1} << 22;
        for (std::size_t tried = count; tried <= most; tried *= 8) {
            divide(double(tried));
            Status status = locate(running.subtask(0, 0.5));
            if (status != Status::ok) return status;
            const std::size_t inside = inside_count();
            if (8 * inside < 64 && tried * 8 <= most) continue; // too few to estimate the fraction
            if (inside == 0) break;
            const double wanted = double(count) * double(states_.size()) / double(inside);
            divide(wanted < double(most) ? wanted : double(most));
            status = locate(running.subtask(0.5, 1));
            if (status == Status::ok) collect(found);
            return status;
        }
        return Status::samples_missing;
    }

private:
    /// Divides the box into about `count` nearly cubic cells.
    void divide(double count) {
        double edge = 1;
        const Vec<double, D> extent = box_.upper - box_.lower;
        for (std::size_t k = 0; k < D; ++k) edge *= extent[k];
        edge = std::pow(edge / count, 1.0 / double(D));
        std::size_t total = 1;
        for (std::size_t k = 0; k < D; ++k) {
            cells_[k] = (std::max)(std::size_t{1}, std::size_t(std::lround(extent[k] / edge)));
            total *= cells_[k];
        }
        states_.assign(total, PointState::inside);
    }
    Vec<T, D> point(std::size_t n) const noexcept {
        Vec<T, D> p;
        for (std::size_t k = 0; k < D; ++k) {
            const double share = (double(n % cells_[k]) + 0.5) / double(cells_[k]);
            p[k] = static_cast<T>(box_.lower[k] + share * (box_.upper[k] - box_.lower[k]));
            n /= cells_[k];
        }
        return p;
    }

    /// Evaluates the states of the points, a few at a time, since their weights are discarded.
    Status locate(const Running& running) {
        const std::size_t blocks = is_closed_form(coordinates_) ? 8 : 128, piece = blocks * lane_count<T>;
        const std::size_t handles = handle_view(coordinates_).count;
        const std::size_t pieces = (states_.size() + piece - 1) / piece;
        std::vector<Status> statuses(pieces, Status::ok);
        const Status status = for_each_block(pieces, running, [&](std::size_t begin, std::size_t end) {
            std::vector<Lanes<T>> positions(blocks * D), weights(blocks * handles);
            for (std::size_t n = begin; n < end; ++n) {
                const std::size_t first = n * piece, count = (std::min)(piece, states_.size() - first);
                const BlockView<T> points{positions.data(), D, count};
                for (std::size_t i = 0; i < block_count<T>(count) * lane_count<T>; ++i) {
                    const auto p = point(first + (std::min)(i, count - 1));
                    for (std::size_t k = 0; k < D; ++k) points(i, k) = p[k];
                }
                statuses[n] = coordinates_
                                  .evaluate(points, {weights.data(), handles, count},
                                            std::span(states_).subspan(first, count), {})
                                  .status;
            }
        });
        for (const Status of_piece : statuses) {
            if (of_piece != Status::ok) return of_piece;
        }
        return status;
    }
    std::size_t inside_count() const noexcept {
        std::size_t count = 0;
        for (const PointState state : states_) count += state == PointState::inside ? 1 : 0;
        return count;
    }

    void collect(SamplePoints<T, D>& found) const {
        std::vector<std::uint32_t> number(states_.size(), ~std::uint32_t{0});
        for (std::size_t n = 0; n < states_.size(); ++n) {
            if (states_[n] != PointState::inside) continue;
            number[n] = std::uint32_t(found.points.size());
            found.points.push_back(point(n));
            std::size_t stride = 1, left = n;
            for (std::size_t k = 0; k < D; ++k) { // preceding cells are already numbered
                if (left % cells_[k] > 0 && states_[n - stride] == PointState::inside)
                    found.neighbours.push_back({number[n - stride], number[n]});
                left /= cells_[k];
                stride *= cells_[k];
            }
        }
    }

    const C& coordinates_;
    Bounds<double, D> box_;
    std::array<std::size_t, D> cells_{};
    std::vector<PointState> states_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail
