#include "engine/media/image_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>
#include <utility>

#include "engine/media/decoded_picture.hpp"
#include "engine/media/ffmpeg.hpp"
#include "engine/media/picture_decoder.hpp"
#include "engine/media/stored_image.hpp"

namespace touchable {
namespace {

constexpr std::size_t largest_file = std::size_t{256} << 20;

Error file_error(const std::filesystem::path& file, const std::string& what) {
    return input_error(file.string() + ": " + what);
}
Error out_of_memory() {
    return {ErrorKind::internal, "out of memory"};
}

Error too_large(const std::string& where) {
    return input_error(where + ": is larger than 256 MiB: not a picture this program reads");
}

Image packed_grey(const PlaneView& plane) {
    const auto row_bytes = static_cast<std::size_t>(plane.width * plane.bytes_per_sample);
    Image image{plane.width, plane.height, plane.bytes_per_sample, 1, {}};
    image.samples.resize(row_bytes * static_cast<std::size_t>(plane.height));
    for (int y = 0; y < plane.height; ++y)
        std::memcpy(image.samples.data() + row_bytes * static_cast<std::size_t>(y), plane.row(y), row_bytes);
    return image;
}

/// The grey of formats that `grey_samples` does not see: 16 bits as PNG has them (high byte first), and grey
/// with alpha. Nothing for other formats.
std::optional<Image> grey_of_png(const AVFrame& frame) {
    const bool deep = frame.format == AV_PIX_FMT_GRAY16BE || frame.format == AV_PIX_FMT_YA16BE;
    const bool alpha = frame.format == AV_PIX_FMT_YA8 || frame.format == AV_PIX_FMT_YA16BE;
    if (!deep && !alpha) return std::nullopt;
    const int bytes = deep ? 2 : 1, step = alpha ? 2 * bytes : bytes;
    Image image{frame.width, frame.height, bytes, 1, {}};
    image.samples.resize(static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height) *
                         static_cast<std::size_t>(bytes));
    std::uint8_t* to = image.samples.data();
    for (int y = 0; y < frame.height; ++y) {
        const std::uint8_t* from = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
        for (int x = 0; x < frame.width; ++x, from += step, to += bytes) {
            const auto sample = static_cast<std::uint16_t>(deep ? from[0] << 8 | from[1] : from[0]);
            if (deep)
                std::memcpy(to, &sample, 2);
            else
                *to = from[0];
        }
    }
    return image;
}

Result<Image> image_from(const std::string& where, const AVFrame& frame) {
    if (auto grey = grey_of_png(frame)) return std::move(*grey);
    if (const auto plane = grey_samples(frame)) return packed_grey(*plane);
    const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    if (format.comp[0].depth == 8) {
        auto rgb = rgb_converted(frame);
        return rgb ? std::move(rgb) : input_error(where + ": " + rgb.error().message);
    }
    return input_error(where + ": has pixel format " + format_name(frame) +
                       "; grey of 8 or 16 bits and colour of 8 bits are read");
}

/// FFmpeg spreads grey of 2 and 4 bits over 8.
void gather(Image& image, int bits) {
    const int step = 255 / ((1 << bits) - 1);
    for (std::uint8_t& sample : image.samples) sample = static_cast<std::uint8_t>(sample / step);
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

Result<PacketPtr> encode_png(const AVFrame& frame) {
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
    AVDictionary* options = nullptr;
    av_dict_set(&options, "pred", "mixed", 0);
    int status = avcodec_open2(encoder.get(), codec, &options);
    av_dict_free(&options);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), &frame);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), nullptr);
    if (status >= 0) status = avcodec_receive_packet(encoder.get(), packet.get());
    if (status < 0) return Error{ErrorKind::internal, "PNG encoder: " + ffmpeg_text(status)};
    return packet;
}

}  // namespace

Result<std::string> read_picture_bytes(const std::filesystem::path& file) {
    std::error_code failure;
    const auto size = std::filesystem::file_size(file, failure);
    if (failure) return file_error(file, "cannot be read: " + failure.message());
    if (size == 0) return file_error(file, "is empty");
    if (size > largest_file) return too_large(file.string());
    std::string bytes(static_cast<std::size_t>(size), '\0');
    std::ifstream in(file, std::ios::binary);
    if (!in.read(bytes.data(), static_cast<std::streamsize>(size)))
        return file_error(file, std::string("cannot be read: ") + std::strerror(errno));
    return bytes;
}

Result<StoredImage> read_stored_image(const std::filesystem::path& file) {
    const auto bytes = read_picture_bytes(file);
    if (!bytes) return bytes.error();
    return decode_stored_image(*bytes, file.string());
}

Result<StoredImage> decode_stored_image(std::string_view bytes, const std::string& where) {
    if (bytes.size() > largest_file) return too_large(where);
    const auto picture = decode_picture(bytes, where);
    if (!picture) return picture.error();
    auto image = image_from(where, *picture->frame);
    if (!image) return image.error();
    if (picture->bits < 8) gather(*image, picture->bits);
    return StoredImage{std::move(*image), avcodec_get_name(picture->codec), format_name(*picture->frame),
                       picture->bits, picture->interlaced};
}

Result<Image> read_image(const std::filesystem::path& file) {
    auto stored = read_stored_image(file);
    if (!stored) return stored.error();
    return std::move(stored->image);
}

Result<void> write_png(NewFile& file, const PlaneView& image) {
    silence_ffmpeg();
    if (auto usable = file.check(); !usable) return usable;
    if (image.empty() || image.width < 1 || image.height < 1 ||
        !(image.channels == 1 || (image.channels == 3 && image.bytes_per_sample == 1)))
        return Error{ErrorKind::internal,
                     file.target().string() + ": only grey and 8-bit RGB pictures are written as PNG"};
    auto frame = png_input(image);
    if (!frame) return frame.error();
    auto packet = encode_png(**frame);
    if (!packet) return packet.error();
    std::ofstream out(file.path(), std::ios::binary);
    out.write(reinterpret_cast<const char*>((*packet)->data), (*packet)->size);
    out.close();
    if (!out) return file_error(file.target(), std::string("cannot be written: ") + std::strerror(errno));
    return {};
}

Result<void> write_png(const std::filesystem::path& file, const PlaneView& image) {
    NewFile output(file);
    if (auto written = write_png(output, image); !written) return written;
    return output.commit();
}

}  // namespace touchable
