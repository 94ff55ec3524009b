#include "engine/formats/azure_kinect_calibration.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Node;

/// What a mode keeps of a sensor's picture, once it is scaled to `whole`.
struct SensorMode {
    PictureSize picture, whole;
    int cut_x, cut_y;  ///< pixels of `whole` at the left and above
};
constexpr SensorMode depth_modes[] = {{{640, 576}, {1024, 1024}, 192, 180},  // NFOV_UNBINNED
                                      {{320, 288}, {512, 512}, 96, 90},      // NFOV_2X2BINNED
                                      {{1024, 1024}, {1024, 1024}, 0, 0},    // WFOV_UNBINNED
                                      {{512, 512}, {512, 512}, 0, 0}};       // WFOV_2X2BINNED
constexpr SensorMode colour_modes[] = {
    {{1280, 720}, {1280, 960}, 0, 120},   {{1920, 1080}, {1920, 1440}, 0, 180},
    {{2560, 1440}, {2560, 1920}, 0, 240}, {{2048, 1536}, {2048, 1536}, 0, 0},
    {{3840, 2160}, {3840, 2880}, 0, 360}, {{4096, 3072}, {4096, 3072}, 0, 0}};

template <std::size_t n>
const SensorMode* mode_of(const SensorMode (&modes)[n], PictureSize size) {
    const auto* const found = std::find_if(std::begin(modes), std::end(modes), [&](const SensorMode& mode) {
        return mode.picture.width == size.width && mode.picture.height == size.height;
    });
    return found == std::end(modes) ? nullptr : found;
}

struct LensCamera {
    Camera camera;
    LensDistortion lens;
    CameraPose pose;  ///< from the recording's reference, metres
};

/// Centre and focal lengths are shares of the sensor's picture, whose corner is at 0, and not at -0.5.
LensCamera read_lens_camera(const Node& node, const SensorMode& mode) {
    const std::vector<Node> terms = node["Intrinsics"]["ModelParameters"].elements(
        14, 32, "cx, cy, fx, fy, k1 ... k6, codx, cody, p2, p1");
    const auto term = [&](std::size_t k) { return terms[k].number(); };
    LensCamera read;
    read.camera = {term(2) * mode.whole.width, term(3) * mode.whole.height,
                   term(0) * mode.whole.width - mode.cut_x - 0.5,
                   term(1) * mode.whole.height - mode.cut_y - 0.5};
    read.lens.terms = {term(4), term(5), term(13), term(12), term(6), term(7), term(8), term(9)};
    const auto rotation = node["Rt"]["Rotation"].elements(9, 9, "nine numbers");
    const auto translation = node["Rt"]["Translation"].elements(3, 3, "three numbers");
    for (std::size_t k = 0; k < 9; ++k) read.pose.rotation[k] = rotation[k].number();
    for (std::size_t k = 0; k < 3; ++k) read.pose.translation[k] = translation[k].number();
    return read;
}

std::optional<Node> camera_of(const std::vector<Node>& cameras, const std::string& purpose) {
    for (const Node& camera : cameras)
        if (camera["Purpose"].text() == "CALIBRATION_CameraPurpose" + purpose) return camera;
    return {};
}

Result<K4aCameras> read_cameras(const Node& root, PictureSize depth_size,
                                const std::optional<PictureSize>& colour_size, const std::string& where) {
    const Node information =
        root[root.has("CalibrationInformation") ? "CalibrationInformation" : "CameraInfo"];
    const std::vector<Node> cameras = information["Cameras"].elements(1, 16, "an array of cameras");
    const auto depth = camera_of(cameras, "Depth");
    const SensorMode* const depth_mode = mode_of(depth_modes, depth_size);
    if (!depth || depth_mode == nullptr)
        return input_error(where + ": says nothing of depth of " + std::to_string(depth_size.width) + "x" +
                           std::to_string(depth_size.height));
    const LensCamera of_depth = read_lens_camera(*depth, *depth_mode);
    K4aCameras read{of_depth.camera, of_depth.lens, {}};
    const auto colour = camera_of(cameras, "PhotoVideo");
    const SensorMode* const colour_mode = colour_size ? mode_of(colour_modes, *colour_size) : nullptr;
    if (!colour || colour_mode == nullptr) return read;
    const LensCamera of_colour = read_lens_camera(*colour, *colour_mode);
    read.colour = ColourCamera{of_colour.camera, colour_size->width, colour_size->height, of_colour.lens,
                               of_colour.pose.after(of_depth.pose.inverse())};
    return read;
}

}  // namespace

Result<K4aCameras> parse_azure_kinect_calibration(std::string_view text, PictureSize depth,
                                                  const std::optional<PictureSize>& colour,
                                                  const std::string& where) {
    while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
    try {
        const checked_json::Json json = checked_json::parse(text);
        return read_cameras(Node(json, ""), depth, colour, where);
    } catch (const checked_json::Refusal& reason) {
        return input_error(where + ": " + reason.message);
    } catch (const checked_json::Json::exception& fault) {
        return input_error(where + ": " + fault.what());
    }
}

}  // namespace touchable
