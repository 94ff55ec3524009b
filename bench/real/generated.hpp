#pragma once

#include "bench/real/filter_choices.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// What a choice of filters does to depth that needs none. Appends changed_pct: of generated clips of 16
/// bits, the pixels whose code or validity is not the stored one's.
Result<void> measure_generated(const FilterChoice& choice, Figures& figures);

}  // namespace touchable
