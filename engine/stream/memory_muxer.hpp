#pragma once

// FFmpeg's muxers, whose bytes come out in memory; for this room's .cpp files only.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// A container that is written forwards, and taken piece by piece.
class MemoryMuxer {
public:
    /// `format`: as FFmpeg calls it.
    static Result<std::unique_ptr<MemoryMuxer>> open(const char* format);
    ~MemoryMuxer();
    MemoryMuxer(const MemoryMuxer&) = delete;
    MemoryMuxer& operator=(const MemoryMuxer&) = delete;

    /// For its streams, before `begin`.
    AVFormatContext& context() { return *context_; }
    /// `options`: of the muxer, "key=value:key=value".
    Result<void> begin(const std::string& options);
    /// A packet whose times are in `tick`.
    Result<void> write(AVPacket& packet, int stream, AVRational tick);
    /// What the muxer holds back.
    Result<void> flush();
    /// The bytes of all that was written since the last time.
    std::vector<std::uint8_t> take();

private:
    explicit MemoryMuxer(AVFormatContext* context) : context_(context) {}
    static int append(void* own, MuxedBytes* bytes, int count);
    Result<void> check(int status) const;

    AVFormatContext* context_;
    std::vector<std::uint8_t> bytes_;
};

}  // namespace touchable
