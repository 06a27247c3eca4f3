#pragma once

// Animations of glTF 2.0 documents.

#include "files/gltf_scene.hpp"

namespace cageform_support {

/// An animation of a scene, which must outlive this object.
class GltfAnimation {
public:
    /// Reads an animation. Channels of extensions, such as KHR_animation_pointer, are skipped.
    ///
    ///   name    of the file, prefix of messages
    ///   fails   if the document has no such animation, or if it is invalid
    static Expected<GltfAnimation> read(const GltfScene& scene, GltfIndex animation, const std::string& name);

    /// Whether the animation moves a node or morph target of the scene.
    bool moves() const { return !channels_.empty(); }
    /// The time of the last key, in seconds.
    double length() const { return length_; }

    /// The pose of the scene at a time in seconds (3.11). Before the first key and after the last, a property
    /// has the value of that key.
    GltfPose pose_at(double seconds) const;

private:
    enum class Property : std::uint8_t { translation, rotation, scale, weights };
    enum class Interpolation : std::uint8_t { step, linear, cubic };
    struct Channel {
        GltfIndex node = 0;
        Property property{};
        Interpolation interpolation{};
        std::vector<double> times, values; // of all keys; cubic: in-tangent, value, out-tangent
        std::size_t components = 0;        // of a value

        std::vector<double> at(double seconds) const;
    };

    explicit GltfAnimation(const GltfScene& scene)
        : scene_(&scene) {}
    void read_channel(const GltfJson& animation, std::size_t index, const std::string& user);
    void read_keys(const GltfJson& sampler, const std::string& user, Channel& channel) const;

    const GltfScene* scene_;
    std::vector<Channel> channels_;
    double length_ = 0;
};

/// The index of an animation by its name, or else by its number from 0.
///
///   given   empty: the first animation
///   name    of the file, prefix of messages
///   fails   if there is none
Expected<GltfIndex> find_animation(const GltfScene& scene, const std::string& given, const std::string& name);

} // namespace cageform_support
