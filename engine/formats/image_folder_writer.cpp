#include "engine/formats/image_folder_writer.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/hidden_folder.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/scene/scene_file.hpp"

namespace touchable {
namespace fs = std::filesystem;
namespace {

constexpr const char* scene_name = "scene.json";
constexpr const char* times_list = "depth.txt";
constexpr const char* poses_list = "poses.txt";
constexpr std::int64_t ns_a_second = 1'000'000'000;

Error unwritable(const fs::path& place, const std::error_code& why) {
    return input_error(place.string() + ": cannot be written: " + why.message());
}

std::string numbered(PlaneRole role, std::int64_t frame) {
    return std::string(role_name(role)) + formatted("_%06lld.png", static_cast<long long>(frame));
}

/// "NAME_colour.png", beside a file NAME of whatever kind.
std::string beside(const fs::path& file, PlaneRole role) {
    return file.stem().string() + "_" + std::string(role_name(role)) + ".png";
}

Result<void> write_text(const fs::path& path, const std::string& text, const fs::path& name) {
    std::ofstream out(path, std::ios::binary);
    out << text;
    out.close();
    return out ? Result<void>{} : input_error(name.string() + ": cannot be written");
}

/// What both kinds have in common: frames come in order, into a hidden folder, and are whole or nothing.
class PictureWriter : public ClipWriter {
public:
    PictureWriter(const fs::path& place, const SceneDescription& described)
        : place_(place),
          scene_(described.scene),
          unstated_(described.unstated),
          hidden_(place.parent_path()) {}
    Result<void> open() const {
        return hidden_.failure() ? unwritable(place_, hidden_.failure()) : Result<void>{};
    }

    Result<void> write(const RawFrame& frame) override {
        if (complete_ || frame.number != frames_ || frame.depth.empty())
            return Error{ErrorKind::internal, place_.string() + ": frame " + std::to_string(frames_) +
                                                  " with depth was due, " + std::to_string(frame.number) +
                                                  " was given"};
        if (auto written = write_frame(frame); !written) return written;
        ++frames_;
        return {};
    }

    Result<fs::path> complete() override {
        if (frames_ == 0) return input_error(place_.string() + ": not written: no frame was given");
        TRY(end());
        hidden_.sync();
        complete_ = true;
        return hidden_.path() / opens_by();
    }

    Result<void> finish() override {
        if (!complete_) TRY(complete());
        auto named = name_it();
        if (named.ok()) hidden_.remove();
        return named;
    }

protected:
    virtual Result<void> write_frame(const RawFrame& frame) = 0;
    /// The scene file, last.
    virtual Result<void> end() = 0;
    virtual fs::path opens_by() const = 0;
    virtual Result<void> name_it() = 0;
    /// The folder that the files will be in.
    virtual fs::path home() const = 0;

    Result<void> write_picture(PlaneRole role, const std::string& name, const PlaneView& plane) const {
        return write_png_to(hidden_.path() / name, plane, home() / name, PngEffort::quick, png_colours(role));
    }
    /// What describes the pictures that are here, without their names.
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
    Unstated unstated_;
    HiddenFolder hidden_;
    std::int64_t frames_ = 0;
    bool complete_ = false;
};

class FolderWriter final : public PictureWriter {
public:
    FolderWriter(const fs::path& place, const SceneDescription& described, Existing existing)
        : PictureWriter(place, described), existing_(existing) {}

private:
    Result<void> write_frame(const RawFrame& frame) override {
        if (frames_ == 0) first_ = kept_frame(frame);
        for (const PlaneRole role : all_roles) {
            const PlaneView& plane = plane_of(frame, role);
            if (plane.empty() != plane_of(first_, role).empty())
                return Error{ErrorKind::internal, place_.string() + ": frame " + std::to_string(frames_) +
                                                      " has other planes than the first"};
            if (plane.empty()) continue;
            if (auto written = write_plane(role, plane); !written) return written;
        }
        return {};
    }

    /// Of a plane that has not changed so far nothing is written.
    Result<void> write_plane(PlaneRole role, const PlaneView& plane) {
        bool& changes = changes_[static_cast<std::size_t>(role)];
        if (role != PlaneRole::depth && !changes) {
            const PlaneView& first = plane_of(first_, role);
            if (same_samples(first, plane)) return {};
            for (std::int64_t frame = 0; frame < frames_; ++frame) {
                if (stop_requested()) return Error{ErrorKind::interrupted, "interrupted"};
                if (auto written = write_picture(role, numbered(role, frame), first); !written)
                    return written;
            }
            changes = true;
        }
        return write_picture(role, numbered(role, frames_), plane);
    }

    Result<void> end() override {
        SceneDescription described = described_pictures();
        Scene& scene = described.scene;
        scene.folder->count = static_cast<int>(frames_);
        for (const PlaneRole role : all_roles) {
            const PlaneView& plane = plane_of(first_, role);
            if (plane.empty()) continue;
            const std::string name(role_name(role));
            const bool is_still = role != PlaneRole::depth && !changes_[static_cast<std::size_t>(role)];
            pattern_of(*scene.folder, role) = name + (is_still ? ".png" : "_%06d.png");
            if (!is_still) continue;
            if (auto written = write_picture(role, name + ".png", plane); !written) return written;
        }
        if (scene.rate.own_times) {
            scene.folder->depth = times_list;
            scene.folder->count = 0;  // as long as the list
            if (auto written = write_times(); !written) return written;
        }
        if (scene_.path)
            if (auto written = write_text(hidden_.path() / poses_list,
                                          timed_poses_text(*scene_.path, scene_.rate, scene_.metres_per_unit),
                                          place_ / poses_list);
                !written)
                return written;
        return write_text(hidden_.path() / scene_name, scene_to_json(described), place_ / scene_name);
    }

