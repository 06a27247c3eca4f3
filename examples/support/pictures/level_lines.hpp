#pragma once

// Level lines of grid fields by marching squares.

#include "svg/path.hpp"

#include <array>
#include <cmath>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace cageform_support {

/// Extracts level lines, with linear interpolation along grid edges. In squares with four crossings, the mean
/// of the corners decides how they are connected. Closed lines end at their first point. Squares with a NaN
/// corner are skipped.
///
///   values   width · height, row-major; value (x, y) is at (x, y)
///   cost     O(#values + #crossings log #crossings)
inline std::vector<std::vector<Point2>> level_lines(std::span<const double> values, std::size_t width,
                                                    double level) {
    using Side = std::pair<std::size_t, bool>; // edge from value `first` to the right, or downwards (true)
    std::map<Side, std::vector<Side>> neighbours;
    const std::size_t height = width == 0 ? 0 : values.size() / width;
    for (std::size_t y = 0; y + 1 < height; ++y) {
        for (std::size_t x = 0; x + 1 < width; ++x) {
            const std::size_t i = y * width + x;
            const std::array<double, 4> corner{values[i], values[i + 1], values[i + width + 1],
                                               values[i + width]};
            const double mean = 0.25 * (corner[0] + corner[1] + corner[2] + corner[3]);
            if (std::isnan(mean)) continue;
            const std::array<Side, 4> sides{Side{i, false}, Side{i + 1, true}, Side{i + width, false},
                                            Side{i, true}};
            std::vector<Side> crossed;
            for (std::size_t k = 0; k < 4; ++k) {
                if ((corner[k] > level) != (corner[(k + 1) % 4] > level)) crossed.push_back(sides[k]);
            }
            // With four crossings, the lines cut off the two opposite corners that differ from the mean.
            if (crossed.size() == 4 && (corner[0] > level) != (mean > level))
                std::swap(crossed[1], crossed[3]);
            for (std::size_t k = 0; k + 1 < crossed.size(); k += 2) {
                neighbours[crossed[k]].push_back(crossed[k + 1]);
                neighbours[crossed[k + 1]].push_back(crossed[k]);
            }
        }
    }
    const auto place = [&](const Side& side) {
        const auto& [i, down] = side;
        const double a = values[i], b = values[i + (down ? width : 1)], t = (level - a) / (b - a);
        const std::size_t row = i / width;
        const double x = double(i % width), y = double(row);
        return down ? Point2{x, y + t} : Point2{x + t, y};
    };
    std::vector<std::vector<Point2>> lines;
    const auto follow = [&](Side side) { // removes the links that it follows
        std::vector<Point2> line{place(side)};
        for (auto* links = &neighbours[side]; !links->empty(); links = &neighbours[side]) {
            const Side next = links->back();
            links->pop_back();
            auto& back = neighbours[next];
            back.erase(back[0] == side ? back.begin() : back.begin() + 1);
            line.push_back(place(next));
            side = next;
        }
        lines.push_back(std::move(line));
    };
    for (const auto& [side, links] : neighbours) {
        if (links.size() == 1) follow(side);
    }
    for (const auto& [side, links] : neighbours) {
        if (!links.empty()) follow(side);
    }
    return lines;
}

} // namespace cageform_support
