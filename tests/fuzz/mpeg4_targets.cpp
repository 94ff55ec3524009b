// MPEG-4: a scene's text and binary form, how a file's movie box carries it, and a clip in MP4 as a whole,
// plain and in fragments.
#include <algorithm>

#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/mpeg4/bifs.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

mpeg4::Bytes bytes_in(std::string_view bytes) {
    return {bytes.begin(), bytes.end()};
}

/// What a scene says as a clip is refused, or can be said again, and is then the same.
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
                                  .most_mebibytes = 2048,
                                  .most_live_mebibytes = 2048}};

/// Cut anywhere they have the frames of the whole ones.
const Registered mp4_fragments_target{{.name = "mp4_fragments",
                                       .parse = parse_mp4_clip,
                                       .changes = 120,
                                       .most_bytes = 12288,
                                       .most_mebibytes = 2048,
                                       .most_live_mebibytes = 2048}};

}  // namespace
}  // namespace touchable::fuzz
