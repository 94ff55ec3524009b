#include "engine/formats/video_picture.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

const AVPixFmtDescriptor& format_of(const AVFrame& frame) {
    return *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
}

/// With rows packed.
Image copied(const PlaneView& view) {
    Image image{view.width, view.height, view.bytes_per_sample, view.channels, {}};
    const auto row_bytes = static_cast<std::size_t>(view.width * view.channels * view.bytes_per_sample);
    image.samples.resize(row_bytes * static_cast<std::size_t>(view.height));
    for (int y = 0; y < view.height; ++y)
        std::memcpy(image.samples.data() + row_bytes * static_cast<std::size_t>(y), view.row(y), row_bytes);
    return image;
}

/// Grey of two bytes in the other order than this machine's, such as PNG has it: the same in this one's.
std::optional<Image> in_host_order(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = format_of(frame);
    const bool is_big = (format.flags & AV_PIX_FMT_FLAG_BE) != 0;
    const AVComponentDescriptor& samples = format.comp[0];
    if (format.nb_components != 1 || samples.depth <= 8 || samples.shift != 0 || samples.step != 2 ||
        (format.flags & AV_PIX_FMT_FLAG_FLOAT) != 0 || is_big == (std::endian::native == std::endian::big))
        return std::nullopt;
    Image image = copied({frame.data[0], frame.linesize[0], frame.width, frame.height, 2, 1});
    for (std::size_t k = 0; k < image.samples.size(); k += 2)
        std::swap(image.samples[k], image.samples[k + 1]);
    return image;
}

}  // namespace

std::optional<PicturePart> depth_part(VideoLayout layout, int width, int height, int bar) {
    const bool is_beside = layout == VideoLayout::left || layout == VideoLayout::right;
    if (layout == VideoLayout::alone) return PicturePart{0, 0, width, height};
    int &side = is_beside ? width : height, whole = side;
    if (side <= bar || (side - bar) % 2 != 0) return std::nullopt;
    side = (side - bar) / 2;
    const int second = whole - side;
    switch (layout) {
        case VideoLayout::right:
            return PicturePart{second, 0, width, height};
        case VideoLayout::bottom:
            return PicturePart{0, second, width, height};
        default:
            return PicturePart{0, 0, width, height};
    }
}

PicturePart colour_part(VideoLayout layout, int width, int height, int bar) {
    constexpr std::pair<VideoLayout, VideoLayout> others[] = {{VideoLayout::left, VideoLayout::right},
                                                              {VideoLayout::right, VideoLayout::left},
                                                              {VideoLayout::top, VideoLayout::bottom},
                                                              {VideoLayout::bottom, VideoLayout::top}};
    for (const auto& [depth, colour] : others)
        if (layout == depth) return depth_part(colour, width, height, bar).value_or(PicturePart{});
    return {0, 0, width, height};
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
    return format_of(*frame_).nb_components >= 3 || frame_->format == AV_PIX_FMT_PAL8;
}

int VideoPicture::bits() const {
    return is_rgb8(*frame_) ? 8 : sample_bits(*frame_);
}

Result<Plane> VideoPicture::rgb() {
    if (rgb_) return *rgb_;
    auto made = converter_.converted(*frame_);
    if (!made) return input_error(where_ + ": " + made.error().message);
    const AVFrame& rgb = **made;
    const PlaneView view{rgb.data[0], rgb.linesize[0], rgb.width, rgb.height, 1, 3};
    rgb_ = Plane{view, std::shared_ptr<const AVFrame>(std::move(*made))};
    return *rgb_;
}

Result<Plane> VideoPicture::depth(VideoValues values, const PicturePart& part) {
    if (values == VideoValues::grey) return grey(part);
    if (values == VideoValues::mean) return mean(part);
    auto plane = rgb();
    if (plane) plane->view = part_of(plane->view, part);
    return plane;
}

Result<Plane> VideoPicture::grey(const PicturePart& part) {
    if (is_rgb8(*frame_)) {
        TRY_ASSIGN(const auto all, rgb());
        if (auto grey = as_grey(copied(part_of(all.view, part)))) return plane_from(std::move(*grey));
        return input_error(where_ +
                           ": is in colour, where depth was to be grey (a scene file's video.values can be "
                           "mean, or hue with depth.coding hue)");
    }
    const int bits = sample_bits(*frame_);
    if (const auto samples = luma_samples(*frame_)) return Plane{part_of(*samples, part), frame_, bits};
    if (const auto swapped = in_host_order(*frame_))
        return plane_from(copied(part_of(swapped->view(), part)), bits);
    return input_error(where_ + ": has pixel format " + format_name(*frame_) +
                       ": depth is grey of 8 to 16 bits, YUV, or RGB of 8 bits");
}

/// (R + G + B) / 3, rounded to the nearest.
Result<Plane> VideoPicture::mean(const PicturePart& part) {
    TRY_ASSIGN(const auto all, rgb());
    const PlaneView from = part_of(all.view, part);
    Image to{from.width, from.height, 1, 1, {}};
    to.samples.reserve(static_cast<std::size_t>(from.width) * static_cast<std::size_t>(from.height));
    for (int y = 0; y < from.height; ++y) {
        const std::uint8_t* rgb = from.row(y);
        for (int x = 0; x < from.width; ++x, rgb += 3)
            to.samples.push_back(static_cast<std::uint8_t>((rgb[0] + rgb[1] + rgb[2] + 1) / 3));
    }
    return plane_from(std::move(to));
}

CodeRange VideoPicture::code_range(VideoValues values) const {
    const CodeRange full{0, (1 << bits()) - 1};
    const bool is_luma = values == VideoValues::grey && has_colours() && !is_rgb8(*frame_);
    const std::string name = format_name(*frame_);
    if (!is_luma || frame_->color_range == AVCOL_RANGE_JPEG || name.starts_with("yuvj")) return full;
    const int scale = 1 << (bits() - 8);
    const CodeRange limited{16 * scale, 235 * scale};
    if (frame_->color_range == AVCOL_RANGE_MPEG) return limited;
    // Full grey that was encoded as luma often comes without a word on its range.
    const auto samples = luma_samples(*frame_);
    for (int y = 0; samples && y < samples->height; ++y)
        for (int x = 0; x < samples->width; ++x) {
            const int code = samples->sample(x, y);
            constexpr int ringing = 4;
            if (code < limited.least - ringing * scale || code > limited.most + ringing * scale) return full;
        }
    return limited;
}

}  // namespace touchable
