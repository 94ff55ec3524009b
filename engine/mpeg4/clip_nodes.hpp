#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/mpeg4/scene_tree.hpp"
#include "engine/scene/scene.hpp"

namespace touchable::mpeg4 {

/// Where a plane's pictures are: an ImageTexture or a MovieTexture.
struct PlaneTexture {
    Url url;
    bool is_movie = false;
    bool operator==(const PlaneTexture&) const = default;
};

/// What the nodes of a touchable clip say (the paper's Fig. 9 to 12): one Shape whose geometry is a Depth,
/// with a HapticTextureSurface in its Appearance, as the paper has it, or in its Depth, as it is written
/// here; or MPEG-4's own DepthImage, which cannot be felt otherwise than everywhere alike.
struct ClipNodes {
    /// Of the paper's camera: square pixels, in one unit of length; of a DepthImage: 0.
    double focal_length = 0, pixel_width = 0;
    /// Of a DepthImage: the angles of the whole picture, radians, across and down; otherwise 0.
    double angle_x = 0, angle_y = 0;
    double near = 0, far = 0;  ///< scene units
    PlaneTexture depth;
    std::optional<PlaneTexture> colour, haptic, height;
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

}  // namespace touchable::mpeg4
