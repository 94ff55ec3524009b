#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "player/session/clip_choice.hpp"

namespace touchable {

/// The clips of a window, and the place of one among them: the one that is shown, or on its way there.
class Playlist {
public:
    Playlist() = default;
    /// Begins with the first of `clips`. `wraps`: after the last comes the first.
    explicit Playlist(std::vector<ClipChoice> clips, bool wraps = false)
        : clips_(std::move(clips)), wraps_(wraps) {}

    std::size_t size() const { return clips_.size(); }
    std::size_t place() const { return place_; }              ///< of the clip, from 0
    const ClipChoice& now() const { return clips_[place_]; }  ///< of a list that is not empty
    /// Goes one on or back; null where nothing is there: then it stays.
    const ClipChoice* next();
    const ClipChoice* previous();
    const ClipChoice* go(int by) { return by > 0 ? next() : previous(); }
    /// To that place, which is there.
    void go_to(std::size_t place) { place_ = place; }

private:
    std::vector<ClipChoice> clips_;
    std::size_t place_ = 0;
    bool wraps_ = false;
};

/// What a person names, as clips: a folder that is no clip itself is the clips that lie in it (videos,
/// recordings, folders with a scene file), by name, with numbers in their order: "clip2" before "clip10".
/// Anything else, and a folder without any, is itself.
std::vector<std::filesystem::path> clips_of(const std::filesystem::path& named);

}  // namespace touchable
