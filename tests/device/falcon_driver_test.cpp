// SPDX-License-Identifier: Apache-2.0
// A Falcon from its plug to its last bytes, over a fake one that does all that real ones are known to do
// wrong.

#include <gtest/gtest.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "device/drivers/driven_device.hpp"
#include "device/drivers/falcon_device.hpp"
#include "device/drivers/known_devices.hpp"
#include "tests/device/fault_sessions.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
    std::vector<std::byte> bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
    return bytes;
}

/// A Falcon at the other end of a USB cable, as its owners have described it; it shares no code with the
/// driver. It is what stays when the cable is pulled and put in again. Any thread's.
class FakeFalcon {
public:
    // Its state.
    bool plugged = true, has_firmware = true, homed = true;
    std::array<int, 3> counts{};
    unsigned buttons = 0;
    std::string image;  // that makes it run

    // Its faults. Each is asked for the next answer that it is about to send.
    std::function<std::string(const std::string&)>
        spoil;  // an answer of running firmware -> what comes of it
    std::function<std::string(const std::string&)> spoil_echo;  // while firmware is loaded
    int deaf_greetings = 0;
    bool zero_before_welcome = false;
    std::size_t longest_packet = 62;
    bool holds_next = false;      // an answer, until the next question
    std::size_t empty_reads = 0;  // before an answer comes
    bool silent = false, babbles = false;

    // Its record of a session.
    std::vector<FtdiCommand> commands;
    std::string written;  // since it was made
    std::string loaded;
    std::vector<std::size_t> blocks;
    std::array<int, 3> motors{};  // that act now
    int state = 0;                // of the last command: homing and lamps
    int questions = 0;
    int opened = 0;

    std::mutex mutex;

    std::string last_bytes(std::size_t count) {
        const std::lock_guard lock(mutex);
        return written.substr(written.size() - std::min(count, written.size()));
    }
    void pull_power() {
        const std::lock_guard lock(mutex);
        has_firmware = homed = false;
        motors = {};
        loaded.clear();
        coming.clear();
    }

    bool command(const FtdiCommand& command) {
        const std::lock_guard lock(mutex);
        if (!plugged) return false;
        commands.push_back(command);
        if (command == FtdiCommand{3, 0x4138}) loaded.clear(), marked_ = greeted_ = false;
        if (command.request == 3) divisor_ = command.value;
        if (command.request == 1 && (command.value & 0x100) != 0) dtr_ = (command.value & 1) != 0;
        if (command == FtdiCommand{0, 1}) coming.clear();
        if (divisor_ == 2 && !image.empty() && loaded == image) has_firmware = true;
        return true;
    }
    bool write(std::span<const std::byte> bytes) {
        const std::lock_guard lock(mutex);
        if (!plugged) return false;
        std::string text;
        for (const std::byte byte : bytes) text += static_cast<char>(byte);
        written += text;
        if (divisor_ == 0x4138 && dtr_ && text == "\x0a\x43\x0d") greet();
        if (divisor_ == 0x15 && greeted_ && !dtr_) load(text);
        if (divisor_ == 2 && has_firmware) run(text);
        return true;
    }
    /// The next packet to the driver, with the two bytes before its text.
    std::optional<std::vector<std::byte>> next_packet() {
        const std::lock_guard lock(mutex);
        if (!plugged) return std::nullopt;
        std::string packet = "\x01\x60";
        if (babbles) {
            packet += std::string(62, 'x');
        } else if (!silent && !coming.empty()) {
            packet += coming.front();
            coming.pop_front();
        }
        return bytes_of(packet);
    }

