// Factorises and solves the equations Σ k_ij (u_i − u_j) + e_i u_i = b_i of a graph.
#pragma once

#include <cageform/fields/detail/elimination.hpp>

#include <Eigen/Core>

#include <cmath>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The multifrontal factorisation L D Lᵀ. A front is a dense matrix of the columns of a group of nodes (Duff,
/// Reid, The multifrontal solution of indefinite sparse symmetric linear equations, ACM Trans. Math. Softw. 9
/// (1983)). No diagonal is stored: a pivot is the remaining e plus the sum of the remaining conductances.
/// Without negative conductances there are no subtractions. All numbers are then accurate to rounding, for
/// any ratio of conductances (Alfa, Xue, Ye, Accurate computation of the smallest eigenvalue of a diagonally
/// dominant M-matrix, Math. Comp. 71 (2002), sec. 2).
class GraphFactors {
public:
    /// The excess e of a node, and the sum of the absolute values of its terms.
    struct Excess {
        double value = 0, size = 0;
    };

    /// Returns false if a pivot is not finite, zero, or indistinguishable from rounding.
    bool factorise(const Adjacency& graph, std::span<const Excess> excess) {
        const Elimination order(graph);
        const auto groups = order.groups();
        position_.assign(order.positions().begin(), order.positions().end());
        excess_.assign(excess.begin(), excess.end());
        marked_.assign(graph.nodes(), 0);
        local_.assign(graph.nodes(), 0);
        fronts_.clear();
        fronts_.reserve(groups.size());
        for (std::size_t g = 0; g < groups.size(); ++g) {
            std::size_t children = 0;
            while (children < pending_.size() && pending_[pending_.size() - 1 - children].parent == g)
                ++children;
            const auto updates = std::span(pending_).last(children);
            Front front = rows_of(graph, order.nodes(groups[g]), updates);
            Matrix matrix = assemble(graph, front, updates);
            pending_.resize(pending_.size() - children);
            if (!eliminate(front, matrix)) return false;
            const auto own = Eigen::Index(front.own), rest = matrix.rows() - own;
            if (rest > 0)
                pending_.push_back({groups[g].parent,
                                    {front.rows.begin() + own, front.rows.end()},
                                    matrix.bottomRightCorner(rest, rest)});
            fronts_.push_back(std::move(front));
        }
        return true;
    }

    std::size_t bytes() const noexcept {
        std::size_t sum = 0;
        for (const Front& front : fronts_)
            sum += sizeof(double) * std::size_t(front.columns.size()) +
                   sizeof(std::uint32_t) * front.rows.size();
        return sum;
    }

    /// Solves for several fields. `values` has b of node i and field f at i · fields + f, and receives u.
    void solve(std::span<double> values, std::size_t fields) const {
        const auto width = Eigen::Index(fields);
        Eigen::Map<Rows> all(values.data(), Eigen::Index(values.size() / fields), width);
        const auto gather = [&](const Front& front, std::size_t begin, std::size_t end) {
            Matrix block(Eigen::Index(end - begin), width);
            for (std::size_t r = begin; r < end; ++r)
                block.row(Eigen::Index(r - begin)) = all.row(front.rows[r]);
            return block;
        };
        for (const Front& front : fronts_) {
            const auto own = Eigen::Index(front.own), rest = front.columns.rows() - own;
            Matrix x = gather(front, 0, front.own);
            front.columns.topRows(own).triangularView<Eigen::UnitLower>().solveInPlace(x);
            for (Eigen::Index r = 0; r < own; ++r)
                all.row(front.rows[std::size_t(r)]) = x.row(r) / front.pivots[r];
            if (rest == 0) continue;
            const Matrix passed = front.columns.bottomRows(rest) * x;
            for (Eigen::Index r = 0; r < rest; ++r)
                all.row(front.rows[std::size_t(own + r)]) -= passed.row(r);
        }
        for (auto at = fronts_.rbegin(); at != fronts_.rend(); ++at) {
            const Front& front = *at;
            const auto own = Eigen::Index(front.own), rest = front.columns.rows() - own;
            Matrix x = gather(front, 0, front.own);
            if (rest > 0)
                x.noalias() -=
                    front.columns.bottomRows(rest).transpose() * gather(front, front.own, front.rows.size());
            front.columns.topRows(own).triangularView<Eigen::UnitLower>().transpose().solveInPlace(x);
            for (Eigen::Index r = 0; r < own; ++r) all.row(front.rows[std::size_t(r)]) = x.row(r);
        }
    }

private:
    using Matrix = Eigen::MatrixXd;
    using Vector = Eigen::VectorXd;
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

    struct Front {
        std::vector<std::uint32_t> rows; ///< its own nodes, then those of later fronts, in elimination order
        std::size_t own = 0;
        Matrix columns; ///< columns of L, with diagonal 1
        Vector pivots;
    };
    /// The update matrix of a front for its parent: links between its remaining rows.
    struct Update {
        std::uint32_t parent;
        std::vector<std::uint32_t> rows;
        Matrix matrix; ///< lower triangle without the diagonal
    };

