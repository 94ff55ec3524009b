// SPDX-License-Identifier: Apache-2.0
// The program's words on devices, on machines that may have any or none.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "device/drivers/known_devices.hpp"
#include "device/drivers/network_device.hpp"
#include "player/commands/machine_check.hpp"
#include "tests/player/program.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

/// A device's log of `seconds`, whose x flickers by 40 um and whose handle otherwise rests.
void write_log(const std::string& file, int seconds) {
    std::ofstream log(file);
    log << "time_s,finger,x,y,z,buttons,age_ms,fx,fy,fz,force_on\n";
    for (int tick = 0; tick < seconds * 1000; ++tick)
        log << tick / 1000 << '.' << std::to_string(1000 + tick % 1000).substr(1) << ",0,"
            << (tick % 2 == 0 ? "0" : "0.00004") << ",0.01,0,0,0.5,0,0,0,0\n";
}

TEST(Devices, ListEveryKind) {
    const Outcome run = succeed({"devices"});
    for (const DeviceKind& kind : device_kinds())
        EXPECT_PRED2(says, run.out, "\n    " + std::string(kind.name) + std::string(kind.keys) + " ")
            << kind.name;
    for (const char* part : {"\n    falcon:firmware=FILE ", "\n    woodenhaptics:file=FILE ",
                             "\n    recorded:FILE ", "\n    simulated "})
        EXPECT_PRED2(says, run.out, part);
    if (run.out.starts_with("No device")) {
        EXPECT_EQ(run.out.find("sudo udevadm control --reload") == std::string::npos, has_udev_rules())
            << run.out;
    }
    for (const char* part : {"\nWhat --device takes (docs/devices.md has each one's keys):\n    ",
                             "\nSee whether it works:  touchable check --device NAME\n",
                             "touchable touch CLIP --live --device NAME\n"})
        EXPECT_PRED2(says, run.out, part);
}

TEST(Devices, ListKindsAsJson) {
    const auto json = json_of({"devices", "--json"});
    EXPECT_TRUE(json["devices"].is_array());
    ASSERT_EQ(json["words"].size(), device_kinds().size() + 1);
    EXPECT_EQ(json["words"][0]["word"], "falcon");
    EXPECT_EQ(json["words"][0]["keys"], ":firmware=FILE");
    EXPECT_EQ(json["words"].back()["word"], "simulated");
}

/// For users who have the program without its source tree.
TEST(Devices, PrintUdevRules) {
    const Outcome run = succeed({"devices", "--udev-rules"});
    EXPECT_EQ(run.out, file_contents(std::string(TOUCHABLE_SOURCE_DIR) + "/share/udev/70-touchable.rules"));
}

TEST(DeviceCheck, MeasuresRecordedLog) {
    const TemporaryFolder folder;
    const std::string log = folder / "trouble.csv", report = folder / "report.txt";
    write_log(log, 8);
    const auto json = json_of(
        {"check", "--device", "recorded:" + log + ":force=4", "--seconds", "1", "--json", "--out", report});
    EXPECT_EQ(json["touchable_device_check"], 1);
    EXPECT_EQ(json["device"]["words"], "recorded:trouble.csv:force=4");
    EXPECT_EQ(json["device"]["axes_driven"], 0);
    EXPECT_EQ(json["readings"], 1000);
    EXPECT_GT(json["reports_per_s"].get<double>(), 100);
    EXPECT_LT(json["reports_per_s"].get<double>(), 1100);
    EXPECT_GT(json["interval_ms"]["count"].get<int>(), 100);
    EXPECT_GE(json["age_ms"]["p99"].get<double>(), json["age_ms"]["median"].get<double>());
    EXPECT_NEAR(json["rest"]["step_um"][0].get<double>(), 40, 1e-6);
    EXPECT_EQ(json["rest"]["step_um"][1].get<double>(), 0);
    EXPECT_NEAR(json["rest"]["deviation_um"][0].get<double>(), 20, 10);
    EXPECT_FALSE(json["rest"]["moved"].get<bool>());
    EXPECT_EQ(json["losses"], 0);
    EXPECT_EQ(json["stiffness"]["not_tried"], "it exerts no force");

    const std::string words = file_contents(report);
    for (const char* part : {"recorded:trouble.csv:force=4", "touchable ", "Linux ", "reports   ",
                             "age       ", "places    ", "stiffness not tried: it exerts no force"})
        EXPECT_PRED2(says, words, part) << part << " in\n" << words;
    EXPECT_EQ(words.find(folder.path().string()), std::string::npos) << "folder names identify a person";

    const Outcome again = run_touchable({"check", "--device", "recorded:" + log, "--out", report});
    EXPECT_EQ(again.code, 2) << "the report is there already";
    EXPECT_EQ(file_contents(report), words);
}

