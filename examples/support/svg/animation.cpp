// Key frames of animated documents (AnimatedSvg).

#include "svg/document.hpp"
#include "svg/shapes.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

namespace cageform_support {

namespace {

using Numbers = std::vector<double>;

Numbers rounded(Numbers numbers, int decimals) {
    const double unit = std::pow(10.0, decimals);
    for (double& number : numbers) number = std::round(number * unit) / unit;
    return numbers;
}

/// Fewest decimals whose rounding error, times `sensitivity`, is at most a tenth of the tolerance.
int fewest_decimals(double sensitivity, double tolerance) {
    int enough = 0;
    while (enough < 15 && 5 * sensitivity > tolerance * std::pow(10.0, enough)) ++enough;
    return enough;
}

/// Easing between two key frames: a cubic Bézier curve from (0, 0) to (1, 1), time first, with the control
/// points (handle, first) and (1 - handle, second).
struct Ease {
    double handle = handles.front(), first = handle, second = 1 - handle;

    /// 1/3 gives any cubic in time; 0.42 is the ease-in-out of CSS.
    static constexpr std::array<double, 2> handles{1.0 / 3, 0.42};

    bool is_steady() const { return std::abs(first - handle) + std::abs(second - 1 + handle) < 1e-3; }

    /// The curve's parameter at a time, by Newton's method.
    static double parameter(double handle, double time) {
        double t = time;
        for (int n = 0; n < 8; ++n) {
            const double v = 1 - t, value = 3 * t * v * (v * handle + t * (1 - handle)) + t * t * t;
            t -= (value - time) / (3 * v * v * handle + 6 * t * v * (1 - 2 * handle) + 3 * t * t * handle);
        }
        return t;
    }

    double at(double time) const {
        const double t = parameter(handle, time), v = 1 - t;
        return 3 * t * v * (v * first + t * second) + t * t * t;
    }
};

/// The numbers of an attribute in every frame, and the key frames that reproduce them.
struct KeyFrames {
    /// Whether numbers are accurate enough in a frame.
    using Test = std::function<bool(std::size_t frame, const Numbers& numbers)>;

    std::vector<Numbers> exact;
    int decimals = 0; // of the numbers in key frames
    std::vector<std::size_t> kept{0};
    std::vector<Ease> eases; // #kept - 1

    /// Chooses key frames greedily: each step is the longest that passes the test.
    void choose(const Test& test) {
        kept = {0};
        eases.clear();
        while (kept.back() + 1 < exact.size()) {
            const std::size_t from = kept.back();
            std::size_t good = from + 1, bad = 0; // a step to the next frame always passes
            Ease best;
            const auto reaches = [&](std::size_t to) {
                const auto ease = step(from, to, test);
                if (ease) best = *ease;
                (ease ? good : bad) = to;
                return bool(ease);
            };
            reaches(next_turn(from)); // easing may fit the whole motion, but not a part
            for (bad = good + 1; bad < exact.size() && reaches(bad);) bad = good + (good - from);
            bad = std::min(bad, exact.size());
            while (good + 1 < bad) reaches(good + (bad - good) / 2);
            kept.push_back(good);
            eases.push_back(best);
        }
    }

    /// The interpolated numbers in a frame.
    Numbers played(std::size_t frame) const {
        const auto next = std::upper_bound(kept.begin() + 1, kept.end() - 1, frame);
        const std::size_t from = *(next - 1), to = *next;
        const Ease& ease = eases[std::size_t(next - kept.begin() - 1)];
        return between(rounded(exact[from], decimals), rounded(exact[to], decimals),
                       ease.at(double(frame - from) / double(to - from)));
    }

    /// Whether all key frames equal these numbers.
    bool are(const Numbers& numbers) const {
        return std::all_of(kept.begin(), kept.end(),
                           [&](std::size_t frame) { return rounded(exact[frame], decimals) == numbers; });
    }

    /// Returns keyTimes and keySplines.
    AnimationTiming timing() const {
        AnimationTiming timing;
        const double last = double(exact.size() - 1);
        const int digits = fewest_decimals(last, 0.01); // a thousandth of a frame
        if (kept.size() > 2) {
            for (const std::size_t frame : kept)
                timing.times += format_number(double(frame) / last, digits) + ';';
            timing.times.pop_back();
        }
        if (std::all_of(eases.begin(), eases.end(), [](const Ease& ease) { return ease.is_steady(); }))
            return timing;
        for (const Ease& ease : eases) {
            for (const double number : {ease.handle, ease.first, 1 - ease.handle, ease.second})
                timing.splines += format_number(ease.is_steady() ? 0.5 : number, 5) + ' ';
            timing.splines.back() = ';';
        }
        timing.splines.pop_back();
        return timing;
    }

