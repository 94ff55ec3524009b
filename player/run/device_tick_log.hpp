#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptics_cpu/spsc_ring.hpp"
#include "player/run/output_sink.hpp"

namespace touchable {

/// A tick as a device had it.
struct DeviceTick {
    std::int64_t tick = 0;
    std::uint32_t buttons = 0;
    double age_s = 0;                       ///< of the positions
    bool exerts = false;                    ///< forces were on, and not kept back
    std::span<const glm::dvec3> places{};   ///< device metres, not a number where there was none
    std::span<const glm::dvec3> newtons{};  ///< as given to the device
};

/// Ticks of a device on their way from the haptic thread to a file.
class DeviceTickLog {
public:
    DeviceTickLog(int ticks, int fingers);

    /// Haptic thread; neither waits nor allocates. One for which there is no room is lost, and counted.
    void push(const DeviceTick& tick);
    /// Reader. Hands the oldest tick to `take`; false where there is none.
    template <class Take>
    bool pop(const Take& take) {
        return ring_.pop([&take](const Slot& slot) { take(slot.tick); });
    }
    std::int64_t lost() const { return lost_.load(std::memory_order_relaxed); }

private:
    struct Slot {
        DeviceTick tick;
        std::vector<glm::dvec3> places, newtons;
    };
    static std::vector<Slot> slots_for(int ticks, int fingers);

    SpscRing<Slot> ring_;
    std::atomic<std::int64_t> lost_{0};
};

/// `--device-log FILE`, or `-`: a row for each tick and finger (docs/devices.md, Logs). Replays as a device.
class DeviceLogFile final : public OutputSink {
public:
    /// `log` outlives it. Only live runs have one. `name`: as OutputFile has it, here and wherever one is
    /// made.
    static Result<std::unique_ptr<DeviceLogFile>> create(const std::filesystem::path& file, Existing existing,
                                                         DeviceTickLog& log, std::string name);
    /// Gives the file its name, as OutputFile does. Error: ticks are missing.
    Result<void> finish();

private:
    DeviceLogFile(std::unique_ptr<OutputFile> file, DeviceTickLog& log)
        : OutputSink(std::move(file)), log_(log) {}
    /// All that has come by now.
    Result<void> write(const TouchTick&) override;

    DeviceTickLog& log_;
    std::string rows_;
};

}  // namespace touchable
