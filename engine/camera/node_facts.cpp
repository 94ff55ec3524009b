#include "engine/camera/node_facts.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <numeric>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

// A driver that never says that there are no more is not listened to for ever.
constexpr std::uint32_t most_entries = 256;
constexpr int largest_side = 16384;
constexpr double usual_rate = 30;
constexpr std::int64_t usual_pixels = 1280 * 720;

constexpr std::array depth_formats{V4L2_PIX_FMT_Z16, V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_Y16_BE};
constexpr std::array colour_formats{V4L2_PIX_FMT_RGB24, V4L2_PIX_FMT_BGR24, V4L2_PIX_FMT_YUYV,
                                    V4L2_PIX_FMT_UYVY,  V4L2_PIX_FMT_NV12,  V4L2_PIX_FMT_MJPEG,
                                    V4L2_PIX_FMT_JPEG};

/// Drivers end their texts with a 0, as a rule.
template <std::size_t n>
std::string text_of(const std::uint8_t (&bytes)[n]) {
    std::string text;
    for (const std::uint8_t byte : bytes) {
        if (byte == 0) break;
        text += static_cast<char>(byte);
    }
    return text;
}

bool is_faster(const FrameRate& a, const FrameRate& b) {
    return per_second(a) > per_second(b);
}

std::vector<FrameRate> rates_of(VideoSystem& system, int descriptor, std::uint32_t code, int width,
                                int height) {
    std::vector<FrameRate> rates;
    for (std::uint32_t index = 0; index < most_entries; ++index) {
        v4l2_frmivalenum entry = {};
        entry.index = index;
        entry.pixel_format = code;
        entry.width = static_cast<std::uint32_t>(width);
        entry.height = static_cast<std::uint32_t>(height);
        if (call(system, descriptor, VIDIOC_ENUM_FRAMEINTERVALS, &entry) < 0) break;
        const bool one = entry.type == V4L2_FRMIVAL_TYPE_DISCRETE;
        const v4l2_fract& interval = one ? entry.discrete : entry.stepwise.min;
        if (const auto rate = rate_of_interval(interval.numerator, interval.denominator))
            rates.push_back(*rate);
        if (one) continue;
        const v4l2_fract& slowest = entry.stepwise.max;
        // All between: those that people ask for.
        for (const std::int64_t usual : {60, 30, 15})
            if (const auto least = rate_of_interval(slowest.numerator, slowest.denominator);
                least && !rates.empty() && static_cast<double>(usual) < per_second(rates.front()) &&
                static_cast<double>(usual) > per_second(*least))
                rates.push_back({usual, 1});
        break;
    }
    std::stable_sort(rates.begin(), rates.end(), is_faster);
    return rates;
}

void add_mode(VideoSystem& system, int descriptor, NodeFormat& format, std::uint32_t width,
              std::uint32_t height) {
    if (width == 0 || height == 0 || width > largest_side || height > largest_side) return;
    const int w = static_cast<int>(width), h = static_cast<int>(height);
    format.modes.push_back({w, h, rates_of(system, descriptor, format.code, w, h)});
}

void find_modes(VideoSystem& system, int descriptor, NodeFormat& format) {
    for (std::uint32_t index = 0; index < most_entries; ++index) {
        v4l2_frmsizeenum entry = {};
        entry.index = index;
        entry.pixel_format = format.code;
        if (call(system, descriptor, VIDIOC_ENUM_FRAMESIZES, &entry) < 0) break;
        if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
            add_mode(system, descriptor, format, entry.discrete.width, entry.discrete.height);
            continue;
        }
        format.any_size = true;
        add_mode(system, descriptor, format, entry.stepwise.min_width, entry.stepwise.min_height);
        if (entry.stepwise.min_width <= 640 && entry.stepwise.max_width >= 640 &&
            entry.stepwise.min_height <= 480 && entry.stepwise.max_height >= 480)
            add_mode(system, descriptor, format, 640, 480);
        add_mode(system, descriptor, format, entry.stepwise.max_width, entry.stepwise.max_height);
        break;
    }
}

std::int64_t pixels_of(const NodeMode& mode) {
    return std::int64_t{mode.width} * mode.height;
}

/// The rate nearest to what is wanted; nothing where the camera says none.
std::optional<FrameRate> nearest_rate(const NodeMode& mode, double wanted) {
    const auto distance = [wanted](const FrameRate& rate) { return std::abs(per_second(rate) - wanted); };
    const auto nearest =
        std::min_element(mode.rates.begin(), mode.rates.end(),
                         [&](const FrameRate& a, const FrameRate& b) { return distance(a) < distance(b); });
    return nearest == mode.rates.end() ? std::nullopt : std::optional(*nearest);
}

/// How well a mode goes where nobody asked for a size: at the usual rate before others, then the largest
/// that is not too large.
std::pair<bool, std::int64_t> usual_mark(const NodeMode& mode, double wanted) {
    const auto rate = nearest_rate(mode, wanted);
    const bool fast = !rate || per_second(*rate) > 0.9 * wanted;
    const std::int64_t pixels = pixels_of(mode);
    return {fast, pixels <= usual_pixels ? pixels : -pixels};
}

