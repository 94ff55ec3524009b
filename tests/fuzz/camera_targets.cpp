// SPDX-License-Identifier: Apache-2.0
// Cameras: colour pictures as drivers deliver them, and the cameras of frames.

#include <linux/videodev2.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "engine/camera/frameset_camera.hpp"
#include "engine/camera/v4l2_camera.hpp"
#include "engine/clip/containers.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/pinhole_frames.hpp"
#include "engine/formats/ros_messages.hpp"
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
    RgbConverter converter;
    const auto plane = rgb_of(picture, format, converter);
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
        require(!std::isnan(shift.length()), "the distance of two cameras' rays is no number");
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

// Recordings of cameras in files of their own makers.

bool is_recording(const std::filesystem::path& file) {
    const auto guessed = guess_bag(file, {});
    return is_taken(guessed) && is_clip(open_bag_clip({file, {}, *guessed}));
}

bool parse_bag(std::string_view bytes) {
    return is_recording(file_of(bytes, "input.bag"));
}

bool parse_mcap(std::string_view bytes) {
    return is_recording(file_of(bytes, "input.mcap"));
}

bool parse_db3(std::string_view bytes) {
    return is_recording(file_of(bytes, "input.db3"));
}

/// A byte says how many pixels there are.
bool parse_rvl(std::string_view bytes) {
    Taken taken(bytes);
    const std::size_t pixels = taken.byte();
    const auto depth = unpack_rvl(taken.rest(), pixels);
    if (depth) require(depth->size() == pixels, "there are more or fewer pixels than were asked for");
    return depth.has_value();
}

/// An Azure Kinect's file as a whole: as it is, and with a camera that is known, which its own gives way to.
bool parse_k4a(std::string_view bytes) {
    const auto file = file_of(bytes, "kinect.mkv");
    const bool taken = is_clip(open_clip(file));
    SourceDescription known;
    known.fov = 75;
    return is_clip(open_clip(file, std::nullopt, known)) || taken;
}

void require_camera(const Camera& camera) {
    require(std::isfinite(camera.cx) && std::isfinite(camera.cy), "a principal point is not finite");
    require(std::isfinite(camera.fx) && std::isfinite(camera.fy), "a focal length is not finite");
}

bool parse_calibration(std::string_view bytes) {
    const auto cameras =
        parse_azure_kinect_calibration(bytes, {640, 576}, PictureSize{1280, 720}, "calibration.json");
    if (!is_taken(cameras)) return false;
    require_camera(cameras->depth);
    if (cameras->colour) require_camera(cameras->colour->camera);
    return true;
}

/// Times survive a round trip through text.
bool parse_times(std::string_view bytes) {
    const auto rate = parse_frame_times(bytes, "timestamps.txt");
    if (!is_taken(rate)) return false;
    require(rate->num > 0 && rate->own_times->size() > 1 && rate->own_times->front() == 0,
            "times do not begin with 0");
    constexpr std::int64_t exact_ns = 4'000'000'000'000'000;  // doubles have no finer milliseconds beyond
    if (rate->own_times->back() > exact_ns) return true;
    const auto again = parse_frame_times(frame_times_text(*rate), "timestamps.txt");
    require(again && *again->own_times == *rate->own_times, "times are others when they are read again");
    return true;
}

const Registered bag_target{{.name = "bag", .parse = parse_bag, .changes = 700, .most_bytes = 16384}};
const Registered mcap_target{{.name = "mcap", .parse = parse_mcap, .changes = 300, .most_bytes = 8192}};
const Registered db3_target{
    {.name = "db3", .parse = parse_db3, .cuts_are_refused = true, .changes = 300, .most_bytes = 8192}};
const Registered rvl_target{{.name = "rvl", .parse = parse_rvl, .most_bytes = 512}};
const Registered k4a_target{{.name = "k4a",
                             .parse = parse_k4a,
                             .cuts_are_refused = true,
                             .changes = 100,
                             .most_bytes = 6144,
                             .decodes_video = true}};
const Registered calibration_target{{.name = "k4a_calibration", .parse = parse_calibration}};
const Registered times_target{{.name = "frame_times", .parse = parse_times, .most_bytes = 512}};

// Framesets that a program sends: any bytes, in pieces of any size.

unsigned long whole_of(const std::string& bytes, std::size_t at) {
    unsigned long number = 0;
    for (std::size_t k = 4; k-- > 0;) number = number << 8U | static_cast<unsigned char>(bytes[at + k]);
    return number;
}

