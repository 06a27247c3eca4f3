// The stages of a wrap.
#pragma once

#include <cageform/core/types/bounds.hpp>
#include <cageform/fit/types/wrap.hpp>

#include <algorithm>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the stages of the options; the cage first if there is one.
inline std::vector<WrapOptions::Stage> wrap_stages(const WrapOptions& options, bool has_cage) {
    std::vector<WrapOptions::Stage> stages = options.stages;
    if (stages.empty()) {
        if (has_cage)
            stages.push_back({0, {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}, 0.05});
        else
            stages.push_back({6, {1e-2, 1e-3, 1e-4}, 0.08});
        for (unsigned cells = 12; cells <= (std::min)(options.finest, 192u); cells *= 2) {
            if (cells == 12) stages.push_back({cells, {1e-4, 1e-5}, 0.05});
            if (cells == 24) stages.push_back({cells, {1e-5, 1e-6, 1e-7}, 0.03});
            if (cells > 24) stages.push_back({cells, {1e-7}, 0.03});
        }
        for (WrapOptions::Stage& stage : stages)
            std::erase_if(stage.stiffness, [&](double x) { return x < 0.99 * options.least_stiffness; });
        while (!stages.empty() && stages.back().stiffness.empty()) stages.pop_back();
    }
    return stages;
}

/// Whether a lattice has so many handles in a box that it is too large, however few are near samples.
inline bool is_too_large(const WrapOptions& options, unsigned cells, const Bounds<double, 3>& box) noexcept {
    constexpr double most_per_used = 64; // handles in the box per handle near samples
    double all = 1;
    for (std::size_t k = 0; k < 3; ++k) all *= (box.upper[k] - box.lower[k]) * cells + 5;
    return all > most_per_used * double(options.handles);
}

} // namespace cageform::inline CAGEFORM_ABI::detail
