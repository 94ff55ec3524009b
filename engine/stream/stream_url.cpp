// SPDX-License-Identifier: Apache-2.0
#include "engine/stream/stream_url.hpp"

#include <netdb.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <memory>
#include <system_error>

#include "engine/base/words.hpp"

namespace touchable {
namespace {

struct Scheme {
    std::string_view words;
    StreamTransport transport;
    std::vector<std::string> keys{};  // allowed in its query
};
const std::array schemes{
    Scheme{"tcp://", StreamTransport::tcp},
    Scheme{"http://", StreamTransport::http},  // its keys are the server's own
    Scheme{"https://", StreamTransport::http},
    Scheme{"srt://", StreamTransport::srt, {"mode", "latency", "passphrase", "pbkeylen", "streamid"}},
    Scheme{"udp://", StreamTransport::udp, {"localaddr"}},
    Scheme{"pipe:", StreamTransport::pipe},
};

const Scheme* scheme_of(std::string_view words) {
    for (const Scheme& scheme : schemes)
        if (words.starts_with(scheme.words)) return &scheme;
    return nullptr;
}

/// "ftp:// is not read; " of "ftp://host/a.mkv", also of "tcp:/host:1"; empty: words of another kind.
std::string unread_scheme(std::string_view words) {
    const std::size_t colon = words.find(":/");
    if (colon == std::string_view::npos || scheme_of(words)) return "";
    const std::string_view name = words.substr(0, colon);
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    if (name.size() < 2 || name == "file" || !std::ranges::all_of(name, is_letter)) return "";
    const bool has_both = words.substr(colon).starts_with("://");
    if (!has_both && !scheme_of(std::string(name) + "://")) return "";
    return std::string(name) + (has_both ? "://" : ":/") + " is not read; ";
}

std::optional<int> port_of(std::string_view digits) {
    const auto port = parsed_as<int>(digits);
    return port && *port >= 0 && *port <= 65535 ? port : std::nullopt;
}

/// The part before path and query: "HOST:PORT", "[::1]:PORT"; for HTTP also without a port.
bool read_authority(std::string_view authority, bool needs_port, StreamUrl& url) {
    const std::size_t bracket = authority.starts_with('[') ? authority.find(']') : 0;
    if (bracket == std::string_view::npos) return false;
    const std::size_t colon = authority.find(':', bracket);
    std::string_view host = authority.substr(0, colon);
    if (bracket > 0) host = host.size() == bracket + 1 ? host.substr(1, bracket - 1) : "";
    if (bracket > 0 && host.empty()) return false;
    url.host = host;
    for (const char letter : host)
        if (letter <= ' ' || letter == '@' || letter == '\\' || letter == 127) return false;
    if (colon == std::string_view::npos) {
        url.port = url.is_tls ? 443 : 80;
        return !needs_port;
    }
    const auto port = port_of(authority.substr(colon + 1));
    if (!port) return false;
    url.port = *port;
    return true;
}

/// For messages: without user, password and passphrase.
std::string without_secrets(std::string_view words) {
    std::string said(words);
    const std::size_t scheme = said.find("://"), user = said.find('@');
    if (scheme != std::string::npos && user != std::string::npos && user > scheme)
        said.replace(scheme + 3, user - scheme - 3, "...");
    std::string small = small_letters(said);
    constexpr std::string_view key = "passphrase=";
    for (std::size_t at = small.find(key); at != std::string::npos; at = small.find(key, at + key.size())) {
        const std::size_t end = std::min(small.find('&', at), small.size());
        said.replace(at + key.size(), end - at - key.size(), "...");
        small.replace(at + key.size(), end - at - key.size(), "...");
    }
    return said;
}

Error unusable(std::string_view words, const std::string& right) {
    return usage_error(in_quotes(without_secrets(words)) + " cannot be used as a stream: " + right);
}

template <class Use>
std::optional<std::string_view> find_pair(std::string_view query, const Use& is_it) {
    while (!query.empty()) {
        const std::string_view pair = cut_part(query, '&');
        if (is_it(pair.substr(0, pair.find('=')))) return pair;
    }
    return std::nullopt;
}

Result<StreamUrl> read_pipe(std::string_view words) {
    StreamUrl url;
    url.transport = StreamTransport::pipe;
    url.text = words == "-" ? "pipe:0" : words;
    if (url.text == "pipe:") url.text = "pipe:0";
    if (parsed_as<int>(std::string_view(url.text).substr(5)).value_or(-1) < 0)
        return unusable(words, "pipe: is followed by a descriptor's number, or by nothing");
    return url;
}

std::optional<SocketAddress> first_address(const std::string& host, int port, int flags) {
    addrinfo wanted = {};
    wanted.ai_flags = AI_NUMERICSERV | flags;
    wanted.ai_socktype = SOCK_STREAM;  // otherwise each address is listed once per type
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) return std::nullopt;
    const std::unique_ptr<addrinfo, ReleasedBy<::freeaddrinfo>> list(found);
    SocketAddress address;
    if (found->ai_addrlen > sizeof address.storage) return std::nullopt;
    address.length = found->ai_addrlen;
    std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
    return address;
}

}  // namespace

