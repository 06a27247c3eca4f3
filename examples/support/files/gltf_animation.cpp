#include "files/gltf_animation.hpp"

#include "io/csv.hpp"

#include <cmath>

namespace cageform_support {

Expected<GltfAnimation> GltfAnimation::read(const GltfScene& scene, GltfIndex index,
                                            const std::string& name) {
    GltfAnimation animation(scene);
    const std::string user = "animation " + std::to_string(index);
    try {
        const GltfJson& json = scene.document.object("animations", index, "the document");
        if (!json.contains("channels") || !json["channels"].is_array() || !json.contains("samplers") ||
            !json["samplers"].is_array())
            throw GltfFault(user + ": has no list of channels and samplers");
        for (std::size_t c = 0; c < json["channels"].size(); ++c)
            animation.read_channel(json, c, user + ", channel " + std::to_string(c));
    } catch (const GltfFault& fault) {
        return FileError{name + ": " + fault.what()};
    } catch (const GltfJson::exception&) {
        return FileError{name + ": " + user + ": a property has a wrong type"};
    }
    return animation;
}

void GltfAnimation::read_channel(const GltfJson& animation, std::size_t index, const std::string& user) {
    const GltfJson& json = animation["channels"][index];
    if (!json.is_object() || !json.contains("target") || !json["target"].is_object())
        throw GltfFault(user + ": has no target");
    const GltfJson& target = json["target"];
    if (!target.contains("node")) return; // 3.11: defined by an extension
    Channel channel;
    channel.node = target["node"].get<GltfIndex>();
    (void)scene_->document.object("nodes", channel.node, user);
    const std::string path = target.value("path", "");
    constexpr std::pair<std::string_view, std::pair<Property, std::size_t>> paths[] = {
        {"translation", {Property::translation, 3}},
        {"rotation", {Property::rotation, 4}},
        {"scale", {Property::scale, 3}},
        {"weights", {Property::weights, 0}}};
    const auto known = std::find_if(std::begin(paths), std::end(paths),
                                    [&](const auto& entry) { return entry.first == path; });
    if (known == std::end(paths))
        throw GltfFault(user + ": the path " + detail::quoted(path) +
                        " is none of translation, rotation, scale and weights");
    channel.property = known->second.first;
    channel.components = known->second.second;
    if (channel.property == Property::weights) {
        for (const GltfVertices& run : scene_->runs)
            channel.components = run.node == channel.node ? run.targets.size() : channel.components;
        if (channel.components == 0) return; // outside the scene
    } else if (scene_->nodes[channel.node].rest.matrix) {
        throw GltfFault(user + ": " + scene_->nodes[channel.node].name +
                        " has a matrix, which animations cannot change");
    }
    const std::size_t sampler = json.value("sampler", gltf_none);
    if (sampler >= animation["samplers"].size() || !animation["samplers"][sampler].is_object())
        throw GltfFault(user + ": there is no such sampler; the animation has " +
                        std::to_string(animation["samplers"].size()));
    read_keys(animation["samplers"][sampler], user + ", sampler " + std::to_string(sampler), channel);
    length_ = std::max(length_, channel.times.back());
    channels_.push_back(std::move(channel));
}

void GltfAnimation::read_keys(const GltfJson& sampler, const std::string& user, Channel& channel) const {
    const std::string interpolation = sampler.value("interpolation", "LINEAR");
    if (interpolation != "LINEAR" && interpolation != "STEP" && interpolation != "CUBICSPLINE")
        throw GltfFault(user + ": the interpolation " + detail::quoted(interpolation) +
                        " is none of LINEAR, STEP and CUBICSPLINE");
    channel.interpolation = interpolation == "LINEAR" ? Interpolation::linear
                            : interpolation == "STEP" ? Interpolation::step
                                                      : Interpolation::cubic;
    const GltfDocument& document = scene_->document;
    channel.times = document.numbers(sampler.value("input", gltf_none), {"SCALAR"}, user + ", input").numbers;
    double before = -1;
    for (const double time : channel.times) {
        if (!std::isfinite(time) || !(time >= 0) || !(time > before))
            throw GltfFault(user + ": its times do not ascend from 0 or later");
        before = time;
    }
    const char* type = channel.property == Property::weights    ? "SCALAR"
                       : channel.property == Property::rotation ? "VEC4"
                                                                : "VEC3";
    channel.values = document.numbers(sampler.value("output", gltf_none), {type}, user + ", output").numbers;
    const std::size_t expected =
        channel.times.size() * channel.components * (channel.interpolation == Interpolation::cubic ? 3 : 1);
    if (channel.times.empty() || channel.values.size() != expected)
        throw GltfFault(user + ": has " + std::to_string(channel.times.size()) + " times and " +
                        std::to_string(channel.values.size()) + " numbers, but " + std::to_string(expected) +
                        " are needed");
    for (const double value : channel.values) {
        if (!std::isfinite(value)) throw GltfFault(user + ": a value is not finite");
    }
}

namespace {

/// Spherical interpolation of unit quaternions by the shorter way (appendix C).
void interpolate_rotation(std::span<const double> a, std::span<const double> b, double t,
                          std::vector<double>& result) {
    double along = 0;
    for (std::size_t c = 0; c < 4; ++c) along += a[c] * b[c];
    const double angle = std::acos(std::min(std::fabs(along), 1.0)), sine = std::sin(angle);
    const double of_a = sine > 1e-9 ? std::sin((1 - t) * angle) / sine : 1 - t,
                 of_b = sine > 1e-9 ? std::sin(t * angle) / sine : t;
    for (std::size_t c = 0; c < 4; ++c) result[c] = of_a * a[c] + std::copysign(of_b, along) * b[c];
}

} // namespace

std::vector<double> GltfAnimation::Channel::at(double seconds) const {
    const std::size_t parts = interpolation == Interpolation::cubic ? 3 : 1;
    const auto value = [&](std::size_t key, std::size_t part) {
        return std::span(values).subspan((parts * key + part) * components, components);
    };
    const auto next = std::upper_bound(times.begin(), times.end(), seconds);
    const auto b = std::size_t(next - times.begin()), a = b == 0 ? 0 : b - 1;
    const auto own = value(a, parts / 2);
    std::vector<double> result(own.begin(), own.end());
    if (b == 0 || b == times.size() || interpolation == Interpolation::step) return result;
    const double length = times[b] - times[a], t = (seconds - times[a]) / length;
    if (interpolation == Interpolation::linear && property == Property::rotation) {
        interpolate_rotation(own, value(b, 0), t, result);
    } else if (interpolation == Interpolation::linear) {
        for (std::size_t c = 0; c < components; ++c) result[c] = (1 - t) * own[c] + t * value(b, 0)[c];
    } else { // appendix C
        const double t2 = t * t, t3 = t2 * t;
        for (std::size_t c = 0; c < components; ++c)
            result[c] = (2 * t3 - 3 * t2 + 1) * own[c] + length * (t3 - 2 * t2 + t) * value(a, 2)[c] +
                        (3 * t2 - 2 * t3) * value(b, 1)[c] + length * (t3 - t2) * value(b, 0)[c];
    }
    return result;
}

GltfPose GltfAnimation::pose_at(double seconds) const {
    GltfPose pose = scene_->rest_pose();
    for (const Channel& channel : channels_) {
        const std::vector<double> value = channel.at(seconds);
        GltfTransform& node = pose.nodes[channel.node];
        switch (channel.property) {
        case Property::translation: node.translation = {value[0], value[1], value[2]}; break;
        case Property::scale: node.scale = {value[0], value[1], value[2]}; break;
        case Property::rotation: {
            const double length = std::hypot(std::hypot(value[0], value[1]), std::hypot(value[2], value[3]));
            for (std::size_t k = 0; k < 4 && length > 0; ++k) node.rotation[k] = value[k] / length;
            break;
        }
        case Property::weights:
            for (std::size_t r = 0; r < scene_->runs.size(); ++r) {
                if (scene_->runs[r].node == channel.node) pose.weights[r] = value;
            }
        }
    }
    return pose;
}

Expected<GltfIndex> find_animation(const GltfScene& scene, const std::string& given,
                                   const std::string& name) {
    try {
        const GltfJson& list = scene.document.array("animations");
        if (list.empty()) return FileError{name + ": has no animations"};
        if (given.empty()) return GltfIndex{0};
        for (GltfIndex a = 0; a < list.size(); ++a) {
            if (scene.document.object("animations", a, "the document").value("name", GltfJson()) == given)
                return a;
        }
        double number = 0;
        if (detail::parse_number(given, number).empty() && number >= 0 && number < double(list.size()) &&
            number == std::floor(number))
            return GltfIndex(number);
        std::string names;
        for (GltfIndex a = 0; a < list.size(); ++a) {
            const GltfJson own = list[a].value("name", GltfJson());
            names += (a == 0 ? "" : ", ") +
                     (own.is_string() ? detail::quoted(own.get<std::string>()) : std::to_string(a));
        }
        return FileError{name + ": has no animation " + detail::quoted(given) + "; it has " + names};
    } catch (const GltfFault& fault) {
        return FileError{name + ": " + fault.what()};
    }
}

} // namespace cageform_support
