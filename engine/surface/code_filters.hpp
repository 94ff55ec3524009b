#pragma once

#include <memory>

#include "engine/surface/code_rows.hpp"
#include "engine/surface/filter_plan.hpp"

namespace touchable {

/// A plan's filters as the CPU has them, one on top of the other: from stored values to codes and validity,
/// of a whole picture or of any part of one.
std::unique_ptr<BandSource> make_code_filters(const FilterPlan& plan, VectorUnit unit);

}  // namespace touchable
