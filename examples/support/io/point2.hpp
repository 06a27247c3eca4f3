#pragma once

namespace cageform_support {

struct Point2 {
    double x = 0;
    double y = 0;
    friend bool operator==(const Point2&, const Point2&) = default;
};

} // namespace cageform_support
