// SPDX-License-Identifier: Apache-2.0
// Folders of pictures: read as clips (FolderPictures), and written (PictureWriter), first into a hidden
// folder beside their place.

#include "engine/formats/formats_read.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <set>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/colour_video.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/read_pictures.hpp"
#include "engine/formats/sidecar_text.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/formats/touch_maps.hpp"
#include "engine/formats/value_evidence.hpp"
#include "engine/formats/video_picture.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/plane_memory.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

// --- Reading

/// A plane's layer in files with pictures of several planes.
PictureLayer layer_of(PlaneRole role) {
    if (role == PlaneRole::colour) return PictureLayer::colour;
    return role == PlaneRole::haptic ? PictureLayer::materials : PictureLayer::own;
}

/// Adds the files that were found for a track to the clip's inputs, each once.
void add_inputs(const PictureFiles& found, StoredClip& clip) {
    if (!found.remark.empty()) clip.notes.push_back(found.remark);
    if (!found.list.empty()) clip.inputs.push_back(found.list);
    for (const auto& file : found.files)
        if (clip.inputs.empty() || clip.inputs.back() != file) clip.inputs.push_back(file);
}

constexpr std::size_t no_index = largest_material_index + 1;

std::size_t index_at(const StoredImage& picture, std::size_t k) {
    if (picture.values.empty()) return sample_at(picture.image, k);
    const float value = picture.values[k];
    const bool is_index = value >= 0 && value <= largest_material_index && value == std::floor(value);
    return is_index ? static_cast<std::size_t>(value) : no_index;
}

/// The whole numbers in a picture of material indices: the first 12 met, sorted.
std::set<int> indices_in(const StoredImage& picture) {
    constexpr std::size_t most = 12;
    std::set<int> found;
    for (std::size_t k = 0; k < pixel_count(picture.image) && found.size() < most; ++k)
        if (const std::size_t index = index_at(picture, k); index != no_index)
            found.insert(static_cast<int>(index));
    return found;
}

/// Turns pictures of material indices into haptic pictures: each pixel gets its material's properties, by the
/// scene's haptic ranges. An index without an entry, or a value that is no whole number from 0 to 65535, gets
/// the scene's default properties.
class MaterialPictures {
public:
    explicit MaterialPictures(const SceneDescription& described) : samples_(3 * (no_index + 1)) {
        const Scene& scene = described.scene;
        const auto set = [&](std::size_t index, const HapticProperties& properties) {
            samples_[3 * index] = scene.haptic.stiffness.nearest(properties.stiffness / 1000);
            samples_[3 * index + 1] = scene.haptic.static_friction.nearest(properties.static_friction);
            samples_[3 * index + 2] = scene.haptic.dynamic_friction.nearest(properties.dynamic_friction);
        };
        for (std::size_t index = 0; index <= no_index; ++index) set(index, scene.default_properties);
        for (const SceneDescription::Material& material : described.materials)
            set(static_cast<std::size_t>(material.index), material.properties);
    }

    /// `indices` has one channel. An error does not name the file.
    Result<StoredImage> haptic(const StoredImage& indices) const {
        if (indices.image.channels != 1)
            return input_error(
                "is in colour: where the scene has haptic.materials, haptic pictures are of material "
                "indices");
        StoredImage made{blank_image(indices.image.width, indices.image.height, 1, 3), indices.codec,
                         "rgb24"};
        std::uint8_t* to = made.image.samples.data();
        for (std::size_t k = 0; k < pixel_count(indices.image); ++k, to += 3)
            std::memcpy(to, &samples_[3 * index_at(indices, k)], 3);
        return made;
    }

private:
    std::vector<std::uint8_t> samples_;  // red, green, blue of each index, and of all others
};

FrameRate rate_of_clip(const StoredClip& clip) {
    const FrameRate& described = clip.described.scene.rate;
    return clip.described.unstated.rate ? clip.found.rate.value_or(described) : described;
}

/// Reads a file for each picture, or one that holds all frames.
class FolderPictures final : public FrameSource {
public:
    /// `colour_video`: colour, if it is a video that is open already.
    FolderPictures(fs::path folder, const Scene& scene, std::shared_ptr<ReadPictures> pictures,
                   std::shared_ptr<VideoFile> colour_video)
        : folder_(std::move(folder)),
          rules_{scene.depth.kind, scene.folder->haptic_may_be_lossy, scene.stored.packed},
          pictures_(pictures ? std::move(pictures) : std::make_shared<ReadPictures>()),
          colour_video_(std::move(colour_video)) {}

