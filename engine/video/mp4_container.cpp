#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "engine/byte_source.hpp"
#include "engine/mpeg4/bit_stream.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/mpeg4/scene_stream.hpp"
#include "engine/printable.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/video/clip_container.hpp"
#include "engine/video/clip_file_reader.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/mp4_writer.hpp"

namespace touchable {
namespace {

Result<mpeg4::Bytes> bytes_at(ByteSource& file, std::uint64_t at, std::uint64_t count) {
    if (count > file.size() || at > file.size() - count)
        return input_error("is cut short: " + std::to_string(count) + " bytes at " + std::to_string(at) +
                           " are not there");
    mpeg4::Bytes bytes(count);
    if (auto read = file.read(at, reinterpret_cast<char*>(bytes.data()), bytes.size()); !read)
        return read.error();
    return bytes;
}

/// The content of the movie box; empty where there is none.
Result<mpeg4::Bytes> movie_box_of(ByteSource& file) {
    constexpr std::uint64_t most_bytes = std::uint64_t{64} << 20;
    for (std::uint64_t at = 0; at + 8 <= file.size();) {
        const auto head = bytes_at(file, at, std::min<std::uint64_t>(16, file.size() - at));
        if (!head) return head.error();
        const std::uint64_t stated = mpeg4::number_at(*head, 0, 4);
        const std::uint64_t size = stated == 1   ? mpeg4::number_at(*head, 8, 8)
                                   : stated == 0 ? file.size() - at
                                                 : stated;
        const std::uint64_t before = stated == 1 ? 16 : 8;
        if (size < before || size > file.size() - at) break;
        if (std::memcmp(head->data() + 4, "moov", 4) == 0) {
            if (size > most_bytes) return input_error("its movie box has more than 64 MiB");
            return bytes_at(file, at + before, size - before);
        }
        at += size;
    }
    return mpeg4::Bytes();
}

/// Whether its coding may leave out the transform, without which it keeps every value: a flag of the
/// sequence's parameters (ISO/IEC 14496-10, 7.3.2.1.1), for which encoders ask only where they are to be
/// lossless.
bool is_lossless_h264(const Demuxer& file, int stream) {
    constexpr std::size_t sequence_at = 8;  // in avcC
    constexpr std::uint64_t high_444_predictive = 244;
    const AVCodecParameters& stored = *file.container().streams[stream]->codecpar;
    const mpeg4::BytesView bytes(stored.extradata, static_cast<std::size_t>(stored.extradata_size));
    if (stored.codec_id != AV_CODEC_ID_H264 || bytes.size() <= sequence_at) return false;
    mpeg4::BitReader bits(bytes.subspan(sequence_at));
    const auto number = [&bits] {  // Exp-Golomb: as many bits follow as zeros came
        int zeros = 0;
        while (zeros < 32 && !bits.flag()) ++zeros;
        return (std::uint64_t{1} << zeros) - 1 + bits.get(zeros);
    };
    bits.get(8);
    if (bits.get(8) != high_444_predictive) return false;
    bits.get(16);
    number();
    constexpr std::uint64_t colours_at_full_size = 3;
    if (number() == colours_at_full_size) bits.get(1);
    number();
    number();
    const bool leaves_out_transform = bits.flag();
    return leaves_out_transform && !bits.is_over();
}

constexpr ContainerWords mp4_words{"tag T3D_SCENE", "tag T3D_TIMES"};

/// An MPEG-4 scene says which track is which plane, and what the planes mean, as far as it can; tags say the
/// rest. A file without a scene, such as a fragmented one, says it by tags and by the names of its tracks.
class Mp4Container final : public ClipContainer {
public:
    Mp4Container(const SourceFile& source, const std::optional<PlaneTracks>& told)
        : ClipContainer(source, mp4_words), told_(told) {}
    Result<std::unique_ptr<Demuxer>> open() override;
    Result<FrameRate> rate(const Demuxer& file) override;
    Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) override;
    Result<std::vector<ClipTrack>> tracks(const Demuxer& file, const Scene& scene) override;
    bool has_whole_index() const override { return true; }

private:
    Result<void> read_scene_stream();
    Result<int> low_bits(const Demuxer& file, PlaneRole role, const Scene& scene) const;
    Result<std::optional<int>> stream_of(const Demuxer& file, PlaneRole role) const;
    Result<std::optional<int>> low_stream_of(const Demuxer& file, PlaneRole role) const;
    Result<int> stream_numbered(const Demuxer& file, std::uint32_t track, const std::string& what) const;
    static std::optional<int> stream_named(const Demuxer& file, const std::string& name);

