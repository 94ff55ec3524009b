#include "player/commands/device_check_report.hpp"

#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"

namespace touchable {
namespace {

using Json = nlohmann::ordered_json;

std::string digits_of(double value, int digits = 3) {
    return formatted("%.*g", digits, value);
}

std::string times_in_words(const Percentiles& of) {
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
    for (const ConnectedDevice& each : report.connected)
        out << "hardware  " << each.what << " at " << each.place
            << (each.name.empty() ? "" : ", " + in_quotes(each.name))
            << (each.firmware.empty() ? "" : ", " + printable(each.firmware))
            << (each.node.empty() ? "" : ", " + each.node + (each.may_use ? "" : " (not permitted)")) << '\n';
    out << "program   touchable " << report.version << ", " << report.kernel << '\n'
        << "thread    " << report.thread << "; " << report.late_ticks
        << " ticks late by a millisecond or more\n";
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
    const RestFigures& rest = report.watch.rest;
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

Json percentiles_json(const Percentiles& of) {
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

}  // namespace touchable
