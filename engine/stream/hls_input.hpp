#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/stream_figures.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/hls_fetch.hpp"
#include "engine/stream/hls_playlist.hpp"

namespace touchable {

/// Packets of a stream that is played by HTTP Live Streaming: of the planes that are felt, and of colour.
/// FFmpeg reads the playlists and what their segments hold; it is given nothing but what was fetched from the
/// stream's own host and judged (check_hls_media), each file whole or not at all: a segment that is missing,
/// cut or too large is left out. A playlist that cannot be fetched for a while, or is an older one, is held.
/// One thread.
class HlsInput {
public:
    /// `place`: of a master or a media playlist, "http://...", "https://..." or a file's path. Errors name
    /// it. Colour that cannot be had is left out, which a remark says. Waits until `is_over` says that
    /// nobody does any more (ErrorKind::interrupted); it stays so. `now_ns`: the clock by which the level is
    /// chosen that the link carries (LevelChoice), where the stream has two; null: the full level alone.
    static Result<std::unique_ptr<HlsInput>> open(const std::string& place, WaitIsOver is_over,
                                                  HlsHosts hosts = HlsHosts::own,
                                                  std::function<std::int64_t()> now_ns = {});
    virtual ~HlsInput() = default;

    struct Packet {
        bool is_touch = true;              ///< of the rendition with the planes that are felt; else colour's
        bool is_low = false;               ///< of the low level, whose streams are others
        const AVStream* stream = nullptr;  ///< its index counts within the rendition
        PacketPtr packet;
    };
    /// The next one, by time over both renditions; nothing after the last. A live stream is waited for. Once
    /// there was an error, the stream can only be opened anew.
    virtual Result<std::optional<Packet>> next() = 0;

    /// Whether more comes than was there when it was opened.
    virtual bool is_live() const = 0;
    /// Segments that were left out so far.
    virtual std::int64_t segments_lost() const = 0;
    /// Which level was read, where there is a choice.
    virtual std::optional<LevelFigures> levels() const = 0;
    /// What a person should know.
    virtual const std::vector<std::string>& remarks() const = 0;
};

}  // namespace touchable