StreamUrl playlist_in_folder(const std::string& file) {
    StreamUrl url;
    url.transport = StreamTransport::http;
    url.text = url.path = file;
    return url;
}

bool is_stream_url(std::string_view words) {
    return words == "-" || scheme_of(words) != nullptr || !unread_scheme(words).empty();
}

std::string without_passphrase(const std::string& words) {
    return is_stream_url(words) ? without_secrets(words) : words;
}

std::string without_percents(std::string_view url) {
    std::string text;
    for (std::size_t k = 0; k < url.size(); ++k) {
        unsigned char byte = 0;
        const char* const digits = url.data() + k + 1;
        const bool is_coded = url[k] == '%' && k + 2 < url.size() &&
                              std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
        text += is_coded ? static_cast<char>(byte) : url[k];
        if (is_coded) k += 2;
    }
    return text;
}

std::string typed_path(const std::string& words) {
    for (const std::string_view begin : {"file:///", "file://localhost/"}) {
        if (!words.starts_with(begin)) continue;
        const std::string path = without_percents(words.substr(begin.size() - 1));
        if (path.find('\0') == std::string::npos) return path;  // else it would be another, shorter one
    }
    return words;
}

Result<StreamUrl> read_stream_url(std::string_view words) {
    const Scheme* const scheme = scheme_of(words);
    if (words == "-" || (scheme && scheme->transport == StreamTransport::pipe)) return read_pipe(words);
    if (!scheme)
        return unusable(words, unread_scheme(words) + "streams begin with " +
                                   listed(schemes, [](const Scheme& each) { return each.words; }));
    constexpr std::size_t longest = 4096;
    if (words.size() > longest) return unusable(words.substr(0, 80), "it is longer than 4096 bytes");
    StreamUrl url;
    url.transport = scheme->transport;
    url.text = words;
    url.is_tls = scheme->words == "https://";
    const bool is_http = url.transport == StreamTransport::http;
    std::string_view rest = words.substr(scheme->words.size());
    if (const std::size_t mark = rest.find('?'); mark != std::string_view::npos) {
        url.query = rest.substr(mark + 1);
        rest = rest.substr(0, mark);
    }
    const std::size_t slash = rest.find('/');
    if (slash != std::string_view::npos) url.path = rest.substr(slash);
    if (!read_authority(rest.substr(0, slash), !is_http, url) || (!is_http && url.path.size() > 1))
        return unusable(words, std::string(scheme->words) +
                                   (is_http ? "HOST[:PORT]/PATH" : "HOST:PORT, with a port from 0 to 65535"));
    if (is_http && url.host.empty()) return unusable(words, "it names no host");
    if (is_http && url.path.empty()) url.path = "/";
    const auto is_foreign = [&](std::string_view key) {
        return std::ranges::find(scheme->keys, key) == scheme->keys.end();
    };
    if (const std::size_t secret = url.value("passphrase").size(); secret > 0 && (secret < 10 || secret > 79))
        return unusable(words, "a passphrase has 10 to 79 characters");
    if (const auto foreign = is_http ? std::nullopt : find_pair(url.query, is_foreign)) {
        const std::string meant = nearest_word(foreign->substr(0, foreign->find('=')), scheme->keys);
        return unusable(words, "it has no setting " + in_quotes(without_secrets(*foreign)) +
                                   (meant.empty() ? "" : " (did you mean " + meant + "?)") +
                                   (scheme->keys.empty() ? "" : "; there are " + listed(scheme->keys)));
    }
    return url;
}

std::string StreamUrl::name() const {
    return printable(without_secrets(text), 200);
}

std::string StreamUrl::value(std::string_view key) const {
    const auto pair = find_pair(query, [key](std::string_view name) { return name == key; });
    if (!pair || pair->size() <= key.size()) return "";
    return std::string(pair->substr(key.size() + 1));
}

std::string SocketAddress::text() const {
    char host[NI_MAXHOST], port[NI_MAXSERV];
    if (::getnameinfo(get(), length, host, sizeof host, port, sizeof port, NI_NUMERICHOST | NI_NUMERICSERV) !=
        0)
        return "?";
    const std::string name(&host[0]);
    return (is_ipv6() ? "[" + name + "]" : name) + ":" + &port[0];
}

std::optional<SocketAddress> own_address(const StreamUrl& url) {
    const std::string host = url.host == "localhost" ? "127.0.0.1" : url.host.empty() ? "0.0.0.0" : url.host;
    return first_address(host, url.port, AI_PASSIVE | AI_NUMERICHOST);
}

std::optional<SocketAddress> look_up(const StreamUrl& url) {
    return first_address(url.host.empty() ? "127.0.0.1" : url.host, url.port, 0);
}

}  // namespace touchable
