#pragma once

#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// How depth of real cameras feels, recorded and simulated: real-<what>-<filters>. Where the recordings are
/// not there, a line on stderr says which cases are left out.
std::vector<BenchCase> real_cases(bool quick);

}  // namespace touchable
