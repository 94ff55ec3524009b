// SPDX-License-Identifier: Apache-2.0
// A static MPEG-4 scene in one MP4 file, whose planes are tracks of one picture each: the reader, then the
// writer.

#include "engine/formats/formats_read.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/containers.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/image.hpp"

namespace touchable {
namespace {

/// The file's movie box, without the tables of where samples are.
Result<mpeg4::Bytes> movie_of(const SourceFile& file) {
    TRY_ASSIGN(const auto bytes, bytes_of_file(file));
    return mpeg4::movie_head_of(*bytes);
}

/// The first sample of a plane's track; nothing if the scene has no such plane. Errors do not name the file.
Result<std::optional<mpeg4::FirstSample>> sample_of_plane(const mpeg4::Bytes& movie, const Mp4Scene& scene,
                                                          PlaneRole role) {
    TRY_ASSIGN(const auto track, track_of_plane(scene, role));
    if (!track) return std::optional<mpeg4::FirstSample>();
    TRY_ASSIGN(const auto sample, error_at("its MPEG-4 scene: " + std::string(role_name(role)),
                                           mpeg4::first_sample_of(movie, *track)));
    return std::optional(sample);
}

constexpr std::uint64_t largest_picture = std::uint64_t{257} << 20;  // as for a picture in a file

/// Whether bytes begin as one of the object types of an ImageTexture.
bool is_png_or_jpeg(const mpeg4::Bytes& begin) {
    const std::string_view kind = picture_kind({reinterpret_cast<const char*>(begin.data()), begin.size()});
    return kind == "PNG" || kind == "JPEG";
}

/// Refuses a moving texture beside still ones.
Result<void> check_textures(const mpeg4::ClipNodes& nodes, const std::string& file) {
    for (const auto& [texture, plane] :
         {std::pair{&nodes.colour, "colour"}, {&nodes.haptic, "haptic"}, {&nodes.height, "height"}})
        if (*texture && (*texture)->is_movie)
            return input_error(file + ": its MPEG-4 scene has depth in an ImageTexture and " + plane +
                               " in a MovieTexture: must all be one or the other");
    return {};
}

/// Reads each plane's picture, the first sample of its track; not by FFmpeg, which refuses MP4Box's files.
class Mp4Stills final : public FrameSource {
public:
    explicit Mp4Stills(const SourceFile& source) : source_(source), file_(source.string()) {}

    Result<void> find(const Mp4Scene& scene, StoredClip& clip) {
        TRY(check_textures(scene.nodes, file_));
        TRY_ASSIGN(const auto movie, error_at(file_, movie_of(source_)));
        for (const PlaneRole role : all_roles) {
            TRY_ASSIGN(const auto sample, error_at(file_, sample_of_plane(movie, scene, role)));
            if (!sample) continue;
            samples_[static_cast<std::size_t>(role)] = *sample;
            clip.roles.push_back(role);
            if (sample->count > 1)
                clip.notes.push_back("track " + std::string(role_name(role)) + " has " +
                                     std::to_string(sample->count) +
                                     " pictures; its ImageTexture is the first");
        }
        return {};
    }

    void rule(DepthCodingKind depth) { rules_.depth = depth; }

    std::string where(PlaneRole role, std::int64_t) const override {
        return file_ + ": track " + std::string(role_name(role));
    }

    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        TRY_ASSIGN(auto read, stored(role));
        return track_picture(std::move(read), role, rules_, where(role, frame));
    }

    Result<StoredImage> stored(PlaneRole role) const {
        TRY_ASSIGN(const auto file, bytes_of_file(source_));
        const auto& [at, size, count] = samples_[static_cast<std::size_t>(role)];
        const auto picture = size > largest_picture
                                 ? input_error("has " + std::to_string(size) + " bytes: must be " +
                                               std::to_string(largest_picture) + " at most")
                                 : mpeg4::bytes_at(*file, at, size);
        if (!picture) return error_at(where(role, 0), picture.error());
        if (!is_png_or_jpeg(*picture)) return input_error(where(role, 0) + ": is neither PNG nor JPEG");
        return decode_stored_image(std::string(picture->begin(), picture->end()), where(role, 0));
    }

private:
    SourceFile source_;
    std::string file_;
    StillRules rules_{DepthCodingKind::linear, true};  // the paper's own example is lossy
    std::array<mpeg4::FirstSample, all_roles.size()> samples_{};
};

/// Ordinary players show the first track.
constexpr std::pair<PlaneRole, std::uint16_t> still_order[] = {{PlaneRole::colour, mpeg4::colour_object},
                                                               {PlaneRole::depth, mpeg4::depth_object},
                                                               {PlaneRole::haptic, mpeg4::haptic_object},
                                                               {PlaneRole::height, mpeg4::height_object}};

/// The description of a picture, which has no time.
SceneDescription without_rate(SceneDescription described) {
    described.scene.rate = {1, 1};
    return described;
}

class Mp4StillsWriter final : public MuxedClipWriter {
public:
    Mp4StillsWriter(const std::filesystem::path& path, const SceneDescription& described, Existing existing)
        : MuxedClipWriter(path, without_rate(described), {}, existing, "mp4"), pictures_(described) {}

private:
    Result<void> add(const RawFrame& frame) override {
        if (!roles_.empty()) return internal_error(output_.target().string() + ": is of one frame");
        std::vector<std::string> pngs;
        for (const auto& [role, object] : still_order) {
            const PlaneView& plane = plane_of(frame, role);
            if (plane.empty()) continue;
            TRY(assign(pngs.emplace_back(), png_bytes(plane, PngEffort::quick, png_colours(role))));
            TRY(add_track(role));
            objects_[object] = static_cast<std::uint32_t>(roles_.size());
        }
        TRY(make_scene());
        TRY(write_header());
        for (std::size_t track = 0; track < pngs.size(); ++track) TRY(add_picture(track, pngs[track]));
        return {};
    }

