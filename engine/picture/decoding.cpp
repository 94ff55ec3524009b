// SPDX-License-Identifier: Apache-2.0
#include "engine/picture/decoding.hpp"

extern "C" {
#include <libavutil/imgutils.h>
}

#include <bit>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/scene/plane_memory.hpp"

namespace touchable {

namespace {

std::string_view view_of(const AVPacket& packet) {
    return {reinterpret_cast<const char*>(packet.data), static_cast<std::size_t>(packet.size)};
}

/// PNG or JPEG by its first bytes; AV_CODEC_ID_NONE for anything else.
AVCodecID codec_of(std::string_view bytes) {
    if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return AV_CODEC_ID_PNG;
    if (bytes.starts_with("\xff\xd8\xff")) return AV_CODEC_ID_MJPEG;
    return AV_CODEC_ID_NONE;
}

/// FFmpeg silently fills in what a truncated file lacks. Neither marker can occur inside coded data, so a
/// whole JPEG has an end marker after its last start of a scan; a whole PNG ends with its IEND chunk.
bool is_cut(AVCodecID codec, std::string_view bytes) {
    if (codec == AV_CODEC_ID_PNG) return bytes.find("IEND\xae\x42\x60\x82") == std::string_view::npos;
    const auto end = bytes.rfind("\xff\xd9"), scan = bytes.rfind("\xff\xda");
    return end == std::string_view::npos || scan == std::string_view::npos || end < scan;
}

/// Facts of a PNG's header that its decoder does not give.
struct PngHeader {
    int bits = 8;
    std::uint64_t pixels = 0, bytes = 0;  ///< bytes: unpacked
    bool grey = false, interlaced = false;
    std::optional<std::size_t> colours{};  ///< in its palette
    bool made_after = false;               ///< FFmpeg converts its samples once all are decoded
};

constexpr std::size_t png_signature = 8;

/// The first chunk of these bytes of a PNG, up to its checksum; its name is empty if the chunk is incomplete.
struct PngChunk {
    std::string_view name{}, all{};
    std::size_t length = 0;

