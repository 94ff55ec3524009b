// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names of streams. A stream is named by a URL: tcp://, http(s)://, srt://, udp://, or pipe: for a
// descriptor. `read_stream_url` is the only parser, and refuses what no transport supports; it opens no
// connection and queries no name server. A StreamUrl is passed on to code that receives (receiving.hpp) or
// sends (sending.hpp); own_address and look_up return its address for sockets. Use:
//
//   if (!is_stream_url(word)) ...;  // a file's name
//   TRY_ASSIGN(const auto url, read_stream_url(word));
//   open_stream_clip({.url = url});
//
// An SRT URL may have a passphrase, which no message, report or recording may show: messages use `name`, and
// code that quotes a word that may be a URL uses `without_passphrase`. Only FFmpeg and libsrt get `text`.
//
// Threads: any; values and functions without state.

#include <sys/socket.h>

#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

/// The transport of a stream's bytes; `file`: saved ones, which no URL names (open_saved_stream).
enum class StreamTransport { tcp, http, srt, udp, pipe, file };

/// A parsed name of a stream: "tcp://HOST:PORT", "http://HOST[:PORT]/PATH", "https://...",
/// "srt://HOST:PORT[?key=value&...]", "udp://HOST:PORT", "pipe:" or "pipe:N" (a descriptor), "-".
struct StreamUrl {
    StreamTransport transport = StreamTransport::tcp;
    std::string text;     ///< as FFmpeg takes it; "-" is "pipe:"
    std::string host;     ///< without brackets; empty: this machine, or a pipe
    int port = 0;         ///< 0: a pipe, or, of an address to listen at, any free port
    std::string path;     ///< of http, with its "/"
    std::string query;    ///< behind "?"
    bool is_tls = false;  ///< https

    /// The name for messages: without a passphrase.
    std::string name() const;
    /// FFmpeg's `protocol_whitelist` for this URL; empty for SRT.
    std::string protocols() const {
        if (transport == StreamTransport::http) return is_tls ? "https,tls,tcp" : "http,tcp";
        if (transport == StreamTransport::tcp) return "tcp";
        if (transport == StreamTransport::udp) return "udp";
        return transport == StreamTransport::pipe ? "pipe" : "";
    }
    /// A playlist of HTTP Live Streaming (.m3u8).
    bool is_playlist() const { return transport == StreamTransport::http && path.ends_with(".m3u8"); }
    /// The query's value of this key; empty if it is missing.
    std::string value(std::string_view key) const;
    /// Whether a receiver of this stream waits for the sender to call.
    bool is_called() const { return transport == StreamTransport::srt && value("mode") == "listener"; }
};

/// A playlist of HTTP Live Streaming in a folder of this machine.
StreamUrl playlist_in_folder(const std::string& file);

/// Whether a word is meant as a stream's URL: it begins like one, whatever follows.
bool is_stream_url(std::string_view words);

/// A clip's name for reports: a stream's URL without its passphrase, any other name unchanged.
std::string without_passphrase(const std::string& words);

/// The path of a file:// URL of this machine, as file managers copy it; any other words as they are.
std::string typed_path(const std::string& words);

/// "my map.png" of "my%20map.png".
std::string without_percents(std::string_view url);

/// Refuses (ErrorKind::usage) another form, a port out of range, and a key that the transport does not have;
/// the message says what would be right.
Result<StreamUrl> read_stream_url(std::string_view words);

/// A host and a port as sockets take them.
struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t length = 0;

    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
    bool is_ipv6() const { return storage.ss_family == AF_INET6; }
    /// "192.168.0.5:7000", "[::1]:7000".
    std::string text() const;
};

/// The address that a URL states. Nothing if its host is a name: only numbers, `localhost` and an empty host
/// (all addresses of this machine) are definite. Never waits.
std::optional<SocketAddress> own_address(const StreamUrl& url);

/// The address of the URL's host. Nothing if the host is unknown. A name server may take long to answer.
std::optional<SocketAddress> look_up(const StreamUrl& url);

}  // namespace touchable