    /// Finds every track's files for every frame; an error names the first that is missing.
    Result<void> find(StoredClip& clip, Colour colour) {
        const SceneDescription& described = clip.described;
        const FolderSource& source = *described.scene.folder;
        TRY_ASSIGN(auto depth, depth_files(folder_, source));
        // A single file may hold a stack of pictures.
        TRY_ASSIGN(auto stack, depth.files.size() == 1 ? pictures_->stack_in(depth.files.front())
                                                       : Result<std::shared_ptr<ImageStack>>(nullptr));
        if (stack) depth.frames = static_cast<std::size_t>(stack->count());
        tell_of_pages(depth, clip);
        if (!stack) find_halves(depth, clip);
        TRY(check_named_depth(pictures_->known(), depth.files.front()));
        const bool has_confidence = stack && stack->least_confidence();
        if (pictures_->known().least_confidence && !has_confidence)
            return usage_error(depth.files.front().string() +
                               ": has no confidence beside its depth, so none can be the least: must be a "
                               ".npz with an array conf");
        if (has_confidence)
            clip.notes.push_back(
                "depth whose confidence is below " + short_number(*stack->least_confidence()) +
                " is taken for none (the default is half of the median confidence of frame 0)");
        for (const PlaneRole role : all_roles) {
            if (pattern_of(source, role).empty()) continue;
            if (role == PlaneRole::colour && is_named_as_video(source.colour)) {
                TRY(open_colour_video(source.colour));
                clip.inputs.push_back(folder_ / source.colour);
                clip.roles.push_back(role);
                tracks_.push_back(
                    {role, PictureFiles{{folder_ / source.colour}, {}, false, {}, {}}, nullptr});
                continue;
            }
            const bool is_depths = role == PlaneRole::depth || (pattern_of(source, role) == source.depth &&
                                                                !numbers_of(source, role).any());
            TRY_ASSIGN(auto found,
                       is_depths ? Result<PictureFiles>(depth) : files_beside(folder_, role, source, depth));
            if (role == PlaneRole::depth || !is_depths) add_inputs(found, clip);
            clip.roles.push_back(role);
            tracks_.push_back(
                {role, std::move(found), role == PlaneRole::depth ? stack : nullptr, halves_ && is_depths});
        }
        if (!described.materials.empty()) materials_.emplace(described);
        if (!stack) tell_of_materials(clip);
        pictures_->want_beside({colour == Colour::wanted && shares_depths_files(PlaneRole::colour),
                                shares_depths_files(PlaneRole::haptic)});
        reads_side_by_side_ =
            !stack && std::none_of(tracks_.begin() + 1, tracks_.end(),
                                   [&](const Track& track) { return shares_depths_files(track.role); });
        clip.count = static_cast<std::int64_t>(depth.count());
        const auto& files = depth.files;
        clip.name = (files.front() == files.back() ? files.front() : folder_).string();
        clip.found.rate = own_rate_of(depth);
        if (colour_video_) pair_colour_video(depth, clip);
        find_poses(depth, clip);
        if (!source.cameras.empty()) TRY(find_cameras(depth, clip));
        if (!described.unstated.rate) return {};
        if (const std::string why = unusable_times(depth); !why.empty())
            clip.notes.push_back(why + ": played at " + short_number(rate_of_clip(clip).per_second()) +
                                 " frames a second (the scene's rate says otherwise)");
        return {};
    }

