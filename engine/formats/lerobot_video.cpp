#include "engine/formats/lerobot_video.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/camera_file.hpp"
#include "engine/formats/lerobot_writer.hpp"
#include "engine/scene/checked_json.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;
using checked_json::Json;

/// A member of `info`, or of `video_info` as older data sets call it, with or without "video." before its
/// name.
const Json* member_of(const Json& feature, const std::string& name) {
    for (const char* in : {"info", "video_info"}) {
        const auto info = feature.find(in);
        if (info == feature.end() || !info->is_object()) continue;
        for (const std::string& each : {"video." + name, name})
            if (const auto found = info->find(each); found != info->end()) return &*found;
    }
    return nullptr;
}

bool is_depth(const Json& feature) {
    const Json* const said = member_of(feature, "is_depth_map");
    return said != nullptr && *said == true;
}

/// The members of "features" that are videos, by name.
using Videos = std::vector<std::pair<std::string, Json>>;
Videos videos_in(const Json& json) {
    Videos videos;
    const auto features = json.find("features");
    if (features == json.end() || !features->is_object()) return videos;
    for (const auto& [name, feature] : features->items())
        if (feature.is_object() && (feature.contains("info") || feature.contains("video_info")))
            videos.emplace_back(name, feature);
    return videos;
}

Result<double> number_of(const Json& feature, const char* name, double usual, const std::string& where) {
    const Json* const said = member_of(feature, name);
    if (said == nullptr) return usual;
    if (said->is_number() && std::isfinite(said->get<double>())) return said->get<double>();
    return input_error(where + ": video." + name + " is " + printable(said->dump(), 40) +
                       ": must be a number of metres");
}

Result<DepthCoding> coding_of(const Json& feature, const std::string& where) {
    const DepthCoding usual = lerobot_coding();
    const auto near = number_of(feature, "depth_min", usual.near, where);
    const auto far = number_of(feature, "depth_max", usual.far, where);
    const auto shift = number_of(feature, "shift", usual.shift, where);
    for (const auto* each : {&near, &far, &shift})
        if (!*each) return each->error();
    const Json* const use_log = member_of(feature, "use_log");
    const bool is_log = use_log == nullptr || *use_log != false;
    if (!(*near >= 0 && *near < *far && *far < lerobot_horizon) || (is_log && !(*near + *shift > 0)))
        return input_error(where +
                           ": its depth_min, depth_max and shift are no range of depth: must be 0 <= "
                           "depth_min < depth_max < " +
                           short_number(lerobot_horizon) +
                           (is_log ? ", and depth_min + shift more than 0" : ""));
    return is_log ? lerobot_coding(*near, *far, *shift) : lerobot_linear_coding(*near, *far);
}

/// Where the description of a video may be, the nearest first.
std::vector<fs::path> descriptions_of(const fs::path& video) {
    std::vector<fs::path> files{lerobot_info_file(video)};
    std::error_code failure;
    fs::path folder = fs::absolute(video, failure).lexically_normal().parent_path();
    constexpr int folders_of_data_set = 4;  // videos/KEY/chunk-000, and the data set's own
    for (int up = 0; up < folders_of_data_set && !failure; ++up, folder = folder.parent_path())
        files.push_back(folder / "meta" / "info.json");
    return files;
}

bool is_in_path(const fs::path& video, const std::string& name) {
    std::error_code ignored;
    const fs::path whole = fs::absolute(video, ignored);
    return std::find(whole.begin(), whole.end(), name) != whole.end();
}

/// "observation.images.wrist" of "observation.images.wrist_depth".
std::string without_depth(std::string name) {
    for (const char* word : {"_depth", "depth_", ".depth", "depth."})
        if (const auto at = name.find(word); at != std::string::npos)
            name.erase(at, std::string_view(word).size());
    return name;
}

/// The video of colour that lies in the data set as this one of depth does: of the same name, or the only
/// one.
fs::path colour_of(const fs::path& video, const std::string& depth, const Videos& videos) {
    std::vector<std::string> names;
    for (const auto& [name, feature] : videos)
        if (!is_depth(feature)) names.push_back(name);
    const auto same = std::find(names.begin(), names.end(), without_depth(depth));
    if (same != names.end()) names = {*same};
    if (names.size() != 1) return {};
    std::error_code ignored;
    const fs::path own = fs::absolute(video, ignored).lexically_normal();
    fs::path other;
    for (const fs::path& part : own) other /= part == depth ? fs::path(names.front()) : part;
    if (other == own || !fs::is_regular_file(other, ignored)) return {};
    return other.lexically_relative(own.parent_path());
}

