// SPDX-License-Identifier: Apache-2.0
// Planes into packets: samples laid out as each codec takes them.
#include <algorithm>
#include <cstring>

#include "engine/base/try.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/track_codecs.hpp"

namespace touchable {
namespace {

Error track_error(PlaneRole role, const std::string& what) {
    return internal_error("encoder of track " + std::string(role_name(role)) + ": " + what);
}

/// The codec's input: grey samples of two bytes go into H.264 as two pictures of bytes, one above the other.
struct CodedForm {
    AVPixelFormat format;
    int width, height;
    bool split;
};

CodedForm form_of(TrackCoding coding, const PlaneView& plane) {
    const bool wide = plane.bytes_per_sample == 2;
    if (is_visual(coding)) {
        const bool even = plane.width % 2 == 0 && plane.height % 2 == 0;
        return {even ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV444P, plane.width, plane.height, false};
    }
    if (plane.channels == 3)
        return {coding == TrackCoding::ffv1 ? AV_PIX_FMT_BGR0 : AV_PIX_FMT_RGB24, plane.width, plane.height,
                false};
    return {AV_PIX_FMT_GRAY8, plane.width, plane.height * (wide ? 2 : 1), wide};
}

void copy_rgb_as_bgr0(const std::uint8_t* from, std::uint8_t* to, int width) {
    for (int x = 0; x < width; ++x, from += 3, to += 4) {
        to[0] = from[2];
        to[1] = from[1];
        to[2] = from[0];
        to[3] = 0;
    }
}

/// High bytes above, low bytes below.
void split_bytes(const PlaneView& plane, AVFrame& picture) {
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint8_t* high = picture.data[0] + static_cast<std::ptrdiff_t>(picture.linesize[0]) * y;
        std::uint8_t* low = high + static_cast<std::ptrdiff_t>(picture.linesize[0]) * plane.height;
        for (int x = 0; x < plane.width; ++x) {
            std::uint16_t sample;
            std::memcpy(&sample, from + 2 * x, 2);
            high[x] = static_cast<std::uint8_t>(sample >> 8);
            low[x] = static_cast<std::uint8_t>(sample);
        }
    }
}

void copy_samples(const PlaneView& plane, AVFrame& picture) {
    if (plane.bytes_per_sample == 2 && picture.format == AV_PIX_FMT_GRAY8) return split_bytes(plane, picture);
    const std::ptrdiff_t pitch = picture.linesize[0];
    if (picture.format != AV_PIX_FMT_BGR0)
        return plane.copy_rows(picture.data[0], static_cast<std::size_t>(pitch));
    for (int y = 0; y < plane.height; ++y)
        copy_rgb_as_bgr0(plane.row(y), picture.data[0] + pitch * y, plane.width);
}

/// Replaces the messages of the picture before.
bool attach_messages(std::span<const std::string> messages, AVFrame& picture) {
    av_frame_remove_side_data(&picture, AV_FRAME_DATA_SEI_UNREGISTERED);
    for (const std::string& message : messages) {
        AVBufferRef* const buffer = av_buffer_alloc(message.size());
        if (!buffer) return false;
        std::memcpy(buffer->data, message.data(), message.size());
        if (av_frame_new_side_data_from_buf(&picture, AV_FRAME_DATA_SEI_UNREGISTERED, buffer)) continue;
        AVBufferRef* lost = buffer;
        av_buffer_unref(&lost);
        return false;
    }
    return true;
}

class FfmpegEncoder final : public TrackEncoder {
public:
    explicit FfmpegEncoder(PlaneRole role) : role_(role) {}
    Result<void> open(TrackCoding coding, const PlaneView& first, const Scene& scene) {
        const CodedForm form = form_of(coding, first);
        auto codec = open_encoder(coding, form.format, form.width, form.height, scene.rate);
        if (!codec && codec.error().kind == ErrorKind::usage && form.split)  // with the scene's size
            return unstorable_size(first.width, first.height, "H.264 takes sides of 16384 at most");
        if (!codec) return codec.error();
        codec_ = std::move(*codec);
        picture_ = blank_picture(form.format, form.width, form.height);
        if (!picture_) return track_error(role_, "out of memory");
        picture_->pts = -1;
        if (!is_visual(coding)) return {};
        scaler_ = scaler_from_rgb(form.width, form.height, form.format, form.width, form.height,
                                  SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT);
        if (!scaler_) return track_error(role_, "no way from RGB to its pixels");
        return {};
    }

    Result<void> describe(AVCodecParameters& stored) const override {
        if (avcodec_parameters_from_context(&stored, codec_.get()) < 0)
            return track_error(role_, "out of memory");
        return {};
    }

