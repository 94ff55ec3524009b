#include "player/window/playlist.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <system_error>

#include "engine/formats/open_clip.hpp"

namespace touchable {

const ClipChoice* Playlist::next() {
    if (place_ + 1 >= clips_.size() && !(wraps_ && clips_.size() > 1)) return nullptr;
    place_ = (place_ + 1) % clips_.size();
    return &clips_[place_];
}

const ClipChoice* Playlist::previous() {
    if (place_ == 0 && !(wraps_ && clips_.size() > 1)) return nullptr;
    place_ = (place_ + clips_.size() - 1) % clips_.size();
    return &clips_[place_];
}

namespace {

namespace fs = std::filesystem;

/// Of videos and recordings. Pictures are frames of a clip far more often than clips.
constexpr std::array clip_endings{".mkv", ".mp4", ".mov", ".webm", ".m4v", ".avi", ".bag", ".mcap", ".db3"};

bool looks_like_clip(const fs::directory_entry& entry) {
    std::error_code failed;
    if (entry.is_directory(failed)) return fs::exists(entry.path() / "scene.json", failed);
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return std::find(clip_endings.begin(), clip_endings.end(), ending) != clip_endings.end();
}

bool by_name(const fs::path& a, const fs::path& b) {
    const std::string x = a.filename().string(), y = b.filename().string();
    const int order = strverscmp(x.c_str(), y.c_str());
    return order != 0 ? order < 0 : x < y;
}

}  // namespace

std::vector<fs::path> clips_of(const fs::path& named) {
    std::error_code failed;
    if (!fs::is_directory(named, failed)) return {named};
    std::vector<fs::path> clips;
    for (fs::directory_iterator entry(named, failed), end; !failed && entry != end; entry.increment(failed))
        if (entry->path().filename().string().front() != '.' && looks_like_clip(*entry))
            clips.push_back(entry->path());
    // A folder of pictures may have a film beside them.
    if (clips.empty() || fs::exists(named / "scene.json", failed) || guess_clip(named, {}).ok())
        return {named};
    std::sort(clips.begin(), clips.end(), by_name);
    return clips;
}

}  // namespace touchable
