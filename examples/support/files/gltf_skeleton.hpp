#pragma once

// glTF 2.0: skins and skeletons of figures, and their animation.

#include "files/clip_file.hpp"
#include "files/gltf_figure.hpp"

#include <cageform/binding/skin_weights.hpp>
#include <cageform/exchange/gltf.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

namespace cageform_support {

/// Rounds weights to multiples of 2^-24, such that the weights of each point sum to exactly 1. An error of
/// the sum would move a point by that fraction of its distance from the origin.
void make_sums_exact(cageform::SkinWeights& skin);

/// Estimated rounding error of players that compute in single precision: four roundings of the largest
/// coordinate, in its units.
double single_precision_error(std::span<const Point3> places);

/// Number of sets of four joints with a nonzero weight.
std::size_t joint_sets(const cageform::SkinWeights& skin);

/// The skin as shown by players that read only the first set (four joints per vertex) and normalise its
/// weights.
cageform::SkinWeights first_set(const cageform::SkinWeights& skin);

/// Returns JOINTS_0, WEIGHTS_0, JOINTS_1, … with four joints per set. Sets without weights are omitted.
///
///   Index     std::uint8_t or std::uint16_t
///   weights   #points · influences: float, or normalised integers
template <class Index, class Weight>
GltfJson skin_attributes(GltfDocument& document, const GltfSurface& surface,
                         const cageform::SkinWeights& skin, std::span<const Weight> weights,
                         std::size_t still) {
    GltfJson attributes = GltfJson::object();
    constexpr bool integer = !std::is_same_v<Weight, float>;
    constexpr Weight one = integer ? std::numeric_limits<Weight>::max() : Weight(1);
    const std::size_t most = skin.influences, sets = joint_sets(skin);
    for (std::size_t set = 0; set < sets; ++set) {
        std::vector<std::array<Index, 4>> joints;
        std::vector<std::array<Weight, 4>> shares;
        for (const MeshCorner& corner : surface.corners) {
            auto& joint = joints.emplace_back();
            auto& share = shares.emplace_back();
            const std::size_t first = corner.vertex * most;
            for (std::size_t k = 0; k < 4 && 4 * set + k < most; ++k) {
                share[k] = weights[first + 4 * set + k];
                // 3.7.3.3: unused entries have joint 0, also after rounding.
                joint[k] = share[k] == 0 ? Index(0) : static_cast<Index>(skin.joints[first + 4 * set + k]);
            }
            if (set == 0 && weights[first] == 0) {
                joint[0] = static_cast<Index>(still);
                share[0] = one;
            }
        }
        const std::string number = std::to_string(set);
        attributes["JOINTS_" + number] = document.add(joints, GltfDocument::Use::vertices);
        attributes["WEIGHTS_" + number] = document.add(shares, GltfDocument::Use::vertices, false, integer);
    }
    return attributes;
}

/// "JOINTS_0 to JOINTS_3: many players read only JOINTS_0, four joints per vertex; ": a note on skins with
/// several sets.
std::string describe_sets(std::size_t sets);

/// A joint at rest, without rotation.
struct GltfJoint {
    static constexpr std::size_t no_parent = ~std::size_t{0};

    std::string name;
    Point3 place; // relative to an origin
    std::size_t parent = no_parent;
    /// Whether the joint has a second node, below its first one. This node has the weights and the children.
    bool has_axes = false;
};

/// The nodes of joints.
struct GltfJoints {
    GltfIndex root = 0;           // the parent of all joints without a parent
    Point3 origin;                // its translation
    std::vector<Point3> places;   // #joints: relative to the origin, in single precision
    std::vector<GltfIndex> nodes; // #joints
    std::vector<GltfIndex> axes;  // #joints: the node with the weights
};

/// Appends the nodes of joints below a new root node. Parents come before their children.
GltfJoints add_joints(GltfDocument& document, const std::string& root_name, const Point3& origin,
                      std::span<const GltfJoint> joints);

/// Adds a skin to all surfaces. Surfaces keep their positions. Transforms of nodes do not affect skinned
/// meshes (3.7.3.2). So the mesh of a node with a parent, children, a camera, extensions or animations of its
/// transform moves to a new root node.
///
///   skin      of the figure's vertices
///   weights   float, unorm8 or unorm16
///   still     joint of vertices without weights
void add_skin(GltfFigure& gltf, const GltfJoints& joints, const cageform::SkinWeights& skin,
              const std::string& weights, std::size_t still);

/// Appends the nodes of a skeleton, its skin and its animation.
///
///   name     of the parent node of all bones
///   origin   its translation: origin of the skeleton's positions
void add_skeleton(GltfFigure& gltf, const cageform::FittedSkeleton<double>& skeleton,
                  const cageform::SkeletonKeys<double>& keys, const std::string& weights,
                  const std::string& name, const Point3& origin);

/// A property of a node in a motion.
struct GltfTrackOfNode {
    GltfIndex node = 0;
    const char* path = "translation";
    std::vector<double> values; // of all keys of the clip
    std::size_t components = 3;
};

/// Appends an animation with one CUBICSPLINE sampler per track. Returns the status of the conversion.
cageform::Status add_clip(GltfDocument& document, const PoseClip& clip, const std::string& name,
                          std::span<const GltfTrackOfNode> tracks);

/// Converts curve_through() of several numbers to a CUBICSPLINE sampler, exactly up to single precision.
///
///   values    #keys · components: the numbers at the keys
///   returns   as to_gltf_cubicspline()
cageform::Result<cageform::GltfTrack, cageform::ExchangeReport>
gltf_track(const PoseClip& clip, std::span<const double> values, std::size_t components);

} // namespace cageform_support
