// Cameras: colour pictures as drivers deliver them, and the cameras of frames.
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/camera/v4l2_camera.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/pinhole_frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

struct PixelFormat {
    std::uint32_t code;
    std::ptrdiff_t bytes;  ///< of a pixel, or of its luma
};
constexpr std::array<PixelFormat, 7> pixel_formats{{{V4L2_PIX_FMT_RGB24, 3},
                                                    {V4L2_PIX_FMT_BGR24, 3},
                                                    {V4L2_PIX_FMT_YUYV, 2},
                                                    {V4L2_PIX_FMT_UYVY, 2},
                                                    {V4L2_PIX_FMT_NV12, 1},
                                                    {V4L2_PIX_FMT_MJPEG, 0},
                                                    {V4L2_PIX_FMT_JPEG, 0}}};

/// A kind of pixels, width, height, bytes at a row's end, and a picture: as many bytes as a driver has to
/// give of one, and the few behind them that the program adds.
bool parse_camera_colour(std::string_view bytes) {
    Taken taken(bytes);
    const PixelFormat pixels = pixel_formats[taken.byte() % pixel_formats.size()];
    StreamFormat format;
    format.code = pixels.code;
    format.width = static_cast<int>(taken.byte()) + 1;
    format.height = static_cast<int>(taken.byte()) + 1;
    format.stride = pixels.bytes * format.width + static_cast<std::ptrdiff_t>(taken.byte());
    const bool is_coded = pixels.bytes == 0;
    const std::ptrdiff_t rows =
        pixels.code == V4L2_PIX_FMT_NV12 ? format.height + (format.height + 1) / 2 : format.height;
    format.least =
        is_coded ? 1 : static_cast<std::size_t>(format.stride * (rows - 1) + pixels.bytes * format.width);
    const std::string_view stored = taken.rest();
    if (stored.empty()) return false;
    constexpr std::size_t behind = 64;
    TakenPicture picture;
    picture.bytes =
        std::make_shared<std::vector<std::uint8_t>>((is_coded ? stored.size() : format.least) + behind);
    for (std::size_t k = 0; k + behind < picture.bytes->size(); ++k)
        (*picture.bytes)[k] = static_cast<std::uint8_t>(stored[k % stored.size()]);
    ColourConverter converter;
    const auto plane = converter.rgb(picture, format);
    require(is_coded || plane, "a whole picture is refused");
    if (!is_taken(plane)) return false;
    require(plane->view.channels == 3 && plane->view.bytes_per_sample == 1, "is not RGB of 8 bits");
    require(is_coded || (plane->view.width == format.width && plane->view.height == format.height),
            "a picture has another size than it had");
    (void)plane->view.sample(plane->view.width - 1, plane->view.height - 1, 2);
    return true;
}

/// A camera's file for each frame, with a line of '%' between.
bool parse_frame_cameras(std::string_view bytes) {
    constexpr std::size_t most_frames = 4;
    constexpr int width = 64, height = 48;
    std::vector<std::filesystem::path> files;
    for (std::string_view rest = bytes; files.size() < most_frames;) {
        const std::size_t end = rest.find("\n%\n");
        files.push_back(file_of(rest.substr(0, end), "camera" + std::to_string(files.size()) + ".txt"));
        if (end == std::string_view::npos) break;
        rest.remove_prefix(end + 3);
    }
    PictureFiles named;
    named.files = files;
    const auto cameras = read_frame_cameras(named, width, height);
    if (!is_taken(cameras)) return false;
    require(cameras->size() == files.size(), "not a camera for each frame");
    const Camera middle = median_camera(*cameras);
    for (const Camera& camera : *cameras) {
        require(camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.fx) && std::isfinite(camera.fy),
                "a focal length cannot be");
        require(std::isfinite(camera.cx) && std::isfinite(camera.cy), "a principal point is not finite");
        const PixelShift shift = shift_between(middle, camera, width, height);
        require(!std::isnan(shift.length()), "nobody knows how far a camera shows a ray from another");
    }
    return true;
}

/// A scene of two cameras, small; its pictures have what its own bytes give.
bool parse_colour_registration(std::string_view bytes) {
    constexpr int most_side = 96;
    const auto described = parse_scene(bytes, "scene.json");
    if (!is_taken(described) || !described->scene.colour_camera || described->unstated.far) return false;
    const Scene* const scene = &described->scene;
    const ColourCamera& beside = *scene->colour_camera;
    if (std::max({scene->width, scene->height, beside.width, beside.height}) > most_side) return false;
    std::uint32_t state = 1;
    auto next = [&state, bytes, at = std::size_t{0}]() mutable {
        state = state * 1664525U + 1013904223U + static_cast<unsigned char>(bytes[at++ % bytes.size()]);
        return state >> 16U;
    };
    Image depth{scene->width, scene->height, scene->depth_bits > 8 ? 2 : 1, 1, {}};
    depth.samples.resize(static_cast<std::size_t>(depth.width * depth.height * depth.bytes_per_sample));
    for (int k = 0; k < depth.width * depth.height; ++k) {
        const unsigned code = next() % (unsigned{scene->depth.code_max} + 1);
        const auto at = static_cast<std::size_t>(k * depth.bytes_per_sample);
        depth.samples[at] = static_cast<std::uint8_t>(code);
        if (depth.bytes_per_sample == 2) depth.samples[at + 1] = static_cast<std::uint8_t>(code >> 8U);
    }
    Image colour{beside.width, beside.height, 1, 3, {}};
    colour.samples.resize(static_cast<std::size_t>(colour.width * colour.height * 3));
    for (std::uint8_t& sample : colour.samples) sample = static_cast<std::uint8_t>(next());
    if (scene->depth.kind == DepthCodingKind::hue) return false;  // three samples a pixel
    ColourRegistration registration(*scene);
    const Image registered = registration.registered(depth.view(), colour.view());
    require(registered.width == scene->width && registered.height == scene->height &&
                registered.channels == 3 &&
                registered.samples.size() == static_cast<std::size_t>(scene->width * scene->height * 3),
            "colour has not depth's pixels");
    require(registration.unseen_share() >= 0 && registration.unseen_share() <= 1, "a share is none");
    return true;
}

const Registered camera_colour_target{
    {.name = "camera_colour", .parse = parse_camera_colour, .most_bytes = 1024, .most_live_mebibytes = 512}};
const Registered frame_cameras_target{{.name = "frame_cameras", .parse = parse_frame_cameras}};
const Registered colour_registration_target{
    {.name = "colour_registration", .parse = parse_colour_registration, .most_bytes = 2048}};

}  // namespace
}  // namespace touchable::fuzz
