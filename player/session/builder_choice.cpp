#include "player/session/builder_choice.hpp"

#include <iostream>

#include "engine/base/try.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/surface/fallback_builder.hpp"

namespace touchable {
namespace {

void warn(const std::string& line) {
    std::cerr << "touchable: warning: " << line << std::endl;
}

Result<std::unique_ptr<SurfaceBuilder>> make_vulkan(const Scene& scene, RunGpu& gpu) {
    TRY_ASSIGN(auto device, gpu.open());
    TRY_ASSIGN(auto builder, make_vulkan_builder(scene, std::move(device)));
    return make_fallback_builder(std::move(builder), make_cpu_builder(scene), warn);
}

}  // namespace

Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu) {
    if (choice.name == "cpu") return make_cpu_builder(scene);
    if (choice.name == "lazy" && scene.filter.temporal)
        return usage_error(
            "builder lazy cannot filter in time: it knows nothing of pixels that nobody touched; right "
            "would be another builder, or no filter in time",
            {{Setting::builder}, {Setting::temporal, "off"}});
    if (choice.name == "lazy") return make_lazy_builder(scene);
    if (choice.name == "reference") return make_reference_builder(scene);
    if (choice.name != "vulkan")
        return usage_error("builder " + choice.name + " is not known", {{Setting::builder}});
    auto vulkan = make_vulkan(scene, gpu);
    if (vulkan.ok() || !choice.gpu_fallback || vulkan.error().kind != ErrorKind::gpu) return vulkan;
    warn(vulkan.error().message + "; the cpu builder does its work");
    return make_cpu_builder(scene);
}

}  // namespace touchable
