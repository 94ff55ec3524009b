#include "player/session/camera_words.hpp"

#include <array>
#include <cmath>
#include <numeric>
#include <string_view>

#include "device/hand_options.hpp"
#include "engine/printable.hpp"

namespace touchable {
namespace {

constexpr std::string_view kind = "replay:";

constexpr std::array camera_keys{
    HandKey{.name = "fps", .unit = "frames/s", .least = 0.1, .greatest = 1000, .standard = 30},
    HandKey{.name = "jitter", .unit = "ms", .least = 0, .greatest = 1000, .standard = 0},
    HandKey{.name = "drop", .unit = "of the frames", .least = 0, .greatest = 0.99, .standard = 0},
    HandKey{.name = "stall", .unit = "s", .least = 0, .greatest = 1e6, .standard = 0},
    HandKey{.name = "resume", .unit = "s", .least = 0, .greatest = 1e6, .standard = 0}};

/// In thousandths, which is what cameras' 29.97 is said in.
FrameRate rate_of(double per_second) {
    constexpr std::int64_t thousand = 1000;
    const std::int64_t thousandths = std::llround(per_second * thousand);
    const std::int64_t common = std::gcd(thousandths, thousand);
    return {thousandths / common, thousand / common};
}

std::int64_t nanoseconds_of(double seconds) {
    return std::llround(seconds * 1e9);
}

}  // namespace

Result<LiveCamera> read_live_camera(const std::string& words) {
    if (!words.starts_with(kind))
        return usage_error("unknown camera '" + printable(words) +
                           "'; the one there is is replay:PATH, a recording that behaves like one");
    const std::size_t comma = words.find(',');
    LiveCamera camera{words.substr(kind.size(), comma == std::string::npos ? comma : comma - kind.size()),
                      {}};
    if (camera.recording.empty())
        return usage_error("camera 'replay' needs a recording: replay:PATH, with a clip or folder of images");
    const auto given = HandOptions::parse(
        "camera 'replay'", comma == std::string::npos ? "" : words.substr(comma + 1), camera_keys);
    if (!given.ok()) return given.error();
    CameraDelivery& delivery = camera.delivery;
    if (given->given("fps")) delivery.rate = rate_of(given->number("fps"));
    delivery.jitter_ns = nanoseconds_of(given->number("jitter") * 1e-3);
    delivery.drop = given->number("drop");
    if (given->given("stall")) delivery.stall_ns = nanoseconds_of(given->number("stall"));
    if (given->given("resume")) delivery.resume_ns = nanoseconds_of(given->number("resume"));
    if (delivery.resume_ns && !(delivery.stall_ns && *delivery.stall_ns < *delivery.resume_ns))
        return usage_error(
            "camera 'replay': resume must be a moment after stall, which begins the time "
            "without frames");
    return camera;
}

}  // namespace touchable
