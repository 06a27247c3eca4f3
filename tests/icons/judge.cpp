// Compares a deformed icon, as rendered, with the deformed picture of the icon: for run.sh and frames.sh.
//
//     judge prepare ICON.svg FOLDER   writes rest.svg, wide.svg (with a margin), cage.csv and bend.csv
//     judge compare FOLDER            of rest.png, wide.png, identity.png and bend.png: prints the largest
//     difference of
//                                     the identity, and of the bend the mean difference where either
//                                     picture has
//                                     paint and the share of it that differs by more than 32; writes
//                                     expected.png
//     judge difference A.png B.png    prints the largest difference, the mean and that share
//     judge sheet OUT.png FOLDER…     a row each: at rest, expected, bent
//
// Differences are in steps of 1/255 over white. A picture cannot be bent without blur, so they are of means
// of 2 x 2 pixels, and edges of an icon without a fault differ by some.

#include "../support/larger.hpp"
#include "svg/document.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/mean_value.hpp>

#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

using namespace cageform_support;
using Vertex = std::array<double, 2>;

constexpr int rendered_width = 256; // of the viewBox, in pixels
constexpr int wide_width = 768;     // of the viewBox and its margin
constexpr double margin = 0.25;     // of wide.svg, on each side, in sizes of the viewBox
constexpr std::size_t cells = 120;  // of the mesh that deforms the picture, along a side

[[noreturn]] void fail(const std::string& why) {
    std::fprintf(stderr, "judge: %s\n", why.c_str());
    std::exit(1);
}

// ---- the cage and its bend ----

/// The border of the square [-1, 1]², six edges a side.
std::vector<Vertex> square_cage() {
    constexpr int n = 6;
    std::vector<Vertex> cage;
    const std::array<Vertex, 5> corners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}}};
    for (std::size_t side = 0; side < 4; ++side) {
        for (int i = 0; i < n; ++i) {
            const double t = double(i) / n;
            cage.push_back({(1 - t) * corners[side][0] + t * corners[side + 1][0],
                            (1 - t) * corners[side][1] + t * corners[side + 1][1]});
        }
    }
    return cage;
}

/// Onto a ring of 52 degrees.
Vertex bent(const Vertex& p) {
    constexpr double radius = 2.2, scale = 0.92;
    const double angle = p[0] / radius;
    return {scale * (radius - p[1]) * std::sin(angle),
            scale * (radius - (radius - p[1]) * std::cos(angle)) - 0.15};
}

Vertex in_view(const ViewBox& view, const Vertex& p) {
    return {view.x + view.width * (0.5 + 0.5 * p[0]), view.y + view.height * (0.5 + 0.5 * p[1])};
}

std::vector<Vertex> cage_of(const ViewBox& view, bool bend) {
    std::vector<Vertex> cage = square_cage();
    for (Vertex& p : cage) p = in_view(view, bend ? bent(p) : p);
    return cage;
}

// ---- files ----

void write_cage(const std::string& path, const std::vector<Vertex>& cage) {
    std::ofstream file(path);
    file.precision(17);
    for (const Vertex& p : cage) file << p[0] << ',' << p[1] << '\n';
    if (!file.flush()) fail(path);
}

SvgDocument load(const std::string& path) {
    auto document = load_svg(path);
    if (!document) fail(to_string(document.error()));
    return std::move(*document);
}

ViewBox view_of(const SvgDocument& document) {
    const auto view = view_box(document);
    return view;
}

/// The document, showing this part of itself, in a picture of this many pixels.
void write_view(SvgDocument& document, const ViewBox& view, int width, const std::string& path) {
    pugi::xml_node root = detail::root_element(document.xml);
    const auto text = [](double v) { return format_number(v, 12); };
    detail::set_attribute(root, "viewBox",
                          text(view.x) + ' ' + text(view.y) + ' ' + text(view.width) + ' ' +
                              text(view.height));
    detail::set_attribute(root, "width", std::to_string(width));
    detail::set_attribute(root, "height", text(width * view.height / view.width));
    detail::set_attribute(root, "preserveAspectRatio", "none");
    std::ofstream file(path);
    file << to_text(document);
    if (!file.flush()) fail(path);
}

void prepare(const std::string& icon, const std::string& folder) {
    SvgDocument document = load(icon);
    const ViewBox view = view_of(document);
    write_view(document, view, rendered_width, folder + "/rest.svg");
    const ViewBox wide{view.x - margin * view.width, view.y - margin * view.height,
                       (1 + 2 * margin) * view.width, (1 + 2 * margin) * view.height};
    write_view(document, wide, wide_width, folder + "/wide.svg");
    write_cage(folder + "/cage.csv", cage_of(view, false));
    write_cage(folder + "/bend.csv", cage_of(view, true));
}

// ---- pictures ----

/// Four numbers a pixel, 0 to 255, colours multiplied by alpha.
struct Picture {
    std::size_t width = 0, height = 0;
    std::vector<float> pixels;

