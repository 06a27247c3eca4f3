// A binding that was checked for rational clones.
#pragma once

#include <cageform/core/vec.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

/// A binding with weights suitable for rational clones, made by `rational_view`; owns nothing.
template <class View>
class RationalView {
public:
    using scalar = typename View::scalar;
    static constexpr std::size_t dimension = View::dimension;

    RationalView() = default;
    RationalView(const View& binding, scalar slack) noexcept
        : binding_(binding)
        , slack_(slack) {}

    std::size_t handle_count() const noexcept { return binding_.handle_count(); }
    std::size_t point_count() const noexcept { return binding_.point_count(); }
    const View& binding() const noexcept { return binding_; }
    /// Returns the largest sum of the absolute negative weights of a point.
    scalar slack() const noexcept { return slack_; }

private:
    View binding_;
    scalar slack_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI
