// Adapts GLM vectors as points: glm::vec2, glm::vec3, glm::dvec2, … with any qualifier.
#pragma once

#include <cageform/core/point.hpp>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

template <glm::length_t D, class T, glm::qualifier Q>
struct cageform::PointTraits<glm::vec<D, T, Q>> {
    using scalar = T;
    static constexpr std::size_t dimension = D;
    static constexpr T get(const glm::vec<D, T, Q>& p, std::size_t axis) noexcept {
        return p[glm::length_t(axis)];
    }
    static constexpr void set(glm::vec<D, T, Q>& p, std::size_t axis, T x) noexcept {
        p[glm::length_t(axis)] = x;
    }
};

static_assert(cageform::MutablePoint<glm::vec2> && cageform::MutablePoint<glm::dvec3>);
