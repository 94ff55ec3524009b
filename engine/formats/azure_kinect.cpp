// SPDX-License-Identifier: Apache-2.0
// Recordings of an Azure Kinect: their calibration, and the scene made of it. The pictures are read as those
// of any video.

#include "engine/formats/formats_read.hpp"

#include <optional>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/formats/video_picture.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

using checked_json::Node;

/// The part that a mode keeps of a sensor's picture, which is scaled to `whole` first.
struct SensorMode {
    PictureSize picture, whole;
    int cut_x, cut_y;  ///< pixels of `whole` cut off at the left and above
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
    for (const SensorMode& mode : modes)
        if (mode.picture.width == size.width && mode.picture.height == size.height) return &mode;
    return nullptr;
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
        return input_error(where + ": says nothing of depth of " +
                           size_text(depth_size.width, depth_size.height));
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

constexpr const char* calibration_file = "calibration.json";

/// The picture size of the track with this name.
std::optional<PictureSize> size_of_track(const Demuxer& file, const std::string& name) {
    for (const auto& [stream, title] : file.tagged_pictures("title"))
        if (title == name) return PictureSize{stream->codecpar->width, stream->codecpar->height};
    return {};
}

Result<StoredImage> first_depth(VideoFile& video) {
    RgbConverter converter;
    TRY_ASSIGN(auto picture, picture_at(video, 0, converter));
    TRY_ASSIGN(const auto plane, picture.depth(VideoValues::grey, {0, 0, picture.width(), picture.height()}));
    if (plane.view.bytes_per_sample != 2)
        return input_error(video.where(0) + ": is no depth of 16 bits, as this camera records it");
    StoredImage stored;
    stored.bits = 16;
    stored.image = packed_image(plane.view);
    return stored;
}

}  // namespace

bool is_k4a_recording(const Candidate& file) {
    if (!file.begin.starts_with(matroska_magic)) return false;
    const auto opened = Demuxer::open_matroska(file.source);
    return opened && ((*opened)->tag("K4A_DEPTH_MODE") || (*opened)->attachment(calibration_file)) &&
           size_of_track(**opened, "DEPTH");
}

Result<GuessedScene> guess_k4a(const SourceFile& file, const SourceDescription& known) {
    TRY_ASSIGN(const auto demuxer, Demuxer::open_matroska(file));
    const auto depth_size = size_of_track(*demuxer, "DEPTH"), colour_size = size_of_track(*demuxer, "COLOR");
    if (!depth_size) return input_error(file.string() + ": has no track DEPTH");
    TRY_ASSIGN(auto video, VideoFile::open(file, PlaneRole::depth));
    TRY_ASSIGN(const auto first, first_depth(*video));
    SourceDescription said = known;
    constexpr double millimetre = 0.001;
    if (!said.metres_per_code && said.preset.empty()) said.metres_per_code = millimetre;
    std::optional<K4aCameras> cameras;
    std::vector<Remark> remarks;
    const bool is_told = said.intrinsics || said.fov;
    if (const auto text = demuxer->attachment(calibration_file); text && !is_told) {
        TRY_ASSIGN(cameras, parse_azure_kinect_calibration(*text, *depth_size, colour_size,
                                                           file.string() + ": its " + calibration_file));
        const Camera& camera = cameras->depth;
        if (!(camera.fx > 0) || !(camera.fy > 0))
            return input_error(file.string() + ": its " + calibration_file +
                               ": the depth camera's focal lengths must be above 0");
        said.intrinsics = Intrinsics{camera.fx, camera.fy, camera.cx, camera.cy};
        add_remark(remarks, {"the cameras are those of the recording's calibration.json"});
    }
    TRY_ASSIGN(auto guessed, guess_scene(file.path(), first, said));
    Scene& scene = guessed.scene;
    scene.rate = video->rate();
    scene.video.emplace().depth = file.path().filename().string();
    if (colour_size) scene.video->colour = scene.video->depth;
    if (cameras) {
        scene.lens = cameras->depth_lens;
        scene.colour_camera = cameras->colour;
    }
    if (colour_size && !scene.colour_camera)
        add_remark(remarks,
                   {"colour is not brought onto depth's pixels, as nothing says how its camera stands"});
    TRY(error_at(file.string() + ": its " + calibration_file, validate(scene)));
    scene.remarks = joined_remarks(std::move(remarks), scene.remarks);
    guessed.video = std::move(video);
    return guessed;
}

Result<K4aCameras> parse_azure_kinect_calibration(std::string_view text, PictureSize depth,
                                                  const std::optional<PictureSize>& colour,
                                                  const std::string& where) {
    while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
    TRY_ASSIGN(auto cameras,
               checked_json::read_checked(text, checked_json::largest_text, where, [&](const Node& node) {
                   return read_cameras(node, depth, colour, where);
               }));
    return cameras;
}

}  // namespace touchable
