#include "engine/formats/gltf_file.hpp"

#include <charconv>
#include <limits>
#include <memory>
#include <utility>

#include "engine/base/printable.hpp"

namespace touchable {
namespace {

using checked_json::Node;
using checked_json::Refusal;

/// Values of three bytes of text take a hundred of memory.
constexpr std::size_t largest_json = std::size_t{8} << 20U;

/// The two parts of a file: what it says, and the bytes it carries.
struct GltfParts {
    std::string_view json;
    std::optional<std::string_view> carried;
};

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
    std::uint32_t word = 0;
    for (std::size_t k = 4; k-- > 0;) word = word << 8U | static_cast<unsigned char>(bytes[at + k]);
    return word;
}

GltfParts parts_of(std::string_view bytes) {
    if (!bytes.starts_with("glTF")) return {bytes, std::nullopt};
    if (bytes.size() < 12 || word_at(bytes, 4) != 2)
        throw Refusal{"is no GLB of version 2, which is the one that is read"};
    GltfParts parts;
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
        const std::size_t length = word_at(bytes, at);
        const std::string_view kind = bytes.substr(at + 4, 4);
        at += 8;
        if (length > bytes.size() - at) throw Refusal{"is damaged: it ends within a chunk"};
        if (kind == "JSON" && parts.json.empty()) parts.json = bytes.substr(at, length);
        if (kind == std::string_view("BIN\0", 4) && !parts.carried) parts.carried = bytes.substr(at, length);
        at += length;
    }
    if (parts.json.empty()) throw Refusal{"is damaged: has no JSON"};
    return parts;
}

/// The number in "#track_ID=2" (ISO/IEC 14496-12, Annex C).
std::uint32_t track_number(const Node& track) {
    constexpr std::string_view begin = "#track_ID=";
    const std::string text = track.text();
    std::uint32_t number = 0;
    const char* const end = text.data() + text.size();
    if (!text.starts_with(begin)) track.refuse("\"#track_ID=N\"");
    const auto [last, failure] = std::from_chars(text.data() + begin.size(), end, number);
    if (failure != std::errc() || last != end || number == 0) track.refuse("\"#track_ID=N\", N from 1");
    return number;
}

/// The first that is a file here: no other place is ever asked.
Node local_alternative(const Node& media) {
    const std::vector<Node> all = gltf_array(media["alternatives"]);
    for (const Node& one : all)
        if (is_local_link(one["uri"].text())) return one;
    if (all.empty()) media["alternatives"].refuse("an array with an element");
    all.front()["uri"].refuse("the name of a file beside it, as nothing is fetched");
}

}  // namespace

std::vector<Node> gltf_array(const Node& array) {
    return array.elements(0, most_gltf_elements, "an array");
}

std::optional<Node> gltf_extension(const Node& node, const char* name) {
    if (!node.has("extensions")) return std::nullopt;
    const Node all = node["extensions"];
    if (!all.is_object()) all.refuse("an object {...}");
    return all.has(name) ? std::optional(all[name]) : std::nullopt;
}

GltfFile::GltfFile(const std::filesystem::path& file, std::string_view bytes) : file_(file) {
    const GltfParts parts = parts_of(bytes);
    json_ = checked_json::parse(parts.json, largest_json);
    carried_ = parts.carried;
    if (!root().has("asset") || !root()["asset"].has("version")) return;
    const Node version = root()["asset"]["version"];
    if (!version.text().starts_with("2.")) version.refuse("2.0 or another 2, which alone is read");
}

Node GltfFile::element(const char* array, const Node& index) const {
    const Node all = root()[array];
    const auto found = all.element(static_cast<std::size_t>(index.whole()));
    if (!found) index.refuse("a number of one of " + std::to_string(all.size()) + " " + array);
    return *found;
}

