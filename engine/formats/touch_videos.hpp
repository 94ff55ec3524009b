#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/clip/clip_reader.hpp"
#include "engine/formats/linked_file.hpp"

namespace touchable {

/// Where one property of touch is: a channel of a video, or of a picture that serves all frames.
struct TouchSource {
    std::filesystem::path video{};         ///< empty: `picture`
    std::optional<std::uint32_t> track{};  ///< its number in that file; nothing: the file's first of pictures
    LinkedFile picture{};
    int channel = 0;  ///< red, green or blue
};
/// Stiffness, static and dynamic friction (property_names); nothing: the same everywhere.
using TouchSources = std::array<std::optional<TouchSource>, 3>;

/// The clip with a haptic plane of these under every frame, in place of its own: of each video the picture of
/// the frame's number, or where it has not as many frames the one that is nearest in time. The clip's scene
/// says what black and white are.
Result<std::unique_ptr<ClipReader>> with_touch_videos(Result<std::unique_ptr<ClipReader>> clip,
                                                      const TouchSources& sources);

}  // namespace touchable
