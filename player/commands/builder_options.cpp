#include "player/commands/builder_options.hpp"

#include <CLI/CLI.hpp>

namespace touchable {

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

}  // namespace touchable
