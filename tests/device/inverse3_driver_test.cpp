// SPDX-License-Identifier: Apache-2.0
// The driver over a service of lines that a test writes: every fault at a known moment.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <deque>
#include <limits>
#include <random>

#include "device/drivers/inverse3_device.hpp"
#include "device/drivers/safety_watchdog.hpp"
#include "tests/device/fault_sessions.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;

constexpr microseconds no_time{0};

/// The messages that went over the wire, and those that come next.
struct Wire {
    std::vector<std::string> sent;
    std::deque<std::string> coming;
    std::string version = R"({"project_version":"3.5.0.0"})";
    std::string scale = "0.5";  // its force scale
    std::int64_t now_ns = 1;    // passes in a wait for what does not come
    bool answers = true;        // each message with `state`
    bool broken = false;
    std::string state = arm_text("049D", "");

    static std::string arm_text(const std::string& id, const std::string& more) {
        return R"({"inverse3":[{"device_id":")" + id + R"(",)" + more +
               R"("state":{"cursor_position":{"x":0.01,"y":-0.12,"z":0.17}}}]})";
    }
};

class WireTransport final : public Transport {
public:
    explicit WireTransport(Wire& wire) : wire_(wire) {}
    Result<void> send(std::span<const std::byte> bytes) override {
        if (wire_.broken) return Error{ErrorKind::device, "the wire is cut"};
        wire_.sent.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        if (wire_.answers) wire_.coming.push_back(wire_.state);
        return {};
    }
    Result<std::size_t> receive(std::span<std::byte> room, microseconds patience) override {
        if (wire_.broken) return Error{ErrorKind::device, "the wire is cut"};
        if (wire_.coming.empty()) {
            wire_.now_ns += std::chrono::nanoseconds(patience).count();
            return std::size_t{0};
        }
        const std::string message = wire_.coming.front();
        wire_.coming.pop_front();
        std::memcpy(room.data(), message.data(), message.size());
        return message.size();
    }
    int descriptor() const override { return 77; }

private:
    Wire& wire_;
};

class WireService final : public HaplyService {
public:
    explicit WireService(Wire& wire) : wire_(wire) {}
    std::string address() const override { return "ws://wire"; }
    Result<std::string> get(const std::string& path, std::chrono::milliseconds) override {
        return path == "/version" ? wire_.version : R"({"ok":true,"data":)" + wire_.scale + "}";
    }
    Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds) override {
        wire_.coming.push_front(wire_.state);
        return std::unique_ptr<Transport>(std::make_unique<WireTransport>(wire_));
    }

private:
    Wire& wire_;
};

const std::string zero_force =
    R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":0.0,"y":0.0,"z":0.0}}}}]})";

struct Driven {
    Wire wire;
    Inverse3Driver driver;
    explicit Driven(Inverse3Choice choice = {})
        : driver(std::move(choice), std::make_unique<WireService>(wire), [this] { return wire.now_ns; }) {}

    Result<void> connect() { return driver.connect(); }
    Result<void> push(const glm::dvec3& newtons) { return driver.send(std::span(&newtons, 1)); }
    std::string refusal() {
        const auto connected = connect();
        if (connected) return "taken";
        EXPECT_EQ(connected.error().kind, ErrorKind::device);
        EXPECT_EQ(connected.error().message.find('\n'), std::string::npos);
        driver.disconnect();
        return connected.error().message;
    }
};

TEST(Inverse3Driver, MeasuresPositionFromWorkspaceCentre) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    EXPECT_EQ(driven.wire.sent, std::vector<std::string>{zero_force}) << "unpowered before all else";
    ASSERT_TRUE(driven.push({0, 1, 0}));
    EXPECT_NE(driven.wire.sent.back().find(R"("z":1.0)"), std::string::npos);
    DeviceSample sample;
    ASSERT_TRUE(*driven.driver.receive(sample, no_time));
    // (0.01, 0.17, 0.12) from the base in our axes; the centre is (0, 0.15, 0.12).
    EXPECT_NEAR(sample.metres[0].x, 0.01, 1e-15);
    EXPECT_NEAR(sample.metres[0].y, 0.02, 1e-15);
    EXPECT_NEAR(sample.metres[0].z, 0, 1e-15);
    EXPECT_FALSE(*driven.driver.receive(sample, no_time)) << "one answer to one message";
}