    explicit PngChunk(std::string_view png) {
        constexpr std::size_t around = 12;  // its length, its name, a checksum
        length = number_in_bytes(png.substr(0, 4));
        if (png.size() < around || length > png.size() - around) return;
        name = png.substr(4, 4);
        all = png.substr(0, around + length);
    }
};

/// Colours of the palette that FFmpeg takes: the last one before the picture's data.
std::size_t colours_in_palette(std::string_view png) {
    std::size_t colours = 0;
    for (png.remove_prefix(png_signature);;) {
        const PngChunk chunk(png);
        if (chunk.name.empty() || chunk.name == "IDAT") return colours;
        if (chunk.name == "PLTE") colours = chunk.length / 3;
        png.remove_prefix(chunk.all.size());
    }
}

/// Bytes of packed picture data (IDAT).
std::size_t packed_pixels(std::string_view png) {
    std::size_t bytes = 0;
    for (png.remove_prefix(std::min(png_signature, png.size()));;) {
        const PngChunk chunk(png);
        if (chunk.name.empty()) return bytes;
        if (chunk.name == "IDAT") bytes += chunk.length;
        png.remove_prefix(chunk.all.size());
    }
}

/// A packet of these bytes, followed by the zeros that FFmpeg's decoders may read past the end. Leaves out
/// texts and colour profiles of a PNG: they are not needed, and FFmpeg would unpack them, however large.
Result<PacketPtr> packet_of(std::string_view bytes) {
    std::vector<std::string_view> parts;
    std::size_t size = 0;
    const auto take = [&](std::size_t count) {
        parts.push_back(bytes.substr(0, count));
        size += count;
        bytes.remove_prefix(count);
    };
    if (codec_of(bytes) == AV_CODEC_ID_PNG) {
        take(png_signature);
        for (PngChunk chunk(bytes); !chunk.name.empty(); chunk = PngChunk(bytes)) {
            if (chunk.name == "zTXt" || chunk.name == "iTXt" || chunk.name == "iCCP")
                bytes.remove_prefix(chunk.all.size());
            else
                take(chunk.all.size());
        }
    }
    take(bytes.size());
    PacketPtr packet(av_packet_alloc());
    if (!packet || av_new_packet(packet.get(), static_cast<int>(size)) < 0) return memory_error();
    std::uint8_t* to = packet->data;
    for (const std::string_view part : parts) to = std::copy(part.begin(), part.end(), to);
    return packet;
}

PngHeader png_header(std::string_view png) {
    constexpr std::size_t end = 33;  // of signature and IHDR, which comes first
    if (png.size() < end || codec_of(png) != AV_CODEC_ID_PNG) return {};
    const auto byte = [&](std::size_t at) { return static_cast<int>(static_cast<unsigned char>(png[at])); };
    const auto side = [&](std::size_t at) { return number_in_bytes(png.substr(at, 4)); };
    PngHeader header;
    header.bits = byte(24);
    header.pixels = side(16) * side(20);
    constexpr std::uint64_t channels[] = {1, 1, 3, 1, 2, 1, 4};  // by kind of colour
    const auto kind = std::min<std::size_t>(static_cast<std::size_t>(byte(25)), 6);
    const std::uint64_t row_bits = side(16) * channels[kind] * static_cast<std::uint64_t>(header.bits);
    header.bytes = side(20) * (row_bits / 8 + 2);  // a byte before each row says how it was filtered
    header.grey = byte(25) == 0 || byte(25) == 4;
    header.interlaced = byte(28) != 0;
    const bool palette = byte(25) == 3;
    if (palette) header.colours = colours_in_palette(png);
    const bool transparent = png.substr(0, png.find("IDAT")).find("tRNS") != std::string_view::npos;
    header.made_after = header.bits < 8 || (transparent && !palette);
    return header;
}

/// Noise in the memory of a picture's last row before it is decoded: if the data end before that row,
/// FFmpeg's PNG decoder says nothing, and the noise stays.
class LastRow {
public:
    explicit LastRow(std::uint8_t seed) : seed_(seed) {}
    void lay(AVFrame& frame) const {
        for (int k = 0; k < row_bytes(frame); ++k) row_of(frame)[k] = noise(k);
    }
    bool untouched(const AVFrame& frame) const {
        const std::uint8_t* row = row_of(frame);
        for (int k = 0; k < row_bytes(frame); ++k)
            if (row[k] != noise(k)) return false;
        return true;
    }
    static std::vector<std::uint8_t> copy(const AVFrame& frame) {
        return {row_of(frame), row_of(frame) + row_bytes(frame)};
    }

private:
    std::uint8_t noise(int k) const { return static_cast<std::uint8_t>((k * 157 + seed_) ^ (k >> 3)); }
    static std::uint8_t* row_of(const AVFrame& frame) {
        return frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * (frame.height - 1);
    }
    static int row_bytes(const AVFrame& frame) {
        return av_image_get_linesize(static_cast<AVPixelFormat>(frame.format), frame.width, 0);
    }

    std::uint8_t seed_;
};

constexpr std::uint32_t deflate_expansion = 1032;  // times as many bytes, at most

/// Most pixels that these bytes can hold: deflate makes at most 1032 bytes of one, and a block of 8x8 pixels
/// of a JPEG takes at least a bit.
std::int64_t held_pixels(AVCodecID codec, std::string_view bytes) {
    const auto size = static_cast<std::int64_t>(bytes.size());
    if (codec == AV_CODEC_ID_PNG)
        return size * std::int64_t{deflate_expansion} * 8 / std::max(png_header(bytes).bits, 1);
    return size * 8 * 64;
}

/// Allocates a decoder's picture, unless it has more pixels than the file can hold. This is FFmpeg's memory,
/// not plane memory: the picture is gathered into an Image, and drop_rows returns its pages.
class PictureMemory {
public:
    PictureMemory(std::int64_t held_pixels, const LastRow* last_row)
        : held_pixels_(held_pixels), last_row_(last_row) {}
    void serve(AVCodecContext& decoder) {
        decoder.opaque = this;
        decoder.get_buffer2 = [](AVCodecContext* context, AVFrame* frame, int flags) {
            return static_cast<PictureMemory*>(context->opaque)->give(*context, *frame, flags);
        };
    }
    bool is_refused() const { return is_refused_; }

private:
    int give(AVCodecContext& context, AVFrame& frame, int flags) {
        is_refused_ = std::int64_t{context.width} * context.height > held_pixels_;
        if (is_refused_) return AVERROR(EINVAL);
        const int status = avcodec_default_get_buffer2(&context, &frame, flags);
        if (status >= 0 && last_row_) last_row_->lay(frame);
        return status;
    }