    std::deque<std::string> coming;  // at most 62 bytes each

private:
    void send(const std::string& bytes) {
        for (std::size_t at = 0; at < bytes.size(); at += longest_packet)
            coming.push_back(bytes.substr(at, longest_packet));
    }
    void greet() {
        if (deaf_greetings-- > 0) return;
        greeted_ = true;
        send((zero_before_welcome ? std::string(1, '\0') : std::string()) + "\x0a\x44\x2c\x0d");
    }
    void load(const std::string& block) {
        const std::string echo = spoil_echo ? spoil_echo(block) : block;
        if (!marked_ && block == "A") {
            marked_ = true;
        } else {
            loaded += block;
            blocks.push_back(block.size());
        }
        send(echo);
    }
    void run(const std::string& text) {
        for (const char byte : text) {
            if (byte == '<') begun_.clear();
            begun_ += byte;
            if (begun_.size() != 16 || begun_[0] != '<' || byte != '>') continue;
            for (std::size_t arm = 0; arm < 3; ++arm) {
                int word = 0;
                for (std::size_t digit = 4; digit-- > 0;)
                    word = 16 * word + (begun_[1 + 4 * arm + digit] - 'A');
                motors[arm] = word >= 32768 ? word - 65536 : word;
            }
            state = begun_[13] - 'A';
            ++questions;
            const std::string next = spoil ? spoil(answer()) : answer();
            if (std::exchange(holds_next, false)) {
                held_ = next;
                continue;
            }
            send(std::exchange(held_, std::string()));
            coming.insert(coming.end(), empty_reads, std::string());
            send(next);
        }
    }
    std::string answer() const {
        std::string packet = "<";
        for (const int count : counts) {
            unsigned bits = static_cast<unsigned>(count) & 0xFFFFU;
            for (int digit = 0; digit < 4; ++digit, bits /= 16) packet += static_cast<char>('A' + bits % 16);
        }
        packet += static_cast<char>('A' + static_cast<int>(buttons) + (homed && (state & 1) != 0 ? 0x70 : 0));
        return packet + "A>";
    }

    unsigned divisor_ = 0;
    bool dtr_ = false, greeted_ = false, marked_ = false;
    std::string begun_, held_;
};

/// An open port to it.
class FakeFalconPort final : public UsbPort {
public:
    explicit FakeFalconPort(std::shared_ptr<FakeFalcon> falcon) : falcon_(std::move(falcon)) {}

    Result<void> command(const FtdiCommand& command) override {
        return falcon_->command(command) ? Result<void>() : gone();
    }
    Result<void> write(std::span<const std::byte> bytes) override {
        return falcon_->write(bytes) ? Result<void>() : gone();
    }
    Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds) override {
        const auto packet = falcon_->next_packet();
        if (!packet) return gone();
        std::copy(packet->begin(), packet->end(), room.begin());
        return packet->size();
    }
    int usbfs() const override { return 77; }

private:
    static Error gone() { return {ErrorKind::device, "fake: was unplugged"}; }
    std::shared_ptr<FakeFalcon> falcon_;
};

using std::chrono::microseconds;
using std::chrono::milliseconds;

const std::string zero_force_packet = "<AAAAAAAAAAAABA>";
const std::string unpowered = zero_force_packet + zero_force_packet;

std::string some_image(std::size_t bytes) {
    std::mt19937 random(3);
    std::string image;
    while (image.size() < bytes) image += static_cast<char>(random() % 256);
    return image;
}

class Falcon : public ::testing::Test {
protected:
    FalconSettings settings(const std::string& image = {}) {
        FalconSettings settings;
        settings.firmware = bytes_of(image);
        settings.patience.question = milliseconds(2);
        if (in_vain) settings.patience = {milliseconds(2), milliseconds(5), milliseconds(2)};
        return settings;
    }
    std::unique_ptr<FalconDriver> driver_for(const std::string& image = {}, DriverClock clock = boot_ns) {
        return std::make_unique<FalconDriver>(
            settings(image),
            [falcon = falcon]() -> Result<std::unique_ptr<UsbPort>> {
                if (!falcon->plugged) return Error{ErrorKind::device, "no Novint Falcon is plugged in"};
                ++falcon->opened;
                return std::unique_ptr<UsbPort>(std::make_unique<FakeFalconPort>(falcon));
            },
            std::move(clock));
    }
    void connect(FalconDriver& driver) {
        const auto connected = driver.connect();
        ASSERT_TRUE(connected) << connected.error().message;
    }
    /// A turn of the device's thread.
    Result<bool> turn(FalconDriver& driver, const glm::dvec3& newtons = glm::dvec3(0.0)) {
        if (auto sent = driver.send(std::span(&newtons, 1)); !sent) return sent.error();
        return driver.receive(sample, patience);
    }
    void home(FalconDriver& driver) {
        for (int go = 0; go < 20 && !driver.prompt().empty(); ++go) ASSERT_TRUE(turn(driver));
        ASSERT_EQ(driver.prompt(), "");
    }
    void move_to(const glm::dvec3& place) {
        const auto angles = falcon_angles(place);
        for (std::size_t arm = 0; arm < 3; ++arm)
            falcon->counts[arm] =
                static_cast<int>(std::lround(((*angles)[arm] - 0.610865238198) / 6.35905e-4));
    }

    std::shared_ptr<FakeFalcon> falcon = std::make_shared<FakeFalcon>();
    bool in_vain = false;  // is it waited for what will not come?
    DeviceSample sample;
    microseconds patience{1500};
};

