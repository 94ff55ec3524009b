// The driver over a service of lines that a test writes: every fault at a known moment.
#include "device/drivers/inverse3_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <deque>
#include <random>
#include "device/drivers/safety_watchdog.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;

constexpr microseconds no_time{0};

/// What went over the wire, and what comes next.
struct Wire {
    std::vector<std::string> sent;
    std::deque<std::string> coming;
    std::string version = R"({"project_version":"3.5.0.0"})";
    std::string scale = "0.5";  // its force scale
    std::int64_t now_ns = 1;    // passes where somebody waits for what does not come
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

TEST(Inverse3Driver, TellsThePlaceFromTheCentreOfItsWorkspace) {
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

TEST(Inverse3Driver, TheLastThatGoesOutIsZero) {
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

TEST(Inverse3Driver, TheZeroForcePacketIsTheZeroForceAsAFrame) {
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

TEST(Inverse3Driver, AServiceThatDoesNotAnswerIsNotFilledButHearsTheZero) {
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

TEST(Inverse3Driver, AServiceThatDoesNotAnswerForHalfASecondIsGone) {
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

TEST(Inverse3Driver, AServiceThatMakesForcesLongerIsGivenShorterOnes) {
    for (const auto& [scale, sent] : {std::pair{"2.0", R"("z":2.0)"}, {"0.5", R"("z":4.0)"}}) {
        Driven driven;
        driven.wire.scale = scale;
        ASSERT_TRUE(driven.connect());
        ASSERT_TRUE(driven.push({0, 4, 0}));
        EXPECT_NE(driven.wire.sent.back().find(sent), std::string::npos) << driven.wire.sent.back();
    }
}

TEST(Inverse3Driver, OfLateAnswersTheNewestCounts) {
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
TEST(Inverse3Driver, WhatCameWhileNobodyAskedIsForgotten) {
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

TEST(Inverse3Driver, NonsenseIsLeftOutUntilItIsTooMuch) {
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

TEST(Inverse3Driver, AnArmThatIsGoneIsAFaultAndACutWireToo) {
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

TEST(Inverse3Driver, AnArmThatIsNotCalibratedHasNoPlaceAndSaysSo) {
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
              "the Haply service multiplies forces by 0.5; change it in Haply Hub if that is not meant");
}

TEST(Inverse3Driver, SaysWhichServiceItSpeaksWith) {
    Driven driven;
    driven.wire.state = Wire::arm_text("049D", R"("config":{"filters":{"force_gate":{"gain":0.3}}},)");
    EXPECT_EQ(driven.driver.service_in_words(), "");
    ASSERT_TRUE(driven.connect());
    EXPECT_EQ(driven.driver.service_in_words(),
              "Inverse3 049D, Haply Inverse Service 3.5: force gate 0.3, force scale 0.5");
}

TEST(Inverse3Driver, RefusesWhatItDoesNotKnow) {
    {
        Driven driven;
        driven.wire.version = R"({"project_version":"4.0.1.0"})";
        EXPECT_EQ(driven.refusal(),
                  "Haply Inverse Service 4.0 is not known here; right would be 3.1 to any other 3.x");
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
        Driven driven;
        driven.wire.state = Wire::arm_text("049D", R"("config":{"basis":{"permutation":"XZY"}},)");
        EXPECT_NE(driven.refusal().find("basis XZY"), std::string::npos);
        EXPECT_TRUE(driven.wire.sent.empty());
    }
    {
        Driven driven(*read_inverse3_choice("id=04BA"));
        EXPECT_EQ(driven.refusal(), "there is no Inverse3 '04BA'; the Haply service knows of 049D");
    }
}

TEST(Inverse3Driver, AVersionThatIsGivenIsNotAskedFor) {
    Driven driven(*read_inverse3_choice("service=3.4"));
    driven.wire.version = "";
    ASSERT_TRUE(driven.connect());
    EXPECT_NE(driven.wire.sent.back().find(R"("values")"), std::string::npos);
}

/// Short, corrupt, repeated, late, lost and cut at random moments.
TEST(Inverse3Driver, WhateverComesItEndsWithZeroAndTellsNumbers) {
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

TEST(Inverse3Driver, GivesUpConnectingWhenItIsToldTo) {
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
