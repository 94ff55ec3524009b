#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "device/drivers/spacemouse_device.hpp"
#include "device/drivers/woodenhaptics_device.hpp"
#include "tests/device/fault_sessions.hpp"
#include "tests/device/wooden_bench.hpp"

namespace touchable::test {
namespace {

Error pulled_out() {
    return {ErrorKind::device, "fake: unplugged"};
}

/// Reports to and from a device that a test plays.
class FaultyReports final : public ReportTransport {
public:
    using Hear = std::function<void(std::span<const std::byte>)>;

    FaultyReports(FaultyLine& line, Hear hear) : line_(line), hear_(std::move(hear)) {}
    Result<void> send(std::span<const std::byte> report) override {
        if (!line_.passes()) return pulled_out();
        hear_(report);
        return {};
    }
    Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override {
        if (line_.is_cut()) return pulled_out();
        const auto came = line_.next(patience);
        if (line_.is_cut()) return pulled_out();
        if (!came) return std::size_t{0};
        const std::size_t bytes = std::min(room.size(), came->size());
        std::copy_n(came->begin(), bytes, room.begin());
        return bytes;
    }

private:
    FaultyLine& line_;
    const Hear hear_;
};

using Opened = Result<std::unique_ptr<ReportTransport>>;

/// A WoodenHaptics. Now and then its board is reset: its counters are none, and its button's lamp is on.
class FaultyWooden final : public FaultyDevice {
public:
    FaultyWooden() : FaultyDevice("woodenhaptics", {.longest_force = 2000}) { board_.silent = true; }

    std::unique_ptr<DeviceDriver> driver() override {
        board_.pressed = false;
        return std::make_unique<WoodenHapticsDriver>(
            build_, false,
            [this]() -> Opened {
                if (line.is_cut()) return pulled_out();
                line.clear();
                return std::unique_ptr<ReportTransport>(std::make_unique<FaultyReports>(
                    line, [this](std::span<const std::byte> report) { hear(report); }));
            },
            [this] { return time.now_ns(); });
    }
    void live(double angle) override {
        board_.counters = {0, 0, 6000, 0, 0, 0};  // home, where it stays while its button is pressed
        if (board_.pressed) return;
        board_.counters[0] = static_cast<int>(std::lround(450 * std::sin(angle)));
        board_.counters[2] += static_cast<int>(std::lround(450 * std::cos(angle)));
    }
    void tend(const std::string& prompt) override { board_.pressed = board_.pressed || !prompt.empty(); }
    void suffer_its_own() override { board_.pressed = true; }

private:
    void hear(std::span<const std::byte> report) {
        FakeWire nobodys;
        board_.hear(nobodys, Bytes(report.begin(), report.end()));
        int longest = 0;
        for (const int current : board_.milliamperes) longest = std::max(longest, std::abs(current));
        line.went_out(longest);
        std::array<std::int16_t, 3> counts{};
        for (std::size_t joint = 0; joint < 3; ++joint)
            counts[joint] = static_cast<std::int16_t>(board_.counters[joint]);
        const glm::dvec3 place = wooden_place(build_, wooden_angles(build_, counts));
        line.tell(board_.reading(),
                  board_.pressed ? glm::dvec3(std::numeric_limits<double>::quiet_NaN()) : place);
    }

    const WoodenParameters build_ = published_build();
    Board board_;
};

/// A puck that is pushed around. It tells pushes, of which the driver makes a place: that is as old as the
/// last look at a node that could be read.
class FaultySpaceMouse final : public FaultyDevice {
public:
    FaultySpaceMouse() : FaultyDevice("spacemouse", {}) {
        exerts = false;
        std::erase(faults, Fault::refuses);  // nothing is sent to it
    }

    std::unique_ptr<DeviceDriver> driver() override {
        return std::make_unique<SpaceMouseDriver>(
            SpaceMousePace{},
            [this]() -> Opened {
                if (line.is_cut()) return pulled_out();
                line.clear();
                return std::unique_ptr<ReportTransport>(std::make_unique<Node>(*this));
            },
            [this] { return time.now_ns(); });
    }
    void live(double angle) override {
        if (time.now_ns() / VirtualTime::ms % 8 != 0) return;
        const auto word = [](double share) { return static_cast<int>(std::lround(300 * share)) & 0xffff; };
        const int x = word(std::cos(angle)), y = word(std::sin(angle));
        line.tell(bytes_of({0x01, x & 0xff, x >> 8, y & 0xff, y >> 8, 0, 0}), glm::dvec3(0));
    }
    double age_of(const glm::dvec3& place) override {
        for (int axis = 0; axis < 3; ++axis)
            if (std::abs(place[axis]) > SpaceMousePace{}.reach) return 1e9;
        return static_cast<double>(time.now_ns() - looked_ns_) * 1e-9;
    }

private:
    class Node final : public ReportTransport {
    public:
        explicit Node(FaultySpaceMouse& to)
            : to_(to), reports_(to.line, [&to](auto) { to.line.went_out(1); }) {}
        Result<void> send(std::span<const std::byte> report) override { return reports_.send(report); }
        Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override {
            auto came = reports_.receive(room, patience);
            if (came) to_.looked_ns_ = to_.time.now_ns();
            return came;
        }

    private:
        FaultySpaceMouse& to_;
        FaultyReports reports_;
    };
    std::int64_t looked_ns_ = 0;
};

TEST(WoodenFaults, AtRandomMoments) {
    FaultyWooden wooden;
    run_fault_sessions(wooden);
}

TEST(WoodenFaults, ForceAfterSilence) {
    FaultyWooden wooden;
    expect_force_after_silence(wooden);
}

TEST(SpaceMouseFaults, AtRandomMoments) {
    FaultySpaceMouse puck;
    run_fault_sessions(puck);
}

}  // namespace
}  // namespace touchable::test
