// SPDX-License-Identifier: Apache-2.0
#include "player/commands/machine_check.hpp"

#include <poll.h>
#include <sys/utsname.h>
#include <termios.h>
#include <unistd.h>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/run_options.hpp"
#include "player/run/run_files.hpp"
#include "player/run/terminal.hpp"

namespace touchable {

namespace {

using Json = nlohmann::ordered_json;

std::string digits_of(double value, int digits = 3) {
    return formatted("%.*g", digits, value);
}

std::string times_in_words(const WatchFigures::Percentiles& of) {
    if (of.count == 0) return "none";
    return digits_of(of.median * 1e3) + " ms at the median, " + digits_of(of.p99 * 1e3) + " ms p99, " +
           digits_of(of.greatest * 1e3) + " ms at worst (" + std::to_string(of.count) + ")";
}

std::string micrometres(const glm::dvec3& metres) {
    return formatted("%.3g %.3g %.3g um", metres.x * 1e6, metres.y * 1e6, metres.z * 1e6);
}

void tell_device(std::ostream& out, const DeviceReport& report) {
    const DeviceCapabilities& can = report.capabilities;
    out << "device    " << printable(report.name) << " (--device " << printable(report.words, 200)
        << "), fingers: " << report.fingers << ", axes sensed: " << can.axes_sensed
        << ", driven: " << can.axes_driven << ", buttons: " << can.buttons << '\n';
    out << "limits    ";
    if (can.axes_driven == 0)
        out << "it exerts no force\n";
    else
        out << digits_of(report.limits.max_force) << " N, " << digits_of(report.limits.max_stiffness / 1000)
            << " N/mm; " << (can.own_watchdog ? "its own watchdog" : "no watchdog of its own that is known")
            << '\n';
    if (!report.prompt.empty()) out << "it says   " << printable(report.prompt, 400) << '\n';
    for (const ConnectedDevice& each : report.connected)
        out << "hardware  " << each.what << " at " << each.place
            << (each.name.empty() ? "" : ", " + in_quotes(each.name))
            << (each.firmware.empty() ? "" : ", " + printable(each.firmware))
            << (each.node.empty() ? "" : ", " + each.node + (each.may_use ? "" : " (not permitted)")) << '\n';
    out << "program   touchable " << report.version << ", " << report.kernel << '\n'
        << "thread    " << report.thread << "; " << counted(report.late_ticks, "tick")
        << " late by a millisecond or more\n";
}

void tell_times(std::ostream& out, const DeviceReport& report) {
    const WatchFigures& watch = report.watch;
    out << "reports   " << digits_of(watch.reports_per_s, 4) << " a second, from one to the next "
        << times_in_words(watch.interval_s);
    if (report.capabilities.rate_hz > 0)
        out << "; it is made for up to " << digits_of(report.capabilities.rate_hz, 4) << " a second";
    out << '\n'
        << "age       of the newest position, at 1 kHz: " << times_in_words(watch.age_s) << '\n'
        << "forces    from being asked for until they had gone out: " << times_in_words(watch.going_out_s)
        << '\n';
    out << (report.capabilities.answers
                ? "answer    round trip, from a force to the position that answers it: "
                : "answer    from a force to the next position, which comes by itself: ");
    out << times_in_words(watch.until_received_s) << '\n'
        << "calls     of the thread that reads and writes, longest " << digits_of(watch.longest_call_s * 1e3)
        << " ms\n";
}

void tell_rest(std::ostream& out, const DeviceReport& report) {
    const WatchFigures::Rest& rest = report.watch.rest;
    out << "places    " << (report.fingers > 1 ? "of the first finger, " : "") << "smallest step (x y z) "
        << micrometres(rest.step_m) << "; ";
    if (rest.moved())
        out << "the handle moved (by " << digits_of(rest.farthest_m * 1e3)
            << " mm), so their noise is not known: let it rest\n";
    else
        out << "noise (standard deviation) " << micrometres(rest.deviation_m) << '\n';
    out << "left out  ";
    if (report.facts.left_out >= 0) out << report.facts.left_out << " reports, ";
    out << report.facts.implausible << " places that cannot be; " << report.watch.without_place << " of "
        << report.watch.readings << " readings had no place; lost " << report.facts.losses << " times\n";
}

void tell_stiffness(std::ostream& out, const DeviceReport& report) {
    out << "stiffness ";
    if (!report.stiffness) {
        out << "not tried: " << printable(report.no_stiffness, 300) << '\n';
        return;
    }
    const StiffnessFinding& found = *report.stiffness;
    if (!found.moved)
        out << "friction held the handle against every nudge, so nothing can be said";
    else if (found.quiet == 0)
        out << "even " << digits_of(found.shaking / 1000) << " N/mm is not quiet: " << found.why;
    else if (found.shaking == 0)
        out << digits_of(found.quiet / 1000) << " N/mm, its own limit, is quiet";
    else
        out << digits_of(found.quiet / 1000) << " N/mm is quiet, " << digits_of(found.shaking / 1000)
            << " N/mm is not: " << found.why;
    out << " (no hand on it, " << digits_of(found.most_force) << " N at most)\n";
}

Json percentiles_json(const WatchFigures::Percentiles& of) {
    return {{"count", of.count},
            {"median", of.median * 1e3},
            {"p99", of.p99 * 1e3},
            {"worst", of.greatest * 1e3}};
}

Json axes_json(const glm::dvec3& metres) {
    return Json::array({metres.x * 1e6, metres.y * 1e6, metres.z * 1e6});
}

Json stiffness_json(const DeviceReport& report) {
    if (!report.stiffness) return {{"not_tried", report.no_stiffness}};
    const StiffnessFinding& found = *report.stiffness;
    return {{"quiet_n_per_mm", found.quiet / 1000},
            {"shaking_n_per_mm", found.shaking > 0 ? Json(found.shaking / 1000) : Json()},
            {"why", found.why},
            {"moved", found.moved},
            {"most_force_n", found.most_force}};
}

Json device_json(const DeviceReport& report) {
    const DeviceCapabilities& can = report.capabilities;
    return {{"words", report.words},
            {"name", report.name},
            {"prompt", report.prompt},
            {"fingers", report.fingers},
            {"axes_sensed", can.axes_sensed},
            {"axes_driven", can.axes_driven},
            {"buttons", can.buttons},
            {"rate_hz", can.rate_hz > 0 ? Json(can.rate_hz) : Json()},
            {"own_watchdog", can.own_watchdog},
            {"answers", can.answers},
            {"max_force_n", report.limits.max_force},
            {"max_stiffness_n_per_mm", report.limits.max_stiffness / 1000},
            {"connected", Json::parse(devices_in_json(report.connected)).at("devices")}};
}

/// An open device and its thread's times.
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
    if (KeyedValues::name_and_pairs(words).first == "simulated")
        return usage_error("--device simulated is computed, so there is nothing to measure");
    ignore_stop_keys();
    TRY_ASSIGN(auto watchdog, SafetyWatchdog::start());
    MeasuredDevice measured;
    DrivenSettings driven;
    driven.watchdog = watchdog;
    driven.as_thread_begins = [] { become_fifo(); };
    driven.on_received = [times = measured.times](std::int64_t moment) { times->received.add(moment); };
    driven.on_sent = [times = measured.times](std::int64_t moment) { times->sent.add(moment); };
    TRY_ASSIGN(measured.device, make_device(words, driven));
    TRY(measured.device->open());
    return measured;
}

/// Waits for the first position; the user may have to home the device or start a program first.
Result<void> wait_for_position(HapticDevice& device, int seconds) {
    std::vector<glm::dvec3> metres(static_cast<std::size_t>(device.fingers()));
    StatusLine line;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
    while (!stop_requested()) {
        if (!device.read_positions(metres)) return failure_of(device);
        if (std::isfinite(metres[0].x + metres[0].y + metres[0].z)) return {};
        const std::string prompt = device.prompt();
        if (std::chrono::steady_clock::now() >= until)
            return device_error(device.name() + ": no position within " + std::to_string(seconds) + " s" +
                                (prompt.empty() ? "" : "; " + prompt) + " (--wait S waits longer)");
        if (line.is_due()) line.show(prompt.empty() ? "waiting for a position" : prompt);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return interrupted_error();
}

/// The haptic thread's pace: a tick every millisecond; missed ticks are not made up for.
class RealPace {
public:
    TickPace pace() {
        return {[this] { return next(); }, boot_ns};
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
        return !stop_requested();
    }
    std::chrono::steady_clock::time_point due_{};
    std::int64_t late_ = 0;
};

/// Runs `work` on a real-time thread like the haptic one; meanwhile shows what `words` returns.
template <class Work, class Words>
auto in_real_time(RealtimeGrant& grant, Work&& work, Words&& words) -> decltype(work()) {
    std::optional<decltype(work())> answer;
    StatusLine line;
    std::atomic<bool> over{false};
    std::thread thread;
    TRY(start_thread(thread, "device-check", "that reads the device", [&] {
        grant = become_realtime();
        answer.emplace(work());
        over = true;
    }));
    while (!over) {
        if (line.is_due()) line.show(words());
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
    auto figures = in_real_time(
        grant, [&] { return watch_device(*measured.device, *measured.times, pace.pace(), seconds * 1000); },
        [&] { return "measuring for " + std::to_string(seconds) + " s: let the handle rest"; });
    if (!figures) return stop_requested() ? interrupted_error() : figures.error();
    report.watch = *figures;
    report.facts = between(before, measured.facts());
    report.thread = grant.in_words();
    report.late_ticks = pace.late();
    report.prompt = measured.device->prompt();
    return {};
}

/// Whether the user at the terminal presses Enter and no other key before it.
bool says_yes() {
    tcflush(STDIN_FILENO, TCIFLUSH);  // earlier input is no answer
    std::cerr << "Take your hand off the handle, and leave it where it stays by itself. Then Enter: springs "
                 "of up to 1.5 N look\nfor the largest stiffness (a minute or less; Ctrl-C ends it at once). "
                 "n and Enter leaves that out. "
              << std::flush;
    char line[64];
    return wait_unless_stopped(STDIN_FILENO, POLLIN) && read(STDIN_FILENO, line, sizeof line) > 0 &&
           line[0] == '\n';
}

/// Why no spring may be tried; empty: allowed.
std::string why_no_spring(const HapticDevice& device, bool hands_off) {
    if (device.capabilities().axes_driven == 0) return "it exerts no force";
    if (hands_off) return {};
    if (isatty(STDIN_FILENO) == 0)
        return "no one was there to take the hand off the handle (--hands-off says that there is none)";
    return says_yes() ? std::string() : "it was left out";
}

/// A failure here becomes part of the report.
Result<void> find_out_stiffness(const MeasuredDevice& measured, bool hands_off, DeviceReport& report) {
    report.no_stiffness = why_no_spring(*measured.device, hands_off);
    if (stop_requested()) return interrupted_error();
    if (!report.no_stiffness.empty()) return {};
    std::atomic<double> tried{0};
    RealtimeGrant grant;
    RealPace pace;
    auto found = in_real_time(
        grant,
        [&] {
            return find_stiffness(*measured.device, pace.pace(), [&](double n_per_m) { tried = n_per_m; });
        },
        [&] { return "trying " + std::to_string(std::lround(tried)) + " N/m, hands off"; });
    if (stop_requested()) return interrupted_error();
    if (!found) {
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
    const auto word_of = [](const std::string& driven) { return KeyedValues::name_and_pairs(driven).first; };
    for (ConnectedDevice& each : connected_devices())
        if (word_of(each.driven) == word_of(words)) report.connected.push_back(std::move(each));
    return report;
}

Result<void> report_to(const DeviceReport& report, const DeviceCheckOptions& options, OutputFile* file) {
    if (!options.json.replaces_words()) std::cout << on_terminal(to_text(report));
    TRY(options.json.write(to_json(report)));
    if (!file) return {};
    TRY(file->write(to_text(report)));
    return file->finish();
}

}  // namespace

std::string without_folders(const std::string& device) {
    std::string told;
    std::istringstream pieces(device);
    for (std::string piece; std::getline(pieces, piece, ',');) {
        const std::size_t slash = piece.find('/');
        if (slash != std::string::npos && piece.compare(slash, 5, "/dev/") != 0) {
            const std::size_t before = piece.find_last_of(":=", slash);
            const std::size_t begin = before == std::string::npos ? 0 : before + 1;
            piece.erase(begin, piece.rfind('/') + 1 - begin);
        }
        told += (told.empty() ? "" : ",") + piece;
    }
    return told;
}

std::string to_text(const DeviceReport& report) {
    std::ostringstream out;
    tell_device(out, report);
    tell_times(out, report);
    tell_rest(out, report);
    tell_stiffness(out, report);
    return out.str();
}

nlohmann::ordered_json to_json(const DeviceReport& report) {
    const WatchFigures& watch = report.watch;
    return {{"touchable_device_check", 1},
            {"version", report.version},
            {"kernel", report.kernel},
            {"device", device_json(report)},
            {"thread", {{"granted", report.thread}, {"late_ticks", report.late_ticks}}},
            {"seconds", watch.seconds},
            {"reports_per_s", watch.reports_per_s},
            {"interval_ms", percentiles_json(watch.interval_s)},
            {"age_ms", percentiles_json(watch.age_s)},
            {"going_out_ms", percentiles_json(watch.going_out_s)},
            {"until_heard_ms", percentiles_json(watch.until_received_s)},
            {"longest_call_ms", watch.longest_call_s * 1e3},
            {"rest",
             {{"places", watch.rest.places},
              {"deviation_um", axes_json(watch.rest.deviation_m)},
              {"step_um", axes_json(watch.rest.step_m)},
              {"farthest_mm", watch.rest.farthest_m * 1e3},
              {"moved", watch.rest.moved()}}},
            {"readings", watch.readings},
            {"without_place", watch.without_place},
            {"left_out", report.facts.left_out >= 0 ? Json(report.facts.left_out) : Json()},
            {"implausible", report.facts.implausible},
            {"losses", report.facts.losses},
            {"stiffness", stiffness_json(report)}};
}

Result<void> run_device_check(const DeviceCheckOptions& options) {
    std::unique_ptr<OutputFile> file;
    if (options.out) {
        TRY(check_outputs({{{"--out", *options.out}}, options.json.existing}, {}));
        TRY_ASSIGN(file, OutputFile::create("--out", *options.out, options.json.existing));
    }
    TRY_ASSIGN(auto measured, take_device(options.device));
    HapticDevice& device = *measured.device;
    TRY(wait_for_position(device, options.wait));
    DeviceReport report = describe(device, options.device);
    TRY(watch(measured, options.seconds, report));
    const auto tried = find_out_stiffness(measured, options.hands_off, report);
    device.close();
    if (!tried && tried.error().kind == ErrorKind::interrupted) return tried;
    TRY(report_to(report, options, file.get()));
    return tried;
}

}  // namespace touchable
