#pragma once

#include <span>

#include "engine/picture/image_file.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/surface_painter.hpp"

namespace touchable {

/// A picture as asked for.
struct PictureSettings {
    Viewpoint viewpoint;
    int width = 1280, height = 720;  ///< pixels, 1 to 8192
};

/// The surface and the fingers on it, from anywhere, smooth at edges: painted two or three times as large (as
/// memory allows) and averaged in light. An orbit goes round the middle of `subject`, and shows all of it
/// unless the viewpoint has a zoom. Where there are fingers, and the picture is large enough, a legend
/// explains them.
Result<Image> make_picture(const PictureSettings& settings, const Scene& scene, const ViewSurface& surface,
                           const Subject& subject, std::span<const FingerMark> fingers,
                           const MarkSizes& sizes, SurfacePainter& painter);

}  // namespace touchable
