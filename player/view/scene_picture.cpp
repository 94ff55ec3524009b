#include "player/view/scene_picture.hpp"

#include <cstdint>

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
                           const glm::dvec3& centre, std::span<const FingerMark> fingers,
                           const MarkSizes& sizes, SurfacePainter& painter) {
    const int samples = samples_for(settings);
    const ViewCamera camera =
        make_view(settings.viewpoint, scene, centre, settings.width * samples, settings.height * samples);
    auto planes = painter.paint(surface, camera);
    if (!planes.ok()) return planes.error();
    LightPicture picture = on_background(std::move(*planes));
    draw_fingers(fingers, sizes, camera, picture);
    return developed(picture, samples);
}

}  // namespace touchable
