// SPDX-License-Identifier: Apache-2.0
// Reads a clip's metadata from MP4: an MPEG-4 scene, tags, and names of tracks.
#include <algorithm>
#include <cstring>
#include <map>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/clip/track_codecs.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

constexpr ClipContainer::Words mp4_words{"tag T3D_SCENE", "tag T3D_TIMES", mp4_format_version};

/// The MPEG-4 scene of a file, as far as it has one.
struct FoundScene {
    std::optional<Mp4Scene> scene{};  // if it is a touchable clip
    bool is_damaged = false;          // it may be a clip, or none
    std::string fault{};              // why it is no clip; empty: it is one, or is absent
};

FoundScene scene_in(const mpeg4::Bytes& movie, ByteSource& file) {
    const auto damaged = [](const std::string& why) { return FoundScene{.is_damaged = true, .fault = why}; };
    auto stream = mpeg4::read_scene_stream(
        movie, [&file](std::uint64_t at, std::uint64_t count) { return mpeg4::bytes_at(file, at, count); });
    if (!stream) return damaged("its MPEG-4 scene cannot be read: " + stream.error().message);
    if (!*stream) return {};
    const auto tree = mpeg4::decode_scene((*stream)->scene, (*stream)->config);
    if (!tree) return damaged("its MPEG-4 scene is damaged: " + tree.error().message);
    auto nodes = mpeg4::clip_nodes_of(*tree);
    if (!nodes)
        return {.is_damaged = !tree->has_names && !tree->prototypes.empty(),
                .fault = "its MPEG-4 scene is no touchable clip: " + nodes.error().message};
    return {.scene = Mp4Scene{std::move(**stream), std::move(*nodes)}};
}

/// The video stream of this track number; `what`: its purpose, for messages.
Result<std::optional<int>> stream_numbered(const Demuxer& file, std::uint32_t track,
                                           const std::string& what) {
    const AVFormatContext& container = file.container();
    for (const AVStream* const stream : std::span(container.streams, container.nb_streams))
        if (stream->id == static_cast<int>(track) && stream->codecpar->codec_type == AVMEDIA_TYPE_VIDEO)
            return std::optional(stream->index);
    return input_error(what + ", track " + std::to_string(track) + ", which has no pictures");
}

std::optional<mpeg4::ClipNodes::Texture> texture_of_plane(const mpeg4::ClipNodes& nodes, PlaneRole role) {
    const std::optional<mpeg4::ClipNodes::Texture> textures[] = {nodes.depth, nodes.colour, nodes.haptic,
                                                                 nodes.height};
    return textures[static_cast<std::size_t>(role)];
}

std::string object_in_words(const std::string& plane, const mpeg4::ClipNodes::Texture& texture) {
    return "its MPEG-4 scene: " + plane + " is object " + std::to_string(texture.url.object);
}

Result<std::optional<int>> stream_of_plane(const Mp4Scene& scene, const Demuxer& file, PlaneRole role) {
    TRY_ASSIGN(const auto track, track_of_plane(scene, role));
    if (!track) return std::optional<int>();
    return stream_numbered(
        file, *track, object_in_words(std::string(role_name(role)), *texture_of_plane(scene.nodes, role)));
}

/// Whether tracks have the names that programs give the planes in files without a scene.
bool has_tracks_of_touch(mpeg4::BytesView movie) {
    const auto parts = mpeg4::boxes_in(movie);
    bool has_depth = false, has_more = false;
    for (const mpeg4::Box& part : parts ? *parts : std::vector<mpeg4::Box>()) {
        constexpr std::size_t name_at = 24;
        const mpeg4::BytesView handler = mpeg4::content_at(part.content, {"mdia", "hdlr"});
        if (part.type != "trak" || handler.size() <= name_at) continue;
        std::string name(handler.begin() + name_at, handler.end());
        name = name.substr(0, name.find('\0'));
        has_depth = has_depth || name == role_name(PlaneRole::depth);
        has_more = has_more || name == role_name(PlaneRole::haptic) || name == role_name(PlaneRole::height);
    }
    return has_depth && has_more;
}

