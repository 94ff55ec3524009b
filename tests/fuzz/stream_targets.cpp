// SPDX-License-Identifier: Apache-2.0
// A received stream: any bytes, through a pipe, to be opened and read to their end.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <string>

#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/mpeg4/bifs.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/stream/hls.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "engine/stream/receiving.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// In the end that is read: a pipe holds 64 KiB.
int pipe_with(std::string_view bytes) {
    int ends[2];
    require(::pipe2(ends, O_CLOEXEC) == 0, "there is no pipe");
    const auto some = bytes.substr(0, std::size_t{1} << 16U);
    require(::write(ends[1], some.data(), some.size()) == static_cast<ssize_t>(some.size()),
            "a pipe takes no bytes");
    ::close(ends[1]);
    return ends[0];
}

bool parse_stream(std::string_view bytes) {
    const int descriptor = pipe_with(bytes);
    StreamSource source;
    source.url = *read_stream_url("pipe:" + std::to_string(descriptor));
    auto clip = open_stream_clip(source);
    bool taken = is_taken(clip);
    constexpr std::int64_t most_frames = 200;  // each of those missing between is given
    for (std::int64_t number = 0; clip && number < most_frames; ++number) {
        const auto frame = (*clip)->next();
        taken = is_taken(frame) && taken;
        if (!frame || !*frame) break;
        require((*frame)->number == number, "frames are not numbered one by one");
        const Scene& scene = (*clip)->scene();
        require((*frame)->depth.width == scene.width && (*frame)->depth.height == scene.height,
                "depth is not of the scene's size");
        (void)(*frame)->depth.sample(scene.width - 1, scene.height - 1);
    }
    ::close(descriptor);
    return taken;
}

const Registered stream_target{
    {.name = "stream", .parse = parse_stream, .changes = 60, .most_bytes = 8192, .decodes_video = true}};

// Streams of unknown senders: playlists of HLS, what H.264 says beside its pictures, segments of fragmented
// MP4.

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

// MPEG-4: a scene's text and binary form, how a file's movie box carries it, and a clip in MP4 as a whole,
// plain and in fragments.

mpeg4::Bytes bytes_in(std::string_view bytes) {
    return {bytes.begin(), bytes.end()};
}

/// A scene read as a clip is refused, or can be written again and is then the same.
void require_same_nodes(const mpeg4::SceneTree& scene) {
    const auto nodes = mpeg4::clip_nodes_of(scene);
    if (!is_taken(nodes)) return;
    (void)is_taken(mpeg4::described_by(*nodes, 64, 48, 8));
    const auto again = mpeg4::clip_nodes_of(mpeg4::scene_of(*nodes, 64, 48));
    if (nodes->focal_length == 0 && nodes->pixel_width == 0) return;  // a DepthImage is written as a Depth
    require(bool(again), again ? "" : "nodes that were written are refused: " + again.error().message);
    require(again->depth == nodes->depth && again->colour == nodes->colour &&
                again->haptic == nodes->haptic && again->height == nodes->height &&
                again->near == nodes->near && again->far == nodes->far &&
                again->max_height == nodes->max_height && again->scene_file == nodes->scene_file,
            "nodes are others when they are read again");
}

/// Written as text and read again, a scene is the same.
void require_same_text(const mpeg4::SceneTree& scene) {
    const std::string text = mpeg4::scene_text(scene);
    if (text.size() > (std::size_t{1} << 20)) return;
    const auto again = mpeg4::parse_scene_text(text);
    require(bool(again), again ? "" : "a scene that was written is refused: " + again.error().message);
    require(mpeg4::scene_text(*again) == text, "a scene is another one when it is read again");
}

