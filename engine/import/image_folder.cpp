#include "engine/import/image_folder.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "engine/clip/far_plane.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/import/guess/depth_values.hpp"
#include "engine/import/guess/frame_cameras.hpp"
#include "engine/import/guess/number_words.hpp"
#include "engine/import/guess/picture_files.hpp"
#include "engine/import/touch_maps/still_maps.hpp"
#include "engine/picture/npy_stack.hpp"
#include "engine/picture/stored_image.hpp"
#include "engine/stop_request.hpp"
#include "engine/video/codecs.hpp"

namespace touchable {
namespace {

class ImageFolderReader final : public ClipReader {
public:
    ImageFolderReader(std::filesystem::path folder, SceneDescription described,
                      std::vector<std::string> notes, std::shared_ptr<ReadPictures> pictures)
        : folder_(std::move(folder)),
          described_(std::move(described)),
          notes_(std::move(notes)),
          pictures_(pictures ? std::move(pictures) : std::make_shared<ReadPictures>()),
          values_(described_) {}
    Result<void> open();
    bool leaves_far_open() const { return values_.leaves_far_open(); }
    /// The folder, or the one picture that is read.
    std::string name() const {
        const auto& files = tracks_.front().files.files;
        return files.front() == files.back() ? files.front().string() : folder_.string();
    }