    const std::int64_t held_pixels_;
    const LastRow* const last_row_;
    bool is_refused_ = false;
};

Result<FramePtr> decode(const std::string& where, AVCodecID codec_id, const AVPacket& packet,
                        LastRow* last_row) {
    const AVCodec* codec = avcodec_find_decoder(codec_id);
    CodecPtr decoder(avcodec_alloc_context3(codec));
    FramePtr frame(av_frame_alloc());
    if (!codec || !decoder || !frame) return memory_error();
    decoder->thread_count = 1;
    decoder->max_pixels = std::int64_t{16384} * 16384;
    decoder->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
    PictureMemory memory(held_pixels(codec_id, view_of(packet)), last_row);
    memory.serve(*decoder);
    int status = avcodec_open2(decoder.get(), codec, nullptr);
    if (status >= 0) status = avcodec_send_packet(decoder.get(), &packet);
    if (status >= 0) status = avcodec_send_packet(decoder.get(), nullptr);
    if (status >= 0) status = avcodec_receive_frame(decoder.get(), frame.get());
    if (memory.is_refused())
        return input_error(where + ": claims more pixels than its " + std::to_string(packet.size) +
                           " bytes can hold");
    if (status < 0) return input_error(where + ": is damaged: " + ffmpeg_text(status));
    if (frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0)
        return input_error(where + ": is damaged");
    return frame;
}

/// Pixels of the largest picture in a JPEG, times the number of scans. Neither marker can occur inside coded
/// data.
std::uint64_t scanned_pixels(std::string_view jpeg) {
    std::uint64_t pixels = 0, scans = 1;
    for (std::size_t at = 0; (at = jpeg.find('\xff', at)) != std::string_view::npos; ++at) {
        const auto byte = [&](std::size_t k) {
            return at + k < jpeg.size() ? std::uint64_t{static_cast<unsigned char>(jpeg[at + k])} : 0;
        };
        const std::uint64_t marker = byte(1);
        const bool has_size =
            marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (has_size) pixels = std::max(pixels, (byte(5) << 8 | byte(6)) * (byte(7) << 8 | byte(8)));
        scans += marker == 0xda;
    }
    return pixels * scans;
}

/// Whether decoding may take some hundredths of a second or more.
bool takes_long(AVCodecID codec, const AVPacket& packet) {
    constexpr std::uint64_t many = 1 << 23;
    const std::string_view bytes = view_of(packet);
    if (codec != AV_CODEC_ID_PNG) return scanned_pixels(bytes) >= many;
    return std::max<std::uint64_t>(png_header(bytes).bytes, deflate_expansion * packed_pixels(bytes)) >= many;
}

/// FFmpeg decodes a picture in one go, which takes seconds for the largest. A stop does not wait for it.
Result<FramePtr> decode_unless_stopped(const std::string& where, AVCodecID codec, const AVPacket& packet,
                                       std::optional<LastRow> last_row) {
    if (!takes_long(codec, packet)) return decode(where, codec, packet, last_row ? &*last_row : nullptr);
    PacketPtr own(av_packet_clone(&packet));
    if (!own) return memory_error();
    auto frame = unless_stopped([where, codec, packet = std::move(own), last_row]() mutable {
        return decode(where, codec, *packet, last_row ? &*last_row : nullptr);
    });
    if (!frame) return interrupted_error();
    return std::move(*frame);
}

/// Refuses data beyond the pixels, which FFmpeg would unpack, too: even incompressible pixels have hardly
/// more data than their own size.
Result<void> check_packed_pixels(AVCodecID codec, const PngHeader& header, std::string_view bytes,
                                 const std::string& where) {
    constexpr std::size_t always = std::size_t{64} << 10;
    if (codec != AV_CODEC_ID_PNG) return {};
    const std::size_t packed = packed_pixels(bytes);
    if (packed <= 2 * header.bytes + always) return {};
    return input_error(where + ": is damaged: has " + std::to_string(packed) + " bytes of data for " +
                       std::to_string(header.pixels) + " pixels");
}

/// Refuses pixels with a colour beyond the palette's last, which FFmpeg would make black.
Result<void> check_indices(const std::string& where, const AVFrame& frame, std::size_t colours) {
    for (int y = 0; y < frame.height && !stop_requested(); ++y) {
        const std::uint8_t* row = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
        const std::uint8_t* most = std::max_element(row, row + frame.width);
        if (*most >= colours)
            return input_error(where + ": is damaged: a pixel has colour " + std::to_string(*most) +
                               " of its palette, which has " + std::to_string(colours));
    }
    return {};
}

/// Finds PNGs whose data end early: if the last row is the noise, or was converted from samples that may be
/// noise, decodes again over other noise and compares. Decoded rows do not depend on the noise.
Result<FramePtr> decode_png(const std::string& where, const AVPacket& packet, const PngHeader& header) {
    const LastRow noise(1), other(2);
    std::vector<std::uint8_t> last_row;
    {
        auto frame = decode_unless_stopped(where, AV_CODEC_ID_PNG, packet, noise);
        if (!frame || !(header.made_after || noise.untouched(**frame))) return frame;
        last_row = LastRow::copy(**frame);
    }
    auto again = decode_unless_stopped(where, AV_CODEC_ID_PNG, packet, other);
    if (!again || LastRow::copy(**again) == last_row) return again;
    return input_error(where + ": is damaged: its data end before the picture does");
}

constexpr bool host_is_big_endian = std::endian::native == std::endian::big;

void move_palette(const AVFrame& frame, const std::uint8_t* from, std::uint8_t* to) {
    for (int x = 0; x < frame.width; ++x, to += 3) {
        std::uint32_t entry;  // 0xAARRGGBB in host order
        std::memcpy(&entry, frame.data[1] + 4 * std::size_t{from[x]}, 4);
        for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>(entry >> (16 - 8 * c));
    }
}

/// Returns the whole pages of these rows to the system: they may not be read again. The frame must have no
/// other owner.
void drop_rows(AVFrame& frame, int first, int count) {
    const AVPixFmtDescriptor& format = pixel_format_of(frame);
    const bool has_palette = (format.flags & AV_PIX_FMT_FLAG_PAL) != 0;
    if (format.log2_chroma_h != 0) return;  // chroma planes have fewer rows
    for (int plane = 0; plane < (has_palette ? 1 : AV_NUM_DATA_POINTERS) && frame.data[plane]; ++plane) {
        const auto stride = static_cast<std::size_t>(std::max(frame.linesize[plane], 0));
        give_back(frame.data[plane] + stride * static_cast<std::size_t>(first),
                  stride * static_cast<std::size_t>(count));
    }
}

/// Rows copied before their memory is returned, so that a picture is held once and not twice.
constexpr int rows_at_once = 64;

/// A picture whose row y `append(samples, y)` adds at the end.
template <class Append>
Result<Image> gathered(AVFrame& frame, int bytes, int channels, Append&& append) {
    Image image{frame.width, frame.height, bytes, channels, {}};
    image.samples.reserve(pixel_count(frame.width, frame.height) *
                          static_cast<std::size_t>(bytes * channels));
    for (int first = 0; first < frame.height; first += rows_at_once) {
        if (stop_requested()) return interrupted_error();
        const int count = std::min(rows_at_once, frame.height - first);
        for (int y = first; y < first + count; ++y) append(image.samples, y);
        drop_rows(frame, first, count);
    }
    return image;
}

using Samples = std::vector<std::uint8_t>;

auto packed_grey(const PlaneView& plane) {
    return [plane](Samples& to, int y) {
        const auto row_bytes = static_cast<std::ptrdiff_t>(plane.width) * plane.bytes_per_sample;
        to.insert(to.end(), plane.row(y), plane.row(y) + row_bytes);
    };
}

bool is_colour_of_16_bits(const AVFrame& frame) {
    return frame.format == AV_PIX_FMT_RGB48BE || frame.format == AV_PIX_FMT_RGBA64BE;
}

/// The channel of 16-bit red, green and blue that holds numbers.
struct NumbersInColour {
    int channel = 0;
    bool is_all = false;  // they are the same in all three
};

/// The channel with the most values, if the others are the same or masks of few values (EVIMO); the first if
/// each has few, like a frame without depth. Nullopt if they are colours, or at a stop.
std::optional<NumbersInColour> numbers_in_colour(const AVFrame& frame) {
    constexpr std::ptrdiff_t most_of_a_mask = 256, times_as_many = 4, few = 16;
    std::array<std::vector<bool>, 3> seen;
    for (auto& values : seen) values.resize(65536);
    std::array<bool, 3> differs{};  // from the next channel
    const int step = 2 * pixel_format_of(frame).nb_components;
    for (int y = 0; y < frame.height; ++y) {
        if (stop_requested()) return std::nullopt;
        const std::uint8_t* from = frame.data[0] + std::ptrdiff_t{frame.linesize[0]} * y;
        for (int x = 0; x < frame.width; ++x, from += step) {
            std::array<std::size_t, 3> values{};
            for (std::size_t c = 0; c < 3; ++c) {
                values[c] = static_cast<std::size_t>(from[2 * c] << 8 | from[2 * c + 1]);
                seen[c][values[c]] = true;
            }
            for (std::size_t c = 0; c < 3; ++c) differs[c] = differs[c] || values[c] != values[(c + 1) % 3];
        }
    }
    if (std::ranges::none_of(differs, std::identity())) return NumbersInColour{0, true};
    std::array<std::ptrdiff_t, 3> counts{};
    for (std::size_t c = 0; c < 3; ++c) counts[c] = std::ranges::count(seen[c], true);
    const auto most = static_cast<std::size_t>(std::ranges::max_element(counts) - counts.begin());
    if (counts[most] <= few) return NumbersInColour{};
    for (std::size_t c = 0; c < 3; ++c) {
        const bool is_same = c == most || !differs[(c + 1) % 3 == most ? c : most];
        if (!is_same && (counts[c] > most_of_a_mask || times_as_many * counts[c] > counts[most]))
            return std::nullopt;
    }
    return NumbersInColour{static_cast<int>(most)};
}

/// Grey of formats that `grey_samples` does not support: 16 bits as PNG has them (high byte first), grey with
/// alpha, and one channel of colour of 16 bits.
struct GreyOfPng {
    const AVFrame& frame;
    int channel = 0;
    bool is_deep() const {
        return frame.format == AV_PIX_FMT_GRAY16BE || frame.format == AV_PIX_FMT_YA16BE ||
               is_colour_of_16_bits(frame);
    }
    bool is_it() const { return is_deep() || frame.format == AV_PIX_FMT_YA8; }
    void operator()(Samples& to, int y) const {
        const bool deep = is_deep();
        const int step = (deep ? 2 : 1) * pixel_format_of(frame).nb_components;
        const std::uint8_t* from =
            frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y + 2 * channel;
        for (int x = 0; x < frame.width; ++x, from += step) {
            const auto sample = static_cast<std::uint16_t>(deep ? from[0] << 8 | from[1] : from[0]);
            const auto bytes = std::bit_cast<std::array<std::uint8_t, 2>>(sample);
            if (deep)
                to.insert(to.end(), bytes.begin(), bytes.end());
            else
                to.push_back(from[0]);
        }
    }
};

/// Grey of 1 bit, eight pixels a byte, the first one highest.
auto black_and_white(const AVFrame& frame) {
    return [&frame](Samples& to, int y) {
        const std::uint8_t* row = frame.data[0] + static_cast<std::ptrdiff_t>(frame.linesize[0]) * y;
        for (int x = 0; x < frame.width; ++x) to.push_back((row[x / 8] >> (7 - x % 8) & 1) != 0 ? 255 : 0);
    };
}

/// 8-bit RGB; the frame is_rgb8.
auto rgb_of(const AVFrame& frame) {
    return [&frame](Samples& to, int y) {
        to.resize(to.size() + 3 * static_cast<std::size_t>(frame.width));
        move_rgb_row(frame, y, to.data() + to.size() - 3 * static_cast<std::size_t>(frame.width));
    };
}

/// RGB outside plane memory: a GPU may have imported that, and drop_rows would take its pages away.
Result<FramePtr> rgb_to_gather(const AVFrame& frame) {
    FramePtr rgb = blank_picture(AV_PIX_FMT_RGB24, frame.width, frame.height, plane_row_alignment);
    if (!rgb) return memory_error();
    TRY(RgbConverter().convert(frame, *rgb));
    return rgb;
}

/// The alpha of RGBA of 8 bits; empty: it is opaque.
Samples alpha_of(const AVFrame& frame) {
    Samples alpha;
    for (int y = 0; y < frame.height && frame.format == AV_PIX_FMT_RGBA; ++y)
        for (int x = 0; x < frame.width; ++x)
            alpha.push_back(frame.data[0][std::ptrdiff_t{frame.linesize[0]} * y + 4 * x + 3]);
    return std::ranges::all_of(alpha, [](std::uint8_t each) { return each == 255; }) ? Samples() : alpha;
}

/// `channel`: set to the name of the channel read, if there are several.
Result<Image> image_from(const std::string& where, FramePtr frame, std::string& channel) {
    const Error unread = input_error(where + ": has pixel format " + format_name(*frame) +
                                     "; grey of 8 or 16 bits and colour of 8 bits are read");
    if (frame->format == AV_PIX_FMT_MONOBLACK) return gathered(*frame, 1, 1, black_and_white(*frame));
    if (is_colour_of_16_bits(*frame)) {
        const auto numbers = numbers_in_colour(*frame);
        if (stop_requested()) return interrupted_error();
        if (!numbers) return unread;
        constexpr const char* names[] = {"red", "green", "blue"};
        if (!numbers->is_all) channel = names[numbers->channel];
        return gathered(*frame, 2, 1, GreyOfPng{*frame, numbers->channel});
    }
    if (const GreyOfPng grey{*frame}; grey.is_it()) return gathered(*frame, grey.is_deep() ? 2 : 1, 1, grey);
    if (const auto plane = grey_samples(*frame))
        return gathered(*frame, plane->bytes_per_sample, 1, packed_grey(*plane));
    if (sample_bits(*frame) != 8) return unread;
    if (!is_rgb8(*frame)) {
        auto rgb = unless_stopped([frame = std::move(frame)] { return rgb_to_gather(*frame); });
        if (!rgb) return interrupted_error();
        if (!*rgb) return input_error(where + ": " + rgb->error().message);
        frame = std::move(**rgb);
    }
    return gathered(*frame, 1, 3, rgb_of(*frame));
}

/// Undoes FFmpeg's spreading of 1, 2 and 4 bits over 8.
void gather(Image& image, int bits) {
    const int step = 255 / ((1 << bits) - 1);
    until_stopped(image.samples.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k)
            image.samples[k] = static_cast<std::uint8_t>(image.samples[k] / step);
    });
}

}  // namespace

