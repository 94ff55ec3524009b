#pragma once

#include <memory>
#include <string>

#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/result.hpp"

namespace touchable {

/// What turns the packets of a track into pictures: FFmpeg's decoders, and one of our own. Takes packets and
/// gives pictures as FFmpeg's do, with FFmpeg's error numbers.
class PacketDecoder {
public:
    /// For a stream whose codec `is_read`. Messages begin with `where`.
    static Result<std::unique_ptr<PacketDecoder>> open(const AVStream& stream, const std::string& where);
    virtual ~PacketDecoder() = default;

    /// The next packet; null after the last.
    virtual int send(const AVPacket* packet) = 0;
    /// The next picture. EAGAIN while another packet is needed, EOF when all are out.
    virtual int receive(AVFrame& picture) = 0;
    /// Forgets all packets.
    virtual void flush() = 0;
    /// Whether each packet is a picture, which comes out before the next goes in.
    virtual bool is_one_packet_each() const = 0;
};

}  // namespace touchable
