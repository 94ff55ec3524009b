#include "engine/import/bag/bag_clip.hpp"

#include <optional>
#include <utility>

#include "engine/clip/far_plane.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/import/bag/bag_recording.hpp"
#include "engine/import/guess/depth_values.hpp"
#include "engine/import/guess/known_camera.hpp"
#include "engine/import/guess/number_words.hpp"
#include "engine/import/guess/picture_files.hpp"
#include "engine/import/guess/presets.hpp"
#include "engine/printable.hpp"
#include "engine/stop_request.hpp"
#include "engine/video/codecs.hpp"

namespace touchable {
namespace {

class BagReader final : public ClipReader {
public:
    BagReader(BagRecording recording, SceneDescription described)
        : recording_(std::move(recording)), described_(std::move(described)), values_(described_) {}
    Result<void> open();
    bool leaves_far_open() const { return values_.leaves_far_open(); }

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return described_.unstated.filters; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return recording_.count(); }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override;
    std::int64_t access_point(std::int64_t frame) const override { return frame; }
    void leave_out_colour() override { with_colour_ = false; }

private:
    Result<Plane> depth_plane(StoredImage stored, std::int64_t frame);
    Result<Plane> colour_plane(StoredImage stored, std::int64_t frame);
    Result<void> look_at_some();
    void describe(PlaneRole role, const StoredImage& first);