    std::string where(PlaneRole role, std::int64_t frame) const override {
        if (is_colour_video(role)) return colour_video_->where(picture_number(role, frame));
        return file(track(role), frame).string() + in_words(role, frame);
    }

    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        if (is_colour_video(role)) return colour_picture(picture_number(role, frame));
        const Track& from = track(role);
        auto stored =
            from.stack ? from.stack->image(frame) : pictures_->take(file(from, frame), layer_of(role));
        if (!stored) return Error{stored.error().kind, stored.error().message + in_words(role, frame)};
        if (from.is_half) stored = half_of(*stored, *halves_, role);
        if (role == PlaneRole::haptic && materials_) {
            stored = materials_->haptic(*stored);
            if (!stored) return error_at(where(role, frame), stored.error());
        } else if (role == PlaneRole::haptic && stored->codec == "exr") {
            return input_error(
                where(role, frame) +
                ": is of material indices: the scene file's haptic.materials must say what they feel like");
        }
        return track_picture(std::move(*stored), role, rules_, where(role, frame));
    }

    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        if (is_colour_video(role)) return colour_frame(frame);
        return track(role).is_still() ? 0 : frame;
    }
    /// Whether all tracks have files of their own.
    bool reads_side_by_side() const override { return reads_side_by_side_; }
    void keep(std::int64_t frame, StoredImage picture) override {
        if (!tracks_.front().stack && !halves_)
            pictures_->keep(file(tracks_.front(), frame), std::move(picture));
    }

