#pragma once

// The coordinate types: for the files that compile them.

#include "cli/coordinates.hpp"
#include "io/messages.hpp"

#include <cageform/binding/make_coordinates.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

namespace cageform_support {

/// Returns harmonic coordinates on the uniform grid if there is a resolution, else on the adaptive one.
template <class C>
auto harmonic(const C& cage, const cageform::HarmonicOptions& options) {
    return options.resolution != 0 ? cageform::HarmonicCoordinates(cage, options, cageform::UniformGrid{})
                                   : cageform::HarmonicCoordinates(cage, options);
}

/// Makes harmonic coordinates. If their grid takes much memory, `note` says how much and why.
///
///   thickness   of the cage in the mean, in the figure's units
template <class C>
ChosenCoordinates<typename C::scalar, C::dimension>
make_harmonic(const C& cage, const cageform::HarmonicOptions& options, double thickness) {
    constexpr double much = 1 << 30;
    cageform::HarmonicOptions refused = options;
    refused.memory_limit = 1; // the estimate that a refusal states takes a small part of a solve
    ChosenCoordinates<typename C::scalar, C::dimension> made = harmonic(cage, options);
    const cageform::SolverReport estimate = harmonic(cage, refused).solve().solver;
    const double bytes = double(estimate.bytes);
    if (!(bytes > much)) return made;
    const double size = cageform::bounds_of(cage.vertices()).diagonal();
    made.note = "the grid of harmonic coordinates takes about " + detail::short_number(bytes / (1 << 30)) +
                " GiB for " + detail::short_number(double(estimate.cells)) + " nodes, as the cage is " +
                detail::short_number(thickness) + " thick in the mean and " + detail::short_number(size) +
                " long; --coordinates mean-value and green need no grid";
    return made;
}

/// The coordinates of a lattice, which --coordinates does not choose.
template <class T, std::size_t D>
ChosenCoordinates<T, D> lattice_coordinates(const CoordinatesChoice& choice, const LatticeBox<D>& lattice) {
    if (choice.is_named)
        warn("--coordinates " + choice.name + " is not used: a lattice has functions of its own");
    return lattice.template coordinates<T>();
}

template <class T, std::size_t D>
ChosenCoordinates<T, D> make_coordinates(const CoordinatesChoice& choice, const SiteFile<D>& sites) {
    cageform::CoordinateOptions<T> options;
    if (choice.gradients == "gentle") options.sibson.gradients = cageform::SiteGradients::gentle;
    if (choice.gradients == "mirrored") options.sibson.gradients = cageform::SiteGradients::mirrored;
    ChosenCoordinates<T, D> made =
        cageform::make_coordinates(choice.type(), cageform::PointSet<T, D>(sites.points), options);
    made.takes_sites = true;
    return made;
}

} // namespace cageform_support
