// SPDX-License-Identifier: Apache-2.0
// Packets into pictures, and pictures into planes: checksums are verified, and codings undone.
#include <algorithm>
#include <thread>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/clip/track_codecs.hpp"
#include "engine/picture/decoding.hpp"

extern "C" {
#include <libavutil/crc.h>
#include <libavutil/intreadwrite.h>
}

namespace touchable {
namespace {

/// Pictures of at least this many pixels are decoded by several threads.
constexpr std::int64_t pixels_for_threads = 100'000;

/// More threads than cores would only delay drawing.
int decoding_threads(const AVCodecParameters& stored, std::size_t tracks) {
    if (std::int64_t{stored.width} * stored.height < pixels_for_threads) return 1;
    const std::size_t cores = std::thread::hardware_concurrency();
    return static_cast<int>(std::clamp<std::size_t>(cores / tracks, 1, 4));
}

class FfmpegDecoder final : public PacketDecoder {
public:
    explicit FfmpegDecoder(CodecPtr codec) : codec_(std::move(codec)) {}
    int send(const AVPacket* packet) override { return avcodec_send_packet(codec_.get(), packet); }
    int receive(AVFrame& picture) override { return avcodec_receive_frame(codec_.get(), &picture); }
    void flush() override { avcodec_flush_buffers(codec_.get()); }
    bool is_one_packet_each() const override {
        return (codec_->codec->capabilities & AV_CODEC_CAP_DELAY) == 0;
    }

private:
    CodecPtr codec_;
};

/// Each packet is a picture of 16 bits.
class RankZstdPackets final : public PacketDecoder {
public:
    RankZstdPackets(RankZstdDecoder::Version version, int width, int height)
        : width_(width), height_(height), decoder_(version) {}
    int send(const AVPacket* packet) override {
        if (decoded_) return AVERROR(EAGAIN);
        ended_ = packet == nullptr;
        if (!packet) return 0;
        const std::size_t samples = pixel_count(width_, height_);
        const std::span<const std::uint8_t> bytes(packet->data, static_cast<std::size_t>(packet->size));
        if (!decoder_.promises(bytes, samples)) return AVERROR_INVALIDDATA;
        FramePtr frame = plane_picture(AV_PIX_FMT_GRAY16, width_, height_);
        if (!frame) return AVERROR(ENOMEM);
        if (!decoder_.decode(bytes, width_, height_, reinterpret_cast<std::uint16_t*>(frame->data[0]),
                             frame->linesize[0] / 2))
            return AVERROR_INVALIDDATA;
        frame->best_effort_timestamp = frame->pts = packet->pts;
        decoded_ = std::move(frame);
        return 0;
    }

    int receive(AVFrame& picture) override {
        if (!decoded_) return ended_ ? AVERROR_EOF : AVERROR(EAGAIN);
        av_frame_move_ref(&picture, decoded_.get());
        decoded_.reset();
        return 0;
    }

