// SPDX-License-Identifier: Apache-2.0
#include "engine/formats/colour_video.hpp"

#include <algorithm>

#include "engine/base/threads.hpp"
#include "engine/base/words.hpp"
#include "engine/formats/picture_files.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_files_beside = 100'000;  // looked at in a folder
constexpr const char* video_extensions[] = {".mp4", ".mov", ".mkv", ".webm", ".avi", ".m4v"};
constexpr const char* depth_words[] = {"depths", "depth", "disparity", "disp", "vis"};
constexpr const char* colour_words[] = {"src", "rgb", "color", "colour", "image", "video"};

bool is_letter(char c) {
    return c >= 'a' && c <= 'z';
}

/// A name in small letters without this word and the separator beside it; nothing if the name does not have
/// the word: "walk_depth_1" without "depth" is "walk_1".
std::optional<std::string> without_word(const std::string& name, const std::string& word) {
    for (auto at = name.find(word); at != std::string::npos; at = name.find(word, at + 1)) {
        const std::size_t end = at + word.size();
        if ((at > 0 && is_letter(name[at - 1])) || (end < name.size() && is_letter(name[end]))) continue;
        const auto is_separator = [&](std::size_t k) {
            return k < name.size() && std::string_view("_- .").find(name[k]) != std::string_view::npos;
        };
        if (at > 0 && is_separator(at - 1)) return name.substr(0, at - 1) + name.substr(end);
        return name.substr(0, at) + name.substr(is_separator(end) ? end + 1 : end);
    }
    return {};
}

template <class Words>
std::optional<std::string> without_any(const std::string& name, const Words& words) {
    for (const char* word : words)
        if (auto rest = without_word(name, word)) return rest;
    return {};
}

std::string small_stem(const fs::path& file) {
    return small_letters(file.stem().string());
}

}  // namespace

bool is_named_as_video(const fs::path& file) {
    return std::ranges::count(video_extensions, small_letters(file.extension().string())) > 0;
}

bool is_named_as_depth_video(const fs::path& file) {
    return is_named_as_video(file) && without_any(small_stem(file), depth_words);
}

std::vector<fs::path> video_files_in(const fs::path& folder) {
    std::vector<fs::path> videos;
    std::error_code ignored;
    std::size_t entries = 0;
    for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, ignored)) {
        if (++entries > most_files_beside) break;
        const fs::path name = entry.path().filename();
        if (!name.string().starts_with(".") && is_named_as_video(name) && is_file(entry.path()))
            videos.push_back(folder / name);
    }
    std::ranges::sort(videos);
    return videos;
}

std::optional<ColourVideo> colour_video_beside(const fs::path& depth) {
    const auto rest = without_any(small_stem(depth), depth_words);
    if (!rest) return {};
    /// Smaller is better: the order of the words for colour, and depth's own extension.
    const auto rank = [&](const fs::path& video) -> std::optional<std::size_t> {
        const std::string stem = small_stem(video);
        const auto is_rest = [&](const char* word) { return without_word(stem, word) == *rest; };
        const auto n =
            static_cast<std::size_t>(std::ranges::find_if(colour_words, is_rest) - std::begin(colour_words));
        if (n == std::size(colour_words) && (rest->empty() || stem != *rest)) return {};
        return 2 * n + (video.extension() == depth.extension() ? 0 : 1);
    };
    std::vector<std::pair<std::size_t, fs::path>> found;
    for (const fs::path& video : video_files_in(depth.parent_path()))
        if (const auto ranked = rank(video); ranked && video.filename() != depth.filename())
            found.emplace_back(*ranked, video);
    std::ranges::sort(found);
    for (const auto& [ranked, video] : found) {
        if (stop_requested()) return {};
        if (auto opened = VideoFile::open(video, PlaneRole::colour))
            return ColourVideo{video.filename().string(), std::move(*opened)};
    }
    return {};
}

std::optional<ColourVideo> colour_video_in(const fs::path& folder, std::int64_t frames) {
    std::vector<fs::path> named, unnamed;
    for (const fs::path& video : video_files_in(folder)) {
        const std::string stem = small_stem(video);
        if (without_any(stem, depth_words)) continue;
        (without_any(stem, colour_words) ? named : unnamed).push_back(video);
    }
    const bool is_named = !named.empty();
    if (!is_named && unnamed.size() != 1) return {};
    for (const fs::path& video : is_named ? named : unnamed) {
        if (stop_requested()) return {};
        auto opened = VideoFile::open(video, PlaneRole::colour);
        if (!opened || (!is_named && (*opened)->count() != frames)) continue;
        ColourVideo found{video.filename().string(), std::move(*opened)};
        for (const fs::path& other : named)
            if (other != video) found.others.push_back(other.filename().string());
        return found;
    }
    return {};
}

}  // namespace touchable
