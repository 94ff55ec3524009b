#include "player/draw/pictures.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/base/try.hpp"
#include "engine/base/vectors.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/draw/cpu_painting.hpp"
#include "player/draw/drawn_surface.hpp"
#include "player/draw/gpu_painting.hpp"
#include "player/draw/legends.hpp"
#include "player/draw/light_picture.hpp"

// Composes pictures in linear light, single ones (make_picture) and sequences (CpuDrawing); makes painters by
// name.

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

    Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                                   Lighting lighting) override {
        return lattices_.surface_of(field, pair, colour, lighting);
    }

    Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) override {
        const auto width = static_cast<std::size_t>(camera.width),
                   height = static_cast<std::size_t>(camera.height);
        PicturePlanes planes{camera.width, camera.height, std::vector<float>(width * height),
                             std::vector<PackedColour>(width * height)};
        edges_.clear();
        if (!is_own_view(camera))
            edges_.find(edge_lattice(surface.q.data(), surface.width, surface.height, surface.width, 1,
                                     surface.focal_length));
        raster_.draw({surface.q.data(), surface.colours.data(), surface.width, surface.height, surface.width,
                      1, surface.fills_gaps},
                     edges_, camera, std::vector<PackedColour>(height), camera.width, planes.colours,
                     planes.z);
        return planes;
    }

private:
    CpuLattices lattices_{CpuLattices::usual_threads()};
    SurfaceEdges edges_{CpuLattices::usual_threads()};  // of what is painted
    LatticeRaster raster_{CpuLattices::usual_threads()};
};

using OpenGpu = std::function<Result<std::shared_ptr<GpuDevice>>()>;

Result<std::unique_ptr<SurfacePainter>> gpu_painter(std::string_view name, const OpenGpu& open_gpu) {
    TRY_ASSIGN(auto device, open_gpu());
    const GpuFacts& facts = device->facts();
    // Software Vulkan without 64-bit atomics is slower than the CPU painter.
    if (name == "mesh" || (name == "auto" && facts.kind != GpuKind::software && draws_by_mesh(facts)))
        return make_mesh_painter(std::move(device));
    return make_raster_painter(std::move(device));
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

void double_picture(std::span<const PackedColour> from, int width, int height, std::span<PackedColour> to) {
    const auto pixels = static_cast<std::size_t>(width);
    // Two channels of 16 bits in each value; of two rows, the outer pixels twice.
    constexpr std::uint32_t channels = 0x00ff00ff, half = 0x00080008;
    std::vector<std::uint32_t> reds(pixels + 2), greens(pixels + 2);
    const auto stretch = [&](auto) __attribute__((always_inline)) {
        const int count = width, last = height - 1;  // in registers, which lets the loops vectorise
        for (int y = 0; y <= 2 * last + 1; ++y) {
            const int beside = std::clamp(y / 2 + y % 2 * 2 - 1, 0, last);
            const PackedColour* const near = from.data() + pixels * static_cast<std::size_t>(y / 2);
            const PackedColour* const far = from.data() + pixels * static_cast<std::size_t>(beside);
            std::uint32_t* const red = reds.data() + 1;
            std::uint32_t* const green = greens.data() + 1;
            for (int x = 0; x < count; ++x) {
                red[x] = 3 * (near[x] & channels) + (far[x] & channels);
                green[x] = 3 * (near[x] >> 8 & channels) + (far[x] >> 8 & channels);
            }
            for (std::uint32_t* const sum : {red, green}) {
                sum[-1] = sum[0];
                sum[count] = sum[count - 1];
            }
            const auto between = [=](int x, int other) __attribute__((always_inline)) {
                const std::uint32_t r = 3 * red[x] + red[other] + half,
                                    g = 3 * green[x] + green[other] + half;
                return (r >> 4 & channels) | (g >> 4 & channels) << 8;
            };
            PackedColour* const out = to.data() + 2 * pixels * static_cast<std::size_t>(y);
            for (int x = 0; x < count; ++x) {
                out[2 * x] = between(x, x - 1);
                out[2 * x + 1] = between(x, x + 1);
            }
        }
    };
    run_vectors(usable_vector_units().front(), stretch);
}

struct CpuDrawing::Parts {
    CpuLattices lattices{CpuLattices::usual_threads()};
    std::unique_ptr<SurfacePainter> painter = make_cpu_painter();
    ViewSurface surface;
    Silhouettes silhouettes;
    LightPicture bare;                  // the surface on its background, without fingers
    std::optional<glm::dmat4> painted;  // clip_from_lattice of `bare`
    Image picture;
};

CpuDrawing::CpuDrawing() : parts_(std::make_unique<Parts>()) {}
CpuDrawing::~CpuDrawing() = default;

void CpuDrawing::show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                      Lighting lighting) {
    CpuLattices& lattices = parts_->lattices;
    ViewSurface& surface = parts_->surface;
    parts_->painted.reset();
    surface.width = field.width();
    surface.height = field.height();
    surface.focal_length = static_cast<float>(field.scene().camera.fx);
    surface.fills_gaps = fills_gaps(colour, lighting);
    lattices.q_of(field, pair, surface.q);
    surface.colours.resize(surface.q.size());
    lattices.light(field, surface.q.data(), surface.width, colour, lighting, surface.colours.data());
}

Result<const Image*> CpuDrawing::draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                                      const MarkSizes& sizes, int samples) {
    auto& [lattices, painter, surface, silhouettes, bare, painted, picture] = *parts_;
    if (painted != camera.clip_from_lattice || bare.width != camera.width || bare.height != camera.height) {
        TRY_ASSIGN(auto planes, painter->paint(surface, camera));
        if (!is_own_view(camera)) silhouettes.smooth(planes);
        bare = on_background(std::move(planes));
        painted = camera.clip_from_lattice;
    }
    LightPicture touched = bare;
    draw_fingers(fingers, sizes, camera, touched);
    picture = developed(touched, samples);
    return &picture;
}

}  // namespace touchable