TEST_F(Falcon, RunningFirmwareIsNotReloaded) {
    auto driver = driver_for();
    connect(*driver);
    EXPECT_EQ(falcon->commands, (std::vector<FtdiCommand>{{9, 1}, {3, 2}, {0, 1}, {0, 2}}));
    EXPECT_EQ(falcon->written.substr(0, 16), "<AAAAAAAAAAAAJA>");  // no force, homing, red
    EXPECT_EQ(falcon->loaded, "");
}

TEST_F(Falcon, MissingFirmwareHintsAtOption) {
    falcon->has_firmware = false;
    const auto connected = driver_for()->connect();
    ASSERT_FALSE(connected);
    EXPECT_EQ(connected.error().kind, ErrorKind::device);
    EXPECT_NE(connected.error().message.find("has no firmware"), std::string::npos);
    EXPECT_EQ(connected.error().hints.at(0).value, "falcon:firmware=FILE");
}

TEST_F(Falcon, LoadsFirmwareAsDocumented) {
    falcon->has_firmware = false;
    falcon->image = some_image(7318);
    auto driver = driver_for(falcon->image);
    connect(*driver);
    EXPECT_EQ(falcon->loaded, falcon->image);
    ASSERT_EQ(falcon->blocks.size(), 119U);  // 118 of 62 bytes, and 2
    EXPECT_EQ(falcon->blocks[117], 62U);
    EXPECT_EQ(falcon->blocks[118], 2U);
    const std::vector<FtdiCommand> described{
        {9, 1},     {3, 2},     {0, 1},     {0, 2},               // is there firmware?
        {0, 1},     {0, 2},     {9, 16},    {3, 0x4138}, {4, 8},  // 9600 8N1
        {2, 0},     {1, 0x200}, {1, 0x100}, {1, 0x101},           // no flow control, RTS low, DTR up
        {1, 0x100}, {3, 0x15},  {0, 1},     {0, 2},               // DTR down, 140 kbaud
        {9, 1},     {3, 2},     {0, 1},     {0, 2}};              // 1.5 Mbaud
    EXPECT_EQ(falcon->commands, described);
    const std::string loading = falcon->written.substr(falcon->written.find('\x0a'));
    EXPECT_EQ(loading.substr(0, 4 + 7318), std::string("\x0a\x43\x0d") + "A" + falcon->image);
}

TEST_F(Falcon, ToleratesLostGreetingsAndFragments) {
    in_vain = true;
    falcon->has_firmware = false;
    falcon->image = some_image(2000);
    falcon->deaf_greetings = 7;
    falcon->zero_before_welcome = true;
    falcon->longest_packet = 3;
    connect(*driver_for(falcon->image));
    EXPECT_EQ(falcon->loaded, falcon->image);
}

TEST_F(Falcon, CorruptEchoRestartsFirmwareLoading) {
    falcon->has_firmware = false;
    falcon->image = some_image(2000);
    int echoes = 0;
    falcon->spoil_echo = [&](const std::string& block) {
        std::string echo = block;
        if (++echoes == 5) echo[1] = static_cast<char>(echo[1] ^ 4);
        return echo;
    };
    connect(*driver_for(falcon->image));
    EXPECT_EQ(falcon->loaded, falcon->image);
    EXPECT_EQ(echoes, 5 + 1 + 33);  // 'A' and three blocks, the spoilt one; then all of them
}

TEST_F(Falcon, ReportsWhereLoadingFails) {
    in_vain = true;
    falcon->has_firmware = false;
    falcon->image = some_image(2000);
    std::string message;
    const auto refused = [&] {
        falcon->blocks.clear();
        const auto connected = driver_for(falcon->image)->connect();
        return connected ? std::string() : connected.error().message;
    };
    falcon->spoil_echo = [&](const std::string& block) {
        return block == "A" || falcon->blocks.size() % 3 != 0 ? block : block.substr(0, 10);
    };
    message = refused();
    EXPECT_NE(message.find("block 3 of 33: 10 of 62 bytes came back (4 goes)"), std::string::npos) << message;
    falcon->spoil_echo = [](const std::string& block) { return block == "A" ? "B" : block; };
    message = refused();
    EXPECT_NE(message.find("the mark that begins it came back changed"), std::string::npos) << message;
    falcon->deaf_greetings = 1000000;
    message = refused();
    EXPECT_NE(message.find("does not answer; pull its power plug"), std::string::npos) << message;
}

TEST_F(Falcon, RejectsForeignFirmwareFile) {
    in_vain = true;
    falcon->has_firmware = false;
    falcon->image = some_image(2000);
    const auto connected = driver_for(some_image(1500))->connect();
    ASSERT_FALSE(connected);
    EXPECT_NE(connected.error().message.find("is the file its firmware?"), std::string::npos);
    EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
}

