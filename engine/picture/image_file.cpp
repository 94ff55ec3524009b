#include "engine/picture/image_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

#include "engine/ffmpeg/ffmpeg.hpp"

namespace touchable {
namespace {

Error file_error(const std::filesystem::path& file, const std::string& what) {
    return input_error(file.string() + ": " + what);
}
Error out_of_memory() {
    return {ErrorKind::internal, "out of memory"};
}

/// What the PNG encoder takes: the plane's samples, those of 16 bits with their high byte first.
Result<FramePtr> png_input(const PlaneView& image) {
    FramePtr frame(av_frame_alloc());
    if (!frame) return out_of_memory();
    frame->width = image.width;
    frame->height = image.height;
    frame->format = image.channels == 3           ? AV_PIX_FMT_RGB24
                    : image.bytes_per_sample == 2 ? AV_PIX_FMT_GRAY16BE
                                                  : AV_PIX_FMT_GRAY8;
    if (av_frame_get_buffer(frame.get(), 0) < 0) return out_of_memory();
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

Result<PacketPtr> encode_png(const AVFrame& frame, PngEffort effort) {
    const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_PNG);
    if (!codec) return Error{ErrorKind::internal, "this FFmpeg has no PNG encoder"};
    CodecPtr encoder(avcodec_alloc_context3(codec));
    PacketPtr packet(av_packet_alloc());
    if (!encoder || !packet) return out_of_memory();
    encoder->width = frame.width;
    encoder->height = frame.height;
    encoder->pix_fmt = static_cast<AVPixelFormat>(frame.format);
    encoder->time_base = {1, 1};
    encoder->thread_count = 1;
    encoder->flags |= AV_CODEC_FLAG_BITEXACT;
    const bool quick = effort == PngEffort::quick;
    if (quick) encoder->compression_level = 3;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "pred", quick ? "up" : "mixed", 0);
    int status = avcodec_open2(encoder.get(), codec, &options);
    av_dict_free(&options);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), &frame);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), nullptr);
    if (status >= 0) status = avcodec_receive_packet(encoder.get(), packet.get());
    if (status < 0) return Error{ErrorKind::internal, "PNG encoder: " + ffmpeg_text(status)};
    return packet;
}

}  // namespace

bool is_grey(const Image& image) {
    if (image.channels == 1) return true;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    for (std::size_t at = 0; at < image.samples.size(); at += 3 * bytes)
        if (std::memcmp(image.samples.data() + at, image.samples.data() + at + bytes, 2 * bytes) != 0)
            return false;
    return true;
}

std::optional<Image> as_grey(const Image& image) {
    if (image.channels == 1) return image;
    if (!is_grey(image)) return std::nullopt;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    Image grey{image.width, image.height, image.bytes_per_sample, 1, {}};
    grey.samples.resize(image.samples.size() / 3);
    const std::uint8_t* from = image.samples.data();
    for (std::size_t at = 0; at < grey.samples.size(); at += bytes, from += 3 * bytes)
        std::memcpy(grey.samples.data() + at, from, bytes);
    return grey;
}

Result<void> write_png_to(const std::filesystem::path& path, const PlaneView& image,
                          const std::filesystem::path& name, PngEffort effort) {
    silence_ffmpeg();
    if (image.empty() || image.width < 1 || image.height < 1 ||
        !(image.channels == 1 || (image.channels == 3 && image.bytes_per_sample == 1)))
        return Error{ErrorKind::internal,
                     name.string() + ": only grey and 8-bit RGB pictures are written as PNG"};
    auto frame = png_input(image);
    if (!frame) return frame.error();
    auto packet = encode_png(**frame, effort);
    if (!packet) return packet.error();
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>((*packet)->data), (*packet)->size);
    out.close();
    if (!out) return file_error(name, std::string("cannot be written: ") + std::strerror(errno));
    return {};
}

Result<void> write_png(NewFile& file, const PlaneView& image) {
    if (auto usable = file.check(); !usable) return usable;
    return write_png_to(file.path(), image, file.target(), PngEffort::thorough);
}

Result<void> write_png(const std::filesystem::path& file, const PlaneView& image) {
    NewFile output(file);
    if (auto written = write_png(output, image); !written) return written;
    return output.commit();
}

}  // namespace touchable
