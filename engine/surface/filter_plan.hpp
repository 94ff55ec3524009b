#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "engine/scene/flying_pixels.hpp"
#include "engine/scene/temporal.hpp"
#include "engine/scene/terraces.hpp"

namespace touchable {

/// Passes that fill holes from their rims.
struct HoleFilling {
    int passes = 0;
    bool operator==(const HoleFilling&) const = default;
};
/// The lower median of a window of `side` x `side` pixels, 3 or 5.
struct MedianWindow {
    int side = 0;
    bool operator==(const MedianWindow&) const = default;
};

/// Every builder has an overload for each, so that none of them can miss a new one.
using Filter = std::variant<FlyingPixels, HoleFilling, MedianWindow, TemporalFilter, TerraceFilter>;

struct PlannedFilter {
    Filter filter;
    /// How far away, along x and along y, a pixel may be that another one depends on; nothing where that may
    /// be one of a frame before.
    std::optional<int> reach;
    DepthCoding coding;  ///< of the codes that it leaves
    bool operator==(const PlannedFilter&) const = default;
};

/// What becomes of a scene's stored values: which filters they go through, in what order, how far each of
/// them looks, what it remembers, and what the codes mean in the end. All builders go by it.
struct FilterPlan {
    /// Needs a scene that `validate` accepts.
    explicit FilterPlan(const Scene& scene);

    DepthCoding stored;                  ///< of the codes that stored values are
    std::vector<PlannedFilter> filters;  ///< in order; empty: values are only decoded

    const DepthCoding& coding() const { return filters.empty() ? stored : filters.back().coding; }
    /// Of all filters together; nothing where one remembers frames before.
    std::optional<int> reach() const;
    bool remembers() const { return !reach(); }
    /// Null where the scene does not ask for it.
    template <class F>
    const F* find() const {
        for (const PlannedFilter& planned : filters)
            if (const F* filter = std::get_if<F>(&planned.filter)) return filter;
        return nullptr;
    }
    bool operator==(const FilterPlan&) const = default;
};

}  // namespace touchable
