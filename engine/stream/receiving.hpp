#pragma once

// Receiving: streams that others send, as clips (open_stream_clip), or live, as a camera (open_live_stream).
// Both receive TCP, HTTP, SRT, UDP and pipes in Matroska or MPEG-TS, and HTTP Live Streaming from a web
// server or a folder. A frameset is given when all of its planes that are felt are there and undamaged, else
// never.
//
// An http(s) address may be a stream or a clip in a file: `open_http` asks the server. Of a file it gives a
// SourceFile whose parts are fetched as they are read; of a stream it gives the connection, which goes into
// StreamSource, so that the server is not asked twice:
//
//   StreamSource source{.url = url};
//   TRY_ASSIGN(auto found, open_http(url));
//   if (found.file) ...;  // opened like any other file
//   source.connection = std::move(found.stream);
//   auto clip = open_stream_clip(source);
//
// No call waits longer than StreamSource::Patience says, and a stop of the thread that calls (stop_requested)
// ends all waits. A ClipReader that is made here belongs to one thread; a live one has a thread of its own,
// which receives.

#include <chrono>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

class StreamBytes;

/// A stream, and how it is received.
struct StreamSource {
    /// How long a stream is waited for.
    struct Patience {
        std::chrono::milliseconds connection{5'000};  ///< for a connection
        std::chrono::milliseconds caller{60'000};     ///< for a caller, where this end listens
        std::chrono::milliseconds opening{10'000};  ///< from the call to the first whole frameset, all in all
        std::chrono::milliseconds frameset{10'000};  ///< for the next whole frameset
        std::chrono::milliseconds silence{20'000};   ///< in a live run, until the connection is given up
        std::chrono::milliseconds back_off{500};     ///< before connecting again; doubles up to 16 times that
    };

    StreamUrl url;
    Patience patience{};
    /// A connection that is there already (HttpSource), for the first to receive by.
    std::shared_ptr<StreamBytes> connection{};
    /// Of a live one: the longest that framesets wait for others' sake.
    std::chrono::milliseconds latency{200};
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
Result<HttpSource> open_http(const StreamUrl& url, const StreamSource::Patience& patience = {});

/// A stream as a clip: framesets as they come, numbered from 0, at the times that its rate gives them, until
/// its sender ends it. Where one was lost the one before is given in its place. It goes on and not back: the
/// first ones alone are kept for a while, so that a reader of them can begin anew. Errors name the stream and
/// the frame. `described`: in place of its own scene.
Result<std::unique_ptr<ClipReader>> open_stream_clip(const StreamSource& source,
                                                     const std::optional<SceneDescription>& described = {},
                                                     Colour colour = Colour::wanted);

/// Its framesets as they come, each shown when JitterBuffer says. A thread of its own receives them. A sender
/// that goes, or is silent, is connected to again, at first after `patience.back_off`, then ever less often;
/// meanwhile the last frameset stands still. One that then sends another scene, or other planes, ends the
/// stream. `described`: in place of its own scene.
Result<std::unique_ptr<ClipReader>> open_live_stream(const StreamSource& source,
                                                     const std::optional<SceneDescription>& described = {});

}  // namespace touchable
