#include "engine/formats/image_folder.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/formats/frame_cameras.hpp"
#include "engine/formats/frame_poses.hpp"
#include "engine/formats/material_pictures.hpp"
#include "engine/formats/picture_files.hpp"
#include "engine/formats/still_maps.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/picture/npy_stack.hpp"

namespace touchable {
namespace {

/// A file for each picture, or one that holds those of all frames.
class FolderPictures final : public FrameSource {
public:
    FolderPictures(std::filesystem::path folder, const Scene& scene, std::shared_ptr<ReadPictures> pictures)
        : folder_(std::move(folder)),
          rules_{scene.depth.kind, scene.folder->haptic_may_be_lossy},
          pictures_(pictures ? std::move(pictures) : std::make_shared<ReadPictures>()) {}
    Result<void> find(StoredClip& clip, Colour colour);

    std::string where(PlaneRole role, std::int64_t frame) const override {
        return file(track(role), frame).string() + in_words(role, frame);
    }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override;
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        return track(role).is_still() ? 0 : frame;
    }
    /// Tracks of files of their own.
    bool reads_side_by_side() const override { return reads_side_by_side_; }
    void keep(std::int64_t frame, StoredImage picture) override {
        if (!tracks_.front().stack) pictures_->keep(file(tracks_.front(), frame), std::move(picture));
    }

private:
    struct Track {
        PlaneRole role;
        PictureFiles files;
        std::shared_ptr<ImageStack> stack;  // that holds all frames
        bool is_still() const {
            return !stack && files.count() > 1 && files.file(0) == files.file(files.count() - 1);
        }
    };

    static std::string in_words(PlaneRole role, std::int64_t frame) {
        return " (" + std::string(role_name(role)) + ", frame " + std::to_string(frame) + ")";
    }
    static const std::filesystem::path& file(const Track& track, std::int64_t frame) {
        return track.files.file(static_cast<std::size_t>(frame));
    }
    const Track& track(PlaneRole role) const { return *std::ranges::find(tracks_, role, &Track::role); }
    Result<void> find_cameras(const PictureFiles& depth, StoredClip& clip) const;
    void find_poses(const PictureFiles& depth, StoredClip& clip) const;
    bool shares_depths_files(PlaneRole role) const;
    void tell_of_materials(StoredClip& clip);