TEST(DeviceCheck, ReportsWhatDeviceSays) {
    const TemporaryFolder folder;
    const std::string log = folder / "short.csv", report = folder / "report.txt";
    write_log(log, 1);
    const auto json =
        json_of({"check", "--device", "recorded:" + log, "--seconds", "1", "--json", "--out", report});
    EXPECT_PRED2(says, json["device"]["prompt"].get<std::string>(), "has ended: nothing holds the handle");
    EXPECT_PRED2(says, file_contents(report), "\nit says   the log ");
}

TEST(DeviceCheck, ReportsDeviceThatCannotOpen) {
    const Outcome run = expect_failure({"check", "--device", "spacemouse:node=/dev/nonexistent-hidraw"}, 5);
    EXPECT_TRUE(run.out.empty()) << run.out;
    EXPECT_PRED2(says, run.err, "/dev/nonexistent-hidraw: does not exist; must be");
}

TEST(DeviceCheck, ReportsMissingFileAndDevice) {
    if (!run_touchable({"devices"}).out.starts_with("No device")) GTEST_SKIP() << "a device is connected";
    const TemporaryFolder folder;
    for (const char* device : {"falcon:firmware=", "woodenhaptics:file="}) {
        const std::string name(device, std::string(device).find(':'));
        const Outcome run = expect_failure({"check", "--device", device + (folder / "none.bin").string()}, 3,
                                           "none.bin: does not exist; expected ");
        EXPECT_PRED2(says, run.err, "; and no " + name + " is connected");
        const Outcome on_folder = run_touchable({"check", "--device", device + folder.path().string()});
        EXPECT_PRED2(says, on_folder.err, ": is a folder; expected ");
    }
    const Outcome log = run_touchable({"check", "--device", "recorded:" + (folder / "none.csv").string()});
    EXPECT_PRED2(says, log.err, "none.csv: does not exist; expected a CSV file\n");
}

TEST(DeviceCheck, SuggestsNearestDeviceName) {
    const auto refusal = [](const char* name) { return run_touchable({"check", "--device", name}).err; };
    const std::string falco = refusal("falco");
    EXPECT_PRED2(says, falco,
                 "unknown device 'falco'; did you mean falcon? There are falcon, inverse3, woodenhaptics, "
                 "spacemouse, network, recorded, simulated; and mouse, in the window alone");
    EXPECT_PRED2(says, refusal("netwrok:port=6000"), "did you mean network?");
    EXPECT_PRED2(says, refusal("inverse"), "did you mean inverse3?");
    EXPECT_PRED2(says, refusal("xyz"), "unknown device 'xyz'; there are falcon, ") << "none is near";
}

TEST(DeviceCheck, TimesOutWithoutHand) {
    const TemporaryFolder folder;
    const std::string port = std::to_string(unused_port());
    expect_failure(
        {"check", "--device", "network:port=" + port, "--wait", "1", "--out", folder / "report.txt"}, 5,
        "no position within 1 s; waiting for a hand at UDP 127.0.0.1:" + port);
    EXPECT_EQ(folder.file_count(), 0u);
}

TEST(DeviceCheck, StopsWhenInterrupted) {
    expect_failure(run_interrupted_at_once({"check", "--device",
                                            "network:port=" + std::to_string(unused_port()), "--wait", "60"}),
                   130);
}

