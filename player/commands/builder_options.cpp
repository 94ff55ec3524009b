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
    sub.add_option("--builder", choice.name, what)->check(CLI::IsMember(names))->capture_default_str();
    sub.add_option("--gpu", choice.gpu,
                   "the GPU of --builder vulkan and --picture, which auto may take: auto, cpu (a Vulkan in "
                   "software, as lavapipe), or index or part of the name of a device (touchable check)")
        ->capture_default_str();
}

Result<void> check_gpu_options(const BuilderChoice& choice, bool draws_on_gpu) {
    const bool builds_on_gpu = choice.name == "vulkan" || choice.name == "auto";
    if (choice.names_gpu() && !builds_on_gpu && !draws_on_gpu)
        return usage_error(
            "--gpu goes with --builder vulkan or auto, or a --picture that is not painted by the cpu");
    return {};
}

}  // namespace touchable