    Result<void> add_track(PlaneRole role) {
        AVStream* const stream = avformat_new_stream(muxer_.get(), nullptr);
        if (!stream) return memory_error();
        AVCodecParameters& stored = *stream->codecpar;
        stored.codec_type = AVMEDIA_TYPE_VIDEO;
        stored.codec_id = AV_CODEC_ID_PNG;
        stored.width = scene_.width;
        stored.height = scene_.height;
        roles_.push_back(role);
        stream->id = static_cast<int>(roles_.size());
        stream->time_base = {1, 1000};
        av_dict_set(&stream->metadata, "handler_name", std::string(role_name(role)).c_str(), 0);
        return {};
    }

    /// Adds a picture that lasts a second, as a still picture has no time.
    Result<void> add_picture(std::size_t track, const std::string& png) {
        const PacketPtr packet(av_packet_alloc());
        if (!packet || av_new_packet(packet.get(), static_cast<int>(png.size())) < 0) return memory_error();
        std::memcpy(packet->data, png.data(), png.size());
        packet->pts = packet->dts = 0;
        packet->duration = 1;
        packet->flags |= AV_PKT_FLAG_KEY;
        return write_picture(*packet, track, {1, 1});
    }

    Result<void> make_scene() {
        Scene& scene = pictures_.scene;
        scene.stored = {};  // as codes
        scene.folder.emplace();
        for (const PlaneRole role : roles_) pattern_of(*scene.folder, role) = role_name(role);
        mpeg4::ClipNodes nodes = mpeg4::nodes_of_pictures(pictures_);
        for (const auto& [role, object] : still_order) {
            if (!objects_.contains(object)) continue;
            const mpeg4::ClipNodes::Texture texture{{.object = object}, false};
            if (role == PlaneRole::depth) nodes.depth = texture;
            if (role == PlaneRole::colour) nodes.colour = texture;
            if (role == PlaneRole::haptic) nodes.haptic = texture;
            if (role == PlaneRole::height) nodes.height = texture;
        }
        return set_scene(nodes, std::move(objects_));
    }

    SceneDescription pictures_;
    std::vector<PlaneRole> roles_;  // of each track
    std::map<std::uint16_t, std::uint32_t> objects_;  // the track of each
};

}  // namespace

bool is_mp4_stills(const SourceFile& file) {
    const auto scene = read_mp4_scene(file);
    if (!scene || !*scene || (*scene)->nodes.depth.is_movie) return false;
    const auto movie = movie_of(file);
    if (!movie) return false;
    const auto sample = sample_of_plane(*movie, **scene, PlaneRole::depth);
    const auto bytes = bytes_of_file(file);
    if (!sample || !*sample || !bytes) return false;
    constexpr std::uint64_t told_by = 16;
    const auto begin = mpeg4::bytes_at(**bytes, (*sample)->at, std::min(told_by, (*sample)->bytes));
    return begin && is_png_or_jpeg(*begin);
}

Opened open_mp4_stills(const Candidate& candidate) {
    const SourceFile& file = candidate.source;
    TRY_ASSIGN(const auto scene, read_mp4_scene(file));
    if (!scene) return input_error(file.string() + ": has no MPEG-4 scene");
    StoredClip clip{file.string(), candidate.described().value_or(SceneDescription())};
    auto pictures = std::make_unique<Mp4Stills>(file);
    TRY(pictures->find(*scene, clip));
    clip.inputs = {file.path()};
    clip.count = 1;
    if (!candidate.scene) {
        TRY_ASSIGN(const auto depth, pictures->stored(PlaneRole::depth));
        std::vector<std::string> notes;
        TRY_ASSIGN(clip.described,
                   error_at(file.string() + ": its MPEG-4 scene",
                            mpeg4::described_by_pictures(scene->nodes, depth.image.width, depth.image.height,
                                                         depth.bits, notes)));
        clip.notes.insert(clip.notes.end(), notes.begin(), notes.end());
        if (clip.described.scene.name.empty()) clip.described.scene.name = file.path().stem().string();
    }
    clip.described.scene.folder.reset();
    clip.described.scene.video.reset();
    pictures->rule(clip.described.scene.depth.kind);
    clip.pictures = std::move(pictures);
    return open_stored_clip(std::move(clip), candidate.wanted.colour);
}

Result<std::unique_ptr<ClipWriter>> create_mp4_stills(const std::filesystem::path& path,
                                                      const SceneDescription& described, Existing existing) {
    return opened_as<ClipWriter>(std::make_unique<Mp4StillsWriter>(path, described, existing), std::nullopt);
}

}  // namespace touchable
