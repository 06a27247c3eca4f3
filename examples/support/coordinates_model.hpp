#pragma once

// AnyCoordinates of a type of the library: for the files that compile it.

#include "coordinates.hpp"

#include <cageform/binding/bind.hpp>

#include <utility>

namespace cageform_examples {

template <class C>
class CoordinatesModel : public AnyCoordinates<typename C::scalar, C::dimension> {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;
    using typename AnyCoordinates<T, D>::Points;

public:
    explicit CoordinatesModel(C coordinates)
        : own(std::move(coordinates)) {
        this->has_extension = C::has_extension;
        this->closed_form = C::closed_form;
        this->handles = own.handles().size();
        this->cage_report = own.cage_report();
    }

    cageform::Evaluation solve(const cageform::Running& running) override {
        if constexpr (requires { own.solve(running); })
            return own.solve(running);
        else
            return {};
    }
    cageform::BindResult<T, D> bind(Points points, const cageform::BindOptions& options,
                                    const cageform::Running& running) const override {
        return cageform::bind(own, points, options, running);
    }

    C own;
};

template <class C>
auto model_of(C coordinates) {
    return std::make_unique<CoordinatesModel<C>>(std::move(coordinates));
}

} // namespace cageform_examples