/// An MPEG-4 scene gives each plane's track and, as far as it can, its meaning; tags give the rest. A file
/// without a scene, such as a fragmented one, has tags and names of tracks instead.
class Mp4Container final : public ClipContainer {
public:
    Mp4Container(const SourceFile& source, const std::optional<PlaneTracks>& told)
        : ClipContainer(source, mp4_words), told_(told) {}
    Result<std::unique_ptr<Demuxer>> open() override {
        TRY_ASSIGN(auto file, bytes_of_file(source_));
        if (!is_looked_at_) TRY(look_at(*file));
        auto opened = Demuxer::open_quicktime(
            fragments_ ? mpeg4::plain_file(*fragments_, std::move(file)) : std::move(file), file_);
        // FFmpeg's error for files of MP4Box does not mention the scene.
        if (!opened && !scene_.fault.empty()) return refuse_scene();
        return opened;
    }

    /// A file by another program has the rate of its depth track.
    Result<FrameRate> rate(const Demuxer& file) override {
        if (file.tag(clip_tags::version_tag))
            return shortened(tagged_rate(file, file.tag(clip_tags::mp4_times_tag)), file);
        TRY_ASSIGN(const auto depth, stream_of(file, PlaneRole::depth));
        if (!depth) return refuse_scene();
        const AVRational said = file.container().streams[*depth]->avg_frame_rate;
        const FrameRate rate{said.num, said.den};
        if (said.num <= 0 || said.den <= 0 || clip_tags::is_too_fast(rate))
            return refuse("its depth says no frame rate of at most " +
                          std::to_string(clip_tags::fastest_rate) + "/1");
        return rate;
    }

    Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) override {
        notes_.clear();
        if (!scene_.fault.empty()) return refuse_scene();
        const auto& scene = scene_.scene;
        const std::string in_scene = file_ + ": its MPEG-4 scene";
        if (const auto json = file.tag(clip_tags::mp4_scene_tag)) {
            auto described = described_by(*json, recorded);
            if (!described || !scene) return described;
            TRY_ASSIGN(const auto is_other,
                       error_at(in_scene, mpeg4::take_nodes(scene->nodes, described->scene)));
            if (!is_other) return described;
            notes_.emplace_back("its MPEG-4 scene says another camera, other planes or ranges than its tag " +
                                std::string(clip_tags::mp4_scene_tag) + ": the scene stands");
            TRY(error_at(in_scene, validate(*described)));
            return described;
        }
        if (!scene) return refuse_scene();
        TRY_ASSIGN(const auto depth, stream_of(file, PlaneRole::depth));
        const AVCodecParameters& stored = *file.container().streams[depth.value_or(0)]->codecpar;
        constexpr int bits = 8;
        TRY_ASSIGN(auto described,
                   error_at(in_scene, mpeg4::described_by(scene->nodes, stored.width, stored.height, bits)));
        described.scene.name = source_.path().stem().string();
        for (const PlaneRole role : {PlaneRole::depth, PlaneRole::height})
            if (const auto low = low_stream_of(file, role); low && *low)
                notes_.push_back("the low bits of " + std::string(role_name(role)) + ", in its track " +
                                 std::string(role_name(role)) + low_track_suffix + ", are left out: no tag " +
                                 clip_tags::mp4_scene_tag + " says what they are");
        return described;
    }

    Result<std::vector<Track>> tracks(const Demuxer& file, const Scene& scene) override {
        std::vector<Track> tracks;
        std::map<int, std::string> used;  // streams
        for (const PlaneRole role : all_roles) {
            TRY_ASSIGN(const auto stream, stream_of(file, role));
            if (!stream && role == PlaneRole::depth) return refuse("has no track of depth");
            if (!stream) continue;
            Track track{role, *stream};
            TRY_ASSIGN(track.low_bits, low_bits(file, role, scene));
            if (track.low_bits > 0) TRY(assign(track.low_stream, low_stream_of(file, role)));
            const auto is_lossless = [&](int number) {
                return is_coded_without_loss(*file.container().streams[number]->codecpar);
            };
            track.is_lossless =
                is_lossless(track.stream) && (!track.low_stream || is_lossless(*track.low_stream));
            const std::string name(role_name(role));
            const std::pair<std::optional<int>, std::string> parts[] = {
                {track.stream, name}, {track.low_stream, "low bits of " + name}};
            for (const auto& [part, what] : parts) {
                if (!part) continue;
                const auto [other, is_first] = used.emplace(*part, what);
                if (!is_first)
                    return refuse("its " + what + " is the same track as its " + other->second +
                                  ": must be one of its own");
            }
            tracks.push_back(track);
        }
        return tracks;
    }

    std::optional<std::string> poses(const Demuxer& file) override {
        return file.tag(clip_tags::mp4_poses_tag);
    }
    bool has_whole_index() const override { return true; }
    Result<std::optional<WholePart>> whole_part(const Demuxer& file) override {
        if (!fragments_) return std::optional<WholePart>();
        TRY_ASSIGN(const auto all, streams(file));
        std::vector<std::int64_t> counts;
        for (const int stream : all) counts.push_back(file.pictures(stream));
        if (counts.empty()) return std::optional(WholePart{0, fragments_->is_cut});
        const auto [fewest, most] = std::minmax_element(counts.begin(), counts.end());
        return std::optional(WholePart{*fewest, fragments_->is_cut, *fewest != *most});
    }