    Front rows_of(const Adjacency& graph, std::span<const std::uint32_t> own,
                  std::span<const Update> updates) {
        Front front{{own.begin(), own.end()}, own.size(), {}, {}};
        const std::uint32_t last = position_[own.back()];
        const auto mark = std::uint32_t(fronts_.size() + 1);
        const auto add = [&](std::uint32_t i) {
            if (position_[i] <= last || marked_[i] == mark) return;
            marked_[i] = mark;
            front.rows.push_back(i);
        };
        for (const std::uint32_t i : own) {
            for (const std::uint32_t j : graph.neighbours(i)) add(j);
        }
        for (const Update& update : updates) {
            for (const std::uint32_t i : update.rows) add(i);
        }
        std::sort(front.rows.begin() + std::ptrdiff_t(front.own), front.rows.end(),
                  [&](std::uint32_t i, std::uint32_t j) { return position_[i] < position_[j]; });
        return front;
    }

    /// Assembles a front from the remaining links of its own nodes and the updates of its children.
    Matrix assemble(const Adjacency& graph, const Front& front, std::span<const Update> updates) {
        const auto size = Eigen::Index(front.rows.size());
        Matrix matrix = Matrix::Zero(size, size);
        for (Eigen::Index r = 0; r < size; ++r) local_[front.rows[std::size_t(r)]] = r;
        for (std::size_t c = 0; c < front.own; ++c) {
            const std::uint32_t i = front.rows[c];
            for (std::size_t at = graph.first[i]; at < graph.first[i + 1]; ++at) {
                const std::uint32_t j = graph.node[at];
                if (position_[j] > position_[i]) matrix(local_[j], Eigen::Index(c)) -= graph.conductance[at];
            }
        }
        for (const Update& update : updates) {
            for (Eigen::Index c = 0; c < update.matrix.cols(); ++c) {
                double* const column = &matrix(0, local_[update.rows[std::size_t(c)]]);
                for (Eigen::Index r = c + 1; r < update.matrix.rows(); ++r)
                    column[local_[update.rows[std::size_t(r)]]] += update.matrix(r, c);
            }
        }
        return matrix;
    }

    /// Eliminates a front's own nodes, panel by panel, and distributes their excess e to the other rows.
    bool eliminate(Front& front, Matrix& matrix) {
        constexpr Eigen::Index panel = 32;
        const Eigen::Index size = matrix.rows(), own = Eigen::Index(front.own);
        constexpr double rounding = 0x1p-40;
        Vector excess(size), whole(size);
        for (Eigen::Index r = 0; r < size; ++r) {
            excess[r] = excess_[front.rows[std::size_t(r)]].value;
            whole[r] = excess_[front.rows[std::size_t(r)]].size;
        }
        front.pivots.resize(own);
        for (Eigen::Index begin = 0; begin < own; begin += panel) {
            const Eigen::Index end = (std::min)(begin + panel, own), rest = size - end;
            for (Eigen::Index c = begin; c < end; ++c) {
                const Eigen::Index below = size - c - 1, done = c - begin;
                auto column = matrix.col(c).tail(below);
                const Vector row = matrix.row(c)
                                       .segment(begin, done)
                                       .transpose()
                                       .cwiseProduct(front.pivots.segment(begin, done));
                if (below > 0 && done > 0) column.noalias() -= matrix.block(c + 1, begin, below, done) * row;
                const double pivot = excess[c] - column.sum();
                const double least = rounding * (whole[c] + column.cwiseAbs().sum());
                if (!(std::fabs(pivot) > least) || !std::isfinite(pivot)) return false;
                front.pivots[c] = pivot;
                column /= pivot;
                excess.tail(below) -= excess[c] * column;
                whole.tail(below) += whole[c] * column.cwiseAbs();
            }
            if (rest == 0) break;
            const auto columns = matrix.block(end, begin, rest, end - begin);
            const Matrix scaled = columns * front.pivots.segment(begin, end - begin).asDiagonal();
            matrix.bottomRightCorner(rest, rest).triangularView<Eigen::Lower>() -=
                scaled * columns.transpose();
        }
        for (Eigen::Index r = own; r < size; ++r) excess_[front.rows[std::size_t(r)]] = {excess[r], whole[r]};
        front.columns = matrix.leftCols(own);
        return true;
    }

    std::vector<Front> fronts_;           ///< in elimination order
    std::vector<Update> pending_;         ///< updates whose parent front is not assembled yet
    std::vector<std::uint32_t> position_; ///< per node, in elimination order
    std::vector<std::uint32_t> marked_;   ///< per node, number of the last front that contains it
    std::vector<Eigen::Index> local_;     ///< per node, its row in that front
    std::vector<Excess> excess_;          ///< updated during elimination
};

} // namespace cageform::inline CAGEFORM_ABI::detail
