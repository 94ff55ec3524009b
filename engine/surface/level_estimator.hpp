#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/scene/code_curve.hpp"
#include "engine/surface/code_picture.hpp"

namespace touchable {

/// Which codes of a recording occur, and how far they are apart. Integer counts and + - x / alone.
class LevelEstimator {
public:
    explicit LevelEstimator(const DepthCoding& coding);

    void add(const CodePicture& picture);

    /// Of the valid pixels, scene units, without those at the far plane, where backgrounds are, unless there
    /// are no others. Nothing where there were none.
    std::optional<double> median_depth() const;
    /// How far neighbouring depths that occur are apart, where that is more than a code: as of codes that
    /// were rounded from something coarser, such as disparity. Zero where every code occurs, and where what
    /// occurs has no rule. docs/conventions.md, Levels.
    DepthLength levels() const;

private:
    /// Of a code: how often it occurs, and how many of its right and upper neighbours are valid, or the same.
    struct CodeCount {
        std::int64_t pixels = 0, right = 0, same_right = 0, above = 0, same_above = 0;
    };
    /// Codes from `first` to before `end`, among which levels are as far apart.
    struct Window {
        std::int64_t pixels = 0;
        double depth = 0, distance = 0;  // of its middle, and from level to level, scene units
    };

    std::optional<Window> window(int first, int end) const;
    std::vector<Window> windows() const;
    static DepthLength levels_of_floats(const std::vector<Window>& found);

    const DepthCoding coding_;
    std::vector<CodeCount> counts_;
};

}  // namespace touchable
