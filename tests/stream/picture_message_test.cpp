#include "engine/stream/labelled_codec.hpp"

#include <gtest/gtest.h>

#include <array>

namespace touchable {
namespace {

std::span<const std::uint8_t> bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

constexpr std::array<std::uint8_t, 6> samples{1, 2, 3, 4, 5, 6};
const PlaneView plane{samples.data(), 3, 3, 2, 1, 1};
const PictureMessage depth{PlaneRole::depth, PlanePart::high, 16, {12, 1'700'000'000'000'000'000}};

TEST(PictureMessage, SaysWhatItIs) {
    const std::string sei = sei_of(depth, plane);
    // XXH64 of that text and of 1 to 6, by an implementation in Python
    EXPECT_EQ(sei.substr(16),
              "touchable=1 role=depth part=high bits=16 frame=12 taken_ns=1700000000000000000 "
              "xxh64=405067dddc054acd");
    const auto read = read_sei(bytes_of(sei));
    ASSERT_TRUE(read && read->picture);
    EXPECT_EQ(*read->picture, depth);
    EXPECT_TRUE(is_sound(*read, plane));
}

TEST(PictureMessage, AnyOtherSampleIsKnown) {
    const auto read = read_sei(bytes_of(sei_of(depth, plane)));
    for (std::size_t k = 0; k < samples.size(); ++k) {
        auto other = samples;
        other[k] ^= 1;
        EXPECT_FALSE(is_sound(*read, {other.data(), 3, 3, 2, 1, 1})) << k;
    }
    EXPECT_FALSE(is_sound(*read, {samples.data(), 3, 3, 1, 1, 1}));
}

TEST(PictureMessage, ADamagedOneIsNeverSound) {
    const std::string colour = sei_of({PlaneRole::colour, PlanePart::whole, 8, {12, 5}}, plane);
    for (const std::string& sei : {sei_of(depth, plane), colour, sei_of_scene("{\"a\": 1}")})
        for (std::size_t at = 0; at < sei.size(); ++at)
            for (int bit = 0; bit < 8; ++bit) {
                std::string damaged = sei;
                damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
                const auto read = read_sei(bytes_of(damaged));
                if (!read) continue;
                EXPECT_FALSE(read->scene) << at;
                EXPECT_FALSE(read->picture && is_sound(*read, plane)) << at << ", bit " << bit;
            }
}

TEST(PictureMessage, WhatCannotBeIsNone) {
    const std::string uuid = sei_of(depth, plane).substr(0, 16);
    const auto reads = [&](const std::string& text) { return read_sei(bytes_of(uuid + text)).has_value(); };
    EXPECT_TRUE(reads("touchable=1 role=depth part=low bits=9 frame=0 taken_ns=0 xxh64=0000000000000000"));
    for (const char* const text :
         {"", "touchable=1",
          "touchable=2 role=depth part=low bits=9 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=17 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=haptic part=low bits=9 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=whole bits=9 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=-1 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=0 taken_ns=-1 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=0 taken_ns=0 more=1 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=0 taken_ns=0",
          "touchable=1 role=depth part=low bits=9 frame=99999999999999999999 taken_ns=0 "
          "xxh64=0000000000000000",
          "touchable_scene=1 xxh64=", "touchable_scene=1 xxh64=0000000000000000 {}"})
        EXPECT_FALSE(reads(text)) << text;
    EXPECT_FALSE(read_sei({}));
}

TEST(PictureMessage, ASceneComesBack) {
    const std::string json = "{\"name\": \"globe\"}";
    const auto read = read_sei(bytes_of(sei_of_scene(json)));
    ASSERT_TRUE(read && read->scene);
    EXPECT_EQ(*read->scene, json);
}

}  // namespace
}  // namespace touchable
