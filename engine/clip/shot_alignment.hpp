// SPDX-License-Identifier: Apache-2.0
#pragma once

// Depth whose scale changes from frame to frame, brought to one scale: for each frame the line that does so.

#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "engine/clip/readers.hpp"

namespace touchable {

/// d' = scale d + shift.
struct Line {
    double scale = 1, shift = 0;
    double at(double value) const { return scale * value + shift; }
    /// `after` applied to the value that this line gives.
    Line then(const Line& after) const { return {after.scale * scale, after.scale * shift + after.shift}; }
    Line inverse() const { return {1 / scale, -shift / scale}; }
};

struct LinePoint {
    double from = 0, to = 0;
};

struct LineFit {
    Line line;
    double noise = 0;  ///< robust standard deviation of `to`
};
/// Robust line fit: least median of squares over fixed pairs, then weights that fall with the distance. If
/// `from` is nearly the same everywhere, the scale is 1. Nullopt for fewer than eight points. Only + - * /
/// and comparisons, in a fixed order: the same bits everywhere. `least_noise`: distances below it are noise.
std::optional<LineFit> fit_line(const std::vector<LinePoint>& points, double least_noise);

/// Depths of cells that stood still, in the frame before and in a frame, sixteenths of a code.
using RestingCells = std::vector<std::pair<std::int32_t, std::int32_t>>;

/// Finds for each frame of a clip the line that takes its codes to one scale. Frames come in order; a cut
/// begins a new shot. In a shot in which most things stand still, the lines keep them still: unchanged colour
/// and agreeing depths identify still cells, which are remembered for the whole shot, so that the scale
/// cannot drift. If the camera moves, the scale a while ago is unknown: only changes faster than a second are
/// removed. The mean scale of a shot stays what it was.
class ShotAlignment {
public:
    void add(CellPicture picture);
    /// The line of every added frame, in sixteenths of a code. Once.
    std::vector<Line> finish();

    const std::vector<RestingCells>& resting() const { return resting_; }
    std::int64_t shots() const { return shots_; }
    /// Shots aligned by what stands still.
    std::int64_t still_shots() const { return still_shots_; }
    /// Motion of still cells from frame to frame, root mean square, as a share of the range of codes; and the
    /// part of it that no scale and shift explain.
    double pumping() const { return pairs_ > 0 ? std::sqrt(moved_ / static_cast<double>(pairs_)) : 0; }
    double unexplained() const {
        return pairs_ > 0 ? std::sqrt(unexplained_ / static_cast<double>(pairs_)) : 0;
    }

private:
    struct Reference {
        double depth = 0, luma = 0;
        int age = -1;  // frames since the depth changed; -1: no depth yet
        int calm = 0;  // frames since the colour changed
    };
    struct Fitted {
        Line to_shot;    // to the shot's scale
        Line to_before;  // to the codes of the frame before
        bool is_still = false;
    };

    double changed(const CellPicture& picture) const;
    LineFit fit_to_before(const CellPicture& picture, RestingCells& resting);
    void fit_to_shot(const CellPicture& picture, Fitted& fitted);
    void remember(const CellPicture& picture, const std::vector<bool>& same, const Line& line,
                  double tolerance);
    void begin_shot(const CellPicture& picture);
    void end_shot();
    std::vector<Line> lines_of_still() const;
    std::vector<Line> lines_of_moving() const;

    std::vector<Line> lines_;
    std::vector<RestingCells> resting_;
    std::vector<Fitted> shot_;           // frames of the current shot
    std::vector<Reference> references_;  // by cell of the current shot
    CellPicture before_;
    double least_noise_ = 1, range_ = 1;  // of the shot
    double moved_ = 0, unexplained_ = 0;  // sums of squares
    std::int64_t pairs_ = 0, shots_ = 0, still_shots_ = 0;
};

}  // namespace touchable
