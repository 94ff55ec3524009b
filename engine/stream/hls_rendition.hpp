#pragma once

// One rendition of HlsInput, for this room's .cpp files only.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "engine/ffmpeg/ffmpeg.hpp"
#include "engine/result.hpp"
#include "engine/stream/hls_fetch.hpp"
#include "engine/stream/hls_playlist.hpp"

namespace touchable {

/// A media playlist and its segments, as FFmpeg's reader of HLS takes them: it asks for places, and is given
/// bytes in memory.
class HlsRendition {
public:
    /// `place`: of the media playlist; `text`: that, where it was fetched already. Errors name a place.
    static Result<std::unique_ptr<HlsRendition>> open(std::string place, WaitIsOver is_over, HlsHosts hosts,
                                                      std::optional<std::string> text = {});
    ~HlsRendition();
    HlsRendition(const HlsRendition&) = delete;
    HlsRendition& operator=(const HlsRendition&) = delete;

    /// The packet that `take` gives; null at the end.
    Result<const AVPacket*> peek();
    PacketPtr take() { return std::move(ahead_); }
    const AVStream& stream_of(const AVPacket& packet) const {
        return *context_->streams[packet.stream_index];
    }
    /// When it is decoded; the least number where nobody says.
    std::int64_t time_ns(const AVPacket& packet) const;

    bool has_ended() const { return facts_.has_ended; }
    std::int64_t segments_lost() const { return segments_lost_; }

private:
    HlsRendition(std::string place, WaitIsOver is_over, HlsHosts hosts)
        : place_(std::move(place)), is_over_(std::move(is_over)), hosts_(hosts) {}
    Result<void> begin(std::optional<std::string> text);
    static int open_io(AVFormatContext* context, AVIOContext** io, const char* url, int flags,
                       AVDictionary** options);
    static int close_io(AVFormatContext* context, AVIOContext* io);
    static int is_over(void* own);
    Result<void> fetch_playlist();
    Result<void> take_playlist(Result<std::string> text);
    Result<std::string> read_segment(const std::string& named, const ByteRange& range);
    Error failure(int status) const;

    const std::string place_;
    const WaitIsOver is_over_;
    const HlsHosts hosts_;
    AVFormatContext* context_ = nullptr;
    AVIOContext* first_io_ = nullptr;  // of the playlist, as it was opened
    std::string playlist_;             // the newest that was judged
    HlsMediaFacts facts_;              // of it
    std::string header_;               // the initialisation, for which FFmpeg asks with every playlist
    int held_ = 0;                     // so often in a row there was no newer one to be had
    std::int64_t segments_lost_ = 0;
    std::optional<Error> fault_;  // for which nothing more is read
    PacketPtr ahead_;
    bool at_end_ = false;
};

}  // namespace touchable