Result<FramePtr> decode_picture(std::string_view bytes, const std::string& where) {
    silence_ffmpeg();
    const AVCodecID codec = codec_of(bytes);
    if (codec == AV_CODEC_ID_NONE) return input_error(where + ": is neither PNG nor JPEG");
    if (is_cut(codec, bytes)) return input_error(where + ": is cut short");
    // FFmpeg skips whatever precedes the header of a PNG, but png_header reads it only in first place.
    if (codec == AV_CODEC_ID_PNG && bytes.substr(0, 16).substr(12) != "IHDR")
        return input_error(where + ": is damaged: a PNG must begin with its header, IHDR");
    const PngHeader header = png_header(bytes);
    TRY(check_packed_pixels(codec, header, bytes, where));
    TRY_ASSIGN(const auto packet, packet_of(bytes));
    TRY_ASSIGN(auto frame, codec == AV_CODEC_ID_PNG
                               ? decode_png(where, *packet, header)
                               : decode_unless_stopped(where, codec, *packet, std::nullopt));
    if (header.colours && frame->format == AV_PIX_FMT_PAL8)
        TRY(check_indices(where, *frame, *header.colours));
    return frame;
}

std::string format_name(const AVFrame& frame) {
    const char* name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(frame.format));
    return name ? name : "unknown";
}

