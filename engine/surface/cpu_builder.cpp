// SPDX-License-Identifier: Apache-2.0
// The fast builder: rows on several threads, vectorised filters, and partial builds of frames that changed
// little.
#include <deque>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/surface/code_rows.hpp"
#include "engine/surface/frame_changes.hpp"
#include "engine/surface/patches.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

/// These take about 50 us.
constexpr long pixels_filtered_per_thread = 150'000;

/// Building larger pictures takes longer than stopping the program should.
bool is_large(const Scene& scene) {
    return std::int64_t{scene.width} * scene.height > std::int64_t{4096} * 4096;
}

/// The widest available unit, up to `most`.
VectorUnit unit_for(VectorUnit most) {
    const auto units = usable_vector_units();
    return *std::find_if(units.begin(), units.end() - 1, [&](VectorUnit unit) { return unit <= most; });
}

/// Share of a picture up to which patches pay: a patch is written twice, so its pixels cost more than those
/// of a whole picture, the more the less there is to filter.
double what_pays(const FilterPlan& filters) {
    return filters.find<FilterPlan::MedianWindow>() == nullptr ? 0.45 : 0.65;
}

/// Filtered vertices with the number of the build that their frame holds. Only this builder keeps them in a
/// slot.
class TrackedVertices final : public FilteredVertices {
public:
    using FilteredVertices::FilteredVertices;
    BuildNumber build;
};

/// The vertices of a slot; new ones if it has none.
TrackedVertices& tracked_vertices(SurfaceFrame& slot) {
    if (auto* const there = dynamic_cast<TrackedVertices*>(slot.vertices.get())) return *there;
    auto made = std::make_unique<TrackedVertices>(slot);
    TrackedVertices& vertices = *made;
    slot.vertices = std::move(made);
    return vertices;
}

class CpuBuilder final : public SurfaceBuilder {
public:
    CpuBuilder(const Scene& scene, const CpuPlan& plan)
        : scene_(scene),
          plan_(scene),
          break_even_(plan.break_even.value_or(what_pays(plan_))),
          bands_(plan.threads > 0 ? plan.threads
                                  : threads_for(long{scene.width} * scene.height, pixels_filtered_per_thread),
                 is_large(scene)),
          filters_(make_code_filters(plan_, unit_for(plan.vectors))),
          tiles_(unit_for(plan.vectors)) {
        const auto reach = plan_.reach();
        if (!reach) return;
        changes_.emplace(scene.width, scene.height, *reach, unit_for(plan.vectors));
        while (static_cast<int>(patch_filters_.size()) < bands_.threads())
            patch_filters_.emplace_back(plan_, unit_for(plan.vectors));
    }
    std::string_view name() const override { return "cpu"; }
    double built_share() const override { return built_share_; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        TRY(check_raw_frame(raw, scene_));
        const BuildNumber newest = changes_ ? changes_->advance(raw, bands_) : BuildNumber{};
        TrackedVertices& vertices = tracked_vertices(out);
        const BuildNumber held = std::exchange(vertices.build, {});
        out.raw = {};
        if (const auto stale = changes_ ? changes_->stale_blocks(held) : std::nullopt; stale && pays(*stale))
            build_patches(raw, out);
        else
            build_all(raw, out);
        if (is_large(scene_) && stop_requested()) return interrupted_error();
        if (!changes_ || !held.is_since(changes_->touch_planes())) copy_touch_planes(raw, out);
        out.filled = raw.filled;
        vertices.build = newest;
        return {};
    }

private:
    bool pays(const FrameChanges::StaleBlocks& stale) {
        patches_.cover(stale, scene_.width, scene_.height, *plan_.reach());
        const bool cheaper = static_cast<double>(patches_.cost) < break_even_ * scene_.width * scene_.height;
        if (!cheaper) changes_->comparing_was_in_vain();
        return cheaper;
    }
    void build_all(const RawFrame& raw, SurfaceFrame& out) {
        tiles_.begin(bands_.threads(), scene_.width, scene_.height, out);
        out.coding = plan_.coding();
        filters_->make_all(raw, bands_, out, [&](const RowBand& band) { tiles_.bound_inside(band, out); });
        tiles_.finish(bands_, out);
        built_share_ = 1;
    }
    /// Builds the patches in a slot that holds all else.
    void build_patches(const RawFrame& raw, SurfaceFrame& out) {
        const auto& patches = patches_.patches;
        bands_.for_each_band(static_cast<int>(patches.size()), 1, [&](const RowBand& some) {
            for (int n = some.first; n < some.last; ++n)
                patch_filters_[static_cast<std::size_t>(some.thread)].filter(
                    raw, patches[static_cast<std::size_t>(n)], out);
        });
        const auto& runs = patches_.tile_runs;
        bands_.for_each_band(static_cast<int>(runs.size()), 1, [&](const RowBand& some) {
            for (int n = some.first; n < some.last; ++n)
                tiles_.bound(runs[static_cast<std::size_t>(n)], some.thread, out);
        });
        built_share_ = static_cast<double>(patches_.tiles) / static_cast<double>(out.tiles.size());
    }

    const Scene scene_;
    const FilterPlan plan_;
    const double break_even_;
    RowBands bands_;
    const std::unique_ptr<BandSource> filters_;
    TileBounder tiles_;
    std::optional<FrameChanges> changes_;  // nothing: filters remember earlier frames
    Patches patches_;
    std::deque<PatchFilter> patch_filters_;  // one per thread
    double built_share_ = 0;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene, const CpuPlan& plan) {
    return std::make_unique<CpuBuilder>(scene, plan);
}

}  // namespace touchable