TEST(Inverse3Driver, DisconnectSendsZeroForce) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    ASSERT_TRUE(driven.push({0, 0, 4}));
    EXPECT_NE(driven.wire.sent.back(), zero_force);
    driven.driver.disconnect();
    EXPECT_EQ(driven.wire.sent.back(), zero_force);
    const std::size_t sent = driven.wire.sent.size();
    driven.driver.disconnect();
    EXPECT_EQ(driven.wire.sent.size(), sent);
    EXPECT_FALSE(driven.push({0, 0, 0}));
}

TEST(Inverse3Driver, FramesZeroForcePacket) {
    Driven driven;
    EXPECT_FALSE(driven.driver.zero_force_packet());
    ASSERT_TRUE(driven.connect());
    const auto word = driven.driver.zero_force_packet();
    ASSERT_TRUE(word);
    EXPECT_EQ(word->descriptor, 77);
    EXPECT_EQ(word->bytes.size(), 6 + zero_force.size()) << "short enough for a head of six bytes";
    ASSERT_LE(word->bytes.size(), SafetyWatchdog::most_bytes);
    EXPECT_EQ(word->bytes[0], std::byte{0x81});
    std::string text;
    for (std::size_t at = 6; at < word->bytes.size(); ++at)
        text += static_cast<char>(word->bytes[at] ^ word->bytes[2 + (at - 6) % 4]);
    EXPECT_EQ(text, zero_force);
    driven.driver.disconnect();
    EXPECT_FALSE(driven.driver.zero_force_packet());
}

TEST(Inverse3Driver, LimitsMessagesToSilentService) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    driven.wire.answers = false;
    const std::size_t before = driven.wire.sent.size();
    for (int n = 0; n < 5; ++n) ASSERT_TRUE(driven.push({0, 1, 0}));
    EXPECT_EQ(driven.wire.sent.size(), before + Inverse3Driver::most_unanswered);
    for (int n = 0; n < 5; ++n) ASSERT_TRUE(driven.push({0, 0, 0}));
    EXPECT_EQ(driven.wire.sent.size(), before + Inverse3Driver::most_unanswered + 1);
    EXPECT_EQ(driven.wire.sent.back(), zero_force);
}

TEST(Inverse3Driver, DropsSilentService) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    driven.wire.answers = false;
    ASSERT_TRUE(driven.push({0, 0, 1}));
    DeviceSample sample;
    driven.wire.now_ns += 500'000'000;
    const auto late = driven.driver.receive(sample, no_time);
    ASSERT_TRUE(late) << "it may still answer";
    EXPECT_FALSE(*late);
    driven.wire.now_ns += 1'000'000;
    const auto gone = driven.driver.receive(sample, no_time);
    ASSERT_FALSE(gone);
    EXPECT_NE(gone.error().message.find("has not answered for half a second"), std::string::npos);
}

TEST(Inverse3Driver, CompensatesForceScaleAboveOne) {
    for (const auto& [scale, sent] : {std::pair{"2.0", R"("z":2.0)"}, {"0.5", R"("z":4.0)"}}) {
        Driven driven;
        driven.wire.scale = scale;
        ASSERT_TRUE(driven.connect());
        ASSERT_TRUE(driven.push({0, 4, 0}));
        EXPECT_NE(driven.wire.sent.back().find(sent), std::string::npos) << driven.wire.sent.back();
    }
}

TEST(Inverse3Driver, TakesNewestLateAnswer) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    driven.wire.coming = {
        R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.1,"y":0,"z":0}}}]})", "garbage",
        R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.2,"y":0,"z":0}}}]})",
        R"({"inverse3":[{"device_id":"049D","state":{}}]})"};
    DeviceSample sample;
    ASSERT_TRUE(*driven.driver.receive(sample, no_time));
    EXPECT_DOUBLE_EQ(sample.metres[0].x, 0.2);
}

/// Answers to another process, which spoke to the service while this one stood still.
TEST(Inverse3Driver, ForgetsAnswersToOtherProcess) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    driven.wire.answers = false;
    for (int force = 0; force < Inverse3Driver::most_unanswered; ++force) ASSERT_TRUE(driven.push({0, 0, 1}));
    driven.wire.coming.assign(40, driven.wire.state);
    driven.wire.now_ns += 1'000'000'000;
    ASSERT_TRUE(driven.driver.forget_what_came());
    const std::size_t before = driven.wire.sent.size();
    ASSERT_TRUE(driven.push({0, 0, 1}));
    EXPECT_EQ(driven.wire.sent.size(), before + 1) << "nothing is under way";
    DeviceSample sample;
    const auto came = driven.driver.receive(sample, no_time);
    ASSERT_TRUE(came) << came.error().message;
    EXPECT_FALSE(*came);
}

