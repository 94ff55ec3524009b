// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/image.hpp"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

#include <sys/mman.h>
#include <unistd.h>
#include <bit>
#include <cerrno>
#include <fstream>
#include <unordered_map>
#include <unordered_set>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/number_pictures.hpp"

namespace touchable {

namespace {

Error file_error(const std::filesystem::path& file, const std::string& what) {
    return input_error(file.string() + ": " + what);
}

/// 8192x8192 pixels as floats, and their headers.
constexpr std::size_t largest_file = std::size_t{257} << 20;

/// P, one of `kinds`, and a character that ends the word.
bool is_netpbm(std::string_view begin, std::string_view kinds) {
    return begin.size() > 2 && begin[0] == 'P' && kinds.find(begin[1]) != std::string_view::npos &&
           std::string_view(" \t\r\n#").find(begin[2]) != std::string_view::npos;
}

Result<StoredImage> refuse_netpbm(std::string_view bytes, const std::string& where) {
    return input_error(where + ": is of Netpbm's kind " + std::string(bytes.substr(0, 2)) +
                       "; P2 and P5 (PGM), P3 and P6 (PPM) and Pf (PFM of one channel) are read");
}

struct PictureKind {
    std::string_view name;
    bool (*is)(std::string_view begin);
    Result<StoredImage> (*decode)(std::string_view bytes, const std::string& where);
};
constexpr PictureKind picture_kinds[] = {
    {"PNG", [](std::string_view begin) { return begin.starts_with("\x89PNG\r\n\x1a\n"); },
     decode_coded_image},
    {"JPEG", [](std::string_view begin) { return begin.starts_with("\xff\xd8\xff"); }, decode_coded_image},
    {"PGM", [](std::string_view begin) { return is_netpbm(begin, "25"); }, decode_netpbm},
    {"PPM", [](std::string_view begin) { return is_netpbm(begin, "36"); }, decode_netpbm},
    {"PFM", [](std::string_view begin) { return is_netpbm(begin, "f"); }, decode_pfm},
    {"dpt", [](std::string_view begin) { return begin.starts_with("PIEH"); }, decode_dpt},
    {"TIFF", is_tiff, decode_tiff},
    {"OpenEXR", is_exr,
     [](std::string_view bytes, const std::string& where) { return decode_exr(bytes, where); }},
    {"npy", is_npy, decode_npy},
    {"npz", is_npz, decode_npz},
    {"HDF5", is_hdf5, refuse_hdf5},
    {"Netpbm", [](std::string_view begin) { return is_netpbm(begin, "147F"); }, refuse_netpbm},
};

const PictureKind* kind_of(std::string_view begin) {
    for (const PictureKind& kind : picture_kinds)
        if (kind.is(begin)) return &kind;
    return nullptr;
}

/// "PNG, JPEG, PGM": the names of all that is read.
std::string kinds_text() {
    std::string text;
    for (const PictureKind& kind : picture_kinds)
        if (kind.decode != refuse_netpbm) text += (text.empty() ? "" : ", ") + std::string(kind.name);
    return text;
}

/// What the PNG encoder takes: the plane's samples, those of 16 bits with their high byte first.
Result<FramePtr> png_input(const PlaneView& image) {
    const AVPixelFormat format = image.channels == 3           ? AV_PIX_FMT_RGB24
                                 : image.bytes_per_sample == 2 ? AV_PIX_FMT_GRAY16BE
                                                               : AV_PIX_FMT_GRAY8;
    FramePtr frame = blank_picture(format, image.width, image.height);
    if (!frame) return memory_error();
    if (image.bytes_per_sample == 1)
        image.copy_rows(frame->data[0], static_cast<std::size_t>(frame->linesize[0]));
    for (int y = 0; y < image.height && image.bytes_per_sample == 2; ++y) {
        std::uint8_t* to = frame->data[0] + static_cast<std::ptrdiff_t>(frame->linesize[0]) * y;
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

/// The colours of a picture of RGB, opaque and ascending, so that neighbours are alike; none if they are too
/// many.
std::vector<std::uint32_t> few_colours(const PlaneView& image) {
    constexpr std::size_t most = 256;
    std::unordered_set<std::uint32_t> found;
    std::uint32_t newest = 0;  // no colour: it is not opaque
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const std::uint32_t colour = colour_at(image.row(y) + std::ptrdiff_t{3} * x);
            if (colour == newest) continue;
            newest = colour;
            found.insert(colour);
            if (found.size() > most) return {};
        }
    std::vector<std::uint32_t> colours(found.begin(), found.end());
    std::ranges::sort(colours);
    return colours;
}

/// The same picture as indices of its colours.
Result<FramePtr> indexed_input(const PlaneView& image, const std::vector<std::uint32_t>& colours) {
    FramePtr frame = blank_picture(AV_PIX_FMT_PAL8, image.width, image.height);
    if (!frame) return memory_error();
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

/// Drops the palette's colours beyond the first `count`: FFmpeg always writes 256.
Result<std::string> with_short_palette(std::string png, std::size_t count) {
    constexpr std::size_t whole = 3 * 256;
    const std::size_t name = png.find("PLTE");
    if (name == std::string::npos || name < 4 || png.size() < name + 8 + whole)
        return internal_error("PNG encoder: it wrote no palette of 256 colours");
    std::string chunk = png.substr(name - 4, 4 + 4 + 3 * count + 4);  // length, name, colours, checksum
    auto* const bytes = reinterpret_cast<std::uint8_t*>(chunk.data());
    AV_WB32(bytes, static_cast<std::uint32_t>(3 * count));
    const AVCRC* const table = av_crc_get_table(AV_CRC_32_IEEE_LE);
    AV_WB32(bytes + 8 + 3 * count, ~av_crc(table, ~std::uint32_t{0}, bytes + 4, 4 + 3 * count));
    png.replace(name - 4, 4 + 4 + whole + 4, chunk);
    return png;
}

/// One picture by an encoder of FFmpeg, which `set` sets up.
Result<std::string> encode_picture(AVCodecID id, const AVFrame& frame,
                                   const std::function<void(AVCodecContext&, AVDictionary*&)>& set) {
    const AVCodec* codec = avcodec_find_encoder(id);
    if (!codec) return internal_error(std::string("this FFmpeg has no encoder of ") + avcodec_get_name(id));
    CodecPtr encoder(avcodec_alloc_context3(codec));
    PacketPtr packet(av_packet_alloc());
    if (!encoder || !packet) return memory_error();
    encoder->width = frame.width;
    encoder->height = frame.height;
    encoder->pix_fmt = static_cast<AVPixelFormat>(frame.format);
    encoder->time_base = {1, 1};
    encoder->thread_count = 1;
    encoder->flags |= AV_CODEC_FLAG_BITEXACT;
    AVDictionary* options = nullptr;
    set(*encoder, options);
    int status = avcodec_open2(encoder.get(), codec, &options);
    av_dict_free(&options);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), &frame);
    if (status >= 0) status = avcodec_send_frame(encoder.get(), nullptr);
    if (status >= 0) status = avcodec_receive_packet(encoder.get(), packet.get());
    if (status < 0)
        return internal_error(std::string("encoder of ") + avcodec_get_name(id) + ": " + ffmpeg_text(status));
    return std::string(reinterpret_cast<const char*>(packet->data), static_cast<std::size_t>(packet->size));
}

Result<std::string> encode_png(const AVFrame& frame, PngEffort effort) {
    return encode_picture(AV_CODEC_ID_PNG, frame, [&](AVCodecContext& encoder, AVDictionary*& options) {
        // Without it FFmpeg writes pHYs of 0:1, an invalid shape.
        encoder.sample_aspect_ratio = {1, 1};
        const bool quick = effort == PngEffort::quick;
        if (quick) encoder.compression_level = 3;
        const bool is_indexed = frame.format == AV_PIX_FMT_PAL8;  // no index predicts the next
        av_dict_set(&options, "pred", is_indexed ? "none" : quick ? "up" : "mixed", 0);
    });
}

}  // namespace

Image blank_image(int width, int height, int bytes_per_sample, int channels) {
    Image image{width, height, bytes_per_sample, channels, {}};
    image.samples.resize(image.view().bytes());
    return image;
}

Image packed_image(const PlaneView& view) {
    Image image = blank_image(view.width, view.height, view.bytes_per_sample, view.channels);
    view.copy_rows(image.samples.data(), view.row_bytes());
    return image;
}

void give_back(void* memory, std::size_t bytes) {
    static const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto begin = std::bit_cast<std::uintptr_t>(memory);
    const auto first_page = (begin + page - 1) / page * page, last_page = (begin + bytes) / page * page;
    if (first_page < last_page)
        madvise(std::bit_cast<void*>(first_page), last_page - first_page, MADV_DONTNEED);
}

bool is_grey(const Image& image) {
    if (image.channels == 1) return true;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    bool grey = true;
    const bool all_seen =
        until_stopped(image.samples.size() / (3 * bytes), [&](std::size_t first, std::size_t last) {
            const std::uint8_t* at = image.samples.data() + 3 * bytes * first;
            for (std::size_t k = first; k < last && grey; ++k, at += 3 * bytes)
                grey = std::memcmp(at, at + bytes, 2 * bytes) == 0;
        });
    return grey && all_seen;
}

std::optional<Image> as_grey(const Image& image) {
    if (image.channels == 1) return image;
    if (!is_grey(image)) return std::nullopt;
    const auto bytes = static_cast<std::size_t>(image.bytes_per_sample);
    Image grey{image.width, image.height, image.bytes_per_sample, 1, {}};
    grey.samples.resize(image.samples.size() / 3);
    const bool all_copied =
        until_stopped(grey.samples.size() / bytes, [&](std::size_t first, std::size_t last) {
            for (std::size_t k = first; k < last; ++k)
                std::memcpy(grey.samples.data() + k * bytes, image.samples.data() + 3 * k * bytes, bytes);
        });
    return all_copied ? std::optional(std::move(grey)) : std::nullopt;
}

Result<void> write_png_to(const std::filesystem::path& path, const PlaneView& image,
                          const std::filesystem::path& name, PngEffort effort, PngColours colours) {
    TRY_ASSIGN(const auto png, error_at(name.string(), png_bytes(image, effort, colours)));
    std::ofstream out(path, std::ios::binary);
    out << png;
    out.close();
    if (!out) return file_error(name, std::string("cannot be written: ") + std::strerror(errno));
    return {};
}

Result<void> write_png(NewFile& file, const PlaneView& image, PngColours colours) {
    TRY(file.check());
    return write_png_to(file.path(), image, file.target(), PngEffort::thorough, colours);
}

Result<void> write_png(const std::filesystem::path& file, const PlaneView& image) {
    NewFile output(file);
    TRY(write_png(output, image));
    return output.commit();
}

Result<std::string> exr_bytes(std::span<const float> samples, int width, int height) {
    FramePtr frame = blank_picture(AV_PIX_FMT_GRAYF32, width, height);
    if (!frame) return memory_error();
    const auto row_bytes = static_cast<std::size_t>(width) * sizeof(float);
    for (int y = 0; y < height; ++y)
        std::memcpy(frame->data[0] + static_cast<std::ptrdiff_t>(frame->linesize[0]) * y,
                    samples.data() + pixel_place(0, y, width), row_bytes);
    return encode_picture(AV_CODEC_ID_EXR, *frame, [](AVCodecContext&, AVDictionary*& options) {
        av_dict_set(&options, "compression", "zip16", 0);
        av_dict_set(&options, "format", "float", 0);
    });
}

std::string_view picture_kind(std::string_view begin) {
    const PictureKind* kind = kind_of(begin);
    return kind ? kind->name : std::string_view();
}

Result<void> check_picture_size(std::int64_t width, std::int64_t height, const std::string& where) {
    const auto usable = [](std::int64_t side) { return side >= 1 && side <= largest_picture_side; };
    if (usable(width) && usable(height)) return {};
    return input_error(where + ": is " + size_text(width, height) + " pixels: must be from 1x1 to " +
                       size_text(largest_picture_side, largest_picture_side));
}

Result<void> check_expansion(std::uint64_t unpacked, std::uint64_t packed, const std::string& where) {
    if (unpacked <= (std::uint64_t{64} << 20) || unpacked / 4096 <= packed) return {};
    return input_error(where + ": is damaged: has " + std::to_string(packed) + " bytes for a picture of " +
                       std::to_string(unpacked));
}

Result<std::string> read_picture_bytes(const SourceFile& file) {
    auto bytes = file.read("a picture", largest_file);
    if (bytes && bytes->empty()) return file_error(file.path(), "is empty");
    return bytes;
}

Result<StoredImage> read_stored_image(const SourceFile& file) {
    TRY_ASSIGN(auto bytes, read_picture_bytes(file));
    return decode_stored_image(std::move(bytes), file.string());
}

Result<StoredImage> decode_stored_image(std::string bytes, const std::string& where) {
    if (bytes.size() > largest_file)
        return input_error(where + ": is larger than " + in_bytes(largest_file) +
                           ": not a picture this program reads");
    const PictureKind* kind = kind_of(bytes);
    if (!kind && is_git_lfs_pointer(bytes)) return input_error(where + ": " + git_lfs_words);
    if (!kind) return input_error(where + ": is no picture that is read: " + kinds_text());
    if (kind->decode == decode_coded_image) return decode_coded_image(bytes, where);  // obeys a stop
    return decode_unless_stopped(std::move(bytes), where, kind->decode);
}

Result<StoredImage> decode_unless_stopped(std::string bytes, const std::string& where, DecodePicture decode) {
    constexpr std::size_t quick = 4096;  // bytes: what they unpack to is decoded in a few milliseconds
    if (stop_requested()) return interrupted_error();
    if (bytes.size() <= quick) return decode(bytes, where);
    auto decoded = unless_stopped(
        [bytes = std::move(bytes), where, decode = std::move(decode)] { return decode(bytes, where); });
    return decoded ? std::move(*decoded) : interrupted_error();
}

Result<Image> read_image(const std::filesystem::path& file) {
    TRY_ASSIGN(auto stored, read_stored_image(file));
    if (!stored.values.empty()) return file_error(file, "is a picture of floats: must be of integers here");
    return std::move(stored.image);
}

Result<std::string> png_bytes(const PlaneView& image, PngEffort effort, PngColours colours) {
    silence_ffmpeg();
    if (image.empty() || image.width < 1 || image.height < 1 ||
        !(image.channels == 1 || (image.channels == 3 && image.bytes_per_sample == 1)))
        return internal_error("only grey and 8-bit RGB pictures are written as PNG");
    const bool may_be_indexed = colours == PngColours::indexed_if_few && image.channels == 3;
    const auto few = may_be_indexed ? few_colours(image) : std::vector<std::uint32_t>();
    TRY_ASSIGN(const auto frame, few.empty() ? png_input(image) : indexed_input(image, few));
    auto png = encode_png(*frame, effort);
    return few.empty() || !png ? png : with_short_palette(std::move(*png), few.size());
}

Result<std::string> jpeg_bytes(const PlaneView& image) {
    silence_ffmpeg();
    const int width = image.width, height = image.height;
    const FramePtr frame = blank_picture(AV_PIX_FMT_YUVJ420P, width, height);
    const ScalerPtr scaler(sws_getContext(width, height, AV_PIX_FMT_RGB24, width, height, AV_PIX_FMT_YUVJ420P,
                                          SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr,
                                          nullptr, nullptr));
    if (!frame || !scaler) return memory_error();
    const int stride = static_cast<int>(image.stride);
    sws_scale(scaler.get(), &image.data, &stride, 0, height, frame->data, frame->linesize);
    constexpr int quality = 3;  // of 1, the best, to 31
    frame->quality = quality * FF_QP2LAMBDA;
    return encode_picture(AV_CODEC_ID_MJPEG, *frame, [](AVCodecContext& encoder, AVDictionary*&) {
        encoder.flags |= AV_CODEC_FLAG_QSCALE;
        encoder.global_quality = quality * FF_QP2LAMBDA;
    });
}

}  // namespace touchable
