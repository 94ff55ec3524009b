#include "engine/formats/mp4_stills.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "engine/base/byte_source.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/mp4_scene.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/mpeg4/clip_scene.hpp"

namespace touchable {
namespace {

/// Each plane's picture, the first sample of its track. FFmpeg refuses files of MP4Box, so its tables are not
/// asked.
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
    std::array<mpeg4::FirstSample, all_roles.size()> samples_{};
};

/// Nothing where the scene has no such plane. Errors have no place.
Result<std::optional<mpeg4::FirstSample>> sample_of_plane(const mpeg4::Bytes& movie, const Mp4Scene& scene,
                                                          PlaneRole role) {
    TRY_ASSIGN(const auto track, track_of_plane(scene, role));
    if (!track) return std::optional<mpeg4::FirstSample>();
    const auto sample = mpeg4::first_sample_of(movie, *track);
    if (!sample) return error_at("its MPEG-4 scene: " + std::string(role_name(role)), sample.error());
    return std::optional(*sample);
}

constexpr std::uint64_t largest_picture = std::uint64_t{257} << 20;  // as of a picture in a file

/// What the object types of an ImageTexture are.
bool is_picture(const mpeg4::Bytes& begin) {
    const std::string_view kind = picture_kind({reinterpret_cast<const char*>(begin.data()), begin.size()});
    return kind == "PNG" || kind == "JPEG";
}

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
    const auto bytes = bytes_of_file(source_);
    const auto movie = bytes ? mpeg4::movie_head_of(**bytes) : Result<mpeg4::Bytes>(bytes.error());
    if (!movie) return error_at(file_, movie.error());
    for (const PlaneRole role : all_roles) {
        const auto sample = sample_of_plane(*movie, scene, role);
        if (!sample) return error_at(file_, sample.error());
        if (!*sample) continue;
        samples_[static_cast<std::size_t>(role)] = **sample;
        clip.roles.push_back(role);
        if ((*sample)->count > 1)
            clip.notes.push_back("track " + std::string(role_name(role)) + " has " +
                                 std::to_string((*sample)->count) +
                                 " pictures; its ImageTexture is the first");
    }
    return {};
}

Result<StoredImage> Mp4Stills::stored(PlaneRole role) const {
    TRY_ASSIGN(const auto file, bytes_of_file(source_));
    const auto& [at, size, count] = samples_[static_cast<std::size_t>(role)];
    const auto picture = size > largest_picture
                             ? input_error("has " + std::to_string(size) + " bytes: must be " +
                                           std::to_string(largest_picture) + " at most")
                             : mpeg4::bytes_at(*file, at, size);
    if (!picture) return error_at(where(role, 0), picture.error());
    if (!is_picture(*picture)) return input_error(where(role, 0) + ": is neither PNG nor JPEG");
    return decode_stored_image(std::string(picture->begin(), picture->end()), where(role, 0));
}

Result<TrackPicture> Mp4Stills::picture(PlaneRole role, std::int64_t frame) {
    auto read = stored(role);
    return read ? track_picture(std::move(*read), role, rules_, where(role, frame)) : read.error();
}

}  // namespace

bool is_mp4_stills(const SourceFile& file) {
    const auto scene = read_mp4_scene(file);
    if (!scene || !*scene || (*scene)->nodes.depth.is_movie) return false;
    const auto bytes = bytes_of_file(file);
    const auto movie = bytes ? mpeg4::movie_head_of(**bytes) : Result<mpeg4::Bytes>(bytes.error());
    const auto sample = movie ? sample_of_plane(*movie, **scene, PlaneRole::depth)
                              : Result<std::optional<mpeg4::FirstSample>>(movie.error());
    if (!sample || !*sample) return false;
    constexpr std::uint64_t told_by = 16;
    const auto begin = mpeg4::bytes_at(**bytes, (*sample)->at, std::min(told_by, (*sample)->bytes));
    return begin && is_picture(*begin);
}

Result<std::unique_ptr<ClipReader>> open_mp4_stills(const SourceFile& file,
                                                    const std::optional<SceneDescription>& described,
                                                    Colour colour) {
    TRY_ASSIGN(const auto scene, read_mp4_scene(file));
    if (!scene) return input_error(file.string() + ": has no MPEG-4 scene");
    StoredClip clip{file.string(), described.value_or(SceneDescription())};
    auto pictures = std::make_unique<Mp4Stills>(file);
    TRY(pictures->find(*scene, clip));
    clip.inputs = {file.path()};
    clip.count = 1;
    if (!described) {
        TRY_ASSIGN(const auto depth, pictures->stored(PlaneRole::depth));
        auto said = mpeg4::described_by_pictures(scene->nodes, depth.image.width, depth.image.height,
                                                 depth.bits, clip.notes);
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