TEST(Inverse3Driver, ToleratesLimitedNonsense) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    DeviceSample sample;
    sample.metres[0] = {1, 2, 3};
    for (int n = 1; n < Inverse3Driver::most_nonsense; ++n) {
        driven.wire.coming.assign(1, "{\"inverse3\":");
        const auto heard = driven.driver.receive(sample, no_time);
        ASSERT_TRUE(heard) << n;
        EXPECT_FALSE(*heard);
    }
    EXPECT_EQ(sample.metres[0], glm::dvec3(1, 2, 3));
    driven.wire.coming.assign(1, "{\"inverse3\":");
    EXPECT_FALSE(driven.driver.receive(sample, no_time));
}

TEST(Inverse3Driver, ReportsLostArmAndConnection) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    driven.wire.coming = {R"({"inverse3":[]})"};
    DeviceSample sample;
    const auto gone = driven.driver.receive(sample, no_time);
    ASSERT_FALSE(gone);
    EXPECT_NE(gone.error().message.find("Inverse3 049D is gone"), std::string::npos);
    driven.wire.broken = true;
    EXPECT_FALSE(driven.push({0, 0, 0}));
    EXPECT_FALSE(driven.driver.receive(sample, no_time));
    driven.driver.disconnect();
    driven.wire.broken = false;
    driven.wire.coming.clear();
    EXPECT_TRUE(driven.connect()) << "and it is found again";
}

TEST(Inverse3Driver, UncalibratedArmHasNoPosition) {
    Driven driven;
    ASSERT_TRUE(driven.connect());
    const auto tells = [&](const std::string& status) {
        driven.wire.coming.assign(1, Wire::arm_text("049D", R"("status":)" + status + ","));
        DeviceSample sample;
        EXPECT_TRUE(*driven.driver.receive(sample, no_time));
        return std::make_pair(std::isnan(sample.metres[0].x), driven.driver.prompt());
    };
    EXPECT_EQ(tells(R"({"calibrated":false,"power_supply":true})"),
              std::make_pair(
                  true, std::string("Inverse3 049D is not calibrated: calibrate it as its manual says")));
    EXPECT_EQ(tells(R"({"calibrated":true,"power_supply":false})"),
              std::make_pair(false, std::string("Inverse3 049D has no power: plug in its power supply")));
    EXPECT_EQ(tells(R"({"calibrated":true,"power_supply":true,"ready":true})").second,
              "the Haply service changes what is felt (force_scale 0.5); change it in Haply Hub if that is "
              "not meant");
}

/// The arm's configuration, and its workspace's transform.
struct Inverse3Case {
    const char *config, *transform, *expected;
};

const std::string identity =
    R"({"position":{"x":0,"y":0,"z":0},"rotation":{"w":-1,"x":0,"y":0,"z":1e-9},"scale":{"x":1,"y":1,"z":0.99999994}})";

std::string state_with(const std::string& config, const std::string& transform) {
    return R"({"inverse3":[{"device_id":"049D","config":{)" + config +
           R"(},"state":{"cursor_position":{"x":0.01,"y":-0.12,"z":0.17},"transform":)" +
           (transform.empty() ? identity : transform) + "}}]}";
}

