#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace touchable {

/// d' = scale d + shift.
struct Line {
    double scale = 1, shift = 0;
    double at(double value) const { return scale * value + shift; }
    /// What `this` gives, in place of the value of `after`.
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
/// The line on which most points lie, however far the others are away: least median of squares over fixed
/// pairs, then weights that fall with the distance. Where `from` is nearly the same everywhere the scale
/// cannot be told: it is 1. Nothing of fewer than eight points. Only + - * / and comparisons, in a fixed
/// order: the same bits everywhere. `least_noise`: distances below it tell nothing.
std::optional<LineFit> fit_line(const std::vector<LinePoint>& points, double least_noise);

}  // namespace touchable
