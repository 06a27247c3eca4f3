// The boundary values of the handles.
#pragma once

#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/core/types/blocks.hpp>

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The boundary values on a PolyhedralMesh, which are not linear on faces with more than three corners.
/// Functions may throw std::bad_alloc.
class FaceData {
public:
    using Visit = std::function<void(std::uint32_t handle, double weight)>;

    virtual ~FaceData() = default;
    /// Calls visit(handle, weight) for the handles with a non-zero value at a surface point.
    virtual void weights(const BoundaryValue<3>& value, const Visit& visit) const = 0;
    /// Calls visit(handle, 1) for a superset of the handles with a non-zero value at a surface point.
    virtual void handles(const BoundaryValue<3>& value, const Visit& visit) const = 0;
};

/// The boundary values of the handles: hat functions, or the given FaceData of a PolyhedralMesh. Copies
/// share the FaceData.
template <std::size_t D>
class BoundaryData {
public:
    using Value = BoundaryValue<D>;

    BoundaryData() = default;
    explicit BoundaryData(std::shared_ptr<const FaceData> faces)
        requires(D == 3)
        : faces_(std::move(faces)) {}

    /// Whether the values are linear on every triangle.
    bool is_linear() const noexcept { return faces_ == nullptr; }

    /// Calls f(handle, weight) for the handles with a non-zero value at a boundary point.
    template <class F>
    void for_each_weight(const Value& value, F&& f) const {
        if constexpr (D == 3) {
            if (faces_) return faces_->weights(value, std::ref(f));
        }
        LinearBoundaryData<D>::for_each_weight(value, f);
    }
    /// Calls f(handle) for a superset of the handles with a non-zero value at a boundary point.
    template <class F>
    void for_each_handle(const Value& value, F&& f) const {
        const auto visit = [&](std::uint32_t handle, double) { f(handle); };
        if constexpr (D == 3) {
            if (faces_) return faces_->handles(value, std::ref(visit));
        }
        LinearBoundaryData<D>::for_each_weight(value, visit);
    }

    /// The weights at many boundary points. Refers to `values`.
    class Table {
    public:
        Table() = default;
        Table(const BoundaryData& data, std::span<const Value> values)
            : values_(values) {
            if (data.is_linear()) return;
            ends_.reserve(values.size());
            for (const Value& value : values) {
                data.for_each_weight(value, [&](std::uint32_t handle, double weight) {
                    entries_.push_back({handle, weight});
                });
                ends_.push_back(entries_.size());
            }
        }
        /// Calls f(handle, weight) for the handles with a non-zero value at point n.
        template <class F>
        void for_each_weight(std::size_t n, F&& f) const {
            if (ends_.empty()) return LinearBoundaryData<D>::for_each_weight(values_[n], f);
            for (std::size_t e = n == 0 ? 0 : ends_[n - 1]; e < ends_[n]; ++e)
                f(entries_[e].handle, entries_[e].weight);
        }

    private:
        struct Entry {
            std::uint32_t handle;
            double weight;
        };
        std::span<const Value> values_;
        std::vector<Entry> entries_; ///< by boundary point; empty for hat functions
        std::vector<std::size_t> ends_;
    };

private:
    std::shared_ptr<const FaceData> faces_;
};

/// Writes the boundary values at a point into a lane of a block with `handles` rows.
template <class T, std::size_t K, class Data = LinearBoundaryData<K>>
void store_boundary_value(const BoundaryValue<K>& value, std::size_t handles, Lanes<T>* rows,
                          std::size_t lane, const Data& data = {}) {
    for (std::size_t i = 0; i < handles; ++i) rows[i][lane] = T(0);
    data.for_each_weight(
        value, [&](std::uint32_t handle, double weight) { rows[handle][lane] += static_cast<T>(weight); });
}

} // namespace cageform::inline CAGEFORM_ABI::detail
