#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "device/drivers/device_driver.hpp"
#include "tests/device/faulty_line.hpp"

namespace touchable::test {

/// --gtest_random_seed, or 17.
unsigned fault_seed();

/// A device that a test plays, at the far end of a line with faults.
class FaultyDevice {
public:
    using Fault = FaultyLine::Fault;

    FaultyDevice(std::string its_name, const FaultyLine::Manner& manner)
        : name(std::move(its_name)), line(manner, time, chance) {}
    FaultyDevice(const FaultyDevice&) = delete;
    FaultyDevice& operator=(const FaultyDevice&) = delete;
    virtual ~FaultyDevice() = default;

    virtual std::unique_ptr<DeviceDriver> driver() = 0;
    /// Each millisecond: its hand is at this angle of a circle that it goes around, rad.
    virtual void live(double angle) = 0;
    /// What a person does who is told this prompt.
    virtual void tend(const std::string&) {}
    /// A fault that no other device has; they come seldom, because it takes long to recover from them.
    virtual void suffer_its_own() { line.begin(Fault::unplugged, 5 * VirtualTime::ms); }
    /// How long ago its word of this place had come, s.
    virtual double age_of(const glm::dvec3& place) { return line.age_of(place); }

    const std::string name;
    VirtualTime time;
    std::mt19937 chance{fault_seed()};
    FaultyLine line;
    std::vector<Fault> faults{Fault::lost,      Fault::late,   Fault::cut,     Fault::damaged,  Fault::twice,
                              Fault::in_pieces, Fault::babble, Fault::refuses, Fault::unplugged};
    bool exerts = true;
};

/// Whole sessions with such a device at 1 kHz in virtual time, from open to close, a hundred faults each at
/// random moments: 10^4 in all, 2,000 in a short run (sweep.hpp), under sanitizers a twentieth. Of each tick
/// it is checked that no force is out that nobody asks for or that answers a place older than promised, and
/// that no such place is read; of each session, that it leaves no force. Prints a line of what came of it,
/// with the longest call of the haptic thread.
void run_fault_sessions(FaultyDevice& device);

/// A hand that presses falls silent for 10 to 100 ms, in virtual time: below 50 ms its force returns by
/// itself, above that only once the finger has been free. It is judged by the last bytes that went out.
void expect_force_after_silence(FaultyDevice& device);

}  // namespace touchable::test
