#include "device/device_watch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// Room that is there before the first reading, so that none waits for memory.
struct Readings {
    explicit Readings(std::size_t ticks) {
        ages.reserve(ticks);
        asked_ns.reserve(ticks);
        places.reserve(ticks);
    }
    std::vector<double> ages;
    std::vector<std::int64_t> asked_ns;
    std::vector<glm::dvec3> places;
    std::int64_t without_place = 0, longest_call_ns = 0;
};

Result<void> read_once(HapticDevice& device, const TickPace& pace, std::vector<glm::dvec3>& metres,
                       const std::vector<glm::dvec3>& zeros, std::int64_t& received_ns, Readings& readings) {
    const std::int64_t now = pace.now_ns();
    if (!device.read_positions(metres)) return failure_of(device);
    const double age = device.age_s();
    if (std::isfinite(age)) readings.ages.push_back(age);
    const bool has_place = std::isfinite(metres[0].x + metres[0].y + metres[0].z);
    if (!has_place) ++readings.without_place;
    // A report that is read twice counts once; moments differ by what it takes to ask for them.
    const std::int64_t received = has_place ? now - static_cast<std::int64_t>(age * 1e9) : received_ns;
    if (has_place && (readings.places.empty() || std::abs(received - received_ns) > 100'000))
        readings.places.push_back(metres[0]);
    received_ns = received;
    readings.asked_ns.push_back(pace.now_ns());
    if (!device.write_forces(zeros)) return failure_of(device);
    readings.longest_call_ns = std::max(readings.longest_call_ns, pace.now_ns() - now);
    return {};
}

}  // namespace

Error failure_of(const HapticDevice& device) {
    const auto health = device.health();
    return health.ok() ? Error{ErrorKind::device, device.name() + ": does not answer any more"}
                       : health.error();
}

Result<WatchFigures> watch_device(HapticDevice& device, const DriveTimes& times, const TickPace& pace,
                                  int ticks) {
    Readings readings(static_cast<std::size_t>(ticks));
    std::vector<glm::dvec3> metres(static_cast<std::size_t>(device.fingers()));
    const std::vector<glm::dvec3> zeros(metres.size(), glm::dvec3(0));
    const std::int64_t begin = pace.now_ns();
    std::int64_t received_ns = 0;
    for (int tick = 0; tick < ticks; ++tick) {
        TRY(read_once(device, pace, metres, zeros, received_ns, readings));
        if (!pace.next_tick()) return Error{ErrorKind::interrupted, "stopped while the device was measured"};
    }
    const std::int64_t end = pace.now_ns();
    const auto received = times.received_within(begin, end), sent = times.sent_within(begin, end);
    WatchFigures figures;
    figures.seconds = static_cast<double>(end - begin) * 1e-9;
    figures.readings = ticks;
    figures.without_place = readings.without_place;
    figures.longest_call_s = static_cast<double>(readings.longest_call_ns) * 1e-9;
    const auto intervals = intervals_between(received);
    if (!intervals.empty())
        figures.reports_per_s = static_cast<double>(intervals.size()) /
                                (static_cast<double>(received.back() - received.front()) * 1e-9);
    figures.interval_s = percentiles_of(intervals);
    figures.age_s = percentiles_of(std::move(readings.ages));
    figures.going_out_s = percentiles_of(until_the_next(readings.asked_ns, sent));
    figures.until_received_s = percentiles_of(until_the_next(sent, received));
    figures.rest = rest_of(readings.places);
    return figures;
}

}  // namespace touchable