Result<NodeMode> choose_size(const NodeFormat& format, const ModeWish& wish) {
    if (wish.width == 0) {
        const double wanted = wish.rate.value_or(usual_rate);
        return *std::max_element(format.modes.begin(), format.modes.end(),
                                 [wanted](const NodeMode& a, const NodeMode& b) {
                                     return usual_mark(a, wanted) < usual_mark(b, wanted);
                                 });
    }
    std::string there;
    for (const NodeMode& mode : format.modes) {
        if (mode.width == wish.width && mode.height == wish.height) return mode;
        there += (there.empty() ? "" : ", ") + std::to_string(mode.width) + "x" + std::to_string(mode.height);
    }
    if (format.any_size) return NodeMode{wish.width, wish.height, format.modes.front().rates};
    return usage_error("offers no " + format_text(format.code) + " of " + std::to_string(wish.width) + "x" +
                       std::to_string(wish.height) + " (size=); there are " + there);
}

}  // namespace

bool is_depth_format(std::uint32_t code) {
    return std::find(depth_formats.begin(), depth_formats.end(), code) != depth_formats.end();
}

Result<const NodeFormat*> depth_of_node(const NodeFacts& facts) {
    const NodeFormat* best = nullptr;
    std::string there;
    for (const NodeFormat& format : facts.formats) {
        there += (there.empty() ? "" : ", ") + format_text(format.code);
        if (!is_depth_format(format.code)) continue;
        if (best == nullptr || (format.code == V4L2_PIX_FMT_Z16 && best->code != V4L2_PIX_FMT_Z16))
            best = &format;
    }
    if (best != nullptr) return best;
    return input_error(facts.node + ": " + printable(facts.card) +
                       (facts.captures ? " gives no depth there (" + (there.empty() ? "nothing" : there) +
                                             "); what can be touched is Z16 or Y16"
                                       : std::string(" gives no pictures there")) +
                       "; touchable cameras lists the nodes that have depth");
}

bool is_colour_format(std::uint32_t code) {
    return std::find(colour_formats.begin(), colour_formats.end(), code) != colour_formats.end();
}

std::string format_text(std::uint32_t code) {
    constexpr std::uint32_t big_endian = 1U << 31;
    std::string text;
    for (int k = 0; k < 4; ++k) text += static_cast<char>((code & ~big_endian) >> (8 * k) & 0xff);
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return printable(text) + ((code & big_endian) != 0 ? " (big-endian)" : "");
}

std::optional<FrameRate> rate_of_interval(std::uint32_t numerator, std::uint32_t denominator) {
    if (numerator == 0 || denominator == 0) return std::nullopt;
    const std::int64_t common = std::gcd(std::int64_t{numerator}, std::int64_t{denominator});
    const FrameRate rate{denominator / common, numerator / common};
    constexpr std::int64_t most_term = 1'000'000'000;
    const bool can_be = per_second(rate) >= 0.01 && per_second(rate) <= 1000 && rate.num <= most_term &&
                        rate.den <= most_term;
    return can_be ? std::optional(rate) : std::nullopt;
}

double per_second(const FrameRate& rate) {
    return static_cast<double>(rate.num) / static_cast<double>(rate.den);
}

std::string rate_text(const FrameRate& rate) {
    return formatted("%.4g", per_second(rate));
}

Result<NodeMode> choose_mode(const NodeFormat& format, const ModeWish& wish) {
    if (format.modes.empty()) return NodeMode{wish.width, wish.height, {}};
    TRY_ASSIGN(auto mode, choose_size(format, wish));
    const auto rate = nearest_rate(mode, wish.rate.value_or(usual_rate));
    mode.rates = rate ? std::vector{*rate} : std::vector<FrameRate>();
    return mode;
}

std::string mode_text(const NodeMode& mode) {
    std::string rates;
    for (const FrameRate& rate : mode.rates) rates += (rates.empty() ? "" : ", ") + rate_text(rate);
    return std::to_string(mode.width) + "x" + std::to_string(mode.height) +
           (rates.empty() ? "" : " at " + rates + " frames/s");
}

Result<NodeFacts> facts_of_node(VideoSystem& system, int descriptor, const std::string& node) {
    v4l2_capability can = {};
    if (call(system, descriptor, VIDIOC_QUERYCAP, &can) < 0) return input_error(node_trouble(node, errno));
    NodeFacts facts{node, text_of(can.driver), text_of(can.card), text_of(can.bus_info)};
    const bool of_node = (can.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
    const std::uint32_t able = of_node ? can.device_caps : can.capabilities;
    facts.captures = (able & V4L2_CAP_VIDEO_CAPTURE) != 0 && (able & V4L2_CAP_STREAMING) != 0;
    if (!facts.captures) return facts;
    for (std::uint32_t index = 0; index < most_entries; ++index) {
        v4l2_fmtdesc entry = {};
        entry.index = index;
        entry.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
        if (call(system, descriptor, VIDIOC_ENUM_FMT, &entry) < 0) break;
        NodeFormat format{entry.pixelformat, text_of(entry.description)};
        find_modes(system, descriptor, format);
        facts.formats.push_back(std::move(format));
    }
    return facts;
}

Result<NodeFacts> look_at_node(VideoSystem& system, const std::string& node) {
    const int descriptor = system.open(node.c_str());
    if (descriptor < 0) return input_error(node_trouble(node, errno));
    auto facts = facts_of_node(system, descriptor, node);
    system.close(descriptor);
    return facts;
}

}  // namespace touchable