TEST(Inverse3Driver, RefusesOtherLengthsAndAxes) {
    for (const Inverse3Case& each : std::initializer_list<Inverse3Case>{
             {R"("basis":{"permutation":"XZY"})", "", R"(basis/permutation "XZY"; must be XYZ)"},
             {R"("mount":{"scale":{"x":3,"y":3,"z":3}})", "", "mount/scale"},
             {R"("mount":{"scale":{"x":1,"y":1,"z":-1}})", "", "must be 1 along x, y and z"},
             {R"("mount":{"scale":3})", "", "mount/scale 3; must be"},
             {R"("mount":{"transform":{"scale":{"x":2,"y":2,"z":2}}})", "", "mount/transform/scale"},
             {R"("mount":{"rotation":{"w":0.7071,"x":0,"y":0,"z":0.7071}})", "", "mount/rotation"},
             {R"("mount":{"position":7})", "", "mount/position 7; must be x, y and z in metres"},
             {R"("preset":"led_front")", "", R"(preset "led_front"; must be defaults)"},
             {R"("filters":{"force_gate":{"gain":3}})", "", "filters/force_gate/gain 3; must be 0 to 1"},
             {R"("filters":{"damping":{"scalar":-1}})", "", "filters/damping/scalar -1; must be 0 or more"},
             {R"("filters":{"damping":{"vector":{"x":0,"y":-1,"z":0}}})", "",
              "damping/vector/y -1; must be 0 or more"},
             {"", R"({"scale":{"x":3,"y":3,"z":3}})", "transform/scale"},
             {"", R"({"rotation":{"w":0,"x":0,"y":0,"z":1}})", "transform/rotation"}}) {
        Driven driven;
        driven.wire.state = state_with(each.config, each.transform);
        EXPECT_NE(driven.refusal().find(each.expected), std::string::npos) << driven.refusal();
        EXPECT_TRUE(driven.wire.sent.empty()) << "no force";
    }
    for (const Inverse3Case& changed : std::initializer_list<Inverse3Case>{
             {"", R"({"scale":{"x":3,"y":3,"z":3}})", "transform/scale"},
             {R"("mount":{"rotation":{"w":0,"x":0,"y":0,"z":1}})", "", "mount/rotation"},
             {R"("mount":{"position":{"x":0.01,"y":0,"z":0}})", "", "another mount for 049D than when"},
             {R"("preset":"arm_front_centered")", "", "another preset for 049D than when"}}) {
        Driven driven;
        ASSERT_TRUE(driven.connect());
        driven.wire.coming.assign(1, state_with(changed.config, changed.transform));
        DeviceSample sample;
        const auto received = driven.driver.receive(sample, no_time);
        ASSERT_FALSE(received) << changed.expected << ": changed while it is held";
        EXPECT_NE(received.error().message.find(changed.expected), std::string::npos)
            << received.error().message;
    }
    Driven driven;
    driven.wire.scale = "-1";
    EXPECT_NE(driven.refusal().find("force_scale -1; must be 0 or more"), std::string::npos);
}

TEST(Inverse3Driver, SaysWhatChangesForces) {
    for (const Inverse3Case& each : std::initializer_list<Inverse3Case>{
             {R"("preset":"defaults","handedness":"right","home_return":{"enabled":false},"mount":null)", "",
              ""},
             {R"("filters":{"force_gate":{"gain":0.3}})", "", "filters/force_gate/gain 0.3"},
             {R"("filters":{"damping":{"scalar":1.25}})", "", "filters/damping/scalar 1.25"},
             {R"("filters":{"damping":{"vector":{"x":0.0,"y":0.0,"z":0.0}}})", "", ""},
             {R"("filters":{"damping":{"vector":{"x":0,"y":1,"z":0}}})", "", "filters/damping/vector/y 1"},
             {R"("torque_scaling":{"enabled":true})", "", "torque_scaling/enabled true"},
             {R"("gravity_compensation":{"enabled":false})", "", "gravity_compensation/enabled false"},
             {R"("gravity_compensation":{"scaling_factor":0.8})", "", "scaling_factor 0.8"},
             {R"("handedness":"left")", "", R"(handedness "left")"},
             {R"("home_return":{"enabled":true})", "", "home_return/enabled true"},
             {R"("preset":"arm_front_centered")", "", R"(preset "arm_front_centered")"},
             {R"("mount":)", R"({"position":{"x":0.5,"y":-0.25,"z":1}})", ""}}) {
        Driven driven;
        driven.wire.scale = "1";
        const bool has_mount = std::string(each.config).ends_with(':');
        driven.wire.state = state_with(each.config + (has_mount ? identity : ""), each.transform);
        const auto connected = driven.connect();
        ASSERT_TRUE(connected) << connected.error().message;
        EXPECT_NE(driven.driver.prompt().find(each.expected), std::string::npos) << driven.driver.prompt();
        EXPECT_EQ(driven.driver.prompt().empty(), std::string(each.expected).empty());
    }
}

TEST(Inverse3Driver, TakesMountPositionIntoAccount) {
    Driven driven;
    driven.wire.state = state_with(R"("mount":{"position":{"x":0.01,"y":0,"z":0}})",
                                   R"({"position":{"x":0,"y":0,"z":0.02}})");
    ASSERT_TRUE(driven.connect());
    ASSERT_TRUE(driven.push({0, 0, 0}));
    DeviceSample sample;
    ASSERT_TRUE(*driven.driver.receive(sample, no_time));
    EXPECT_LT(glm::length(sample.metres[0]), 1e-15) << "(0, 0.15, 0.12) from the base: its centre";
}

