#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// Pixels of a picture: columns x to x + width - 1, rows likewise.
struct PixelBox {
    int x = 0, y = 0, width = 0, height = 0;
};

/// Which frames and pixels of a clip.
struct ClipPart {
    std::int64_t first = 0;
    std::optional<std::int64_t> last{};  ///< inclusive; nothing: the clip's last
    std::int64_t every = 1;              ///< the first, and then each so many frames later
    std::optional<PixelBox> crop{};

    bool is_whole() const { return first == 0 && !last && every == 1 && !crop; }
};

/// A reader of a part of a clip, as a clip: its frames are numbered from 0, at the rate that is left of the
/// clip's; where it is cropped the camera's principal point moves, so that every pixel that is left stays
/// where it was in the world. Refused (ErrorKind::usage) where the clip has no such frame or pixel.
Result<std::unique_ptr<ClipReader>> part_of_clip(std::unique_ptr<ClipReader> clip, const ClipPart& part);

}  // namespace touchable
