#include "engine/picture/png_bytes.hpp"

#include <algorithm>
#include <cstring>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/picture/ffmpeg.hpp"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

Error no_room_for_png() {
    return {ErrorKind::internal, "out of memory"};
}

/// What the PNG encoder takes: the plane's samples, those of 16 bits with their high byte first.
Result<FramePtr> png_input(const PlaneView& image) {
    FramePtr frame(av_frame_alloc());
    if (!frame) return no_room_for_png();
    frame->width = image.width;
    frame->height = image.height;
    frame->format = image.channels == 3           ? AV_PIX_FMT_RGB24
                    : image.bytes_per_sample == 2 ? AV_PIX_FMT_GRAY16BE
                                                  : AV_PIX_FMT_GRAY8;
    if (av_frame_get_buffer(frame.get(), 0) < 0) return no_room_for_png();
    for (int y = 0; y < image.height; ++y) {
        std::uint8_t* to = frame->data[0] + static_cast<std::ptrdiff_t>(frame->linesize[0]) * y;
        if (image.bytes_per_sample == 1) {
            std::memcpy(to, image.row(y), static_cast<std::size_t>(image.width * image.channels));
            continue;
        }
        for (int x = 0; x < image.width; ++x) {
            const std::uint16_t sample = image.sample(x, y);
            *to++ = static_cast<std::uint8_t>(sample >> 8);
            *to++ = static_cast<std::uint8_t>(sample & 255);
        }
    }
    return frame;
}

std::uint32_t colour_at(const std::uint8_t* rgb) {
    return 0xFF000000U | std::uint32_t{rgb[0]} << 16 | std::uint32_t{rgb[1]} << 8 | rgb[2];
}

/// The colours of a picture of RGB, opaque and ascending, so that neighbours are alike; none where they are
/// too many.
std::vector<std::uint32_t> few_colours(const PlaneView& image) {
    constexpr std::size_t most = 256;
    std::unordered_set<std::uint32_t> found;
    std::uint32_t newest = 0;  // which is none: it is not opaque
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const std::uint32_t colour = colour_at(image.row(y) + std::ptrdiff_t{3} * x);
            if (colour == newest) continue;
            newest = colour;
            found.insert(colour);
            if (found.size() > most) return {};
        }
    std::vector<std::uint32_t> colours(found.begin(), found.end());
    std::sort(colours.begin(), colours.end());
    return colours;
}

/// The same picture as indices of its colours.
Result<FramePtr> indexed_input(const PlaneView& image, const std::vector<std::uint32_t>& colours) {
    FramePtr frame(av_frame_alloc());
    if (!frame) return no_room_for_png();
    frame->width = image.width;
    frame->height = image.height;
    frame->format = AV_PIX_FMT_PAL8;
    if (av_frame_get_buffer(frame.get(), 0) < 0) return no_room_for_png();
    std::vector<std::uint32_t> palette = colours;
    palette.resize(256, 0xFF000000U);
    std::memcpy(frame->data[1], palette.data(), 4 * palette.size());
    std::unordered_map<std::uint32_t, std::uint8_t> places;
    for (std::size_t k = 0; k < colours.size(); ++k) places[colours[k]] = static_cast<std::uint8_t>(k);
    std::uint32_t newest = colours.front();
    std::uint8_t index = 0;
    for (int y = 0; y < image.height; ++y) {
        std::uint8_t* to = frame->data[0] + static_cast<std::ptrdiff_t>(frame->linesize[0]) * y;
        for (int x = 0; x < image.width; ++x) {
            const std::uint32_t colour = colour_at(image.row(y) + std::ptrdiff_t{3} * x);
            if (colour != newest) index = places[newest = colour];
            to[x] = index;
        }
    }
    return frame;
}

/// FFmpeg writes 256 colours whatever there are: those beyond the first `count` go.
Result<std::string> with_short_palette(std::string png, std::size_t count) {
    constexpr std::size_t whole = 3 * 256;
    const std::size_t name = png.find("PLTE");
    if (name == std::string::npos || name < 4 || png.size() < name + 8 + whole)
        return Error{ErrorKind::internal, "PNG encoder: it wrote no palette of 256 colours"};
    std::string chunk = png.substr(name - 4, 4 + 4 + 3 * count + 4);  // length, name, colours, checksum
    auto* const bytes = reinterpret_cast<std::uint8_t*>(chunk.data());
    AV_WB32(bytes, static_cast<std::uint32_t>(3 * count));
    const AVCRC* const table = av_crc_get_table(AV_CRC_32_IEEE_LE);
    AV_WB32(bytes + 8 + 3 * count, ~av_crc(table, ~std::uint32_t{0}, bytes + 4, 4 + 3 * count));
    png.replace(name - 4, 4 + 4 + whole + 4, chunk);
    return png;
}

Result<std::string> encode_png(const AVFrame& frame, PngEffort effort) {
    const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_PNG);
    if (!codec) return Error{ErrorKind::internal, "this FFmpeg has no PNG encoder"};
    CodecPtr encoder(avcodec_alloc_context3(codec));
    PacketPtr packet(av_packet_alloc());
    if (!encoder || !packet) return no_room_for_png();
    encoder->width = frame.width;
    encoder->height = frame.height;
    encoder->pix_fmt = static_cast<AVPixelFormat>(frame.format);
    encoder->time_base = {1, 1};
    // Without it FFmpeg writes pHYs of 0:1, which is no shape of a pixel.
    encoder->sample_aspect_ratio = {1, 1};
    encoder->thread_count = 1;
    encoder->flags |= AV_CODEC_FLAG_BITEXACT;
    const bool quick = effort == PngEffort::quick;
    if (quick) encoder->compression_level = 3;
    AVDictionary* options = nullptr;
    const bool is_indexed = frame.format == AV_PIX_FMT_PAL8;  // of which no index foretells the next
    av_dict_set(&options, "pred", is_indexed ? "none" : quick ? "up" : "mixed", 0);
    int status = avcodec_open2(encoder.get(), codec, &options);
    av_dict_free(&options);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), &frame);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), nullptr);
    if (status >= 0) status = avcodec_receive_packet(encoder.get(), packet.get());
    if (status < 0) return Error{ErrorKind::internal, "PNG encoder: " + ffmpeg_text(status)};
    return std::string(reinterpret_cast<const char*>(packet->data), static_cast<std::size_t>(packet->size));
}

}  // namespace

Result<std::string> png_bytes(const PlaneView& image, PngEffort effort, PngColours colours) {
    silence_ffmpeg();
    if (image.empty() || image.width < 1 || image.height < 1 ||
        !(image.channels == 1 || (image.channels == 3 && image.bytes_per_sample == 1)))
        return Error{ErrorKind::internal, "only grey and 8-bit RGB pictures are written as PNG"};
    const bool may_be_indexed = colours == PngColours::indexed_if_few && image.channels == 3;
    const auto few = may_be_indexed ? few_colours(image) : std::vector<std::uint32_t>();
    TRY_ASSIGN(const auto frame, few.empty() ? png_input(image) : indexed_input(image, few));
    auto png = encode_png(*frame, effort);
    return few.empty() || !png ? png : with_short_palette(std::move(*png), few.size());
}

}  // namespace touchable
