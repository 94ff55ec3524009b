#pragma once

// Receiving: streams that others send, as clips (open_stream_clip), or live, as a camera (open_live_stream).
// Both receive TCP, HTTP, SRT, UDP and pipes in Matroska or MPEG-TS, and HTTP Live Streaming from a web
// server or a folder. A frameset is given when all of its planes that are felt are there and undamaged, else
// never.
//
// An http(s) address may be a stream or a clip in a file: `open_http` asks the server. Of a file it gives a
// SourceFile whose parts are fetched as they are read; of a stream it gives the connection, which goes into
// StreamSource or StreamChoice, so that the server is not asked twice:
//
//   StreamSource source{.url = url};
//   TRY_ASSIGN(auto found, open_http(url));
//   if (found.file) ...;  // opened like any other file
//   source.connection = std::move(found.stream);
//   source.wait = source.connection->waits();
//   auto clip = open_stream_clip(source);
//
// No call waits longer than StreamPatience says. A StreamWait may be interrupted by any thread; a request to
// stop the program interrupts all. A ClipReader that is made here belongs to one thread, but `interrupt` may
// be called by any; a live one has a thread of its own, which receives.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

/// How long a stream is waited for.
struct StreamPatience {
    std::chrono::milliseconds connection{5'000};  ///< for a connection
    std::chrono::milliseconds caller{60'000};     ///< for a caller, where this end listens
    std::chrono::milliseconds opening{10'000};    ///< from the call to the first whole frameset, all in all
    std::chrono::milliseconds frameset{10'000};   ///< for the next whole frameset
    std::chrono::milliseconds silence{20'000};    ///< in a live run, until the connection is given up
    std::chrono::milliseconds back_off{500};      ///< before connecting again; doubles up to 16 times that
};

/// When a wait for a stream ends: it is interrupted, by any thread, or its time is over.
class StreamWait {
public:
    /// The next wait, which also ends when `together_at_most` does.
    void at_most(std::chrono::milliseconds longest);
    /// All waits from now on together, until this or `each_alone` is called.
    void together_at_most(std::chrono::milliseconds longest);
    void each_alone() { together_until_ns_ = never; }
    bool is_together() const { return together_until_ns_ != never; }
    void interrupt() { interrupted_ = true; }
    /// By `interrupt`, or by a request to stop the program.
    bool is_interrupted() const;
    bool is_too_long() const;
    bool is_over() const { return is_interrupted() || is_too_long(); }
    /// `error`, but ErrorKind::interrupted exactly where this wait was interrupted.
    Error in_time(Error error) const;

private:
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
    std::atomic<bool> interrupted_{false};
    std::atomic<std::int64_t> until_ns_{never}, together_until_ns_{never};
};

/// A sender's bytes as they come: by libsrt, over FFmpeg's protocols, of which it uses those of its address
/// alone, or through a pipe. No read waits longer than its StreamWait. An HTTP server that sends one
/// elsewhere is refused. One thread.
class StreamBytes : public Demuxer::ByteFlow {
public:
    /// Connected, within that time; otherwise why not, without the stream's name.
    static Result<std::shared_ptr<StreamBytes>> connect(const StreamUrl& url,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const StreamPatience& patience);

    /// The byte that comes next, which `read` will give; 0 at the end.
    Result<std::uint8_t> peek();
    /// 0 once the sender has ended it, or the connection is lost. Errors are without the stream's name.
    Result<std::size_t> read(std::uint8_t* to, std::size_t count) final;
    /// Allows this many more bytes to be read from now on; reading beyond them is an error.
    void allow(std::uint64_t bytes) { left_ = bytes; }
    /// Whether nothing was read of it.
    bool is_unread() const { return left_ == 0 && !has_ended_; }
    /// The size of what HTTP has as a file, which can be read anywhere.
    virtual std::optional<std::uint64_t> file_size() const { return std::nullopt; }
    /// Reads all of these bytes of such a file, or returns false.
    virtual bool read_at(std::uint64_t, std::uint8_t*, std::size_t) { return false; }
    /// Figures of the datagrams that carry it; any thread.
    virtual std::optional<StreamFigures::Link> link() const { return std::nullopt; }
    /// The wait that ends its reads.
    const std::shared_ptr<StreamWait>& waits() const { return wait_; }
    /// Once it has ended: whether the connection was lost, and how it ended, such as "closed the connection".
    bool was_lost() const { return was_lost_; }
    const std::string& how_it_ended() const { return how_it_ended_; }

protected:
    explicit StreamBytes(std::shared_ptr<StreamWait> wait) : wait_(std::move(wait)) {}
    /// As `read`, or FFmpeg's error number.
    virtual std::int64_t some(std::uint8_t* to, std::size_t count) = 0;

private:
    const std::shared_ptr<StreamWait> wait_;
    std::uint64_t left_ = 0;
    std::optional<std::uint8_t> peeked_;
    bool has_ended_ = false, was_lost_ = false;
    std::string how_it_ended_;
};

/// The source at an http(s) address: a file whose size its server says, and of which it gives any part; or a
/// stream, and the connection that it comes by.
struct HttpSource {
    std::optional<SourceFile> file{};
    /// To be called once a file's clip was opened, or could not be. From then on each part has a time of its
    /// own. Returns what has kept bytes from coming so far, which the reader of the clip may not have said.
    std::function<std::optional<Error>()> end_opening{};
    std::shared_ptr<StreamBytes> stream{};
};

/// Asks the server. The file is called after the address. Its parts are read as they are needed, those until
/// `end_opening` within `patience.opening` together, each later one within `patience.frameset`, if need be
/// over a new connection. Once a part did not come, nothing more is read: every later read fails at once.
Result<HttpSource> open_http(const StreamUrl& url, const StreamPatience& patience = {});

/// A stream, how long it is waited for, and how it is read.
struct StreamSource {
    StreamUrl url;
    StreamPatience patience{};
    std::shared_ptr<StreamWait> wait = std::make_shared<StreamWait>();
    std::optional<SceneDescription> described{};  ///< in place of its own scene
    /// A connection that is there already, for the first to receive by.
    std::shared_ptr<StreamBytes> connection{};
    /// The clock by which a stream in two levels is read at the level that the link carries; null: the full
    /// one.
    std::function<std::int64_t()> now_ns{};
};

/// A stream as a clip: framesets as they come, numbered from 0, at the times that its rate gives them, until
/// its sender ends it. Where one was lost the one before is given in its place. It goes on and not back: the
/// first ones alone are kept for a while, so that a reader of them can begin anew. Errors name the stream and
/// the frame.
Result<std::unique_ptr<ClipReader>> open_stream_clip(const StreamSource& source,
                                                     Colour colour = Colour::wanted);

/// A stream as a live source.
struct StreamChoice {
    StreamUrl url;
    std::chrono::milliseconds latency{200};  ///< the longest that framesets wait for others' sake
    StreamPatience patience{};
    std::shared_ptr<StreamBytes> connection{};  ///< that is there already, for the first to open it
};

/// Its framesets as they come, each shown when JitterBuffer says. A thread of its own receives them. A sender
/// that goes, or is silent, is connected to again, at first after `patience.back_off`, then ever less often;
/// meanwhile the last frameset stands still. One that then sends another scene, or other planes, ends the
/// stream. `described`: in place of its own scene.
Result<std::unique_ptr<ClipReader>> open_live_stream(const StreamChoice& choice,
                                                     const std::optional<SceneDescription>& described = {});

}  // namespace touchable