private:
    struct Track {
        PlaneRole role;
        PictureFiles files;
        std::shared_ptr<ImageStack> stack;  // that holds all frames
        bool is_half = false;               // of each picture
        bool is_still() const {
            return !stack && files.count() > 1 && files.file(0) == files.file(files.count() - 1);
        }
    };

    static std::string in_words(PlaneRole role, std::int64_t frame) {
        return " (" + std::string(role_name(role)) + ", frame " + std::to_string(frame) + ")";
    }
    static const fs::path& file(const Track& track, std::int64_t frame) {
        return track.files.file(static_cast<std::size_t>(frame));
    }
    const Track& track(PlaneRole role) const { return *std::ranges::find(tracks_, role, &Track::role); }

    /// Reads the frames' cameras; their median becomes the scene's, if it has none.
    Result<void> find_cameras(const PictureFiles& depth, StoredClip& clip) const {
        const Scene& scene = clip.described.scene;
        TRY_ASSIGN(auto found, camera_files(folder_, *scene.folder, depth));
        add_inputs(found, clip);
        TRY_ASSIGN(clip.cameras, read_frame_cameras(found, scene.width, scene.height));
        if (!clip.described.unstated.camera) return {};
        clip.found.camera = median_camera(clip.cameras);
        clip.notes.emplace_back("the camera is the median of those of the frames");
        return {};
    }

    bool is_colour_video(PlaneRole role) const { return role == PlaneRole::colour && colour_video_; }

    Result<void> open_colour_video(const std::string& name) {
        if (!is_file(folder_ / name)) return input_error((folder_ / name).string() + " (colour): is missing");
        if (!colour_video_ || colour_video_->file().path() != folder_ / name)
            TRY(assign(colour_video_, VideoFile::open(folder_ / name, PlaneRole::colour)));
        return {};
    }

    /// Chooses how the video's frames are found: in their order if there are as many as depth's; by the
    /// numbers in the names of depth's files if the video has so many frames; else by time.
    void pair_colour_video(const PictureFiles& depth, StoredClip& clip) {
        const auto frames = colour_video_->count(), pictures = static_cast<std::int64_t>(depth.count());
        if (colour_video_->note()) clip.notes.push_back(*colour_video_->note());
        // Numbers that are no times, one a frame: a file that is a stack has one for all.
        const auto& numbers = depth.keys;
        const bool counts = numbers.size() == depth.count() && numbers.front() >= 0 && !clip.found.rate;
        if (frames == pictures) {
            if (!clip.found.rate && clip.described.unstated.rate) clip.found.rate = colour_video_->rate();
            return;
        }
        const std::string had = "colour is a video of " + std::to_string(frames) + " frames for depth's " +
                                std::to_string(pictures) + ": ";
        if (counts && numbers.back() < static_cast<double>(frames)) {
            numbers_ = numbers;
            clip.notes.push_back(had + "each depth has the frame of the number in its file's name");
            return;
        }
        pairing_rate_ = rate_of_clip(clip);
        clip.notes.push_back(had + "each depth has the frame that is nearest in time from their beginning");
    }
    std::int64_t colour_frame(std::int64_t frame) const {
        if (!numbers_.empty()) return static_cast<std::int64_t>(numbers_[static_cast<std::size_t>(frame)]);
        if (!pairing_rate_) return frame;
        return colour_video_->nearest(1e-9 * static_cast<double>(pairing_rate_->time_ns(frame)));
    }
    Result<TrackPicture> colour_picture(std::int64_t number) {
        TRY_ASSIGN(auto picture, picture_at(*colour_video_, number, colour_converter_));
        TRY_ASSIGN(auto rgb, picture.rgb());
        return lent_picture(colour_video_->info(), std::move(rgb));
    }

    /// Notes what is left out of the first file, and that each of several files is one frame, even if it has
    /// several pages.
    void tell_of_pages(const PictureFiles& depth, StoredClip& clip) const {
        const fs::path& first = depth.files.front();
        const auto pages = pictures_->stack_in(first);
        if (!pages || !*pages) return;
        if (!(*pages)->left_out().empty())
            clip.notes.push_back(first.filename().string() + ": " + (*pages)->left_out());
        if (depth.files.size() == 1 || (*pages)->count() < 2) return;
        clip.notes.push_back("each file is one frame: of the " + std::to_string((*pages)->count()) +
                             " pictures in " + printable(first.filename().string()) +
                             " the first is taken (a file that is opened alone shows all)");
    }

    /// Finds out whether depth is a half of pictures whose other half is colour.
    void find_halves(const PictureFiles& depth, StoredClip& clip) {
        const FolderSource& source = *clip.described.scene.folder;
        const fs::path& first = depth.files.front();
        const bool may_be = source.colour == source.depth ||
                            is_any_of(small_letters(first.extension().string()), {".png", ".jpg", ".jpeg"});
        if (!may_be || rules_.depth == DepthCodingKind::hue || rules_.packed != Packing::none) return;
        const auto looked = pictures_->look(first);
        if (looked) halves_ = depth_in_colours((*looked)->image);
        if (!halves_) return;
        const int width = clip.described.scene.width, height = clip.described.scene.height;
        const char* const share = halves_->layout == VideoLayout::alone ? nullptr
                                  : height > width                      ? "half"
                                  : width > 2 * height                  ? "twice"
                                                                        : nullptr;
        clip.notes.push_back(words_of(*halves_));
        if (share)
            clip.notes.back() += std::string("; if both were squeezed to fit, the focal length across is ") +
                                 share + " that down, as a stated camera says";
    }

    /// Poses are optional, so a file of poses that cannot be read is a remark, not an error.
    void find_poses(const PictureFiles& depth, StoredClip& clip) const {
        Scene& scene = clip.described.scene;
        if (depth.count() < 2) return;
        auto found = poses_beside(folder_, depth, rate_of_clip(clip), scene.metres_per_unit);
        if (!found) return;
        clip.notes.push_back(std::move(found->remark));
        if (found->path.poses.empty()) return;
        scene.path = std::make_shared<const CameraPath>(std::move(found->path));
        if (std::ranges::find(clip.inputs, found->file) == clip.inputs.end())
            clip.inputs.push_back(found->file);
    }

    bool shares_depths_files(PlaneRole role) const {
        const auto own = std::ranges::find(tracks_, role, &Track::role);
        return own != tracks_.end() && own->files.files == tracks_.front().files.files;
    }

    /// Notes where materials get their properties from, or that nothing states these.
    void tell_of_materials(StoredClip& clip) {
        if (materials_)
            clip.notes.push_back(
                {PlaneRole::haptic,
                 "that of " + std::to_string(clip.described.materials.size()) +
                     " materials, by their indices; other indices have the default properties"});
        const bool has_haptic = std::ranges::count(tracks_, PlaneRole::haptic, &Track::role) > 0;
        if (has_haptic) return;
        const auto looked = pictures_->look(file(tracks_.front(), 0));
        if (!looked || !(*looked)->beside || !(*looked)->beside->materials) return;
        const std::string list = listed(indices_in(*(*looked)->beside->materials),
                                        [](int index) { return std::to_string(index); });
        clip.notes.push_back(
            {PlaneRole::haptic, "not there: the files have material indices (" +
                                    (*looked)->beside->materials_name + ": " + list +
                                    "), but nothing says what they feel like: haptic.materials in a scene "
                                    "file does, with folder.haptic as folder.depth (docs/scene_file.md; "
                                    "touchable init-scene writes one to begin with)"});
    }

    fs::path folder_;
    StillRules rules_;
    std::vector<Track> tracks_;               // depth is the first
    std::optional<DepthInVideo> halves_;      // nothing: a picture is of one plane
    std::shared_ptr<ReadPictures> pictures_;  // not null
    std::optional<MaterialPictures> materials_;
    std::shared_ptr<VideoFile> colour_video_;  // null: colour is pictures, or there is none
    RgbConverter colour_converter_;
    std::vector<double> numbers_;            // video frame for each of depth; empty: by time or order
    std::optional<FrameRate> pairing_rate_;  // depth's, if frames are found by time
    bool reads_side_by_side_ = false;
};

