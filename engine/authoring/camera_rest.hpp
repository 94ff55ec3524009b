#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/authoring/coded_depth.hpp"
#include "engine/clip/cell_picture.hpp"

namespace touchable {

/// Frames in a row through which a camera stood where it did in the first of them.
struct Rest {
    static constexpr std::int64_t least_between_cuts = 4;  ///< frames
    std::int64_t first = 0, count = 0;
    bool begins_with_cut = true;  ///< or with the clip; otherwise the camera had moved
    bool ends_with_cut = true;

    /// Whether it says that the camera stood still: between two cuts soon, elsewhere
    /// after two seconds at 24 Hz, as a slow camera looks still for a while.
    bool is_long_enough() const;
};

/// Tells where a camera rests, frame by frame. It moved where of what is textured most has another brightness
/// than in the first frame of the rest, or of what has depth most has another depth. So things that move are
/// to be the smaller part of the picture.
class CameraRest {
public:
    explicit CameraRest(const CodedDepth& depth) : depth_(depth) {}
    /// The rest that this frame ended, if it did; `current` goes on with this frame, or begins with it.
    bool ends_with(CellPicture picture);
    const Rest& ended() const { return ended_; }
    const Rest& current() const { return current_; }

private:
    /// How many cells changed from one picture to another.
    struct Changes {
        std::size_t known = 0, depth = 0, much_depth = 0;  // with depth in both
        std::size_t all = 0, luma = 0, textured = 0, much_luma = 0;
    };
    Changes changes(const CellPicture& then, const CellPicture& now) const;

    const CodedDepth& depth_;
    CellPicture first_, before_;  // of the rest; where the first one tells nothing of a cell, later ones do
    Rest current_, ended_;
};

}  // namespace touchable