Node GltfFile::texture(std::size_t number) const {
    const Node all = root()["textures"];
    const auto found = all.element(number);
    if (!found)
        throw Refusal{"names texture " + std::to_string(number) + ", but has " + std::to_string(all.size())};
    return *found;
}

LinkedFile GltfFile::linked(const Node& uri) const {
    auto link = follow_link(uri.text(), file_);
    if (!link) throw link.error();
    return std::move(*link);
}

/// A stretch of a buffer.
LinkedFile GltfFile::carried_picture(const Node& view) {
    const Node buffer = element("buffers", view["buffer"]);
    constexpr std::int64_t most = std::int64_t{1} << 40;
    const auto begin =
        static_cast<std::size_t>(view.has("byteOffset") ? view["byteOffset"].integer(0, most) : 0);
    const auto length = static_cast<std::size_t>(view["byteLength"].integer(1, most));
    std::shared_ptr<const std::string> owned;
    std::string_view bytes;
    if (buffer.has("uri")) {
        const LinkedFile link = linked(buffer["uri"]);
        auto read = bytes_of(link);
        if (!read) throw read.error();
        if (!link.file.empty()) read_files_.push_back(link.file);
        owned = std::move(*read);
        bytes = *owned;
    } else if (carried_) {
        bytes = *carried_;
    } else {
        buffer["uri"].text();  // is missing
    }
    if (begin > bytes.size() || length > bytes.size() - begin)
        view["byteLength"].refuse("within its buffer, which has " + std::to_string(bytes.size()) + " bytes");
    return {{}, std::make_shared<const std::string>(bytes.substr(begin, length)), file_.string()};
}

LinkedFile GltfFile::picture(const Node& texture) {
    if (!texture.has("source"))
        throw Refusal{"a texture has no source: must be a PNG or JPEG; pictures of extensions are not read"};
    const Node image = element("images", texture["source"]);
    if (!image.has("bufferView")) return linked(image["uri"]);
    return carried_picture(element("bufferViews", image["bufferView"]));
}

/// Through accessor, view and buffer to the tracks of a medium.
std::optional<GltfVideo> GltfFile::video(const Node& texture) const {
    const auto moving = gltf_extension(texture, "MPEG_texture_video");
    if (!moving) return std::nullopt;
    GltfVideo video;
    constexpr int longest_side = 16384;
    video.width = static_cast<int>((*moving)["width"].integer(1, longest_side));
    video.height = static_cast<int>((*moving)["height"].integer(1, longest_side));
    video.format = moving->has("format") ? (*moving)["format"].text() : "RGB";
    const Node view = element("bufferViews", element("accessors", (*moving)["accessor"])["bufferView"]);
    const Node buffer = element("buffers", view["buffer"]);
    const auto frames = gltf_extension(buffer, "MPEG_buffer_circular");
    if (!frames)
        throw Refusal{"the buffer of a video has no MPEG_buffer_circular: must say of which media it is"};
    const auto files = gltf_extension(root(), "MPEG_media");
    if (!files) throw Refusal{"has no extensions.MPEG_media: must say which files its videos are"};
    const Node media = (*files)["media"];
    const auto medium = media.element(static_cast<std::size_t>((*frames)["media"].whole()));
    if (!medium) (*frames)["media"].refuse("a number of one of " + std::to_string(media.size()) + " media");
    const Node file = local_alternative(*medium);
    video.file = file["uri"].text();
    if (!file.has("tracks")) return video;
    const std::vector<Node> tracks = gltf_array(file["tracks"]);
    if (!frames->has("tracks")) {
        for (const Node& track : tracks) video.tracks.push_back(track_number(track["track"]));
        return video;
    }
    for (const Node& index : gltf_array((*frames)["tracks"])) {
        const auto k = static_cast<std::size_t>(index.whole());
        if (k >= tracks.size())
            index.refuse("a number of one of " + std::to_string(tracks.size()) + " tracks");
        video.tracks.push_back(track_number(tracks[k]["track"]));
    }
    return video;
}

}  // namespace touchable