    std::optional<PlaneTracks> told_;
    std::optional<mpeg4::SceneStream> stream_;
    std::optional<mpeg4::ClipNodes> nodes_;
};

Result<std::unique_ptr<Demuxer>> Mp4Container::open() {
    if (!nodes_ && !told_)
        if (auto read = read_scene_stream(); !read) return read.error();
    return Demuxer::open_quicktime(source_);
}

Result<void> Mp4Container::read_scene_stream() {
    const auto file = bytes_of_file(source_);
    if (!file) return file.error();
    const auto movie = movie_box_of(**file);
    if (!movie) return refuse(movie.error().message);
    auto stream = mpeg4::read_scene_stream(
        *movie, [&](std::uint64_t at, std::uint64_t count) { return bytes_at(**file, at, count); });
    if (!stream) return refuse("its MPEG-4 scene cannot be read: " + stream.error().message);
    if (!*stream) return {};
    stream_ = std::move(**stream);
    const auto scene = mpeg4::decode_scene(stream_->scene, stream_->config);
    if (!scene) return refuse("its MPEG-4 scene is damaged: " + scene.error().message);
    auto nodes = mpeg4::clip_nodes_of(*scene);
    if (!nodes) return refuse("its MPEG-4 scene is no touchable clip: " + nodes.error().message);
    nodes_ = std::move(*nodes);
    return {};
}

/// Of a file that another program wrote: that of its pictures of depth.
Result<FrameRate> Mp4Container::rate(const Demuxer& file) {
    if (!file.tag(clip_tags::version_tag) && (nodes_ || told_)) {
        const auto depth = stream_of(file, PlaneRole::depth);
        if (!depth) return depth.error();
        const AVRational said = file.container().streams[depth->value_or(0)]->avg_frame_rate;
        const FrameRate rate{said.num, said.den};
        if (said.num <= 0 || said.den <= 0 || clip_tags::is_too_fast(rate))
            return refuse("its depth says no frame rate of at most " +
                          std::to_string(clip_tags::fastest_rate) + "/1");
        return rate;
    }
    return tagged_rate(file, file.tag(mp4_times_tag));
}

Result<SceneDescription> Mp4Container::scene(const Demuxer& file, const FrameRate& recorded) {
    notes_.clear();
    if (const auto json = file.tag(mp4_scene_tag)) {
        auto described = described_by(*json, recorded);
        if (!described) return described;
        if (!nodes_) return described;
        const auto is_other = mpeg4::take_nodes(*nodes_, described->scene);
        if (!is_other) return refuse("its MPEG-4 scene: " + is_other.error().message);
        if (!*is_other) return described;
        notes_.emplace_back("its MPEG-4 scene says another camera, other planes or ranges than its tag " +
                            std::string(mp4_scene_tag) + ": the scene stands");
        if (auto valid = validate(*described); !valid)
            return refuse("its MPEG-4 scene: " + valid.error().message);
        return described;
    }
    if (!nodes_)
        return refuse("has neither an MPEG-4 scene nor a tag " + std::string(mp4_scene_tag) +
                          ": describe it with a scene file",
                      {{Setting::scene_file, "FILE"}});
    const auto depth = stream_of(file, PlaneRole::depth);
    if (!depth) return depth.error();
    const AVCodecParameters& stored = *file.container().streams[depth->value_or(0)]->codecpar;
    constexpr int bits = 8;
    auto described = mpeg4::described_by(*nodes_, stored.width, stored.height, bits);
    if (!described) return refuse("its MPEG-4 scene: " + described.error().message);
    described->scene.name = source_.path().stem().string();
    for (const PlaneRole role : {PlaneRole::depth, PlaneRole::height})
        if (const std::string low = std::string(role_name(role)) + low_track_suffix; stream_named(file, low))
            notes_.push_back("the low bits of " + std::string(role_name(role)) + ", in its track " + low +
                             ", are left out: no tag " + mp4_scene_tag + " says what they are");
    return described;
}

std::optional<int> Mp4Container::stream_named(const Demuxer& file, const std::string& name) {
    const AVFormatContext& container = file.container();
    for (unsigned k = 0; k < container.nb_streams; ++k) {
        const AVStream& stream = *container.streams[k];
        const AVDictionaryEntry* handler = av_dict_get(stream.metadata, "handler_name", nullptr, 0);
        if (stream.codecpar->codec_type == AVMEDIA_TYPE_VIDEO && handler && handler->value == name)
            return static_cast<int>(k);
    }
    return std::nullopt;
}

Result<int> Mp4Container::stream_numbered(const Demuxer& file, std::uint32_t track,
                                          const std::string& what) const {
    const AVFormatContext& container = file.container();
    for (unsigned k = 0; k < container.nb_streams; ++k)
        if (container.streams[k]->id == static_cast<int>(track) &&
            container.streams[k]->codecpar->codec_type == AVMEDIA_TYPE_VIDEO)
            return static_cast<int>(k);
    return refuse(what + ", track " + std::to_string(track) + ", which has no pictures");
}

Result<std::optional<int>> Mp4Container::stream_of(const Demuxer& file, PlaneRole role) const {
    const std::string name(role_name(role));
    const auto numbered = [&](std::uint32_t track, const std::string& what) -> Result<std::optional<int>> {
        const auto stream = stream_numbered(file, track, what);
        if (!stream) return stream.error();
        return std::optional(*stream);
    };
    if (told_) {
        const auto& track = (*told_)[static_cast<std::size_t>(role)];
        return track ? numbered(track->track, name) : std::optional<int>();
    }
    if (!nodes_) return stream_named(file, name);
    const std::optional<mpeg4::PlaneTexture> textures[] = {nodes_->depth, nodes_->colour, nodes_->haptic,
                                                           nodes_->height};
    const auto& texture = textures[static_cast<std::size_t>(role)];
    if (!texture) return std::optional<int>();
    if (texture->url.object == 0)
        return refuse("its MPEG-4 scene has " + name + " in another file (" + in_quotes(texture->url.file) +
                      "): must be a track of its own");
    const auto track = stream_->objects.find(texture->url.object);
    const std::string object =
        "its MPEG-4 scene: " + name + " is object " + std::to_string(texture->url.object);
    if (track == stream_->objects.end()) return refuse(object + ", which is no track");
    return numbered(track->second, object);
}

Result<std::optional<int>> Mp4Container::low_stream_of(const Demuxer& file, PlaneRole role) const {
    const std::string name = std::string(role_name(role)) + low_track_suffix;
    if (!told_) return stream_named(file, name);
    const auto& track = (*told_)[static_cast<std::size_t>(role)];
    if (!track || !track->low) return std::optional<int>();
    const auto stream = stream_numbered(file, *track->low, name);
    if (!stream) return stream.error();
    return std::optional(*stream);
}

/// How many of a sample's bits a track with the low ones has: as its tag says, whatever scene replaces that.
Result<int> Mp4Container::low_bits(const Demuxer& file, PlaneRole role, const Scene& scene) const {
    const auto json = file.tag(mp4_scene_tag);
    if (role != PlaneRole::depth && role != PlaneRole::height) return 0;
    const auto tagged = json ? parse_scene(*json, file_ + ": " + words_.scene)
                             : Result<SceneDescription>(SceneDescription(scene));
    if (!tagged) return tagged.error();
    const Scene& stored = tagged->scene;
    return std::max(0,
                    (role == PlaneRole::depth ? stored.depth_bits : height_bits(stored.height_coding)) - 8);
}

Result<std::vector<ClipTrack>> Mp4Container::tracks(const Demuxer& file, const Scene& scene) {
    std::vector<ClipTrack> tracks;
    for (const PlaneRole role : all_roles) {
        const auto stream = stream_of(file, role);
        if (!stream) return stream.error();
        if (!*stream && role == PlaneRole::depth) return refuse("has no track of depth");
        if (!*stream) continue;
        ClipTrack track{role, **stream};
        const auto bits = low_bits(file, role, scene);
        if (!bits) return bits.error();
        track.low_bits = *bits;
        const auto low = *bits > 0 ? low_stream_of(file, role) : Result<std::optional<int>>(std::nullopt);
        if (!low) return low.error();
        track.low_stream = *low;
        track.is_lossless = is_lossless_h264(file, track.stream) &&
                            (!track.low_stream || is_lossless_h264(file, *track.low_stream));
        for (const ClipTrack& other : tracks)
            if (other.stream == track.stream)
                return refuse("its " + std::string(role_name(role)) + " is the same track as its " +
                              std::string(role_name(other.role)) + ": must be one of its own");
        tracks.push_back(track);
    }
    return tracks;
}

}  // namespace

bool is_mp4_clip(const SourceFile& file) {
    const auto bytes = bytes_of_file(file);
    const auto movie = bytes ? movie_box_of(**bytes) : Result<mpeg4::Bytes>(bytes.error());
    if (!movie) return false;
    const auto has = [&](std::string_view word) {
        return std::search(movie->begin(), movie->end(), word.begin(), word.end()) != movie->end();
    };
    return has(clip_tags::version_tag) || has("sdsm");
}

std::unique_ptr<ClipContainer> mp4_container(const SourceFile& file, const std::optional<PlaneTracks>& told) {
    return std::make_unique<Mp4Container>(file, told);
}

}  // namespace touchable
