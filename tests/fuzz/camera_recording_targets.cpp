// Recordings of cameras in files of their own makers.
#include <cmath>

#include "engine/clip/containers.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/ros_messages.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

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

/// What is written of times is the times.
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

const Registered bag_target{{.name = "bag", .parse = parse_bag, .changes = 100, .most_bytes = 16384}};
const Registered mcap_target{{.name = "mcap", .parse = parse_mcap, .changes = 100, .most_bytes = 8192}};
const Registered db3_target{
    {.name = "db3", .parse = parse_db3, .cuts_are_refused = true, .changes = 100, .most_bytes = 8192}};
const Registered rvl_target{{.name = "rvl", .parse = parse_rvl, .most_bytes = 512}};
const Registered k4a_target{{.name = "k4a",
                             .parse = parse_k4a,
                             .cuts_are_refused = true,
                             .changes = 100,
                             .most_bytes = 6144,
                             .most_mebibytes = 2048,
                             .most_live_mebibytes = 2048}};
const Registered calibration_target{{.name = "k4a_calibration", .parse = parse_calibration}};
const Registered times_target{{.name = "frame_times", .parse = parse_times, .most_bytes = 512}};

}  // namespace
}  // namespace touchable::fuzz
