// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/video_picture.hpp"

#include <array>
#include <bit>
#include <cstdlib>
#include <map>
#include <tuple>

#include "engine/base/try.hpp"
#include "engine/clip/tracks.hpp"

namespace touchable {
namespace {

constexpr VideoLayout other_half(VideoLayout layout) {
    return layout == VideoLayout::left     ? VideoLayout::right
           : layout == VideoLayout::right  ? VideoLayout::left
           : layout == VideoLayout::top    ? VideoLayout::bottom
           : layout == VideoLayout::bottom ? VideoLayout::top
                                           : layout;
}

/// Converts grey of two bytes in the other byte order, such as PNG's, to the host's; otherwise nothing.
std::optional<Image> in_host_order(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = pixel_format_of(frame);
    const bool is_big = (format.flags & AV_PIX_FMT_FLAG_BE) != 0;
    const AVComponentDescriptor& samples = format.comp[0];
    if (format.nb_components != 1 || samples.depth <= 8 || samples.shift != 0 || samples.step != 2 ||
        (format.flags & AV_PIX_FMT_FLAG_FLOAT) != 0 || is_big == (std::endian::native == std::endian::big))
        return std::nullopt;
    Image image = packed_image({frame.data[0], frame.linesize[0], frame.width, frame.height, 2, 1});
    for (std::size_t k = 0; k < image.samples.size(); k += 2)
        std::swap(image.samples[k], image.samples[k + 1]);
    return image;
}

/// Counts pixels of a ramp that goes from black to one full colour, on to a mixed one and to white: one
/// channel after another is filled, each when the one before is full ("black-blue-cyan-white", "hot"). The
/// mean of the colours grows along it; the hue does not begin before the first channel is full.
class RampCounts {
public:
    void add(const std::uint8_t* pixel) {
        constexpr int off = 24, full = 255 - off;  // codecs move colours by so much
        constexpr int dark = 48;                   // for hue, darker is no depth
        for (std::size_t k = 0; k < orders_.size(); ++k) {
            const int first = pixel[orders_[k][0]], second = pixel[orders_[k][1]],
                      third = pixel[orders_[k][2]];
            fits_[k] += (second <= off || first >= full) && (third <= off || second >= full);
            unsaturated_[k] += second <= off ? first > dark && first < full - off : third > off;
        }
    }
    /// Whether nearly all fit one order, and many of them are no full hue: darker, or on the way to white.
    bool is_ramp(std::int64_t pixels) const {
        for (std::size_t k = 0; k < orders_.size(); ++k)
            if (100 * fits_[k] >= 97 * pixels && 10 * unsaturated_[k] >= pixels) return true;
        return false;
    }

private:
    static constexpr std::array<std::array<std::uint8_t, 3>, 6> orders_{
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    std::array<std::int64_t, 6> fits_{}, unsaturated_{};
};

/// What the colours of a part look like.
struct PartLook {
    bool is_grey = false, is_hue = false, is_nearly_grey = false;
    bool is_ramp = false;  ///< of colours whose mean grows (RampCounts)
    bool is_even = true;   ///< the same everywhere: a bar, and no depth
    bool is_black = false;
    bool is_vivid = false;        ///< most of what is lit is bright and of full colour
    bool is_mostly_grey = false;  ///< as is_nearly_grey, but for one pixel in twenty

