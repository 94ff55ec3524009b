#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

// Playlists of HTTP Live Streaming (RFC 8216) as somebody else sends them. A place is "http://...",
// "https://..." or "file:" and an absolute path. Errors (ErrorKind::input) go behind the place and a colon.

/// Longer ones are refused.
inline constexpr std::size_t largest_hls_playlist = std::size_t{1} << 20;

/// Which hosts a playlist may name.
enum class HlsHosts { own, any };

bool is_hls_playlist(std::string_view first_bytes);

/// The place that a playlist at `base` names. Refused: another scheme or host than its own (of a file, what
/// is not beside or below it), but for http and https where `any` is allowed; what is no URI.
Result<std::string> resolved_place(std::string_view base, std::string_view named,
                                   HlsHosts hosts = HlsHosts::own);

/// Media playlists of a stream.
struct HlsPlaces {
    std::string touch{};                    ///< of the planes that are felt
    std::string colour{};                   ///< empty: there is none, or it is in `touch`
    std::string low_touch{}, low_colour{};  ///< the same of the low level; empty: there is none
};
/// What the playlist at `place` leads to: a master playlist to those that it names, a media playlist to
/// itself. Refused: a master without planes of touch, one that names itself.
Result<HlsPlaces> places_in_playlist(std::string_view text, const std::string& place,
                                     HlsHosts hosts = HlsHosts::own);

/// What a media playlist says of itself.
struct HlsMediaFacts {
    std::int64_t next_segment = 0;  ///< number of the one that will follow the last
    std::string header;             ///< place of its initialisation; empty: its segments need none
    bool has_ended = false;
};
/// Refused: what FFmpeg's reader would go after although it is no media playlist of ours to read: another
/// playlist, keys, places as above, several initialisations, no segment at all.
Result<HlsMediaFacts> check_hls_media(std::string_view text, const std::string& place,
                                      HlsHosts hosts = HlsHosts::own);

/// Of a media playlist that was checked: its first segment at the place `segment` whose number is `least` or
/// more; nothing where it names none.
struct HlsListedSegment {
    std::int64_t number = 0;
    std::int64_t duration_ns = 0;  ///< 0: it says none that can be
};
std::optional<HlsListedSegment> segment_in(std::string_view text, const std::string& place,
                                           const std::string& segment, std::int64_t least,
                                           HlsHosts hosts = HlsHosts::own);
/// The same playlist without the segments before number `first`; nothing where it has none from there on.
std::optional<std::string> playlist_from(std::string_view text, std::int64_t first);

}  // namespace touchable
