#include "engine/formats/picture_groups.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/formats/picture_files.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_entries = 1'000'000;
constexpr const char* extensions[] = {".png",  ".jpg", ".jpeg", ".pgm", ".ppm", ".tif",
                                      ".tiff", ".pfm", ".exr",  ".npy", ".npz"};

constexpr const char* video_extensions[] = {".mkv", ".webm", ".mp4",  ".m4v", ".mov",
                                            ".avi", ".bag",  ".mcap", ".db3", ".r3d"};

std::string small_letters(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

template <std::size_t n>
bool has_extension(const fs::path& file, const char* const (&known)[n]) {
    const std::string extension = small_letters(file.extension().string());
    return std::find(std::begin(known), std::end(known), extension) != std::end(known);
}

bool is_picture(const fs::path& file) {
    return has_extension(file, extensions);
}

bool is_camera_of_frame(const fs::path& file) {
    return file.extension() == ".pincam";
}

constexpr const char* list_names[] = {"rgb.txt", "color.txt", "colour.txt", "depth.txt"};

/// A name with a star for its last number: a run of digits, or two with a point between them.
std::string starred(const std::string& name) {
    const auto is_digit = [&](std::size_t k) { return k < name.size() && name[k] >= '0' && name[k] <= '9'; };
    std::size_t end = name.rfind('.');  // before the extension
    if (end == std::string::npos) return name;
    while (end > 0 && !is_digit(end - 1)) --end;
    if (end == 0) return name;
    std::size_t begin = end;
    while (begin > 0 && is_digit(begin - 1)) --begin;
    if (begin > 1 && name[begin - 1] == '.' && is_digit(begin - 2)) {
        --begin;
        while (begin > 0 && is_digit(begin - 1)) --begin;
    }
    return name.substr(0, begin) + "*" + name.substr(end);
}

using Wanted = bool (*)(const fs::path&);

void add_files(const fs::path& folder, const std::string& within, Wanted is_wanted,
               std::map<std::string, PictureGroup>& groups, std::size_t& entries) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder / within, ignored)) {
        if (++entries > most_entries) return;
        const std::string name = entry.path().filename().string();
        std::error_code failure;
        if (name.starts_with(".") || name.find_first_of("%*") != std::string::npos || !is_wanted(name) ||
            !entry.is_regular_file(failure))
            continue;
        PictureGroup& group = groups[within + starred(name)];
        if (group.count++ == 0 || entry.path() < group.first) group.first = entry.path();
    }
}

/// Of the folder itself and of those in it, largest first.
std::vector<PictureGroup> groups_of(const fs::path& folder, Wanted is_wanted) {
    std::map<std::string, PictureGroup> found;
    std::size_t entries = 0;
    add_files(folder, "", is_wanted, found, entries);
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (entry.is_directory(ignored))
            add_files(folder, entry.path().filename().string() + "/", is_wanted, found, entries);
    std::vector<PictureGroup> groups;
    for (auto& [pattern, group] : found) {
        group.pattern = group.count > 1 ? pattern : group.first.lexically_relative(folder).string();
        groups.push_back(std::move(group));
    }
    std::stable_sort(groups.begin(), groups.end(),
                     [](const PictureGroup& a, const PictureGroup& b) { return a.count > b.count; });
    return groups;
}

/// Folders above those with pictures, as each is looked into one level down.
std::set<fs::path> folders_further_down(const fs::path& folder) {
    constexpr int deepest = 5;
    constexpr std::size_t most_looked_at = 100'000, most_folders = 100;
    std::set<fs::path> found;
    std::size_t entries = 0;
    std::error_code failure;
    for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, failure),
         end;
         !failure && at != end && ++entries < most_looked_at && found.size() < most_folders;
         at.increment(failure)) {
        if (at.depth() >= deepest) at.disable_recursion_pending();
        std::error_code ignored;
        if (at.depth() > 1 && is_picture(at->path()) && at->is_regular_file(ignored))
            found.insert(at->path().parent_path().parent_path());
    }
    return found;
}

}  // namespace

std::string folder_of(const PictureGroup& group) {
    const fs::path within = fs::path(group.pattern).parent_path();
    return within.empty() ? "" : within.string() + '/';
}

std::string found_elsewhere(const fs::path& folder) {
    std::set<fs::path> videos;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (has_extension(entry.path(), video_extensions)) videos.insert(entry.path());
    if (!videos.empty())
        return std::string("but ") + (videos.size() == 1 ? "a video" : "videos") + ": touchable play " +
               shell_word(videos.begin()->string());
    const std::set<fs::path> folders = folders_further_down(folder);
    if (folders.empty()) return "";
    return std::string("but further down than it is looked: touchable play ") +
           shell_word(folders.begin()->string()) +
           (folders.size() > 1 ? " (one of " + std::to_string(folders.size()) + " such folders)" : "");
}

bool has_word(const std::string& name, std::initializer_list<const char*> words) {
    const std::string small = small_letters(name);
    return std::any_of(words.begin(), words.end(),
                       [&](const char* word) { return small.find(word) != std::string::npos; });
}

std::vector<std::string> unusable_lists(const fs::path& folder) {
    std::vector<std::string> remarks;
    std::error_code ignored;
    for (const char* list : list_names)
        if (fs::is_regular_file(folder / list, ignored))
            if (const auto listed = found_files(folder, list); !listed.ok())
                remarks.push_back(std::string(list) + " is not used: " + listed.error().message);
    return remarks;
}

std::vector<PictureGroup> picture_groups(const fs::path& folder) {
    std::vector<PictureGroup> groups = groups_of(folder, is_picture);
    std::error_code ignored;
    // TUM's lists pair pictures by their times.
    for (const char* list : list_names)
        if (fs::is_regular_file(folder / list, ignored))
            if (const auto listed = found_files(folder, list);
                listed.ok() && is_picture(listed->files.front()))
                groups.insert(groups.begin(), {list, listed->files.front(), listed->count()});
    return groups;
}

std::vector<PictureGroup> camera_groups(const fs::path& folder) {
    return groups_of(folder, is_camera_of_frame);
}

}  // namespace touchable
