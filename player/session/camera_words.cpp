#include "player/session/camera_words.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <string_view>
#include <system_error>
#include <utility>

#include "device/hand_options.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/camera/live_bytes.hpp"

namespace touchable {
namespace {

constexpr std::string_view replay_kind = "replay:", plugged_kind = "v4l2:", pipe_kind = "pipe:",
                           tcp_kind = "tcp://", stream_kind = "stream:";

constexpr std::array plugged_keys{
    HandKey{.name = "size", .unit = "", .kind = HandKey::Kind::words},
    HandKey{.name = "fps", .unit = "frames/s", .least = 0.1, .greatest = 1000, .standard = 30},
    HandKey{.name = "colour", .unit = "", .kind = HandKey::Kind::words}};

constexpr std::array replay_keys{
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

/// What follows the kind: a file's name, and behind the first comma keys.
struct CameraParts {
    std::string file, keys;
};
CameraParts parts_of(const std::string& words, std::string_view kind) {
    const std::size_t comma = words.find(',');
    if (comma == std::string::npos) return {words.substr(kind.size()), ""};
    return {words.substr(kind.size(), comma - kind.size()), words.substr(comma + 1)};
}

/// "640x480".
bool read_size(const std::string& words, V4l2Choice& choice) {
    constexpr int largest_side = 16384;
    const char *at = words.data(), *const end = at + words.size();
    const auto width = std::from_chars(at, end, choice.width);
    if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return false;
    const auto height = std::from_chars(width.ptr + 1, end, choice.height);
    return height.ec == std::errc() && height.ptr == end && choice.width >= 1 && choice.height >= 1 &&
           choice.width <= largest_side && choice.height <= largest_side;
}

Result<LiveCamera> read_plugged(const std::string& words) {
    const auto [node, keys] = parts_of(words, plugged_kind);
    if (node.empty())
        return usage_error(
            "camera 'v4l2' needs a node, such as v4l2:/dev/video0; touchable cameras lists those that are "
            "there");
    const auto given = HandOptions::parse("camera 'v4l2'", keys, plugged_keys);
    if (!given.ok()) return given.error();
    V4l2Choice choice{node};
    if (given->given("size") && !read_size(given->words("size"), choice))
        return usage_error("camera 'v4l2': size=" + printable(given->words("size")) +
                           " will not do; right would be WIDTHxHEIGHT, such as size=640x480");
    if (given->given("fps")) choice.rate = given->number("fps");
    choice.colour = given->words("colour");
    return LiveCamera{std::move(choice), {}, {}};
}

Result<LiveCamera> read_sender(const std::string& words) {
    FramesetChoice choice;
    if (words.starts_with(tcp_kind)) {
        choice.address = words.substr(tcp_kind.size());
        TRY(check_address(choice.address));
        return LiveCamera{std::move(choice), {}, {}};
    }
    choice.command = words.substr(pipe_kind.size());
    if (choice.command.find_first_not_of(" \t") == std::string::npos)
        return usage_error(
            "camera 'pipe' needs a command that writes framesets, such as \"pipe:python3 realsense.py\" "
            "(docs/camera.md)");
    return LiveCamera{std::move(choice), {}, {}};
}

Result<LiveCamera> read_stream(const std::string& words) {
    TRY_ASSIGN(auto url, read_stream_url(words.substr(stream_kind.size())));
    return LiveCamera{StreamChoice{.url = std::move(url)}, {}, {}};
}

Result<LiveCamera> read_replay(const std::string& words) {
    const auto [recording, keys] = parts_of(words, replay_kind);
    if (recording.empty())
        return usage_error("camera 'replay' needs a recording: replay:PATH, with a clip or folder of images");
    const auto given = HandOptions::parse("camera 'replay'", keys, replay_keys);
    if (!given.ok()) return given.error();
    LiveCamera camera{{}, recording, {}};
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

}  // namespace

Result<LiveCamera> read_live_camera(const std::string& words) {
    if (words.starts_with(plugged_kind)) return read_plugged(words);
    if (words.starts_with(replay_kind)) return read_replay(words);
    if (words.starts_with(pipe_kind) || words.starts_with(tcp_kind)) return read_sender(words);
    if (words.starts_with(stream_kind)) return read_stream(words);
    return usage_error(
        "unknown camera '" + printable(words) +
        "'; there are v4l2:/dev/videoN, one that is plugged in (touchable cameras lists "
        "them), pipe:CMD and tcp://HOST:PORT, programs that send framesets, "
        "stream:ADDRESS, what touchable serve sends, and replay:PATH, a recording that behaves like one");
}

}  // namespace touchable