    BagRecording recording_;
    const SceneDescription described_;
    Scene scene_;
    std::vector<TrackInfo> infos_;  // depth is the first
    std::vector<std::string> notes_;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool with_colour_ = true;
    DepthValues values_;
    std::optional<RawFrame> first_;  // read to learn how pictures are stored, not yet given away
};

/// How frame 0 is stored stands for all.
Result<void> BagReader::open() {
    auto scene = settle(described_, {.rate = rate_of_seconds(recording_.times())});
    if (!scene) return input_error(recording_.bag().name() + ": " + scene.error().message);
    scene_ = std::move(*scene);
    auto first = recording_.depth(0);
    if (!first) return first.error();
    describe(PlaneRole::depth, *first);
    if (values_.needs_looks(*first))
        if (auto looked = look_at_some(); !looked) return looked;
    RawFrame frame;
    frame.time_ns = scene_.rate.time_ns(0);
    auto plane = depth_plane(std::move(*first), 0);
    if (!plane) return plane.error();
    add_plane(frame, PlaneRole::depth, std::move(*plane));
    if (auto note = no_depth_note(frame, scene_.depth)) notes_.push_back(std::move(*note));
    if (recording_.has_colour()) {
        auto colour = recording_.colour(0);
        if (!colour) return colour.error();
        describe(PlaneRole::colour, *colour);
        auto fits = colour_plane(std::move(*colour), 0);
        if (!fits) return fits.error();
        add_plane(frame, PlaneRole::colour, std::move(*fits));
    }
    first_ = std::move(frame);
    if (auto note = default_touch_note(false, scene_)) notes_.push_back(std::move(*note));
    return {};
}

void BagReader::describe(PlaneRole role, const StoredImage& first) {
    const Image& image = first.image;
    infos_.push_back(
        {std::string(role_name(role)), first.codec, first.pixel_format, image.width, image.height});
    if (auto note = lossy_note(role, first.codec)) notes_.push_back(std::move(*note));
    if (role != PlaneRole::depth && (image.width != scene_.width || image.height != scene_.height))
        notes_.push_back(resampling_note(role, image.width, image.height, scene_));
}

/// Depth that is no codes yet: its range in these frames settles what they will be. A later one that is
/// damaged tells nothing.
Result<void> BagReader::look_at_some() {
    for (const std::int64_t frame : telling_frames(recording_.count())) {
        if (stop_requested())
            return Error{ErrorKind::interrupted, "interrupted while the clip's range of depth was searched"};
        const auto stored = recording_.depth(frame);
        if (stored)
            values_.look(*stored);
        else if (frame == 0 || stored.error().kind == ErrorKind::interrupted)
            return stored.error();
    }
    auto note = values_.settle(scene_);
    if (!note) return input_error(recording_.bag().name() + ": " + note.error().message);
    notes_.push_back(std::move(*note));
    return {};
}

Result<Plane> BagReader::depth_plane(StoredImage stored, std::int64_t frame) {
    const std::string where = recording_.where(recording_.streams().depth, frame);
    if (stored.pixel_format != infos_.front().pixel_format)
        return input_error(where + ": is " + stored.pixel_format + ", but frame 0 is " +
                           infos_.front().pixel_format);
    const bool makes_codes = values_.makes_codes();
    const int bits = makes_codes ? 16 : stored.bits;
    Image image = makes_codes ? values_.codes(std::move(stored)) : std::move(stored.image);
    return fit_plane(PlaneRole::depth, plane_from(std::move(image), bits), scene_, where);
}

Result<Plane> BagReader::colour_plane(StoredImage stored, std::int64_t frame) {
    const std::string where = recording_.where(*recording_.streams().colour, frame);
    if (!stored.values.empty()) return input_error(where + ": is a picture of floats: must be of integers");
    return fit_plane(PlaneRole::colour, plane_from(std::move(stored.image), stored.bits), scene_, where);
}

Result<void> BagReader::seek(std::int64_t frame) {
    if (frame < 0 || frame > recording_.count())
        return usage_error(recording_.bag().name() + ": has no frame " + std::to_string(frame) +
                           ": must be from 0 to " + std::to_string(recording_.count() - 1));
    number_ = frame;
    return {};
}

Result<std::optional<RawFrame>> BagReader::next() {
    if (number_ == recording_.count()) return std::optional<RawFrame>{};
    if (number_ == 0 && first_) {
        ++number_;
        return std::exchange(first_, std::nullopt);
    }
    RawFrame frame;
    frame.number = number_;
    frame.time_ns = scene_.rate.time_ns(number_);
    auto depth = recording_.depth(number_);
    if (!depth) return depth.error();
    auto plane = depth_plane(std::move(*depth), number_);
    if (!plane) return plane.error();
    add_plane(frame, PlaneRole::depth, std::move(*plane));
    if (with_colour_ && recording_.has_colour()) {
        auto colour = recording_.colour(number_);
        if (!colour) return colour.error();
        auto fits = colour_plane(std::move(*colour), number_);
        if (!fits) return fits.error();
        add_plane(frame, PlaneRole::colour, std::move(*fits));
    }
    ++number_;
    return std::optional(std::move(frame));
}

/// What a person says stands; the rest is what the recording says.
Result<SourceDescription> completed(BagRecording& recording, SourceDescription known,
                                    std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    const Preset* const preset = preset_named(known.preset);
    auto camera = bag_camera(recording.bag(), streams.depth.topic);
    if (!camera) return camera.error();
    if (!known.intrinsics && !known.fov && *camera && !(preset && preset->intrinsics.fx > 0)) {
        known.intrinsics = (*camera)->intrinsics;
        add_remark(remarks, {"the camera is that of " + printable((*camera)->topic)});
    }
    if (known.metres_per_code || !known.preset.empty()) return known;
    const auto unit = bag_depth_unit(recording.bag(), streams.depth.topic);
    if (!unit) return unit.error();
    if (*unit) {
        known.metres_per_code = *unit;
        add_remark(remarks,
                   {"a code is " + short_number(1000 * **unit) + " mm, as the camera's Depth Units say"});
    } else {  // as ROS defines its encodings
        constexpr double millimetre = 0.001;
        known.metres_per_code = streams.depth.kind == RosPictureKind::depth_floats ? 1 : millimetre;
    }
    return known;
}

/// How the lens of depth bends, and where colour's camera stands, as far as the recording says it.
Result<void> add_cameras(BagRecording& recording, Scene& scene, std::vector<Remark>& remarks) {
    const BagStreams& streams = recording.streams();
    const auto depth = bag_camera(recording.bag(), streams.depth.topic);
    if (!depth) return depth.error();
    if (*depth) {
        scene.lens = (*depth)->lens;
        if (!(*depth)->unknown_lens.empty())
            add_remark(remarks, {"the lens of depth bends (" + printable((*depth)->unknown_lens) +
                                 "), which is not undone"});
    }
    if (!streams.colour || is_registered_topic(streams.depth.topic)) return {};
    const auto colour = bag_camera(recording.bag(), streams.colour->topic);
    if (!colour) return colour.error();
    if (!*depth || !*colour) return {};
    const auto depth_pose = bag_pose(recording.bag(), streams.depth.topic),
               colour_pose = bag_pose(recording.bag(), streams.colour->topic);
    if (!depth_pose) return depth_pose.error();
    if (!colour_pose) return colour_pose.error();
    if (!*depth_pose || !*colour_pose) {
        const bool same_frame = !(*depth)->frame.empty() && (*depth)->frame == (*colour)->frame;
        if (!same_frame && !((*depth)->intrinsics == (*colour)->intrinsics))
            add_remark(remarks,
                       {"colour is not brought onto depth's pixels, as the recording does not say how its "
                        "cameras stand (a scene file's colour_camera says it)"});
        return {};
    }
    const auto first = recording.colour(0);
    if (!first) return first.error();
    ColourCamera& camera = scene.colour_camera.emplace();
    camera.width = first->image.width;
    camera.height = first->image.height;
    camera.camera = scaled_camera((*colour)->intrinsics, camera.width, camera.height);
    camera.lens = (*colour)->lens;
    camera.from_depth = (*colour_pose)->after((*depth_pose)->inverse());
    return {};
}

void say_streams(const BagStreams& streams, std::vector<Remark>& remarks) {
    add_remark(remarks, {"depth is " + printable(streams.depth.topic) +
                         (streams.colour ? ", colour is " + printable(streams.colour->topic)
                                         : std::string(", there is no colour"))});
    for (const std::string& other : streams.others)
        add_remark(remarks, {printable(other) + " is depth as well, and is left out"});
}

Result<GuessedScene> guess(BagRecording& recording, const std::filesystem::path& file,
                           const SourceDescription& known) {
    std::vector<Remark> remarks;
    say_streams(recording.streams(), remarks);
    const auto said = completed(recording, known, remarks);
    if (!said) return said.error();
    const auto first = recording.depth(0);
    if (!first) return first.error();
    auto guessed = guess_scene(file.parent_path(), *first, *said);
    if (!guessed) return error_at(file.string(), guessed.error());
    Scene& scene = guessed->scene;
    scene.name = file.stem().string();
    scene.video.emplace().depth = file.filename().string();
    if (auto added = add_cameras(recording, scene, remarks); !added) return added.error();
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
    auto recording = BagRecording::open(file);
    if (!recording) return recording.error();
    return guess(*recording, file.path(), known);
}

Result<std::unique_ptr<ClipReader>> open_bag_clip(const SourceFile& file,
                                                  const std::optional<SceneDescription>& described,
                                                  const SourceDescription& known, Colour colour) {
    auto recording = BagRecording::open(file);
    if (!recording) return recording.error();
    auto made = described ? Result<GuessedScene>(GuessedScene{*described, {}, {}, {}})
                          : guess(*recording, file.path(), known);
    if (!made) return made.error();
    if (described) say_streams(recording->streams(), made->scene.remarks);
    auto reader = std::make_unique<BagReader>(std::move(*recording), *made);
    reader->add_input(file.path());
    if (auto opened = reader->open(); !opened) return opened.error();
    for (const auto& input : made->inputs) reader->add_input(input);
    if (colour == Colour::left_out) reader->leave_out_colour();
    const bool far_is_open = reader->leaves_far_open();
    return with_far_plane(std::move(reader), far_is_open, file.path());
}

}  // namespace touchable