// --- Writing

constexpr const char* scene_name = "scene.json";
constexpr const char* times_list = "depth.txt";
constexpr const char* poses_list = "poses.txt";

Error unwritable(const fs::path& place, const std::error_code& why) {
    return input_error(place.string() + ": cannot be written: " + why.message());
}

std::string numbered(PlaneRole role, std::int64_t frame) {
    return std::string(role_name(role)) + formatted("_%06lld.png", static_cast<long long>(frame));
}

/// "NAME_colour.png", beside a file NAME of any kind.
std::string picture_beside(const fs::path& file, PlaneRole role) {
    return file.stem().string() + "_" + std::string(role_name(role)) + ".png";
}

/// Common part of folders and stills: frames come in order, and all files get their names, or none.
class PictureWriter : public ClipWriter {
public:
    /// `home`: the folder that the files will be in; `opens_by`: the name of the one that opens the clip.
    PictureWriter(const fs::path& place, const SceneDescription& described, Existing existing, fs::path home,
                  std::string opens_by = {})
        : place_(place),
          scene_(described.scene),
          unstated_(described.unstated),
          existing_(existing),
          home_(std::move(home)),
          opens_by_(std::move(opens_by)),
          hidden_(place.parent_path()) {}
    Result<void> open() const {
        return hidden_.failure() ? unwritable(place_, hidden_.failure()) : Result<void>{};
    }

    Result<void> write(const RawFrame& frame) override {
        if (complete_ || frame.number != frames_ || frame.depth.empty())
            return internal_error(place_.string() + ": frame " + std::to_string(frames_) +
                                  " with depth was due, " + std::to_string(frame.number) + " was given");
        TRY(write_frame(frame));
        ++frames_;
        return {};
    }

    Result<fs::path> complete() override {
        if (frames_ == 0) return input_error(place_.string() + ": not written: no frame was given");
        TRY(end());
        TRY(hidden_.sync(place_));
        complete_ = true;
        return hidden_.path() / opens_by_;
    }

    Result<void> finish() override {
        if (!complete_) TRY(complete());
        TRY(name_it());
        hidden_.remove();
        return {};
    }

protected:
    virtual Result<void> write_frame(const RawFrame& frame) = 0;
    /// Writes the scene file, last.
    virtual Result<void> end() = 0;
    virtual Result<void> name_it() = 0;

    Result<void> write_picture(PlaneRole role, const std::string& name, const PlaneView& plane) const {
        return write_png_to(hidden_.path() / name, plane, home_ / name, PngEffort::quick, png_colours(role));
    }
    Result<void> write_text(const std::string& name, const std::string& text) const {
        return hidden_.write(home_, name, text);
    }
    /// The description of the pictures, without their names.
    SceneDescription described_pictures() const {
        SceneDescription described(scene_);
        described.unstated = unstated_;
        described.scene.video.reset();
        described.scene.folder.emplace();
        described.scene.stored = {};  // codes
        return described;
    }

    fs::path place_;
    Scene scene_;
    SceneDescription::Unstated unstated_;
    Existing existing_;
    fs::path home_;
    std::string opens_by_;
    HiddenFolder hidden_;
    std::int64_t frames_ = 0;
    bool complete_ = false;
};

class FolderWriter final : public PictureWriter {
public:
    FolderWriter(const fs::path& place, const SceneDescription& described, Existing existing)
        : PictureWriter(place, described, existing, place) {}

private:
    Result<void> write_frame(const RawFrame& frame) override {
        if (frames_ == 0) first_ = kept_frame(frame);
        for (const PlaneRole role : all_roles) {
            const PlaneView& plane = plane_of(frame, role);
            if (plane.empty() != plane_of(first_, role).empty())
                return internal_error(place_.string() + ": frame " + std::to_string(frames_) +
                                      " has other planes than the first");
            if (!plane.empty()) TRY(write_plane(role, plane));
        }
        return {};
    }