private:
    Result<void> look_at(ByteSource& file) {
        TRY_ASSIGN(const auto movie, error_at(file_, mpeg4::movie_head_of(file)));
        if (!told_) scene_ = scene_in(movie, file);
        TRY_ASSIGN(fragments_, error_at(file_, mpeg4::gather_fragments(file)));
        is_looked_at_ = true;
        return {};
    }

    /// Streams of every plane, those with low bits included.
    Result<std::vector<int>> streams(const Demuxer& file) const {
        std::vector<int> all;
        for (const PlaneRole role : all_roles) {
            TRY_ASSIGN(const auto stream, stream_of(file, role));
            TRY_ASSIGN(const auto low, low_stream_of(file, role));
            for (const auto& each : {stream, low})
                if (each) all.push_back(*each);
        }
        return all;
    }

    /// Drops the times of frames that were cut off.
    Result<FrameRate> shortened(Result<FrameRate> rate, const Demuxer& file) {
        TRY_ASSIGN(const auto whole, whole_part(file));
        if (!rate || !rate->own_times || !whole) return rate;
        const auto frames = static_cast<std::size_t>(whole->frames);
        if (frames >= rate->own_times->size()) return rate;
        std::vector<std::int64_t> times = *rate->own_times;
        times.resize(frames);
        constexpr std::size_t fewest = 2;  // in a list of times
        if (frames < fewest)
            rate->own_times = nullptr;
        else
            rate->own_times = std::make_shared<const std::vector<std::int64_t>>(std::move(times));
        return rate;
    }

    Error refuse_scene() const {
        const std::string why =
            scene_.fault.empty() ? "has neither an MPEG-4 scene nor a tag T3D_SCENE" : scene_.fault;
        return refuse(why + ": describe it with a scene file", {{Setting::scene_file, "FILE"}});
    }

    /// Bits per sample in the track with the low bits: as the file's tag says, even if another scene replaces
    /// it.
    Result<int> low_bits(const Demuxer& file, PlaneRole role, const Scene& scene) const {
        const auto json = file.tag(clip_tags::mp4_scene_tag);
        if (role != PlaneRole::depth && role != PlaneRole::height) return 0;
        TRY_ASSIGN(const auto tagged, json ? parse_scene(*json, file_ + ": " + words_.scene)
                                           : Result<SceneDescription>(SceneDescription(scene)));
        const Scene& stored = tagged.scene;
        return std::max(
            0, (role == PlaneRole::depth ? stored.depth_bits : height_bits(stored.height_coding)) - 8);
    }

    Result<std::optional<int>> stream_of(const Demuxer& file, PlaneRole role) const {
        const std::string name(role_name(role));
        if (told_) {
            const auto& numbers = (*told_)[static_cast<std::size_t>(role)];
            return numbers.empty() ? std::optional<int>()
                                   : error_at(file_, stream_numbered(file, numbers[0], name));
        }
        if (scene_.scene) return error_at(file_, stream_of_plane(*scene_.scene, file, role));
        const auto named = stream_named(file, name);
        return named || role != PlaneRole::colour ? named : stream_named(file, "color");
    }

    static std::optional<int> stream_named(const Demuxer& file, const std::string& name) {
        for (const auto& [stream, handler] : file.tagged_pictures("handler_name"))
            if (handler == name) return stream->index;
        return std::nullopt;
    }

    Result<std::optional<int>> low_stream_of(const Demuxer& file, PlaneRole role) const {
        const std::string name = std::string(role_name(role)) + low_track_suffix;
        if (!told_) return stream_named(file, name);
        const auto& numbers = (*told_)[static_cast<std::size_t>(role)];
        return numbers.size() < 2 ? std::optional<int>()
                                  : error_at(file_, stream_numbered(file, numbers[1], name));
    }

    std::optional<PlaneTracks> told_;
    bool is_looked_at_ = false;
    std::optional<mpeg4::GatheredMovie> fragments_;
    FoundScene scene_;
};

}  // namespace

