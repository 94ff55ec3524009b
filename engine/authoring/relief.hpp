#pragma once

// Relief that is felt, made of a recording's colour (docs/content.md).
//
// A clip with heights is made around one without: details of brightness between two widths (difference of
// Gaussians) are taken for bumps. Some frames of the clip tell how strong they are (ReliefEstimator), and
// heights stay steady through time (ReliefHeights).
//
// A reader is one thread's; a stop is heard between frames.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A picture of whole numbers, row by row.
struct NumberField {
    int width = 0, height = 0;
    std::vector<std::int32_t> numbers;

    NumberField() = default;
    NumberField(int columns, int rows)
        : width(columns),
          height(rows),
          numbers(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}
    std::int32_t* row(int y) {
        return numbers.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
    const std::int32_t* row(int y) const {
        return numbers.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
};

/// Where surfaces end: of each pixel the first and the last column, and the first and the last row, of the
/// run of pixels around it that belong together.
struct SurfaceRuns {
    struct Run {
        std::int16_t first, last;
    };
    SurfaceRuns() = default;
    /// All pixels belong together.
    SurfaceRuns(int width, int height);

    int width = 0, height = 0;
    std::vector<Run> across, down;
};

/// Sum over a square of `side` (odd) pixels around each, as far as they are of its surface, over that many
/// pixels; in place. Along rows first, then along columns, each rounded to the nearest, halves up. Numbers
/// are 0 to 2^24, sides at most 127.
class BoxFilter {
public:
    void apply(NumberField& field, int side, const SurfaceRuns& runs);

private:
    std::vector<std::uint32_t> row_sums_,
        column_sums_;  // of all before; they may wrap, their differences do not
};

/// Details of a picture by their size: what a Gaussian blur leaves less what a wider one leaves. This is the
/// Laplacian of Gaussian that the paper takes for roughness (section 3.1.2), at three widths. Pixels have
/// weights, and surfaces end: neither what counts for nothing nor another surface blurs into what is beside
/// it (normalised convolution).
class DifferenceOfGaussians {
public:
    static constexpr int bands = 3;
    /// Standard deviations of the blurs between which the bands lie, in pixels. A Gaussian is boxes, one
    /// after the other: sides of squares.
    static constexpr std::array<double, bands + 1> sigma{0.82, 1.83, 4.47, 10.39};

    static constexpr std::int32_t most_weight = 4096, most_value = 4096;

    /// `values` 0 to most_value, `weights` 0 to most_weight, all of one size.
    void split(const NumberField& values, const NumberField& weights, const SurfaceRuns& runs);
    /// Band k of the last picture, from fine to coarse: 0 where nothing near counts.
    const NumberField& band(int k) const { return bands_[static_cast<std::size_t>(k)]; }
    /// How much what is around each pixel counts, 0 to most_weight: weights after the second blur.
    const NumberField& confidence() const { return confidence_; }

private:
    void blur(std::size_t step, const SurfaceRuns& runs);

    BoxFilter box_;
    NumberField weighted_, weights_, mean_, wider_, confidence_;
    std::array<NumberField, bands> bands_;
};

/// What of a picture's details becomes relief.
struct ReliefSettings {
    std::array<int, DifferenceOfGaussians::bands> bands{
        100, 70, 40};     ///< per cent of fine, medium, coarse; -400 to 400
    int amount = 100;     ///< per cent of the largest height, 0 to 400
    bool invert = false;  ///< dark stands out, not bright
    bool operator==(const ReliefSettings&) const = default;
};

/// The relief that the colour of a frame suggests, before it is scaled: what is brighter than around it
/// stands out. There is none across a step of depth, where depth is missing, in deep shadow and in
/// highlights.
class ReliefFilter {
public:
    ReliefFilter(const ReliefSettings& settings, const DepthCoding& depth)
        : settings_(settings), depth_(depth) {}

    /// `frame` has colour. Numbers are sixteenths of a level of brightness; about -4096 to 4096 for bands of
    /// 100 %.
    const NumberField& apply(const RawFrame& frame);
    /// Of each pixel of the last frame, how much its relief counts: 0 to DifferenceOfGaussians::most_weight.
    const NumberField& confidence() const { return split_.confidence(); }

private:
    void read_luma(const PlaneView& colour);
    void part_surfaces(const RawFrame& frame);

    const ReliefSettings settings_;
    const DepthCoding depth_;
    DifferenceOfGaussians split_;
    NumberField luma_, weights_, relief_;
    SurfaceRuns runs_;
};

/// What a clip's relief is like, in the numbers of ReliefFilter.
struct ReliefRange {
    std::int32_t full =
        1;  ///< 99 % of what counts is no higher and no deeper: this becomes the largest height
    /// Standard deviation from frame to frame of what does not move. Nothing: no two frames followed each
    /// other.
    std::optional<std::int32_t> noise{};
};

/// Looks at the relief of some frames. Percentiles of the whole clip, not of each frame: otherwise a picture
/// that gets darker would pulse under a resting finger.
class ReliefEstimator {
public:
    /// A frame's relief; `follows` the one that was added before it.
    void add(const NumberField& relief, const NumberField& confidence, bool follows);
    /// Nothing to be felt in any frame: full is 1.
    ReliefRange range() const;

private:
    static constexpr std::size_t most = std::size_t{1} << 16;

    std::vector<std::int64_t> sizes_ = std::vector<std::int64_t>(most), changes_ = sizes_;
    NumberField before_;
};

/// Height codes of 8 bits of a clip's relief, frame after frame: 128 is level. What may be noise of the
/// camera is averaged, and a code stays until another is clearly nearer, so that a still point feels still.
class ReliefHeights {
public:
    /// `amount`: per cent of the largest height that the range's `full` becomes.
    ReliefHeights(const ReliefRange& range, int amount) : range_(range), amount_(amount) {}

    /// Of the next frame; until the next call.
    const std::vector<std::uint8_t>& next(const NumberField& relief);
    /// The next frame is not what follows the one before.
    void forget() { states_.clear(); }

    /// How far codes change from frame to frame where no more than noise changed: the mean, and the share of
    /// such pixels that change by more than one.
    struct Flicker {
        double mean = 0, more_than_one = 0;
    };
    /// Nothing where nothing stood still from one frame to the next.
    std::optional<Flicker> flicker() const;

private:
    const ReliefRange range_;
    const int amount_;
    std::vector<std::int32_t> states_;  // 256ths of a code
    std::vector<std::uint8_t> codes_;
    std::int64_t still_ = 0, changes_ = 0, larger_ = 0;
};

/// A clip at its beginning, and what its relief is like.
struct LookedAt {
    std::unique_ptr<ClipReader> clip;
    ReliefRange range;
};
/// Looks at some frames (telling_frames) of a clip that is at its beginning: they say what the largest height
/// stands for, and how much of it is the camera's noise. Amount and direction change nothing of it. Refused
/// without colour.
Result<LookedAt> look_at_relief(std::unique_ptr<ClipReader> clip, const ReliefSettings& settings);

/// The clip with heights that its colour suggests, in place of its own: codes of 8 bits, 128 is level, from
/// -max_height / 2 to max_height / 2 around it. `max_height`: scene units, more than 0; where that leaves no
/// room before the camera it is half of the nearest depth, and a note says so. `notes`: what else a person
/// should know, before what is noted here. After the last frame a note says how far heights flicker.
Result<std::unique_ptr<ClipReader>> with_relief(std::unique_ptr<ClipReader> clip,
                                                const ReliefSettings& settings, const ReliefRange& range,
                                                double max_height, std::vector<std::string> notes = {});

}  // namespace touchable
