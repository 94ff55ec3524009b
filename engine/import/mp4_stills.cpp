#include "engine/import/mp4_stills.hpp"

#include <array>
#include <string>
#include <utility>

#include "engine/ffmpeg/demuxer.hpp"
#include "engine/import/guess/stored_clip.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/video/mp4_scene.hpp"

namespace touchable {
namespace {

/// Each plane's picture, the first sample of its track.
class Mp4Stills final : public FrameSource {
public:
    explicit Mp4Stills(const SourceFile& source) : source_(source), file_(source.string()) {}
    Result<void> find(const Mp4Scene& scene, StoredClip& clip);
    void rule(DepthCodingKind depth) { rules_.depth = depth; }

    std::string where(PlaneRole role, std::int64_t) const override {
        return file_ + ": track " + std::string(role_name(role));
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override;
    Result<StoredImage> stored(PlaneRole role) const;

private:
    SourceFile source_;
    std::string file_;
    StillRules rules_{DepthCodingKind::linear, true};  // as the paper's own example is
    std::array<int, all_roles.size()> streams_{};
};

/// A texture that changes has no place among still ones.
Result<void> check_textures(const mpeg4::ClipNodes& nodes, const std::string& file) {
    for (const auto& [texture, plane] :
         {std::pair{&nodes.colour, "colour"}, {&nodes.haptic, "haptic"}, {&nodes.height, "height"}})
        if (*texture && (*texture)->is_movie)
            return input_error(file + ": its MPEG-4 scene has depth in an ImageTexture and " + plane +
                               " in a MovieTexture: must all be one or the other");
    return {};
}

Result<void> Mp4Stills::find(const Mp4Scene& scene, StoredClip& clip) {
    if (auto checked = check_textures(scene.nodes, file_); !checked) return checked;
    const auto tracks = Demuxer::open_quicktime(source_);
    if (!tracks) return tracks.error();
    for (const PlaneRole role : all_roles) {
        const auto stream = stream_of_plane(scene, **tracks, role);
        if (!stream) return input_error(file_ + ": " + stream.error().message);
        if (!*stream) continue;
        streams_[static_cast<std::size_t>(role)] = **stream;
        clip.roles.push_back(role);
        const std::int64_t pictures = (*tracks)->container().streams[**stream]->nb_frames;
        if (pictures > 1)
            clip.notes.push_back("track " + std::string(role_name(role)) + " has " +
                                 std::to_string(pictures) + " pictures; its ImageTexture is the first");
    }
    return {};
}

Result<StoredImage> Mp4Stills::stored(PlaneRole role) const {
    const auto tracks = Demuxer::open_quicktime(source_);
    if (!tracks) return tracks.error();
    const int stream = streams_[static_cast<std::size_t>(role)];
    (*tracks)->select(stream);
    const auto packet = (*tracks)->next(stream);
    if (!packet) return packet.error();
    if (!*packet) return input_error(where(role, 0) + ": has no picture");
    return decode_stored_image(std::string(reinterpret_cast<const char*>((*packet)->data),
                                           static_cast<std::size_t>((*packet)->size)),
                               where(role, 0));
}

Result<TrackPicture> Mp4Stills::picture(PlaneRole role, std::int64_t frame) {
    auto read = stored(role);
    return read ? track_picture(std::move(*read), role, rules_, where(role, frame)) : read.error();
}

}  // namespace

bool is_mp4_stills(const SourceFile& file) {
    const auto scene = read_mp4_scene(file);
    if (!scene || !*scene || (*scene)->nodes.depth.is_movie) return false;
    const auto tracks = Demuxer::open_quicktime(file);
    const auto stream = tracks ? stream_of_plane(**scene, **tracks, PlaneRole::depth)
                               : Result<std::optional<int>>(tracks.error());
    if (!stream || !*stream) return false;
    const AVCodecID codec = (*tracks)->container().streams[**stream]->codecpar->codec_id;
    return codec == AV_CODEC_ID_PNG || codec == AV_CODEC_ID_MJPEG;
}

Result<std::unique_ptr<ClipReader>> open_mp4_stills(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    Colour colour) {
    const auto scene = read_mp4_scene(file);
    if (!scene) return scene.error();
    if (!*scene) return input_error(file.string() + ": has no MPEG-4 scene");
    StoredClip clip{file.string(), described.value_or(SceneDescription())};
    auto pictures = std::make_unique<Mp4Stills>(file);
    if (auto found = pictures->find(**scene, clip); !found) return found.error();
    clip.inputs = {file.path()};
    clip.count = 1;
    if (!described) {
        const auto depth = pictures->stored(PlaneRole::depth);
        if (!depth) return depth.error();
        auto said = mpeg4::described_by_pictures((*scene)->nodes, depth->image.width, depth->image.height,
                                                 depth->bits, clip.notes);
        if (!said) return input_error(file.string() + ": its MPEG-4 scene: " + said.error().message);
        clip.described = std::move(*said);
        if (clip.described.scene.name.empty()) clip.described.scene.name = file.path().stem().string();
    }
    clip.described.scene.folder.reset();
    clip.described.scene.video.reset();
    pictures->rule(clip.described.scene.depth.kind);
    clip.pictures = std::move(pictures);
    return open_stored_clip(std::move(clip), colour);
}

}  // namespace touchable
