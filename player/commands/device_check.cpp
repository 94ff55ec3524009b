#include "player/commands/device_check.hpp"

#include <poll.h>
#include <sys/utsname.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "device/device_catalog.hpp"
#include "device/steady_time.hpp"
#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"
#include "haptics_cpu/realtime.hpp"
#include "player/commands/device_check_report.hpp"
#include "player/commands/device_options.hpp"
#include "player/commands/outputs.hpp"
#include "player/run/interrupt.hpp"
#include "player/run/output_file.hpp"
#include "player/run/progress.hpp"

namespace touchable {
namespace {

/// A device that is open, and what its thread tells.
struct MeasuredDevice {
    static constexpr std::size_t most_times = 1 << 20;

    std::shared_ptr<DriveTimes> times = std::make_shared<DriveTimes>(most_times);
    std::unique_ptr<HapticDevice> device;

    DrivenFacts facts() const {
        const auto* driven = dynamic_cast<const DrivenDevice*>(device.get());
        return driven ? driven->facts() : DrivenFacts{};
    }
};

Result<MeasuredDevice> take_device(const std::string& words) {
    if (words.substr(0, words.find(':')) == "simulated")
        return usage_error("--device simulated is computed, so there is nothing to measure");
    ignore_stop_keys();
    TRY_ASSIGN(auto watchdog, SafetyWatchdog::start());
    MeasuredDevice measured;
    DrivenSettings driven;
    driven.watchdog = watchdog;
    driven.as_thread_begins = [] { become_fifo(); };
    driven.on_received = [times = measured.times](std::int64_t moment) { times->received(moment); };
    driven.on_sent = [times = measured.times](std::int64_t moment) { times->sent(moment); };
    TRY_ASSIGN(auto device, make_device(words, driven));
    measured.device = std::move(device);
    TRY(measured.device->open());
    return measured;
}

/// Until it has a position; a person may have to home it first, or start a program.
Result<void> wait_for_position(HapticDevice& device, int seconds) {
    std::vector<glm::dvec3> metres(static_cast<std::size_t>(device.fingers()));
    StatusLine line;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    while (!interrupted()) {
        if (!device.read_positions(metres)) return failure_of(device);
        if (std::isfinite(metres[0].x + metres[0].y + metres[0].z)) return {};
        const std::string prompt = device.prompt();
        if (std::chrono::steady_clock::now() >= until)
            return Error{ErrorKind::device,
                         device.name() + ": no position within " + std::to_string(seconds) + " s" +
                             (prompt.empty() ? "" : "; " + prompt) + " (--wait S waits longer)"};
        if (line.is_due()) line.show(prompt.empty() ? "waiting for a position" : prompt);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return interrupted_error();
}

/// The haptic thread's time: a tick each millisecond, none made up for.
class RealPace {
public:
    TickPace pace() {
        return {[this] { return next(); }, steady_ns};
    }
    std::int64_t late() const { return late_; }

private:
    bool next() {
        const auto now = std::chrono::steady_clock::now();
        if (due_ == std::chrono::steady_clock::time_point{}) due_ = now;
        due_ += std::chrono::milliseconds(1);
        if (now >= due_ + std::chrono::milliseconds(1)) {
            ++late_;
            due_ = now;
        }
        sleep_until(due_);
        return !interrupted();
    }
    std::chrono::steady_clock::time_point due_{};
    std::int64_t late_ = 0;
};

/// On a thread as the haptic one is; meanwhile `show` is called now and then.
template <class Work, class Show>
auto in_real_time(RealtimeGrant& grant, Work&& work, Show&& show) -> decltype(work()) {
    std::optional<decltype(work())> answer;
    std::atomic<bool> over{false};
    std::thread thread;
    TRY(start_thread(thread, "device-check", "that reads the device", [&] {
        grant = become_realtime();
        answer.emplace(work());
        over = true;
    }));
    while (!over) {
        show();
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    thread.join();
    return std::move(*answer);
}

DrivenFacts between(const DrivenFacts& before, const DrivenFacts& after) {
    return {after.samples - before.samples, after.implausible - before.implausible, after.sent - before.sent,
            after.losses - before.losses,
            after.left_out < 0 ? -1 : after.left_out - std::max<std::int64_t>(before.left_out, 0)};
}

Result<void> watch(const MeasuredDevice& measured, int seconds, DeviceReport& report) {
    const DrivenFacts before = measured.facts();
    RealtimeGrant grant;
    RealPace pace;
    StatusLine line;
    auto figures = in_real_time(
        grant, [&] { return watch_device(*measured.device, *measured.times, pace.pace(), seconds * 1000); },
        [&] {
            if (line.is_due())
                line.show("measuring for " + std::to_string(seconds) + " s: let the handle rest");
        });
    if (!figures.ok()) return interrupted() ? interrupted_error() : figures.error();
    report.watch = *figures;
    report.facts = between(before, measured.facts());
    report.thread = grant.in_words();
    report.late_ticks = pace.late();
    return {};
}

/// Whether a person at the terminal presses Enter, and nothing else before it.
bool says_yes() {
    tcflush(STDIN_FILENO, TCIFLUSH);  // what was typed before is no answer
    std::cerr
        << "Take your hand off the handle, and leave it where it stays by itself. Then Enter: springs of up "
           "to 1.5 N look\nfor the largest stiffness (a minute or less; Ctrl-C ends it at once). n and Enter "
           "leaves that out. "
        << std::flush;
    pollfd input{STDIN_FILENO, POLLIN, 0};
    while (!interrupted()) {
        if (poll(&input, 1, 50) <= 0) continue;
        char line[64];
        const auto typed = read(STDIN_FILENO, line, sizeof line);
        return typed > 0 && line[0] == '\n';
    }
    return false;
}

/// Why no spring may be tried; empty: one may.
std::string why_no_spring(const HapticDevice& device, bool hands_off) {
    if (device.capabilities().axes_driven == 0) return "it exerts no force";
    if (hands_off) return {};
    if (isatty(STDIN_FILENO) == 0)
        return "nobody was there to take the hand off the handle (--hands-off says that there is none)";
    return says_yes() ? std::string() : "it was left out";
}

/// What fails here is part of the report.
Result<void> find_out_stiffness(const MeasuredDevice& measured, bool hands_off, DeviceReport& report) {
    report.no_stiffness = why_no_spring(*measured.device, hands_off);
    if (interrupted()) return interrupted_error();
    if (!report.no_stiffness.empty()) return {};
    std::atomic<double> tried{0};
    RealtimeGrant grant;
    RealPace pace;
    StatusLine line;
    auto found = in_real_time(
        grant,
        [&] {
            return find_stiffness(*measured.device, pace.pace(), [&](double n_per_m) { tried = n_per_m; });
        },
        [&] {
            if (line.is_due()) line.show("trying " + std::to_string(std::lround(tried)) + " N/m, hands off");
        });
    if (interrupted()) return interrupted_error();
    if (!found.ok()) {
        report.no_stiffness = found.error().message;
        return found.error();
    }
    report.stiffness = *found;
    return {};
}

DeviceReport describe(const HapticDevice& device, const std::string& words) {
    DeviceReport report;
    utsname system{};
    uname(&system);
    report.version = TOUCHABLE_VERSION;
    report.kernel = std::string(system.sysname) + " " + system.release + " " + system.machine;
    report.words = without_folders(words);
    report.name = device.name();
    report.fingers = device.fingers();
    report.limits = device.limits();
    report.capabilities = device.capabilities();
    const std::string word = words.substr(0, words.find(':'));
    for (ConnectedDevice& each : connected_devices(ConnectedSystem()))
        if (each.driven.substr(0, each.driven.find(':')) == word) report.connected.push_back(std::move(each));
    return report;
}

Result<void> report_to(const DeviceReport& report, const DeviceCheckOptions& options, OutputFile* file) {
    if (options.json)
        std::cout << to_json(report).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    else
        std::cout << to_text(report);
    if (!file) return {};
    if (auto written = file->write(to_text(report)); !written.ok()) return written;
    return file->finish();
}

}  // namespace

Result<void> run_device_check(const DeviceCheckOptions& options) {
    std::unique_ptr<OutputFile> file;
    if (options.out) {
        if (auto free = check_outputs({{{"--out", *options.out}}, options.existing}, {}); !free.ok())
            return free;
        TRY_ASSIGN(auto created, OutputFile::create("--out", *options.out, options.existing));
        file = std::move(created);
    }
    TRY_ASSIGN(auto measured, take_device(options.device));
    HapticDevice& device = *measured.device;
    if (auto has_one = wait_for_position(device, options.wait); !has_one.ok()) return has_one;
    DeviceReport report = describe(device, options.device);
    if (auto watched = watch(measured, options.seconds, report); !watched.ok()) return watched;
    const auto tried = find_out_stiffness(measured, options.hands_off, report);
    device.close();
    if (!tried.ok() && tried.error().kind == ErrorKind::interrupted) return tried;
    if (auto written = report_to(report, options, file.get()); !written.ok()) return written;
    return tried;
}

}  // namespace touchable