    bool is(VideoValues values) const {
        if (values == VideoValues::grey) return is_grey;
        return values == VideoValues::hue ? is_hue : is_nearly_grey || is_ramp;
    }
};

/// Leaves out a margin: codecs mix colours across the border of two halves.
PartLook look_of(const PlaneView& rgb, int widest_margin = 16) {
    constexpr int codec_noise = 24, tint = 40, dark = 48, least_full = 192;
    const int margin = std::min({widest_margin, rgb.width / 8, rgb.height / 8});
    std::int64_t pixels = 0, grey = 0, nearly = 0, lit = 0, vivid = 0, full = 0, both = 0;
    int least = 255, most = 0;
    RampCounts ramp;
    for (int y = margin; y < rgb.height - margin; ++y)
        for (int x = margin; x < rgb.width - margin; ++x) {
            const std::uint8_t* pixel = rgb.row(y) + 3 * std::ptrdiff_t{x};
            const auto [low, high] = std::minmax({pixel[0], pixel[1], pixel[2]});
            least = std::min<int>(least, low);
            most = std::max<int>(most, high);
            ++pixels;
            grey += high - low <= codec_noise;
            nearly += high - low <= tint;
            ramp.add(pixel);
            if (high < dark) continue;
            ++lit;
            const bool is_vivid = 5 * (high - low) >= 3 * high, is_full = high >= least_full;
            vivid += is_vivid;
            full += is_full;
            both += is_vivid && is_full;
        }
    const bool is_black = most < DepthCoding::max_invalid_codes;
    const bool is_ramp = 100 * nearly < 98 * pixels && ramp.is_ramp(pixels);
    return {100 * grey >= 99 * pixels,
            !is_ramp && 10 * lit >= pixels && 10 * vivid >= 9 * lit && 10 * full >= 7 * lit,
            100 * nearly >= 98 * pixels,
            is_ramp,
            most - least <= 8,
            is_black,
            2 * both > lit,
            100 * nearly >= 95 * pixels};
}

/// Number of columns of one colour in the middle: Depth Anything's videos have 50 white ones there, of which
/// codecs blur the outer ones. 0: no such bar.
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

/// What the halves of a picture look like.
class Halves {
public:
    Halves(const PlaneView& rgb, int bar) : bar_(bar) {
        for (const VideoLayout layout :
             {VideoLayout::left, VideoLayout::right, VideoLayout::top, VideoLayout::bottom})
            if (const auto part = depth_part(layout, rgb.width, rgb.height, bar_of(layout)))
                looks_[layout] = look_of(part_of(rgb, *part));
    }
    /// The half that looks like these values, if the other half does not.
    std::optional<DepthInVideo> of(VideoValues values) const {
        for (const auto& [layout, depth] : looks_) {
            const PartLook& other = looks_.at(other_half(layout));
            const bool are_alike =
                other.is(values) || (values == VideoValues::mean && !depth.is_ramp && other.is_mostly_grey);
            if (depth.is(values) && !depth.is_even && !are_alike)
                return DepthInVideo{layout, values, bar_of(layout), depth.is_ramp};
        }
        return {};
    }

private:
    int bar_of(VideoLayout layout) const { return is_side_by_side(layout) ? bar_ : 0; }