int sample_bits(const AVFrame& frame) {
    return pixel_format_of(frame).comp[0].depth;
}

bool is_rgb8(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = pixel_format_of(frame);
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
    return pixel_format_of(frame).nb_components == 1 ? luma_samples(frame) : std::nullopt;
}

std::optional<PlaneView> luma_samples(const AVFrame& frame) {
    const AVPixFmtDescriptor& format = pixel_format_of(frame);
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

FramePtr joined_bytes(const PlaneView& high, const PlaneView& low, int low_bits) {
    FramePtr joined = plane_picture(AV_PIX_FMT_GRAY16, high.width, high.height);
    if (!joined) return nullptr;
    for (int y = 0; y < high.height; ++y) {
        const std::uint8_t *above = high.row(y), *below = low.row(y);
        std::uint8_t* to = joined->data[0] + std::ptrdiff_t{joined->linesize[0]} * y;
        for (int x = 0; x < high.width; ++x) {
            const auto sample = static_cast<std::uint16_t>(above[x] << low_bits | below[x]);
            std::memcpy(to + 2 * x, &sample, 2);
        }
    }
    return joined;
}

void move_rgb_row(const AVFrame& frame, int y, std::uint8_t* rgb) {
    static const VectorUnit unit = usable_vector_units().front();
    std::array<const std::uint8_t*, 3> from{};
    std::array<int, 3> places{}, steps{};
    for (int c = 0; c < 3; ++c) {
        const AVComponentDescriptor& samples = pixel_format_of(frame).comp[c];
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
    Image image{frame.width, frame.height, 1, 3, {}};
    image.samples.reserve(3 * pixel_count(frame.width, frame.height));
    for (int y = 0; y < frame.height; ++y) rgb_of(frame)(image.samples, y);
    return image;
}

Result<StoredImage> decode_coded_image(std::string_view bytes, const std::string& where) {
    TRY_ASSIGN(auto frame, decode_picture(bytes, where));
    const PngHeader header = png_header(bytes);
    StoredImage stored;
    stored.codec = avcodec_get_name(codec_of(bytes));
    stored.pixel_format = format_name(*frame);
    stored.bits = header.grey ? header.bits : 8;
    stored.interlaced = header.interlaced;
    stored.alpha = alpha_of(*frame);
    std::string channel;
    TRY_ASSIGN(stored.image, image_from(where, std::move(frame), channel));
    if (!channel.empty()) stored.beside = std::make_shared<BesideDepth>(BesideDepth{.depth_name = channel});
    if (stored.bits < 8) gather(stored.image, stored.bits);
    if (stop_requested()) return interrupted_error();
    return stored;
}

Result<Image> decode_indices(std::string_view bytes, const std::string& where) {
    TRY_ASSIGN(const auto frame, decode_picture(bytes, where));
    if (codec_of(bytes) == AV_CODEC_ID_PNG && frame->format == AV_PIX_FMT_PAL8)
        return gathered(*frame, 1, 1,
                        packed_grey({frame->data[0], frame->linesize[0], frame->width, frame->height, 1, 1}));
    TRY_ASSIGN(auto stored, decode_coded_image(bytes, where));
    const Image& image = stored.image;
    if (stored.codec != "png" || image.channels != 1 || image.bytes_per_sample != 1)
        return input_error(where + ": must be a PNG of indices, with a palette or grey of up to 8 bits");
    return std::move(stored.image);
}

}  // namespace touchable
