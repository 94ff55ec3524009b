#include "engine/formats/bag_clip.hpp"

#include <optional>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/formats/bag_recording.hpp"
#include "engine/formats/known_camera.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/presets.hpp"
#include "engine/formats/stored_clip.hpp"

namespace touchable {
namespace {

class BagFrames final : public FrameSource {
public:
    explicit BagFrames(BagRecording recording) : recording_(std::move(recording)) {}
    std::string where(PlaneRole role, std::int64_t frame) const override {
        const BagStreams& streams = recording_.streams();
        return recording_.where(role == PlaneRole::depth ? streams.depth : *streams.colour, frame);
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        TRY_ASSIGN(auto image, role == PlaneRole::depth ? recording_.depth(frame) : recording_.colour(frame));
        return TrackPicture{std::move(image)};
    }
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        return role == PlaneRole::depth ? frame : recording_.colour_beside(frame);
    }

private:
    BagRecording recording_;
};

/// What a person says stands; the rest is what the recording says.
Result<SourceDescription> completed(BagRecording& recording, SourceDescription known,
                                    std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    const Preset* const preset = preset_named(known.preset);
    TRY_ASSIGN(auto camera, bag_camera(recording.bag(), streams.depth.topic));
    if (!known.intrinsics && !known.fov && camera && !(preset && preset->intrinsics.fx > 0)) {
        known.intrinsics = camera->intrinsics;
        add_remark(remarks, {"the camera is that of " + printable(camera->topic)});
    }
    if (known.metres_per_code || !known.preset.empty()) return known;
    TRY_ASSIGN(const auto unit, bag_depth_unit(recording.bag(), streams.depth.topic));
    if (unit) {
        known.metres_per_code = unit;
        add_remark(remarks,
                   {"a code is " + short_number(1000 * *unit) + " mm, as the camera's Depth Units say"});
    } else {  // as ROS defines its encodings
        constexpr double millimetre = 0.001;
        known.metres_per_code = streams.depth.kind == RosPictureKind::depth_floats ? 1 : millimetre;
    }
    return known;
}

/// How the lens of depth bends, and where colour's camera stands, as far as the recording says it.
Result<void> add_cameras(BagRecording& recording, Scene& scene, std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    TRY_ASSIGN(const auto depth, bag_camera(recording.bag(), streams.depth.topic));
    if (depth) {
        scene.lens = depth->lens;
        if (!depth->unknown_lens.empty())
            add_remark(remarks, {"the lens of depth bends (" + printable(depth->unknown_lens) +
                                 "), which is not undone"});
    }
    if (!streams.colour || is_registered_topic(streams.depth.topic)) return {};
    TRY_ASSIGN(const auto colour, bag_camera(recording.bag(), streams.colour->topic));
    if (!depth || !colour) return {};
    const auto depth_pose = bag_pose(recording.bag(), streams.depth.topic),
               colour_pose = bag_pose(recording.bag(), streams.colour->topic);
    if (!depth_pose) return depth_pose.error();
    if (!colour_pose) return colour_pose.error();
    if (!*depth_pose || !*colour_pose) {
        const bool same_frame = !depth->frame.empty() && depth->frame == colour->frame;
        if (!same_frame && !(depth->intrinsics == colour->intrinsics))
            add_remark(remarks,
                       {"colour is not brought onto depth's pixels, as the recording does not say how its "
                        "cameras stand (a scene file's colour_camera says it)"});
        return {};
    }
    TRY_ASSIGN(const auto first, recording.colour(0));
    ColourCamera& camera = scene.colour_camera.emplace();
    camera.width = first.image.width;
    camera.height = first.image.height;
    camera.camera = scaled_camera(colour->intrinsics, camera.width, camera.height);
    camera.lens = colour->lens;
    camera.from_depth = (*colour_pose)->after((*depth_pose)->inverse());
    return {};
}

void say_streams(BagRecording& recording, std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    add_remark(remarks, {"depth is " + printable(streams.depth.topic) +
                         (streams.colour ? ", colour is " + printable(streams.colour->topic)
                                         : std::string(", there is no colour"))});
    for (const std::string& other : streams.others)
        add_remark(remarks, {printable(other) + " is depth as well, and is left out"});
    if (const std::string left_out = recording.bag().left_out(); !left_out.empty())
        add_remark(remarks, {left_out});
}

Result<GuessedScene> guess(BagRecording& recording, const std::filesystem::path& file,
                           const SourceDescription& known) {
    std::vector<Remark> remarks;
    say_streams(recording, remarks);
    TRY_ASSIGN(const auto said, completed(recording, known, remarks));
    TRY_ASSIGN(const auto first, recording.depth(0));
    auto guessed = guess_scene(file.parent_path(), first, said);
    if (!guessed) return error_at(file.string(), guessed.error());
    Scene& scene = guessed->scene;
    scene.name = file.stem().string();
    scene.video.emplace().depth = file.filename().string();
    TRY(add_cameras(recording, scene, remarks));
    if (auto valid = validate(scene); !valid)
        return input_error(file.string() + ": its cameras are damaged: " + valid.error().message);
    const auto rate = rate_of_seconds(recording.times());
    if (rate) scene.rate = *rate;
    add_remark(remarks, {short_number(scene.rate.per_second()) + " frames a second" +
                             (scene.rate.own_times ? " on average, each at its own time"
                              : rate               ? ", by their times"
                                                   : ""),
                         !rate});
    scene.remarks = joined_remarks(std::move(remarks), scene.remarks);
    return guessed;
}

}  // namespace

Result<GuessedScene> guess_bag(const SourceFile& file, const SourceDescription& known) {
    TRY_ASSIGN(auto recording, BagRecording::open(file));
    return guess(recording, file.path(), known);
}

Result<std::unique_ptr<ClipReader>> open_bag_clip(const SourceFile& file,
                                                  const std::optional<SceneDescription>& described,
                                                  const SourceDescription& known, Colour colour) {
    TRY_ASSIGN(auto recording, BagRecording::open(file));
    TRY_ASSIGN(auto made, described ? Result<GuessedScene>(GuessedScene{*described, {}, {}, {}})
                                    : guess(recording, file.path(), known));
    if (described) say_streams(recording, made.scene.remarks);
    StoredClip clip{recording.bag().name(), made};
    clip.count = recording.count();
    clip.roles = {PlaneRole::depth};
    if (recording.has_colour()) clip.roles.push_back(PlaneRole::colour);
    clip.found.rate = rate_of_seconds(recording.times());
    clip.inputs = made.inputs;
    clip.inputs.insert(clip.inputs.begin(), file.path());
    clip.pictures = std::make_unique<BagFrames>(std::move(recording));
    return open_stored_clip(std::move(clip), colour);
}

}  // namespace touchable
