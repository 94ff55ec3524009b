#pragma once

// Devices that a person holds: made by what is written behind --device, found where they are plugged in, and
// measured. `make_device` makes a device that a thread of its own drives (DrivenDevice: thread, limits,
// reconnection), with the settings given: the watchdog that leaves it unpowered when this process cannot,
// callbacks for each position and force.
//
//   TRY_ASSIGN(auto watchdog, SafetyWatchdog::start());  // early: it forks
//   TRY_ASSIGN(auto device, make_device("network:port=5710", driven));
//   TRY(device->open());                                 // then as haptic_device.hpp says
//
// `connected_devices` lists what is plugged in and known, opens none of it, and says what makes it ready.
// `watch_device` and `find_stiffness` measure an open device.
//
// The rules of udev that permit devices to this machine's user (share/udev/70-touchable.rules) are part of
// the program, so that they can be had where nothing else of it is installed.
//
// Threads: all of it may be called by any one thread, but by none that ticks; what is measured is read by the
// thread that calls. DriveTimes is written by a device's thread and read by another.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <string>
#include <vector>

#include "device/drivers/driven_device.hpp"
#include "device/drivers/safety_watchdog.hpp"

namespace touchable {

/// Of "NAME[:key=value,...]", not opened yet. Refuses (ErrorKind::usage) an unknown name or key with the
/// legal ones.
Result<std::unique_ptr<HapticDevice>> make_device(const std::string& description,
                                                  const DrivenSettings& driven);

/// What describes a device, with the keys that it needs: "falcon:firmware=FILE", ...; the last one is
/// "simulated", which a scripted hand holds.
std::vector<std::string> device_words();

// ---- What is connected

/// A device that is connected and known.
struct ConnectedDevice {
    std::string place;  ///< "usb 1-2.3", "bluetooth", "other" (HID of no bus that is known)
    std::uint16_t vendor = 0, product = 0;
    std::string name;                  ///< the device's own words, from outside
    std::string what;                  ///< for people
    std::string driven;                ///< what to write behind --device; empty: it cannot be driven
    std::string why_not;               ///< it cannot be driven; empty: it can
    std::string firmware;              ///< what shows of it; empty: nothing
    std::vector<std::string> nodes{};  ///< its nodes in /dev
    std::string node;                  ///< the node that drives it; empty: it needs none, or there is none
    bool may_use = false;              ///< that node, by this user
    std::vector<std::string> rules{};  ///< of udev, that would permit it to this user; empty: it may be used
    std::vector<std::string> held_by{};  ///< programs that have one of its nodes open, as far as it shows
    bool ready = false;
    std::string next;  ///< the one line that makes it ready, or helps where it cannot be driven; empty: ready
};

/// All that are connected and known, by USB and Bluetooth; opens none of them.
std::vector<ConnectedDevice> connected_devices();

/// For a person: lines; with none connected one, which says what to do.
std::string devices_in_words(const std::vector<ConnectedDevice>& devices, const std::string& naming = "");
/// Every word that --device takes, a line each, and how to begin; `with_simulated`: the command that does
/// with a simulated one.
std::string device_words_in_words(const std::string& with_simulated = "");
/// The same as JSON, with members named as above, ids as "046d:c626", and `words`.
std::string devices_in_json(const std::vector<ConnectedDevice>& devices);

/// The file share/udev/70-touchable.rules as it was when the program was built.
const char* udev_rules();
/// The line that permits devices to this machine's user, with nothing but this program. It is the only text
/// outside player/commands that names an option.
inline constexpr const char* udev_rules_command =
    "touchable devices --udev-rules | sudo tee /etc/udev/rules.d/70-touchable.rules && sudo udevadm control "
    "--reload";

// ---- What a device does, in figures

/// When positions came and forces went out: written by a device's thread (DrivenSettings), which it never
/// keeps waiting, read by another.
class DriveTimes {
public:
    explicit DriveTimes(std::size_t room) : received_(room), sent_(room) {}

    void received(std::int64_t time_ns) { received_.add(time_ns); }
    void sent(std::int64_t time_ns) { sent_.add(time_ns); }

