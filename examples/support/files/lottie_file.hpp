#pragma once

// The animated numbers of Lottie files: a curve per interval between keyframes.

#include "io/csv.hpp"

#include <cageform/exchange/lottie.hpp>

#include <nlohmann/json.hpp>

#include <stdexcept>
#include <string>
#include <vector>

namespace cageform_support {

/// The curve between consecutive keyframes, for one component of a property.
struct LottieCurve {
    std::string path; ///< "layers/0/ks/r/k/2:0": the keyframe in the file and, after the colon, the component
    std::string layer; ///< names of the enclosing layers
    cageform::Result<cageform::KeyInterval> curve;
};

namespace detail {

/// A number, or a component of an array. The element of an array of length 1 applies to all components.
inline double lottie_number(const nlohmann::ordered_json& json, std::size_t component) {
    if (!json.is_array()) return json.get<double>();
    return json.at(json.size() == 1 ? 0 : component).get<double>();
}

inline cageform::LottieHandle lottie_handle(const nlohmann::ordered_json& key, const char* name,
                                            std::size_t component, cageform::LottieHandle otherwise) {
    const auto handle = key.find(name);
    if (handle == key.end()) return otherwise;
    return {lottie_number(handle->at("x"), component), lottie_number(handle->at("y"), component)};
}

/// Whether a position moves along a curve in space, that is, one of its tangents is not zero. Easing then
/// applies to the arc length.
inline bool moves_along_a_path(const nlohmann::ordered_json& key) {
    for (const char* const tangent : {"to", "ti"}) {
        if (!key.contains(tangent)) continue;
        for (const auto& x : key.at(tangent)) {
            if (x.get<double>() != 0) return true;
        }
    }
    return false;
}

/// Appends the intervals of an array of keyframes; throws nlohmann's exceptions if it is invalid.
inline void add_lottie_intervals(const nlohmann::ordered_json& keys, const std::string& path,
                                 const std::string& layer, std::vector<LottieCurve>& curves) {
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        const auto &key = keys[i], &next = keys[i + 1];
        // Files of versions before 5.0 store the end value of an interval in its first keyframe.
        const auto& end = key.contains("e") ? key.at("e") : next.at("s");
        const auto& begin = key.at("s");
        if (begin.is_array() && (begin.empty() || !begin[0].is_number()))
            return; // keyframes of shapes or of gradients
        const bool path_in_space = moves_along_a_path(key);
        const std::size_t components = path_in_space || !begin.is_array() ? 1 : begin.size();
        for (std::size_t c = 0; c < components; ++c) {
            const cageform::LottieEasing easing{lottie_handle(key, "o", c, {0, 0}),
                                                lottie_handle(key, "i", c, {1, 1}),
                                                key.contains("h") && key.at("h") == 1};
            const double from = path_in_space ? 0 : lottie_number(begin, c);
            const double to = path_in_space ? 1 : easing.hold ? from : lottie_number(end, c);
            curves.push_back(
                {path + "/" + std::to_string(i) + ":" + (path_in_space ? "path" : std::to_string(c)), layer,
                 cageform::from_lottie(easing, {key.at("t").get<double>(), from},
                                       {next.at("t").get<double>(), to})});
        }
    }
}

inline void add_lottie_curves(const nlohmann::ordered_json& json, const std::string& path, std::string layer,
                              std::vector<LottieCurve>& curves, int depth = 0) {
    constexpr int deepest = 200; // common files have a few dozen levels
    if (!json.is_structured()) return;
    if (depth > deepest) throw std::length_error("nested too deeply");
    if (json.is_object() && json.contains("nm") && json.at("nm").is_string())
        layer += (layer.empty() ? "" : ", ") + json.at("nm").get<std::string>();
    const auto keys = json.is_object() ? json.find("k") : json.end();
    if (keys != json.end() && keys->is_array() && !keys->empty() && keys->front().is_object() &&
        keys->front().contains("t")) {
        add_lottie_intervals(*keys, path + "/k", layer, curves);
        return;
    }
    const std::string parent = path.empty() ? "" : path + "/";
    for (const auto& [name, part] : json.items())
        add_lottie_curves(part, parent + name, layer, curves, depth + 1);
}

} // namespace detail

/// The curves of all animated numbers, in file order. Throws nlohmann's exceptions on an invalid keyframe,
/// std::length_error if the JSON is nested deeper than 200 levels.
inline std::vector<LottieCurve> lottie_curves(const nlohmann::ordered_json& file) {
    std::vector<LottieCurve> curves;
    detail::add_lottie_curves(file, "", "", curves);
    return curves;
}

/// "layers/0/ks/r/k/0:0  frames 0 to 30, 0 to 90  (ball)".
inline std::string describe(const LottieCurve& one) {
    const auto& p = one.curve.value.curve.points;
    std::string text = one.path + "  ";
    if (!one.curve)
        text += cageform::to_string(one.curve.status());
    else
        text += "frames " + detail::short_number(p[0][0]) + " to " + detail::short_number(p[3][0]) +
                (one.curve.value.kind == cageform::KeyKind::hold
                     ? ", held at " + detail::short_number(p[0][1])
                     : ", " + detail::short_number(p[0][1]) + " to " + detail::short_number(p[3][1]));
    return text + (one.layer.empty() ? "" : "  (" + one.layer + ")");
}

} // namespace cageform_support
