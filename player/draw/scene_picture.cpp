#include "player/draw/scene_picture.hpp"

#include <cstdint>
#include <glm/geometric.hpp>

#include "engine/base/try.hpp"
#include "player/draw/legend.hpp"

namespace touchable {
namespace {

/// Pixels of a side per pixel of the picture.
int samples_for(const PictureSettings& settings) {
    constexpr std::int64_t most_pixels = 16'000'000;
    const std::int64_t pixels = std::int64_t{settings.width} * settings.height;
    return pixels * 9 <= most_pixels ? 3 : (pixels * 4 <= most_pixels ? 2 : 1);
}

}  // namespace

Result<Image> make_picture(const PictureSettings& settings, const Scene& scene, const ViewSurface& surface,
                           const Subject& subject, std::span<const FingerMark> fingers,
                           const MarkSizes& sizes, SurfacePainter& painter) {
    const int samples = samples_for(settings);
    Viewpoint viewpoint = settings.viewpoint;
    if (!viewpoint.zoom && !viewpoint.own)
        viewpoint.zoom =
            whole_zoom(viewpoint, scene, subject.middle, subject.points, settings.width, settings.height);
    const ViewCamera camera =
        make_view(viewpoint, scene, subject.middle, settings.width * samples, settings.height * samples);
    TRY_ASSIGN(auto planes, painter.paint(surface, camera));
    LightPicture picture = on_background(std::move(planes));
    draw_fingers(fingers, sizes, camera, picture);
    Image image = developed(picture, samples);
    if (fingers.empty()) return image;
    const double pixels = camera.focal / samples / glm::length(subject.middle - camera.eye);
    TRY(draw_legend({fingers.size(), sizes.length_per_newton * pixels}, image));
    return image;
}

}  // namespace touchable
