// SPDX-License-Identifier: Apache-2.0
#include <stdlib.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>

#include "bench/clocks.hpp"
#include "bench/measured_commit.hpp"
#include "bench/report.hpp"
#include "bench/suite.hpp"
#include "bench/targets.hpp"
#include "engine/base/hand_thresholds.hpp"
#include "engine/base/try.hpp"
#include "engine/gpu/gpu_device.hpp"

namespace touchable {
namespace {

constexpr std::array suites{
    BenchSuite{"touch", "the touch solver: time per tick, accuracy, following, energy, real depth",
               touch_cases, real_targets},
    BenchSuite{"surface", "frames by kernels, by the CPU and by others: time per frame", surface_cases,
               surface_targets},
    BenchSuite{"gpu", "a Vulkan device: its memory, its frames beside the CPU's, and which way costs least",
               gpu_cases},
    BenchSuite{"loop", "hand, device and surface in a closed loop: up to which stiffness it is stable",
               loop_cases},
    BenchSuite{"paper", "the paper's own experiments: spectrum of the force, time of a tick", paper_cases,
               nullptr, conclude_paper},
    BenchSuite{"live", "clips in real time: reading, building, touch, seek, memory", live_cases,
               live_targets},
    BenchSuite{"play", "the window: pictures in time, their cost by stage, from input to picture", play_cases,
               play_targets},
    BenchSuite{"stream", "streams over a network: framesets that come, delay, forces, cost of both ends",
               stream_cases},
    BenchSuite{"targets", "what solver and frames are to reach, and whether they do", target_cases,
               both_targets, conclude_targets},
};

struct Options {
    std::string suite, filter;
    std::optional<std::string> json;
    bool quick = false, list = false;
};

double load_average() {
    double load = 0;
    return getloadavg(&load, 1) == 1 ? load : -1;
}

/// The day, in UTC.
std::string date() {
    const std::time_t now = std::time(nullptr);
    std::array<char, 16> text;
    return {text.data(), std::strftime(text.data(), text.size(), "%F", std::gmtime(&now))};
}

std::string cpu_model() {
    std::ifstream cpuinfo("/proc/cpuinfo");
    for (std::string line; std::getline(cpuinfo, line);)
        if (line.starts_with("model name"))
            if (const auto begin = line.find(": "); begin != std::string::npos) return line.substr(begin + 2);
    return "not named by the kernel";
}

/// What a hand just notices (engine/base/hand_thresholds.hpp): pages that show records draw it.
CaseFigures hand_figures() {
    using namespace hand_thresholds;
    return {"hand",
            {{"direction_seen_deg", seen_degrees, "deg"},
             {"direction_felt_deg", felt_degrees, "deg"},
             {"size_share_pct", 100 * size_share, "%"},
             {"size_from_n", size_from_n, "N"},
             {"size_to_n", size_to_n, "N"}}};
}

/// The machine of this run's times, and the run. The GPU is the one that `auto` takes; omitted without
/// Vulkan.
Figures machine_figures(double load_at_start, bool quick) {
    Figures figures{{"commit", 0, "", false, measured_commit},
                    {"date", 0, "", false, date()},
                    {"quick", quick ? 1.0 : 0.0, "", false},
                    named("cpu", cpu_model()),
                    {"cores", static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN)), ""},
                    {"load_1m_begin", load_at_start, ""},
                    {"load_1m_end", load_average(), ""},
                    {"clock_overhead_ns", clock_costs().monotonic, "ns"},
                    {"thread_clock_overhead_ns", clock_costs().thread_cpu, "ns"}};
    const auto gpus = list_gpus();
    if (!gpus) return figures;
    const auto chosen = choose_gpu(*gpus, "auto");
    if (!chosen) return figures;
    const GpuFacts& gpu = (*gpus)[*chosen];
    figures.push_back(named("gpu", gpu.name));
    figures.push_back(named("gpu_driver", gpu.driver + " " + gpu.driver_info));
    figures.push_back(named("vulkan", gpu.api));
    return figures;
}

