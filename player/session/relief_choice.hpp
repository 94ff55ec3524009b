#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "engine/authoring/relief_clip.hpp"
#include "engine/authoring/relief_estimator.hpp"
#include "engine/authoring/relief_filter.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"

namespace touchable {

/// What several readers of one clip have learned of its relief: another amount or height needs no second
/// look.
class ReliefMemory {
public:
    using Bands = std::array<int, DifferenceOfGaussians::bands>;
    std::optional<ReliefRange> range(const Bands& bands) const;
    void keep(const Bands& bands, const ReliefRange& range);

private:
    mutable std::mutex mutex_;
    std::map<Bands, ReliefRange> ranges_;
};

/// Relief that a person wants of a clip's colour.
struct ReliefChoice {
    ReliefSettings settings{};
    double height_mm = 0.5;    ///< from the deepest to the highest
    bool is_of_world = false;  ///< of what was recorded, not of the hand
};

/// The clip with relief in place of its own heights (with_relief). `clip` is at its beginning, and no live
/// source (ErrorKind::usage). `memory`: of that clip; nullptr: none is kept.
Result<std::unique_ptr<ClipReader>> with_chosen_relief(std::unique_ptr<ClipReader> clip,
                                                       const ReliefChoice& choice,
                                                       ReliefMemory* memory = nullptr);

}  // namespace touchable
