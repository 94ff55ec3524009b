// SPDX-License-Identifier: Apache-2.0
// Which codecs are read, how our clips set FFmpeg's encoders, and whether another program's track keeps every
// value.
#include "engine/clip/track_codecs.hpp"

#include <zstd.h>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/mpeg4/boxes.hpp"

extern "C" {
#include <libavutil/imgutils.h>
}

namespace touchable {
namespace {

struct ReadCodec {
    AVCodecID id;
    bool lossy;
};

/// What this program writes, and what cameras, Depthkit and editors export.
constexpr std::array read_codecs{ReadCodec{AV_CODEC_ID_FFV1, false},    ReadCodec{AV_CODEC_ID_PNG, false},
                                 ReadCodec{AV_CODEC_ID_FFVHUFF, false}, ReadCodec{AV_CODEC_ID_MJPEG, true},
                                 ReadCodec{AV_CODEC_ID_MPEG4, true},    ReadCodec{AV_CODEC_ID_H264, true},
                                 ReadCodec{AV_CODEC_ID_HEVC, true},     ReadCodec{AV_CODEC_ID_PRORES, true},
                                 ReadCodec{AV_CODEC_ID_VP9, true},      ReadCodec{AV_CODEC_ID_AV1, true},
                                 ReadCodec{AV_CODEC_ID_HAP, true},      ReadCodec{AV_CODEC_ID_VP8, true},
                                 ReadCodec{AV_CODEC_ID_RAWVIDEO, false}};

struct OwnCodec {
    std::uint32_t tag;
    const char* name;
    int version;
};

constexpr std::array own_codecs{
    OwnCodec{MKTAG('T', '3', 'D', 'Z'), "t3dz", 1},
    OwnCodec{rank_zstd_tag, "t3d2", 2},
};

const OwnCodec* own_codec(const AVCodecParameters& stored) {
    return stored.codec_id == AV_CODEC_ID_NONE ? named_in(own_codecs, stored.codec_tag, &OwnCodec::tag)
                                               : nullptr;
}

Error encoder_error(const std::string& what) {
    return internal_error("encoder: " + what);
}

/// How a picture is cut for FFV1: n x n slices, which decode side by side, none over 4 megapixels; 0 if
/// FFmpeg's FFV1 cannot cut it. (It wants at least 2 x 2 slices beyond 352x288, and if a slice would be 1
/// pixel wide or high it writes slice positions that cannot be read back.)
int ffv1_slices(int width, int height) {
    if (width >= 32 && height >= 32) {
        constexpr int largest = 1 << 22;
        int n = 2;
        while (((width + n - 1) / n) * ((height + n - 1) / n) > largest) ++n;
        return n * n;
    }
    if (width > 352 || height > 288) return width >= 4 && height >= 4 ? 4 : 0;
    return width >= 2 && height >= 2 ? 1 : 0;
}

/// Slices cost bytes, and threads are worth waking for large pictures only.
int h264_slices(int width, int height) {
    return std::int64_t{width} * height < 100'000 ? 1 : 4;
}

/// x264's limit, pixels.
constexpr int largest_h264_side = 16384;

struct EncoderSettings {
    const char* encoder;
    const char* name;  // in messages
    std::vector<std::pair<const char*, const char*>> options;
};

EncoderSettings settings_of(TrackCoding coding, AVPixelFormat format) {
    if (coding == TrackCoding::ffv1)
        return {"ffv1", "FFV1", {{"slicecrc", "1"}, {"coder", "1"}, {"context", "1"}}};
    if (is_visual(coding) && !has_x264()) return {"libopenh264", "H.264", {{"rc_mode", "quality"}}};
    // Each picture gives a packet at once; keyframes come only where `encode` asks for them.
    EncoderSettings h264{format == AV_PIX_FMT_RGB24 ? "libx264rgb" : "libx264",
                         "H.264",
                         {{"tune", "zerolatency"}, {"forced-idr", "1"}, {"udu_sei", "1"}}};
    if (is_visual(coding)) {
        const char* const quality = coding == TrackCoding::h264_visual ? "18" : "24";
        // Streams of both qualities have the same parameter sets: VLC keeps those of the first when it
        // switches.
        h264.options.insert(h264.options.end(), {{"x264-params", "keyint=infinite:scenecut=0:stitchable=1"},
                                                 {"preset", "superfast"},
                                                 {"crf", quality}});
    } else {
        h264.options.insert(h264.options.end(), {{"x264-params", "keyint=infinite:scenecut=0"}, {"qp", "0"}});
        h264.options.push_back({"preset", coding == TrackCoding::h264_quick ? "ultrafast" : "superfast"});
    }
    return h264;
}

Result<int> slices_of(TrackCoding coding, int width, int height) {
    if (coding != TrackCoding::ffv1) {
        if (width > largest_h264_side || height > largest_h264_side)
            return unstorable_size(width, height, "H.264 takes sides of 16384 at most");
        return h264_slices(width, height);
    }
    const int slices = ffv1_slices(width, height);
    if (slices == 0)
        return unstorable_size(
            width, height,
            "FFV1 needs sides of at least 2 pixels, and of 4 where one is over 352 wide or 288 high");
    return slices;
}

using mpeg4::BitReader;
using ParameterBytes = std::span<const std::uint8_t>;

/// Reads transform bypass from the sequence parameters in avcC (ISO/IEC 14496-10, 7.3.2.1.1).
bool is_lossless_h264(ParameterBytes avcc) {
    constexpr std::size_t sequence_at = 8;
    constexpr std::uint64_t high_444_predictive = 244, colours_at_full_size = 3;
    if (avcc.size() <= sequence_at) return false;
    BitReader bits(avcc.subspan(sequence_at));
    bits.get(8);
    if (bits.get(8) != high_444_predictive) return false;
    bits.get(16);
    bits.golomb();
    if (bits.golomb() == colours_at_full_size) bits.get(1);
    bits.golomb();
    bits.golomb();
    const bool leaves_out_transform = bits.flag();
    return leaves_out_transform && !bits.is_over();
}

/// The first unit of this kind in hvcC (ISO/IEC 14496-15, 8.3.3.1.2).
std::optional<ParameterBytes> hevc_unit(ParameterBytes hvcc, int kind) {
    std::size_t at = 22;
    const auto number = [&](std::size_t bytes) {
        std::size_t value = 0;
        for (; bytes > 0; --bytes, ++at) value = value << 8 | (at < hvcc.size() ? hvcc[at] : 0);
        return value;
    };
    for (std::size_t lists = number(1); lists > 0; --lists) {
        const bool is_wanted = static_cast<int>(number(1) & 63) == kind;
        for (std::size_t units = number(2); units > 0; --units) {
            const std::size_t length = number(2);
            if (at > hvcc.size() || length > hvcc.size() - at) return {};
            if (is_wanted) return hvcc.subspan(at, length);
            at += length;
        }
    }
    return {};
}

/// transquant_bypass_enabled_flag of the pictures' parameters (ISO/IEC 23008-2, 7.3.2.3.1). x265 also sets it
/// if only some blocks are lossless; its message in hvcC tells.
bool is_lossless_hevc(ParameterBytes hvcc) {
    constexpr int picture_parameters = 34;
    const std::string_view words(reinterpret_cast<const char*>(hvcc.data()), hvcc.size());
    if (words.find(" no-lossless") != std::string_view::npos) return false;
    const auto unit = hevc_unit(hvcc, picture_parameters);
    if (!unit) return false;
    BitReader bits(*unit);
    bits.get(16);  // the unit's header
    bits.golomb();  // ids of picture and sequence parameters
    bits.golomb();
    bits.get(7);  // dependent slices, output flag, 3 extra bits, hidden signs, cabac_init
    for (int number = 0; number < 3; ++number) bits.golomb();  // references of two lists, quantiser
    bits.get(2);                                              // constrained intra, skipped transforms
    if (bits.flag()) bits.golomb();                           // a quantiser for each block
    bits.golomb();                                            // offsets for colour
    bits.golomb();
    bits.get(3);  // offsets for each slice, weights
    const bool leaves_out_transform = bits.flag();
    return leaves_out_transform && !bits.is_over();
}

/// The head, if the packet states that it holds this many samples.
std::optional<RankHead> head_of(std::span<const std::uint8_t> packet, RankZstdDecoder::Version version,
                                std::size_t samples) {
    const auto head =
        version == RankZstdDecoder::Version::second ? rank_head(packet, samples) : std::optional(RankHead{});
    if (!head) return std::nullopt;
    const auto frame = packet.subspan(head->bytes);
    const bool is_so = ZSTD_getFrameContentSize(frame.data(), frame.size()) == head->content(samples);
    return is_so ? head : std::nullopt;
}

}  // namespace

std::string codec_name(const AVCodecParameters& stored) {
    if (const OwnCodec* const own = own_codec(stored)) return own->name;
    if (stored.codec_id != AV_CODEC_ID_NONE || stored.codec_tag == 0)
        return avcodec_get_name(stored.codec_id);
    char text[AV_FOURCC_MAX_STRING_SIZE];
    return av_fourcc_make_string(text, stored.codec_tag);
}

std::optional<int> rank_zstd_version(const AVCodecParameters& stored) {
    const OwnCodec* const own = own_codec(stored);
    return own ? std::optional(own->version) : std::nullopt;
}

std::optional<ClipNote> lossy_note(PlaneRole role, const std::string& codec) {
    const auto is_stored = [&](const ReadCodec& one) { return codec == avcodec_get_name(one.id); };
    const auto* const stored = std::ranges::find_if(read_codecs, is_stored);
    if (role == PlaneRole::colour || stored == read_codecs.end() || !stored->lossy) return std::nullopt;
    return ClipNote(role, "stored as " + codec +
                              ", which changes values: what is felt is not quite what was recorded (ffv1, "
                              "png and t3d2 keep every value)");
}

Result<void> check_is_read(const AVCodecParameters& stored, const std::string& where) {
    if (own_codec(stored) || named_in(read_codecs, stored.codec_id, &ReadCodec::id)) return {};
    std::string names;
    for (const ReadCodec& codec : read_codecs) names += std::string(avcodec_get_name(codec.id)) + ", ";
    return input_error(where + ": has codec " + codec_name(stored) + ": must be one of " + names +
                       own_codecs[0].name + ", " + own_codecs[1].name);
}

bool has_x264() {
    return avcodec_find_encoder_by_name("libx264") && avcodec_find_encoder_by_name("libx264rgb");
}

Result<void> check_x264(const std::string& what) {
    if (has_x264()) return {};
    return usage_error(what + " needs libx264, which this FFmpeg was built without; NAME.mkv does not");
}

Result<CodecPtr> open_encoder(TrackCoding coding, AVPixelFormat format, int width, int height,
                              const FrameRate& rate) {
    const EncoderSettings settings = settings_of(coding, format);
    const AVCodec* codec = avcodec_find_encoder_by_name(settings.encoder);
    if (!codec)
        return encoder_error("this FFmpeg has no " + std::string(settings.name) + " (" + settings.encoder +
                             ")");
    TRY_ASSIGN(const auto slices, slices_of(coding, width, height));
    if (av_image_check_size(static_cast<unsigned>(width), static_cast<unsigned>(height), 0, nullptr) < 0)
        return unstorable_size(width, height, "FFmpeg takes no more than some 16384x16128 pixels");
    CodecPtr context(avcodec_alloc_context3(codec));
    if (!context) return encoder_error("out of memory");
    context->width = width;
    context->height = height;
    context->pix_fmt = format;
    context->time_base = {static_cast<int>(rate.den), static_cast<int>(rate.num)};
    context->framerate = {static_cast<int>(rate.num), static_cast<int>(rate.den)};
    context->slices = slices;
    context->thread_count = 1;
    context->flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_GLOBAL_HEADER;
    const bool seen = is_visual(coding);  // shown by ordinary players
    context->color_range = seen ? AVCOL_RANGE_MPEG : AVCOL_RANGE_JPEG;
    if (seen) {
        context->colorspace = AVCOL_SPC_BT709;
        context->color_primaries = AVCOL_PRI_BT709;
        context->color_trc = AVCOL_TRC_BT709;
    }
    if (std::string_view(settings.encoder) == "libopenh264") {
        context->gop_size = std::numeric_limits<int>::max();
        context->qmin = context->qmax = coding == TrackCoding::h264_visual ? 18 : 24;
        context->bit_rate = std::int64_t{100} * width * height;  // never the limit
    }
    if (coding == TrackCoding::ffv1) {
        context->gop_size = 1;
        context->level = 3;
    }
    AVDictionary* options = nullptr;
    for (const auto& [name, value] : settings.options) av_dict_set(&options, name, value, 0);
    const int status = avcodec_open2(context.get(), codec, &options);
    const bool all_taken = av_dict_count(options) == 0;
    av_dict_free(&options);
    if (status < 0 || !all_taken)
        return encoder_error(std::string(settings.name) + ": " +
                             (status < 0 ? ffmpeg_text(status) : "unknown option"));
    return context;
}

ScalerPtr scaler_from_rgb(int from_width, int from_height, AVPixelFormat format, int width, int height,
                          int flags) {
    ScalerPtr scaler(sws_getContext(from_width, from_height, AV_PIX_FMT_RGB24, width, height, format, flags,
                                    nullptr, nullptr, nullptr));
    if (scaler)
        sws_setColorspaceDetails(scaler.get(), sws_getCoefficients(SWS_CS_DEFAULT), 1,
                                 sws_getCoefficients(SWS_CS_ITU709), 0, 0, 1 << 16, 1 << 16);
    return scaler;
}

Error unstorable_size(int width, int height, const std::string& why) {
    return usage_error("pictures of " + size_text(width, height) + " cannot be stored: " + why);
}

bool is_coded_without_loss(const AVCodecParameters& stored) {
    if (stored.extradata == nullptr || stored.extradata_size <= 0) return false;
    const ParameterBytes parameters(stored.extradata, static_cast<std::size_t>(stored.extradata_size));
    if (stored.codec_id == AV_CODEC_ID_H264) return is_lossless_h264(parameters);
    return stored.codec_id == AV_CODEC_ID_HEVC && is_lossless_hevc(parameters);
}

RankEncoder::Compress zstd_at(int level) {
    const std::shared_ptr<ZSTD_CCtx> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
    return [context, level](std::span<const std::uint8_t> from, std::span<std::uint8_t> to) -> std::size_t {
        const std::size_t size =
            context ? ZSTD_compressCCtx(context.get(), to.data(), to.size(), from.data(), from.size(), level)
                    : 0;
        return ZSTD_isError(size) ? 0 : size;
    };
}

bool RankZstdDecoder::promises(std::span<const std::uint8_t> packet, std::size_t samples) const {
    return head_of(packet, version_, samples).has_value();
}

bool RankZstdDecoder::decode(std::span<const std::uint8_t> packet, int width, int height,
                             std::uint16_t* samples, std::ptrdiff_t stride) {
    const std::size_t count = pixel_count(width, height);
    const auto head = head_of(packet, version_, count);
    if (!head) return false;
    if (!context_) context_.reset(ZSTD_createDCtx());
    if (!context_) return false;
    bytes_.resize(head->content(count));
    const auto frame = packet.subspan(head->bytes);
    return ZSTD_decompressDCtx(context_.get(), bytes_.data(), bytes_.size(), frame.data(), frame.size()) ==
               bytes_.size() &&
           take_rank_content(*head, bytes_, width, height, samples, stride);
}

}  // namespace touchable