Result<const BenchSuite*> find_suite(const std::string& name) {
    std::string known;
    for (const BenchSuite& suite : suites) {
        if (suite.name == name) return &suite;
        known.append(known.empty() ? "" : ", ").append(suite.name);
    }
    return usage_error("suite '" + name + "' is not known; known are " + known);
}

Result<std::vector<BenchCase>> choose_cases(const BenchSuite& suite, const Options& options) {
    std::vector<BenchCase> cases = suite.cases(options.quick);
    std::erase_if(cases,
                  [&](const BenchCase& c) { return c.name.find(options.filter) == std::string::npos; });
    if (cases.empty())
        return usage_error("no case of suite '" + options.suite + "' has '" + options.filter +
                           "' in its name; see touchable-bench " + options.suite + " --list");
    return cases;
}

Result<void> run(const Options& options) {
    TRY_ASSIGN(const auto suite, find_suite(options.suite));
    TRY_ASSIGN(const auto cases, choose_cases(*suite, options));
    if (options.list) {
        for (const BenchCase& c : cases) std::cout << c.name << '\n';
        return {};
    }
    if (options.json)
        if (auto writable = check_writable(*options.json); !writable) return writable;

    const double load_at_start = load_average();
    std::vector<CaseFigures> done;
    for (std::size_t k = 0; k < cases.size(); ++k) {
        const BenchCase& c = cases[k];
        std::cerr << "[" << k + 1 << "/" << cases.size() << "] " << c.name << std::endl;
        done.push_back({c.name, {}});
        if (auto measured = c.measure(done.back().figures); !measured) return measured;
        add_jnd(done.back().figures);
    }
    const CaseFigures machine{"machine", machine_figures(load_at_start, options.quick)};
    std::cout << "commit " << measured_commit << "\n\n"
              << tables_of({machine}) << '\n'
              << tables_of(done) << std::flush;
    const std::vector<Target> none, &targets = suite->targets ? suite->targets() : none;
    if (const auto those = measured_targets(targets, done); !those.empty())
        std::cout << '\n' << table_of(those, done) << std::flush;
    if (options.json) {
        std::vector<CaseFigures> records = records_of(targets, done);
        records.insert(records.begin(), done.begin(), done.end());
        records.insert(records.begin(), {machine, hand_figures()});
        if (auto written = write_report(*options.json, options.suite, records); !written) return written;
    }
    return suite->conclude ? suite->conclude(done) : Result<void>();
}

void print_overview() {
    std::cout << "touchable-bench SUITE [--quick] [--json FILE] [--filter SUBSTRING] [--list]\n\n";
    for (const BenchSuite& suite : suites)
        std::printf("  %-8s%s\n", std::string(suite.name).c_str(), std::string(suite.what).c_str());
}

int fail(const Error& error) {
    std::cerr << "touchable-bench: " << error.message << '\n';
    return exit_code(error.kind);
}

int run_program(int argc, char** argv) {
    CLI::App app{"Measure run time and error.", "touchable-bench"};
    Options options;
    app.set_version_flag("-V,--version", std::string("touchable-bench of commit ") + measured_commit,
                         "print the commit it was built from, and end");
    app.add_option("suite", options.suite, "what to measure; without one, the suites are listed");
    app.add_flag("--quick", options.quick, "the same more coarsely, within a minute");
    app.add_option("--json", options.json, "write the figures to this file too");
    app.add_option("--filter", options.filter, "only cases with this in their name");
    app.add_flag("--list", options.list, "name the cases, measure nothing");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return app.exit(success);
    } catch (const CLI::ParseError& error) {
        return fail(usage_error(std::string(error.what()) + "; see touchable-bench -h"));
    }
    if (options.suite.empty()) {
        print_overview();
        return 0;
    }
    const Result<void> result = run(options);
    return result ? 0 : fail(result.error());
}

int run_or_tell(int argc, char** argv) {
    try {
        return run_program(argc, argv);
    } catch (const std::exception& fault) {
        std::cerr << "touchable-bench: internal fault: " << fault.what() << '\n';
        return exit_code(ErrorKind::internal);
    }
}

}  // namespace
}  // namespace touchable

int main(int argc, char** argv) {
    const int code = touchable::run_or_tell(argc, argv);
    touchable::wait_for_given_up_gpus();
    return code;
}
