#include <algorithm>
#include <cassert>
#include <thread>

#include "engine/surface/hole_filling.hpp"
#include "engine/surface/line_source.hpp"
#include "engine/surface/median.hpp"
#include "engine/surface/raw_check.hpp"
#include "engine/surface/surface_builder.hpp"
#include "engine/surface/temporal_filter.hpp"
#include "engine/surface/terrace_filter.hpp"
#include "engine/surface/tile_bounds.hpp"

namespace touchable {
namespace {

/// A thread more pays where it has this many pixels to do: they take about 50 us, waking it some 5 us of CPU
/// time and a few tens of waiting.
constexpr long pixels_per_thread = 150'000;
/// More of them wait for memory, and the others of a program want cores too.
constexpr int most_threads = 4;

int threads_for(const Scene& scene, int asked) {
    if (asked > 0) return asked;
    const long pixels = long{scene.width} * scene.height;
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    return std::clamp(static_cast<int>(std::min<long>(pixels / pixels_per_thread, most_threads)), 1,
                      std::max(cores, 1));
}

/// The widest that there is, up to the one that is asked for.
VectorUnit unit_for(VectorUnit most) {
    const auto units = usable_vector_units();
    return *std::find_if(units.begin(), units.end() - 1, [&](VectorUnit unit) { return unit <= most; });
}

class CpuBuilder final : public SurfaceBuilder {
public:
    CpuBuilder(const Scene& scene, const CpuPlan& plan)
        : scene_(scene),
          unit_(unit_for(plan.vectors)),
          temporal_(temporal_filter(scene)),
          terraces_(terrace_filter(scene)),
          bands_(threads_for(scene, plan.threads)),
          median_(unit_),
          smoother_(unit_),
          remover_(unit_),
          tiles_(unit_) {
        assert(scene.filter.median == 0 || scene.filter.median == 3 || scene.filter.median == 5);
    }
    std::string_view name() const override { return "cpu"; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (auto checked = check_raw_frame(raw, scene_); !checked) return checked;
        out.raw = {};
        take_size(out);
        const StoredLines stored(raw.depth, scene_.depth, unit_);
        tiles_.begin(bands_.threads(), out);
        if (temporal_) smoother_.begin(out, raw.number);
        if (scene_.filter.fill_holes == 0) {
            finish_codes(stored, out);
        } else {
            take_size(filled_);
            decode(stored, filled_);
            holes_.fill(scene_.filter.fill_holes, bands_, filled_);
            finish_codes(FrameLines(filled_), out);
        }
        tiles_.finish(bands_, out);
        copy_touch_planes(raw, out);
        if (dynamic_cast<FilteredVertices*>(out.vertices.get()) == nullptr)
            out.vertices = std::make_unique<FilteredVertices>(out);
        return {};
    }

private:
    void take_size(SurfaceFrame& frame) const {
        frame.coding = scene_.depth;
        frame.width = scene_.width;
        frame.height = scene_.height;
        frame.codes.resize(frame.index(0, frame.height));
        frame.validity.resize(static_cast<std::size_t>(frame.validity_words_per_row()) *
                              static_cast<std::size_t>(frame.height));
    }

    void decode(const LineSource& stored, SurfaceFrame& out) {
        median_.begin(1, out.width, bands_.threads());
        bands_.for_each_band(out.height, TileGrid::cells,
                             [&](const RowBand& band) { median_.filter(band, stored, out); });
    }
    /// Codes of the last filter, and those bounds that need no other band.
    void finish_codes(const LineSource& source, SurfaceFrame& out) {
        if (terraces_) {
            take_size(with_terraces_);
            filter(source, with_terraces_, [&](const RowBand& band) { smooth(band, with_terraces_); });
            remove_terraces(out);
        } else {
            if (temporal_) out.coding = temporal_->coding;
            filter(source, out, [&](const RowBand& band) {
                smooth(band, out);
                tiles_.bound_inside(band, out);
            });
        }
    }
    /// Decoding too, where `source` does; `then` is what else to do with a band.
    template <class Then>
    void filter(const LineSource& source, SurfaceFrame& out, Then&& then) {
        median_.begin(std::max(scene_.filter.median, 1), out.width, bands_.threads());
        bands_.for_each_band(out.height, TileGrid::cells, [&](const RowBand& band) {
            median_.filter(band, source, out);
            then(band);
        });
    }
    void smooth(const RowBand& band, SurfaceFrame& frame) {
        if (temporal_) smoother_.smooth(band, *temporal_, frame);
    }
    void remove_terraces(SurfaceFrame& out) {
        out.coding = terraces_->coding;
        remover_.begin(out.width, bands_.threads());
        bands_.for_each_band(out.height, TileGrid::cells, [&](const RowBand& band) {
            remover_.remove(band, *terraces_, with_terraces_, out);
            tiles_.bound_inside(band, out);
        });
    }

    Scene scene_;
    const VectorUnit unit_;
    std::optional<TemporalFilter> temporal_;
    std::optional<TerraceFilter> terraces_;
    RowBands bands_;
    SurfaceFrame filled_;         // between hole filling and median; empty where no holes are filled
    SurfaceFrame with_terraces_;  // between median and terrace removal, likewise
    HoleFiller holes_;
    MedianFilter median_;
    TemporalSmoother smoother_;
    TerraceRemover remover_;
    TileBounder tiles_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene) {
    return make_cpu_builder(scene, {});
}
std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene, const CpuPlan& plan) {
    return std::make_unique<CpuBuilder>(scene, plan);
}

}  // namespace touchable