    /// Writes a plane's picture; nothing is written while the plane has not changed.
    Result<void> write_plane(PlaneRole role, const PlaneView& plane) {
        bool& changes = changes_[static_cast<std::size_t>(role)];
        if (role != PlaneRole::depth && !changes) {
            const PlaneView& first = plane_of(first_, role);
            if (same_samples(first, plane)) return {};
            for (std::int64_t frame = 0; frame < frames_; ++frame) {
                if (stop_requested()) return interrupted_error();
                TRY(write_picture(role, numbered(role, frame), first));
            }
            changes = true;
        }
        return write_picture(role, numbered(role, frames_), plane);
    }

    Result<void> end() override {
        SceneDescription described = described_pictures();
        Scene& scene = described.scene;
        scene.folder->count = static_cast<int>(frames_);
        for (const auto& [role, plane] : planes_of(first_)) {
            const std::string name(role_name(role));
            const bool is_still = role != PlaneRole::depth && !changes_[static_cast<std::size_t>(role)];
            pattern_of(*scene.folder, role) = name + (is_still ? ".png" : "_%06d.png");
            if (is_still) TRY(write_picture(role, name + ".png", plane));
        }
        if (scene.rate.own_times) {
            scene.folder->depth = times_list;
            scene.folder->count = 0;  // as long as the list
            TRY(write_text(times_list, times()));
        }
        if (scene_.path)
            TRY(write_text(poses_list, timed_poses_text(*scene_.path, scene_.rate, scene_.metres_per_unit)));
        return write_text(scene_name, scene_to_json(described));
    }

    /// Seconds and name of each picture of depth, as TUM's recordings have them.
    std::string times() const {
        constexpr std::int64_t ns_a_second = 1'000'000'000;
        std::string list;
        for (std::int64_t frame = 0; frame < frames_; ++frame) {
            const std::int64_t ns = scene_.rate.time_ns(frame);
            list += formatted("%lld.%09lld ", static_cast<long long>(ns / ns_a_second),
                              static_cast<long long>(ns % ns_a_second)) +
                    numbered(PlaneRole::depth, frame) + '\n';
        }
        return list;
    }

    Result<void> name_it() override {
        std::error_code failure;
        const bool is_there = fs::exists(fs::symlink_status(place_, failure));
        if (!is_there || fs::is_empty(place_, failure)) {
            if (is_there) fs::remove(place_, failure);
            if (const int why = move_to_free_name(hidden_.path(), place_))
                return unwritable(place_, std::error_code(why, std::generic_category()));
        } else if (existing_ == Existing::keep || !is_image_folder(place_)) {
            return input_error(place_.string() + ": is there by now; it stays as it is");
        } else if (auto replaced = replace(); !replaced) {
            return replaced;
        }
        return sync_names(place_.parent_path(), place_);
    }

    /// Atomic if the file system can exchange two names; the old folder is then removed with the hidden one.
    Result<void> replace() {
        if (renameat2(AT_FDCWD, hidden_.path().c_str(), AT_FDCWD, place_.c_str(), RENAME_EXCHANGE) == 0)
            return {};
        const HiddenFolder aside(place_.parent_path());
        std::error_code failure = aside.failure();
        if (!failure) fs::rename(place_, aside.path() / "before", failure);
        if (failure) return unwritable(place_, failure);
        fs::rename(hidden_.path(), place_, failure);
        if (!failure) return {};
        std::error_code ignored;
        fs::rename(aside.path() / "before", place_, ignored);
        return unwritable(place_, failure);
    }

    RawFrame first_;
    std::array<bool, all_roles.size()> changes_{};
};

class StillWriter final : public PictureWriter {
public:
    /// `depth`, `text`: names of the depth picture, and of the file that describes all.
    struct Form {
        std::string depth, text;
        std::string (*describe)(const SceneDescription&);  // names are in scene.folder
    };
    StillWriter(const fs::path& place, const SceneDescription& described, Existing existing, Form form)
        : PictureWriter(place, described, existing, place.parent_path(), form.text), form_(std::move(form)) {}

private:
    Result<void> write_frame(const RawFrame& frame) override {
        if (frames_ > 0) return internal_error(place_.string() + ": is of one frame");
        SceneDescription described = described_pictures();
        Scene& scene = described.scene;
        for (const auto& [role, plane] : planes_of(frame)) {
            names_.push_back(role == PlaneRole::depth ? form_.depth : picture_beside(place_, role));
            pattern_of(*scene.folder, role) = names_.back();
            TRY(write_picture(role, names_.back(), plane));
        }
        names_.push_back(form_.text);
        return write_text(form_.text, form_.describe(described));
    }
    Result<void> end() override { return {}; }
    Result<void> name_it() override { return hidden_.move_to(home_, names_, existing_); }