    /// The attribute `values`: key frames formatted by `write`, separated by semicolons.
    std::string values(const std::function<std::string(std::size_t)>& write) const {
        std::string text;
        for (const std::size_t frame : kept) text += write(frame) + ';';
        text.pop_back();
        return text;
    }

private:
    /// The next frame at which the motion reverses, starts or stops; else the last frame.
    std::size_t next_turn(std::size_t frame) const {
        while (++frame + 1 < exact.size()) {
            double product = 0, before = 0, after = 0;
            for (std::size_t i = 0; i < exact[frame].size(); ++i) {
                const double a = exact[frame][i] - exact[frame - 1][i],
                             b = exact[frame + 1][i] - exact[frame][i];
                product += a * b;
                before += a * a;
                after += b * b;
            }
            if (product <= 0 && before + after > 0) break;
        }
        return frame;
    }

    static Numbers between(Numbers from, const Numbers& to, double share) {
        for (std::size_t i = 0; i < from.size(); ++i) from[i] += share * (to[i] - from[i]);
        return from;
    }

    /// Finds an easing between two frames that passes the test in all frames between. Its values are fitted
    /// by least squares, regularised towards linear time.
    std::optional<Ease> step(std::size_t from, std::size_t to, const Test& test) const {
        const Numbers a = rounded(exact[from], decimals), b = rounded(exact[to], decimals);
        double square = 0;
        for (std::size_t i = 0; i < a.size(); ++i) square += (b[i] - a[i]) * (b[i] - a[i]);
        const auto time = [&](std::size_t frame) { return double(frame - from) / double(to - from); };
        Numbers shares;
        for (std::size_t f = from + 1; f < to; ++f) {
            double share = 0;
            for (std::size_t i = 0; i < a.size(); ++i) share += (exact[f][i] - a[i]) * (b[i] - a[i]);
            shares.push_back(square > 0 ? share / square : time(f));
        }
        for (const double handle : Ease::handles) {
            constexpr double ridge = 1e-9;
            double xx = ridge, xy = 0, yy = ridge, x = ridge * handle, y = ridge * (1 - handle);
            for (std::size_t f = from + 1; f < to; ++f) {
                const double t = Ease::parameter(handle, time(f)), v = 1 - t, p = 3 * t * v * v,
                             q = 3 * t * t * v;
                const double rest = shares[f - from - 1] - t * t * t;
                xx += p * p;
                xy += p * q;
                yy += q * q;
                x += p * rest;
                y += q * rest;
            }
            const double determinant = xx * yy - xy * xy;
            const auto height = [](double h) { return std::round(std::clamp(h, 0.0, 1.0) * 1e5) / 1e5; };
            const Ease ease{handle, height((x * yy - y * xy) / determinant),
                            height((y * xx - x * xy) / determinant)};
            bool good = true;
            for (std::size_t f = from + 1; f < to && good; ++f)
                good = test(f, between(a, b, ease.at(time(f))));
            if (good) return ease;
        }
        return std::nullopt;
    }
};

/// A matrix animation as a product of animated translation, rotation, skew and scale, since SVG cannot
/// animate a matrix. All but the translation are about `centre`.
class AnimatedTransform {
public:
    enum Part { shift, turn, skew, scale };
    static constexpr std::array<const char*, 4> types{"translate", "rotate", "skewX", "scale"};

    std::array<KeyFrames, 4> parts;
    Point2 centre;

