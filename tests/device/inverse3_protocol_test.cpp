// Messages are written by hand, after the examples of the service's public pages.
#include "device/drivers/inverse3_device.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace touchable {
namespace {

TEST(Inverse3Protocol, AForceIsTurnedToTheServicesAxes) {
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

TEST(Inverse3Protocol, AnInventoryTellsArmsAndTheirSettings) {
    const auto message = decode_inverse3_message(R"({"session_id": 7, "inverse3": [
        {"device_id": "049D",
         "config": {"type": "inverse3", "handedness": "right",
                    "gravity_compensation": {"enabled": true, "scaling_factor": 0.8},
                    "torque_scaling": {"enabled": false}, "basis": {"permutation": "XZY"},
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
    ASSERT_TRUE(arm.settings);
    EXPECT_EQ(arm.settings->basis, "XZY");
    EXPECT_EQ(in_words(*arm.settings),
              "damping 1.25, force gate 0.3, gravity compensation on (times 0.8), torque scaling off");
    EXPECT_EQ(altered_forces(*arm.settings), "damps with 1.25");
    EXPECT_EQ(message->arms[1].place, glm::dvec3(1, 3, -2));
    EXPECT_FALSE(message->arms[1].settings);
    EXPECT_FALSE(message->arms[1].calibrated);
}

TEST(Inverse3Protocol, AStateBefore35IsRead) {
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

TEST(Inverse3Protocol, AWiredGripHasOneButton) {
    const auto pressed = decode_inverse3_message(R"({"verse_grip":[{"state":{"button":true,"hall":1}}]})");
    ASSERT_TRUE(pressed);
    EXPECT_EQ(pressed->buttons, 1u);
    EXPECT_EQ(decode_inverse3_message(R"({"verse_grip":[{"state":{"button":1}}]})")->buttons, 0u);
}

TEST(Inverse3Protocol, WhatIsNoMessageIsRefused) {
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

TEST(Inverse3Protocol, MembersOfAWrongTypeAreMissing) {
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
        EXPECT_FALSE(message->arms[0].settings);
    }
    // A number that no double holds is no number of JSON's either.
    EXPECT_FALSE(decode_inverse3_message(
        R"({"inverse3":[{"device_id":"1","state":{"cursor_position":{"x":1e999,"y":0,"z":0}}}]})"));
}

TEST(Inverse3Protocol, VersionsAreReadAndUnknownOnesRefusedByName) {
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

TEST(Inverse3Protocol, TheVersionIsFoundInWhatTheServiceAnswers) {
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

TEST(Inverse3Protocol, TheForceScaleIsANumberOrNothing) {
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

TEST(Inverse3Protocol, AFrameIsThatOfRfc6455) {
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
