// Clones compiled at one optimisation level: functions of each object of bench/level.cpp for
// bench/levels.cpp.
#pragma once

#include <cageform/runtime.hpp>

#include <span>

namespace cageform_bench {

template <class T, std::size_t D>
using Points = std::span<cageform::Vec<T, D>>;
template <class T, std::size_t D>
using Pose = std::span<const cageform::Vec<T, D>>;
template <class T>
using Tangents = std::array<cageform::BindingView<T, 3>, 2>;
template <class T>
using Axes = std::array<cageform::BindingView<T, 3>, 3>;

/// The functions of one object. They read and write memory of the caller, so the compiler cannot know the
/// arguments.
struct Level {
    template <class T, std::size_t D>
    using Dense = cageform::Status (*)(const cageform::BindingView<T, D>&, Pose<T, D>, Points<T, D>);
    template <class T>
    using Packed = cageform::Status (*)(const cageform::PackedBindingView<T, 3>&, Pose<T, 3>, Points<T, 3>);
    template <class T>
    using Figure = cageform::Status (*)(const cageform::PackedFigureView<T, 3>&, Pose<T, 3>, Points<T, 3>,
                                        Points<T, 3>, Points<T, 4>);
    template <class T>
    using Normals = cageform::Status (*)(const Tangents<T>&, Pose<T, 3>, Points<T, 3>);
    template <class T>
    using Jacobians = cageform::Status (*)(const Axes<T>&, Pose<T, 3>,
                                           const cageform::StridedMatrices<T, 3>&);

    template <class T>
    struct Of {
        Dense<T, 2> plane;
        Dense<T, 3> space;
        Packed<T> packed;
        Figure<T> figure;
        Normals<T> normals;
        Jacobians<T> jacobians;
    };
    Of<float> in_float;
    Of<double> in_double;

    template <class T>
    const Of<T>& of() const noexcept {
        if constexpr (sizeof(T) == sizeof(float))
            return in_float;
        else
            return in_double;
    }
};

} // namespace cageform_bench