    std::filesystem::path folder_;
    StillRules rules_;
    std::vector<Track> tracks_;               // depth is the first
    std::shared_ptr<ReadPictures> pictures_;  // not null
    std::optional<MaterialPictures> materials_;
    bool reads_side_by_side_ = false;
};

/// Of files with pictures of several planes.
PictureLayer layer_of(PlaneRole role) {
    if (role == PlaneRole::colour) return PictureLayer::colour;
    return role == PlaneRole::haptic ? PictureLayer::materials : PictureLayer::own;
}

/// Files that were found for a track are inputs of the clip, each once.
void add_inputs(const PictureFiles& found, StoredClip& clip) {
    if (!found.remark.empty()) clip.notes.push_back(found.remark);
    if (!found.list.empty()) clip.inputs.push_back(found.list);
    for (const auto& file : found.files)
        if (clip.inputs.empty() || clip.inputs.back() != file) clip.inputs.push_back(file);
}

/// Every track has every frame, or the first that is missing is named.
Result<void> FolderPictures::find(StoredClip& clip, Colour colour) {
    const SceneDescription& described = clip.described;
    const FolderSource& source = *described.scene.folder;
    auto depth = depth_files(folder_, source);
    if (!depth) return depth.error();
    // Of a single file that holds a stack of pictures.
    TRY_ASSIGN(auto stack, depth->files.size() == 1 ? pictures_->stack_in(depth->files.front())
                                                    : Result<std::shared_ptr<ImageStack>>(nullptr));
    if (stack) depth->frames = static_cast<std::size_t>(stack->count());
    const bool has_confidence = stack && stack->least_confidence();
    if (pictures_->least_confidence() && !has_confidence)
        return usage_error(
            depth->files.front().string() +
            ": has no confidence beside its depth, so none can be the least: must be a .npz with "
            "an array conf");
    if (has_confidence)
        clip.notes.push_back(
            "depth whose confidence is below " + short_number(*stack->least_confidence()) +
            " is taken for none (half of the median of frame 0's where nobody says another)");
    for (const PlaneRole role : all_roles) {
        if (pattern_of(source, role).empty()) continue;
        const bool is_depths = role == PlaneRole::depth ||
                               (pattern_of(source, role) == source.depth && !numbers_of(source, role).any());
        TRY_ASSIGN(auto found, is_depths ? depth : files_beside(folder_, role, source, *depth));
        if (role == PlaneRole::depth || !is_depths) add_inputs(found, clip);
        clip.roles.push_back(role);
        tracks_.push_back({role, std::move(found), role == PlaneRole::depth ? stack : nullptr});
    }
    if (!described.materials.empty()) materials_.emplace(described);
    if (!stack) tell_of_materials(clip);
    pictures_->want_beside({colour == Colour::wanted && shares_depths_files(PlaneRole::colour),
                            shares_depths_files(PlaneRole::haptic)});
    reads_side_by_side_ = !stack && std::none_of(tracks_.begin() + 1, tracks_.end(), [&](const Track& track) {
        return shares_depths_files(track.role);
    });
    clip.count = static_cast<std::int64_t>(depth->count());
    const auto& files = depth->files;
    clip.name = (files.front() == files.back() ? files.front() : folder_).string();
    clip.found.rate = own_rate_of(*depth);
    find_poses(*depth, clip);
    if (!source.cameras.empty())
        if (auto read = find_cameras(*depth, clip); !read) return read;
    if (!described.unstated.rate) return {};
    const FrameRate rate = clip.found.rate.value_or(described.scene.rate);
    if (const std::string why = unusable_times(*depth); !why.empty())
        clip.notes.push_back(why + ": played at " + short_number(rate.per_second()) +
                             " frames a second (the scene's rate says otherwise)");
    return {};
}

/// What they feel like, or that nothing says it.
void FolderPictures::tell_of_materials(StoredClip& clip) {
    if (materials_)
        clip.notes.push_back("haptic is that of " + std::to_string(clip.described.materials.size()) +
                             " materials, by their indices; other indices have the default properties");
    const bool has_haptic = std::ranges::count(tracks_, PlaneRole::haptic, &Track::role) > 0;
    if (has_haptic) return;
    const auto looked = pictures_->look(file(tracks_.front(), 0));
    if (!looked || !(*looked)->beside || !(*looked)->beside->materials) return;
    std::string list;
    for (const int index : indices_in(*(*looked)->beside->materials))
        list += (list.empty() ? "" : ", ") + std::to_string(index);
    clip.notes.push_back(
        "haptic is not there: the files have material indices (" + (*looked)->beside->materials_name + ": " +
        list +
        "), but nothing says what they feel like: haptic.materials in a scene file does, with "
        "folder.haptic as folder.depth (docs/scene_file.md; touchable init-scene writes one "
        "to begin with)");
}

bool FolderPictures::shares_depths_files(PlaneRole role) const {
    const auto own = std::ranges::find(tracks_, role, &Track::role);
    return own != tracks_.end() && own->files.files == tracks_.front().files.files;
}

/// Nothing goes by them but who asks: poses that cannot be read are no error.
void FolderPictures::find_poses(const PictureFiles& depth, StoredClip& clip) const {
    Scene& scene = clip.described.scene;
    if (depth.count() < 2) return;
    const FrameRate rate = clip.described.unstated.rate ? clip.found.rate.value_or(scene.rate) : scene.rate;
    auto found = poses_beside(folder_, depth, rate, scene.metres_per_unit);
    if (!found) return;
    clip.notes.push_back(std::move(found->remark));
    if (found->path.poses.empty()) return;
    scene.path = std::make_shared<const CameraPath>(std::move(found->path));
    if (std::ranges::find(clip.inputs, found->file) == clip.inputs.end()) clip.inputs.push_back(found->file);
}

/// Of the frames; their median is the scene's, where it has none.
Result<void> FolderPictures::find_cameras(const PictureFiles& depth, StoredClip& clip) const {
    const Scene& scene = clip.described.scene;
    TRY_ASSIGN(auto found, camera_files(folder_, *scene.folder, depth));
    add_inputs(found, clip);
    TRY_ASSIGN(auto cameras, read_frame_cameras(found, scene.width, scene.height));
    clip.cameras = std::move(cameras);
    if (!clip.described.unstated.camera) return {};
    clip.found.camera = median_camera(clip.cameras);
    clip.notes.emplace_back("the camera is the median of those of the frames");
    return {};
}

Result<TrackPicture> FolderPictures::picture(PlaneRole role, std::int64_t frame) {
    const Track& from = track(role);
    auto stored = from.stack ? from.stack->image(frame) : pictures_->take(file(from, frame), layer_of(role));
    if (!stored) return Error{stored.error().kind, stored.error().message + in_words(role, frame)};
    if (role == PlaneRole::haptic && materials_) {
        stored = materials_->haptic(*stored);
        if (!stored) return error_at(where(role, frame), stored.error());
    } else if (role == PlaneRole::haptic && stored->codec == "exr") {
        return input_error(where(role, frame) +
                           ": is of material indices: the scene file's haptic.materials must say what they "
                           "feel like");
    }
    return track_picture(std::move(*stored), role, rules_, where(role, frame));
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_image_folder(const std::filesystem::path& folder,
                                                      const SceneDescription& described,
                                                      std::vector<std::string> notes, Colour colour,
                                                      std::shared_ptr<ReadPictures> opened,
                                                      DepthAlignment alignment) {
    if (!described.scene.folder)
        return input_error(
            folder.string() +
            ": is a folder, but its scene file has no member \"folder\" that says which images to read");
    StoredClip clip{folder.string(), described};
    clip.notes = std::move(notes);
    clip.alignment = alignment;
    StillMaps maps;
    if (std::string& haptic = clip.described.scene.folder->haptic; is_surface_file(haptic)) {
        maps.haptic = folder / haptic;
        haptic.clear();
    }
    auto pictures = std::make_unique<FolderPictures>(folder, described.scene, std::move(opened));
    TRY(pictures->find(clip, colour));
    clip.pictures = std::move(pictures);
    return with_still_maps(open_stored_clip(std::move(clip), colour), maps);
}

}  // namespace touchable