    Form form_;
    std::vector<std::string> names_;  // of its files, in the order in which they appear
};

/// Depth alone, as floats.
class FloatWriter final : public PictureWriter {
public:
    FloatWriter(const fs::path& place, const SceneDescription& described, Existing existing)
        : PictureWriter(place, described, existing, place.parent_path(), place.stem().string() + ".json"),
          is_exr_(small_letters(place.extension().string()) == ".exr"),
          metres_(metres_of_codes(scene_.depth, scene_.metres_per_unit)) {}

private:
    Result<void> write_frame(const RawFrame& frame) override {
        if (is_exr_ && frames_ > 0) return internal_error(place_.string() + ": is of one frame");
        std::vector<float> floats;
        for (int y = 0; y < frame.depth.height; ++y)
            for (int x = 0; x < frame.depth.width; ++x)
                floats.push_back(metres_[stored_code(frame.depth, scene_.depth, x, y)]);
        std::string bytes(reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float));
        if (is_exr_) TRY(assign(bytes, exr_bytes(floats, scene_.width, scene_.height)));
        if (frames_ == 0) {
            file_.open(hidden_.path() / place_.filename(), std::ios::binary);
            if (!is_exr_) file_ << npy_header(0, scene_.height, scene_.width);
        }
        file_ << bytes;
        return written();
    }

    Result<void> end() override {
        if (!is_exr_) file_.seekp(0) << npy_header(frames_, scene_.height, scene_.width);
        file_.close();
        TRY(written());
        SceneDescription described = described_pictures();
        Scene& scene = described.scene;
        scene.folder->depth = place_.filename().string();
        scene.depth = {.kind = DepthCodingKind::metric,
                       .semantics = scene_.depth.semantics,
                       .near = scene_.depth.kind == DepthCodingKind::metric ? scene_.depth.near : 0,
                       .far = scene_.depth.far,
                       .scale = 1 / scene_.metres_per_unit,
                       .code_max = 65535};
        scene.depth_bits = 16;
        scene.height_coding = {};
        scene.rate.own_times.reset();  // an array has no times: their mean rate stays
        described.unstated.rate = false;
        // A scene file's far plane is that of a whole number of its scale: nearer ones are found in the frames.
        described.unstated.far = scene.depth.far < scene.depth.scale;
        return write_text(opens_by_, scene_to_json(described));
    }
    Result<void> name_it() override {
        return hidden_.move_to(home_, {place_.filename().string(), opens_by_}, existing_);
    }
    Result<void> written() const {
        if (file_) return {};
        return unwritable(place_, std::error_code(errno, std::generic_category()));
    }

    const bool is_exr_;
    const std::vector<float> metres_;  // of each code
    std::ofstream file_;
};

/// The path with all links followed, so that their target is replaced.
fs::path whole_name(const fs::path& path) {
    std::error_code failure;
    fs::path whole = fs::weakly_canonical(fs::absolute(path, failure), failure);
    if (failure) whole = fs::absolute(path, failure).lexically_normal();
    return whole.has_filename() ? whole : whole.parent_path();
}

Result<void> check_place(const fs::path& place, const SceneDescription& described) {
    std::error_code failure;
    if (!fs::is_directory(place.parent_path(), failure))
        return input_error(place.string() + ": cannot be written: there is no folder " +
                           place.parent_path().string());
    SceneDescription pictures = described;
    pictures.scene.folder.reset();
    pictures.scene.video.reset();
    return error_at(place.string(), validate(pictures));
}

/// % and * stand for numbers in the names that a scene file has of pictures.
Result<void> check_name(const fs::path& still) {
    const std::string stem = still.stem().string();
    if (is_still(stem + ".png")) return {};
    return usage_error(still.string() + ": has a % or * in its name, which stand for numbers");
}

