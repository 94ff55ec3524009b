#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// What turns the packets of a track into pictures: FFmpeg's decoders, and one of our own. Takes packets and
/// gives pictures as FFmpeg's do, with FFmpeg's error numbers.
class PacketDecoder {
public:
    /// For a stream whose codec `is_read`. Messages begin with `where`. Of larger pictures nothing is
    /// decoded. Where several `tracks` are decoded side by side, each has its share of the cores.
    static Result<std::unique_ptr<PacketDecoder>> open(const AVStream& stream, const std::string& where,
                                                       std::int64_t most_pixels = largest_picture,
                                                       std::size_t tracks = 1);
    static constexpr std::int64_t largest_picture = std::int64_t{16384} * 16384;  ///< pixels
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