    /// Those from one moment to before another, in order, as far as there was room.
    std::vector<std::int64_t> received_within(std::int64_t from_ns, std::int64_t to_ns) const {
        return received_.within(from_ns, to_ns);
    }
    std::vector<std::int64_t> sent_within(std::int64_t from_ns, std::int64_t to_ns) const {
        return sent_.within(from_ns, to_ns);
    }

private:
    /// The newest of them; a reader takes what was there when it began, and leaves out what was overwritten.
    class Ring {
    public:
        explicit Ring(std::size_t room) : times_(room) {}
        void add(std::int64_t time_ns) {
            const std::size_t count = count_.load(std::memory_order_relaxed);
            times_[count % times_.size()].store(time_ns, std::memory_order_relaxed);
            count_.store(count + 1, std::memory_order_release);
        }
        std::vector<std::int64_t> within(std::int64_t from_ns, std::int64_t to_ns) const;

    private:
        std::vector<std::atomic<std::int64_t>> times_;
        std::atomic<std::size_t> count_{0};
    };
    Ring received_, sent_;
};

/// The time of a thread that reads a device, as the haptic thread does.
struct TickPace {
    std::function<bool()> next_tick;  ///< waits for the next millisecond; false: give up
    std::function<std::int64_t()> now_ns;
};

/// Why a device's call returned false.
Error failure_of(const HapticDevice& device);

/// What a device does while a reader asks it a thousand times a second and asks for no force.
struct WatchFigures {
    /// Of many values; percentiles are values that were there (nearest rank). All 0 where there were none.
    struct Percentiles {
        std::int64_t count = 0;
        double median = 0, p99 = 0, greatest = 0;
    };

    /// A handle that is left alone, or is meant to be.
    struct Rest {
        static constexpr double moved_m = 0.0005;

        std::int64_t places = 0;
        glm::dvec3 deviation_m{0.0};  ///< standard deviation along each axis
        glm::dvec3 step_m{0.0};       ///< smallest change from a place to the next; 0: it never changed
        double farthest_m = 0;        ///< from the mean place
        bool moved() const { return farthest_m > moved_m; }  ///< then deviations tell of the hand
    };

    double seconds = 0;
    std::int64_t readings = 0;
    std::int64_t without_place = 0;  ///< readings whose first finger had no position
    double reports_per_s = 0;
    Percentiles interval_s;   ///< from a report to the next
    Percentiles age_s;        ///< of the newest position, at a reading
    Percentiles going_out_s;  ///< from asking for a force until it was sent
    /// From a force that had gone out to the next report, where no other went between.
    Percentiles until_received_s;
    double longest_call_s = 0;  ///< that the reader gave to the device in one tick, reading and writing
    Rest rest;                  ///< first finger, a place for each reading that had a new one
};

/// Reads it so many ticks. It is open, `times` receives when its reports come. Error: it failed
/// (ErrorKind::device); given up (ErrorKind::interrupted).
Result<WatchFigures> watch_device(HapticDevice& device, const DriveTimes& times, const TickPace& pace,
                                  int ticks);

/// Up to which stiffness a spring about the place of rest stays quiet, with no hand on the handle.
struct StiffnessFinding {
    double quiet = 0;       ///< N/m, the largest that was quiet; 0: none was
    double shaking = 0;     ///< N/m, the least that was not; 0: all were quiet, up to the device's limit
    std::string why{};      ///< what that one did
    bool moved = true;      ///< false: friction held the handle against every nudge, which says nothing
    double most_force = 0;  ///< N, that was exerted at most
};

/// Why it is here: the largest stiffness that stays quiet depends on the delays of this computer and on this
/// very device, so no table of limits has it. A person with a new device gets a safe --max-stiffness before a
/// hand is on the handle.
///
/// Climbs in steps of a factor of sqrt(2), from soft to the device's own limit, with 1.5 N or half of the
/// device's longest force at most; force ends at the first sign of growth, and with the search however it
/// ends. `tries` is called with each stiffness (N/m). Refuses (ErrorKind::usage) a device that exerts no
/// force; other errors are those of SpringTrial.
Result<StiffnessFinding> find_stiffness(HapticDevice& device, const TickPace& pace,
                                        const std::function<void(double)>& tries = {});

}  // namespace touchable
