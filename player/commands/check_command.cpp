// SPDX-License-Identifier: Apache-2.0
// Commands that tell what this machine has: its speed, and the cameras and haptic devices that are plugged
// in.
#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/camera/camera.hpp"
#include "engine/content/scenes.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "player/commands/machine_check.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {
namespace {

/// Times and results of all builders for one generated frame.
struct BuilderFacts {
    std::string scene;
    int width = 0, height = 0;
    double reference_ms = 0, cpu_ms = 0, lazy_ms = 0;  ///< lazy: all pixels read
    std::optional<double> vulkan_ms;                   ///< nothing: no usable GPU
    bool identical = false;  ///< codes, validity and bounds; for the lazy one depths
};

/// Milliseconds that the work takes.
template <class Work>
Result<double> timed(const Work& work) {
    if (stop_requested()) return interrupted_error();
    const auto start = std::chrono::steady_clock::now();
    TRY(work());
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

Result<BuilderFacts> builder_facts(const char* name) {
    SceneOptions options;
    options.bits = 8;
    TRY_ASSIGN(auto source, make_scene(name, options));
    Scene scene = source->scene();
    scene.filter = {5, 2};
    scene.depth.invalid_codes[0] = 0;  // makes holes to fill
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    const RawFrame raw = source->frame(0);

    BuilderFacts facts{name, scene.width, scene.height, 0, 0, 0, std::nullopt, false};
    SurfaceFrame reference, cpu, lazy, vulkan;
    bool same_lazily = false;
    TRY_ASSIGN(facts.reference_ms,
               timed([&] { return make_reference_builder(scene)->build(raw, reference); }));
    TRY_ASSIGN(facts.cpu_ms, timed([&] { return make_cpu_builder(scene)->build(raw, cpu); }));
    const auto lazy_builder = make_lazy_builder(scene);  // its frames read pixels from it, so keep it
    TRY_ASSIGN(facts.lazy_ms, timed([&]() -> Result<void> {
                   TRY(lazy_builder->build(raw, lazy));
                   same_lazily = same_depths(lazy, reference);
                   return {};
               }));
    if (stop_requested()) return interrupted_error();
    facts.identical = same_lazily && same_bits(cpu, reference);
    if (const auto device = GpuDevice::open(); device) {
        TRY_ASSIGN(auto builder, make_vulkan_builder(scene, *device));
        TRY(builder->build(raw, vulkan));  // compiles the kernels
        TRY_ASSIGN(facts.vulkan_ms, timed([&] { return builder->build(raw, vulkan); }));
        facts.identical = facts.identical && same_bits(vulkan, reference);
    }
    return facts;
}

struct MachineReport {
    CpuFacts cpu;
    TimerFacts timer;
    FfmpegFacts ffmpeg;
    VulkanFacts vulkan;
    std::vector<BuilderFacts> builders;

    std::vector<std::string> faults() const {
        std::vector<std::string> found;
        for (const CodecFact& codec : ffmpeg.needed)
            if (!codec.present) found.push_back("FFmpeg here has no " + codec.name);
        for (const BuilderFacts& facts : builders)
            if (!facts.identical) found.push_back("the builders differ on " + facts.scene);
        // A missing device is no fault, because the CPU does the same work; a device that computes wrongly
        // is.
        if (vulkan.used && !vulkan.unusable.empty()) found.push_back(vulkan.unusable);
        return found;
    }
};

void print_cpu(const CpuFacts& cpu) {
    std::cout << "cpu       " << cpu.model << ", " << cpu.cores << " cores\n";
}

void print_realtime(const TimerFacts& timer) {
    std::cout << "wake-up   " << timer.late_p50_us << " us late at the median, " << timer.late_max_us
              << " us at worst, of 200 sleeps to a 1 ms grid\n"
              << "realtime  SCHED_FIFO is " << (timer.realtime_permitted ? "permitted\n" : "not permitted");
    if (timer.realtime_permitted) return;
    std::cout << ", so that ticks are late while others compute; it is permitted by one of\n";
    for (const std::string& way : ways_to_realtime()) std::cout << "          - " << way << '\n';
}

void print_machine(const MachineReport& report) {
    print_cpu(report.cpu);
    std::cout << "clock     " << report.timer.clock_resolution_ns << " ns resolution, "
              << report.timer.timer_slack_ns / 1000.0 << " us timer slack\n";
    print_realtime(report.timer);
    std::cout << "ffmpeg    " << report.ffmpeg.version << ':';
    for (const CodecFact& codec : report.ffmpeg.needed)
        std::cout << (&codec == &report.ffmpeg.needed.front() ? " " : ", ") << (codec.present ? "" : "NO ")
                  << codec.name;
    std::cout << std::endl;
}

void print_builders(const BuilderFacts& facts) {
    std::cout << "builders  " << facts.scene << ' ' << facts.width << "x" << facts.height << ": cpu "
              << facts.cpu_ms << " ms, reference " << facts.reference_ms << " ms, lazy " << facts.lazy_ms
              << " ms (every pixel)";
    if (facts.vulkan_ms) std::cout << ", vulkan " << *facts.vulkan_ms << " ms";
    std::cout << "; " << (facts.identical ? "the same bits" : "DIFFERENT bits") << std::endl;
}

nlohmann::ordered_json timer_json(const TimerFacts& timer) {
    nlohmann::ordered_json out{{"clock_resolution_ns", timer.clock_resolution_ns},
                               {"timer_slack_ns", timer.timer_slack_ns},
                               {"late_p50_us", timer.late_p50_us},
                               {"late_max_us", timer.late_max_us},
                               {"realtime_permitted", timer.realtime_permitted}};
    if (!timer.realtime_permitted) out["ways_to_realtime"] = ways_to_realtime();
    return out;
}

nlohmann::ordered_json to_json(const MachineReport& report, const std::vector<std::string>& faults) {
    using nlohmann::ordered_json;
    ordered_json out{{"touchable_check", 1}};
    out["cpu"] = {{"model", report.cpu.model}, {"cores", report.cpu.cores}};
    out["timer"] = timer_json(report.timer);
    out["ffmpeg"] = {{"version", report.ffmpeg.version}, {"needed", ordered_json::object()}};
    for (const CodecFact& codec : report.ffmpeg.needed) out["ffmpeg"]["needed"][codec.name] = codec.present;
    out["vulkan"] = vulkan_json(report.vulkan);
    out["builders"] = ordered_json::array();
    for (const BuilderFacts& facts : report.builders)
        out["builders"].push_back(
            {{"scene", facts.scene},
             {"width", facts.width},
             {"height", facts.height},
             {"cpu_ms", facts.cpu_ms},
             {"reference_ms", facts.reference_ms},
             {"lazy_ms", facts.lazy_ms},
             {"vulkan_ms", facts.vulkan_ms ? nlohmann::json(*facts.vulkan_ms) : nlohmann::json()},
             {"identical", facts.identical}});
    out["ready"] = faults.empty();
    out["faults"] = faults;
    return out;
}

/// Gathers the facts one by one; if `tell`, prints each as soon as it is known.
Result<MachineReport> look_around(bool tell) {
    MachineReport report{cpu_facts(), timer_facts(), ffmpeg_facts(), {}, {}};
    if (tell) print_machine(report);
    if (stop_requested()) return interrupted_error();
    report.vulkan = vulkan_facts();
    if (tell) print_vulkan(std::cout, report.vulkan);
    for (const char* scene : {"globe", "noise"}) {
        TRY_ASSIGN(auto facts, builder_facts(scene));
        if (tell) print_builders(facts);
        report.builders.push_back(std::move(facts));
    }
    return report;
}

Result<void> answer(const TouchDemand& demand, const JsonOutput& json) {
    TRY_ASSIGN(const auto figures, try_touch(demand));
    const CpuFacts cpu = cpu_facts();
    const TimerFacts timer = timer_facts();
    const TrialVerdict verdict = judge(demand, figures, cpu.cores);
    auto out = trial_json(demand, figures, verdict, cpu.cores);
    out["timer"] = timer_json(timer);
    if (!json.replaces_words()) {
        std::cout << trial_to_text(demand, figures, verdict, cpu.cores);
        print_cpu(cpu);
        print_realtime(timer);
    }
    TRY(json.write(out));
    if (verdict.can) return {};
    return Error{ErrorKind::check, demand.in_words() + " is too much for this machine: " + verdict.why};
}

struct CheckWords {
    DeviceCheckOptions device;  ///< its `json` is that of all checks
    TouchDemand demand;
    std::string size = "720x480";
};

void add_device_options(CLI::App& check, DeviceCheckOptions& options) {
    begin_topic(check, "Device");
    auto* device = add_file_option(check, "--device", options.device,
                                   "measure a haptic device instead: its reports, their age and noise, and "
                                   "the stiffness that it bears. It takes :key=value,... (docs/devices.md)")
                       ->type_name(type_with_words("DEVICE", device_words()));
    add_whole_option(check, "--seconds", options.seconds, "how long to watch the reports of --device", 1, 600)
        ->type_name("SECONDS")
        ->capture_default_str()
        ->needs(device);
    add_whole_option(check, "--wait", options.wait, "how long to wait for the first position of --device", 1,
                     3600)
        ->type_name("SECONDS")
        ->capture_default_str()
        ->needs(device);
    check
        .add_flag("--hands-off", options.hands_off,
                  "try springs without asking: no hand is on the handle of --device")
        ->needs(device);
    add_file_option(check, "--out", options.out,
                    "write the report on --device to a file, to attach to a bug report")
        ->needs(device);
}

/// Prints the facts of this machine and whether it suffices: CPU, timers, codecs, Vulkan, and the builders
/// compared bit for bit. Fails (ErrorKind::check) if clips cannot be read or written, if a Vulkan device
/// computes wrongly (no device is no fault), or if builders differ. With a demand: a short trial, which fails
/// if this machine is too slow. With a device: run_device_check.
Result<void> run_check(CheckWords words, bool has_demand) {
    const JsonOutput& json = words.device.json;
    const bool has_device = !words.device.device.empty();
    if (has_device && has_demand)
        return usage_error("--device is checked alone; --size, --fingers and --rate ask for a clip");
    if (has_demand) {
        TRY_ASSIGN(const auto size, read_pixel_size("--size", words.size, 16, 8192));
        words.demand.width = size.width;
        words.demand.height = size.height;
    }
    TRY(json.check());
    if (has_device) return run_device_check(words.device);
    if (has_demand) return within_memory("frames of that size", [&] { return answer(words.demand, json); });
    TRY_ASSIGN(const auto report, look_around(!json.replaces_words()));
    const std::vector<std::string> faults = report.faults();
    if (!json.replaces_words())
        std::cout << "verdict   " << (faults.empty() ? "ready" : "not ready")
                  << (report.vulkan.unusable.empty() ? "\n" : ", without Vulkan\n");
    TRY(json.write(to_json(report, faults)));
    if (faults.empty()) return {};
    return Error{ErrorKind::check, faults.front() + (faults.size() > 1 ? "; and more, listed above" : "")};
}

std::string how_to_touch(const std::string& camera, const std::string& with_colour) {
    std::string lines = "    touch it:  touchable touch --live --camera " + camera + '\n';
    if (!with_colour.empty())
        lines += "    see it in its colour, and touch it:  touchable play --camera " + with_colour + '\n';
    return lines;
}

Result<void> run_cameras(const JsonOutput& json) {
    TRY(json.check());
    const auto system = system_video();
    if (!json.replaces_words()) std::cout << on_terminal(cameras_in_words(*system, how_to_touch));
    return json.write(nlohmann::ordered_json::parse(cameras_in_json(*system)));
}

struct DevicesOptions {
    JsonOutput json;
    bool rules = false;
};

Result<void> run_devices(const DevicesOptions& options) {
    if (options.rules) {
        std::cout << udev_rules();
        return {};
    }
    TRY(options.json.check());
    const auto devices = connected_devices();
    if (!options.json.replaces_words())
        std::cout << on_terminal(
            devices_in_words(devices, "--device ", has_udev_rules()) +
            "\nWhat --device takes (docs/devices.md has each one's keys):\n" +
            device_words_in_words("touchable touch CLIP --live --device simulated --hand stroke") +
            "See whether it works:  touchable check --device NAME\n"
            "Touch with it:         touchable touch CLIP --live --device NAME\n");
    return options.json.write(nlohmann::ordered_json::parse(devices_in_json(devices)));
}

}  // namespace

void add_check_command(CLI::App& app, Command& command) {
    auto* check =
        app.add_subcommand("check", "say what this machine can do, or measure what a haptic device does");
    auto words = std::make_shared<CheckWords>();
    begin_topic(*check, "Machine");
    add_json_option(*check, words->device.json, "print the same as JSON");
    check->add_option("--size", words->size, "can it touch a clip of this size in pixels?")
        ->type_name("WxH")
        ->capture_default_str();
    add_whole_option(*check, "--fingers", words->demand.fingers, "with so many fingers?", 1, 256)
        ->capture_default_str();
    add_whole_option(*check, "--rate", words->demand.rate, "at so many frames per second?", 1, 1000)
        ->capture_default_str();
    add_device_options(*check, words->device);
    set_work(*check, command, [words, check] {
        return run_check(*words,
                         check->count("--size") + check->count("--fingers") + check->count("--rate") > 0);
    });
}

void add_cameras_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("cameras", "list the cameras that are plugged in, and how to touch them");
    auto json = std::make_shared<JsonOutput>();
    add_json_option(*sub, *json, "print the same as JSON");
    set_work(*sub, command, [json] { return run_cameras(*json); });
}

void add_devices_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("devices", "list the haptic devices that are plugged in, ready or not, and why");
    auto options = std::make_shared<DevicesOptions>();
    auto* json = add_json_option(*sub, options->json, "print the same as JSON");
    sub->add_flag("--udev-rules", options->rules,
                  "print the file for /etc/udev/rules.d that permits them to the person at the machine")
        ->excludes(json);
    set_work(*sub, command, [options] { return run_devices(*options); });
}

}  // namespace touchable
