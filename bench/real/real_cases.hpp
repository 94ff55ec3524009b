// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// Forces on depth of real cameras, recorded and simulated: real-<what>-<filters>. Cases left out because of
/// missing recordings are listed on stderr.
std::vector<BenchCase> real_cases(bool quick);

}  // namespace touchable
