// SPDX-License-Identifier: Apache-2.0
#pragma once

// Haptic devices: made from the text after --device, found where they are plugged in, and measured.
// `make_device` makes a device that its own thread drives (DrivenDevice: thread, limits, reconnection), with
// the given settings: the watchdog that unpowers the device if this process cannot, and callbacks for each
// position and force.
//
//   TRY_ASSIGN(auto watchdog, SafetyWatchdog::start());  // early: it forks
//   TRY_ASSIGN(auto device, make_device("network:port=5710", driven));
//   TRY(device->open());                                 // then as haptic_device.hpp says
//
// `connected_devices` lists the known devices that are plugged in, opens none, and says how to make each
// ready. `watch_device` and `find_stiffness` measure an open device.
//
// The udev rules that permit devices to this machine's user (share/udev/70-touchable.rules) are embedded in
// the program, so that they are available without any other installed file.
//
// Threads: any one thread that does not tick may call these functions; it reads the device that it measures.
// DriveTimes is written by a device's thread and read by another.

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

/// Makes a device from "NAME[:key=value,...]", not opened yet. Refuses (ErrorKind::usage) an unknown name or
/// key and lists the legal ones.
Result<std::unique_ptr<HapticDevice>> make_device(const std::string& description,
                                                  const DrivenSettings& driven);

/// The texts that describe a device, with the keys that each needs: "falcon:firmware=FILE", ...; the last is
/// "simulated", which a scripted hand holds.
std::vector<std::string> device_words();

// ---- What is connected

/// A device that is connected and known.
struct ConnectedDevice {
    std::string place;  ///< "usb 1-2.3", "bluetooth", "other" (HID on an unknown bus)
    std::uint16_t vendor = 0, product = 0;
    std::string name;                    ///< maker and product as the device reports them; untrusted
    std::string what;                    ///< kind of device, for people
    std::string driven;                  ///< argument of --device; empty: it cannot be driven
    std::string why_not;                 ///< why it cannot be driven; empty: it can
    std::string firmware;                ///< its release or how it is loaded; empty: unknown
    std::vector<std::string> nodes{};    ///< its nodes in /dev
    std::string node;                    ///< the node that drives it; empty: none needed or none found
    bool may_use = false;                ///< whether this user may use `node`
    std::vector<std::string> rules{};    ///< udev rules that would permit it to this user; empty: not needed
    std::vector<std::string> held_by{};  ///< programs that have one of its nodes open, as far as visible
    bool ready = false;
    std::string next;  ///< what makes it ready, or an alternative if it cannot be driven; empty: it is ready
};

/// Known devices that are connected by USB or Bluetooth; opens none of them.
std::vector<ConnectedDevice> connected_devices();

/// Lines for people; if none is connected, what to do. `naming` precedes arguments, such as "--device ";
/// `has_rules`: the udev rules are installed.
std::string devices_in_words(const std::vector<ConnectedDevice>& devices, const std::string& naming = "",
                             bool has_rules = false);
/// The arguments of --device, one line each; `with_simulated`: the command that tries a simulated device.
std::string device_words_in_words(const std::string& with_simulated = "");
/// The same as JSON: members named as in ConnectedDevice, ids as "046d:c626", and `words`.
std::string devices_in_json(const std::vector<ConnectedDevice>& devices);

/// The file share/udev/70-touchable.rules as it was when the program was built.
const char* udev_rules();
/// Whether this machine has that file where udev reads it.
bool has_udev_rules();
/// The shell line that permits devices to this machine's user and needs only this program. It is the only
/// text outside player/commands that names an option.
inline constexpr const char* udev_rules_command =
    "touchable devices --udev-rules | sudo tee /etc/udev/rules.d/70-touchable.rules && sudo udevadm control "
    "--reload";

// ---- What a device does, in figures

