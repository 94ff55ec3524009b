#include "engine/surface/lazy_vertices.hpp"
#include "engine/surface/raw_check.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

class LazyBuilder final : public SurfaceBuilder {
public:
    explicit LazyBuilder(const Scene& scene) : scene_(scene), terraces_(terrace_filter(scene)) {}
    std::string_view name() const override { return "lazy"; }
    double built_share() const override { return 0; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (scene_.filter.temporal)
            return input_error(
                "the lazy builder cannot filter in time (filter.temporal is on), because it has no history "
                "of "
                "pixels that nobody touched; must be another builder");
        if (auto checked = check_raw_frame(raw, scene_); !checked) return checked;
        out.width = scene_.width;
        out.height = scene_.height;
        out.coding = terraces_ ? terraces_->coding : scene_.depth;
        out.codes.clear();
        out.validity.clear();
        out.tiles.clear();
        copy_touch_planes(raw, out);
        out.raw = raw;
        auto* vertices = dynamic_cast<LazyVertices*>(out.vertices.get());
        if (vertices != nullptr && vertices->serves(scene_))
            vertices->restart();
        else
            out.vertices = std::make_unique<LazyVertices>(out, scene_);
        return {};
    }

private:
    Scene scene_;
    std::optional<TerraceFilter> terraces_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_lazy_builder(const Scene& scene) {
    return std::make_unique<LazyBuilder>(scene);
}

}  // namespace touchable