TEST_F(Falcon, LoadingCanBeCancelled) {
    falcon->has_firmware = false;
    falcon->image = some_image(8000);
    std::stop_source given_up;
    falcon->spoil_echo = [&](const std::string& block) {
        if (falcon->blocks.size() >= 20) given_up.request_stop();
        return block;
    };
    const auto connected =
        work_until(given_up.get_token(), [&] { return driver_for(falcon->image)->connect(); });
    ASSERT_FALSE(connected);
    EXPECT_EQ(connected.error().kind, ErrorKind::interrupted);
    EXPECT_LT(falcon->blocks.size(), 25U);
}

TEST_F(Falcon, HomingPrecedesPositionAndForce) {
    falcon->homed = false;
    auto driver = driver_for();
    connect(*driver);
    for (int go = 0; go < 30; ++go) {
        ASSERT_TRUE(turn(*driver, {0, 0, 5}));
        EXPECT_TRUE(std::isnan(sample.metres[0].x));
        EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
        EXPECT_EQ(falcon->state, 9);  // homing, red
    }
    EXPECT_EQ(driver->prompt(), "pull the Falcon's grip out, then push it in, until its ring is green");
    falcon->homed = true;
    int reports = 0;
    while (std::isnan(sample.metres[0].x)) {
        ASSERT_TRUE(turn(*driver, {0, 0, 5}));
        ASSERT_LE(++reports, 100);
        EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
    }
    EXPECT_EQ(reports, FalconDriver::homed_reports);  // one false report homes nothing
    ASSERT_TRUE(turn(*driver, {0, 0, 5}));
    EXPECT_EQ(driver->prompt(), "");
    EXPECT_EQ(falcon->state, 3);  // homing, green
    EXPECT_LT(falcon->motors[0], 0);
    falcon->homed = false;
    ASSERT_TRUE(turn(*driver, {0, 0, 5}));
    EXPECT_TRUE(std::isnan(sample.metres[0].x));
    ASSERT_TRUE(turn(*driver, {0, 0, 5}));
    EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
}

TEST_F(Falcon, ReadsPositionAndExertsForce) {
    auto driver = driver_for();
    connect(*driver);
    home(*driver);
    falcon->buttons = 5;
    for (const glm::dvec3& place :
         {glm::dvec3(0.0), glm::dvec3(0.02, -0.03, 0.01), glm::dvec3(-0.04, 0, -0.02)}) {
        move_to(place);
        ASSERT_TRUE(turn(*driver));
        EXPECT_LT(glm::length(sample.metres[0] - place), 1e-4);  // a count
        EXPECT_EQ(sample.buttons, 5U);
    }
    move_to(glm::dvec3(0.0));
    ASSERT_TRUE(turn(*driver));
    ASSERT_TRUE(turn(*driver, {0, 0, 8}));
    for (const int word : falcon->motors) EXPECT_NEAR(word, -2019, 3);  // the middle is not at whole counts
}

TEST_F(Falcon, ImpossibleEncodersGiveNoPosition) {
    auto driver = driver_for();
    connect(*driver);
    home(*driver);
    falcon->counts = {3000, -3000, 100};
    for (int go = 0; go < 300; ++go) {
        ASSERT_TRUE(turn(*driver, {0, 0, 5}));
        EXPECT_TRUE(std::isnan(sample.metres[0].x));
        if (go == 0) continue;
        EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
    }
    EXPECT_NE(driver->prompt().find("cannot reach"), std::string::npos);
    move_to({0.01, 0, 0});
    ASSERT_TRUE(turn(*driver));
    EXPECT_NEAR(sample.metres[0].x, 0.01, 1e-4);
    EXPECT_EQ(driver->prompt(), "");
}

TEST_F(Falcon, LateAnswerLeavesNoLag) {
    auto driver = driver_for();
    connect(*driver);
    home(*driver);
    patience = milliseconds(20);
    falcon->empty_reads = 3;
    falcon->holds_next = true;
    const auto late = turn(*driver);
    ASSERT_TRUE(late);
    EXPECT_FALSE(*late);
    move_to({0, 0.02, 0});
    ASSERT_TRUE(*turn(*driver));  // both came; the newer counts
    EXPECT_NEAR(sample.metres[0].y, 0.02, 1e-4);
    for (const double y : {0.018, 0.016, 0.014}) {
        move_to({0, y, 0});
        ASSERT_TRUE(*turn(*driver));
        EXPECT_NEAR(sample.metres[0].y, y, 1e-4);
    }
}