    int bar_;
    std::map<VideoLayout, PartLook> looks_;
};

/// (R + G + B) / 3, rounded to the nearest.
Image mean_of(const PlaneView& colours) {
    Image to{colours.width, colours.height, 1, 1, {}};
    to.samples.reserve(pixel_count(colours.width, colours.height));
    for (int y = 0; y < colours.height; ++y) {
        const std::uint8_t* rgb = colours.row(y);
        for (int x = 0; x < colours.width; ++x, rgb += 3)
            to.samples.push_back(static_cast<std::uint8_t>((rgb[0] + rgb[1] + rgb[2] + 1) / 3));
    }
    return to;
}

std::optional<DepthInVideo> find_in_colours(const PlaneView& rgb, std::optional<VideoValues> said) {
    constexpr VideoLayout alone = VideoLayout::alone;
    const int bar = bar_in_the_middle(rgb);
    if (said) return Halves(rgb, bar).of(*said).value_or(DepthInVideo{alone, *said});
    const PartLook whole = look_of(rgb);
    if (whole.is_grey) return DepthInVideo{alone, VideoValues::grey};
    if (whole.is_hue) return DepthInVideo{alone, VideoValues::hue};
    const Halves halves(rgb, bar);
    for (const VideoValues values : {VideoValues::grey, VideoValues::hue})
        if (auto half = halves.of(values)) return half;
    if (whole.is(VideoValues::mean)) return DepthInVideo{alone, VideoValues::mean, 0, whole.is_ramp};
    return halves.of(VideoValues::mean);
}

}  // namespace

std::optional<PicturePart> depth_part(VideoLayout layout, int width, int height, int bar) {
    if (layout == VideoLayout::alone) return PicturePart{0, 0, width, height};
    int &side = is_side_by_side(layout) ? width : height, whole = side;
    if (side <= bar || (side - bar) % 2 != 0) return std::nullopt;
    side = (side - bar) / 2;
    const int second = whole - side;
    return PicturePart{layout == VideoLayout::right ? second : 0, layout == VideoLayout::bottom ? second : 0,
                       width, height};
}

PicturePart colour_part(VideoLayout layout, int width, int height, int bar) {
    return depth_part(other_half(layout), width, height, bar).value_or(PicturePart{});
}

PlaneView part_of(PlaneView plane, const PicturePart& part) {
    plane.data = plane.row(part.y) + std::ptrdiff_t{part.x} * plane.channels * plane.bytes_per_sample;
    plane.width = part.width;
    plane.height = part.height;
    return plane;
}

VideoPicture::VideoPicture(FramePtr frame, RgbConverter& converter, std::string where)
    : frame_(std::move(frame)), converter_(converter), where_(std::move(where)) {}

bool VideoPicture::has_colours() const {
    return pixel_format_of(*frame_).nb_components >= 3 || frame_->format == AV_PIX_FMT_PAL8;
}

int VideoPicture::bits() const {
    return is_rgb8(*frame_) ? 8 : sample_bits(*frame_);
}

Result<Plane> VideoPicture::rgb() {
    if (rgb_) return *rgb_;
    auto made = converter_.converted(*frame_);
    if (!made) return input_error(where_ + ": " + made.error().message);
    rgb_ = plane_from(std::move(*made));
    return *rgb_;
}

Result<Plane> VideoPicture::depth(VideoValues values, const PicturePart& part) {
    if (values == VideoValues::grey) return grey(part);
    if (values == VideoValues::mean) return mean(part);
    if (!has_colours()) return input_error(where_ + ": is grey, where depth was to be hue");
    auto plane = rgb();
    if (plane) plane->view = part_of(plane->view, part);
    return plane;
}

Result<Plane> VideoPicture::grey(const PicturePart& part) {
    if (is_rgb8(*frame_)) {
        TRY_ASSIGN(const auto all, rgb());
        const PlaneView here = part_of(all.view, part);
        if (auto grey = as_grey(packed_image(here))) return plane_from(std::move(*grey));
        if (look_of(here).is_nearly_grey) return plane_from(mean_of(here));
        return input_error(where_ +
                           ": is in colour, where depth was to be grey (a scene file's video.values can be "
                           "mean, or hue with depth.coding hue)");
    }
    const int bits = sample_bits(*frame_);
    if (const auto samples = luma_samples(*frame_)) return Plane{part_of(*samples, part), frame_, bits};
    if (const auto swapped = in_host_order(*frame_))
        return plane_from(packed_image(part_of(swapped->view(), part)), bits);
    return input_error(where_ + ": has pixel format " + format_name(*frame_) +
                       ": depth is grey of 8 to 16 bits, YUV, or RGB of 8 bits");
}

Result<Plane> VideoPicture::mean(const PicturePart& part) {
    TRY_ASSIGN(const auto all, rgb());
    return plane_from(mean_of(part_of(all.view, part)));
}

CodeRange VideoPicture::code_range(VideoValues values) const {
    const CodeRange full{0, (1 << bits()) - 1};
    const bool is_luma = values == VideoValues::grey && has_colours() && !is_rgb8(*frame_);
    const std::string name = format_name(*frame_);
    if (!is_luma || frame_->color_range == AVCOL_RANGE_JPEG || name.starts_with("yuvj")) return full;
    const int scale = 1 << (bits() - 8);
    const CodeRange limited{16 * scale, 235 * scale};
    if (frame_->color_range == AVCOL_RANGE_MPEG) return limited;
    // Full-range grey that was encoded as luma often states no range.
    const auto samples = luma_samples(*frame_);
    for (int y = 0; samples && y < samples->height; ++y)
        for (int x = 0; x < samples->width; ++x) {
            const int code = samples->sample(x, y);
            constexpr int ringing = 4;
            if (code < limited.least - ringing * scale || code > limited.most + ringing * scale) return full;
        }
    return limited;
}

Result<VideoPicture> picture_at(VideoFile& video, std::int64_t number, RgbConverter& converter) {
    TRY(video.seek(number));
    TRY_ASSIGN(auto frame, video.next());
    if (!frame) return input_error(video.where(number) + ": is missing");
    return VideoPicture(std::move(frame), converter, video.where(number));
}

std::optional<DepthInVideo> find_depth_in(VideoPicture& picture, std::optional<VideoValues> said) {
    if (!picture.has_colours()) return DepthInVideo{VideoLayout::alone, VideoValues::grey};
    const auto rgb = picture.rgb();
    return rgb ? find_in_colours(rgb->view, said) : std::nullopt;
}

std::optional<VideoValues> values_in(VideoPicture& picture, const PicturePart& part) {
    if (!picture.has_colours()) return VideoValues::grey;
    const auto rgb = picture.rgb();
    if (!rgb) return {};
    const PartLook look = look_of(part_of(rgb->view, part));
    if (look.is_black) return {};
    if (look.is_vivid && !look.is_ramp) return VideoValues::hue;
    return look.is_grey ? VideoValues::grey : VideoValues::mean;
}

std::string words_of(const DepthInVideo& found) {
    const std::string kind = found.values == VideoValues::grey  ? "grey"
                             : found.values == VideoValues::hue ? "hue"
                             : found.is_ramp                    ? "a ramp from black through colours to white"
                                                                : "nearly grey";
    const std::string what =
        found.values == VideoValues::mean ? ", and a value is the mean of its colours" : "";
    constexpr std::tuple<VideoLayout, const char*, const char*> halves[] = {
        {VideoLayout::left, "left", "right"},
        {VideoLayout::right, "right", "left"},
        {VideoLayout::top, "upper", "lower"},
        {VideoLayout::bottom, "lower", "upper"}};
    for (const auto& [layout, depth, colour] : halves)
        if (layout == found.layout)
            return std::string("depth is the ") + depth + " half, which is " + kind + ", colour the " +
                   colour + " one" + what;
    return "depth is " + kind + what;
}

std::optional<DepthInVideo> depth_beside_colour(const Image& picture) {
    if (picture.channels != 3 || picture.bytes_per_sample != 1) return {};
    const auto found = find_in_colours(picture.view(), {});
    const bool is_half = found && found->layout != VideoLayout::alone && found->values != VideoValues::hue;
    return is_half ? found : std::nullopt;
}

std::optional<DepthInVideo> depth_in_colours(const Image& picture) {
    if (auto half = depth_beside_colour(picture)) return half;
    const bool may_be = picture.channels == 3 && picture.bytes_per_sample == 1 && !is_grey(picture);
    if (!may_be || !look_of(picture.view(), 0).is_grey) return {};
    return DepthInVideo{VideoLayout::alone, VideoValues::mean};
}

StoredImage half_of(const StoredImage& picture, const DepthInVideo& found, PlaneRole role) {
    const Image& all = picture.image;
    const bool is_depth = role == PlaneRole::depth;
    const auto part =
        depth_part(is_depth ? found.layout : other_half(found.layout), all.width, all.height, found.bar);
    if (!part || all.channels != 3) return picture;
    const PlaneView view = part_of(all.view(), *part);
    return {is_depth ? mean_of(view) : packed_image(view), picture.codec,
            is_depth ? "gray" : picture.pixel_format, 8, picture.interlaced};
}

}  // namespace touchable
