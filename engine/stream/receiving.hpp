// SPDX-License-Identifier: Apache-2.0
#pragma once

// Receiving: streams as clips (open_stream_clip), or live, as a camera (open_live_stream). Both receive TCP,
// HTTP, SRT, UDP and pipes in Matroska or MPEG-TS, and HTTP Live Streaming from a web server or a folder. A
// frameset is returned only if all of its touch planes are there and undamaged.
//
// An http(s) address may be a stream or a clip in a file: `open_http` finds out from the server. For a file
// it returns a SourceFile whose parts are fetched as they are read; for a stream it returns the connection,
// to be put into StreamSource, so that there is only one request:
//
//   StreamSource source{.url = url};
//   TRY_ASSIGN(auto found, open_http(url));
//   if (found.file) ...;  // opened like any other file
//   source.connection = std::move(found.stream);
//   auto clip = open_stream_clip(source);
//
// No call waits longer than StreamSource::Patience, and a stop of the calling thread (stop_requested) ends
// all waits.
// Threads: one uses a ClipReader that is made here; a live one receives on its own.

#include <chrono>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/stream/stream_url.hpp"

namespace touchable {

class StreamBytes;

/// A stream, and how it is received.
struct StreamSource {
    /// Longest waits.
    struct Patience {
        std::chrono::milliseconds connection{5'000};  ///< for a connection
        std::chrono::milliseconds caller{60'000};     ///< for a caller, if this end listens
        std::chrono::milliseconds opening{10'000};    ///< from the call to the first whole frameset, in total
        std::chrono::milliseconds frameset{10'000};   ///< for the next whole frameset
        std::chrono::milliseconds silence{20'000};    ///< in a live run, until the connection is given up
        std::chrono::milliseconds back_off{500};  ///< before connecting again; doubles up to 16 times that
    };

    StreamUrl url;
    Patience patience{};
    /// An existing connection (HttpSource), for the first receiver.
    std::shared_ptr<StreamBytes> connection{};
    /// Live streams: longest time that framesets are held back so that late ones are in time.
    std::chrono::milliseconds latency{200};
};

/// The source at an http(s) address: a file, if its server states its size and sends any part of it; or a
/// stream and its connection.
struct HttpSource {
    std::optional<SourceFile> file{};
    /// To be called after a file's clip was opened, or could not be. From then on each part has its own time
    /// limit. Returns what has kept bytes from coming so far, which the clip's reader may not have reported.
    std::function<std::optional<Error>()> end_opening{};
    std::shared_ptr<StreamBytes> stream{};
};

/// Sends a request to the server. The file is named after the address. Its parts are read as needed: those
/// until `end_opening` within `patience.opening` in total, each later one within `patience.frameset`, over a
/// new connection if necessary. After a part has failed, every later read fails at once.
Result<HttpSource> open_http(const StreamUrl& url, const StreamSource::Patience& patience = {});

/// A stream as a clip: framesets as they come, numbered from 0, at the times that its rate gives them, until
/// its sender ends it. A lost frameset is replaced by the one before. The clip cannot go back; only its first
/// framesets are kept for a while, so that their reader can begin anew. Errors name the stream and the frame.
/// `described`: replaces the stream's own scene.
Result<std::unique_ptr<ClipReader>> open_stream_clip(const StreamSource& source,
                                                     const std::optional<SceneDescription>& described = {},
                                                     Colour colour = Colour::wanted);

/// Whether a file holds a stream in MPEG-TS.
bool is_saved_stream(const SourceFile& file);
/// A stream in MPEG-TS that was saved to a file, as `open_stream_clip`, up to its last whole frameset.
Result<std::unique_ptr<ClipReader>> open_saved_stream(const SourceFile& file,
                                                      const std::optional<SceneDescription>& described = {},
                                                      Colour colour = Colour::wanted);

/// A live stream, whose framesets are shown when JitterBuffer says. Its own thread receives them. If the
/// sender goes, or is silent, the stream reconnects, at first after `patience.back_off`, then less and less
/// often; meanwhile the last frameset stays. The stream ends if the sender then has another scene, or other
/// planes. `described`: replaces the stream's own scene.
Result<std::unique_ptr<ClipReader>> open_live_stream(const StreamSource& source,
                                                     const std::optional<SceneDescription>& described = {});

}  // namespace touchable