void put_crc(std::string& bytes, std::size_t of, std::size_t length, std::size_t at) {
    const auto crc = ::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()) + of, length);
    for (std::size_t k = 0; k < 4; ++k) bytes[at + k] = static_cast<char>(crc >> (8 * k) & 0xffU);
}

/// No changed byte would be seen by more than the checksums.
std::string with_right_frameset_checksums(std::string bytes) {
    for (std::size_t at = bytes.rfind("FRAMESET"); at != std::string::npos;
         at = at == 0 ? at : bytes.rfind("FRAMESET", at - 1)) {
        if (bytes.size() - at >= frameset_header_bytes) {
            const std::size_t length = 2 * whole_of(bytes, at + 32) * whole_of(bytes, at + 36) +
                                       3 * whole_of(bytes, at + 80) * whole_of(bytes, at + 84);
            if (length <= bytes.size() - at - frameset_header_bytes)
                put_crc(bytes, at + frameset_header_bytes, length, at + 92);
            put_crc(bytes, at, 96, at + 96);
        }
        if (at == 0) break;
    }
    return bytes;
}

struct Found {
    std::vector<std::uint64_t> numbers;
    std::string refusal;
    std::int64_t damaged = 0;
    bool operator==(const Found&) const = default;
};

Found found_in(const std::string& bytes, std::size_t piece) {
    FramesetParser parser;
    Found found;
    for (std::size_t at = 0; at < bytes.size() && found.refusal.empty(); at += piece) {
        const std::string_view part = std::string_view(bytes).substr(at, piece);
        parser.take({reinterpret_cast<const std::uint8_t*>(part.data()), part.size()});
        while (true) {
            const auto frameset = parser.next();
            if (!is_taken(frameset)) found.refusal = frameset.error().message;
            if (!frameset || !*frameset) break;
            const FramesetHeader& header = (*frameset)->header;
            require((*frameset)->payload->size() == header.payload_bytes(), "not the bytes that it says");
            require(header.metres_per_unit > 0 && header.metres_per_unit <= 1, "a unit cannot be");
            require(header.fx > 0 && header.fy > 0, "a focal length cannot be");
            (void)(*frameset)->depth().sample(header.width - 1, header.height - 1);
            if (header.has_colour())
                (void)(*frameset)->colour().sample(header.colour_width - 1, header.colour_height - 1, 2);
            found.numbers.push_back(header.number);
        }
    }
    found.damaged = parser.damaged();
    return found;
}

/// How many bytes come at once, whether the checksums are made right, and the bytes.
bool parse_framesets(std::string_view input) {
    Taken taken(input);
    const std::size_t piece = taken.byte() + 1;
    const bool is_right = taken.byte() % 2 == 1;
    const std::string rest(taken.rest());
    const std::string bytes = is_right ? with_right_frameset_checksums(rest) : rest;
    const Found found = found_in(bytes, piece);
    // How long it looks through what is damaged depends on how much came with it.
    const Found at_once = found_in(bytes, bytes.size() + 1);
    require(at_once.damaged > 0 || found == at_once, "what is found depends on how the bytes come");
    return !found.numbers.empty();
}

const Registered framesets_target{
    {.name = "framesets", .parse = parse_framesets, .most_bytes = 2048, .most_live_mebibytes = 4}};

// The table beside a snapshot of the RealSense Viewer, and the picture that it describes.

bool parse_realsense_table(std::string_view bytes) {
    const auto camera = parse_realsense_metadata(bytes, "metadata");
    const SourceFile raw(file_of(std::string(2 * 4 * 3, '\1'), "snap_Depth.raw"));
    (void)file_of(bytes, "snap_Depth_metadata.csv");
    const bool is_opened = is_picture(read_realsense_raw(raw));
    if (!is_taken(camera)) {
        require(!is_opened, "a picture is read by a table that is refused");
        return false;
    }
    require(camera->width > 0 && camera->height > 0 && camera->fx > 0 && camera->fy > 0 &&
                std::isfinite(camera->fx + camera->fy + *camera->cx + *camera->cy),
            "a camera is none");
    return true;
}

const Registered realsense_metadata_target{{.name = "realsense_metadata", .parse = parse_realsense_table}};

}  // namespace
}  // namespace touchable::fuzz