TEST(Inverse3Driver, RejectsUnknownServices) {
    {
        Driven driven;
        driven.wire.version = R"({"project_version":"4.0.1.0"})";
        EXPECT_EQ(driven.refusal(),
                  "Haply Inverse Service 4.0 is not known here; must be 3.1 to any other 3.x");
        EXPECT_TRUE(driven.wire.sent.empty());
    }
    {
        Driven driven;
        driven.wire.version = "";
        EXPECT_NE(driven.refusal().find("inverse3:service=3.4"), std::string::npos);
    }
    {
        Driven driven;
        driven.wire.state = R"({"inverse3":[]})";
        EXPECT_EQ(driven.refusal(), "the Haply service knows of no Inverse3; plug it in and switch it on");
    }
    {
        Driven driven(*read_inverse3_choice("id=04BA"));
        EXPECT_EQ(driven.refusal(), "there is no Inverse3 '04BA'; the Haply service knows of 049D");
    }
}

TEST(Inverse3Driver, GivenVersionSkipsQuery) {
    Driven driven(*read_inverse3_choice("service=3.4"));
    driven.wire.version = "";
    ASSERT_TRUE(driven.connect());
    EXPECT_NE(driven.wire.sent.back().find(R"("values")"), std::string::npos);
}

/// Short, corrupt, repeated, late, lost and cut at random moments.
TEST(Inverse3Driver, RandomFaultsEndWithZero) {
    int losses = 0;
    for (unsigned seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 chance(seed);
        const auto one_in = [&](unsigned many) { return chance() % many == 0; };
        Driven driven;
        ASSERT_TRUE(driven.connect());
        for (int step = 0; step < 150; ++step) {
            std::string next = driven.wire.state;
            if (one_in(4)) next.resize(1 + chance() % next.size());
            if (one_in(4)) next[chance() % next.size()] ^= static_cast<char>(1u << chance() % 8);
            for (unsigned copies = chance() % 4; copies > 0; --copies) driven.wire.coming.push_back(next);
            driven.wire.broken = one_in(50);
            driven.wire.answers = !one_in(3);
            DeviceSample sample;
            const auto heard = driven.driver.receive(sample, no_time);
            if (heard && *heard) {
                ASSERT_TRUE(std::isfinite(sample.metres[0].x));
            }
            const bool sent = bool(driven.push({0, 0, one_in(2) ? 1.0 : 0.0}));
            if (heard && sent) continue;
            ++losses;
            const bool cut = driven.wire.broken;
            driven.driver.disconnect();
            if (!cut) {
                ASSERT_EQ(driven.wire.sent.back(), zero_force);
            }
            driven.wire.broken = false;
            driven.wire.answers = true;
            driven.wire.coming.clear();
            ASSERT_TRUE(driven.connect());
            ASSERT_EQ(driven.wire.sent.back(), zero_force);
        }
    }
    EXPECT_GT(losses, 15);
}

TEST(Inverse3Driver, ConnectingCanBeCancelled) {
    Driven driven;
    driven.wire.state = "garbage";
    std::stop_source given_up;
    given_up.request_stop();
    const auto connected = work_until(given_up.get_token(), [&] { return driven.connect(); });
    ASSERT_FALSE(connected);
    EXPECT_EQ(connected.error().kind, ErrorKind::interrupted);
}

TEST(Inverse3Device, KeysAreChecked) {
    const auto choice =
        read_inverse3_choice("id=04BA,port=4711,up=0.2,towards=0.1,right=-0.05,force=8,stiffness=2");
    ASSERT_TRUE(choice);
    EXPECT_EQ(choice->id, "04BA");
    EXPECT_EQ(choice->port, 4711);
    EXPECT_EQ(choice->centre, glm::dvec3(-0.05, 0.2, 0.1));
    EXPECT_EQ(choice->limits.max_force, 8);
    EXPECT_EQ(choice->limits.max_stiffness, 2000);
    for (const char* keys :
         {"port=0", "force=0", "force=nan", "force=100", "service=x", "service=4.0", "colour=red", "id="}) {
        const auto refused = read_inverse3_choice(keys);
        ASSERT_FALSE(refused) << keys;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    }
}

}  // namespace
}  // namespace touchable

namespace touchable::test {
namespace {

/// The service of an Inverse3 that answers each text with one. Now and then the arm is unplugged from it.
class FaultyInverse3 final : public FaultyDevice {
public:
    FaultyInverse3() : FaultyDevice("inverse3", {.longest_force = 5.0 + 1e-9}) {}

