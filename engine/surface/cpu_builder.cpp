#include <cassert>

#include "engine/surface/decode.hpp"
#include "engine/surface/hole_filling.hpp"
#include "engine/surface/median.hpp"
#include "engine/surface/raw_check.hpp"
#include "engine/surface/surface_builder.hpp"
#include "engine/surface/tile_bounds.hpp"

namespace touchable {
namespace {

class CpuBuilder final : public SurfaceBuilder {
public:
    explicit CpuBuilder(const Scene& scene) : scene_(scene) {
        assert(scene.filter.median == 0 || scene.filter.median == 3 || scene.filter.median == 5);
    }
    std::string_view name() const override { return "cpu"; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (auto checked = check_raw_frame(raw, scene_); !checked) return checked;
        out.coding = scene_.depth;
        out.raw = {};
        decode(raw.depth, out);
        if (scene_.filter.fill_holes > 0) holes_.fill(scene_.filter.fill_holes, out);
        if (scene_.filter.median > 0) median_.apply(scene_.filter.median, out);
        tiles_.bound(out);
        copy_touch_planes(raw, out);
        if (dynamic_cast<FilteredVertices*>(out.vertices.get()) == nullptr)
            out.vertices = std::make_unique<FilteredVertices>(out);
        return {};
    }

private:
    Scene scene_;
    HoleFiller holes_;
    MedianFilter median_;
    TileBounder tiles_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_cpu_builder(const Scene& scene) {
    return std::make_unique<CpuBuilder>(scene);
}

}  // namespace touchable