    const Scene& scene() const override { return scene_; }
    UnstatedFilters unstated_filters() const override { return described_.unstated.filters; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return count_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    std::span<const Camera> frame_cameras() const override { return cameras_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override;
    std::int64_t access_point(std::int64_t frame) const override { return frame; }
    void leave_out_colour() override { with_colour_ = false; }

private:
    struct Track {
        PlaneRole role;
        PictureFiles files;
        std::shared_ptr<ImageStack> stack;  // that holds all frames
        Plane still{};                      // the picture of every frame
        bool is_still() const {
            return !stack && files.count() > 1 && files.file(0) == files.file(files.count() - 1);
        }
    };

    static std::string where(const Track& track, std::int64_t frame) {
        return track.files.file(static_cast<std::size_t>(frame)).string() + " (" +
               std::string(role_name(track.role)) + ", frame " + std::to_string(frame) + ")";
    }
    Result<void> find_files();
    Result<std::vector<Camera>> read_cameras(const PictureFiles& depth);
    Result<void> settle_scene(const PictureFiles& depth);
    Result<void> read_first();
    Result<void> look_at_some(const StoredImage& first);
    Result<StoredImage> read(const Track& track, std::int64_t frame) const;
    Result<Plane> fitted(const Track& track, std::int64_t frame, StoredImage stored) const;
    Result<Plane> plane(const Track& track, std::int64_t frame) const;

    std::filesystem::path folder_;
    const SceneDescription described_;
    Scene scene_;
    std::vector<Track> tracks_;  // depth is the first
    std::vector<TrackInfo> infos_;
    std::vector<Camera> cameras_;  // of the frames; empty: the scene's
    std::vector<std::string> notes_;
    std::int64_t count_ = 0;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool with_colour_ = true;
    std::shared_ptr<ReadPictures> pictures_;  // not null
    std::optional<RawFrame> first_;           // read to learn how pictures are stored, not yet given away
    DepthValues values_;
};

Result<void> ImageFolderReader::open() {
    if (auto found = find_files(); !found) return found;
    if (auto read = read_first(); !read) return read;
    if (auto note = default_touch_note(!scene_.folder->haptic.empty(), scene_))
        notes_.push_back(std::move(*note));
    return {};
}

/// Every track has every frame, or the first that is missing is named.
Result<void> ImageFolderReader::find_files() {
    const FolderSource& source = *described_.scene.folder;
    auto depth = depth_files(folder_, source);
    if (!depth) return depth.error();
    if (!depth->remark.empty()) notes_.push_back(depth->remark);
    // Of a single file that holds a stack of pictures.
    auto stack = depth->files.size() == 1 ? pictures_->stack_in(depth->files.front())
                                          : Result<std::shared_ptr<ImageStack>>(nullptr);
    if (!stack) return stack.error();
    if (*stack) depth->frames = static_cast<std::size_t>((*stack)->count());
    for (const PlaneRole role : all_roles) {
        if (pattern_of(source, role).empty()) continue;
        auto found = role == PlaneRole::depth ? depth : files_beside(folder_, role, source, *depth);
        if (!found) return found.error();
        if (role != PlaneRole::depth && !found->remark.empty()) notes_.push_back(found->remark);
        if (!found->list.empty()) add_input(found->list);
        for (const auto& file : found->files)
            if (inputs().empty() || inputs().back() != file) add_input(file);
        tracks_.push_back({role, std::move(*found), role == PlaneRole::depth ? *stack : nullptr});
    }
    count_ = static_cast<std::int64_t>(depth->count());
    return settle_scene(*depth);
}

/// What the scene does not say of its camera and its times, the files do.
Result<void> ImageFolderReader::settle_scene(const PictureFiles& depth) {
    FoundInClip found{.rate = own_rate_of(depth)};
    std::vector<Camera> cameras;
    if (!described_.scene.folder->cameras.empty()) {
        auto read = read_cameras(depth);
        if (!read) return read.error();
        cameras = std::move(*read);
        if (described_.unstated.camera) found.camera = median_camera(cameras);
    }
    auto scene = settle(described_, found);
    if (!scene) return input_error(name() + ": " + scene.error().message);
    scene_ = std::move(*scene);
    if (described_.unstated.camera) notes_.emplace_back("the camera is the median of those of the frames");
    const bool differ = std::any_of(cameras.begin(), cameras.end(),
                                    [&](const Camera& camera) { return !(camera == scene_.camera); });
    if (differ) cameras_ = std::move(cameras);
    if (!described_.unstated.rate) return {};
    if (const std::string why = unusable_times(depth); !why.empty())
        notes_.push_back(why + ": played at " + short_number(scene_.rate.per_second()) +
                         " frames a second (the scene's rate says otherwise)");
    return {};
}

/// Of the frames.
Result<std::vector<Camera>> ImageFolderReader::read_cameras(const PictureFiles& depth) {
    auto found = camera_files(folder_, *described_.scene.folder, depth);
    if (!found) return found.error();
    if (!found->remark.empty()) notes_.push_back(found->remark);
    if (!found->list.empty()) add_input(found->list);
    for (const auto& file : found->files)
        if (inputs().empty() || inputs().back() != file) add_input(file);
    return read_frame_cameras(*found, described_.scene.width, described_.scene.height);
}

/// How frame 0 is stored stands for all.
Result<void> ImageFolderReader::read_first() {
    RawFrame first;
    for (Track& track : tracks_) {
        auto stored = read(track, 0);
        if (!stored) return stored.error();
        const Image& image = stored->image;
        infos_.push_back({std::string(role_name(track.role)), stored->codec, stored->pixel_format,
                          image.width, image.height});
        if (track.role != PlaneRole::depth && (image.width != scene_.width || image.height != scene_.height))
            notes_.push_back(resampling_note(track.role, image.width, image.height, scene_));
        if (auto note = lossy_note(track.role, stored->codec)) notes_.push_back(std::move(*note));
        if (track.role == PlaneRole::depth && values_.needs_looks(*stored))
            if (auto looked = look_at_some(*stored); !looked) return looked;
        if (track.role == PlaneRole::haptic && image.channels == 1)
            notes_.push_back(take_grey_haptic(scene_));
        auto fits = fitted(track, 0, std::move(*stored));
        if (!fits) return fits.error();
        if (track.is_still()) track.still = *fits;
        add_plane(first, track.role, std::move(*fits));
    }
    first.time_ns = scene_.rate.time_ns(0);
    if (auto note = no_depth_note(first, scene_.depth)) notes_.push_back(std::move(*note));
    first_ = std::move(first);
    return {};
}

/// Depth that is no codes yet: its range in these frames settles what they will be. A later one that is
/// damaged tells nothing.
Result<void> ImageFolderReader::look_at_some(const StoredImage& first) {
    values_.look(first);
    for (const std::int64_t frame : telling_frames(count_)) {
        if (stop_requested())
            return Error{ErrorKind::interrupted, "interrupted while the clip's range of depth was searched"};
        if (frame == 0) continue;
        auto stored = read(tracks_.front(), frame);
        if (!stored && stored.error().kind == ErrorKind::interrupted) return stored.error();
        if (!stored) continue;
        values_.look(*stored);
        if (frame < first_frames && !tracks_.front().stack)
            pictures_->keep(tracks_.front().files.file(static_cast<std::size_t>(frame)), std::move(*stored));
    }
    auto note = values_.settle(scene_);
    if (!note) return input_error(name() + ": " + note.error().message);
    notes_.push_back(std::move(*note));
    return {};
}

Result<StoredImage> ImageFolderReader::read(const Track& track, std::int64_t frame) const {
    const auto& file = track.files.file(static_cast<std::size_t>(frame));
    auto stored = track.stack ? track.stack->image(frame) : pictures_->take(file);
    if (!stored)
        return Error{stored.error().kind, stored.error().message + " (" + std::string(role_name(track.role)) +
                                              ", frame " + std::to_string(frame) + ")"};
    if (!stored->values.empty() && track.role != PlaneRole::depth)
        return input_error(where(track, frame) + ": is a picture of floats: must be of integers");
    const bool is_grey = (track.role == PlaneRole::depth && scene_.depth.kind != DepthCodingKind::hue) ||
                         track.role == PlaneRole::height;
    if (is_grey && stored->image.channels == 3)
        if (auto grey = as_grey(stored->image)) stored->image = std::move(*grey);
    if (track.role == PlaneRole::haptic && stored->codec == "mjpeg")
        return input_error(where(track, frame) + ": is JPEG, which mixes materials; haptic is PNG");
    if (track.role != PlaneRole::colour && stored->interlaced)
        return input_error(where(track, frame) + ": is an interlaced PNG: must be a plain one to be touched");
    return stored;
}

Result<Plane> ImageFolderReader::plane(const Track& track, std::int64_t frame) const {
    if (!track.still.view.empty()) return track.still;
    auto stored = read(track, frame);
    if (!stored) return stored.error();
    const TrackInfo& info = infos_[static_cast<std::size_t>(&track - tracks_.data())];
    const Image& image = stored->image;
    if (image.width != info.width || image.height != info.height || stored->pixel_format != info.pixel_format)
        return input_error(where(track, frame) + ": is " + std::to_string(image.width) + "x" +
                           std::to_string(image.height) + " " + stored->pixel_format + ", but frame 0 is " +
                           std::to_string(info.width) + "x" + std::to_string(info.height) + " " +
                           info.pixel_format);
    return fitted(track, frame, std::move(*stored));
}

Result<Plane> ImageFolderReader::fitted(const Track& track, std::int64_t frame, StoredImage stored) const {
    const bool is_made = track.role == PlaneRole::depth && values_.makes_codes();
    const int bits = is_made ? 16 : stored.bits;
    Image image = is_made ? values_.codes(std::move(stored)) : std::move(stored.image);
    return fit_plane(track.role, plane_from(std::move(image), bits), scene_, where(track, frame));
}

Result<void> ImageFolderReader::seek(std::int64_t frame) {
    if (frame < 0 || frame > count_)
        return usage_error(folder_.string() + ": has no frame " + std::to_string(frame) +
                           ": must be from 0 to " + std::to_string(count_ - 1));
    number_ = frame;
    return {};
}

Result<std::optional<RawFrame>> ImageFolderReader::next() {
    if (number_ == count_) return std::optional<RawFrame>{};
    if (number_ == 0 && first_) {
        ++number_;
        return std::exchange(first_, std::nullopt);
    }
    RawFrame frame;
    frame.number = number_;
    frame.time_ns = scene_.rate.time_ns(number_);
    for (const Track& track : tracks_) {
        if (track.role == PlaneRole::colour && !with_colour_) continue;
        auto read = plane(track, number_);
        if (!read) return read.error();
        add_plane(frame, track.role, std::move(*read));
    }
    ++number_;
    return std::optional(std::move(frame));
}

}  // namespace

Result<std::unique_ptr<ClipReader>> open_image_folder(const std::filesystem::path& folder,
                                                      const SceneDescription& described,
                                                      std::vector<std::string> notes, Colour colour,
                                                      std::shared_ptr<ReadPictures> opened) {
    if (!described.scene.folder)
        return input_error(
            folder.string() +
            ": is a folder, but its scene file has no member \"folder\" that says which images to read");
    StillMaps maps;
    SceneDescription pictures = described;
    if (std::string& haptic = pictures.scene.folder->haptic; is_surface_file(haptic)) {
        maps.haptic = folder / haptic;
        haptic.clear();
    }
    auto reader =
        std::make_unique<ImageFolderReader>(folder, std::move(pictures), std::move(notes), std::move(opened));
    if (auto opened = reader->open(); !opened) return opened.error();
    if (colour == Colour::left_out) reader->leave_out_colour();
    const auto name = reader->name();
    const bool far_is_open = reader->leaves_far_open();
    return with_still_maps(with_far_plane(std::move(reader), far_is_open, name), maps);
}

}  // namespace touchable