    std::unique_ptr<DeviceDriver> driver() override {
        gone_until_ns_ = 0;
        return std::make_unique<Inverse3Driver>(Inverse3Choice{}, std::make_unique<Service>(*this),
                                                [this] { return time.now_ns(); });
    }
    void live(double angle) override { place_ = 0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0); }
    void suffer_its_own() override { gone_until_ns_ = time.now_ns() + 30 * VirtualTime::ms; }

private:
    void answer() {
        const bool is_there = time.now_ns() >= gone_until_ns_;
        char text[160] = R"({"inverse3":[]})";
        // From its base, in its axes: x right, y forward, z up.
        if (is_there)
            std::snprintf(
                text, sizeof text,
                R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":%.9f,"y":%.9f,"z":%.9f}}}]})",
                place_.x, -(place_.z + 0.12), place_.y + 0.15);
        FaultyLine::Message message;
        for (const char* at = text; *at != 0; ++at) message.push_back(static_cast<std::byte>(*at));
        line.tell(std::move(message), is_there ? place_ : glm::dvec3(std::nan("")));
    }
    void hear(const std::string& text) {
        const auto at = text.find(R"({"x":)");
        glm::dvec3 force(0);
        if (at != std::string::npos) {
            EXPECT_EQ(
                std::sscanf(text.c_str() + at, R"({"x":%lf,"y":%lf,"z":%lf)", &force.x, &force.y, &force.z),
                3)
                << text;
            line.went_out(glm::length(force));
        }
        answer();
    }

    class Texts final : public Transport {
    public:
        explicit Texts(FaultyInverse3& to) : to_(to) {}
        Result<void> send(std::span<const std::byte> bytes) override {
            if (!to_.line.passes()) return cut();
            to_.hear(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
            return {};
        }
        Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override {
            if (to_.line.is_cut()) return cut();
            const auto came = to_.line.next(patience);
            if (to_.line.is_cut()) return cut();
            if (!came) return std::size_t{0};
            std::copy(came->begin(), came->end(), room.begin());
            return came->size();
        }

    private:
        FaultyInverse3& to_;
    };
    class Service final : public HaplyService {
    public:
        explicit Service(FaultyInverse3& to) : to_(to) {}
        std::string address() const override { return "ws://fake"; }
        Result<std::string> get(const std::string& path, std::chrono::milliseconds) override {
            if (to_.line.is_cut()) return cut();
            return path == "/version" ? std::string(R"({"project_version":"3.5.0.0"})") : std::string();
        }
        Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds) override {
            if (to_.line.is_cut()) return cut();
            to_.line.clear();
            to_.answer();
            return std::unique_ptr<Transport>(std::make_unique<Texts>(to_));
        }

    private:
        FaultyInverse3& to_;
    };
    static Error cut() { return {ErrorKind::device, "fake: the wire is cut"}; }

    glm::dvec3 place_{0.0};
    std::int64_t gone_until_ns_ = 0;
};

TEST(Inverse3Faults, NeverCauseUnsafeForce) {
    FaultyInverse3 arm;
    run_fault_sessions(arm);
}

TEST(Inverse3Faults, ForceReturnsAfterShortSilence) {
    FaultyInverse3 arm;
    expect_force_after_silence(arm);
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

// Messages are written by hand, after the examples of the service's public pages.

TEST(Inverse3Protocol, EncodesForceInServiceAxes) {
    // Ours x right, y up, z towards the person; the service's x right, y forward, z up.
    EXPECT_EQ(encode_inverse3_force(Inverse3Dialect::vector, "049D", {1.5, -2, 0.25}),
              R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":)"
              R"({"x":1.5,"y":-0.25,"z":-2.0}}}}]})");
    EXPECT_EQ(encode_inverse3_force(Inverse3Dialect::values, "04BA", {0, 0, -3}),
              R"({"inverse3":[{"device_id":"04BA","commands":{"set_cursor_force":{"values":)"
              R"({"x":0.0,"y":3.0,"z":0.0}}}}]})");
    EXPECT_EQ(encode_inverse3_force(Inverse3Dialect::vector, "1", {0, 0, 0}),
              R"({"inverse3":[{"device_id":"1","commands":{"set_cursor_force":{"vector":)"
              R"({"x":0.0,"y":0.0,"z":0.0}}}}]})");
}

TEST(Inverse3Protocol, DecodesInventory) {
    const auto message = decode_inverse3_message(R"({"session_id": 7, "inverse3": [
        {"device_id": "049D",
         "config": {"type": "inverse3", "handedness": "right",
                    "gravity_compensation": {"enabled": true, "scaling_factor": 0.8},
                    "torque_scaling": {"enabled": false}, "basis": {"permutation": "XYZ"},
                    "filters": {"force_gate": {"gain": 0.3}, "damping": {"scalar": 1.25}}},
         "state": {"cursor_position": {"x": 0.01, "y": -0.12, "z": 0.15}, "control_mode": "idle"},
         "status": {"calibrated": true, "in_use": false, "power_supply": false, "ready": true}},
        {"device_id": "04BA", "state": {"cursor_position": {"x": 1, "y": 2, "z": 3}}}]})");
    ASSERT_TRUE(message) << message.error().message;
    ASSERT_EQ(message->arms.size(), 2u);
    const Inverse3Arm& arm = message->arms[0];
    EXPECT_EQ(arm.id, "049D");
    EXPECT_EQ(arm.place, glm::dvec3(0.01, 0.15, 0.12));
    EXPECT_EQ(arm.calibrated, true);
    EXPECT_EQ(arm.powered, false);
    EXPECT_EQ(arm.ready, true);
    EXPECT_EQ(arm.unusable, "");
    EXPECT_EQ(arm.settings,
              "filters/force_gate/gain 0.3, filters/damping/scalar 1.25, "
              "gravity_compensation/scaling_factor 0.8");
    EXPECT_EQ(message->arms[1].place, glm::dvec3(1, 3, -2));
    EXPECT_EQ(message->arms[1].settings, "");
    EXPECT_FALSE(message->arms[1].calibrated);
}

