#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/packet_decoder.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/rgb_converter.hpp"

namespace touchable {

/// Decodes one track of a clip: packets in, planes out in the order of presentation.
class TrackDecoder {
public:
    struct Picture {
        std::int64_t number = 0;     ///< of the first frame that shows it, from 0
        std::int64_t frames = 1;     ///< that show it
        std::int64_t timestamp = 0;  ///< in the stream's time base
        Plane plane;  ///< as stored; colour and haptic as 8-bit RGB or as grey; none if left out
    };

    /// `file` names the clip in messages; so many `tracks` are decoded side by side.
    static Result<TrackDecoder> open(const AVStream& stream, PlaneRole role, const std::string& file,
                                     std::size_t tracks = 1);

    /// Codec, and once the first picture is out, its size and format.
    const TrackInfo& info() const { return info_; }
    PlaneRole role() const { return role_; }
    std::int64_t pixels() const { return pixels_; }
    /// No packet is needed any more.
    bool drained() const { return drained_; }
    /// "clip.mkv: track depth".
    std::string name() const { return file_ + ": track " + info_.role; }
    /// "clip.mkv: track depth, frame 7", for the picture that comes next.
    std::string where() const;

    /// The next packet; null after the last. Only when `receive` had nothing.
    Result<void> send(const AVPacket* packet);
    /// Known with the first packet.
    bool has_additions() const { return has_additions_.value_or(false); }
    /// Whether the next picture is what the next packet holds, so that it can be left out.
    bool is_one_packet_each() const;
    /// The picture of this packet, which must be sound, without its plane. None after it is decoded, but
    /// where `restart` says so.
    Result<Picture> skip(const AVPacket& packet);
    /// The next packet holds this frame, and decoding can begin there.
    void restart(std::int64_t number);
    /// The next picture; nothing while another packet is needed, or when all are out.
    Result<std::optional<Picture>> receive();
    /// The same as FFmpeg decodes it, of a track whose pictures are not planes but hold them.
    struct Decoded {
        std::int64_t timestamp = 0;  ///< in the stream's time base
        FramePtr frame;
    };
    Result<std::optional<Decoded>> receive_frame();

private:
    TrackDecoder() = default;
    Result<void> read_tags(const AVStream& stream);
    Result<std::int64_t> frames_of(const AVPacket& packet);
    Result<FramePtr> decoded();
    std::int64_t passed();
    Result<void> check_format(const AVFrame& frame);
    Result<Plane> plane(FramePtr frame);
    Result<Plane> rgb(const AVFrame& frame);
    Result<Plane> joined(const AVFrame& frame) const;
    bool is_split() const { return stated_bits_ > 0 && codec_ != AV_CODEC_ID_NONE; }

    PlaneRole role_ = PlaneRole::depth;
    std::string file_;
    TrackInfo info_;
    std::unique_ptr<PacketDecoder> decoder_;
    AVCodecID codec_ = AV_CODEC_ID_NONE;  // FFmpeg's number; none for the codec that is our own
    std::int64_t pixels_ = 0;
    RgbConverter converter_;
    bool says_lossless_ = false;
    bool has_slice_checksums_ = false;   // as FFV1 has them from version 3 on
    int stated_bits_ = 0;                // of samples stored as two bytes apart; 0: they are not
    std::optional<bool> has_additions_;  // all packets or none, as the first has them
    std::deque<std::int64_t> frames_;    // that the pictures of packets sent, not received, stay
    std::string format_;                 // of the pictures, FFmpeg's name
    int coded_height_ = 0;
    std::int64_t received_ = 0;  // frames
    bool drained_ = false;
};

}  // namespace touchable
