#include "coordinates.hpp"

#include <algorithm>

namespace cageform_examples {

const std::vector<std::string>& CoordinatesChoice::names() {
    static const std::vector<std::string> all{"barycentric", "mean-value", "harmonic"};
    return all;
}

void CoordinatesChoice::add_options(CommandLine& line) {
    line.add("--coordinates", name, "barycentric, mean-value or harmonic")
        .check([](const std::string& given) {
            const auto& known = names();
            return std::find(known.begin(), known.end(), given) != known.end()
                       ? std::string()
                       : "\"" + given + "\" is not one of barycentric, mean-value, harmonic";
        });
    line.add("--resolution", harmonic.resolution, "harmonic: grid cells along the longer side")
        .show_default();
    line.add_number(
            "--tolerance",
            [this](double t) { harmonic.multigrid.tolerance = harmonic.averaging.tolerance = t; },
            "harmonic: where the solver ends; the error (multigrid) or the mean change of a cell")
        .show_default("1e-06");
    line.add_text(
            "--solver",
            [this](const std::string& given) {
                harmonic.solver = given == "multigrid" ? cageform::HarmonicSolver::multigrid
                                                       : cageform::HarmonicSolver::averaging_pyramid;
            },
            "harmonic: multigrid, or the papers' averaging-pyramid")
        .check([](const std::string& given) {
            return given == "multigrid" || given == "averaging-pyramid"
                       ? std::string()
                       : "\"" + given + "\" is not one of multigrid, averaging-pyramid";
        })
        .show_default("multigrid");
}

} // namespace cageform_examples
