// SPDX-License-Identifier: Apache-2.0
#pragma once

// The MPEG-4 scene of a touchable clip, and its text (docs/codecs.md).
//
// The paper sends a clip as a scene of nodes: DepthImage with a camera, hapticSurface with ranges, textures
// for colour, depth, haptic and height pictures. Nodes are a tree (node_types.hpp) that has two forms: the
// text that people and GPAC write (parse_scene_text, scene_text), and BIFS, its bits (bifs.hpp).
// clip_nodes_of reads the nodes of one clip from a tree and names the part that it does not understand;
// described_by turns these into a SceneDescription, and the functions beside it turn a scene into nodes.
//
// Text and bits come from outside: depth of nesting, sizes and numbers are checked.
// Threads: any; pure functions.

#include <cstdint>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/mpeg4/node_types.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::mpeg4 {

/// Reads a scene's text (BT): prototypes, then one node. The paper's own nodes are known without a prototype.
/// Errors begin "line 3, column 5: ".
Result<SceneTree> parse_scene_text(std::string_view text);

/// The text of a scene, as MPEG-4 tools read it, indented by two spaces for each node.
std::string scene_text(const SceneTree& scene);

/// The nodes of a touchable clip (the paper's Fig. 9 to 12): one Shape whose geometry is a Depth, with a
/// HapticTextureSurface in its Appearance, as in the paper, or in its Depth, as written here; or MPEG-4's own
/// DepthImage, which feels the same everywhere.
struct ClipNodes {
    /// Where a plane's pictures are: an ImageTexture or a MovieTexture.
    struct Texture {
        Url url;
        bool is_movie = false;
        bool operator==(const Texture&) const = default;
    };
    /// The streams of a clip besides depth.
    struct Streams {
        bool colour = false, haptic = false, height = false;
    };

    /// The paper's camera: square pixels, both in one unit of length; 0 for a DepthImage.
    double focal_length = 0, pixel_width = 0;
    /// A DepthImage's camera: the angles of the whole picture, radians, across and down; otherwise 0.
    double angle_x = 0, angle_y = 0;
    double near = 0, far = 0;  ///< scene units
    Texture depth;
    std::optional<Texture> colour, haptic, height;
    HapticRanges ranges;    ///< stiffness in N/mm
    double max_height = 0;  ///< levels of depth
    /// A scene file's text with what nodes cannot express, for touchable alone: `info` of a WorldInfo with
    /// this title.
    std::string scene_file;
    static constexpr const char* scene_file_title = "T3D_SCENE";
};

/// Reads the one layout of nodes that is a touchable clip, as the paper wrote it or by prototypes of the
/// paper's names. An error names the node or field that is missing or unexpected.
Result<ClipNodes> clip_nodes_of(const SceneTree& scene);

/// The same by prototypes, so that every reader of MPEG-4 accepts it: one without touch shows a rectangle
/// with the clip's colour. The Appearance is MPEG-4's own: GPAC takes any node there for one, and a prototype
/// crashes it. So `hapticSurface` is a field of the prototype Depth. The root is an OrderedGroup: of a Group,
/// GPAC's player with OpenGL shows an empty outline. Prototypes have the paper's initial values; all values
/// are stated. `width`, `height`: of the picture, pixels.
SceneTree scene_of(const ClipNodes& nodes, int width, int height);

/// Object descriptors in scenes written here: the streams of colour, depth, haptic and height.
inline constexpr std::uint16_t colour_object = 10, depth_object = 11, haptic_object = 12, height_object = 13;

/// The nodes of a scene: the paper's camera, near and far plane, ranges; and the streams of depth and of the
/// other planes that it has.
ClipNodes nodes_from(const Scene& scene, ClipNodes::Streams streams = {});
/// The form of textures: tracks of 8 bits that change, or pictures of one moment, of 8 or 16 bits.
enum class Textures { tracks, pictures };
/// Lists what nodes cannot express, for a person: "frames at times of their own". Empty: nothing.
std::vector<std::string> unsaid_by_nodes(const Scene& scene, ClipNodes::Streams streams = {},
                                         Textures textures = Textures::tracks);

/// Describes a clip by nodes alone: depth as in the paper, white near, along the ray (Eq. 3), of so many
/// bits, the rate left open. Lengths are millimetres.
Result<SceneDescription> described_by(const ClipNodes& nodes, int width, int height, int bits);
/// Turns a scene of pictures into nodes; what these cannot express to the last bit is a scene file's text
/// (ClipNodes::scene_file). Name and rate are left out: a single frame is named after its file.
ClipNodes nodes_of_pictures(const SceneDescription& described);
/// Describes a clip of pictures by such nodes: by their scene file, except for values that were changed in
/// the nodes since, which a note says; without a scene file by the nodes alone, with depth of so many bits.
/// It names no pictures.
Result<SceneDescription> described_by_pictures(const ClipNodes& nodes, int width, int height, int bits,
                                               std::vector<std::string>& notes);
/// Changes a scene to what the nodes state; returns false, and changes nothing, if that agrees with
/// `nodes_from` it, within the rounding of four bytes. An error if the nodes' camera is impossible.
Result<bool> take_nodes(const ClipNodes& nodes, Scene& scene);

}  // namespace touchable::mpeg4
