// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/real/filter_choices.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Measures what a choice of filters changes in depth that needs none. Appends changed_pct: the pixels of
/// generated 16-bit clips whose code or validity differs from the stored one.
Result<void> measure_generated(const FilterChoice& choice, Figures& figures);

}  // namespace touchable
