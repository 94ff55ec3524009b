#pragma once

#include "engine/surface/code_filters.hpp"
#include "engine/surface/patches.hpp"

namespace touchable {

/// Filters patches of frames, where no filter remembers frames before; one for each thread that does.
class PatchFilter {
public:
    PatchFilter(const FilterPlan& plan, VectorUnit unit) : filters_(make_code_filters(plan, unit)) {}

    /// Codes and validity of the patch's inner box, into a frame that holds all else. The box begins on a
    /// whole word of validity, and ends on one or with the picture.
    void filter(const RawFrame& raw, const Patch& patch, SurfaceFrame& out);

private:
    void copy(const Patch& patch, SurfaceFrame& out) const;

    const std::unique_ptr<BandSource> filters_;
    RowBands alone_{1};
    SurfaceFrame picture_;  // the patch, as a picture of its own
};

}  // namespace touchable
