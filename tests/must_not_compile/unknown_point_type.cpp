// BROKEN: PointTraits: core/point.hpp, adapt/
#include <cageform/core/view.hpp>

#include <vector>

struct Pixel {
    float x, y;
};

#if !defined(BROKEN)
template <>
struct cageform::PointTraits<Pixel> {
    using scalar = float;
    static constexpr std::size_t dimension = 2;
    static constexpr float get(const Pixel& p, std::size_t axis) noexcept { return axis == 0 ? p.x : p.y; }
};
#endif

static_assert(cageform::PointRange<std::vector<Pixel>>);