/// Times at which positions were received and forces sent: written by a device's thread (DrivenSettings),
/// which never waits for a reader, and read by another thread.
struct DriveTimes {
    /// The newest times.
    class Ring {
    public:
        explicit Ring(std::size_t room) : times_(room) {}
        void add(std::int64_t time_ns) {
            const std::size_t count = count_.load(std::memory_order_relaxed);
            times_[count % times_.size()].store(time_ns, std::memory_order_relaxed);
            count_.store(count + 1, std::memory_order_release);
        }
        /// Times in [from_ns, to_ns), in order, as far back as there was room. Entries overwritten during a
        /// read are newer than `to_ns` (now at most): left out.
        std::vector<std::int64_t> within(std::int64_t from_ns, std::int64_t to_ns) const;

    private:
        std::vector<std::atomic<std::int64_t>> times_;
        std::atomic<std::size_t> count_{0};
    };

    explicit DriveTimes(std::size_t room) : received(room), sent(room) {}
    Ring received, sent;
};

/// Pace and clock of a thread that reads a device as the haptic thread does.
struct TickPace {
    std::function<bool()> next_tick;  ///< waits for the next millisecond; false: cancelled
    std::function<std::int64_t()> now_ns;
};

/// The error of a device whose call returned false.
Error failure_of(const HapticDevice& device);

/// Figures of a device that is read a thousand times a second and gets zero forces.
struct WatchFigures {
    /// Statistics of many values; percentiles are actual values (nearest rank). All 0 if there are none.
    struct Percentiles {
        std::int64_t count = 0;
        double median = 0, p99 = 0, greatest = 0;
    };

    /// Motion of a handle that is, or should be, left alone.
    struct Rest {
        static constexpr double moved_m = 0.0005;

        std::int64_t places = 0;
        glm::dvec3 deviation_m{0.0};  ///< standard deviation along each axis
        glm::dvec3 step_m{0.0};       ///< smallest change between successive positions; 0: it never changed
        double farthest_m = 0;        ///< from the mean position
        bool moved() const { return farthest_m > moved_m; }  ///< true: deviations are the hand's, not noise
    };

    double seconds = 0;
    std::int64_t readings = 0;
    std::int64_t without_place = 0;  ///< readings whose first finger had no position
    double reports_per_s = 0;
    Percentiles interval_s;   ///< between successive reports
    Percentiles age_s;        ///< age of the newest position at each reading
    Percentiles going_out_s;  ///< from requesting a force until it was sent
    /// From sending a force to the next report, if no other force was sent between.
    Percentiles until_received_s;
    double longest_call_s = 0;  ///< longest time of the device calls of one tick, reading and writing
    Rest rest;                  ///< first finger, one position for each reading that had a new one
};

/// Reads an open device for `ticks` ticks, while `times` records its reports. Errors: the device failed
/// (ErrorKind::device), cancelled (ErrorKind::interrupted).
Result<WatchFigures> watch_device(HapticDevice& device, const DriveTimes& times, const TickPace& pace,
                                  int ticks);

/// Up to which stiffness a spring about the rest position stays quiet, with no hand on the handle.
struct StiffnessFinding {
    double quiet = 0;       ///< N/m, largest quiet stiffness; 0: none
    double shaking = 0;     ///< N/m, least stiffness that shook; 0: quiet up to the device's limit
    std::string why{};      ///< what the device did at `shaking`
    bool moved = true;      ///< false: friction held the handle against every nudge: no result
    double most_force = 0;  ///< N, limit of the exerted force
};

/// The largest quiet stiffness depends on the delays of this computer and on the individual device, so no
/// table of limits has it. The search gives a safe --max-stiffness before a hand is on a new device's handle.
///
/// Climbs by factors of sqrt(2) from soft to the device's own limit, with at most 1.5 N and at most half of
/// the device's greatest force. Force ends at the first sign of growth and on every exit. `tries` is called
/// with each stiffness (N/m). Refuses (ErrorKind::usage) a device that exerts no force; other errors are
/// those of SpringTrial.
Result<StiffnessFinding> find_stiffness(HapticDevice& device, const TickPace& pace,
                                        const std::function<void(double)>& tries = {});

}  // namespace touchable
