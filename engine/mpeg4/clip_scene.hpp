#pragma once

#include <string>
#include <vector>

#include "engine/mpeg4/clip_nodes.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable::mpeg4 {

/// The objects that our scenes name: the streams of colour, depth, haptic and height.
inline constexpr std::uint16_t colour_object = 10, depth_object = 11, haptic_object = 12, height_object = 13;

/// What the nodes can say of a scene: the paper's camera, near and far plane, ranges; and streams of depth
/// and of those planes that it has.
struct StreamsBeside {
    bool colour = false, haptic = false, height = false;
};
ClipNodes nodes_from(const Scene& scene, StreamsBeside streams = {});
/// Where the textures are: tracks of 8 bits that change, or pictures of one moment, of 8 or 16 bits.
enum class Textures { tracks, pictures };
/// What they cannot, each as a person reads it: "frames at times of their own". Empty: they say all.
std::vector<std::string> unsaid_by_nodes(const Scene& scene, StreamsBeside streams = {},
                                         Textures textures = Textures::tracks);

/// A clip that nothing but nodes describes: depth as the paper has it, white near, along the ray (Eq. 3), of
/// so many bits, its rate left open. Lengths are millimetres.
Result<SceneDescription> described_by(const ClipNodes& nodes, int width, int height, int bits);
/// The same scene by nodes of pictures, and what those cannot say of it, to the last bit, as a scene file's
/// text (ClipNodes::scene_file). Its name and rate are not needed: one frame is called as its file.
ClipNodes nodes_of_pictures(const SceneDescription& described);
/// A clip of pictures by such nodes: what their scene file says, but for what somebody has changed in the
/// nodes since, which `notes` says; or without one what they say alone, of depth of so many bits. It names no
/// pictures.
Result<SceneDescription> described_by_pictures(const ClipNodes& nodes, int width, int height, int bits,
                                               std::vector<std::string>& notes);
/// A scene of which the nodes say something else than `nodes_from` it, as they say it; false where they
/// agree, but for what four bytes round. An error where a clip cannot be what they say.
Result<bool> take_nodes(const ClipNodes& nodes, Scene& scene);

}  // namespace touchable::mpeg4
