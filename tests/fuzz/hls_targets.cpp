// Streams that anybody sends: playlists of HLS, what H.264 says beside its pictures, segments of fragmented
// MP4.
#include <algorithm>
#include <optional>
#include <string>

#include "engine/stream/hls.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// The playlist of a web server or of a folder, as a master and as what it leads to.
bool parse_hls_playlist(std::string_view text) {
    bool taken = false;
    for (const std::string place : {"http://host:80/a/b.m3u8", "file:/srv/a/b.m3u8"}) {
        const std::string own = place.substr(0, place.find("/a/") + 1);
        const auto places = places_in_playlist(text, place);
        if (is_taken(places)) {
            require(places->touch.starts_with(own), "the planes are elsewhere");
            require(places->colour.empty() || places->colour.starts_with(own), "colour is elsewhere");
            require(places->touch == place || places->colour != place, "it leads to itself");
            for (const std::string& low : {places->low_touch, places->low_colour})
                require(low.empty() || (low.starts_with(own) && low != place && low != places->touch),
                        "the low level is elsewhere, or the full one");
        }
        const auto facts = check_hls_media(text, place);
        if (is_taken(facts)) {
            require(facts->header.empty() || facts->header.starts_with(own), "elsewhere");
            const std::int64_t last = facts->next_segment - 1;
            const auto rest = playlist_from(text, last);
            require(rest && !playlist_from(text, last + 1), "its last segment is another");
            const auto again = check_hls_media(*rest, place);
            require(again && again->next_segment == last + 1, "its last segment alone is none");
            const auto listed = segment_in(text, place, own + "a/0.m4s", last);
            require(!listed || (listed->number == last && listed->duration_ns >= 0), "another segment");
        }
        taken = taken || places || facts;
    }
    return taken;
}

bool parse_picture_message(std::string_view bytes) {
    const auto read = read_sei({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!read) return false;
    require(read->picture.has_value() != read->scene.has_value(), "it is neither or both");
    if (!read->picture) return true;
    const bool is_right = is_sound(*read, {});
    const std::string again = sei_of(*read->picture, {});
    require(!is_right || again == bytes, "what is sound is not what is sent");
    return is_right;
}

/// The initialisation up to the first fragment, and the rest as a segment.
bool parse_hls_stream(std::string_view bytes) {
    const std::size_t head = std::min(bytes.find("moof"), bytes.size());
    const std::size_t cut = head < 4 ? head : head - 4;
    const auto playlist = file_of(
        "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXT-X-MAP:URI=\"hls-init.mp4\"\n#EXTINF:1,\nhls-0.m4s\n"
        "#EXT-X-ENDLIST\n",
        "hls.m3u8");
    file_of(bytes.substr(0, cut), "hls-init.mp4");
    file_of(bytes.substr(cut), "hls-0.m4s");
    const auto input = HlsInput::open(playlist.string());
    if (!is_taken(input)) return false;
    constexpr std::int64_t most_pixels = 1 << 16;
    LabelledDecoder decoder(most_pixels);
    std::optional<std::size_t> track;
    bool taken = false;
    while (true) {
        const auto packet = (*input)->next();
        if (!is_taken(packet) || !*packet) return taken;
        if (!track) {
            const auto added = decoder.add_track(*(*packet)->stream, "stream");
            if (!is_taken(added)) return false;
            track = *added;
        }
        const auto pictures = decoder.add(*track, *(*packet)->packet);
        if (!is_taken(pictures)) return taken;
        taken = taken || !pictures->empty();
    }
}

const Registered hls_playlist_target{
    {.name = "hls_playlist", .parse = parse_hls_playlist, .most_live_mebibytes = 4}};
const Registered picture_message_target{{.name = "picture_message",
                                         .parse = parse_picture_message,
                                         .cuts_are_refused = true,
                                         .most_live_mebibytes = 4}};
const Registered hls_stream_target{{.name = "hls_stream",
                                    .parse = parse_hls_stream,
                                    .most_bytes = 1 << 14,
                                    .most_mebibytes = 2100,
                                    .most_live_mebibytes = 2200}};

}  // namespace
}  // namespace touchable::fuzz
