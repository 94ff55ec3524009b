#include "player/check/builder_facts.hpp"

#include <chrono>
#include <memory>

#include "engine/content/scenes.hpp"
#include "engine/surface_vulkan/vulkan_builder.hpp"
#include "player/terminal/interrupt.hpp"

namespace touchable {
namespace {

template <class Work>
double milliseconds(Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Reads every pixel of `seen` and compares it with the filtered frame.
bool same_depths(const SurfaceFrame& seen, const SurfaceFrame& filtered) {
    bool same = true;
    for (int y = 0; y < filtered.height; ++y)
        for (int x = 0; x < filtered.width; ++x) {
            const DepthSample sample = seen.vertices->at(x, y);
            const bool valid = filtered.is_valid(x, y);
            if (sample.valid != valid) same = false;
            if (valid && sample.depth != filtered.coding.depth(filtered.codes[filtered.index(x, y)]))
                same = false;
        }
    return same;
}

bool same_bits(const SurfaceFrame& a, const SurfaceFrame& b) {
    return a.codes == b.codes && a.validity == b.validity && a.tiles == b.tiles;
}

}  // namespace

Result<BuilderFacts> builder_facts(const char* name) {
    SceneOptions options;
    options.bits = 8;
    auto source = make_scene(name, options);
    if (!source.ok()) return source.error();
    Scene scene = (*source)->scene();
    scene.filter = {5, 2};
    scene.depth.invalid_codes[0] = 0;  // the picture gets holes to fill
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    const RawFrame raw = (*source)->frame(0);

    BuilderFacts facts{name, scene.width, scene.height, 0, 0, 0, std::nullopt, false};
    SurfaceFrame reference, cpu, lazy, vulkan;
    Result<void> built;
    const auto build = [&](std::unique_ptr<SurfaceBuilder> builder, SurfaceFrame& out) {
        if (built.ok() && interrupted()) built = interrupted_error();
        if (built.ok()) built = builder->build(raw, out);
    };
    bool same_lazily = false;
    facts.reference_ms = milliseconds([&] { build(make_reference_builder(scene), reference); });
    facts.cpu_ms = milliseconds([&] { build(make_cpu_builder(scene), cpu); });
    const auto lazy_builder = make_lazy_builder(scene);  // its frames ask it for pixels, so it stays
    facts.lazy_ms = milliseconds([&] {
        if (built.ok()) built = lazy_builder->build(raw, lazy);
        if (built.ok()) same_lazily = same_depths(lazy, reference);
    });
    if (built.ok() && interrupted()) built = interrupted_error();
    if (!built.ok()) return built.error();
    facts.identical = same_lazily && same_bits(cpu, reference);
    if (const auto device = GpuDevice::open(); device.ok()) {
        auto builder = make_vulkan_builder(scene, *device);
        if (!builder.ok()) return builder.error();
        built = (*builder)->build(raw, vulkan);  // compiles the kernels
        facts.vulkan_ms = milliseconds([&] {
            if (built.ok()) built = (*builder)->build(raw, vulkan);
        });
        if (!built.ok()) return built.error();
        facts.identical = facts.identical && same_bits(vulkan, reference);
    }
    return facts;
}

}  // namespace touchable
