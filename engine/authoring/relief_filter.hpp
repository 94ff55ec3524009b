// SPDX-License-Identifier: Apache-2.0
#pragma once

// The relief of a clip's pictures, step by step: details by their size (DifferenceOfGaussians), a frame's
// relief (ReliefFilter), a clip's strength of relief (ReliefEstimator), heights through time (ReliefHeights).

#include <array>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A picture of whole numbers, row by row.
struct NumberField {
    int width = 0, height = 0;
    std::vector<std::int32_t> numbers;

    NumberField() = default;
    NumberField(int columns, int rows) : width(columns), height(rows), numbers(pixel_count(columns, rows)) {}
    std::int32_t* row(int y) { return numbers.data() + pixel_place(0, y, width); }
    const std::int32_t* row(int y) const { return numbers.data() + pixel_place(0, y, width); }
};

/// Where surfaces end: for each pixel the first and the last column, and the first and the last row, of the
/// run of its surface around it.
struct SurfaceRuns {
    struct Run {
        std::int16_t first, last;
    };
    SurfaceRuns() = default;
    /// All pixels are one surface.
    SurfaceRuns(int width, int height);

    int width = 0, height = 0;
    std::vector<Run> across, down;
};

/// Divides the sum over a square of `side` (odd) pixels around each, as far as they are of its surface, by
/// side^2; in place. Along rows first, then along columns, each rounded to the nearest, halves up. Numbers
/// are 0 to 2^24, sides at most 127.
class BoxFilter {
public:
    void apply(NumberField& field, int side, const SurfaceRuns& runs);

private:
    // Running sums; they may wrap, their differences do not.
    std::vector<std::uint32_t> row_sums_, column_sums_;
};

/// Details of a picture by their size: a Gaussian blur minus a wider one. This is the Laplacian of Gaussian
/// that the paper takes for roughness (section 3.1.2), at three widths. Pixels have weights, and surfaces
/// end: neither pixels without weight nor another surface blur into neighbours (normalised convolution).
class DifferenceOfGaussians {
public:
    static constexpr int bands = std::tuple_size_v<decltype(ReliefSettings::bands)>;
    /// Standard deviations, in pixels, of the blurs between which the bands lie. A Gaussian is made of
    /// successive boxes.
    static constexpr std::array<double, bands + 1> sigma{0.82, 1.83, 4.47, 10.39};

    static constexpr std::int32_t most_weight = 4096, most_value = 4096;

    /// `values` 0 to most_value, `weights` 0 to most_weight, all of one size.
    void split(const NumberField& values, const NumberField& weights, const SurfaceRuns& runs);
    /// Band k of the last picture, from fine to coarse: 0 where no pixel nearby has weight.
    const NumberField& band(int k) const { return bands_[static_cast<std::size_t>(k)]; }
    /// Weight around each pixel, 0 to most_weight: weights after the second blur.
    const NumberField& confidence() const { return confidence_; }

private:
    void blur(std::size_t step, const SurfaceRuns& runs);

    BoxFilter box_;
    NumberField weighted_, weights_, mean_, wider_, confidence_;
    std::array<NumberField, bands> bands_;
};

/// The relief that a frame's colour suggests, before it is scaled: places brighter than their surroundings
/// stand out. There is none across a step of depth, where depth is missing, in deep shadow and in highlights.
class ReliefFilter {
public:
    ReliefFilter(const ReliefSettings& settings, const DepthCoding& depth)
        : settings_(settings), depth_(depth) {}

    /// `frame` must have colour. Numbers are sixteenths of a level of brightness; about -4096 to 4096 for
    /// bands of 100 %.
    const NumberField& apply(const RawFrame& frame);
    /// Weight of each pixel's relief in the last frame: 0 to DifferenceOfGaussians::most_weight.
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

/// Measures the relief of some frames. Percentiles are of the whole clip, not of each frame: otherwise a
/// picture that gets darker would pulse under a resting finger.
class ReliefEstimator {
public:
    /// Adds a frame's relief; `follows`: it comes right after the one added before it.
    void add(const NumberField& relief, const NumberField& confidence, bool follows);
    /// If no frame has relief, full is 1.
    ReliefRange range() const;

private:
    static constexpr std::size_t most = std::size_t{1} << 16;

    std::vector<std::int64_t> sizes_ = std::vector<std::int64_t>(most), changes_ = sizes_;
    NumberField before_;
};

/// Height codes of 8 bits of a clip's relief, frame after frame: 128 is level. Possible noise of the camera
/// is averaged, and a code stays until another is clearly nearer, so that a still point feels still.
class ReliefHeights {
public:
    /// `amount`: per cent of the largest height that the range's `full` becomes.
    ReliefHeights(const ReliefRange& range, int amount) : range_(range), amount_(amount) {}

    /// Returns the codes of the next frame, valid until the next call.
    const std::vector<std::uint8_t>& next(const NumberField& relief);
    /// To be called if the next frame does not follow the last one.
    void forget() { states_.clear(); }

    /// How far codes change from frame to frame at pixels where no more than noise changed: the mean, and the
    /// share of these pixels that change by more than one.
    struct Flicker {
        double mean = 0, more_than_one = 0;
    };
    /// nullopt if no pixel stood still from one frame to the next.
    std::optional<Flicker> flicker() const;

private:
    const ReliefRange range_;
    const int amount_;
    std::vector<std::int32_t> states_;  // 256ths of a code
    std::vector<std::uint8_t> codes_;
    std::int64_t still_ = 0, changes_ = 0, larger_ = 0;
};

}  // namespace touchable