/// As bytes, where it has such a form.
void require_same_bytes(const mpeg4::SceneTree& scene) {
    const auto config = mpeg4::config_for(scene, 64, 48);
    const auto bytes = mpeg4::encode_scene(scene, config);
    if (!is_taken(bytes) || bytes->size() > (std::size_t{60} << 10)) return;
    const auto again = mpeg4::decode_scene(*bytes, config);
    if (!is_taken(again)) return;  // of a string longer than one may be
    require(bool(mpeg4::encode_scene(*again, config)), "a scene that was decoded cannot be encoded");
    require(*mpeg4::encode_scene(*again, config) == *bytes,
            "a scene is another one when it is decoded again");
}

bool parse_scene_words(std::string_view bytes) {
    const auto scene = mpeg4::parse_scene_text(bytes);
    if (!is_taken(scene)) {
        require(scene.error().message.starts_with("line "), "a text is refused without the line");
        return false;
    }
    require_same_text(*scene);
    require_same_bytes(*scene);
    require_same_nodes(*scene);
    return true;
}

/// Version and bits of numbers of nodes and prototypes; then an access unit. The same bytes as a
/// configuration.
bool parse_bifs(std::string_view bytes) {
    (void)is_taken(mpeg4::decode_config(bytes_in(bytes), 1));
    (void)is_taken(mpeg4::decode_config(bytes_in(bytes), 2));
    Taken taken(bytes);
    const unsigned said = taken.byte();
    const mpeg4::BifsConfig config{.version = said & 1U ? 2 : 1,
                                   .node_id_bits = static_cast<int>(said >> 1 & 15U) + 1,
                                   .prototype_id_bits = static_cast<int>(said >> 5)};
    const auto scene = mpeg4::decode_scene(bytes_in(taken.rest()), config);
    if (!is_taken(scene)) return false;
    require_same_text(*scene);
    require_same_bytes(*scene);
    require_same_nodes(*scene);
    return true;
}

/// The content of a movie box, then the file's samples from its first byte on, as it says where they are.
bool parse_scene_stream(std::string_view bytes) {
    const mpeg4::Bytes all = bytes_in(bytes);
    const auto read = [&](std::uint64_t at, std::uint64_t count) -> Result<mpeg4::Bytes> {
        if (count > all.size() || at > all.size() - count) return input_error("is cut short");
        const auto from = all.begin() + static_cast<std::ptrdiff_t>(at);
        return mpeg4::Bytes(from, from + static_cast<std::ptrdiff_t>(count));
    };
    const auto stream = mpeg4::read_scene_stream(all, read);
    if (!is_taken(stream) || !stream->has_value()) return false;
    for ([[maybe_unused]] const auto& [object, track] : (*stream)->objects)
        (void)is_taken(mpeg4::first_sample_of(all, track));
    const auto written = mpeg4::with_scene_stream(all, **stream, 1, 0);
    (void)is_taken(written);
    (void)is_taken(mpeg4::decode_scene((*stream)->scene, (*stream)->config));
    return true;
}

bool parse_mp4_clip(std::string_view bytes) {
    const auto file = file_of(bytes, "clip.mp4");
    if (!is_mp4_clip(file, false)) return false;
    return is_clip(is_mp4_stills(file) ? open_mp4_stills({file}) : open_mp4_clip(file, std::nullopt));
}

const Registered scene_text_target{{.name = "scene_text",
                                    .parse = parse_scene_words,
                                    .cuts_are_refused = true,
                                    .needless_bytes = 1,
                                    .changes = 600}};
const Registered bifs_target{{.name = "bifs", .parse = parse_bifs, .changes = 600}};
const Registered scene_stream_target{{.name = "scene_stream", .parse = parse_scene_stream, .changes = 600}};
const Registered mp4_clip_target{{.name = "mp4_clip",
                                  .parse = parse_mp4_clip,
                                  .cuts_are_refused = true,
                                  .changes = 120,
                                  .most_bytes = 12288,
                                  .decodes_video = true}};

/// Cut anywhere they have the frames of the whole ones.
const Registered mp4_fragments_target{{.name = "mp4_fragments",
                                       .parse = parse_mp4_clip,
                                       .changes = 120,
                                       .most_bytes = 12288,
                                       .decodes_video = true}};

}  // namespace
}  // namespace touchable::fuzz
