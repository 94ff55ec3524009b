#include <string>
#include <utility>

#include "engine/printable.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/video/clip_container.hpp"
#include "engine/video/clip_tags.hpp"
#include "engine/video/frame_times_text.hpp"
#include "engine/video/matroska_writer.hpp"

namespace touchable {
namespace {

/// Tags say what each track is, and attachments what the clip means.
class MatroskaContainer final : public ClipContainer {
public:
    explicit MatroskaContainer(const SourceFile& source) : source_(source), file_(source.string()) {}
    Result<std::unique_ptr<Demuxer>> open() override { return Demuxer::open_matroska(source_); }
    Result<FrameRate> rate(const Demuxer& file) override;
    Result<SceneDescription> scene(const Demuxer& file, const FrameRate& recorded) override;
    Result<std::vector<ClipTrack>> tracks(const Demuxer& file, const Scene& scene) override;

private:
    Error refuse(const std::string& what, Hints hints = {}) const {
        return input_error(file_ + ": " + what, std::move(hints));
    }

    SourceFile source_;
    std::string file_;
};

Result<FrameRate> MatroskaContainer::rate(const Demuxer& file) {
    auto rate = tagged_rate(file, file_);
    if (!rate) return rate;
    const auto own = file.attachment(clip_tags::times_file);
    if (!own) return rate;
    auto times = parse_frame_times(*own, file_ + ": " + clip_tags::times_file);
    if (!times) return times.error();
    rate->own_times = std::move(times->own_times);
    return rate;
}

/// Its rate is the recorded one, of which it does not say the frames' own times.
Result<SceneDescription> MatroskaContainer::scene(const Demuxer& file, const FrameRate& recorded) {
    const auto json = file.attachment(clip_tags::scene_file);
    if (!json)
        return refuse("has no scene.json attached: describe it with a scene file",
                      {{Setting::scene_file, "FILE"}});
    auto described = parse_scene(*json, file_ + ": scene.json");
    if (!described) return described;
    const FrameRate& rate = described->scene.rate;
    if (!described->unstated.rate && !clip_tags::same_rate(rate, recorded))
        return refuse("its tag T3D_RATE is " + clip_tags::rate_text(recorded) + ", but its scene.json says " +
                      clip_tags::rate_text(rate));
    described->unstated.rate = true;
    return described;
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

Result<FrameRate> tagged_rate(const Demuxer& file, const std::string& name) {
    const auto version = file.tag(clip_tags::version_tag);
    if (!version) return input_error(name + ": is not a touchable clip: it has no tag T3D_VERSION");
    const auto number = clip_tags::parse_version(*version);
    if (!number)
        return input_error(name + ": its tag T3D_VERSION is " + in_quotes(*version) +
                           ": must be a whole number from 1");
    if (*number > clip_format_version)
        return input_error(name + ": is of clip format " + printable(*version) +
                           "; this program reads up to " + std::to_string(clip_format_version) +
                           ": use a newer one");
    const auto rate = file.tag(clip_tags::rate_tag);
    const auto parsed = rate ? clip_tags::parse_rate(*rate) : std::nullopt;
    if (!parsed || clip_tags::is_too_fast(*parsed))
        return input_error(name + ": its tag T3D_RATE is " + (rate ? in_quotes(*rate) : "missing") +
                           ": must be a frame rate such as 30000/1001, at most " +
                           std::to_string(clip_tags::fastest_rate) + "/1");
    return *parsed;
}

std::unique_ptr<ClipContainer> matroska_container(const SourceFile& file) {
    return std::make_unique<MatroskaContainer>(file);
}

}  // namespace touchable