TEST(Inverse3Protocol, DecodesStateBefore35) {
    const auto message = decode_inverse3_message(
        R"({"inverse3":[{"device_id":"04EA","state":{"angular_position":{"a0":-30.9,"a1":53.8,"a2":-6.6},)"
        R"("control_mode":"idle","current_cursor_force":{"x":0,"y":0,"z":0},)"
        R"("cursor_position":{"x":0.104,"y":-0.036,"z":-0.061},"mode":"idle"},)"
        R"("status":{"calibrated":true,"in_use":false,"power_supply":true,"ready":true,"started":true}}],)"
        R"("wireless_verse_grip":[{"device_id":"61576","state":{"buttons":{"a":true,"b":false,"c":true}}}]})");
    ASSERT_TRUE(message);
    ASSERT_EQ(message->arms.size(), 1u);
    EXPECT_EQ(message->arms[0].place, glm::dvec3(0.104, -0.061, 0.036));
    EXPECT_EQ(message->buttons, 0b101u);
}

TEST(Inverse3Protocol, DecodesWiredGripButton) {
    const auto pressed = decode_inverse3_message(R"({"verse_grip":[{"state":{"button":true,"hall":1}}]})");
    ASSERT_TRUE(pressed);
    EXPECT_EQ(pressed->buttons, 1u);
    EXPECT_EQ(decode_inverse3_message(R"({"verse_grip":[{"state":{"button":1}}]})")->buttons, 0u);
}