template <class Writer, class... More>
Result<std::unique_ptr<ClipWriter>> opened_writer(const fs::path& path, const SceneDescription& described,
                                                  Existing existing, More... more) {
    const fs::path place = whole_name(path);
    TRY(check_place(place, described));
    return opened_as<ClipWriter>(std::make_unique<Writer>(place, described, existing, std::move(more)...));
}

std::string scene_text_of(const SceneDescription& described) {
    const Scene& scene = described.scene;
    const mpeg4::SceneTree tree =
        mpeg4::scene_of(mpeg4::nodes_of_pictures(described), scene.width, scene.height);
    return "# The text of an MPEG-4 scene; touchable play opens it\n" + mpeg4::scene_text(tree);
}

/// Whether a name is a plane's picture's ("depth_000000.png", or "haptic.png") or a describing file's.
bool is_picture_name(const std::string& name) {
    if (name == scene_name || name == times_list || name == poses_list) return true;
    return std::ranges::any_of(all_roles, [&](PlaneRole role) {
        const std::string begin(role_name(role)), end = ".png";
        if (!name.starts_with(begin) || !name.ends_with(end)) return false;
        const std::string between = name.substr(begin.size(), name.size() - begin.size() - end.size());
        if (between.empty()) return true;
        return between.size() >= 7 && between[0] == '_' && is_digits(between.substr(1));
    });
}

}  // namespace

Opened open_image_folder(const fs::path& folder, const GuessedScene& described, Colour colour,
                         DepthAlignment alignment) {
    assert(described.scene.folder);
    StoredClip clip{folder.string(), described};
    clip.notes = described.notes;
    clip.alignment = alignment;
    StillMaps maps;
    if (std::string& haptic = clip.described.scene.folder->haptic; is_surface_file(haptic)) {
        maps.haptic = folder / haptic;
        haptic.clear();
    }
    auto pictures =
        std::make_unique<FolderPictures>(folder, described.scene, described.pictures, described.video);
    TRY(pictures->find(clip, colour));
    clip.pictures = std::move(pictures);
    return with_still_maps(open_stored_clip(std::move(clip), colour), maps);
}

bool is_image_folder(const fs::path& folder) {
    std::error_code failure;
    for (const auto& entry : fs::directory_iterator(folder, failure)) {
        const bool is_file = entry.is_regular_file(failure);
        if (failure || !is_file || !is_picture_name(entry.path().filename().string())) return false;
    }
    return !failure;
}

Result<std::unique_ptr<ClipWriter>> create_image_folder(const fs::path& folder,
                                                        const SceneDescription& described,
                                                        Existing existing) {
    return opened_writer<FolderWriter>(folder, described, existing);
}

Result<std::unique_ptr<ClipWriter>> create_still(const fs::path& picture, const SceneDescription& described,
                                                 Existing existing) {
    TRY(check_name(picture));
    const StillWriter::Form form{picture.filename().string(), picture.stem().string() + ".json",
                                 scene_to_json};
    return opened_writer<StillWriter>(picture, described, existing, form);
}

Result<std::unique_ptr<ClipWriter>> create_float_depth(const fs::path& path,
                                                       const SceneDescription& described, Existing existing) {
    TRY(check_name(path));
    return opened_writer<FloatWriter>(path, described, existing);
}

std::vector<fs::path> still_files(const fs::path& picture) {
    const fs::path folder = picture.parent_path();
    const std::string stem = picture.stem().string();
    std::vector<fs::path> files{picture, folder / (stem + ".json")};
    for (const PlaneRole role : {PlaneRole::colour, PlaneRole::haptic, PlaneRole::height})
        files.push_back(folder / picture_beside(picture, role));
    return files;
}

Result<std::unique_ptr<ClipWriter>> create_scene_text(const fs::path& text, const SceneDescription& described,
                                                      Existing existing) {
    if (text.filename().string().starts_with("od:"))  // as texts name objects of an MP4 file
        return usage_error(text.string() + ": must not begin with od:, which names tracks in a scene's text");
    TRY(check_name(text));
    const StillWriter::Form form{picture_beside(text, PlaneRole::depth), text.filename().string(),
                                 scene_text_of};
    return opened_writer<StillWriter>(text, described, existing, form);
}

std::vector<fs::path> described_still_files(const fs::path& text) {
    std::vector<fs::path> files{text};
    for (const PlaneRole role : all_roles) files.push_back(text.parent_path() / picture_beside(text, role));
    return files;
}

}  // namespace touchable
