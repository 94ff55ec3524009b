#pragma once

// One rendition of HlsInput, for this room's .cpp files only.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/hls_fetch.hpp"
#include "engine/stream/hls_playlist.hpp"
#include "engine/stream/level_choice.hpp"

namespace touchable {

/// Follows a rendition's segments, on the thread that reads them.
class HlsSegmentWatch {
public:
    virtual ~HlsSegmentWatch() = default;
    /// Before a segment is fetched: true ends the rendition there.
    virtual bool ends_before(std::int64_t number) = 0;
    /// Bytes and times alone.
    virtual void fetched(const FetchedSegment& segment) = 0;
    virtual std::int64_t now_ns() const = 0;
};

/// How a rendition is begun.
struct HlsBeginning {
    std::optional<std::string> text{};   ///< of the playlist, where it was fetched already
    std::optional<std::int64_t> from{};  ///< number of the first segment; else as FFmpeg chooses
    HlsSegmentWatch* watch = nullptr;    ///< outlives the rendition
};

/// A media playlist and its segments, as FFmpeg's reader of HLS takes them: it asks for places, and is given
/// bytes in memory.
class HlsRendition {
public:
    /// `place`: of the media playlist. Errors name a place.
    static Result<std::unique_ptr<HlsRendition>> open(std::string place, WaitIsOver is_over, HlsHosts hosts,
                                                      HlsBeginning beginning = {});
    ~HlsRendition();
    HlsRendition(const HlsRendition&) = delete;
    HlsRendition& operator=(const HlsRendition&) = delete;

    /// The packet that `take` gives; null at the end, or where its watch ends it.
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
    HlsRendition(std::string place, WaitIsOver is_over, HlsHosts hosts, HlsSegmentWatch* watch)
        : place_(std::move(place)), is_over_(std::move(is_over)), hosts_(hosts), watch_(watch) {}
    Result<void> begin(HlsBeginning beginning);
    static int open_io(AVFormatContext* context, AVIOContext** io, const char* url, int flags,
                       AVDictionary** options);
    static int close_io(AVFormatContext* context, AVIOContext* io);
    static int is_over(void* own);
    Result<void> fetch_playlist();
    Result<void> take_playlist(Result<std::string> text);
    Result<std::string> place_named(const std::string& named) const;
    int open_segment(AVIOContext** io, const std::string& named, const ByteRange& range);
    Result<std::string> read_segment(const std::string& place, const ByteRange& range);
    Error failure(int status) const;

    const std::string place_;
    const WaitIsOver is_over_;
    const HlsHosts hosts_;
    HlsSegmentWatch* const watch_;
    AVFormatContext* context_ = nullptr;
    AVIOContext* first_io_ = nullptr;  // of the playlist, as it was opened
    std::string playlist_;             // the newest that was judged
    HlsMediaFacts facts_;              // of it
    std::string header_;               // the initialisation, for which FFmpeg asks with every playlist
    int held_ = 0;                     // so often in a row there was no newer one to be had
    std::int64_t segments_lost_ = 0;
    std::int64_t newest_segment_ = -1;  // its number, where there is a watch
    bool was_ended_ = false;            // by it
    std::optional<Error> fault_;        // for which nothing more is read
    PacketPtr ahead_;
    bool at_end_ = false;
};

}  // namespace touchable