/// `check` of a network hand that rests, by a person at a terminal of their own.
class TerminalCheck : public ::testing::Test {
protected:
    /// Types `answer` once it asks for the springs, and plays the hand until it ends.
    void run(const std::string& answer) {
        const std::string port = std::to_string(unused_port()), device = "network:stiffness=0.1,port=" + port;
        const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
        ASSERT_TRUE(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0);
        const std::string name = ptsname(terminal), said = folder_ / "said", json = folder_ / "json";
        const int in = open(name.c_str(), O_RDWR | O_NOCTTY), out = creat(json.c_str(), 0600),
                  err = creat(said.c_str(), 0600);
        const pid_t program =
            start_touchable({"check", "--device", device, "--seconds", "1", "--json"}, in, out, err);
        for (const int each : {in, out, err}) close(each);
        for (bool asked = false; waitpid(program, nullptr, WNOHANG) == 0;) {
            rest(static_cast<std::uint16_t>(std::stoi(port)));
            if (asked || file_contents(said).find("n and Enter leaves that out") == std::string::npos)
                continue;
            asked = true;
            EXPECT_EQ(write(terminal, answer.data(), answer.size()), static_cast<ssize_t>(answer.size()));
        }
        close(terminal);
        report_ = json_in(json);
        ASSERT_TRUE(report_.is_object()) << file_contents(said);
    }
    /// A packet out, and what has come back.
    void rest(std::uint16_t port) {
        if (socket_ < 0) {
            socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
            const sockaddr_in to = loopback(port);
            EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
        }
        NetworkPacket packet;
        packet.sequence = ++sequence_;
        packet.vectors[0] = {0, 0, 0.05};
        const auto bytes = encode(packet);
        [[maybe_unused]] const auto sent = ::send(socket_, bytes.data(), bytes.size(), 0);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::byte room[1024];
        for (ssize_t came; (came = recv(socket_, room, sizeof room, 0)) > 0;) {
            const auto answer = decode_network_packet(std::span(room).first(static_cast<std::size_t>(came)));
            if (answer) largest_ = std::max(largest_, glm::length(answer->vectors[0]));
        }
    }
    ~TerminalCheck() override { close(socket_); }

    const TemporaryFolder folder_;
    int socket_ = -1;
    std::uint32_t sequence_ = 0;
    double largest_ = 0;  // N, that the hand was given
    nlohmann::json report_;
};

TEST_F(TerminalCheck, NSkipsSprings) {
    run("n\n");
    EXPECT_EQ(report_["stiffness"]["not_tried"], "it was left out");
    EXPECT_EQ(largest_, 0) << "a force without consent";
}

TEST_F(TerminalCheck, EnterTriesSprings) {
    run("\n");
    EXPECT_FALSE(report_["stiffness"].contains("not_tried") &&
                 report_["stiffness"]["not_tried"] == "it was left out")
        << report_["stiffness"];
}

/// True where the program ignores a signal while it waits for a hand.
bool ignores(int signal, const Words& words) {
    const pid_t program = start_touchable(words);
    bool ignored = false;
    while (!ignored && waitpid(program, nullptr, WNOHANG) == 0) {
        std::ifstream status("/proc/" + std::to_string(program) + "/status");
        for (std::string line; std::getline(status, line);)
            if (line.starts_with("SigIgn:"))
                ignored = (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1U) == 1;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (!ignored) return false;
    kill(program, SIGKILL);
    waitpid(program, nullptr, 0);
    return true;
}

/// By Ctrl-Z, and by terminals that it is in the background of, it would stop with a force on.
TEST(HeldDevice, IgnoresTerminalStopSignals) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    succeed({"make", "globe", clip, "--size", "64x48", "--frames", "2"});
    for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU}) {
        EXPECT_TRUE(ignores(signal, {"touch", clip, "--live", "--device",
                                     "network:port=" + std::to_string(unused_port()), "--seconds", "3"}))
            << signal;
        EXPECT_TRUE(ignores(
            signal, {"check", "--device", "network:port=" + std::to_string(unused_port()), "--wait", "3"}))
            << signal;
    }
}

TEST(DeviceCheck, RejectsInvalidOptions) {
    for (const Words& words : {Words{"--device", "falconn"},
                               {"--device", "simulated"},
                               {"--device", "network:prot=1"},
                               {"--device", ""},
                               {"--device", "network", "--size", "64x48"},
                               {"--device", "network", "--seconds", "0"},
                               {"--hands-off"},
                               {"--seconds", "3"}}) {
        expect_failure(plus({"check"}, words), 2);
    }
}

class LogDevice : public ::testing::Test {
protected:
    LogDevice() {
        succeed({"make", "globe", clip, "--size", "64x48", "--frames", "2"});
        write_log(log, 1);
    }
    Outcome touch(const Words& more) const {
        return run_touchable(plus({"touch", clip, "--live", "--device", "recorded:" + log}, more));
    }

    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", log = folder / "trouble.csv", report = folder / "r.json";
};

