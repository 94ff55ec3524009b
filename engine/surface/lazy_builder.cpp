#include "engine/surface/lazy_vertices.hpp"
#include "engine/surface/raw_check.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

class LazyBuilder final : public SurfaceBuilder {
public:
    explicit LazyBuilder(const Scene& scene) : scene_(scene), plan_(scene) {}
    std::string_view name() const override { return "lazy"; }
    double built_share() const override { return 0; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (plan_.remembers())
            return input_error(
                "the lazy builder cannot filter in time (filter.temporal is on), because it has no history "
                "of pixels that nobody touched; must be another builder");
        if (auto checked = check_raw_frame(raw, scene_); !checked) return checked;
        out.width = scene_.width;
        out.height = scene_.height;
        out.coding = plan_.coding();
        out.codes.clear();
        out.validity.clear();
        out.tiles.clear();
        copy_touch_planes(raw, out);
        out.filled = raw.filled;
        out.raw = raw;
        auto* vertices = dynamic_cast<LazyVertices*>(out.vertices.get());
        if (vertices != nullptr && vertices->serves(plan_))
            vertices->restart();
        else
            out.vertices = std::make_unique<LazyVertices>(out, plan_);
        return {};
    }

private:
    const Scene scene_;
    const FilterPlan plan_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_lazy_builder(const Scene& scene) {
    return std::make_unique<LazyBuilder>(scene);
}

}  // namespace touchable
