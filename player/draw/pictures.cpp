// SPDX-License-Identifier: Apache-2.0
#include "player/draw/pictures.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/base/try.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/light_picture.hpp"
#include "player/view/drawn_surface.hpp"

// Composes single pictures in linear light (make_picture); makes painters by name.

namespace touchable {
namespace {

// The sRGB curve, IEC 61966-2-1.
float light_of_share(float share) {
    return share <= 0.04045F ? share / 12.92F : std::pow((share + 0.055F) / 1.055F, 2.4F);
}
float share_of_light(float light) {
    return light <= 0.0031308F ? light * 12.92F : 1.055F * std::pow(light, 1.0F / 2.4F) - 0.055F;
}

const std::array<float, 256>& light_of_bytes() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> light;
        for (std::size_t k = 0; k < light.size(); ++k)
            light[k] = light_of_share(static_cast<float>(k) / 255.0F);
        return light;
    }();
    return table;
}

/// Fine enough that every byte equals the exact curve's.
constexpr std::size_t curve_steps = 1 << 14;
const std::vector<std::uint8_t>& bytes_of_light() {
    static const std::vector<std::uint8_t> table = [] {
        std::vector<std::uint8_t> bytes(curve_steps + 1);
        for (std::size_t k = 0; k <= curve_steps; ++k)
            bytes[k] = static_cast<std::uint8_t>(
                255.0F * share_of_light(static_cast<float>(k) / static_cast<float>(curve_steps)) + 0.5F);
        return bytes;
    }();
    return table;
}
std::uint8_t byte_of(float light) {
    const float step = std::clamp(light, 0.0F, 1.0F) * static_cast<float>(curve_steps);
    return bytes_of_light()[static_cast<std::size_t>(step + 0.5F)];
}

glm::vec3 background_light(int row, int height) {
    // Lighter than what recordings have in the dark, whose shapes would be lost before it.
    const glm::vec3 above = light_of(pack_colour(40, 44, 51)), below = light_of(pack_colour(56, 60, 68));
    const float share = static_cast<float>(row) / static_cast<float>(height);
    return glm::mix(above, below, share * share);
}

class CpuPainter final : public SurfacePainter {
public:
    std::string_view name() const override { return "cpu"; }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        const auto width = static_cast<std::size_t>(camera.width),
                   height = static_cast<std::size_t>(camera.height);
        PicturePlanes planes{camera.width, camera.height, std::vector<float>(width * height),
                             std::vector<PackedColour>(width * height)};
        const MappedLattice lattice{
            surface.q.data(), surface.colours.data(), surface.width, surface.height, 1, surface.fills_gaps};
        const std::vector<PackedColour> background(height);
        if (OwnViewPicture::draws(camera)) {
            own_view_.draw(lattice, camera, background, planes.colours, planes.z);
            return planes;
        }
        edges_.clear();
        if (!is_own_view(camera))
            edges_.find(edge_lattice(surface.q.data(), surface.width, surface.height, surface.width, 1,
                                     surface.focal_length));
        raster_.draw(lattice, edges_, camera, background, planes.colours, planes.z);
        return planes;
    }

private:
    SurfaceEdges edges_{CpuLattices::usual_threads()};  // of what is painted
    LatticeRaster raster_{CpuLattices::usual_threads()};
    OwnViewPicture own_view_;
};

using OpenGpu = std::function<Result<std::shared_ptr<GpuDevice>>()>;

Result<std::unique_ptr<SurfacePainter>> gpu_painter(std::string_view name, const OpenGpu& open_gpu) {
    TRY_ASSIGN(auto device, open_gpu());
    if (name == "auto") name = usual_painter(device->facts());
    if (name == "cpu") return make_cpu_painter();
    return name == "mesh" ? make_mesh_painter(std::move(device)) : make_raster_painter(std::move(device));
}

/// Samples per pixel along each side.
int samples_for(const SurfacePainter::Settings& settings) {
    constexpr std::int64_t most_pixels = 16'000'000;
    const std::int64_t pixels = std::int64_t{settings.width} * settings.height;
    return pixels * 9 <= most_pixels ? 3 : (pixels * 4 <= most_pixels ? 2 : 1);
}

}  // namespace

glm::vec3 light_of(PackedColour colour) {
    const auto& light = light_of_bytes();
    return {light[colour & 255U], light[colour >> 8 & 255U], light[colour >> 16 & 255U]};
}

glm::vec3 light_of_brightness(const glm::vec3& brightness) {
    const glm::vec3 share = glm::clamp(brightness, 0.0F, 1.0F);
    return {light_of_share(share.r), light_of_share(share.g), light_of_share(share.b)};
}

glm::vec3 brightness_of(const glm::vec3& light) {
    return {share_of_light(light.r), share_of_light(light.g), share_of_light(light.b)};
}

PackedColour background_colour(int row, int height) {
    const glm::vec3 light = background_light(row, height);
    return pack_colour(byte_of(light.r), byte_of(light.g), byte_of(light.b));
}

LightPicture on_background(PicturePlanes planes) {
    LightPicture picture{planes.width, planes.height, std::move(planes.z), {}};
    picture.light.resize(picture.z.size());
    for (int y = 0; y < picture.height; ++y) {
        const glm::vec3 background = background_light(y, picture.height);
        for (int x = 0; x < picture.width; ++x) {
            const std::size_t at = picture.index(x, y);
            picture.light[at] = planes.colours[at] >> 24 != 0 ? light_of(planes.colours[at]) : background;
        }
    }
    return picture;
}

Image developed(const LightPicture& picture, int samples) {
    Image image{picture.width / samples, picture.height / samples, 1, 3, {}};
    image.samples.reserve(3 * pixel_count(image.width, image.height));
    const float share = 1.0F / static_cast<float>(samples * samples);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            glm::vec3 sum(0.0F);
            for (int sy = 0; sy < samples; ++sy)
                for (int sx = 0; sx < samples; ++sx)
                    sum += glm::min(picture.light[picture.index(x * samples + sx, y * samples + sy)],
                                    glm::vec3(1.0F));
            for (int channel = 0; channel < 3; ++channel)
                image.samples.push_back(byte_of(sum[channel] * share));
        }
    return image;
}

std::unique_ptr<SurfacePainter> make_cpu_painter() {
    return std::make_unique<CpuPainter>();
}

Result<std::unique_ptr<SurfacePainter>> make_painter(std::string_view name, const OpenGpu& open_gpu) {
    if (name == "cpu") return make_cpu_painter();
    if (name != "auto" && name != "raster" && name != "mesh")
        return usage_error(
            "painter " + std::string(name) + " is not known; there are auto, cpu, raster and mesh",
            {{Setting::painter}});
    auto painter = gpu_painter(name, open_gpu);
    if (!painter && name == "auto") return make_cpu_painter();
    return painter;
}

Result<Image> make_picture(const SurfacePainter::Settings& settings, const Scene& scene,
                           const ViewSurface& surface, const Viewpoint::Subject& subject,
                           std::span<const FingerMark> fingers, const MarkSizes& sizes,
                           SurfacePainter& painter) {
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
