// Cloning a region of one picture into another: properties of the membrane, compared with weights computed
// directly and with a solution of the Poisson equation.
#include "catch.hpp"
#include "files/cage_file.hpp"
#include "pictures/image_clone.hpp"
#include "support/cages.hpp"
#include "support/effort.hpp"

#include <cageform/cage/polygon.hpp>
#include <cageform/parallel/threads.hpp>

#include <filesystem>
#include <fstream>

namespace clone_image_tests {

using namespace cageform_tests;
using namespace cageform_support;
using Values = Membrane::Values;

/// Random discs and holes; with `noise`, single pixels change too.
PixelRegion random_region(Random& random, std::size_t size, bool noise) {
    std::vector<std::uint8_t> mask(size * size);
    const std::size_t discs = 3 + random.below(6);
    for (std::size_t n = 0; n < discs; ++n) {
        const double x = random.uniform(0, double(size)), y = random.uniform(0, double(size)),
                     radius = random.uniform(0.05, n == 0 ? 0.5 : 0.3) * double(size);
        const std::uint8_t mark = n > 0 && random.below(3) == 0 ? 0 : 1;
        for (std::size_t i = 0; i < mask.size(); ++i) {
            if (std::hypot(double(i % size) - x, double(i / size) - y) < radius) mask[i] = mark;
        }
    }
    for (std::size_t n = noise ? mask.size() / 50 : 0; n-- > 0;) mask[random.below(mask.size())] ^= 1;
    mask[size + 1] = mask[size + 2] = mask[size] = mask[1] = mask[2 * size + 1] = 1; // not empty
    return make_region(mask, size);
}
PixelRegion rectangle(std::size_t width, std::size_t height) {
    return make_region(std::vector<std::uint8_t>(width * height, 1), width);
}

/// Calls f(pixel, x, y) for all pixels of a kind, with their coordinates in the bounding box.
template <class F>
void for_each_pixel(const PixelRegion& region, PixelKind kind, const F& f) {
    for (std::size_t i = 0; i < region.kinds.size(); ++i) {
        if (region.kinds[i] == kind) f(i, double(i % region.width), double(i / region.width));
    }
}
template <class F>
std::vector<Values> on_outline(const PixelRegion& region, const F& value) {
    std::vector<Values> values;
    for_each_pixel(region, PixelKind::outline,
                   [&](std::size_t, double x, double y) { values.push_back(value(x, y)); });
    return values;
}
std::vector<Values> random_values(Random& random, std::size_t count) {
    std::vector<Values> values(count);
    for (Values& value : values) {
        for (float& v : value.v) v = float(random.uniform(-255, 255));
    }
    return values;
}
/// Values from −1 to 1 that change over some tens of pixels.
std::vector<Values> smooth_values(Random& random, const PixelRegion& region) {
    const double a = random.uniform(0, 6), b = random.uniform(0, 6),
                 size = double(region.width + region.height);
    return on_outline(region, [&](double x, double y) {
        return Values{float(std::sin(a + 6 * x / size)), float(std::cos(b + 6 * y / size)),
                      float(std::sin(b + 5 * (x - y) / size))};
    });
}
std::vector<Values> all_of(Membrane& membrane, const PixelRegion& region, std::span<const Values> outline) {
    std::vector<Values> all(region.kinds.size());
    std::vector<std::uint8_t> times(all.size());
    membrane.interpolate(outline,
                         [&](std::size_t first, std::size_t count, Values value, const Values& step) {
                             for (std::size_t i = first; i < first + count; ++i, value = value + step) {
                                 all[i] = value;
                                 ++times[i];
                             }
                         });
    for (std::size_t i = 0; i < all.size(); ++i)
        REQUIRE(int(times[i]) == (region.kinds[i] == PixelKind::inside ? 1 : 0));
    return all;
}
Membrane membrane_of(const PixelRegion& region, const MembraneOptions& options = {}) {
    auto made = Membrane::bind(region, options);
    REQUIRE(made);
    return std::move(*made);
}
float distance(const Values& a, const Values& b) {
    float largest = 0;
    for (std::size_t k = 0; k < 3; ++k) largest = std::max(largest, std::fabs(a[k] - b[k]));
    return largest;
}
Pixels random_picture(Random& random, std::size_t width, std::size_t height) {
    Pixels picture{width, height};
    for (std::uint8_t& byte : picture.bytes) byte = std::uint8_t(random.below(256));
    return picture;
}

TEST_CASE("a region's outline has a neighbour that is not in it", "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(40, 8)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 7);
    const std::size_t width = 1 + random.below(12), height = 1 + random.below(12);
    std::vector<std::uint8_t> mask(width * height);
    for (std::uint8_t& mark : mask) mark = random.below(4) != 0 ? 1 : 0;
    const PixelRegion region = make_region(mask, width);
    const auto marked = [&](std::size_t x, std::size_t y) {
        return x < width && y < height && mask[y * width + x] != 0;
    };
    std::size_t inside = 0, seen = 0, outline = 0;
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t u = x - region.left, v = y - region.top;
            const bool in_box = u < region.width && v < region.height; // both wrap around
            const PixelKind kind = in_box ? region.kinds[v * region.width + u] : PixelKind::outside;
            const bool is_inside =
                marked(x, y) && marked(x + 1, y) && marked(x - 1, y) && marked(x, y + 1) && marked(x, y - 1);
            CHECK(kind == (is_inside      ? PixelKind::inside
                           : marked(x, y) ? PixelKind::outline
                                          : PixelKind::outside));
            inside += is_inside ? 1 : 0;
            if (kind == PixelKind::outline) {
                CHECK(region.outline[outline++] == v * region.width + u);
            }
            seen += in_box ? 1 : 0;
        }
    }
    CHECK(region.inside == inside);
    CHECK(region.outline.size() == outline);
    CHECK(seen == region.kinds.size());
}

