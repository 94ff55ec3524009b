#include "engine/import/image_folder.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <utility>

#include "engine/media/codecs.hpp"
#include "engine/media/far_plane.hpp"
#include "engine/media/plane_role.hpp"
#include "engine/media/stored_image.hpp"
#include "engine/printable.hpp"

namespace touchable {
namespace {

/// A file pattern with at most one field of digits, %d or %0Nd, which the scene has checked.
class Pattern {
public:
    explicit Pattern(const std::string& text) {
        if (is_still(text)) {
            still_ = text;
            return;
        }
        const auto percent = text.find('%'), end = text.find('d', percent);
        before_ = text.substr(0, percent);
        if (end > percent + 1) digits_ = static_cast<std::size_t>(text[percent + 2] - '0');
        after_ = text.substr(end + 1);
    }
    std::filesystem::path file(const std::filesystem::path& folder, std::int64_t number) const {
        if (!still_.empty()) return folder / still_;
        std::string field = std::to_string(number);
        if (field.size() < digits_) field.insert(0, digits_ - field.size(), '0');
        return folder / (before_ + field + after_);
    }
    /// Numbers of the files that are there, from `first` on, in order.
    std::vector<std::int64_t> numbers(const std::filesystem::path& folder, std::int64_t first) const {
        std::vector<std::int64_t> found;
        const std::string before = (folder / before_).filename().string();
        std::error_code ignored;
        for (const auto& entry :
             std::filesystem::directory_iterator((folder / before_).parent_path() / "", ignored)) {
            const std::string name = entry.path().filename().string();
            if (!name.starts_with(before) || name.size() <= before.size() + after_.size()) continue;
            const char* digits = name.data() + before.size();
            std::int64_t number = 0;
            const auto [end, failure] =
                std::from_chars(digits, name.data() + name.size() - after_.size(), number);
            const bool named_so = failure == std::errc() && file(folder, number).filename() == name;
            if (named_so && number >= first) found.push_back(number);
        }
        std::sort(found.begin(), found.end());
        return found;
    }

private:
    std::string still_;  // the whole name where it has no field
    std::string before_, after_;
    std::size_t digits_ = 1;
};

const std::string& pattern_of(const FolderSource& source, PlaneRole role) {
    switch (role) {
        case PlaneRole::depth:
            return source.depth;
        case PlaneRole::colour:
            return source.colour;
        case PlaneRole::haptic:
            return source.haptic;
        case PlaneRole::height:
            break;
    }
    return source.height;
}

bool is_file(const std::filesystem::path& file) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(file, ignored);
}

class ImageFolderReader final : public ClipReader {
public:
    ImageFolderReader(std::filesystem::path folder, const Scene& scene)
        : folder_(std::move(folder)), scene_(scene) {}
    Result<void> open();

    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return infos_; }
    std::optional<std::int64_t> frame_count() const override { return count_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override;
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override;
    std::int64_t access_point(std::int64_t frame) const override { return frame; }
    void leave_out_colour() override { with_colour_ = false; }

private:
    struct Track {
        PlaneRole role;
        Pattern pattern;
    };

    std::filesystem::path file(const Track& track, std::int64_t frame) const {
        return track.pattern.file(folder_, scene_.folder->first + frame);
    }
    std::string where(const Track& track, std::int64_t frame) const {
        return file(track, frame).string() + " (" + std::string(role_name(track.role)) + ", frame " +
               std::to_string(frame) + ")";
    }
    Result<void> count_frames();
    std::string beyond(std::int64_t frame) const;
    Result<void> read_first();
    Result<void> find_far_plane();
    Result<StoredImage> read(const Track& track, std::int64_t frame) const;
    Result<Plane> plane(const Track& track, std::int64_t frame) const;

    std::filesystem::path folder_;
    Scene scene_;
    std::vector<Track> tracks_;  // depth is the first
    std::vector<TrackInfo> infos_;
    std::vector<std::string> notes_;
    std::int64_t count_ = 0;
    std::int64_t number_ = 0;  // of the frame that `next` gives
    bool with_colour_ = true;
};

Result<void> ImageFolderReader::open() {
    for (const PlaneRole role : all_roles) {
        const std::string& pattern = pattern_of(*scene_.folder, role);
        if (!pattern.empty()) tracks_.push_back({role, Pattern(pattern)});
    }
    if (auto counted = count_frames(); !counted) return counted;
    if (auto read = read_first(); !read) return read;
    if (auto note = default_touch_note(!scene_.folder->haptic.empty(), scene_))
        notes_.push_back(std::move(*note));
    return scene_.far_from_frames ? find_far_plane() : Result<void>{};
}

/// Every track has every frame, or the first that is missing is named.
Result<void> ImageFolderReader::count_frames() {
    count_ = is_still(scene_.folder->depth) ? 1 : scene_.folder->count;
    if (count_ == 0)
        while (is_file(file(tracks_.front(), count_))) ++count_;
    const std::int64_t checked = count_ == 0 ? 1 : count_;
    for (const Track& track : tracks_)
        for (std::int64_t frame = 0; frame < checked; ++frame) {
            if (!is_file(file(track, frame)))
                return input_error(where(track, frame) + ": is missing" + (count_ == 0 ? beyond(0) : ""));
            add_input(file(track, frame));
        }
    const bool to_the_end = scene_.folder->count == 0 && !is_still(scene_.folder->depth);
    const std::string later = to_the_end ? beyond(count_) : "";
    if (!later.empty())
        notes_.push_back("ends after " + std::to_string(count_) + " frames: " +
                         file(tracks_.front(), count_).filename().string() + " is missing" + later);
    return {};
}

/// Where depth's picture of this frame is missing and later ones are there: which numbers are missing.
std::string ImageFolderReader::beyond(std::int64_t frame) const {
    const Track& depth = tracks_.front();
    std::int64_t expected = scene_.folder->first + frame;
    if (is_still(scene_.folder->depth)) return "";
    const auto later = depth.pattern.numbers(folder_, expected);
    if (later.empty()) return "";
    if (frame == 0)
        return "; the first that is there is number " + std::to_string(later.front()) + ": give folder.first";
    std::string missing;
    for (const std::int64_t number : later) {
        if (number > expected) missing += (missing.empty() ? "" : ", ") + std::to_string(expected);
        if (number > expected + 1) missing += " to " + std::to_string(number - 1);
        expected = number + 1;
    }
    return ", though later ones exist up to number " + std::to_string(later.back()) +
           "; missing numbers: " + printable(missing, 120);
}

/// How frame 0 is stored stands for all.
Result<void> ImageFolderReader::read_first() {
    for (const Track& track : tracks_) {
        auto stored = read(track, 0);
        if (!stored) return stored.error();
        const Image& image = stored->image;
        infos_.push_back({std::string(role_name(track.role)), stored->codec, stored->pixel_format,
                          image.width, image.height});
        if (track.role != PlaneRole::depth && (image.width != scene_.width || image.height != scene_.height))
            notes_.push_back(resampling_note(track.role, image.width, image.height, scene_));
        if (auto note = lossy_note(track.role, stored->codec)) notes_.push_back(std::move(*note));
        auto fits = fit_plane(track.role, plane_from(std::move(stored->image), stored->bits), scene_,
                              where(track, 0));
        if (!fits) return fits.error();
        if (track.role != PlaneRole::depth) continue;
        RawFrame frame;
        add_plane(frame, PlaneRole::depth, std::move(*fits));
        if (auto note = no_depth_note(frame, scene_.depth)) notes_.push_back(std::move(*note));
    }
    return {};
}

Result<void> ImageFolderReader::find_far_plane() {
    FarPlaneSearch search(scene_.depth);
    for (std::int64_t frame = 0; frame < count_; ++frame) {
        const auto depth = plane(tracks_.front(), frame);
        if (!depth) return depth.error();
        if (auto added = search.add(depth->view); !added) return added;
    }
    auto note = search.settle(scene_);
    if (!note) return input_error(folder_.string() + ": " + note.error().message);
    notes_.push_back(std::move(*note));
    return {};
}

Result<StoredImage> ImageFolderReader::read(const Track& track, std::int64_t frame) const {
    auto stored = read_stored_image(file(track, frame));
    if (!stored)
        return Error{stored.error().kind, stored.error().message + " (" + std::string(role_name(track.role)) +
                                              ", frame " + std::to_string(frame) + ")"};
    if (!stored->values.empty())
        return input_error(where(track, frame) + ": is a picture of floats: must be of integers");
    if (track.role == PlaneRole::haptic && stored->codec == "mjpeg")
        return input_error(where(track, frame) + ": is JPEG, which mixes materials; haptic is RGB PNG");
    if (track.role != PlaneRole::colour && stored->interlaced)
        return input_error(where(track, frame) + ": is an interlaced PNG: must be a plain one to be touched");
    return stored;
}

Result<Plane> ImageFolderReader::plane(const Track& track, std::int64_t frame) const {
    auto stored = read(track, frame);
    if (!stored) return stored.error();
    const TrackInfo& info = infos_[static_cast<std::size_t>(&track - tracks_.data())];
    const Image& image = stored->image;
    if (image.width != info.width || image.height != info.height || stored->pixel_format != info.pixel_format)
        return input_error(where(track, frame) + ": is " + std::to_string(image.width) + "x" +
                           std::to_string(image.height) + " " + stored->pixel_format + ", but frame 0 is " +
                           std::to_string(info.width) + "x" + std::to_string(info.height) + " " +
                           info.pixel_format);
    return fit_plane(track.role, plane_from(std::move(stored->image), stored->bits), scene_,
                     where(track, frame));
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
                                                      const Scene& scene) {
    if (!scene.folder)
        return input_error(
            folder.string() +
            ": is a folder, but its scene file has no member \"folder\" that says which images to read");
    auto reader = std::make_unique<ImageFolderReader>(folder, scene);
    if (auto opened = reader->open(); !opened) return opened.error();
    return std::unique_ptr<ClipReader>(std::move(reader));
}

}  // namespace touchable