    void flush() override {
        decoded_.reset();
        ended_ = false;
    }
    bool is_one_packet_each() const override { return true; }

private:
    const int width_, height_;
    RankZstdDecoder decoder_;
    FramePtr decoded_;  // not yet received
    bool ended_ = false;
};

Error damaged_header(const std::string& where, const std::string& what) {
    return input_error(where + ": its header is damaged: " + what);
}

/// FFmpeg's FFV1 decoder conceals a slice whose checksum fails, so the checksums are verified here. A packet
/// is a chain of slices, each ending in its size (3 bytes), an error status (1) and a CRC parity (4) that
/// brings the CRC-32 of the whole slice to 0 (RFC 9043, 4.8 and 4.9).
bool ffv1_slices_intact(const AVPacket& packet) {
    constexpr int footer = 8;
    const AVCRC* table = av_crc_get_table(AV_CRC_32_IEEE);
    int end = packet.size;
    while (end > 0) {
        if (end < footer) return false;
        const int slice = static_cast<int>(AV_RB24(packet.data + end - footer)) + footer;
        if (slice > end || packet.data[end - footer + 3] != 0) return false;
        if (av_crc(table, 0, packet.data + end - slice, static_cast<std::size_t>(slice)) != 0) return false;
        end -= slice;
    }
    return packet.size > 0;
}

std::string form_text(const AVFrame& frame) {
    return size_text(frame.width, frame.height) + " " + format_name(frame);
}

Error undecodable(const std::string& where, int status) {
    if (status == AVERROR(ENOMEM)) return internal_error(where + ": out of memory");
    return input_error(where + ": is damaged: " + ffmpeg_text(status));
}

}  // namespace

Plane plane_from(FramePtr picture, int bits) {
    const int channels = picture->format == AV_PIX_FMT_RGB24 ? 3 : 1;
    const PlaneView view{picture->data[0],
                         picture->linesize[0],
                         picture->width,
                         picture->height,
                         sample_bits(*picture) > 8 ? 2 : 1,
                         channels};
    return {view, std::shared_ptr<const AVFrame>(std::move(picture)), bits};
}

Result<std::unique_ptr<PacketDecoder>> PacketDecoder::open(const AVStream& stream, const std::string& where,
                                                           std::int64_t most_pixels, std::size_t tracks) {
    const AVCodecParameters& stored = *stream.codecpar;
    if (const auto version = rank_zstd_version(stored)) {
        if (stored.width <= 0 || stored.height <= 0 ||
            std::int64_t{stored.width} * stored.height > most_pixels)
            return damaged_header(where, "it says " + size_text(stored.width, stored.height) + " pixels");
        return std::make_unique<RankZstdPackets>(RankZstdDecoder::Version{*version}, stored.width,
                                                 stored.height);
    }
    const AVCodec* decoder = avcodec_find_decoder(stored.codec_id);
    if (!decoder)
        return input_error(where + ": has codec " + codec_name(stored) + ", which this FFmpeg cannot decode");
    CodecPtr codec(avcodec_alloc_context3(decoder));
    if (!codec) return memory_error();
    int status = avcodec_parameters_to_context(codec.get(), &stored);
    // Threads decode slices of one picture; frame threads would add delay.
    codec->thread_type = FF_THREAD_SLICE;
    codec->thread_count = decoding_threads(stored, tracks);
    codec->pkt_timebase = stream.time_base;
    codec->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
    codec->max_pixels = most_pixels;
    codec->get_buffer2 = give_plane_memory;
    if (status >= 0) status = avcodec_open2(codec.get(), decoder, nullptr);
    if (status < 0) return damaged_header(where, ffmpeg_text(status));
    return std::make_unique<FfmpegDecoder>(std::move(codec));
}

Result<TrackDecoder> TrackDecoder::open(const AVStream& stream, PlaneRole role, const std::string& file,
                                        std::size_t tracks) {
    TrackDecoder track;
    track.role_ = role;
    track.file_ = file;
    track.info_.role = role_name(role);
    track.info_.codec = codec_name(*stream.codecpar);
    const std::string where = file + ": track " + track.info_.role;
    TRY(check_is_read(*stream.codecpar, where));
    TRY_ASSIGN(track.decoder_, PacketDecoder::open(stream, where, PacketDecoder::largest_picture, tracks));
    track.codec_ = stream.codecpar->codec_id;
    // Versions 0 and 1 have neither a header of their own nor checksums.
    track.has_slice_checksums_ = track.codec_ == AV_CODEC_ID_FFV1 && stream.codecpar->extradata_size > 0;
    track.pixels_ = std::int64_t{stream.codecpar->width} * stream.codecpar->height;
    TRY(track.read_tags(stream));
    return track;
}

Result<void> TrackDecoder::read_tags(const AVStream& stream) {
    says_lossless_ = av_dict_get(stream.metadata, clip_tags::lossless_tag, nullptr, 0) != nullptr;
    const AVDictionaryEntry* tag = av_dict_get(stream.metadata, clip_tags::bits_tag, nullptr, 0);
    if (!tag && codec_ != AV_CODEC_ID_NONE) return {};
    if (role_ != PlaneRole::depth && role_ != PlaneRole::height)
        return input_error(
            name() +
            ": is stored as depth and height are (tag T3D_BITS, or codec t3dz or t3d2): must not be");
    const auto bits = tag ? clip_tags::parse_bits(tag->value) : std::nullopt;
    if (!bits)
        return input_error(name() + ": its tag T3D_BITS is " + (tag ? in_quotes(tag->value) : "missing") +
                           ": must be a whole number from 9 to 16");
    stated_bits_ = *bits;
    return {};
}

/// Number of frames for which this packet's picture stays; an error if the packet is damaged.
Result<std::int64_t> TrackDecoder::frames_of(const AVPacket& packet) {
    const auto addition = block_addition_of(packet);
    if (!has_additions_) {
        has_additions_ = addition.has_value();
        // Other programs keep the tag of a track that they re-encode, but not its packets' additions.
        info_.lossless = says_lossless_ && *has_additions_;
    }
    bool sound = (packet.flags & AV_PKT_FLAG_CORRUPT) == 0 && addition.has_value() == *has_additions_;
    if (addition) sound = sound && addition->sound;
    if (!addition && codec_ == AV_CODEC_ID_NONE) sound = false;  // its only checksum
    if (!addition && has_slice_checksums_) sound = sound && ffv1_slices_intact(packet);
    if (sound) return addition ? addition->frames : 1;
    return input_error(where() + ": is damaged: its checksum is missing or wrong");
}

Result<TrackDecoder::Picture> TrackDecoder::skip(const AVPacket& packet) {
    TRY_ASSIGN(const auto frames, frames_of(packet));
    received_ += frames;
    return Picture{received_ - frames, frames, packet.pts, {}};
}

void TrackDecoder::restart(std::int64_t number) {
    decoder_->flush();
    frames_.clear();
    received_ = number;
    drained_ = false;
}

Result<void> TrackDecoder::send(const AVPacket* packet) {
    if (packet) {
        TRY_ASSIGN(const auto frames, frames_of(*packet));
        frames_.push_back(frames);
    }
    const int status = decoder_->send(packet);
    if (status < 0) return undecodable(where(), status);
    drained_ = packet == nullptr;
    return {};
}

Result<FramePtr> TrackDecoder::decoded() {
    FramePtr frame(av_frame_alloc());
    if (!frame) return memory_error();
    const int status = decoder_->receive(*frame);
    if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return FramePtr{};
    if (status < 0) return undecodable(where(), status);
    if (frame->decode_error_flags != 0 || (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0)
        return input_error(where() + ": is damaged");
    TRY(check_format(*frame));
    return frame;
}

/// Number of frames for which the picture just decoded stays.
std::int64_t TrackDecoder::passed() {
    std::int64_t frames = 1;
    if (!frames_.empty()) {
        frames = frames_.front();
        frames_.pop_front();
    }
    received_ += frames;
    return frames;
}

Result<std::optional<TrackDecoder::Decoded>> TrackDecoder::receive_frame() {
    TRY_ASSIGN(auto frame, decoded());
    if (!frame) return std::optional<Decoded>{};
    passed();
    const std::int64_t timestamp = frame->best_effort_timestamp;
    return std::optional(Decoded{timestamp, std::move(frame)});
}

Result<std::optional<TrackDecoder::Picture>> TrackDecoder::receive() {
    TRY_ASSIGN(FramePtr frame, decoded());
    if (!frame) return std::optional<Picture>{};
    const std::int64_t timestamp = frame->best_effort_timestamp;
    TRY_ASSIGN(auto made, plane(std::move(frame)));
    const std::int64_t frames = passed();
    return std::optional(Picture{received_ - frames, frames, timestamp, std::move(made)});
}

Result<void> TrackDecoder::check_format(const AVFrame& frame) {
    if (format_.empty()) {
        format_ = format_name(frame);
        info_.width = frame.width;
        info_.height = is_split() ? frame.height / 2 : frame.height;
        info_.pixel_format = format_;
        if (stated_bits_ > 0)
            info_.pixel_format =
                std::to_string(stated_bits_) + (is_split() ? " bits in two halves" : " bits");
        coded_height_ = frame.height;
    }
    if (frame.width == info_.width && frame.height == coded_height_ && format_name(frame) == format_)
        return {};
    return input_error(where() + ": is " + form_text(frame) + ", but the track began as " +
                       size_text(info_.width, coded_height_) + " " + format_);
}

/// Joins a picture of high bytes above low bytes.
Result<Plane> TrackDecoder::joined(const AVFrame& frame) const {
    const auto bytes = luma_samples(frame);
    if (!bytes || bytes->bytes_per_sample != 1 || frame.height % 2 != 0)
        return input_error(where() + ": is " + form_text(frame) + "; with the tag T3D_BITS, " + info_.role +
                           " is grey of 8 bits, the high bytes above the low ones");
    PlaneView high = *bytes;
    high.height /= 2;
    PlaneView low = high;
    low.data = bytes->row(high.height);
    FramePtr joined = joined_bytes(high, low);
    if (!joined) return memory_error();
    return plane_from(std::move(joined), stated_bits_);
}

Result<Plane> TrackDecoder::rgb(const AVFrame& frame) {
    auto rgb = converter_.converted(frame);
    if (!rgb) return input_error(where() + ": " + rgb.error().message);
    return plane_from(std::move(*rgb));
}

Result<Plane> TrackDecoder::plane(FramePtr frame) {
    const bool one_channel = role_ == PlaneRole::depth || role_ == PlaneRole::height;
    if (one_channel && is_split()) return joined(*frame);
    if (role_ == PlaneRole::depth && is_rgb8(*frame)) return rgb(*frame);
    if (one_channel) {
        const int bits = stated_bits_ > 0 ? stated_bits_ : sample_bits(*frame);
        const auto samples = luma_samples(*frame);
        if (!samples)
            return input_error(where() + ": has pixel format " + info_.pixel_format + "; " + info_.role +
                               " is grey of 8 to 16 bits" +
                               (role_ == PlaneRole::depth ? ", or RGB of 8 bits for hue" : ""));
        return Plane{*samples, std::shared_ptr<const AVFrame>(std::move(frame)), bits};
    }
    if (const auto grey = grey_samples(*frame))
        return Plane{*grey, std::shared_ptr<const AVFrame>(std::move(frame))};
    if (role_ == PlaneRole::haptic && !is_rgb8(*frame))
        return input_error(where() + ": has pixel format " + info_.pixel_format +
                           ", which mixes materials; haptic is RGB of 8 bits, such as bgr0 or gbrp, or grey");
    return rgb(*frame);
}

}  // namespace touchable
