#pragma once

#include <cstddef>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/gpu/gpu_device.hpp"

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

/// What the haptic thread will find on this machine.
struct TimerFacts {
    double clock_resolution_ns = 0;           ///< of the monotonic clock
    double timer_slack_ns = 0;                ///< by which the kernel may let this thread oversleep
    double late_p50_us = 0, late_max_us = 0;  ///< waking from 200 sleeps to a 1 ms grid
    bool realtime_permitted = false;          ///< SCHED_FIFO
};

/// How a person permits SCHED_FIFO and locked memory to `program`: one way on each line.
std::vector<std::string> ways_to_realtime(const std::string& user, const std::string& program);
/// For who runs this program, and it.
std::vector<std::string> ways_to_realtime();

struct CpuFacts {
    std::string model;
    int cores = 0;  ///< that this program may use
};

struct CodecFact {
    std::string name;  ///< "ffv1 encoder"
    bool present = false;
};

struct FfmpegFacts {
    std::string version;
    std::vector<CodecFact> needed;
};

CpuFacts cpu_facts();
/// Takes a fifth of a second.
TimerFacts timer_facts();
FfmpegFacts ffmpeg_facts();

}  // namespace touchable
