#include "pictures/membrane.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace cageform_support {

class MembraneBuilder {
public:
    MembraneBuilder(const PixelRegion& region, const MembraneOptions& options,
                    const cageform::ParallelFor& parallel)
        : region_(region)
        , options_(options)
        , width_(region.width)
        , height_(region.height) {
        membrane_.parallel_ = parallel;
        membrane_.width_ = width_;
    }

    Expected<Membrane> run() {
        label_parts();
        trace();
        sort_loops();
        find_squares();
        std::vector<std::string> faults(membrane_.groups_.size());
        membrane_.parallel_(membrane_.groups_.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) faults[n] = bind_group(membrane_.groups_[n]);
        });
        for (const std::string& fault : faults) {
            if (!fault.empty()) return FileError{"the region cannot be bound: " + fault};
        }
        report();
        return std::move(membrane_);
    }

private:
    using Place = std::array<float, 2>;

    /// A box of places, empty at first.
    struct Extent {
        Place low{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()},
            high{-low[0], -low[1]};

        void add(const Place& p) {
            for (std::size_t k = 0; k < 2; ++k) {
                low[k] = std::min(low[k], p[k]);
                high[k] = std::max(high[k], p[k]);
            }
        }
        void add(const Extent& other) {
            add(other.low);
            add(other.high);
        }
        float size() const { return std::hypot(high[0] - low[0], high[1] - low[1]); }
        float distance(const Extent& other) const {
            Place gap{};
            for (std::size_t k = 0; k < 2; ++k)
                gap[k] = std::max({low[k] - other.high[k], other.low[k] - high[k], 0.0f});
            return std::hypot(gap[0], gap[1]);
        }
    };

    /// A closed boundary of a part, outer or of a hole.
    struct Loop {
        std::size_t pixel = 0;           // an adjacent inner pixel
        std::uint32_t root = 0, end = 0; // of its sections
    };

    /// A node of the tree of a part's loops, which are consecutive.
    struct LoopRange {
        std::size_t begin = 0, end = 0;
        std::uint32_t right = 0; // index of the right half; 0 for a leaf. The left half follows
        Extent extent;
        float largest = 0; // largest size of a loop
    };

    bool is_inside(std::size_t pixel) const { return region_.kinds[pixel] == PixelKind::inside; }

    // ---- parts: connected components of pixels that share an edge ----

    std::uint32_t root_of(std::uint32_t run) {
        while (parents_[run] != run) run = parents_[run] = parents_[parents_[run]];
        return run;
    }
    /// Labels runs of pixels in each row, and merges adjacent runs by union-find.
    void label_parts() {
        part_.assign(region_.kinds.size(), 0);
        for (std::size_t y = 1; y + 1 < height_; ++y) { // the outer rows are never inside
            for (std::size_t x = 1, i = y * width_ + 1; x + 1 < width_; ++x, ++i) {
                if (!is_inside(i)) continue;
                if (is_inside(i - 1)) {
                    part_[i] = part_[i - 1];
                } else {
                    part_[i] = std::uint32_t(parents_.size());
                    parents_.push_back(part_[i]);
                }
                if (is_inside(i - width_) && part_[i - width_] != part_[i]) {
                    const std::uint32_t a = root_of(part_[i]), b = root_of(part_[i - width_]);
                    parents_[std::max(a, b)] = std::min(a, b);
                }
            }
        }
        std::vector<std::uint32_t> numbers(parents_.size());
        for (std::uint32_t run = 0; run < parents_.size(); ++run) {
            const std::uint32_t root = root_of(run); // the smallest of its part
            numbers[run] = root == run ? std::uint32_t(parts_++) : numbers[root];
        }
        parents_ = std::move(numbers);
    }
    std::uint32_t part_of(std::size_t pixel) const { return parents_[part_[pixel]]; }

    // ---- the outline ----

    /// Traces the edges between inner and other pixels. Each has a vertex near the other pixel's centre.
    void trace() {
        const auto w = std::ptrdiff_t(width_);
        const std::array<std::ptrdiff_t, 4> over{1, w, -1, -w}; // right, down, left, up
        constexpr std::array<Place, 4> normals{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
        std::vector<std::uint32_t> number(region_.kinds.size());
        for (std::uint32_t n = 0; n < region_.outline.size(); ++n) number[region_.outline[n]] = n;
        std::vector<std::uint8_t> traced(region_.kinds.size());
        std::vector<std::pair<Place, std::uint32_t>> vertices;
        const auto moved = [](std::size_t pixel, std::ptrdiff_t by) {
            return std::size_t(std::ptrdiff_t(pixel) + by);
        };
        for (std::size_t start = 0; start < region_.kinds.size(); ++start) {
            if (!is_inside(start)) continue;
            for (std::size_t first = 0; first < 4; ++first) {
                if (is_inside(moved(start, over[first])) || (traced[start] >> first & 1) != 0) continue;
                vertices.clear();
                std::size_t pixel = start, side = first;
                do {
                    traced[pixel] = std::uint8_t(traced[pixel] | 1u << side);
                    vertices.push_back({{float(pixel % width_) + 0.98f * normals[side][0],
                                         float(pixel / width_) + 0.98f * normals[side][1]},
                                        number[moved(pixel, over[side])]});
                    const std::size_t next = (side + 1) % 4;
                    const std::size_t ahead = moved(pixel, over[next]), across = moved(ahead, over[side]);
                    if (!is_inside(ahead)) {
                        side = next;
                    } else if (is_inside(across)) {
                        pixel = across;
                        side = (side + 3) % 4;
                    } else {
                        pixel = ahead;
                    }
                } while (pixel != start || side != first);
                Loop loop{start, std::uint32_t(membrane_.sections_.size()), 0};
                add_section(vertices, 0, vertices.size());
                loop.end = std::uint32_t(membrane_.sections_.size());
                loops_.push_back(loop);
                membrane_.report_.vertices += vertices.size();
            }
        }
    }
    std::size_t add_section(const std::vector<std::pair<Place, std::uint32_t>>& vertices, std::size_t begin,
                            std::size_t end) {
        const std::size_t at = membrane_.sections_.size();
        membrane_.sections_.emplace_back();
        places_.emplace_back();
        extents_.emplace_back();
        if (end - begin == 1) {
            membrane_.sections_[at].vertices = vertices[begin].second;
            places_[at] = vertices[begin].first;
            extents_[at].add(places_[at]);
            return at;
        }
        const std::size_t middle = begin + (end - begin) / 2;
        const std::size_t left = add_section(vertices, begin, middle),
                          right = add_section(vertices, middle, end);
        membrane_.sections_[at] = {std::uint32_t(right), std::uint32_t(end - begin)};
        const float part = float(middle - begin) / float(end - begin);
        for (std::size_t k = 0; k < 2; ++k)
            places_[at][k] = part * places_[left][k] + (1 - part) * places_[right][k];
        extents_[at].add(extents_[left]);
        extents_[at].add(extents_[right]);
        return at;
    }

    /// Sorts the loops by part, and within a part spatially.
    void sort_loops() {
        std::sort(loops_.begin(), loops_.end(), [&](const Loop& a, const Loop& b) {
            return std::pair(part_of(a.pixel), a.root) < std::pair(part_of(b.pixel), b.root);
        });
        roots_.resize(parts_);
        for (std::size_t begin = 0, end = 0; begin < loops_.size(); begin = end) {
            const std::uint32_t part = part_of(loops_[begin].pixel);
            while (end < loops_.size() && part_of(loops_[end].pixel) == part) ++end;
            roots_[part] = add_loops(begin, end);
        }
    }
    std::uint32_t add_loops(std::size_t begin, std::size_t end) {
        const auto at = std::uint32_t(ranges_.size());
        LoopRange range{begin, end, 0, {}, 0};
        for (std::size_t n = begin; n < end; ++n) {
            const Extent& extent = extents_[loops_[n].root];
            range.extent.add(extent);
            range.largest = std::max(range.largest, extent.size());
        }
        ranges_.push_back(range);
        if (end - begin == 1) return at;
        const std::size_t axis =
            range.extent.high[0] - range.extent.low[0] < range.extent.high[1] - range.extent.low[1] ? 1 : 0;
        const std::size_t middle = begin + (end - begin) / 2;
        std::nth_element(loops_.begin() + std::ptrdiff_t(begin), loops_.begin() + std::ptrdiff_t(middle),
                         loops_.begin() + std::ptrdiff_t(end), [&](const Loop& a, const Loop& b) {
                             return extents_[a.root].low[axis] < extents_[b.root].low[axis];
                         });
        add_loops(begin, middle);
        const std::uint32_t right = add_loops(middle, end);
        ranges_[at].right = right;
        return at;
    }

    // ---- squares and their corners ----

    /// Chebyshev distance of each pixel to the nearest pixel that is not inside.
    std::vector<std::uint16_t> distances() const {
        constexpr std::uint16_t most = std::numeric_limits<std::uint16_t>::max() - 1;
        std::vector<std::uint16_t> far(region_.kinds.size(), 0);
        const std::size_t w = width_;
        const auto lower = [&](const std::array<std::size_t, 4>& others) {
            std::uint16_t least = most;
            for (const std::size_t other : others) least = std::min(least, far[other]);
            return std::uint16_t(least + 1);
        };
        for (std::size_t i = 0; i < far.size(); ++i) {
            if (is_inside(i)) far[i] = lower({i - 1, i - w - 1, i - w, i - w + 1});
        }
        for (std::size_t i = far.size(); i-- > 0;) {
            if (is_inside(i)) far[i] = std::min(far[i], lower({i + 1, i + w + 1, i + w, i + w - 1}));
        }
        return far;
    }

    void find_squares() {
        far_ = distances();
        point_at_.assign(region_.kinds.size(), none);
        levels_ = std::size_t(std::bit_width(std::max(width_, height_) - 1));
        occupied_.resize(levels_ + 1);
        std::size_t w = width_, h = height_;
        occupied_[0].resize(w * h);
        for (std::size_t i = 0; i < w * h; ++i) occupied_[0][i] = is_inside(i) ? 1 : 0;
        for (std::size_t level = 1; level <= levels_; ++level) {
            const std::size_t narrow = (w + 1) / 2;
            occupied_[level].resize(narrow * ((h + 1) / 2));
            for (std::size_t y = 0; y < h; ++y) {
                for (std::size_t x = 0; x < w; ++x)
                    occupied_[level][y / 2 * narrow + x / 2] |= occupied_[level - 1][y * w + x];
            }
            w = narrow;
            h = (h + 1) / 2;
        }
        const Squares all = visit(levels_, 0, 0);
        add_groups(all);
        find_t_junctions();
        occupied_ = {};
        far_ = {};
        point_at_ = {};
    }

    /// A range of squares, and whether they are in groups.
    struct Squares {
        std::size_t begin = 0, end = 0;
        bool are_grouped = false;
    };
    Squares visit(std::size_t level, std::size_t x, std::size_t y) {
        auto& squares = membrane_.squares_;
        Squares all{squares.size(), squares.size(), false};
        const std::size_t columns = ((width_ - 1) >> level) + 1, rows = ((height_ - 1) >> level) + 1;
        if (x >= columns || y >= rows || occupied_[level][y * columns + x] == 0) return all;
        const std::size_t side = std::size_t(1) << level, left = x << level, top = y << level;
        bool is_square = level == 0;
        if (level > 0 && left + side < width_ && top + side < height_) {
            const double middle = far_[(top + side / 2) * width_ + left + side / 2];
            is_square = double(side) <= options_.square * (middle - double(side) / 2);
        }
        if (is_square) {
            squares.push_back({top * width_ + left, std::uint32_t(side), {}});
            all.end = squares.size();
            return all;
        }
        std::array<Squares, 4> quarters;
        for (std::size_t q = 0; q < 4; ++q) {
            quarters[q] = visit(level - 1, 2 * x + q % 2, 2 * y + q / 2);
            all.are_grouped = all.are_grouped || quarters[q].are_grouped;
        }
        all.end = squares.size();
        constexpr std::size_t most = 96; // squares per group
        all.are_grouped = all.are_grouped || all.end - all.begin > most;
        if (all.are_grouped) {
            for (const Squares& quarter : quarters) add_groups(quarter);
        }
        return all;
    }

    /// Adds the corners of squares as points, one group per part.
    void add_groups(const Squares& squares) {
        if (squares.are_grouped || squares.begin == squares.end) return;
        std::vector<std::size_t> order;
        for (std::size_t n = squares.begin; n < squares.end; ++n) order.push_back(n);
        const auto part = [&](std::size_t n) { return part_of(membrane_.squares_[n].first); };
        if (parts_ > 1)
            std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
                return std::pair(part(a), a) < std::pair(part(b), b);
            });
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (i == 0 || part(order[i]) != part(order[i - 1])) membrane_.groups_.emplace_back();
            Membrane::Square& square = membrane_.squares_[order[i]];
            const std::size_t side = square.side;
            const std::array<std::size_t, 4> pixels{square.first, square.first + side,
                                                    square.first + side * width_,
                                                    square.first + side * width_ + side};
            for (std::size_t k = 0; k < (side == 1 ? 1 : 4); ++k) {
                std::uint32_t& point = point_at_[pixels[k]];
                if (point == none) {
                    point = std::uint32_t(points_.size());
                    points_.push_back({float(pixels[k] % width_), float(pixels[k] / width_)});
                    membrane_.groups_.back().points.push_back(point);
                    part_at_.push_back(part(order[i]));
                }
                square.corners[k] = point;
            }
        }
    }

    /// Finds points in the middle of larger squares' sides (T-junctions), largest squares first, because ends
    /// of a side may be T-junctions too.
    void find_t_junctions() {
        std::vector<const Membrane::Square*> large;
        for (const auto& square : membrane_.squares_) {
            if (square.side > 2) large.push_back(&square);
        }
        std::sort(large.begin(), large.end(), [](const auto* a, const auto* b) {
            return a->side != b->side ? a->side > b->side : a->first < b->first;
        });
        std::vector<std::uint8_t> is_t_junction(points_.size());
        for (const auto* const square : large) {
            const std::size_t half = square->side / 2, side = square->side, first = square->first;
            const auto& [a, b, c, d] = square->corners;
            const auto add = [&](std::size_t pixel, std::uint32_t one, std::uint32_t other) {
                const std::uint32_t point = point_at_[pixel];
                if (point == none || is_t_junction[point] != 0) return;
                is_t_junction[point] = 1;
                membrane_.t_junctions_.push_back({point, one, other});
            };
            add(first + half, a, b);
            add(first + half * width_, a, c);
            add(first + side * width_ + half, c, d);
            add(first + half * width_ + side, b, d);
        }
        for (Membrane::Group& group : membrane_.groups_)
            std::erase_if(group.points, [&](std::uint32_t point) { return is_t_junction[point] != 0; });
        std::erase_if(membrane_.groups_, [](const Membrane::Group& group) { return group.points.empty(); });
    }

    // ---- weights ----

    /// An approximation of the outline for points in an extent: sections, and their number per loop.
    struct OutlineSections {
        std::vector<std::uint32_t> sections;
        std::vector<std::size_t> loops;
    };
    void approximate(const Extent& from, double coarseness, std::uint32_t range,
                     OutlineSections& used) const {
        const LoopRange& loops = ranges_[range];
        // The weights of the two sides of a distant hole nearly cancel.
        if (double(loops.largest) <= 0.125 * coarseness * double(loops.extent.distance(from))) return;
        if (loops.right != 0) {
            approximate(from, coarseness, range + 1, used);
            approximate(from, coarseness, loops.right, used);
            return;
        }
        const std::uint32_t root = loops_[loops.begin].root;
        const std::size_t before = used.sections.size();
        add_sections(from, coarseness, root, 2, used); // each loop has four vertices or more
        used.loops.push_back(used.sections.size() - before);
    }
    void add_sections(const Extent& from, double coarseness, std::uint32_t at, int depth,
                      OutlineSections& used) const {
        const Membrane::Section& section = membrane_.sections_[at];
        if (section.right == 0 ||
            (depth <= 0 && double(extents_[at].size()) <= coarseness * double(extents_[at].distance(from)))) {
            used.sections.push_back(at);
            return;
        }
        add_sections(from, coarseness, at + 1, depth - 1, used);
        add_sections(from, coarseness, section.right, depth - 1, used);
    }

    /// Returns the error if a group cannot be bound; else empty.
    std::string bind_group(Membrane::Group& group) const {
        Extent extent;
        for (const std::uint32_t point : group.points) extent.add(points_[point]);
        const auto about = [&](const Place& p) { // relative to the centre, for precision
            return cageform::Vec<float, 2>{p[0] - (extent.low[0] + extent.high[0]) / 2,
                                           p[1] - (extent.low[1] + extent.high[1]) / 2};
        };
        std::vector<cageform::Vec<float, 2>> points, vertices;
        for (const std::uint32_t point : group.points) points.push_back(about(points_[point]));
        OutlineSections used;
        approximate(extent, options_.coarseness, roots_[part_at_[group.points.front()]], used);
        for (;;) {
            vertices.clear();
            for (const std::uint32_t at : used.sections) vertices.push_back(about(places_[at]));
            const cageform::MeanValueCoordinates<float, 2> coordinates(
                cageform::Polygon<float>(vertices, used.loops));
            // A coarse outline may self-intersect; the finest does not.
            const cageform::CageReport& cage = coordinates.cage_report();
            if (cage.status != cageform::Status::ok && refine(cage, used)) continue;
            auto bound =
                cageform::bind(coordinates, points, {.linear_precision = cageform::LinearPrecision::leave});
            if (!bound) return cageform::to_string(bound.status());
            // A binding with these weights, whose handles are colours: 0 at rest.
            auto memory = std::move(bound.value).release();
            const std::vector<Membrane::Values> black(vertices.size());
            std::vector<cageform::Lanes<float>> at_rest(3 * cageform::block_count<float>(points.size()));
            for (auto& lanes : at_rest) std::fill(std::begin(lanes.v), std::end(lanes.v), 0.0f);
            group.binding = {std::move(memory.weights), std::move(at_rest), black, points.size()};
            group.handles = std::move(used.sections);
            return {};
        }
    }
    /// Halves the sections at which the outline has errors; false if none can be halved.
    bool refine(const cageform::CageReport& cage, OutlineSections& used) const {
        std::vector<std::uint8_t> is_named(used.sections.size());
        std::vector<std::size_t> loop_of, begins{0};
        for (std::size_t l = 0; l < used.loops.size(); ++l) {
            loop_of.insert(loop_of.end(), used.loops[l], l);
            begins.push_back(loop_of.size());
        }
        const auto name_edge = [&](std::size_t from) {
            const std::size_t loop = loop_of[from];
            is_named[from] = is_named[from + 1 < begins[loop + 1] ? from + 1 : begins[loop]] = 1;
        };
        for (const cageform::CageFault& fault : cage.faults) {
            if (fault.kind == cageform::CageFaultKind::edges_cross ||
                fault.kind == cageform::CageFaultKind::duplicate_vertices) {
                name_edge(fault.a);
                name_edge(fault.b);
            } else if (fault.kind == cageform::CageFaultKind::no_area) {
                for (std::size_t i = begins[fault.a]; i < begins[fault.a + 1]; ++i) is_named[i] = 1;
            }
        }
        std::vector<std::uint32_t> finer;
        std::size_t halved = 0;
        for (std::size_t i = 0; i < is_named.size(); ++i) {
            const std::uint32_t at = used.sections[i], right = membrane_.sections_[at].right;
            if (is_named[i] == 0 || right == 0) {
                finer.push_back(at);
                continue;
            }
            finer.insert(finer.end(), {at + 1, right});
            ++used.loops[loop_of[i]];
            ++halved;
        }
        used.sections = std::move(finer);
        return halved > 0;
    }

    void report() {
        MembraneReport& report = membrane_.report_;
        report.loops = loops_.size();
        report.parts = parts_;
        report.groups = membrane_.groups_.size();
        for (const Membrane::Group& group : membrane_.groups_) {
            report.points += group.points.size();
            report.weights += group.points.size() * group.handles.size();
        }
        membrane_.section_values_.resize(membrane_.sections_.size());
        membrane_.values_.resize(points_.size());
    }

    static constexpr std::uint32_t none = ~std::uint32_t{0};

    const PixelRegion& region_;
    MembraneOptions options_;
    std::size_t width_, height_;
    Membrane membrane_;

    std::vector<std::uint32_t> part_, parents_; // run of each pixel; part of each run
    std::size_t parts_ = 0;
    std::vector<Loop> loops_;
    std::vector<LoopRange> ranges_;
    std::vector<std::uint32_t> roots_; // #parts: index into ranges_
    std::vector<Place> places_;        // of sections
    std::vector<Extent> extents_;
    std::vector<std::uint16_t> far_;
    std::vector<std::uint32_t> point_at_;
    std::size_t levels_ = 0;
    std::vector<std::vector<std::uint8_t>> occupied_; // by level: whether a square contains an inner pixel
    std::vector<Place> points_;
    std::vector<std::uint32_t> part_at_; // of points
};