    float* at(std::size_t x, std::size_t y) { return &pixels[4 * (y * width + x)]; }
    const float* at(std::size_t x, std::size_t y) const { return &pixels[4 * (y * width + x)]; }
    static float over_white(const float* pixel, int channel) { return pixel[channel] + 255 - pixel[3]; }
};

Picture blank(std::size_t width, std::size_t height) {
    return {width, height, std::vector<float>(4 * width * height)};
}

Picture load_picture(const std::string& path) {
    int width = 0, height = 0, channels = 0;
    unsigned char* data = stbi_load(path.c_str(), &width, &height, &channels, 4);
    if (!data) fail(path + ": is no picture");
    Picture picture = blank(std::size_t(width), std::size_t(height));
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
        const float alpha = float(data[i + 3]);
        for (std::size_t k = 0; k < 3; ++k) picture.pixels[i + k] = float(data[i + k]) * alpha / 255;
        picture.pixels[i + 3] = alpha;
    }
    stbi_image_free(data);
    return picture;
}

void save_picture(const Picture& picture, const std::string& path) {
    std::vector<unsigned char> data;
    data.reserve(picture.width * picture.height * 3);
    for (std::size_t i = 0; i < picture.pixels.size(); i += 4) {
        for (int k = 0; k < 3; ++k) {
            const float value = Picture::over_white(&picture.pixels[i], k);
            data.push_back(static_cast<unsigned char>(std::clamp(value + 0.5F, 0.0F, 255.0F)));
        }
    }
    const int width = int(picture.width);
    if (!stbi_write_png(path.c_str(), width, int(picture.height), 3, data.data(), 3 * width)) fail(path);
}

double largest_difference(const Picture& a, const Picture& b) {
    if (a.width != b.width || a.height != b.height) return 255;
    double largest = 0;
    for (std::size_t i = 0; i < a.pixels.size(); i += 4) {
        for (int k = 0; k < 3; ++k) {
            const double d = Picture::over_white(&a.pixels[i], k) - Picture::over_white(&b.pixels[i], k);
            largest = cageform_tests::larger(largest, std::abs(d));
        }
    }
    return largest;
}

/// Bilinear, at a place in units of the picture's size.
void add_sample(const Picture& from, const Vertex& place, float* to) {
    const double u = place[0] * double(from.width) - 0.5, v = place[1] * double(from.height) - 0.5;
    const double left = std::floor(u), top = std::floor(v);
    for (int k = 0; k < 4; ++k) {
        const double x = left + (k & 1), y = top + (k >> 1);
        if (x < 0 || y < 0 || x >= double(from.width) || y >= double(from.height)) continue;
        const auto share = float((1 - std::abs(u - x)) * (1 - std::abs(v - y)));
        const float* pixel = from.at(std::size_t(x), std::size_t(y));
        for (int c = 0; c < 4; ++c) to[c] += share * pixel[c];
    }
}