TEST_CASE("a pixel is in an outline if its centre is", "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(40, 8)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 17);
    const std::size_t width = 1 + random.below(30), height = 1 + random.below(30);
    std::vector<std::vector<Point2>> loops(1 + random.below(3));
    std::vector<Point2> all;
    std::vector<std::size_t> sizes;
    for (auto& loop : loops) {
        for (std::size_t n = 3 + random.below(9); n-- > 0;)
            loop.push_back({random.uniform(-5, double(width) + 5), random.uniform(-5, double(height) + 5)});
        all.insert(all.end(), loop.begin(), loop.end());
        sizes.push_back(loop.size());
    }
    const cageform::Polygon<double> polygon(all, sizes);
    const auto mask = mask_of(loops, width, height);
    REQUIRE(mask.size() == width * height);
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const auto state =
            cageform::locate(polygon, {double(i % width) + 0.5, double(i / width) + 0.5}, 1e-9);
        if (state != cageform::PointState::on_boundary)
            CHECK((mask[i] != 0) == (state == cageform::PointState::inside));
    }
}

TEST_CASE("a membrane reproduces linear functions", "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(30, 6)));
    const bool noise = GENERATE(false, true);
    CAPTURE(seed, noise);
    Random random(std::uint64_t(seed) + 27);
    const PixelRegion region = random_region(random, 8 + random.below(effort<std::size_t>(120, 40)), noise);
    Membrane membrane = membrane_of(region);
    const double a = random.uniform(-1, 1), b = random.uniform(-1, 1), c = random.uniform(-99, 99);
    const auto linear = [&](double x, double y) {
        return Values{float(a * x + b * y + c), float(c), float(b * y)};
    };
    const auto all = all_of(membrane, region, on_outline(region, linear));
    const double size = double(region.width + region.height) + std::fabs(c);
    for_each_pixel(region, PixelKind::inside, [&](std::size_t i, double x, double y) {
        // The outline is 0.02 pixels from a pixel's centre; where the region is concave some weights exceed
        // 1 in absolute value and amplify that.
        CHECK(distance(all[i], linear(x, y)) < 0.2 + 1e-5 * size);
        CHECK(std::fabs(double(all[i][1]) - c) < 1e-4 * size); // a constant does not depend on positions
    });
}