TEST_F(LogDevice, EndsRunAtLogEnd) {
    const Outcome run = touch({"--json", report});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_PRED2(says, run.out, "has ended: nothing holds the handle any more; the run ends there");
    const auto facts = json_in(report);
    const auto ticks = facts["ticks"].get<int>() + facts["skipped_ticks"].get<int>();
    EXPECT_GT(ticks, 0) << "the log begins when it is opened, a moment before the hand";
    EXPECT_LT(ticks, 2900) << "not the clip's three seconds, nor for ever";
}

TEST_F(LogDevice, RunsForRequestedSeconds) {
    const Outcome run = touch({"--seconds", "1.5", "--json", report});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.out.find("the run ends there"), std::string::npos) << run.out;
    const auto facts = json_in(report);
    EXPECT_GE(facts["ticks"].get<int>() + facts["skipped_ticks"].get<int>(), 1500);
    EXPECT_LE(facts["ticks"].get<int>(), 1500);
}

TEST_F(LogDevice, ExertsNoForce) {
    for (const Words& more : {Words{"--json", report}, {"--force-on", "--json", folder / "on.json"}}) {
        const Outcome run = touch(more);
        EXPECT_EQ(run.code, 0) << run.err;
        EXPECT_PRED2(says, run.err, "the recorded device exerts no force");
        EXPECT_PRED2(says, run.out, "the device exerts no force\n");
        EXPECT_EQ((run.out + run.err).find("forces on"), std::string::npos) << run.out << run.err;
        EXPECT_EQ(json_in(more.back())["forces_on_ticks"], 0);
    }
}

TEST_F(LogDevice, ReportsMissingHand) {
    const std::string port = std::to_string(unused_port());
    const Outcome run = succeed(
        {"touch", clip, "--live", "--device", "network:port=" + port, "--seconds", "0.3", "--json", report});
    EXPECT_PRED2(says, run.err, "press the device's first button (bit 0 of its buttons)");
    EXPECT_PRED2(says, run.err, "waiting for a hand at UDP 127.0.0.1:" + port);
    EXPECT_PRED2(says, run.out, "no hand ever came to UDP 127.0.0.1:" + port + "\n");
    EXPECT_EQ(run.out.find("no finger touched anything"), std::string::npos) << run.out;
    EXPECT_EQ(run.out.find("changed by it"), std::string::npos) << run.out;
    EXPECT_EQ(json_in(report)["warnings"].back(), "no hand ever came to UDP 127.0.0.1:" + port);
}

TEST(DeviceReport, NamesNoFolders) {
    EXPECT_EQ(without_folders("falcon:firmware=/home/ada/novint.bin,force=2"),
              "falcon:firmware=novint.bin,force=2");
    EXPECT_EQ(without_folders("recorded:/home/ada/a.csv:force=4"), "recorded:a.csv:force=4");
    EXPECT_EQ(without_folders("recorded:ada/logs/a.csv"), "recorded:a.csv");
    EXPECT_EQ(without_folders("spacemouse:node=/dev/hidraw0"), "spacemouse:node=/dev/hidraw0");
    EXPECT_EQ(without_folders("network"), "network");
}

TEST(DeviceReport, DescribesStiffnessSearch) {
    DeviceReport report;
    report.capabilities.answers = true;
    report.facts.left_out = 7;
    const auto expect = [&report](const char* part) {
        const std::string text = to_text(report);
        EXPECT_PRED2(says, text, part);
    };
    report.stiffness = {.quiet = 800, .shaking = 1131, .why = "its swings doubled", .most_force = 1.5};
    expect(
        "stiffness 0.8 N/mm is quiet, 1.13 N/mm is not: its swings doubled (no hand on it, 1.5 N at most)");
    expect("answer    round trip, from a force to the position that answers it: ");
    expect("7 reports");
    report.stiffness = {.quiet = 1000, .most_force = 1.5};
    expect("1 N/mm, its own limit, is quiet");
    report.stiffness = {.quiet = 0, .shaking = 100, .why = "it went 3 mm away"};
    expect("even 0.1 N/mm is not quiet: it went 3 mm away");
    report.stiffness = {.quiet = 1000, .moved = false};
    expect("friction held the handle against every nudge");
    report.facts.left_out = -1;
    report.capabilities.answers = false;
    expect("answer    from a force to the next position, which comes by itself: ");
    EXPECT_EQ(to_text(report).find(" reports, "), std::string::npos) << "it does not count them";
    report.watch.rest.farthest_m = 0.004;
    expect("the handle moved (by 4 mm)");
}

}  // namespace
}  // namespace touchable::test