// Answers that are cut, damaged, repeated, late, in pieces or lost, at random: a place is the grip's of the
// last turns or there is none, and never is there a force without a place.
TEST_F(Falcon, FaultsGiveNoWrongPosition) {
    constexpr unsigned seed = 20;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    auto driver = driver_for({}, [now_ns = std::int64_t{0}]() mutable { return now_ns += 10'000; });
    connect(*driver);
    home(*driver);
    patience = microseconds(200);
    std::string held;
    falcon->spoil = [&](std::string answer) {
        answer = std::exchange(held, std::string()) + answer;
        switch (random() % 20) {
            case 0:
                return answer.substr(0, random() % answer.size());
            case 1:
                return answer.erase(random() % answer.size(), 2);
            case 2:
                answer[random() % answer.size()] = "<>\x01\xff"[random() % 4];
                return answer;
            case 3:
                return answer + answer;
            case 4:
                held = answer;
                return std::string();
            case 5:
                return std::string();
            default:
                return answer;
        }
    };
    int places = 0, none = 0;
    std::vector<double> last_x(40, 0.0);
    for (int go = 0; go < 3000; ++go) {
        const double x = 0.03 * std::sin(0.01 * go);
        last_x[static_cast<std::size_t>(go) % last_x.size()] = x;
        falcon->longest_packet = 1 + random() % 62;
        move_to({x, 0, 0});
        sample.metres[0] = glm::dvec3(std::nan(""));
        const auto came = turn(*driver, {3, 0, 0});
        ASSERT_TRUE(came) << go;
        if (!*came) {
            ++none;
            continue;
        }
        if (std::isnan(sample.metres[0].x)) continue;
        ++places;
        ASSERT_LT(std::abs(sample.metres[0].y), 1e-4) << go;
        ASSERT_TRUE(std::any_of(last_x.begin(), last_x.end(),
                                [&](double each) { return std::abs(each - sample.metres[0].x) < 1e-4; }))
            << go << " " << sample.metres[0].x << " for " << x;
    }
    EXPECT_GT(places, 2000);
    EXPECT_GT(none, 100);
    EXPECT_GT(driver->left_out(), 100);
    driver->disconnect();
    EXPECT_EQ(falcon->last_bytes(32), unpowered);
    EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
}

TEST_F(Falcon, DisconnectSendsZeroForce) {
    auto driver = driver_for();
    connect(*driver);
    home(*driver);
    move_to(glm::dvec3(0.0));
    for (int go = 0; go < 3; ++go) ASSERT_TRUE(turn(*driver, {8, 0, 0}));
    EXPECT_NE(falcon->motors, (std::array<int, 3>{}));
    driver->disconnect();
    EXPECT_EQ(falcon->last_bytes(32), unpowered);
    EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
    const std::size_t written = falcon->written.size();
    driver->disconnect();
    EXPECT_EQ(falcon->written.size(), written);
}

TEST_F(Falcon, UnpluggingIsRecoverableError) {
    auto driver = driver_for();
    connect(*driver);
    home(*driver);
    falcon->plugged = false;
    const auto gone = turn(*driver, {1, 0, 0});
    ASSERT_FALSE(gone);
    EXPECT_EQ(gone.error().message, "fake: was unplugged");
    driver->disconnect();
    EXPECT_FALSE(driver->connect());
    falcon->plugged = true;
    connect(*driver);
    EXPECT_NE(driver->prompt(), "");  // homing is believed anew
    home(*driver);
}

TEST_F(Falcon, DropsSilentDevice) {
    std::int64_t now = 1;
    auto driver = driver_for({}, [&now] { return now; });
    connect(*driver);
    home(*driver);
    patience = microseconds(0);
    falcon->silent = true;
    now += 250'000'000;
    const auto late = turn(*driver);
    ASSERT_TRUE(late) << "it may still answer";
    EXPECT_FALSE(*late);
    now += 1'000'000;
    const auto gone = turn(*driver);
    ASSERT_FALSE(gone);
    EXPECT_NE(gone.error().message.find("does not answer any more"), std::string::npos);
}

TEST_F(Falcon, DropsDeviceThatSendsGarbage) {
    auto driver = driver_for();
    connect(*driver);
    home(*driver);
    falcon->babbles = true;
    Result<bool> came = true;
    for (int go = 0; go < 1000000 && came; ++go) came = turn(*driver);
    EXPECT_FALSE(came);
    driver->disconnect();
    EXPECT_EQ(falcon->last_bytes(32), unpowered);
}

TEST_F(Falcon, ReloadsFirmwareAfterPowerLoss) {
    falcon->image = some_image(1500);
    auto driver = driver_for(falcon->image);
    connect(*driver);
    home(*driver);
    falcon->pull_power();
    Result<bool> came = true;
    for (int go = 0; go < 1000 && came; ++go) came = turn(*driver);
    ASSERT_FALSE(came);
    EXPECT_NE(came.error().message.find("does not answer any more"), std::string::npos);
    driver->disconnect();
    connect(*driver);
    EXPECT_EQ(falcon->loaded, falcon->image);
    ASSERT_TRUE(turn(*driver));
    EXPECT_NE(driver->prompt(), "");
}

TEST_F(Falcon, GivesWatchdogZeroForcePacket) {
    auto driver = driver_for();
    EXPECT_FALSE(driver->zero_force_packet());
    connect(*driver);
    const auto word = driver->zero_force_packet();
    ASSERT_TRUE(word);
    EXPECT_EQ(word->descriptor, 77);
    EXPECT_EQ(word->usb_endpoint, 0x02);
    EXPECT_EQ(word->bytes, bytes_of(zero_force_packet));
    driver->disconnect();
    EXPECT_FALSE(driver->zero_force_packet());
}

TEST_F(Falcon, DescribesItself) {
    const auto driver = driver_for();
    EXPECT_EQ(driver->name(), "Novint Falcon");
    EXPECT_EQ(driver->limits().max_force, 8);
    EXPECT_EQ(driver->capabilities().axes_driven, 3);
    EXPECT_EQ(driver->capabilities().buttons, 4);
    EXPECT_EQ(driver->capabilities().reach.x, 0.05);
    EXPECT_FALSE(driver->capabilities().own_watchdog);
}

/// Waits for what must come; a test that waits for ever is stopped by its time.
template <class Condition>
void wait_for(Condition&& condition) {
    while (!condition()) std::this_thread::yield();
}

TEST_F(Falcon, UnpowersOnSilenceAndClose) {
    move_to(glm::dvec3(0.0));
    DrivenDevice device(driver_for());
    ASSERT_TRUE(device.open());
    std::array<glm::dvec3, 1> place, force{glm::dvec3(0, 0, 5)};
    wait_for([&] { return device.read_positions(place) && !std::isnan(place[0].x); });
    EXPECT_LT(glm::length(place[0]), 1e-4);
    const auto motor = [this] {
        const std::lock_guard lock(falcon->mutex);
        return falcon->motors[0];
    };
    wait_for([&] { return device.write_forces(force) && motor() < -1000; });
    wait_for([&] { return motor() == 0; });  // without a word for `silence_s`
    wait_for([&] { return device.write_forces(force) && motor() < -1000; });
    device.close();
    EXPECT_EQ(falcon->motors, (std::array<int, 3>{}));
    EXPECT_EQ(falcon->last_bytes(32), unpowered);
}

// A Falcon's keys, its firmware's file, and what is said where it cannot be had.

namespace fs = std::filesystem;

void write_file(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
}

Error refusal_of(const std::string& keys) {
    const auto settings = read_falcon_settings(keys);
    return settings ? Error{ErrorKind::internal, "taken"} : settings.error();
}

TEST(FalconKeys, ReadForceStiffnessAndFirmware) {
    TemporaryFolder folder;
    write_file(folder / "image.bin", std::string(7318, 'x'));
    const auto plain = read_falcon_settings("");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->limits.max_force, 8);
    EXPECT_EQ(plain->limits.max_stiffness, 1000);
    EXPECT_TRUE(plain->firmware.empty());
    const auto set =
        read_falcon_settings("force=5,stiffness=0.5,firmware=" + (folder / "image.bin").string());
    ASSERT_TRUE(set) << set.error().message;
    EXPECT_EQ(set->limits.max_force, 5);
    EXPECT_EQ(set->limits.max_stiffness, 500);
    EXPECT_EQ(set->firmware, std::vector<std::byte>(7318, std::byte{'x'}));
}

TEST(FalconKeys, RejectInvalidKeys) {
    for (const char* wrong :
         {"force=0", "force=11", "force=nan", "stiffness=-1", "colour=red", "firmware="}) {
        const Error error = refusal_of(wrong);
        EXPECT_EQ(error.kind, ErrorKind::usage) << wrong;
        EXPECT_NE(error.message.find("device 'falcon'"), std::string::npos) << error.message;
    }
}

TEST(FalconKeys, RejectUnusableFirmwareFile) {
    TemporaryFolder folder;
    write_file(folder / "empty", "");
    write_file(folder / "large", std::string(100000, 'x'));
    for (const std::string name : {"none", "empty", "large", ""}) {
        const Error error = refusal_of("firmware=" + (folder / name).string());
        EXPECT_EQ(error.kind, ErrorKind::input) << name;
        EXPECT_NE(error.message.find("firmware"), std::string::npos) << error.message;
    }
    EXPECT_NE(refusal_of("firmware=" + (folder / "large").string()).message.find("100000 bytes"),
              std::string::npos);
}

class UsbDiscovery : public ::testing::Test {
protected:
    void plug(const std::string& name, const std::string& vendor, const std::string& product,
              const std::string& bus, const std::string& number) {
        const fs::path device = folder / "sys/bus/usb/devices" / name;
        write_file(device / "idVendor", vendor + "\n");
        write_file(device / "idProduct", product + "\n");
        write_file(device / "busnum", bus + "\n");
        write_file(device / "devnum", number + "\n");
    }
    Result<std::unique_ptr<UsbPort>> opened() const { return open_falcon(ConnectedSystem(folder.path())); }
    TemporaryFolder folder;
};

TEST_F(UsbDiscovery, OpensFirstMatchingDevice) {
    const auto is_refused_with = [&](const std::string& words) {
        const auto falcon = opened();
        return !falcon && falcon.error().message.find(words) != std::string::npos;
    };
    plug("usb1", "1d6b", "0002", "1", "1");
    plug("1-2", "0403", "6001", "1", "3");
    EXPECT_TRUE(is_refused_with("no Novint Falcon is plugged in"));
    plug("2-1", "0403", "cb48", "2", "4");
    plug("1-1", "0403", "cb48", "1", "12");
    EXPECT_TRUE(is_refused_with("/dev/bus/usb/001/012: No such file"));
    // An interface has no identity of its own.
    fs::create_directories(folder / "sys/bus/usb/devices/1-1:1.0");
    EXPECT_TRUE(is_refused_with("/dev/bus/usb/001/012: No such file"));
}

TEST_F(UsbDiscovery, ExplainsEachOpenFailure) {
    const auto absent = opened();
    ASSERT_FALSE(absent);
    EXPECT_EQ(absent.error().kind, ErrorKind::device);
    EXPECT_NE(absent.error().message.find("0403:cb48"), std::string::npos);
    plug("1-1", "0403", "cb48", "1", "2");
    const auto no_node = opened();
    ASSERT_FALSE(no_node);
    EXPECT_NE(no_node.error().message.find("001/002: No such file"), std::string::npos)
        << no_node.error().message;
    write_file(folder / "dev/bus/usb/001/002", "no USB device");
    const auto no_device = opened();
    ASSERT_FALSE(no_device);
    EXPECT_NE(no_device.error().message.find("Novint Falcon at "), std::string::npos);
    EXPECT_EQ(no_device.error().message.find('\n'), std::string::npos);
    if (geteuid() == 0) return;  // root may open anything
    fs::permissions(folder / "dev/bus/usb/001/002", fs::perms::none);
    const auto forbidden = opened();
    ASSERT_FALSE(forbidden);
    EXPECT_NE(forbidden.error().message.find("70-touchable.rules"), std::string::npos);
}

/// A Falcon on a bad cable. Now and then it loses its power, and with it its firmware and its homing.
class FaultyFalcon final : public FaultyDevice {
public:
    FaultyFalcon()
        : FaultyDevice("falcon", {.is_stream = true, .place_step = 1e-4, .longest_force = 4096}),
          falcon_(std::make_shared<FakeFalcon>()) {
        for (int byte = 0; byte < 1500; ++byte) falcon_->image += static_cast<char>(byte * 7);
    }

    std::unique_ptr<DeviceDriver> driver() override {
        falcon_->written.clear();
        falcon_->commands.clear();
        FalconSettings settings;
        settings.firmware = bytes_of(falcon_->image);
        const auto plug = [this]() -> Result<std::unique_ptr<UsbPort>> {
            if (line.is_cut()) return gone();
            line.clear();
            return std::unique_ptr<UsbPort>(std::make_unique<Port>(*this));
        };
        return std::make_unique<FalconDriver>(settings, plug, [this] { return time.now_ns(); });
    }
    void live(double angle) override {
        const auto angles = falcon_angles(0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0));
        ASSERT_TRUE(angles);
        for (std::size_t arm = 0; arm < 3; ++arm)
            falcon_->counts[arm] =
                static_cast<int>(std::lround(((*angles)[arm] - 0.610865238198) / 6.35905e-4));
        place_ = 0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0);
    }
    void tend(const std::string&) override { falcon_->homed = true; }
    void suffer_its_own() override {
        falcon_->pull_power();
        line.went_out(0);
    }

    /// Another process leaves it unpowered.
    void hear_another() {
        Port port(*this);
        for (int packet = 0; packet < 2; ++packet) ASSERT_TRUE(port.write(bytes_of("<AAAAAAAAAAAABA>")));
    }
    const glm::dvec3& place() const { return place_; }