TEST(Inverse3Protocol, RejectsInvalidMessages) {
    for (const std::string text : {"", "{", "[]", "7", "null", "\"inverse3\"",
                                   "{\"inverse3\":[{\"device_id\":", "\xff\xfe", "{} {}"}) {
        const auto message = decode_inverse3_message(text);
        ASSERT_FALSE(message) << text;
        EXPECT_EQ(message.error().kind, ErrorKind::device);
        EXPECT_EQ(message.error().message.find('\n'), std::string::npos);
    }
    EXPECT_FALSE(decode_inverse3_message(std::string(200'000, '[')));
    EXPECT_FALSE(decode_inverse3_message(std::string(100'000, '[') + std::string(100'000, ']')));
}

TEST(Inverse3Protocol, IgnoresMembersOfWrongType) {
    for (const std::string arms :
         {R"(7)", R"({})", R"([7, null, "a"])", R"([{}])", R"([{"device_id": 7}])", R"([{"device_id": ""}])",
          R"([{"device_id": "a b"}])", R"([{"device_id": "ä"}])"}) {
        const auto message = decode_inverse3_message("{\"inverse3\": " + arms + "}");
        ASSERT_TRUE(message) << arms;
        EXPECT_TRUE(message->arms.empty()) << arms;
    }
    EXPECT_TRUE(decode_inverse3_message("{\"inverse3\":[{\"device_id\":\"" + std::string(65, 'x') + "\"}]}")
                    ->arms.empty());
    for (const std::string place : {R"(7)", R"([1,2,3])", R"({"x":1,"y":2})", R"({"x":1,"y":2,"z":"3"})",
                                    R"({"x":1,"y":2,"z":null})", R"({"x":1,"y":2,"z":true})"}) {
        const auto message = decode_inverse3_message(
            R"({"inverse3":[{"device_id":"1","status":[],"config":7,"state":{"cursor_position":)" + place +
            "}}]}");
        ASSERT_TRUE(message) << place;
        ASSERT_EQ(message->arms.size(), 1u) << place;
        EXPECT_FALSE(message->arms[0].place) << place;
        EXPECT_EQ(message->arms[0].settings, "");
    }
    // A number that no double holds is no number of JSON's either.
    EXPECT_FALSE(decode_inverse3_message(
        R"({"inverse3":[{"device_id":"1","state":{"cursor_position":{"x":1e999,"y":0,"z":0}}}]})"));
}

TEST(Inverse3Protocol, RejectsUnknownVersionsByName) {
    const auto dialect = [](const char* words) {
        const auto version = parse_inverse3_version(words);
        EXPECT_TRUE(version) << words;
        return inverse3_dialect(*version);
    };
    EXPECT_EQ(*dialect("3.1"), Inverse3Dialect::values);
    EXPECT_EQ(*dialect("3.4.9.0"), Inverse3Dialect::values);
    EXPECT_EQ(*dialect("3.5.0"), Inverse3Dialect::vector);
    EXPECT_EQ(*dialect("3.12-rc1"), Inverse3Dialect::vector);
    for (const char* unknown : {"3.0.7", "2.0.0", "4.0.1"}) {
        const auto refused = dialect(unknown);
        ASSERT_FALSE(refused) << unknown;
        EXPECT_NE(refused.error().message.find("Haply Inverse Service " + std::string(unknown).substr(0, 3)),
                  std::string::npos);
    }
    for (const char* words : {"", "3", "3.", ".5", "3.x", "v3.5", "-3.5", "3.-5", "3.5x", "99999999999.1"})
        EXPECT_FALSE(parse_inverse3_version(words)) << words;
}

TEST(Inverse3Protocol, FindsVersionInAnswer) {
    const auto bare = decode_inverse3_version(
        R"({"git_branch":"main","git_describe":"3.5.0-2-gce34c39e","git_tag":"3.5.0","project_version":"3.5.0.0"})");
    ASSERT_TRUE(bare);
    EXPECT_EQ(bare->major, 3);
    EXPECT_EQ(bare->minor, 5);
    EXPECT_EQ(decode_inverse3_version(R"({"ok":true,"data":{"git_tag":"3.6.1"}})")->minor, 6);
    for (const char* answer :
         {"", "404", "{}", "<html>", R"({"ok":false,"error":"no"})", R"({"git_tag":35})"})
        EXPECT_FALSE(decode_inverse3_version(answer)) << answer;
}

TEST(Inverse3Protocol, DecodesForceScale) {
    EXPECT_EQ(decode_force_scale(R"({"ok":true,"data":0.5})"), 0.5);
    EXPECT_EQ(decode_force_scale(R"({"ok":true,"data":{"value":2}})"), 2.0);
    EXPECT_EQ(decode_force_scale(R"({"devices/force_scale":0.25})"), 0.25);
    for (const char* answer : {"", "{}", R"({"ok":false})", R"({"data":"0.5"})"})
        EXPECT_FALSE(decode_force_scale(answer)) << answer;
}

std::vector<std::byte> bytes(std::initializer_list<int> values) {
    std::vector<std::byte> made;
    for (const int value : values) made.push_back(static_cast<std::byte>(value));
    return made;
}

TEST(Inverse3Protocol, FramesFollowRfc6455) {
    // Section 5.7: "A single-frame masked text message".
    EXPECT_EQ(web_socket_frame("Hello", 0x37fa213d),
              bytes({0x81, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58}));
    EXPECT_EQ(web_socket_frame(std::string(125, 'a'), 0)[1], static_cast<std::byte>(0x80 + 125));
    const auto longer = web_socket_frame(std::string(0x123, 'a'), 0);
    ASSERT_EQ(longer.size(), 0x123u + 8);
    EXPECT_EQ(std::vector(longer.begin(), longer.begin() + 9),
              bytes({0x81, 0x80 + 126, 0x01, 0x23, 0, 0, 0, 0, 'a'}));
}

}  // namespace
}  // namespace touchable
