#pragma once

// What `touchable check` finds out of a machine: its CPU, timers, codecs and Vulkan devices (machine facts),
// and whether it is fast enough for a clip that a person names (a trial). vulkan_facts runs a kernel on the
// device that would be taken, timer_facts sleeps for a fifth of a second, and try_touch decodes, builds and
// touches a generated clip for some seconds. By one thread; judge and the functions that put facts in words
// or JSON have no state.

#include <cstddef>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/session/run_record.hpp"

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

/// What a person wants of a machine.
struct TouchDemand {
    int width = 720, height = 480;
    int fingers = 1;
    int rate = 30;  ///< frames per second

    /// "720x480 at 30 frames/s with 1 finger"
    std::string in_words() const {
        return std::to_string(width) + "x" + std::to_string(height) + " at " + std::to_string(rate) +
               " frames/s with " + std::to_string(fingers) + (fingers == 1 ? " finger" : " fingers");
    }
};

/// What a short piece of that came to here. Wall times, but for CPU time, which is of all threads.
struct TrialFigures {
    std::string builder;         ///< what `--live` takes for such a clip
    Spread decode_ms, build_ms;  ///< of a frame
    Spread tick_us;              ///< all fingers
    double frame_cpu_ms = 0;     ///< decoding and building
    double tick_cpu_us = 0;      ///< with the hand's own work
    int frames = 0, ticks = 0;   ///< that were measured

    double cpu_ms_per_second(const TouchDemand& demand) const;
    /// Whether frames waited for cores more than they used them: other programs had them.
    bool is_crowded() const { return decode_ms.mean + build_ms.mean > 2 * frame_cpu_ms; }
};

/// Makes a clip of that size in the folder of temporary files (depth of 16 bits and colour), decodes, builds
/// (median 3x3) and touches it, and removes it. Takes seconds.
Result<TrialFigures> try_touch(const TouchDemand& demand);

struct TrialVerdict {
    bool can = false;
    double most_rate = 0;  ///< frames per second, with as many fingers
    std::string why;       ///< what takes longest, and how long it may
};
/// Whether frames are decoded and built as fast as they are due, on a thread each, ticks end before the next
/// one is due, and all of it fits a machine of so many cores with a tenth left for everything else.
TrialVerdict judge(const TouchDemand& demand, const TrialFigures& figures, int cores);

nlohmann::ordered_json trial_json(const TouchDemand& demand, const TrialFigures& figures,
                                  const TrialVerdict& verdict, int cores);
/// The verdict on a plain line, then the figures.
std::string trial_to_text(const TouchDemand& demand, const TrialFigures& figures, const TrialVerdict& verdict,
                          int cores);

}  // namespace touchable