private:
    class Port final : public UsbPort {
    public:
        explicit Port(FaultyFalcon& to) : to_(to) {}
        Result<void> command(const FtdiCommand& command) override {
            if (to_.line.is_cut()) return gone();
            if (command == FtdiCommand{0, 1}) to_.line.clear();
            to_.falcon_->command(command);
            return {};
        }
        Result<void> write(std::span<const std::byte> bytes) override {
            if (!to_.line.passes()) return gone();
            FakeFalcon& falcon = *to_.falcon_;
            falcon.write(bytes);
            const bool tells = falcon.has_firmware && falcon.homed;
            for (; !falcon.coming.empty(); falcon.coming.pop_front())
                to_.line.tell(bytes_of(falcon.coming.front()),
                              tells ? to_.place_ : glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
            int longest = 0;
            for (const int word : falcon.motors) longest = std::max(longest, std::abs(word));
            to_.line.went_out(longest);
            return {};
        }
        Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds patience) override {
            if (to_.line.is_cut()) return gone();
            // The converter sends a packet after a millisecond, be it empty.
            const auto came = to_.line.next(std::min(patience, std::chrono::microseconds(1000)));
            std::fill_n(room.begin(), 2, std::byte{0x60});
            if (!came) return 2;
            const std::size_t bytes = std::min(came->size(), room.size() - 2);
            std::copy_n(came->begin(), bytes, room.begin() + 2);
            return 2 + bytes;
        }

    private:
        FaultyFalcon& to_;
    };
    static Error gone() { return {ErrorKind::device, "fake: was unplugged"}; }

    std::shared_ptr<FakeFalcon> falcon_;
    glm::dvec3 place_{0.0};
};

