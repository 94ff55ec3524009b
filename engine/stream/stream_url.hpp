#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

/// What carries a stream's bytes.
enum class StreamTransport { tcp, http, srt, udp, pipe };

/// A stream as a person names it: "tcp://HOST:PORT", "http://HOST[:PORT]/PATH", "https://...",
/// "srt://HOST:PORT[?key=value&...]", "udp://HOST:PORT", "pipe:" or "pipe:N" (a descriptor), "-".
struct StreamUrl {
    StreamTransport transport = StreamTransport::tcp;
    std::string text;     ///< as FFmpeg takes it; "-" is "pipe:"
    std::string host;     ///< without brackets; empty: of this machine, or a pipe
    int port = 0;         ///< 0: a pipe, or where one listens, any that is free
    std::string path;     ///< of http, with its "/"
    std::string query;    ///< behind "?"
    bool is_tls = false;  ///< https

    /// As messages have it: without a passphrase.
    std::string name() const;
    /// FFmpeg's protocols that it may use, as `protocol_whitelist`; none for SRT.
    std::string protocols() const;
    /// Of HTTP Live Streaming: a playlist (.m3u8).
    bool is_playlist() const { return transport == StreamTransport::http && path.ends_with(".m3u8"); }
    /// One of the query's values; empty: it has none.
    std::string value(std::string_view key) const;
};

/// A playlist of HTTP Live Streaming in a folder of this machine, as it lies on its way to a web server.
StreamUrl playlist_in_folder(const std::string& file);

/// Whether a person's word is meant as one, whatever its rest looks like: it begins as above.
bool is_stream_url(std::string_view words);

/// A clip's name for reports: of a stream without its passphrase, of anything else as it is.
std::string without_passphrase(const std::string& words);

/// Opens nothing. Refused (ErrorKind::usage), by what would be right: another form, a port out of range, a
/// key that the transport has not.
Result<StreamUrl> read_stream_url(std::string_view words);

}  // namespace touchable