    /// Chooses key frames such that every point stays within the tolerance of its exact position.
    AnimatedTransform(const AnimatedSvg::Track& track, double tolerance) {
        std::vector<Affine2> maps = track.maps;
        maps.push_back(maps.front()); // the animation repeats
        Point2 low = track.places.front(), high = low;
        for (const Point2& p : track.places) {
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
        const bool only_shifts = std::all_of(maps.begin(), maps.end(), [](const Affine2& m) {
            return std::abs(m.a - 1) + std::abs(m.b) + std::abs(m.c) + std::abs(m.d - 1) < 1e-9;
        });
        const double reach = std::hypot(high.x - low.x, high.y - low.y) / 2;
        double largest = 0;
        for (const Affine2& m : maps) largest = std::max(largest, detail::largest_scale(m));
        if (!only_shifts) {
            const int decimals = fewest_decimals(1, reach);
            const Numbers middle = rounded({(low.x + high.x) / 2, (low.y + high.y) / 2}, decimals);
            centre = {middle[0], middle[1]};
        }
        for (const Affine2& m : maps) add(m);

        const double lever = track.scale * reach, per_turn = lever * largest * per_degree;
        const std::array<double, 4> sensitivities{track.scale, per_turn, per_turn, lever};
        const auto is_within_tolerance = [&](std::size_t frame, const Affine2& played, double most) {
            return std::all_of(track.places.begin(), track.places.end(), [&](const Point2& place) {
                const Point2 p = apply(played, place), q = apply(maps[frame], place);
                return track.scale * std::hypot(p.x - q.x, p.y - q.y) <= most;
            });
        };
        const auto is_right_everywhere = [&] {
            for (std::size_t f = 0; f < maps.size(); ++f) {
                const Affine2 played = product({parts[shift].played(f), parts[turn].played(f),
                                                parts[skew].played(f), parts[scale].played(f)});
                if (!is_within_tolerance(f, played, tolerance)) return false;
            }
            return true;
        };
        double each = tolerance;
        do {
            each /= 2;
            for (std::size_t k = 0; k < parts.size(); ++k) {
                parts[k].decimals = fewest_decimals(sensitivities[k], each);
                parts[k].choose([&](std::size_t frame, const Numbers& numbers) {
                    std::array<Numbers, 4> all{parts[shift].exact[frame], parts[turn].exact[frame],
                                               parts[skew].exact[frame], parts[scale].exact[frame]};
                    all[k] = numbers;
                    return is_within_tolerance(frame, product(all), each);
                });
            }
        } while (each > 1e-6 * tolerance && !is_right_everywhere());
    }

private:
    void add(const Affine2& m) {
        const Point2 there = apply(m, centre);
        const double before = parts[turn].exact.empty() ? 0 : parts[turn].exact.back()[0] * per_degree;
        double angle = std::atan2(m.b, m.a);
        angle += 2 * std::numbers::pi *
                 std::round((before - angle) / (2 * std::numbers::pi)); // nearest to the last angle
        const double along = m.c * std::cos(angle) + m.d * std::sin(angle);
        const double across = -m.c * std::sin(angle) + m.d * std::cos(angle);
        parts[shift].exact.push_back({there.x, there.y});
        parts[turn].exact.push_back({angle / per_degree});
        parts[skew].exact.push_back({std::atan(along / across) / per_degree});
        parts[scale].exact.push_back({std::hypot(m.a, m.b), across});
    }

    Affine2 product(const std::array<Numbers, 4>& numbers) const {
        const double angle = numbers[turn][0] * per_degree, c = std::cos(angle), s = std::sin(angle);
        const double tangent = std::tan(numbers[skew][0] * per_degree);
        const Affine2 about{numbers[scale][0], 0, numbers[scale][1] * tangent, numbers[scale][1], 0, 0};
        const Affine2 moved = compose({c, s, -s, c, numbers[shift][0], numbers[shift][1]}, about);
        return compose(moved, {1, 0, 0, 1, -centre.x, -centre.y});
    }

    static constexpr double per_degree = std::numbers::pi / 180;
};

Numbers numbers_of(const Path& path) {
    Numbers numbers;
    const auto put = [&](const Point2& p) { numbers.insert(numbers.end(), {p.x, p.y}); };
    for (const Subpath& subpath : path) {
        put(subpath.start);
        for (const Segment& s : subpath.segments) {
            if (!s.is_line()) put(s.p1), put(s.p2);
            put(s.p3);
        }
    }
    return numbers;
}

/// Adds animation elements for tracks.
class Player {
public:
    ///   animations   out: added elements are appended
    Player(double seconds, double tolerance, std::vector<pugi::xml_node>& animations)
        : seconds_(seconds)
        , tolerance_(tolerance)
        , animations_(animations) {}

    std::size_t keys = 0;

