#include "engine/surface/code_filters.hpp"

#include <cassert>

#include "engine/surface/flying_pixels.hpp"
#include "engine/surface/hole_filling.hpp"
#include "engine/surface/median.hpp"
#include "engine/surface/temporal_filter.hpp"
#include "engine/surface/terrace_filter.hpp"

namespace touchable {
namespace {

/// Of the filters so far: lines until one makes bands of them.
struct FilterStack {
    const DepthCoding& stored;
    const VectorUnit unit;
    std::unique_ptr<LineSource> lines;
    std::unique_ptr<BandSource> bands;

    void add(const FlyingPixels& filter) {
        assert(lines);
        lines = std::make_unique<FlyingPixelFilter>(std::move(lines), filter, stored, unit);
    }
    void add(const HoleFilling& filling) {
        assert(lines);
        lines = std::make_unique<HoleFiller>(std::move(lines), filling.passes);
    }
    void add(const MedianWindow& window) {
        assert(lines);
        bands = std::make_unique<MedianFilter>(std::move(lines), window.side, unit);
    }
    void add(const TemporalFilter& filter) {
        bands = std::make_unique<TemporalSmoother>(take_bands(), filter, unit);
    }
    void add(const TerraceFilter& filter) {
        bands = std::make_unique<TerraceRemover>(take_bands(), filter, unit);
    }
    std::unique_ptr<BandSource> take_bands() {
        return bands ? std::move(bands) : std::make_unique<UnfilteredBands>(std::move(lines));
    }
};

}  // namespace

std::unique_ptr<BandSource> make_code_filters(const FilterPlan& plan, VectorUnit unit) {
    FilterStack stack{plan.stored, unit, std::make_unique<StoredLines>(plan.stored, unit), nullptr};
    for (const PlannedFilter& planned : plan.filters)
        std::visit([&](const auto& filter) { stack.add(filter); }, planned.filter);
    return stack.take_bands();
}

}  // namespace touchable
