#pragma once

// What an MPEG-4 scene says of a touchable clip, and its text (docs/codecs.md).
//
// The paper sends a clip as a scene of nodes: DepthImage with a camera, hapticSurface with ranges, textures
// for colour, depth, haptic and height pictures. Nodes are a tree (node_types.hpp) that has two forms: the
// text that people and GPAC write (parse_scene_text, scene_text), and BIFS, its bits (bifs.hpp).
// clip_nodes_of reads the nodes of one clip out of a tree and says by name which part of it is not
// understood; described_by turns these into a SceneDescription, and the functions beside it make nodes of a
// scene.
//
// Text and bits come from outside: depth of nesting, sizes and numbers are checked. Pure functions, for any
// thread.

#include <cstdint>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/mpeg4/node_types.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::mpeg4 {

/// Reads a scene's text (BT): prototypes, then one node. The paper's own nodes are known without a prototype.
/// Errors begin "line 3, column 5: ".
Result<SceneTree> parse_scene_text(std::string_view text);

/// The text of a scene: as MPEG-4 tools read it, two spaces deeper for each node.
std::string scene_text(const SceneTree& scene);

/// What the nodes of a touchable clip say (the paper's Fig. 9 to 12): one Shape whose geometry is a Depth,
/// with a HapticTextureSurface in its Appearance, as the paper has it, or in its Depth, as it is written
/// here; or MPEG-4's own DepthImage, which cannot be felt otherwise than everywhere alike.
struct ClipNodes {
    /// Where a plane's pictures are: an ImageTexture or a MovieTexture.
    struct Texture {
        Url url;
        bool is_movie = false;
        bool operator==(const Texture&) const = default;
    };
    /// The streams that a clip has beside depth's.
    struct Streams {
        bool colour = false, haptic = false, height = false;
    };

    /// Of the paper's camera: square pixels, in one unit of length; of a DepthImage: 0.
    double focal_length = 0, pixel_width = 0;
    /// Of a DepthImage: the angles of the whole picture, radians, across and down; otherwise 0.
    double angle_x = 0, angle_y = 0;
    double near = 0, far = 0;  ///< scene units
    Texture depth;
    std::optional<Texture> colour, haptic, height;
    HapticRanges ranges;    ///< stiffness in N/mm
    double max_height = 0;  ///< levels of depth
    /// A scene file's text, which says what nodes cannot, to touchable alone: `info` of a WorldInfo of this
    /// title.
    std::string scene_file;
    static constexpr const char* scene_file_title = "T3D_SCENE";
};

/// The one layout of nodes that is a touchable clip, as the paper wrote it or by prototypes of the paper's
/// names. An error names the node or field that is missing, or is there beside it.
Result<ClipNodes> clip_nodes_of(const SceneTree& scene);

/// The same by prototypes, so that every reader of MPEG-4 takes it: one that knows nothing of touch shows a
/// rectangle with the clip's colour. The Appearance is MPEG-4's own: GPAC takes whatever stands there for
/// one, and a prototype crashes it. So `hapticSurface` is a field of the prototype Depth. Prototypes have the
/// paper's initial values; all values are said. `width`, `height`: of the picture, pixels.
SceneTree scene_of(const ClipNodes& nodes, int width, int height);

/// The objects that our scenes name: the streams of colour, depth, haptic and height.
inline constexpr std::uint16_t colour_object = 10, depth_object = 11, haptic_object = 12, height_object = 13;

/// What the nodes can say of a scene: the paper's camera, near and far plane, ranges; and streams of depth
/// and of those planes that it has.
ClipNodes nodes_from(const Scene& scene, ClipNodes::Streams streams = {});
/// Where the textures are: tracks of 8 bits that change, or pictures of one moment, of 8 or 16 bits.
enum class Textures { tracks, pictures };
/// What they cannot, each as a person reads it: "frames at times of their own". Empty: they say all.
std::vector<std::string> unsaid_by_nodes(const Scene& scene, ClipNodes::Streams streams = {},
                                         Textures textures = Textures::tracks);

/// A clip that nothing but nodes describes: depth as the paper has it, white near, along the ray (Eq. 3), of
/// so many bits, its rate left open. Lengths are millimetres.
Result<SceneDescription> described_by(const ClipNodes& nodes, int width, int height, int bits);
/// The same scene by nodes of pictures, and what those cannot say of it, to the last bit, as a scene file's
/// text (ClipNodes::scene_file). Its name and rate are not needed: one frame is called as its file.
ClipNodes nodes_of_pictures(const SceneDescription& described);
/// A clip of pictures by such nodes: what their scene file says, but for what was changed in the nodes
/// since, which `notes` says; or without one what they say alone, of depth of so many bits. It names no
/// pictures.
Result<SceneDescription> described_by_pictures(const ClipNodes& nodes, int width, int height, int bits,
                                               std::vector<std::string>& notes);
/// A scene of which the nodes say something else than `nodes_from` it, as they say it; false where they
/// agree, but for what four bytes round. An error where a clip cannot be what they say.
Result<bool> take_nodes(const ClipNodes& nodes, Scene& scene);

}  // namespace touchable::mpeg4