    /// Seconds and name of each picture of depth, as TUM's recordings have them.
    Result<void> write_times() const {
        std::ofstream out(hidden_.path() / times_list, std::ios::binary);
        for (std::int64_t frame = 0; frame < frames_; ++frame) {
            const std::int64_t ns = scene_.rate.time_ns(frame);
            out << formatted("%lld.%09lld ", static_cast<long long>(ns / ns_a_second),
                             static_cast<long long>(ns % ns_a_second))
                << numbered(PlaneRole::depth, frame) << '\n';
        }
        out.close();
        return out ? Result<void>{} : input_error((place_ / times_list).string() + ": cannot be written");
    }

    fs::path opens_by() const override { return {}; }
    fs::path home() const override { return place_; }

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
        sync_folder(place_.parent_path());
        return {};
    }

    /// At once where the file system can exchange two names; what was there goes with the hidden folder.
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

    Existing existing_;
    RawFrame first_;
    std::array<bool, all_roles.size()> changes_{};
};

class StillWriter final : public PictureWriter {
public:
    /// `depth`, `text`: names of its picture of depth, and of what describes all.
    struct Form {
        std::string depth, text;
        DescribeStill describe;
    };
    StillWriter(const fs::path& place, const SceneDescription& described, Existing existing, Form form)
        : PictureWriter(place, described), existing_(existing), form_(std::move(form)) {}

private:
    Result<void> write_frame(const RawFrame& frame) override {
        if (frames_ > 0) return Error{ErrorKind::internal, place_.string() + ": is of one frame"};
        SceneDescription described = described_pictures();
        Scene& scene = described.scene;
        for (const PlaneRole role : all_roles) {
            const PlaneView& plane = plane_of(frame, role);
            if (plane.empty()) continue;
            names_.push_back(role == PlaneRole::depth ? form_.depth : beside(place_, role));
            pattern_of(*scene.folder, role) = names_.back();
            if (auto written = write_picture(role, names_.back(), plane); !written) return written;
        }
        names_.push_back(form_.text);
        return write_text(hidden_.path() / form_.text, form_.describe(described), home() / form_.text);
    }
    Result<void> end() override { return {}; }
    fs::path opens_by() const override { return form_.text; }
    fs::path home() const override { return place_.parent_path(); }

    Result<void> name_it() override { return hidden_.move_to(place_.parent_path(), names_, existing_); }

    Existing existing_;
    Form form_;
    std::vector<std::string> names_;  // of its files, in the order in which they appear
};

/// The name with all links followed, so that what is replaced is what they lead to.
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
    if (auto valid = validate(pictures); !valid)
        return input_error(place.string() + ": " + valid.error().message);
    return {};
}

/// % and * stand for numbers in the names that a scene file has of pictures.
Result<void> check_name(const fs::path& still) {
    const std::string stem = still.stem().string();
    if (is_still(stem + ".png")) return {};
    return usage_error(still.string() + ": has a % or * in its name, which stand for numbers");
}

template <class Writer, class... More>
Result<std::unique_ptr<ClipWriter>> opened(const fs::path& path, const SceneDescription& described,
                                           Existing existing, More... more) {
    const fs::path place = whole_name(path);
    TRY(check_place(place, described));
    auto writer = std::make_unique<Writer>(place, described, existing, std::move(more)...);
    TRY(writer->open());
    return std::unique_ptr<ClipWriter>(std::move(writer));
}

/// Of a plane's pictures ("depth_000000.png", or "haptic.png") or what describes them.
bool is_picture_name(const std::string& name) {
    if (name == scene_name || name == times_list || name == poses_list) return true;
    return std::any_of(all_roles.begin(), all_roles.end(), [&](PlaneRole role) {
        const std::string begin(role_name(role)), end = ".png";
        if (!name.starts_with(begin) || !name.ends_with(end)) return false;
        const std::string between = name.substr(begin.size(), name.size() - begin.size() - end.size());
        if (between.empty()) return true;
        return between.size() >= 7 && between[0] == '_' &&
               std::all_of(between.begin() + 1, between.end(), [](char c) { return c >= '0' && c <= '9'; });
    });
}

}  // namespace

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
    return opened<FolderWriter>(folder, described, existing);
}

Result<std::unique_ptr<ClipWriter>> create_still(const fs::path& picture, const SceneDescription& described,
                                                 Existing existing) {
    TRY(check_name(picture));
    const StillWriter::Form form{picture.filename().string(), picture.stem().string() + ".json",
                                 scene_to_json};
    return opened<StillWriter>(picture, described, existing, form);
}

Result<std::unique_ptr<ClipWriter>> create_described_still(const fs::path& text,
                                                           const SceneDescription& described,
                                                           Existing existing, DescribeStill describe) {
    TRY(check_name(text));
    const StillWriter::Form form{beside(text, PlaneRole::depth), text.filename().string(),
                                 std::move(describe)};
    return opened<StillWriter>(text, described, existing, form);
}

std::vector<fs::path> still_files(const fs::path& picture) {
    const fs::path folder = picture.parent_path();
    const std::string stem = picture.stem().string();
    std::vector<fs::path> files{picture, folder / (stem + ".json")};
    for (const PlaneRole role : {PlaneRole::colour, PlaneRole::haptic, PlaneRole::height})
        files.push_back(folder / beside(picture, role));
    return files;
}

std::vector<fs::path> described_still_files(const fs::path& text) {
    std::vector<fs::path> files{text};
    for (const PlaneRole role : all_roles) files.push_back(text.parent_path() / beside(text, role));
    return files;
}

}  // namespace touchable