bool is_as_lerobot_encodes(const std::string& codec, const std::string& pixel_format) {
    return codec == "hevc" && pixel_format == "gray12le";
}

/// The videos that a description speaks of; none where it is of something else.
Result<Videos> read_videos(const fs::path& file) {
    constexpr std::size_t largest = std::size_t{16} << 20;
    TRY_ASSIGN(auto text, read_given_file(file, file.string(), "a LeRobot data set's description", largest));
    try {
        return videos_in(checked_json::parse(text, largest));
    } catch (const checked_json::Refusal& refusal) {
        return input_error(file.string() + ": " + refusal.message);
    }
}

/// What a description says of this video; nothing where it speaks of others. `is_usual`: it may be the only
/// one of depth, wherever it lies.
Result<std::optional<LeRobotDepth>> read_description(const fs::path& file, const fs::path& video,
                                                     bool is_usual) {
    TRY_ASSIGN(const auto read, read_videos(file));
    const Videos& videos = read;
    const auto find = [&](auto is_it) { return std::find_if(videos.begin(), videos.end(), is_it); };
    auto found = find([&](const auto& each) { return is_in_path(video, each.first); });
    const bool is_only = std::count_if(videos.begin(), videos.end(),
                                       [](const auto& each) { return is_depth(each.second); }) == 1;
    if (found == videos.end() && is_only && is_usual)
        found = find([](const auto& each) { return is_depth(each.second); });
    if (found == videos.end() || !is_depth(found->second)) return std::optional<LeRobotDepth>{};
    TRY_ASSIGN(const auto coding, coding_of(found->second, file.string() + ": " + printable(found->first)));
    return std::optional(LeRobotDepth{coding, file, colour_of(video, found->first, videos),
                                      intrinsics_in_json(found->second.dump())});
}

}  // namespace

Result<std::optional<LeRobotDepth>> find_lerobot_depth(const SourceFile& video, const std::string& codec,
                                                       const std::string& pixel_format) {
    const bool is_usual = is_as_lerobot_encodes(codec, pixel_format);
    std::error_code ignored;
    for (const fs::path& file : descriptions_of(video.path())) {
        if (!fs::is_regular_file(file, ignored)) continue;
        const bool is_its_own = file.filename() != "info.json";
        auto found = read_description(file, video.path(), is_usual || is_its_own);
        // Other programs have files of this name, which say nothing of a video that cannot be LeRobot's
        // depth.
        if (!found && !is_usual) continue;
        if (!found) return found.error();
        if (!*found) continue;
        if (is_usual) return found;
        return input_error(
            video.string() + ": is " + codec + " of pixel format " + pixel_format + ", but " + file.string() +
            " says that it is LeRobot's depth, which is hevc of gray12le: it was encoded anew, "
            "and its depths are lost; take the data set's own file");
    }
    if (!is_usual) return std::optional<LeRobotDepth>{};
    return std::optional(LeRobotDepth{lerobot_coding()});
}

Result<std::vector<fs::path>> lerobot_depth_videos(const fs::path& folder) {
    std::error_code ignored;
    const fs::path info = folder / "meta" / "info.json";
    std::vector<fs::path> found;
    if (!fs::is_regular_file(info, ignored)) return found;
    TRY_ASSIGN(const auto videos, read_videos(info));
    const bool has_depth =
        std::any_of(videos.begin(), videos.end(), [](const auto& each) { return is_depth(each.second); });
    constexpr std::size_t most_entries = 100'000;
    std::size_t entries = 0;
    if (has_depth)
        for (auto each = fs::recursive_directory_iterator(folder / "videos", ignored);
             !ignored && each != fs::end(each) && entries < most_entries; each.increment(ignored), ++entries)
            if (each->path().extension() == ".mp4" &&
                std::any_of(videos.begin(), videos.end(), [&](const auto& video) {
                    return is_depth(video.second) && is_in_path(each->path(), video.first);
                }))
                found.push_back(each->path());
    std::sort(found.begin(), found.end());
    return found;
}

}  // namespace touchable