/// A place is answered a millisecond after it was asked for, and the grip goes on moving.
class SharedFalcon : public ::testing::Test {
protected:
    void SetUp() override {
        falcon.time.on_tick = [this] { falcon.live(static_cast<double>(falcon.time.now_ns()) * 7.5e-9); };
        falcon.time.pass(VirtualTime::ms);
        ASSERT_TRUE(driver->connect());
        for (int turns = 0; turns < 20; ++turns) turn();
        ASSERT_EQ(driver->prompt(), "");
    }
    /// The distance of the place that a turn tells from the grip's place at the request, metres.
    double turn() {
        const glm::dvec3 none(0), asked = falcon.place();
        EXPECT_TRUE(driver->send(std::span(&none, 1)));
        DeviceSample sample;
        const auto came = driver->receive(sample, std::chrono::microseconds(5000));
        EXPECT_TRUE(came && *came);
        return glm::length(sample.metres[0] - asked);
    }
    FaultyFalcon falcon;
    const std::unique_ptr<DeviceDriver> driver = falcon.driver();
};

TEST_F(SharedFalcon, IgnoresAnswersToOtherProcess) {
    constexpr double encoder_step = 1e-4, of_a_tick = 0.02 * 7.5e-3;
    static_assert(of_a_tick > encoder_step);
    for (const bool goes_on_as_it_speaks : {false, true}) {
        for (int words = 0; words < 10; ++words) {
            falcon.hear_another();
            falcon.time.pass(20 * VirtualTime::ms);
        }
        if (goes_on_as_it_speaks) falcon.hear_another();
        ASSERT_TRUE(driver->forget_what_came());
        if (goes_on_as_it_speaks) falcon.hear_another();
        falcon.time.pass(VirtualTime::ms / 2);
        for (int turns = 0; turns < 5; ++turns)
            ASSERT_LT(turn(), encoder_step) << "turn " << turns << ", " << goes_on_as_it_speaks;
    }
}

TEST_F(SharedFalcon, ProgramStallIsNotSilence) {
    falcon.time.pass(1000 * VirtualTime::ms);
    ASSERT_TRUE(driver->forget_what_came());
    DeviceSample sample;
    EXPECT_TRUE(driver->receive(sample, std::chrono::microseconds(0)));
}

TEST(FalconFaults, NeverCauseUnsafeForce) {
    FaultyFalcon falcon;
    run_fault_sessions(falcon);
}

TEST(FalconFaults, ForceReturnsAfterShortSilence) {
    FaultyFalcon falcon;
    expect_force_after_silence(falcon);
}

}  // namespace
}  // namespace touchable::test
