// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include "device/drivers/driven_device.hpp"
#include "device/drivers/hid_transport.hpp"
#include "device/drivers/known_devices.hpp"
#include "device/drivers/safety_watchdog.hpp"
#include "device/drivers/spacemouse_device.hpp"
#include "device/drivers/woodenhaptics_device.hpp"
#include "tests/device/fault_sessions.hpp"
#include "tests/device/wooden_bench.hpp"
#include "tests/temporary_files.hpp"

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

TEST(WoodenFaults, NeverCauseUnsafeForce) {
    FaultyWooden wooden;
    run_fault_sessions(wooden);
}

TEST(WoodenFaults, ForceReturnsAfterShortSilence) {
    FaultyWooden wooden;
    expect_force_after_silence(wooden);
}

TEST(SpaceMouseFaults, NeverCauseStalePosition) {
    FaultySpaceMouse puck;
    run_fault_sessions(puck);
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

using test::TemporaryFile;

namespace fs = std::filesystem;

void lay_node(const fs::path& root, const std::string& node, const std::string& uevent) {
    const fs::path device = root / "sys/class/hidraw" / node / "device";
    fs::create_directories(device);
    std::ofstream(device / "uevent") << uevent;
}

TEST(HidNode, ReadsIdsAndName) {
    const auto node = read_hid_uevent(
        "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C635\nHID_NAME=3Dconnexion SpaceMouse Compact\n"
        "HID_PHYS=usb-0000:00:14.0-2/input0\nHID_UNIQ=\nMODALIAS=hid:b0003g0001v0000256Fp0000C635\n");
    ASSERT_TRUE(node);
    EXPECT_EQ(node->bus, 3);
    EXPECT_EQ(node->vendor, 0x256f);
    EXPECT_EQ(node->product, 0xc635);
    EXPECT_EQ(node->name, "3Dconnexion SpaceMouse Compact");
}

TEST(HidNode, RejectsTextWithoutIds) {
    for (const char* text : {"", "\n\n", "HID_NAME=x\n", "HID_ID=\n", "HID_ID=0003:256F\n", "HID_ID=g:h:i\n",
                             "HID_ID=0003:0001256F:0000C635\n", "HID_ID=0003:0000256F:0000C635:1\n"})
        EXPECT_FALSE(read_hid_uevent(text)) << text;
}

TEST(HidNode, ListsNodesByNumber) {
    const test::TemporaryFolder root;
    lay_node(root.path(), "hidraw10", "HID_ID=0003:0000256F:0000C635\nHID_NAME=later\n");
    lay_node(root.path(), "hidraw9", "HID_ID=0005:0000256F:0000C63A\nHID_NAME=sooner\n");
    lay_node(root.path(), "hidraw0", "HID_ID=0003:0000046D:0000C077\nHID_NAME=mouse\n");
    lay_node(root.path(), "hidraw1", "nothing that is known\n");
    const auto nodes = hid_nodes(ConnectedSystem(root.path()));
    ASSERT_EQ(nodes.size(), 3u);
    EXPECT_EQ(nodes[0].node, "/dev/hidraw0");
    EXPECT_EQ(nodes[1].node, "/dev/hidraw9");
    EXPECT_EQ(nodes[2].node, "/dev/hidraw10");
    EXPECT_EQ(nodes[1].name, "sooner");
}

TEST(HidNode, IsAbsentWithoutHid) {
    const test::TemporaryFolder root;
    EXPECT_TRUE(hid_nodes(ConnectedSystem(root.path())).empty());
}

TEST(HidTransport, RejectsNonHidFiles) {
    const TemporaryFile file("plain", "text");
    for (const auto& [node, why] : {std::pair(std::string("/dev/hidraw-none"), "does not exist"),
                                    {file.path(), "is no HID device"},
                                    {"/dev/null", "is no HID device"}}) {
        const auto opened = HidTransport::open(node);
        ASSERT_FALSE(opened) << node;
        EXPECT_EQ(opened.error().kind, ErrorKind::device);
        EXPECT_TRUE(opened.error().message.starts_with(node + ": " + why)) << opened.error().message;
        EXPECT_EQ(opened.error().message.find('\n'), std::string::npos);
    }
}

/// A device that is lost and found again often has its old descriptor's number.
TEST(ZeroForcePacket, ReachesDeviceAfterReplug) {
    int lost[2], found[2];
    ASSERT_EQ(pipe(lost), 0);
    ASSERT_EQ(pipe(found), 0);
    const pid_t child = fork();
    if (child == 0) {
        const ZeroForcePacket word{lost[1], {std::byte{'0'}}, {}};
        auto watchdog = SafetyWatchdog::start();
        if (!watchdog) _exit(1);
        auto kept = SafetyWatchdog::keep(*watchdog);
        if (!kept || !(*kept)->set_packet(word)) _exit(1);
        if (dup2(found[1], lost[1]) < 0 || !(*kept)->set_packet(word)) _exit(1);
        _exit(0);
    }
    close(lost[1]);
    close(found[1]);
    std::string heard;
    for (char byte = 0; read(found[0], &byte, 1) == 1;) heard += byte;
    EXPECT_EQ(heard, "00");  // a watchdog says it twice
    char byte = 0;
    EXPECT_EQ(read(lost[0], &byte, 1), 0);
    close(lost[0]);
    close(found[0]);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
}

using std::chrono::microseconds;
constexpr std::int64_t ms = 1'000'000;

SpaceMouseReport decoded(std::initializer_list<int> bytes) {
    const auto report = decode_spacemouse_report(bytes_of(bytes));
    EXPECT_TRUE(report);
    return report ? *report : SpaceMouseReport{};
}

TEST(SpaceMouseProtocol, DecodesLittleEndianTranslation) {
    const auto report = decoded({0x01, 0x5e, 0x01, 0xa2, 0xfe, 0xff, 0xff});
    EXPECT_EQ(report.translation, glm::ivec3(350, -350, -1));
    EXPECT_FALSE(report.buttons);
}

TEST(SpaceMouseProtocol, IgnoresRotationBehindTranslation) {
    const auto report =
        decoded({0x01, 0x0a, 0x00, 0x00, 0x00, 0xf6, 0xff, 0x5e, 0x01, 0x5e, 0x01, 0x5e, 0x01});
    EXPECT_EQ(report.translation, glm::ivec3(10, 0, -10));
}

TEST(SpaceMouseProtocol, IgnoresRotationReport) {
    const auto report = decoded({0x02, 0x00, 0x00, 0xe2, 0xff, 0x00, 0x00});
    EXPECT_FALSE(report.translation || report.buttons);
}

TEST(SpaceMouseProtocol, DecodesButtonBits) {
    EXPECT_EQ(decoded({0x03, 0x01, 0x00}).buttons, 1u);
    EXPECT_EQ(decoded({0x03, 0x02, 0x00}).buttons, 2u);
    EXPECT_EQ(decoded({0x03, 0x03, 0x00}).buttons, 3u);
    EXPECT_EQ(decoded({0x03, 0x00, 0x00}).buttons, 0u);
    EXPECT_EQ(decoded({0x03, 0x00, 0x10, 0x00, 0x80, 0xff, 0xff}).buttons, 0x80001000u);
}

TEST(SpaceMouseProtocol, IgnoresBatteryReport) {
    const auto report = decoded({0x17, 0x64});
    EXPECT_FALSE(report.translation || report.buttons);
}

TEST(SpaceMouseProtocol, RejectsShortReports) {
    EXPECT_FALSE(decode_spacemouse_report({}));
    EXPECT_FALSE(decode_spacemouse_report(bytes_of({3})));
    for (const int number : {1, 2}) {
        Bytes bytes = bytes_of({number});
        for (; bytes.size() < 7; bytes.push_back(std::byte{0}))
            EXPECT_FALSE(decode_spacemouse_report(bytes)) << bytes.size();
        EXPECT_TRUE(decode_spacemouse_report(bytes));
    }
}

TEST(SpaceMouseProtocol, DistinguishesPucksFromMice) {
    EXPECT_TRUE(is_spacemouse(0x046d, 0xc626));   // SpaceNavigator
    EXPECT_TRUE(is_spacemouse(0x046d, 0xc62b));   // SpaceMouse Pro
    EXPECT_TRUE(is_spacemouse(0x256f, 0xc635));   // SpaceMouse Compact
    EXPECT_TRUE(is_spacemouse(0x256f, 0xc652));   // universal receiver
    EXPECT_FALSE(is_spacemouse(0x046d, 0xc52b));  // Logitech's own receiver
    EXPECT_FALSE(is_spacemouse(0x046d, 0xc077));  // an ordinary mouse
    EXPECT_FALSE(is_spacemouse(0x256f, 0xc650));  // CadMouse
    EXPECT_FALSE(is_spacemouse(0x0403, 0xcb48));
}

TEST(SpaceMouseMotion, FullPushMovesAtSpeed) {
    const std::pair<glm::ivec3, glm::dvec3> pushes[] = {
        {{350, 0, 0}, {0.02, 0, 0}}, {{0, 350, 0}, {0, 0, 0.02}}, {{0, 0, 350}, {0, -0.02, 0}}};
    for (const auto& [counts, metres] : pushes) {
        SpaceMouseMotion motion({0.1, 0.08}, 0);
        motion.deflect(counts, 0);
        EXPECT_LT(glm::distance(motion.place(200 * ms), metres), 1e-12);
    }
}

TEST(SpaceMouseMotion, DiagonalPushIsNotFaster) {
    SpaceMouseMotion motion({0.1, 0.08}, 0);
    motion.deflect({350, 350, -350}, 0);
    EXPECT_NEAR(glm::length(motion.place(100 * ms)), 0.01, 1e-12);
}

TEST(SpaceMouseMotion, DeadZoneIgnoresRestingHand) {
    SpaceMouseMotion motion({0.1, 0.08}, 0);
    motion.deflect({10, -10, 8}, 0);  // 16.2 counts long; the dead zone is 17.5
    EXPECT_EQ(motion.place(200 * ms), glm::dvec3(0));
    // Half-way between the dead zone's 17.5 and 350, half the speed.
    motion.deflect({0, 184, 0}, 200 * ms);
    EXPECT_NEAR(motion.place(300 * ms).z, 0.1 * 0.1 * (184 - 17.5) / (350 - 17.5), 1e-12);
}

TEST(SpaceMouseMotion, SilenceMeansReleasedPuck) {
    SpaceMouseMotion motion({0.1, 0.08}, 0);
    motion.deflect({350, 0, 0}, 0);
    EXPECT_NEAR(motion.place(199 * ms).x, 0.0199, 1e-12);
    EXPECT_NEAR(motion.place(5000 * ms).x, 0.02, 1e-12);
    motion.deflect({350, 0, 0}, 6000 * ms);
    EXPECT_NEAR(motion.place(6010 * ms).x, 0.021, 1e-12);
}

TEST(SpaceMouseMotion, SkippedTurnsKeepDistance) {
    SpaceMouseMotion often({0.1, 0.08}, 0), seldom({0.1, 0.08}, 0);
    often.deflect({200, 0, 0}, 0);
    seldom.deflect({200, 0, 0}, 0);
    for (int turn = 1; turn < 150; ++turn) often.place(turn * ms);
    EXPECT_NEAR(often.place(150 * ms).x, seldom.place(150 * ms).x, 1e-12);
}

TEST(SpaceMouseMotion, StaysWithinReach) {
    SpaceMouseMotion motion({1, 0.05}, 0);
    for (int turn = 0; turn < 100; ++turn) motion.deflect({350, 350, 350}, turn * 100 * ms);
    EXPECT_EQ(motion.place(10'000 * ms), glm::dvec3(0.05, -0.05, 0.05));
    motion.deflect({-350, 0, 0}, 10'000 * ms);
    EXPECT_NEAR(motion.place(10'010 * ms).x, 0.04, 1e-12);
}

TEST(SpaceMouseKeys, AreReadOrRejected) {
    const auto given = read_spacemouse_settings("speed=0.25,reach=0.05,node=/dev/hidraw7");
    ASSERT_TRUE(given);
    EXPECT_EQ(given->pace.speed, 0.25);
    EXPECT_EQ(given->pace.reach, 0.05);
    EXPECT_EQ(given->node, "/dev/hidraw7");
    for (const char* wrong : {"speed=0", "reach=2", "force=1", "speed", "node="}) {
        const auto refused = read_spacemouse_settings(wrong);
        ASSERT_FALSE(refused) << wrong;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
}

struct Puck {
    std::shared_ptr<FakeWire> wire = std::make_shared<FakeWire>();
    SpaceMouseDriver driver{SpaceMousePace{},
                            [wire = wire]() -> Result<std::unique_ptr<ReportTransport>> {
                                return std::unique_ptr<ReportTransport>(std::make_unique<FakeReports>(wire));
                            },
                            [wire = wire] { return wire->now_ns(); }};
    DeviceSample sample;

    bool receive() {
        const auto came = driver.receive(sample, microseconds(5000));
        return came && *came;
    }
};

TEST(SpaceMouseDriver, SilentPuckStaysConnected) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    for (int turn = 0; turn < 5000; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.sample.metres[0], glm::dvec3(0));
    EXPECT_GE(puck.wire->now_ns(), 5000 * ms);
    EXPECT_EQ(puck.driver.descriptor(), -1);
    EXPECT_EQ(puck.driver.capabilities().axes_driven, 0);
    EXPECT_GT(puck.driver.limits().max_force, 0);
    EXPECT_GT(puck.driver.limits().max_stiffness, 0);
}

TEST(SpaceMouseDriver, ReadsPushesAndButtons) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    puck.wire->lay(bytes_of({0x01, 0x5e, 0x01, 0, 0, 0, 0}));
    puck.wire->lay(bytes_of({0x03, 0x02, 0x00}));
    ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.sample.buttons, 2u);
    for (int turn = 0; turn < 50; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_NEAR(puck.sample.metres[0].x, 0.005, 1e-9);  // 50 ms at 0.1 m/s
    puck.wire->lay(bytes_of({0x01, 0, 0, 0, 0, 0, 0}));
    for (int turn = 0; turn < 50; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_NEAR(puck.sample.metres[0].x, 0.005, 1e-9);
}

TEST(SpaceMouseDriver, SkipsDamagedReports) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    puck.wire->lay(bytes_of({0x01, 0x5e, 0x01}));
    puck.wire->lay(bytes_of({0x03}));
    ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.driver.left_out(), 2);
    for (int turn = 0; turn < 10; ++turn) ASSERT_TRUE(puck.receive());
    EXPECT_EQ(puck.sample.metres[0], glm::dvec3(0));
}

TEST(SpaceMouseDriver, ReconnectsAfterUnplugging) {
    Puck puck;
    ASSERT_TRUE(puck.driver.connect());
    puck.wire->unplug();
    EXPECT_FALSE(puck.driver.receive(puck.sample, microseconds(1000)));
    puck.driver.disconnect();
    puck.wire->plug_in();
    ASSERT_TRUE(puck.driver.connect());
    EXPECT_TRUE(puck.receive());
}

TEST(SpaceMouseDriver, RestingPuckHasPosition) {
    auto wire = std::make_shared<FakeWire>();
    wire->waits = true;
    DrivenDevice device(std::make_unique<SpaceMouseDriver>(
        SpaceMousePace{}, [wire]() -> Result<std::unique_ptr<ReportTransport>> {
            return std::unique_ptr<ReportTransport>(std::make_unique<FakeReports>(wire));
        }));
    ASSERT_TRUE(device.open());
    while (device.facts().samples < 30) std::this_thread::yield();
    std::array<glm::dvec3, 1> place{glm::dvec3(std::numeric_limits<double>::quiet_NaN())};
    ASSERT_TRUE(device.read_positions(place));
    EXPECT_EQ(place[0], glm::dvec3(0));
    const std::array<glm::dvec3, 1> force{glm::dvec3(1, 0, 0)};
    EXPECT_TRUE(device.write_forces(force));
    device.close();
    EXPECT_TRUE(wire->sent().empty());
}

}  // namespace
}  // namespace touchable
