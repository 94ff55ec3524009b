#include "engine/picture/decoded_picture.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "engine/picture/packed_rgb.hpp"

namespace touchable {
namespace {

constexpr bool host_is_big_endian = std::endian::native == std::endian::big;

const AVPixFmtDescriptor& descriptor(const AVFrame& frame) {
    return *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
}

Image rgb_of_size(int width, int height) {
    Image image{width, height, 1, 3, {}};
    image.samples.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    return image;
}

std::uint8_t* row_of(Image& image, int y) {
    return image.samples.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) * 3;
}

void move_palette(const AVFrame& frame, const std::uint8_t* from, std::uint8_t* to) {
    for (int x = 0; x < frame.width; ++x, to += 3) {
        std::uint32_t entry;  // 0xAARRGGBB in host order
        std::memcpy(&entry, frame.data[1] + 4 * std::size_t{from[x]}, 4);
        for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>(entry >> (16 - 8 * c));
    }
}

std::optional<PlaneView> first_plane(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = descriptor(frame);
    const AVComponentDescriptor& samples = format.comp[0];
    const int bytes = samples.depth > 8 ? 2 : 1;
    constexpr std::uint64_t other = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BITSTREAM |
                                    AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_BAYER;
    const bool big_endian = (format.flags & AV_PIX_FMT_FLAG_BE) != 0;
    if ((format.flags & other) != 0 || (bytes == 2 && big_endian != host_is_big_endian)) return std::nullopt;
    if (samples.plane != 0 || samples.offset != 0 || samples.step != bytes || samples.shift != 0 ||
        samples.depth < 8 || samples.depth > 16)
        return std::nullopt;
    return PlaneView{frame.data[0], frame.linesize[0], frame.width, frame.height, bytes, 1};
}

}  // namespace

std::string format_name(const AVFrame& frame) {
    const char* name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
    return name ? name : "unknown";
}

int sample_bits(const AVFrame& frame) {
    return descriptor(frame).comp[0].depth;
}

bool is_rgb8(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = descriptor(frame);
    if (frame.format == AV_PIX_FMT_PAL8) return true;
    if ((format.flags & AV_PIX_FMT_FLAG_RGB) == 0 || format.nb_components < 3) return false;
    if ((format.flags & (AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BAYER |
                         AV_PIX_FMT_FLAG_FLOAT)) != 0)
        return false;
    for (int c = 0; c < 3; ++c)
        if (format.comp[c].depth != 8 || format.comp[c].shift != 0) return false;
    return true;
}

std::optional<PlaneView> grey_samples(const AVFrame& frame) {
    return descriptor(frame).nb_components == 1 ? first_plane(frame) : std::nullopt;
}

std::optional<PlaneView> luma_samples(const AVFrame& frame) {
    return first_plane(frame);
}

Image joined_bytes(const PlaneView& high, const PlaneView& low, int low_bits) {
    const std::size_t row_bytes = static_cast<std::size_t>(high.width) * 2;
    Image image{high.width, high.height, 2, 1, {}};
    image.samples.resize(row_bytes * static_cast<std::size_t>(high.height));
    for (int y = 0; y < high.height; ++y) {
        const std::uint8_t *above = high.row(y), *below = low.row(y);
        std::uint8_t* to = image.samples.data() + row_bytes * static_cast<std::size_t>(y);
        for (int x = 0; x < high.width; ++x) {
            const auto sample = static_cast<std::uint16_t>(above[x] << low_bits | below[x]);
            std::memcpy(to + 2 * x, &sample, 2);
        }
    }
    return image;
}

void move_rgb_row(const AVFrame& frame, int y, std::uint8_t* rgb) {
    static const VectorUnit unit = usable_vector_units().front();
    std::array<const std::uint8_t*, 3> from{};
    std::array<int, 3> places{}, steps{};
    for (int c = 0; c < 3; ++c) {
        const AVComponentDescriptor& samples = descriptor(frame).comp[c];
        const auto n = static_cast<std::size_t>(c);
        from[n] = frame.data[samples.plane] + std::ptrdiff_t{frame.linesize[samples.plane]} * y;
        places[n] = samples.offset;
        steps[n] = samples.step;
    }
    if (frame.format == AV_PIX_FMT_PAL8) return move_palette(frame, from[0], rgb);
    if (steps == std::array{1, 1, 1}) return join_channels(unit, from, frame.width, rgb);
    if (steps == std::array{4, 4, 4}) return take_channels(unit, from[0], places, frame.width, rgb);
    for (std::size_t c = 0; c < 3; ++c)
        for (int x = 0; x < frame.width; ++x)
            rgb[3 * static_cast<std::size_t>(x) + c] = from[c][steps[c] * x + places[c]];
}

Image rgb_exact(const AVFrame& frame) {
    return rgb_rows(frame, 0, frame.height);
}

Image rgb_rows(const AVFrame& frame, int first, int count) {
    Image image = rgb_of_size(frame.width, count);
    for (int y = 0; y < count; ++y) move_rgb_row(frame, first + y, row_of(image, y));
    return image;
}

void drop_rows(AVFrame& frame, int first, int count) {
    const AVPixFmtDescriptor& format = descriptor(frame);
    const bool has_palette = (format.flags & AV_PIX_FMT_FLAG_PAL) != 0;
    if (format.log2_chroma_h != 0) return;  // rows of other planes are not these
    for (int plane = 0; plane < (has_palette ? 1 : AV_NUM_DATA_POINTERS) && frame.data[plane]; ++plane) {
        const auto stride = static_cast<std::size_t>(std::max(frame.linesize[plane], 0));
        give_back(frame.data[plane] + stride * static_cast<std::size_t>(first),
                  stride * static_cast<std::size_t>(count));
    }
}

}  // namespace touchable
