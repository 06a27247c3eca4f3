#pragma once

// Harmonic coordinates in the plane by the papers' solver, for the programs that show it.

#include "averaging/pyramid_solver.hpp"
#include "cli/coordinates.hpp"

namespace cageform_sources {

using cageform_support::CageFile, cageform_support::ChosenCoordinates, cageform_support::CoordinatesChoice;

/// Makes the coordinates, on 128 cells unless `choice` has a resolution. Sweeps end when the mean change of a
/// cell is below --tolerance.
inline ChosenCoordinates<double, 2> averaged_coordinates(CoordinatesChoice choice, const CageFile& file) {
    if (choice.resolution == 0) choice.resolution = 128;
    const cageform::HarmonicOptions options = choice.harmonic_options(2);
    const averaging::AveragingSolver solver{.sweeps = {.tolerance = options.multigrid.tolerance}};
    return file.visit<double>([&](const auto& cage) -> ChosenCoordinates<double, 2> {
        return cageform::HarmonicCoordinates(cage, options, solver);
    });
}

} // namespace cageform_sources