Expected<Membrane> Membrane::bind(const PixelRegion& region, const MembraneOptions& options,
                                  const cageform::ParallelFor& parallel) {
    if (region.inside == 0) return FileError{"the region has no inside: all its pixels are on its outline"};
    return MembraneBuilder(region, options, parallel).run();
}

void Membrane::find_corners(std::span<const Values> outline) {
    for (std::size_t n = sections_.size(); n-- > 0;) {
        const Section& section = sections_[n];
        if (section.right == 0) {
            section_values_[n] = outline[section.vertices];
            continue;
        }
        const float part = float(section.vertices / 2) / float(section.vertices);
        section_values_[n] = part * section_values_[n + 1] + (1 - part) * section_values_[section.right];
    }
    parallel_(groups_.size(), 8, [&](std::size_t begin, std::size_t end) {
        std::vector<Values> pose, found;
        for (std::size_t n = begin; n < end; ++n) {
            const Group& group = groups_[n];
            pose.clear();
            for (const std::uint32_t handle : group.handles) pose.push_back(section_values_[handle]);
            found.resize(group.points.size());
            // The sizes match, and the values are finite.
            static_cast<void>(cageform::clone(group.binding, pose, found));
            for (std::size_t i = 0; i < found.size(); ++i) values_[group.points[i]] = found[i];
        }
    });
    for (const auto& [point, one, other] : t_junctions_)
        values_[point] = 0.5f * (values_[one] + values_[other]);
}

} // namespace cageform_support
