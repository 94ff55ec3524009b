#include "player/check_command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "player/builder_facts.hpp"
#include "player/interrupt.hpp"
#include "player/machine_facts.hpp"
#include "player/vulkan_facts.hpp"
#include "player/vulkan_report.hpp"

namespace touchable {
namespace {

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
        // No device is no fault, the CPU does the same work; one that does not do as it says is.
        if (vulkan.used && !vulkan.unusable.empty()) found.push_back(vulkan.unusable);
        return found;
    }
};

void print_machine(const MachineReport& report) {
    std::cout << "cpu       " << report.cpu.model << ", " << report.cpu.cores << " cores\n"
              << "clock     " << report.timer.clock_resolution_ns << " ns resolution, "
              << report.timer.timer_slack_ns / 1000.0 << " us timer slack\n"
              << "wake-up   " << report.timer.late_p50_us << " us late at the median, "
              << report.timer.late_max_us << " us at worst, of 200 sleeps to a 1 ms grid\n"
              << "realtime  SCHED_FIFO is " << (report.timer.realtime_permitted ? "" : "not ")
              << "permitted\n"
              << "ffmpeg    " << report.ffmpeg.version << ':';
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

void print_verdict(const MachineReport& report, const std::vector<std::string>& faults) {
    std::cout << "verdict   " << (faults.empty() ? "ready" : "not ready")
              << (report.vulkan.unusable.empty() ? "\n" : ", without Vulkan\n");
}

void print_json(const MachineReport& report, const std::vector<std::string>& faults) {
    using nlohmann::ordered_json;
    ordered_json out;
    out["cpu"] = {{"model", report.cpu.model}, {"cores", report.cpu.cores}};
    out["timer"] = {{"clock_resolution_ns", report.timer.clock_resolution_ns},
                    {"timer_slack_ns", report.timer.timer_slack_ns},
                    {"late_p50_us", report.timer.late_p50_us},
                    {"late_max_us", report.timer.late_max_us},
                    {"realtime_permitted", report.timer.realtime_permitted}};
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
    std::cout << out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
}

/// Finds out one thing after the other, and says each (as text) as soon as it is known.
Result<MachineReport> look_around(bool tell) {
    MachineReport report{cpu_facts(), timer_facts(), ffmpeg_facts(), {}, {}};
    if (tell) print_machine(report);
    if (interrupted()) return interrupted_error();
    report.vulkan = vulkan_facts();
    if (tell) print_vulkan(std::cout, report.vulkan);
    for (const char* scene : {"globe", "noise"}) {
        auto facts = builder_facts(scene);
        if (!facts.ok()) return facts.error();
        if (tell) print_builders(*facts);
        report.builders.push_back(std::move(*facts));
    }
    return report;
}

}  // namespace

Result<void> run_check(const CheckOptions& options) {
    const auto report = look_around(!options.json);
    if (!report.ok()) return report.error();
    const std::vector<std::string> faults = report->faults();
    options.json ? print_json(*report, faults) : print_verdict(*report, faults);
    if (faults.empty()) return {};
    return Error{ErrorKind::check, faults.front() + (faults.size() > 1 ? "; and more, listed above" : "")};
}

void add_check_command(CLI::App& app, Command& command) {
    auto* check = app.add_subcommand("check", "say what this machine is and whether it can do the work");
    auto options = std::make_shared<CheckOptions>();
    check->add_flag("--json", options->json, "the same as JSON");
    check->callback([options, &command] { command = [options] { return run_check(*options); }; });
}

}  // namespace touchable
