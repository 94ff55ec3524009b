#pragma once

#include <cstddef>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/gpu/gpu_facts.hpp"

namespace touchable {

/// A small kernel (64 Ki words, shaders/self_check.h), run on a device.
struct KernelFacts {
    bool same_bits = false;                 ///< as the CPU's, every time
    double first_ms = 0;                    ///< from submission to its end, with the driver's compilation
    double least_ms = 0, p50_ms = 0;        ///< the same, of `runs` later ones
    std::optional<double> least_device_ms;  ///< by the device's own timestamps, where it has them
    static constexpr int runs = 50;
};

/// What Vulkan is here.
struct VulkanFacts {
    std::vector<GpuFacts> gpus;
    std::optional<std::size_t> used;  ///< which of them `auto` is
    std::string unusable;  ///< why there is none, or what failed on it; empty: Vulkan does the work
    std::optional<KernelFacts> kernel;
};

struct KernelRun {
    double ms = 0;                    ///< from submission to its end
    std::optional<double> device_ms;  ///< nothing: the queue gave no times
    bool same_bits = false;
};
/// What the first run, with the driver's compilation, and at least one later one come to.
KernelFacts facts_of(const KernelRun& first, std::span<const KernelRun> later);

/// Opens the device and runs the kernel. Never fails: what is wrong is a fact too.
VulkanFacts vulkan_facts();

/// Lines of `touchable check`: each device and what it lacks, memory, limits and timings of the one used.
void print_vulkan(std::ostream& out, const VulkanFacts& facts);
nlohmann::ordered_json vulkan_json(const VulkanFacts& facts);

}  // namespace touchable