TEST_CASE("a membrane over a rectangle stays in the range of its outline",
          "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 37);
    const PixelRegion region = rectangle(3 + random.below(90), 3 + random.below(90));
    Membrane membrane = membrane_of(region);
    const auto outline = random_values(random, region.outline.size());
    const auto all = all_of(membrane, region, outline);
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [least, largest] = std::minmax_element(
            outline.begin(), outline.end(), [&](const Values& a, const Values& b) { return a[k] < b[k]; });
        for_each_pixel(region, PixelKind::inside, [&](std::size_t i, double, double) {
            CHECK(all[i][k] >= (*least)[k] - 0.01f);
            CHECK(all[i][k] <= (*largest)[k] + 0.01f);
        });
    }
}

TEST_CASE("an approximate membrane is close to the exact one", "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(20, 3)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 47);
    const PixelRegion region = random_region(random, 20 + random.below(effort<std::size_t>(90, 20)), false);
    Membrane coarse = membrane_of(region), full = membrane_of(region, {0, 0});
    CHECK(full.report().points == region.inside);
    const auto outline = smooth_values(random, region);
    const auto near = all_of(coarse, region, outline), exact = all_of(full, region, outline);
    double sum = 0;
    for_each_pixel(region, PixelKind::inside, [&](std::size_t i, double, double) {
        CHECK(distance(near[i], exact[i]) < 0.1); // of a range of 2
        sum += double(distance(near[i], exact[i]));
    });
    CHECK(sum / double(region.inside) < 0.01);
}

TEST_CASE("separate parts of a region do not affect each other", "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(10, 3)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 57);
    const std::size_t size = 10 + random.below(30);
    std::vector<std::uint8_t> mask(2 * size * size, 1);
    for (std::size_t y = 0; y < size; ++y) mask[y * 2 * size + size] = 0;
    const PixelRegion region = make_region(mask, 2 * size);
    Membrane membrane = membrane_of(region);
    CHECK(membrane.report().parts == 2);
    auto outline = random_values(random, region.outline.size());
    const auto before = all_of(membrane, region, outline);
    for (std::size_t n = 0; n < outline.size(); ++n) {
        if (region.outline[n] % region.width > size) outline[n] = {7, 8, 9};
    }
    const auto after = all_of(membrane, region, outline);
    for_each_pixel(region, PixelKind::inside, [&](std::size_t i, double x, double) {
        CHECK(distance(after[i], x < double(size) ? before[i] : Values{7, 8, 9}) < 2e-3f);
    });
}

TEST_CASE("both methods reproduce linear functions, also on a single pixel",
          "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(20, 4)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 67);
    const PixelRegion pixel = rectangle(3, 3);
    Membrane small = membrane_of(pixel);
    const auto values = random_values(random, pixel.outline.size());
    const Values mean = 0.25f * (values[1] + values[3] + values[4] + values[6]);
    const auto solved = poisson_function(pixel, values);
    REQUIRE(solved);
    CHECK(distance((*solved)[4], mean) < 0.06f);
    CHECK(distance(all_of(small, pixel, values)[4], mean) < 0.01f);

    const PixelRegion region = random_region(random, 10 + random.below(50), false);
    const double a = random.uniform(-1, 1), b = random.uniform(-1, 1);
    const auto linear = [&](double x, double y) {
        return Values{float(a * x + b * y), float(a), float(b * x)};
    };
    const auto all = poisson_function(region, on_outline(region, linear));
    REQUIRE(all);
    for_each_pixel(region, PixelKind::inside, [&](std::size_t i, double x, double y) {
        CHECK(distance((*all)[i], linear(x, y)) < 1e-3 * double(region.width + region.height));
    });
}

TEST_CASE("both methods agree approximately over a rectangle", "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(20, 4)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 77);
    const PixelRegion region = rectangle(10 + random.below(60), 10 + random.below(60));
    Membrane membrane = membrane_of(region);
    const auto outline = smooth_values(random, region);
    const auto all = all_of(membrane, region, outline);
    const auto exact = poisson_function(region, outline);
    REQUIRE(exact);
    for_each_pixel(region, PixelKind::inside,
                   [&](std::size_t i, double, double) { CHECK(distance(all[i], (*exact)[i]) < 0.2f); });
}

