#pragma once

// A container that FFmpeg takes apart, for this room's .cpp files only.

#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/byte_source.hpp"
#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

struct InputCloser {
    void operator()(AVFormatContext* container) const;
};
using InputPtr = std::unique_ptr<AVFormatContext, InputCloser>;

/// How a container is opened.
struct InputKind {
    const char* format = nullptr;  ///< as FFmpeg calls it; null: what the bytes look like, of `formats`
    const char* formats = nullptr;
    int error_recognition = 0;  ///< AV_EF_
    int most_streams = 0;       ///< 0: as many as FFmpeg allows
    std::int64_t probed = 0;    ///< bytes that are looked at to open it; 0: as many as FFmpeg likes
};

/// Bytes that come one after the other, and once.
class ByteFlow {
public:
    virtual ~ByteFlow() = default;
    /// At most `count` bytes, as soon as there are any: how many; 0 at the end.
    virtual Result<std::size_t> read(std::uint8_t* to, std::size_t count) = 0;
};

/// Lets FFmpeg see the first `end` bytes, under the name `file`. Once somebody asks the program to stop it is
/// given no more of them, however far it would read on (ErrorKind::interrupted). An error's words go behind
/// the name and a colon (error_at).
Result<InputPtr> open_input(std::unique_ptr<ByteSource> bytes, std::uint64_t end, const std::string& file,
                            const InputKind& kind);

/// The same of bytes as they come. What keeps them from coming is for `flow` to say, and to end.
Result<InputPtr> open_flow(std::shared_ptr<ByteFlow> flow, const InputKind& kind);

/// Why it reads no further with this status, likewise: what its bytes say, or FFmpeg.
Error input_failure(const AVFormatContext& container, int status);

}  // namespace touchable