/// Draws a triangle of a picture. Corners are in pixels, texture in sizes of the picture.
void draw(const std::array<Vertex, 3>& corner, const std::array<Vertex, 3>& texture, const Picture& from,
          Picture& to) {
    const auto& [a, b, c] = corner;
    const double area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if (std::abs(area) < 1e-12) return;
    const auto range = [&](std::size_t axis, std::size_t size) {
        const auto [least, most] = std::minmax({a[axis], b[axis], c[axis]});
        const double first = std::clamp(std::floor(least), 0.0, double(size));
        const double last = std::clamp(std::ceil(most), 0.0, double(size));
        return std::pair(std::size_t(first), std::size_t(last));
    };
    const auto [x0, x1] = range(0, to.width);
    const auto [y0, y1] = range(1, to.height);
    for (std::size_t y = y0; y < y1; ++y) {
        for (std::size_t x = x0; x < x1; ++x) {
            const double px = double(x) + 0.5, py = double(y) + 0.5;
            const double lb = ((px - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (py - a[1])) / area;
            const double lc = ((b[0] - a[0]) * (py - a[1]) - (px - a[0]) * (b[1] - a[1])) / area;
            const double la = 1 - lb - lc;
            if (la < -1e-9 || lb < -1e-9 || lc < -1e-9) continue;
            float* pixel = to.at(x, y);
            std::fill(pixel, pixel + 4, 0.0F); // an edge belongs to both of its triangles
            add_sample(from,
                       {la * texture[0][0] + lb * texture[1][0] + lc * texture[2][0],
                        la * texture[0][1] + lb * texture[1][1] + lc * texture[2][1]},
                       pixel);
        }
    }
}

/// Returns the bent picture with its margin, drawn at twice the size and then halved.
Picture bent_picture(const Picture& wide, const ViewBox& view, std::size_t width, std::size_t height) {
    std::vector<Vertex> places, textures;
    for (std::size_t j = 0; j <= cells; ++j) {
        for (std::size_t i = 0; i <= cells; ++i) {
            const Vertex at{double(i) / cells, double(j) / cells};
            textures.push_back(at);
            places.push_back({view.x + view.width * ((1 + 2 * margin) * at[0] - margin),
                              view.y + view.height * ((1 + 2 * margin) * at[1] - margin)});
        }
    }
    const cageform::MeanValueCoordinates<double, 2> coordinates(cage_of(view, false));
    const auto [binding, report] = cageform::bind(coordinates, places);
    std::vector<Vertex> moved(places.size());
    if (report.status != cageform::Status::ok ||
        clone(binding, cage_of(view, true), moved) != cageform::Status::ok) {
        fail("the picture cannot be bent");
    }
    constexpr std::size_t finer = 2;
    Picture fine = blank(finer * width, finer * height);
    for (Vertex& p : moved) {
        p = {(p[0] - view.x) / view.width * double(fine.width),
             (p[1] - view.y) / view.height * double(fine.height)};
    }
    for (std::size_t j = 0; j < cells; ++j) {
        for (std::size_t i = 0; i < cells; ++i) {
            const std::size_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
            draw({moved[a], moved[b], moved[d]}, {textures[a], textures[b], textures[d]}, wide, fine);
            draw({moved[a], moved[d], moved[c]}, {textures[a], textures[d], textures[c]}, wide, fine);
        }
    }
    Picture picture = blank(width, height);
    for (std::size_t y = 0; y < fine.height; ++y) {
        for (std::size_t x = 0; x < fine.width; ++x) {
            for (int k = 0; k < 4; ++k) {
                picture.at(x / finer, y / finer)[k] += fine.at(x, y)[k] / float(finer * finer);
            }
        }
    }
    return picture;
}

struct Difference {
    double mean = 0;   // over blocks where either has paint
    double strong = 0; // the share of these that differ by more than 32
};

Difference difference(const Picture& a, const Picture& b) {
    Difference result;
    double blocks = 0;
    for (std::size_t y = 0; y + 2 <= a.height; y += 2) {
        for (std::size_t x = 0; x + 2 <= a.width; x += 2) {
            std::array<double, 3> off{};
            double paint = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                const float* p = a.at(x + (k & 1), y + (k >> 1));
                const float* q = b.at(x + (k & 1), y + (k >> 1));
                paint = std::max({paint, double(p[3]), double(q[3])});
                for (int c = 0; c < 3; ++c) {
                    off[std::size_t(c)] += (Picture::over_white(p, c) - Picture::over_white(q, c)) / 4;
                }
            }
            if (paint < 2) continue;
            const double mean = (std::abs(off[0]) + std::abs(off[1]) + std::abs(off[2])) / 3;
            ++blocks;
            result.mean += mean;
            result.strong += mean > 32 ? 1 : 0;
        }
    }
    if (blocks > 0) result = {result.mean / blocks, result.strong / blocks};
    return result;
}

void compare(const std::string& folder) {
    const Picture rest = load_picture(folder + "/rest.png");
    const Picture bend = load_picture(folder + "/bend.png");
    const Picture expected = bent_picture(load_picture(folder + "/wide.png"),
                                          view_of(load(folder + "/rest.svg")), bend.width, bend.height);
    save_picture(expected, folder + "/expected.png");
    const Difference d = difference(expected, bend);
    std::printf("%.3f %.3f %.5f\n", largest_difference(rest, load_picture(folder + "/identity.png")), d.mean,
                d.strong);
}

void sheet(const std::string& path, const std::vector<std::string>& folders) {
    constexpr std::size_t tile = rendered_width + 4;
    Picture all = blank(3 * tile, tile * folders.size());
    for (std::size_t row = 0; row < folders.size(); ++row) {
        std::size_t column = 0;
        for (const char* name : {"/rest.png", "/expected.png", "/bend.png"}) {
            const Picture picture = load_picture(folders[row] + name);
            for (std::size_t y = 0; y < std::min(picture.height, tile); ++y) {
                std::copy_n(picture.at(0, y), 4 * std::min(picture.width, tile),
                            all.at(column * tile, row * tile + y));
            }
            ++column;
        }
    }
    save_picture(all, path);
}

} // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    const std::string what = words.empty() ? "" : words[0];
    if (what == "prepare" && words.size() == 3) {
        prepare(words[1], words[2]);
    } else if (what == "compare" && words.size() == 2) {
        compare(words[1]);
    } else if (what == "difference" && words.size() == 3) {
        const Picture a = load_picture(words[1]), b = load_picture(words[2]);
        const Difference d = difference(a, b);
        std::printf("%.0f %.3f %.5f\n", largest_difference(a, b), d.mean, d.strong);
    } else if (what == "sheet" && words.size() > 2) {
        sheet(words[1], {words.begin() + 2, words.end()});
    } else {
        fail("prepare ICON.svg FOLDER | compare FOLDER | difference A.png B.png | sheet OUT.png FOLDER…");
    }
}