Result<std::optional<Mp4Scene>> read_mp4_scene(const SourceFile& file) {
    TRY_ASSIGN(const auto bytes, bytes_of_file(file));
    TRY_ASSIGN(const auto movie, error_at(file.string(), mpeg4::movie_head_of(*bytes)));
    FoundScene found = scene_in(movie, *bytes);
    if (!found.fault.empty()) return input_error(file.string() + ": " + found.fault);
    return std::move(found.scene);
}

Result<std::optional<std::uint32_t>> track_of_plane(const Mp4Scene& scene, PlaneRole role) {
    const std::string name(role_name(role));
    const auto texture = texture_of_plane(scene.nodes, role);
    if (!texture) return std::optional<std::uint32_t>();
    if (texture->url.object == 0)
        return input_error("its MPEG-4 scene has " + name + " in another file (" +
                           in_quotes(texture->url.file) + "): must be a track of its own");
    const auto track = scene.stream.objects.find(texture->url.object);
    if (track == scene.stream.objects.end())
        return input_error(object_in_words(name, *texture) + ", which is no track");
    return std::optional(track->second);
}

bool is_mp4_clip(const SourceFile& file, bool is_described) {
    const auto bytes = bytes_of_file(file);
    const auto movie = bytes ? mpeg4::movie_head_of(**bytes) : Result<mpeg4::Bytes>(bytes.error());
    if (!movie) return false;
    const std::string_view tag = clip_tags::version_tag;
    if (std::search(movie->begin(), movie->end(), tag.begin(), tag.end()) != movie->end()) return true;
    const FoundScene found = scene_in(*movie, **bytes);
    if (found.scene || has_tracks_of_touch(*movie)) return true;
    return !is_described && !found.fault.empty() && (found.is_damaged || !Demuxer::open_quicktime(file));
}

std::unique_ptr<ClipContainer> mp4_container(const SourceFile& file, const std::optional<PlaneTracks>& told) {
    return std::make_unique<Mp4Container>(file, told);
}

}  // namespace touchable