    void play(const AnimatedSvg::Track& track) {
        if (!track.maps.empty()) return play_maps(track);
        KeyFrames frames;
        frames.decimals = fewest_decimals(track.scale, tolerance_);
        const std::size_t count = std::max(track.paths.size(), track.numbers.size());
        for (std::size_t f = 0; f <= count; ++f) { // the animation repeats
            frames.exact.push_back(track.paths.empty() ? Numbers{track.numbers[f % count]}
                                                       : numbers_of(track.paths[f % count]));
        }
        const std::size_t axes = track.paths.empty() ? 1 : 2;
        frames.choose([&](std::size_t frame, const Numbers& numbers) {
            for (std::size_t i = 0; i < numbers.size(); i += axes) {
                double square = 0;
                for (std::size_t k = i; k < i + axes; ++k)
                    square += (numbers[k] - frames.exact[frame][k]) * (numbers[k] - frames.exact[frame][k]);
                if (!(track.scale * std::sqrt(square) <= tolerance_)) return false;
            }
            return true;
        });
        const auto write = [&](std::size_t f) {
            return track.paths.empty() ? format_number(track.numbers[f % count], frames.decimals)
                                       : write_short_path_data(track.paths[f % count], frames.decimals);
        };
        detail::set_attribute(track.node, track.attribute.c_str(), write(0));
        add(track, "", frames, frames.values(write));
    }

private:
    void play_maps(const AnimatedSvg::Track& track) {
        const AnimatedTransform transform(track, tolerance_);
        for (std::size_t k = 0; k < transform.parts.size(); ++k) {
            const KeyFrames& part = transform.parts[k];
            if (k != 0 && part.are(k == AnimatedTransform::scale ? Numbers{1, 1} : Numbers{0})) continue;
            const auto write = [&](std::size_t f) {
                const Numbers& numbers = part.exact[f];
                const std::string first = format_number(numbers[0], part.decimals);
                return numbers.size() == 1 ? first : first + ' ' + format_number(numbers[1], part.decimals);
            };
            add(track, AnimatedTransform::types[k], part, part.values(write));
        }
        const auto& [x, y] = transform.centre;
        if (x == 0 && y == 0) return;
        append(track, "translate", format_number(-x, 15) + ' ' + format_number(-y, 15), {.adds = true});
    }

    void add(const AnimatedSvg::Track& track, const std::string& type, const KeyFrames& frames,
             const std::string& values) {
        keys += frames.kept.size();
        AnimationTiming timing = frames.timing();
        timing.adds = !type.empty() && type != "translate";
        append(track, type, values, timing);
    }

    void append(const AnimatedSvg::Track& track, const std::string& type, const std::string& values,
                const AnimationTiming& timing) {
        animations_.push_back(
            AnimatedSvg::append_animation(track.node, track.attribute, type, seconds_, values, timing));
    }

    double seconds_, tolerance_;
    std::vector<pugi::xml_node>& animations_;
};

} // namespace

void AnimatedSvg::show(std::size_t frame) {
    for (const Track& track : tracks) {
        detail::set_attribute(track.node, track.attribute.c_str(),
                              !track.maps.empty()    ? detail::write_transform(track.maps[frame])
                              : !track.paths.empty() ? write_path_data(track.paths[frame], track.decimals)
                                                     : format_number(track.numbers[frame], track.decimals));
    }
}

pugi::xml_node AnimatedSvg::append_animation(pugi::xml_node node, const std::string& attribute,
                                             const std::string& type, double seconds,
                                             const std::string& values, const AnimationTiming& timing) {
    const pugi::xml_node root = detail::root_element(node.root());
    const std::string element = detail::name_prefix(root) + (type.empty() ? "animate" : "animateTransform");
    const bool is_pattern =
        detail::local_name(node) == "pattern"; // a pattern with a child would not inherit its content
    pugi::xml_node animation = is_pattern ? node.parent().insert_child_before(element.c_str(), node)
                                          : node.append_child(element.c_str());
    const auto put = [&](const std::string& name, const std::string& text) {
        if (!text.empty()) animation.append_attribute(name.c_str()) = text.c_str();
    };
    if (is_pattern) put(detail::reference_name(root), std::string("#") + node.attribute("id").value());
    put("attributeName", attribute);
    put("type", type);
    put("additive", timing.adds ? "sum" : "");
    put("dur", format_number(seconds, 6) + 's');
    put("repeatCount", "indefinite");
    put("calcMode", timing.splines.empty() ? "" : "spline");
    put("keyTimes", timing.times);
    put("keySplines", timing.splines);
    put("values", values);
    return animation;
}

std::size_t AnimatedSvg::play(double seconds, double tolerance) {
    for (pugi::xml_node animation : animations_) animation.parent().remove_child(animation);
    animations_.clear();
    Player player(seconds, tolerance, animations_);
    for (const Track& track : tracks) player.play(track);
    return player.keys;
}

} // namespace cageform_support