    Result<PacketPtr> encode(const PlaneView& plane, bool on_its_own,
                             std::span<const std::string> messages) override {
        PacketPtr packet(av_packet_alloc());
        if (!packet || av_frame_make_writable(picture_.get()) < 0) return track_error(role_, "out of memory");
        if (scaler_) {
            const std::uint8_t* rows[] = {plane.data, nullptr, nullptr, nullptr};
            const int strides[] = {static_cast<int>(plane.stride), 0, 0, 0};
            sws_scale(scaler_.get(), rows, strides, 0, plane.height, picture_->data, picture_->linesize);
        } else {
            copy_samples(plane, *picture_);
        }
        ++picture_->pts;
        picture_->pict_type = on_its_own ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
        if (!attach_messages(messages, *picture_)) return track_error(role_, "out of memory");
        int status = avcodec_send_frame(codec_.get(), picture_.get());
        if (status >= 0) status = avcodec_receive_packet(codec_.get(), packet.get());
        if (status < 0) return track_error(role_, ffmpeg_text(status));
        return packet;
    }

private:
    PlaneRole role_;
    CodecPtr codec_;
    FramePtr picture_;
    ScalerPtr scaler_;  // only if is_visual
};

class RankZstdTrack final : public TrackEncoder {
public:
    RankZstdTrack(PlaneRole role, const PlaneView& first, int level)
        : role_(role), width_(first.width), height_(first.height), encoder_(zstd_at(level)) {}
    Result<void> describe(AVCodecParameters& stored) const override {
        stored.codec_type = AVMEDIA_TYPE_VIDEO;
        stored.codec_id = AV_CODEC_ID_NONE;
        stored.codec_tag = rank_zstd_tag;
        stored.width = width_;
        stored.height = height_;
        return {};
    }

    Result<PacketPtr> encode(const PlaneView& plane, bool on_its_own,
                             std::span<const std::string> messages) override {
        if (!messages.empty()) return track_error(role_, "its codec has no room for messages");
        const auto bytes = encoder_.encode(plane, on_its_own);
        PacketPtr packet(av_packet_alloc());
        if (bytes.empty() || !packet || av_new_packet(packet.get(), static_cast<int>(bytes.size())) < 0)
            return track_error(role_, "out of memory");
        std::memcpy(packet->data, bytes.data(), bytes.size());
        packet->flags |= AV_PKT_FLAG_KEY;
        return packet;
    }

private:
    const PlaneRole role_;
    const int width_, height_;
    RankEncoder encoder_;
};

}  // namespace

Result<std::unique_ptr<TrackEncoder>> TrackEncoder::open(PlaneRole role, TrackCoding coding,
                                                         const PlaneView& first, const Scene& scene) {
    if (coding == TrackCoding::rank_zstd || coding == TrackCoding::rank_zstd_thrifty)
        return std::make_unique<RankZstdTrack>(role, first, coding == TrackCoding::rank_zstd ? 1 : 19);
    const bool is_odd = first.width % 2 != 0 || first.height % 2 != 0;
    if ((!is_visual(coding) || is_odd) && !has_x264()) coding = TrackCoding::ffv1;
    return opened_as<TrackEncoder>(std::make_unique<FfmpegEncoder>(role), coding, first, scene);
}

std::string PartTrack::name() const {
    return std::string(role_name(role)) + (part == PlanePart::low ? low_track_suffix : "");
}

PlaneView PartTrack::of(const RawFrame& frame) {
    const PlaneView& plane = plane_of(frame, role);
    if (part == PlanePart::whole) return plane;
    const auto width = static_cast<std::size_t>(plane.width);
    bytes.resize(width * static_cast<std::size_t>(plane.height));
    const int low_bits = bits - 8;
    const unsigned low = (1U << low_bits) - 1;
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint8_t* to = bytes.data() + width * static_cast<std::size_t>(y);
        for (std::size_t x = 0; x < width; ++x) {
            std::uint16_t sample;
            std::memcpy(&sample, from + 2 * x, 2);
            to[x] = static_cast<std::uint8_t>(part == PlanePart::high ? sample >> low_bits : sample & low);
        }
    }
    return {bytes.data(), plane.width, plane.width, plane.height, 1, 1};
}

std::vector<PartTrack> part_tracks(const RawFrame& first, const Scene& scene) {
    std::vector<PartTrack> tracks;
    for (const PlanePart part : {PlanePart::high, PlanePart::low})
        for (const PlaneRole role :
             {PlaneRole::colour, PlaneRole::depth, PlaneRole::haptic, PlaneRole::height}) {
            const PlaneView& plane = plane_of(first, role);
            const bool is_wide = plane.bytes_per_sample == 2;
            if (plane.empty() || (part == PlanePart::low && !is_wide)) continue;
            const int bits =
                role == PlaneRole::depth ? scene.depth_bits : std::max(8, height_bits(scene.height_coding));
            tracks.push_back({role, is_wide ? part : PlanePart::whole, is_wide ? bits : 8});
        }
    return tracks;
}

}  // namespace touchable
