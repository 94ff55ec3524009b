#pragma once

#include "engine/result.hpp"
#include "player/check/trial_verdict.hpp"

namespace touchable {

/// Makes a clip of that size in the folder of temporary files (depth of 16 bits and colour),
/// decodes, builds (median 3x3) and touches it, and removes it. Takes seconds.
Result<TrialFigures> try_touch(const TouchDemand& demand);

}  // namespace touchable
