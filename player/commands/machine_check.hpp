// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measurements of `touchable check`: the machine's CPU, timers, codecs and Vulkan devices (machine facts),
// and whether it is fast enough for a stated size and rate (a trial). vulkan_facts runs a kernel on the
// device that auto takes, timer_facts sleeps for a fifth of a second, and try_touch decodes, builds and
// touches a generated clip for some seconds. run_device_check measures a haptic device. For one thread; judge
// and the functions that make text or JSON have no state.

#include <cstddef>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <span>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/result.hpp"
#include "engine/base/words.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "player/commands/option_types.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// A small kernel (64 Ki words, shaders/self_check.h), run on a device.
struct KernelFacts {
    bool same_bits = false;                 ///< equal to the CPU's in every run
    double first_ms = 0;                    ///< from submission to completion, with the driver's compilation
    double least_ms = 0, p50_ms = 0;        ///< the same for `runs` later runs
    std::optional<double> least_device_ms;  ///< by the device's own timestamps, if it has any
    static constexpr int runs = 50;
};

/// Vulkan devices of this machine.
struct VulkanFacts {
    std::vector<GpuFacts> gpus;
    std::optional<std::size_t> used;  ///< the one that `auto` takes
    std::string unusable;             ///< why none is used, or what failed on it; empty: Vulkan works
    std::optional<KernelFacts> kernel;
};

struct KernelRun {
    double ms = 0;                    ///< from submission to completion
    std::optional<double> device_ms;  ///< nothing: the queue has no timestamps
    bool same_bits = false;
};
/// Combines the first run, with the driver's compilation, and at least one later run.
KernelFacts facts_of(const KernelRun& first, std::span<const KernelRun> later);

/// Opens the device and runs the kernel. Never fails: faults are part of the facts.
VulkanFacts vulkan_facts();

/// Lines of `touchable check`: each device and what it lacks; memory, limits and timings of the used one.
void print_vulkan(std::ostream& out, const VulkanFacts& facts);
nlohmann::ordered_json vulkan_json(const VulkanFacts& facts);

/// Timing conditions of the haptic thread on this machine.
struct TimerFacts {
    double clock_resolution_ns = 0;           ///< of the monotonic clock
    double timer_slack_ns = 0;                ///< oversleep that the kernel allows this thread
    double late_p50_us = 0, late_max_us = 0;  ///< waking from 200 sleeps to a 1 ms grid
    bool realtime_permitted = false;          ///< SCHED_FIFO
};

/// Ways to permit SCHED_FIFO and locked memory to `program`, one per element.
std::vector<std::string> ways_to_realtime(const std::string& user, const std::string& program);
/// The same for the current user and this program.
std::vector<std::string> ways_to_realtime();

struct CpuFacts {
    std::string model;
    int cores = 0;  ///< usable by this program
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

/// Load that a machine is tested for.
struct TouchDemand {
    int width = 720, height = 480;
    int fingers = 1;
    int rate = 30;  ///< frames per second

    /// "720x480 at 30 frames/s with 1 finger"
    std::string in_words() const {
        return size_text(width, height) + " at " + std::to_string(rate) + " frames/s with " +
               counted(fingers, "finger");
    }
};

/// Results of a short trial of a demand. Wall times, except CPU times, which are of all threads.
struct TrialFigures {
    std::string builder;         ///< builder that `--live` takes for such a clip
    Spread decode_ms, build_ms;  ///< per frame
    Spread tick_us;              ///< all fingers
    double frame_cpu_ms = 0;     ///< decoding and building
    double tick_cpu_us = 0;      ///< including the hand's own work
    int frames = 0, ticks = 0;   ///< number measured

    double cpu_ms_per_second(const TouchDemand& demand) const;
    /// Whether frames waited for cores longer than they ran: other programs used the cores.
    bool is_crowded() const { return decode_ms.mean + build_ms.mean > 2 * frame_cpu_ms; }
};

/// Writes a clip of that size (16-bit depth and colour) to the temporary folder, decodes, builds (median 3x3)
/// and touches it, and removes it. Takes seconds.
Result<TrialFigures> try_touch(const TouchDemand& demand);

struct TrialVerdict {
    bool can = false;
    double most_rate = 0;  ///< frames per second with the same number of fingers
    std::string why;       ///< the longest step, its time and its limit
};
/// Whether frames are decoded and built (a thread each) as fast as they are due, ticks end before the next
/// one is due, and everything fits into `cores` cores with a tenth left for other programs.
TrialVerdict judge(const TouchDemand& demand, const TrialFigures& figures, int cores);

nlohmann::ordered_json trial_json(const TouchDemand& demand, const TrialFigures& figures,
                                  const TrialVerdict& verdict, int cores);
/// The verdict on one line, then the figures.
std::string trial_to_text(const TouchDemand& demand, const TrialFigures& figures, const TrialVerdict& verdict,
                          int cores);

/// Measurements of a device, also to attach to a bug report. Contains no names of users or folders.
struct DeviceReport {
    std::string version;  ///< of this program
    std::string kernel;   ///< "Linux 6.1.0-18-amd64 x86_64"
    std::string words;    ///< the value of --device, files without their folders
    std::string name;
    std::string prompt;  ///< what the device says of itself; empty: nothing
    int fingers = 0;
    DeviceLimits limits;
    DeviceCapabilities capabilities;
    std::vector<ConnectedDevice> connected;  ///< devices that these words drive
    std::string thread;                      ///< rights granted to the reading thread
    std::int64_t late_ticks = 0;             ///< of the reading thread, late by 1 ms or more
    WatchFigures watch;
    DrivenFacts facts;  ///< while it was watched
    std::optional<StiffnessFinding> stiffness;
    std::string no_stiffness;  ///< why it was not measured
};

/// "falcon:firmware=/home/ada/novint.bin" as "falcon:firmware=novint.bin"; nodes in /dev stay.
std::string without_folders(const std::string& device);

std::string to_text(const DeviceReport& report);
nlohmann::ordered_json to_json(const DeviceReport& report);

/// Options of a device's measurement, as on the command line.
struct DeviceCheckOptions {
    std::string device;      ///< NAME[:key=value,...]
    int seconds = 5;         ///< duration of watching its reports
    int wait = 30;           ///< seconds to wait for its first position
    bool hands_off = false;  ///< no hand is on it: try springs without asking
    JsonOutput json;
    std::optional<std::filesystem::path> out;  ///< the report in words
};

/// Opens the device and prints its measurements; the largest stiffness only if the user confirms that no hand
/// is on it. Leaves it without force. Fails (ErrorKind::device) if it cannot be opened, has no position in
/// time, or is lost.
Result<void> run_device_check(const DeviceCheckOptions& options);

}  // namespace touchable
