#pragma once

#include <string>
#include <vector>

#include "engine/mpeg4/clip_nodes.hpp"
#include "engine/scene/scene_description.hpp"

namespace touchable::mpeg4 {

/// What the nodes can say of a scene, without textures: the paper's camera, near and far plane, ranges.
ClipNodes nodes_from(const Scene& scene);
/// What they cannot, each as a person reads it: "frames at times of their own". Empty: they say all.
std::vector<std::string> unsaid_by_nodes(const Scene& scene);

/// A clip that nothing but nodes describes: depth as the paper has it, white near, along the ray (Eq. 3), of
/// so many bits, its rate left open. Lengths are millimetres.
Result<SceneDescription> described_by(const ClipNodes& nodes, int width, int height, int bits);
/// A scene of which the nodes say something else than `nodes_from` it, as they say it; false where they
/// agree, but for what four bytes round.
bool take_nodes(const ClipNodes& nodes, Scene& scene);

}  // namespace touchable::mpeg4
