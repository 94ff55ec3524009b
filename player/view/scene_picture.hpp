#pragma once

#include <span>

#include "engine/media/image_file.hpp"
#include "player/view/finger_marks.hpp"
#include "player/view/surface_painter.hpp"

namespace touchable {

/// A picture as asked for.
struct PictureSettings {
    Viewpoint viewpoint;
    int width = 1280, height = 720;  ///< pixels, 1 to 8192
};

/// The surface and the fingers on it, from anywhere, smooth at edges: painted two or three times as large (as
/// memory allows) and averaged in light. `centre`: what an orbit goes round, world.
Result<Image> make_picture(const PictureSettings& settings, const Scene& scene, const ViewSurface& surface,
                           const glm::dvec3& centre, std::span<const FingerMark> fingers,
                           const MarkSizes& sizes, SurfacePainter& painter);

}  // namespace touchable