TEST_CASE("a clone changes only the region, and a constant difference shifts its colours by the constant",
          "[examples][clone_image][property]") {
    const auto seed = GENERATE(seeds(effort(20, 4)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 87);
    const std::size_t size = 10 + random.below(40);
    const PixelRegion region = random_region(random, size, true);
    Pixels source = random_picture(random, size, size);
    for (std::size_t i = 3; i < source.bytes.size(); i += 4) source.bytes[i] = random.below(2) != 0 ? 255 : 0;
    Membrane membrane = membrane_of(region);
    for (int move = 0; move < 3; ++move) { // all targets use one membrane
        const Pixels target = random_picture(random, size + random.below(20), size + random.below(20));
        const PixelPlace at{std::int64_t(random.below(target.width - region.width + 1)),
                            std::int64_t(random.below(target.height - region.height + 1))};
        REQUIRE(fault_of_place(region, target, at).empty());
        const std::array<int, 3> shift{int(random.below(400)) - 200, int(random.below(400)) - 200, 0};
        const std::vector<Values> constant(region.outline.size(), {float(shift[0]), float(shift[1]), 0});
        Pixels moved = target, pasted = target, bound = target, fresh = target;
        paste(source, region, at, constant, membrane, moved);
        const auto differences = outline_differences(source, region, target, at);
        paste(source, region, at, differences, membrane, bound);
        Membrane other = membrane_of(region);
        paste(source, region, at, differences, other, fresh);
        CHECK(bound.bytes == fresh.bytes);
        const auto threaded = Membrane::bind(region, {}, cageform::ThreadedFor{3});
        REQUIRE(threaded);
        other = *threaded;
        fresh = target;
        paste(source, region, at, differences, other, fresh);
        CHECK(bound.bytes == fresh.bytes);
        for (std::size_t y = 0; y < target.height; ++y) {
            for (std::size_t x = 0; x < target.width; ++x) {
                const std::size_t u = x - std::size_t(at.x), v = y - std::size_t(at.y);
                const bool is_inside = u < region.width && v < region.height &&
                                       region.kinds[v * region.width + u] == PixelKind::inside;
                CHECK(bound.at(x, y)[3] == target.at(x, y)[3]);
                for (std::size_t k = 0; k < 3; ++k) {
                    const int there = target.at(x, y)[k];
                    if (!is_inside) {
                        CHECK(int(bound.at(x, y)[k]) == there);
                        continue;
                    }
                    const std::uint8_t* const from = source.at(region.left + u, region.top + v);
                    CHECK(int(moved.at(x, y)[k]) ==
                          (from[3] == 0 ? there : std::clamp(from[k] + shift[k], 0, 255)));
                }
            }
        }
        // With a difference of 0 the source is unchanged.
        paste(source, region, at, std::vector<Values>(region.kinds.size()), pasted);
        CHECK(colour_difference(pasted, pasted, region, at).largest == 0);
        CHECK(colour_difference(bound, pasted, region, at).mean <= 255);
    }
}

TEST_CASE("cloning a picture into itself changes nothing", "[examples][clone_image]") {
    Random random(97);
    const Pixels picture = random_picture(random, 40, 30);
    const PixelRegion region = random_region(random, 30, true);
    Membrane membrane = membrane_of(region);
    const PixelPlace at{std::int64_t(region.left), std::int64_t(region.top)};
    Pixels cloned = picture;
    paste(picture, region, at, outline_differences(picture, region, picture, at), membrane, cloned);
    for_each_pixel(region, PixelKind::inside, [&](std::size_t i, double, double) {
        const std::size_t x = region.left + i % region.width, y = region.top + i / region.width;
        for (std::size_t k = 0; k < 3; ++k) // translucent pixels are blended, with a rounding error
            CHECK(std::abs(int(cloned.at(x, y)[k]) - int(picture.at(x, y)[k])) <= 1);
    });
}

TEST_CASE("a place outside the target is refused with the distance", "[examples][clone_image]") {
    const PixelRegion region = rectangle(30, 20);
    const Pixels target{50, 40};
    CHECK(fault_of_place(region, target, {0, 0}).empty());
    CHECK(fault_of_place(region, target, {20, 20}).empty());
    CHECK(fault_of_place(region, target, {21, -3}) ==
          "the region, 30 x 20 pixels, extends beyond the target, 50 x 40: 1 beyond its right side, 3 beyond "
          "its "
          "top; X from 0 to 20 and Y from 0 to 20 fit");
    CHECK(fault_of_place(region, Pixels{29, 40}, {0, 0}) ==
          "the region, 30 x 20 pixels, extends beyond the target, 29 x 40: 1 beyond its right side; the "
          "target is "
          "too small, so enlarge it or shrink the region");
    CHECK(fault_of_place(region, target, {-1000000000, 1000000000}).find("1000000000 beyond its left") !=
          std::string::npos);
}

TEST_CASE("a region without interior is refused", "[examples][clone_image]") {
    CHECK(make_region({}, 0).is_empty());
    CHECK(make_region(std::vector<std::uint8_t>(12), 4).is_empty());
    for (const auto& [width, height] : {std::pair<std::size_t, std::size_t>{1, 1}, {2, 9}, {9, 2}}) {
        const PixelRegion region = rectangle(width, height);
        CHECK(region.outline.size() == width * height);
        CHECK_FALSE(Membrane::bind(region));
    }
}

TEST_CASE("pictures are read back from PNG files", "[examples][clone_image]") {
    const auto folder = std::filesystem::temp_directory_path() /
                        ("clone_image_" + std::to_string(std::uintptr_t(&random_region)) + "_" +
                         std::to_string(std::hash<std::string>{}(std::filesystem::current_path().string())));
    std::filesystem::create_directories(folder);
    Random random(107);
    for (int n = 0; n < 5; ++n) { // an existing file is not overwritten
        const std::string path = (folder / (std::to_string(n) + ".png")).string();
        const Pixels picture = random_picture(random, 1 + random.below(20), 1 + random.below(20));
        {
            AtomicFile file(path);
            picture.write_png(file);
            REQUIRE_FALSE(file.commit());
        }
        const auto read = read_png(path);
        REQUIRE(read);
        CHECK(read->width == picture.width);
        CHECK(read->bytes == picture.bytes);
        // Truncated and corrupted files are refused or read, and nothing crashes.
        std::string bytes = picture.png();
        for (int spoilt = 0; spoilt < effort(60, 20); ++spoilt) {
            std::string other = bytes.substr(0, 8 + random.below(bytes.size() - 8));
            if (spoilt % 2 == 0) {
                other = bytes;
                other[8 + random.below(bytes.size() - 8)] = char(random.below(256));
            }
            std::ofstream(path, std::ios::binary) << other;
            const auto again = read_png(path);
            if (again) CHECK(again->bytes.size() == 4 * again->width * again->height);
        }
    }
    std::filesystem::remove_all(folder);
}

TEST_CASE("a shrunk picture keeps its mean", "[examples][clone_image]") {
    Random random(117);
    Pixels picture = random_picture(random, 64, 48);
    for (std::size_t i = 3; i < picture.bytes.size(); i += 4) picture.bytes[i] = 255;
    const Pixels small = shrunk(picture, 16);
    CHECK(small.width == 16);
    CHECK(small.height == 12);
    const auto mean = [](const Pixels& of) {
        double sum = 0;
        for (const std::uint8_t byte : of.bytes) sum += byte;
        return sum / double(of.bytes.size());
    };
    CHECK(std::fabs(mean(small) - mean(picture)) < 0.1);
    CHECK(shrunk(picture, 64).bytes == picture.bytes);
    const Pixels strip = side_by_side({small, picture}, 8);
    CHECK(strip.width == 16 + 8 + 64);
    CHECK(strip.height == 48);
    CHECK(std::equal(picture.at(0, 47), picture.at(0, 47) + 4 * 64, strip.at(24, 47)));
}

} // namespace clone_image_tests
