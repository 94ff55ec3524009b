#include <string>

#include "engine/printable.hpp"
#include "engine/video/clip_container.hpp"
#include "engine/video/clip_tags.hpp"

namespace touchable {
namespace {

/// Tags say what each track is, and attachments what the clip means.
class MatroskaContainer final : public ClipContainer {
public:
    explicit MatroskaContainer(const SourceFile& source)
        : ClipContainer(source, {clip_tags::scene_file, clip_tags::times_file}) {}
    Result<std::unique_ptr<Demuxer>> open() override { return Demuxer::open_matroska(source_); }
    Result<FrameRate> rate(const Demuxer& file) override {
        return tagged_rate(file, file.attachment(clip_tags::times_file));
    }
    Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) override;
    Result<std::vector<ClipTrack>> tracks(const Demuxer& file, const Scene& scene) override;
};

Result<SceneDescription> MatroskaContainer::scene(const Demuxer& file, const FrameRate& recorded) {
    if (const auto json = file.attachment(clip_tags::scene_file)) return described_by(*json, recorded);
    return refuse("has no scene.json attached: describe it with a scene file",
                  {{Setting::scene_file, "FILE"}});
}

Result<std::vector<ClipTrack>> MatroskaContainer::tracks(const Demuxer& file, const Scene& /*scene*/) {
    const AVFormatContext& container = file.container();
    std::vector<ClipTrack> tracks;
    for (const PlaneRole role : all_roles) {
        for (unsigned k = 0; k < container.nb_streams; ++k) {
            const AVStream& stream = *container.streams[k];
            const AVDictionaryEntry* tag = av_dict_get(stream.metadata, clip_tags::role_tag, nullptr, 0);
            if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO || !tag) continue;
            const std::string number = "track " + std::to_string(k + 1);
            const auto tagged = role_named(tag->value);
            if (!tagged)
                return refuse(number + " has the role " + in_quotes(tag->value) +
                              ": must be depth, colour, haptic or height");
            if (*tagged != role) continue;
            if (!tracks.empty() && tracks.back().role == role)
                return refuse(number + " is a second track of role " + tag->value + ": must be one");
            tracks.push_back({role, static_cast<int>(k)});
        }
        if (tracks.empty()) return refuse("has no track of role depth (tag T3D_ROLE)");
    }
    return tracks;
}

}  // namespace

std::unique_ptr<ClipContainer> matroska_container(const SourceFile& file) {
    return std::make_unique<MatroskaContainer>(file);
}

}  // namespace touchable
