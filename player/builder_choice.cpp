#include "player/builder_choice.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "engine/surface/fallback_builder.hpp"
#include "engine/surface/vulkan_builder.hpp"

namespace touchable {
namespace {

void warn(const std::string& line) {
    std::cerr << "touchable: warning: " << line << std::endl;
}

Result<std::unique_ptr<SurfaceBuilder>> make_vulkan(const Scene& scene, RunGpu& gpu) {
    auto device = gpu.open();
    if (!device.ok()) return device.error();
    auto builder = make_vulkan_builder(scene, std::move(*device));
    if (!builder.ok()) return builder.error();
    return make_fallback_builder(std::move(*builder), make_cpu_builder(scene), warn);
}

}  // namespace

void add_builder_options(CLI::App& sub, BuilderChoice& choice, const std::vector<std::string>& names) {
    std::string what = "how frames become a surface, all with the same bits:";
    for (const std::string& name : names) {
        what += (&name == &names.front() ? " " : ", ") + name;
        if (name == "lazy") what += " (only where touched)";
        if (name == "reference") what += " (slow)";
        if (name == "vulkan") what += " (on a GPU)";
        if (name == "auto") what += " (what costs least here)";
    }
    auto* builder =
        sub.add_option("--builder", choice.name, what)->check(CLI::IsMember(names))->capture_default_str();
    sub.add_option("--gpu", choice.gpu,
                   "the GPU of --builder vulkan and --picture, which auto may take: auto, cpu (a Vulkan in "
                   "software, as lavapipe), or index or part of the name of a device (touchable check)")
        ->capture_default_str();
    sub.add_flag("--gpu-fallback", choice.gpu_fallback,
                 "with --builder vulkan: where no GPU is usable, the cpu builder instead of exit code 4")
        ->needs(builder);
}

Result<void> check_gpu_options(const BuilderChoice& choice, bool draws_on_gpu) {
    if (choice.name == "vulkan") return {};
    if (choice.gpu_fallback)
        return usage_error("--gpu-fallback goes with --builder vulkan, not " + choice.name);
    if (choice.names_gpu() && choice.name != "auto" && !draws_on_gpu)
        return usage_error(
            "--gpu goes with --builder vulkan or auto, or a --picture that is not painted by the cpu");
    return {};
}

Result<std::unique_ptr<SurfaceBuilder>> make_builder(const BuilderChoice& choice, const Scene& scene,
                                                     RunGpu& gpu) {
    if (choice.name == "cpu") return make_cpu_builder(scene);
    if (choice.name == "lazy" && scene.filter.temporal)
        return usage_error(
            "--builder lazy cannot filter in time: it knows nothing of pixels that nobody touched; right "
            "would be another builder, or --temporal off");
    if (choice.name == "lazy") return make_lazy_builder(scene);
    if (choice.name == "reference") return make_reference_builder(scene);
    if (choice.name != "vulkan") return usage_error("--builder " + choice.name + " is not known");
    auto vulkan = make_vulkan(scene, gpu);
    if (vulkan.ok() || !choice.gpu_fallback || vulkan.error().kind != ErrorKind::gpu) return vulkan;
    warn(vulkan.error().message + "; the cpu builder does its work");
    return make_cpu_builder(scene);
}

}  // namespace touchable
