#include "engine/clip/clip_container.hpp"

#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/clip_tags.hpp"
#include "engine/clip/frame_times_text.hpp"
#include "engine/clip/matroska_writer.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {

ClipContainer::ClipContainer(const SourceFile& source, ContainerWords words)
    : source_(source), file_(source.string()), words_(words) {}

Error ClipContainer::refuse(const std::string& what, Hints hints) const {
    return input_error(file_ + ": " + what, std::move(hints));
}

Result<FrameRate> ClipContainer::tagged_rate(const Demuxer& file,
                                             const std::optional<std::string>& own_times) const {
    const auto version = file.tag(clip_tags::version_tag);
    if (!version) return refuse("is not a touchable clip: it has no tag T3D_VERSION");
    const auto number = clip_tags::parse_version(*version);
    if (!number)
        return refuse("its tag T3D_VERSION is " + in_quotes(*version) + ": must be a whole number from 1");
    if (*number > words_.newest_version)
        return refuse("is of clip format " + printable(*version) + "; this program reads up to " +
                      std::to_string(words_.newest_version) + ": use a newer one");
    const auto stated = file.tag(clip_tags::rate_tag);
    auto rate = stated ? clip_tags::parse_rate(*stated) : std::nullopt;
    if (!rate || clip_tags::is_too_fast(*rate))
        return refuse("its tag T3D_RATE is " + (stated ? in_quotes(*stated) : "missing") +
                      ": must be a frame rate such as 30000/1001, at most " +
                      std::to_string(clip_tags::fastest_rate) + "/1");
    if (!own_times) return *rate;
    TRY_ASSIGN(auto times, parse_frame_times(*own_times, file_ + ": " + words_.times));
    rate->own_times = std::move(times.own_times);
    return *rate;
}

Result<SceneDescription> ClipContainer::described_by(const std::string& json,
                                                     const FrameRate& recorded) const {
    auto described = parse_scene(json, file_ + ": " + words_.scene);
    if (!described) return described;
    const FrameRate& rate = described->scene.rate;
    if (!described->unstated.rate && !clip_tags::same_rate(rate, recorded))
        return refuse("its tag T3D_RATE is " + clip_tags::rate_text(recorded) + ", but its " + words_.scene +
                      " says " + clip_tags::rate_text(rate));
    described->unstated.rate = true;
    return described;
}

}  // namespace touchable
