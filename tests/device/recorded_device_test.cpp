// SPDX-License-Identifier: Apache-2.0
// Logs are written by hand, by the definition of docs/devices.md.
#include "device/drivers/recorded_device.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "device/drivers/device_catalog.hpp"
#include "tests/temporary_files.hpp"

namespace touchable {
namespace {

using test::TemporaryFile;

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

const std::string log_header = "time_s,finger,x,y,z,buttons,age_ms,fx,fy,fz,force_on\n";

/// Stands still until it is waited for; then it goes as far as it was waited for.
class HandClock final : public ReplayClock {
public:
    explicit HandClock(nanoseconds& time) : time_(time) {}
    nanoseconds now() override { return time_; }
    void wait_until(nanoseconds moment) override { time_ = std::max(time_, moment); }

private:
    nanoseconds& time_;
};

std::unique_ptr<ReplayDriver> replay(const std::string& text, nanoseconds& time) {
    auto driver = read_recorded_device(text, std::make_unique<HandClock>(time));
    EXPECT_TRUE(driver) << (driver ? "" : driver.error().message);
    EXPECT_TRUE((*driver)->connect());
    return std::move(*driver);
}

std::string refusal(const std::string& log) {
    const TemporaryFile file("device.csv", log);
    nanoseconds time{0};
    const auto driver = read_recorded_device(file.path(), std::make_unique<HandClock>(time));
    if (driver) return "accepted";
    EXPECT_EQ(driver.error().kind, ErrorKind::input);
    EXPECT_TRUE(driver.error().message.starts_with(file.path() + ": ")) << driver.error().message;
    return driver.error().message.substr(file.path().size() + 2);
}

TEST(RecordedDevice, ReplaysTicksOnTime) {
    const TemporaryFile file("device.csv", log_header +
                                               "5.000,0,0.1,0.2,0.3,0,1,0,0,0,0\n"
                                               "5.000,1,-0.1,0,0,0,1,0,0,0,0\n"
                                               "5.001,0,0.11,0.2,0.3,5,1,0,0,1.5,1\n"
                                               "5.001,1,,,,5,25,0,0,0,1\n");
    nanoseconds time = milliseconds(700);
    const auto driver = replay(file.path(), time);
    EXPECT_EQ(driver->fingers(), 2);
    EXPECT_EQ(driver->capabilities().axes_driven, 0);
    EXPECT_NEAR(driver->capabilities().rate_hz, 1000, 1e-6);
    DeviceSample sample;
    ASSERT_TRUE(*driver->receive(sample, milliseconds(5)));
    EXPECT_EQ(time, milliseconds(700)) << "the first is there at once";
    EXPECT_EQ(sample.metres[0], glm::dvec3(0.1, 0.2, 0.3));
    EXPECT_EQ(sample.metres[1], glm::dvec3(-0.1, 0, 0));
    EXPECT_EQ(sample.buttons, 0u);
    EXPECT_FALSE(*driver->receive(sample, microseconds(400)));
    EXPECT_EQ(time, milliseconds(700) + microseconds(400)) << "it waits no longer than asked";
    const glm::dvec3 pushes[2] = {{0, 0, 9}, {0, 0, 9}};
    EXPECT_TRUE(driver->send(pushes));
    ASSERT_TRUE(*driver->receive(sample, milliseconds(5)));
    EXPECT_NEAR(static_cast<double>(time.count()), 701e6, 2);
    EXPECT_EQ(sample.metres[0], glm::dvec3(0.11, 0.2, 0.3)) << "forces move nothing";
    EXPECT_TRUE(std::isnan(sample.metres[1].x));
    EXPECT_EQ(sample.buttons, 5u);
    EXPECT_EQ(driver->prompt(), "");
    EXPECT_FALSE(driver->is_over()) << "its last place stands for a tick";
    ASSERT_TRUE(*driver->receive(sample, milliseconds(5)));
    EXPECT_TRUE(std::isnan(sample.metres[0].x));
    EXPECT_EQ(sample.buttons, 0u);
    EXPECT_NE(driver->prompt().find("has ended"), std::string::npos);
    EXPECT_TRUE(driver->is_over());
    EXPECT_FALSE(*driver->receive(sample, milliseconds(5)));
    driver->disconnect();
    EXPECT_FALSE(driver->receive(sample, milliseconds(5)));
    ASSERT_TRUE(driver->connect()) << "and again from the start";
    EXPECT_FALSE(driver->is_over());
    ASSERT_TRUE(*driver->receive(sample, milliseconds(5)));
    EXPECT_EQ(sample.metres[0], glm::dvec3(0.1, 0.2, 0.3));
}

TEST(RecordedDevice, SkipsMissedTicks) {
    std::string log = log_header;
    for (int tick = 0; tick < 100; ++tick)
        log += "0." + std::string(tick < 10 ? "00" : "0") + std::to_string(tick) + ",0," +
               std::to_string(tick) + ",0,0,0,1,0,0,0,0\n";
    const TemporaryFile file("device.csv", log);
    nanoseconds time{0};
    const auto driver = replay(file.path(), time);
    DeviceSample sample;
    ASSERT_TRUE(*driver->receive(sample, microseconds(0)));
    time = milliseconds(50) + microseconds(1);
    ASSERT_TRUE(*driver->receive(sample, microseconds(0)));
    EXPECT_EQ(sample.metres[0].x, 50);
    EXPECT_FALSE(*driver->receive(sample, microseconds(0)));
}

TEST(RecordedDevice, ReadsKeysAfterFile) {
    const TemporaryFile file("with:colon.csv", log_header + "0,0,0,0,0,0,1,0,0,0,0\n");
    nanoseconds time{0};
    EXPECT_EQ(replay(file.path(), time)->limits().max_force, 10);
    const auto driver = replay(file.path() + ":force=4,stiffness=2", time);
    EXPECT_EQ(driver->limits().max_force, 4);
    EXPECT_EQ(driver->limits().max_stiffness, 2000);
    for (const std::string& text :
         {std::string(), std::string(":force=4"), file.path() + ":fingers=2", file.path() + ":force=0"}) {
        const auto refused = read_recorded_device(text, std::make_unique<HandClock>(time));
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
}

TEST(RecordedDevice, LocatesErrorsInLogs) {
    const std::string first = "1,0,0,0,0,0,1,0,0,0,0\n";
    EXPECT_EQ(refusal("time_s,finger,x,y,z\n1,0,0,0,0\n"),
              "line 1 names no column 'buttons'; a device's log has time_s, finger, x, y, z, buttons");
    EXPECT_EQ(refusal("1,0,0,0,0,0\n"),
              "line 1 names no column 'time_s'; a device's log has time_s, finger, x, y, z, buttons");
    EXPECT_EQ(refusal(log_header + "1,0,a,0,0,0,1,0,0,0,0\n"),
              "line 2, column 'x' holds 'a'; expected a finite number");
    EXPECT_EQ(refusal(log_header + ",0,0,0,0,0,1,0,0,0,0\n"),
              "line 2, column 'time_s' holds nothing; expected a finite number");
    EXPECT_EQ(refusal(log_header + "1,0,0,nan,0,0,1,0,0,0,0\n"),
              "line 2, column 'y' holds 'nan'; expected a finite number");
    EXPECT_EQ(refusal(log_header + "1,0,0,,0,0,1,0,0,0,0\n"),
              "line 2, column 'y' is empty while others are not; a place has x, y and z or none");
    EXPECT_EQ(refusal(log_header + "1,0,,,0,0,1,0,0,0,0\n"),
              "line 2, column 'z' is not empty while others are; a place has x, y and z or none");
    EXPECT_EQ(refusal(log_header + first + first + first),
              "line 3, column 'finger' is 0; must be 1, as each tick has 3");
    EXPECT_EQ(refusal(log_header + "1,1,0,0,0,0,1,0,0,0,0\n"),
              "line 2, column 'finger' is 1; must be 0, as each tick has 1");
    EXPECT_EQ(refusal(log_header + first + "0.5,0,0,0,0,0,1,0,0,0,0\n"),
              "line 3, column 'time_s' is not later than the tick before");
    EXPECT_EQ(refusal(log_header + first + "1,1,0,0,0,0,1,0,0,0,0\n2,0,0,0,0,0,1,0,0,0,0\n"),
              "line 4, column 'finger' is the last; its tick lacks fingers");
    EXPECT_EQ(
        refusal(log_header + first + "1,1,0,0,0,0,1,0,0,0,0\n2,0,0,0,0,0,1,0,0,0,0\n3,1,0,0,0,0,1,0,0,0,0\n"),
        "line 5, column 'time_s' has another time than the tick's first finger");
    EXPECT_EQ(refusal(log_header + "1,0,0,0,0,-1,1,0,0,0,0\n"),
              "line 2, column 'buttons' is no whole number from 0 to 4294967295");
    EXPECT_EQ(refusal(log_header + first + "1e300,0,0,0,0,0,1,0,0,0,0\n"),
              "line 3, column 'time_s' is more than a million seconds after the first");
    std::string many = log_header;
    for (int finger = 0; finger < 11; ++finger)
        many += "1," + std::to_string(finger) + ",0,0,0,0,1,0,0,0,0\n";
    EXPECT_EQ(refusal(many), "line 12, column 'time_s' has the same time in more than ten rows");
    nanoseconds time{0};
    const auto nowhere = read_recorded_device("there-is-no-such.csv", std::make_unique<HandClock>(time));
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().kind, ErrorKind::input);
}

TEST(RecordedDevice, AcceptsLogWithoutPositions) {
    const TemporaryFile file("device.csv", log_header + "0,0,,,,0,,0,0,0,0\n0.001,0,,,,0,,0,0,0,0\n");
    nanoseconds time{0};
    const auto driver = replay(file.path(), time);
    DeviceSample sample;
    ASSERT_TRUE(*driver->receive(sample, milliseconds(1)));
    EXPECT_TRUE(std::isnan(sample.metres[0].y));
}

TEST(RecordedDevice, RunsAsOrdinaryDevice) {
    std::string log = log_header;  // of 0.6 s, so that it is seen where this thread stands still for a while
    for (int tick = 0; tick < 600; ++tick)
        log += std::to_string(0.001 * tick) + ",0,0.25,0.5,-0.125,3,1,0,0,0,0\n";
    const TemporaryFile file("device.csv", log);
    const auto device = make_device("recorded:" + file.path(), {});
    ASSERT_TRUE(device);
    ASSERT_TRUE((*device)->open());
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    bool seen = false, ended = false;
    glm::dvec3 place, push(0, 0, 5);
    while (!ended && std::chrono::steady_clock::now() < until) {
        ASSERT_TRUE((*device)->read_positions(std::span(&place, 1)));
        ASSERT_TRUE((*device)->write_forces(std::span(&push, 1)));
        if (!std::isnan(place.x)) {
            EXPECT_EQ(place, glm::dvec3(0.25, 0.5, -0.125));
            EXPECT_EQ((*device)->buttons(), 3u);
            seen = true;
        }
        ended = seen && std::isnan(place.x) && !(*device)->prompt().empty();
    }
    EXPECT_TRUE(ended);
    EXPECT_TRUE((*device)->health());
}

/// The block of Python under "Logs" in docs/devices.md.
std::string documented_script() {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/docs/devices.md");
    std::string line, script;
    while (std::getline(in, line) && line != "## Logs") {
    }
    while (std::getline(in, line) && line != "```python") {
    }
    while (std::getline(in, line) && line != "```") script += line + "\n";
    return script;
}

/// Declarations of the block of C++ in docs/devices.md, without what is said of them.
std::vector<std::string> documented_driver() {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/docs/devices.md");
    std::string line;
    while (std::getline(in, line) && line != "   ```cpp") {
    }
    std::vector<std::string> calls;
    while (std::getline(in, line) && line != "   ```")
        if (const std::size_t end = line.find(';'); end != std::string::npos && line.find("//") > end)
            calls.push_back(line.substr(3, end - 3));
    return calls;
}

TEST(DeviceDriver, MatchesDocumentation) {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/device/drivers/device_driver.hpp");
    const std::string header((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto calls = documented_driver();
    ASSERT_EQ(calls.size(), 13u);
    for (const std::string& call : calls)
        EXPECT_NE(header.find("virtual " + call), std::string::npos) << call;
    for (std::size_t at = header.find(" = 0;", header.find("class DeviceDriver")); at != std::string::npos;
         at = header.find(" = 0;", at + 1)) {
        const std::size_t begin = header.rfind("virtual ", at) + 8;
        EXPECT_NE(std::find(calls.begin(), calls.end(), header.substr(begin, at - begin)), calls.end())
            << header.substr(begin, at - begin) << " must be there";
    }
}

TEST(DeviceLogs, AreReadByDocumentedScript) {
    const std::string text = documented_script();
    ASSERT_EQ(std::count(text.begin(), text.end(), '\n'), 10);
    const TemporaryFile script("read.py", text), out("out.txt", "");
    // Two fingers; the first goes 3 mm in two ticks and is lost in a third, and feels (0, 3, 4) N at most.
    const TemporaryFile log("device.csv", log_header +
                                              "0,0,0,0,0,0,0.5,0,0,0,0\n0,1,1,1,1,0,0.5,0,0,0,0\n"
                                              "0.001,0,0.001,0,0,0,0.5,0,3,4,1\n0.001,1,1,1,1,0,0.5,0,0,0,1\n"
                                              "0.002,0,0.001,0.002,0,0,0.5,0,0,1,1\n"
                                              "0.002,1,1,1,1,0,0.5,0,0,0,1\n"
                                              "0.003,0,,,,0,21.5,0,0,0,1\n0.003,1,1,1,1,0,0.5,0,0,0,1\n");
    const std::string command =
        "/usr/bin/python3 '" + script.path() + "' '" + log.path() + "' > '" + out.path() + "' 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream in(out.path());
    std::stringstream told;
    told << in.rdbuf();
    ASSERT_EQ(status, 0) << told.str();
    EXPECT_EQ(told.str(),
              "finger 1: 4 ticks, 1 without a place, path 3.0 mm, largest force 5.00 N\n"
              "finger 2: 4 ticks, 0 without a place, path 0.0 mm, largest force 0.00 N\n");
}

}  // namespace
}  // namespace touchable
