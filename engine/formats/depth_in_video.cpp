#include "engine/formats/depth_in_video.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace touchable {
namespace {

/// What the colours of a part look like.
struct Look {
    bool is_grey = false, is_hue = false, is_nearly_grey = false;
    bool is_even = true;  ///< the same everywhere: a bar, and no depth

    bool is(VideoValues values) const {
        return values == VideoValues::grey ? is_grey : values == VideoValues::hue ? is_hue : is_nearly_grey;
    }
};

/// A margin is left out: codecs mix colours across the border of two halves.
Look look_of(const PlaneView& rgb) {
    constexpr int codec_noise = 24, tint = 40, dark = 48;
    const int margin = std::min({16, rgb.width / 8, rgb.height / 8});
    std::int64_t pixels = 0, grey = 0, nearly = 0, lit = 0, vivid = 0;
    int least = 255, most = 0;
    for (int y = margin; y < rgb.height - margin; ++y)
        for (int x = margin; x < rgb.width - margin; ++x) {
            const std::uint8_t* pixel = rgb.row(y) + 3 * std::ptrdiff_t{x};
            const auto [low, high] = std::minmax({pixel[0], pixel[1], pixel[2]});
            least = std::min<int>(least, low);
            most = std::max<int>(most, high);
            ++pixels;
            grey += high - low <= codec_noise;
            nearly += high - low <= tint;
            if (high < dark) continue;
            ++lit;
            vivid += 5 * (high - low) >= 3 * high;
        }
    return {100 * grey >= 99 * pixels, 10 * lit >= pixels && 10 * vivid >= 9 * lit,
            100 * nearly >= 98 * pixels, most - least <= 8};
}

/// Columns in the middle that are all of one colour: Depth Anything's videos have 50 white ones there, of
/// which codecs blur the outer ones.
int bar_in_the_middle(const PlaneView& rgb) {
    constexpr int usual = 50, blurred = 8, codec_noise = 24;
    const int middle = rgb.width / 2;
    const std::uint8_t* const colour = rgb.row(rgb.height / 2) + 3 * std::ptrdiff_t{middle};
    const auto is_bar = [&](int x) {
        for (int y = 0; y < rgb.height; ++y)
            for (int c = 0; c < 3; ++c)
                if (std::abs(rgb.row(y)[3 * std::ptrdiff_t{x} + c] - colour[c]) > codec_noise) return false;
        return true;
    };
    int first = middle, end = middle;
    while (first > 0 && is_bar(first - 1)) --first;
    while (end < rgb.width && is_bar(end)) ++end;
    int bar = 2 * std::min(middle - first, end - middle);
    if (std::abs(bar - usual) <= blurred) bar = usual;
    return may_be_bar(bar, rgb.width) && (rgb.width - bar) % 2 == 0 ? bar : 0;
}

/// The half that is so, where the other one is not.
std::optional<DepthInVideo> half_of(const PlaneView& rgb, VideoValues values, int bar) {
    for (const VideoLayout layout :
         {VideoLayout::left, VideoLayout::right, VideoLayout::top, VideoLayout::bottom}) {
        const bool is_beside = layout == VideoLayout::left || layout == VideoLayout::right;
        const DepthInVideo half{layout, values, is_beside ? bar : 0};
        const auto part = depth_part(layout, rgb.width, rgb.height, half.bar);
        if (!part) continue;
        const Look depth = look_of(part_of(rgb, *part));
        const Look colour = look_of(part_of(rgb, colour_part(layout, rgb.width, rgb.height, half.bar)));
        if (depth.is(values) && !depth.is_even && !colour.is(values)) return half;
    }
    return {};
}

}  // namespace

std::optional<DepthInVideo> find_depth_in(VideoPicture& picture, std::optional<VideoValues> said) {
    constexpr VideoLayout alone = VideoLayout::alone;
    if (!picture.has_colours()) return DepthInVideo{alone, VideoValues::grey};
    const auto rgb = picture.rgb();
    if (!rgb) return {};
    const int bar = bar_in_the_middle(rgb->view);
    if (said) return half_of(rgb->view, *said, bar).value_or(DepthInVideo{alone, *said});
    const Look whole = look_of(rgb->view);
    if (whole.is_grey) return DepthInVideo{alone, VideoValues::grey};
    if (whole.is_hue) return DepthInVideo{alone, VideoValues::hue};
    for (const VideoValues values : {VideoValues::grey, VideoValues::hue})
        if (auto half = half_of(rgb->view, values, bar)) return half;
    if (whole.is_nearly_grey) return DepthInVideo{alone, VideoValues::mean};
    return half_of(rgb->view, VideoValues::mean, bar);
}

std::optional<VideoValues> values_in(VideoPicture& picture, const PicturePart& part) {
    if (!picture.has_colours()) return VideoValues::grey;
    const auto rgb = picture.rgb();
    if (!rgb) return {};
    const Look look = look_of(part_of(rgb->view, part));
    for (const VideoValues values : {VideoValues::grey, VideoValues::hue, VideoValues::mean})
        if (look.is(values)) return values;
    return {};
}

std::string words_of(const DepthInVideo& found) {
    const std::string kind = found.values == VideoValues::grey  ? "grey"
                             : found.values == VideoValues::hue ? "hue"
                                                                : "nearly grey";
    const std::string what =
        found.values == VideoValues::mean ? ", and a value is the mean of its colours" : "";
    switch (found.layout) {
        case VideoLayout::left:
            return "depth is the left half, which is " + kind + ", colour the right one" + what;
        case VideoLayout::right:
            return "depth is the right half, which is " + kind + ", colour the left one" + what;
        case VideoLayout::top:
            return "depth is the upper half, which is " + kind + ", colour the lower one" + what;
        case VideoLayout::bottom:
            return "depth is the lower half, which is " + kind + ", colour the upper one" + what;
        default:
            return "depth is " + kind + what + " and has no colour beside it";
    }
}

}  // namespace touchable
