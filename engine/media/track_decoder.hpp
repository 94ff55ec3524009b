#pragma once

#include <cstdint>
#include <string>

#include "engine/media/clip.hpp"
#include "engine/media/ffmpeg.hpp"
#include "engine/media/plane_role.hpp"
#include "engine/result.hpp"

namespace touchable {

/// Decodes one track of a clip: packets in, planes out in the order of presentation.
class TrackDecoder {
public:
    struct Picture {
        std::int64_t number = 0;     ///< from 0
        std::int64_t timestamp = 0;  ///< in the stream's time base
        Plane plane;                 ///< as stored; colour as 8-bit RGB or as grey, haptic as 8-bit RGB
    };

    /// `file` names the clip in messages.
    static Result<TrackDecoder> open(const AVStream& stream, PlaneRole role, const std::string& file);

    /// Codec, and once the first picture is out, its size and format.
    const TrackInfo& info() const { return info_; }
    PlaneRole role() const { return role_; }
    /// No packet is needed any more.
    bool drained() const { return drained_; }
    /// "clip.mkv: track depth, frame 7", for the picture that comes next.
    std::string where() const;

    /// The next packet; null after the last. Only when `receive` had nothing.
    Result<void> send(const AVPacket* packet);
    /// Whether the next picture is what the next packet holds, so that it can be left out.
    bool is_one_packet_each() const;
    /// Leaves out the picture of this packet, which must be sound.
    Result<void> skip(const AVPacket& packet);
    /// The next picture; nothing while another packet is needed, or when all are out.
    Result<std::optional<Picture>> receive();

private:
    TrackDecoder() = default;
    Result<void> check_sound(const AVPacket& packet) const;
    Result<void> check_format(const AVFrame& frame);
    Result<Plane> plane(FramePtr frame) const;

    PlaneRole role_ = PlaneRole::depth;
    std::string file_;
    TrackInfo info_;
    CodecPtr codec_;
    std::int64_t received_ = 0;
    bool drained_ = false;
};

}  // namespace touchable
