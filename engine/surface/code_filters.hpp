#pragma once

#include <functional>
#include <optional>

#include "engine/scene/terraces.hpp"
#include "engine/surface/hole_filling.hpp"
#include "engine/surface/median.hpp"
#include "engine/surface/temporal_filter.hpp"
#include "engine/surface/terrace_filter.hpp"

namespace touchable {

/// What to do with a band of rows that is finished, while it is still in the cache.
using BandFinished = std::function<void(const RowBand& band)>;

/// A scene's filters, one after the other: from stored values to codes and validity, of a whole picture or of
/// any part of one.
class CodeFilters {
public:
    CodeFilters(const Scene& scene, VectorUnit unit);

    /// How far away, along x and along y, a pixel may be that another one depends on; nothing where that may
    /// be one of a frame before.
    std::optional<int> reach() const;
    /// Codes and validity of `out`, which takes on the depth plane's size. No allocation where it has had
    /// that.
    void filter(const RawFrame& raw, RowBands& bands, SurfaceFrame& out, const BandFinished& finished);

private:
    void take_size(int width, int height, SurfaceFrame& frame) const;
    void finish(const LineSource& source, std::int64_t frame, RowBands& bands, SurfaceFrame& out,
                const BandFinished& finished);
    template <class Then>
    void take_median(int side, const LineSource& source, RowBands& bands, SurfaceFrame& out, Then&& then);
    void remove_terraces(RowBands& bands, SurfaceFrame& out, const BandFinished& finished);

    const DepthCoding coding_;
    const FilterSettings settings_;
    const VectorUnit unit_;
    const std::optional<TemporalFilter> temporal_;
    const std::optional<TerraceFilter> terraces_;
    SurfaceFrame filled_;         // between hole filling and median; empty where no holes are filled
    SurfaceFrame with_terraces_;  // between median and terrace removal, likewise
    HoleFiller holes_;
    MedianFilter median_;
    TemporalSmoother smoother_;
    TerraceRemover remover_;
};

}  // namespace touchable
