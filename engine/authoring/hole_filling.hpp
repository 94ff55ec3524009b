#pragma once

#include <array>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What the codes of a clip's depth mean where they are compared, by tables.
class CodedDepth {
public:
    explicit CodedDepth(const DepthCoding& coding);
    const DepthCoding& coding() const { return coding_; }
    bool is_valid(std::uint16_t code) const { return tolerance_[code] != 0; }
    /// By how many codes two measurements of one surface may differ: 1/64 of the depth, at least 2; 0 of
    /// codes that are invalid.
    std::int32_t tolerance(std::uint16_t code) const { return tolerance_[code]; }
    /// By how many codes `code` is deeper than `than`.
    std::int32_t deeper_by(std::uint16_t code, std::uint16_t than) const {
        return deeper_is_higher_ ? code - than : than - code;
    }

    /// The depth of a frame as a plane of codes, 1 channel; of hue it is made in `codes`.
    PlaneView codes_of(const RawFrame& frame, std::vector<std::uint16_t>& codes) const;
    /// So that `put` has a pixel for each hue that was seen. `codes`: of that frame.
    void remember(const RawFrame& frame, const PlaneView& codes);
    /// Writes a code that was seen into pixel x, of the row of a depth plane.
    void put(std::uint16_t code, std::uint8_t* row, int x, int bytes_per_sample) const;

private:
    DepthCoding coding_;
    bool deeper_is_higher_;
    std::vector<std::int32_t> tolerance_;              // of each code
    std::vector<std::array<std::uint8_t, 3>> hue_of_;  // of each hue, the first pixel that had it
    std::vector<bool> is_known_;                       // whether a pixel had it
};

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

using Rgb = std::array<std::uint8_t, 3>;
/// Whether both may be the same thing in the same light.
bool agree(const Rgb& a, const Rgb& b);

/// What is behind at a pixel.
struct BackgroundPixel {
    std::uint16_t code = 0;
    bool is_known = false;
    /// Something nearer was there as well, of the same colour: colour does not tell the two apart.
    bool is_ambiguous = false;
    Rgb colour{};  ///< of the frames in which that depth was seen, their mean
};
using Background = std::vector<BackgroundPixel>;

/// Of each pixel that a camera at rest sees the depths that it had, as a few modes: bounded memory, however
/// many frames there are. Whole numbers only; frames in their order.
class BackgroundModel {
public:
    BackgroundModel(const CodedDepth& depth, int width, int height)
        : depth_(depth), width_(width), pixels_(pixel_count(width, height)) {}
    /// `codes` of CodedDepth::codes_of. Colour, where all frames have it, is of the same size; otherwise
    /// empty.
    void add(const PlaneView& codes, const PlaneView& colour, RowBands& bands);
    /// Of each pixel the deepest of its modes that was seen for long: in 1/16 of the frames, and without
    /// colour in a quarter of them, as then a thing that comes by may look like what is behind. And begins
    /// anew.
    Background finish(bool has_colour);
    /// Forgets what it was given.
    void begin();

private:
    struct Mode {
        std::int32_t mean = 0;                  // 1/256 of a code
        std::uint16_t code = 0;                 // the one that was seen nearest to it
        std::uint16_t count = 0;                // at most 65535; 0: there is none
        std::array<std::uint16_t, 3> colour{};  // mean, sixteenths
    };
    using Modes = std::array<Mode, 3>;

    void add_rows(const PlaneView& codes, const PlaneView& colour, const RowBand& band);
    void see(Modes& modes, std::uint16_t code, const std::uint8_t* rgb) const;
    BackgroundPixel behind(const Modes& modes, std::int32_t least, bool has_colour) const;

    const CodedDepth& depth_;
    int width_;
    std::vector<Modes> pixels_;
    std::int32_t frames_ = 0;
};

/// Gives holes of a frame the depth that is behind, where what is seen there is what is behind:
/// - its colour is that which the pixel had with that depth, and so is that of most pixels beside it; where
///   there is no colour or it cannot tell, the hole is narrow in its row or column and has what is behind at
///   an end of that;
/// - and of the depths around such pixels, as far as they touch, no more than four times as many are nearer
///   than what is behind as are what is behind: a hole inside a hand is the hand's;
/// - and, without colour, what is narrow is hardly ever a part of a hole that is not.
class HolesFromMotion {
public:
    explicit HolesFromMotion(const CodedDepth& depth) : depth_(depth) {}
    /// Replaces the frame's depth plane and says in `filled` which pixels; the frame as it was where there
    /// are none.
    void fill(RawFrame& frame, const Background& background, bool uses_colour);
    /// Of all frames so far: whether colour misleads. Where depth says that something nearer is seen, colour
    /// often says that it is what is behind: it does not lie on depth's pixels, or both look alike.
    bool is_misled_by_colour() const;
    /// Of the last frame.
    std::int64_t holes() const { return static_cast<std::int64_t>(holes_.size()); }
    std::int64_t filled() const { return filled_; }

private:
    enum class Place : std::uint8_t {
        other,      // depth that is neither, or is not known
        behind,     // depth of what is behind
        nearer,     // of something before it
        hole,       // which stays one
        candidate,  // hole to be filled, unless what is around says no
        looked_at   // candidate whose surroundings are known
    };
    void find_places(const PlaneView& codes, const PlaneView& colour, const Background& background);
    bool is_coloured_as_behind(const PlaneView& colour, const Background& background,
                               std::size_t pixel) const;
    void find_candidates(const PlaneView& colour, const Background& background);
    bool is_beside_what_is_behind(std::size_t pixel) const;
    bool has_end_behind(std::size_t pixel, std::ptrdiff_t step, int place, int places) const;
    void leave_those_of_nearer_things(bool colour_tells);
    void write(RawFrame& frame, const Background& background);

    const CodedDepth& depth_;
    int width_ = 0, height_ = 0;
    std::vector<Place> places_;
    std::vector<std::size_t> holes_, fills_, group_;
    std::vector<std::uint16_t> hue_codes_;
    std::int64_t filled_ = 0;
    std::int64_t nearer_ = 0, nearer_but_alike_ = 0;  // pixels whose colour can tell
};

}  // namespace touchable
