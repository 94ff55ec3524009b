// Filters that a clip leaves open are chosen by what its first frames tell, wherever it is touched.
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/seeded_noise.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

constexpr int columns = 96, rows = 64;

/// Millimetres of a noisy camera, with specks.
void write_noisy_clip(const std::string& file) {
    Scene scene;
    scene.width = columns;
    scene.height = rows;
    scene.camera = {80, 80, 47.5, 31.5};
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.far = 1000;
    scene.depth.code_max = 65535;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    SceneDescription described(scene);
    described.unstated.filters = all_unstated;
    auto writer = create_clip(file, described);
    ASSERT_TRUE(writer) << writer.error().message;
    SplitMix64 random(5);
    for (int n = 0; n < 20; ++n) {
        auto codes = std::make_shared<std::vector<std::uint16_t>>();
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) {
                const double noise = random.within(-4, 4) + random.within(-4, 4);
                const double depth = 400 + x + 0.5 * y + noise;
                codes->push_back(random.next() % 300 == 0 ? 0 : static_cast<std::uint16_t>(depth));
            }
        RawFrame frame;
        frame.number = n;
        frame.depth = {
            reinterpret_cast<const std::uint8_t*>(codes->data()), 2 * columns, columns, rows, 2, 1};
        frame.storage = codes;
        ASSERT_TRUE((*writer)->write(frame));
    }
    ASSERT_TRUE((*writer)->finish());
}

class Filters : public testing::Test {
protected:
    void SetUp() override { write_noisy_clip(clip()); }
    std::string clip() const { return folder / "noisy.mkv"; }
    nlohmann::json touched(const Words& more) const {
        Words words{clip(), "--hand", "press", "--seconds", "0.7"};
        words.insert(words.end(), more.begin(), more.end());
        return touch(words);
    }
    std::string hash(const Words& more) const { return touched(more)["force_hash"]; }

    TemporaryFolder folder;
};

TEST_F(Filters, AreChosenByTheFirstFramesAndTold) {
    const auto report = touched({});
    const auto& filters = report["filters"];
    EXPECT_EQ(filters["median"], 3);
    EXPECT_EQ(filters["fill_holes"], 2);
    EXPECT_EQ(filters["terraces"], true);
    EXPECT_EQ(filters["temporal"], true);
    EXPECT_EQ(filters["chosen"], (Words{"median", "fill_holes", "terraces", "temporal", "flying_pixels"}));
    const double sigma = filters["measured"]["noise_at_median"];
    EXPECT_NEAR(sigma, 3.27, 0.3) << "of two uniform numbers from -4 to 4";
    const std::string words = filters["in_words"];
    EXPECT_NE(words.find("(noise 3."), std::string::npos) << words;
    const Outcome said = run_touchable({"touch", clip(), "--seconds", "0.1", "--verbose"});
    EXPECT_NE(said.out.find("  filters "), std::string::npos) << said.out;
    EXPECT_NE(run_touchable({"info", clip()}).out.find("median 3x3 ("), std::string::npos);
}

TEST_F(Filters, OneOptionSaysAllOfThem) {
    EXPECT_EQ(hash({"--filters", "auto"}), hash({}));
    const std::string off = hash({"--filters", "off"});
    EXPECT_NE(off, hash({}));
    EXPECT_EQ(off, hash({"--median", "0", "--fill-holes", "0", "--terraces", "off", "--temporal", "off"}));
    EXPECT_EQ(hash({"--filters", "median=3,holes,temporal=5+1e-6"}),
              hash({"--median", "3", "--fill-holes", "2", "--terraces", "off", "--temporal", "5,1e-6"}));
    EXPECT_EQ(hash({"--filters", "off", "--median", "5"}), hash({"--filters", "median"}))
        << "one by one counts last";
    EXPECT_FALSE(touched({"--filters", "off"})["filters"].contains("chosen")) << "nothing was measured";
    const auto info = run_touchable({"info", clip(), "--filters", "terraces", "--json"});
    EXPECT_EQ(nlohmann::json::parse(info.out)["filters"]["terraces"], true);
}

TEST_F(Filters, EveryBuilderHasTheSame) {
    const std::string chosen = hash({});
    for (const char* builder : {"cpu", "reference", "vulkan"})
        EXPECT_EQ(hash({"--builder", builder}), chosen) << builder;
    const auto lazy = touched({"--builder", "lazy"});
    EXPECT_EQ(lazy["force_hash"], chosen);
    EXPECT_EQ(lazy["builder"], "cpu") << "which can average over time";
    EXPECT_NE(lazy["builder_why"].get<std::string>().find("lazy"), std::string::npos);
}

TEST_F(Filters, ARecordingKeepsWhatWasChosen) {
    const std::string recording = folder / "run.rec";
    const std::string chosen = hash({"--record", recording});
    const Outcome again = run_touchable({"touch", "--replay", recording});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.out.find(chosen), std::string::npos) << again.out;
}

TEST_F(Filters, AnExportedFrameStatesThem) {
    const Outcome run =
        run_touchable({"export", clip(), "--frame", "7", "--out", folder / "frame", "--builder", "cpu"});
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_NE(run.err.find("median 3x3 ("), std::string::npos) << run.err;
    const auto filter = nlohmann::json::parse(file_contents(folder / "frame/scene.json"))["filter"];
    EXPECT_EQ(filter["median"], 3);
    EXPECT_EQ(filter["fill_holes"], 2);
    EXPECT_EQ(filter["terraces"], "on");
    EXPECT_EQ(filter["temporal"], "on");
    EXPECT_FALSE(touch({folder / "frame", "--seconds", "0.1"})["filters"].contains("chosen"))
        << "measured once is enough";
}

TEST_F(Filters, WhatMakeWritesLeavesThemOpen) {
    make_clip("globe", folder / "globe.mkv", {"--size", "48x32", "--frames", "2"});
    const auto report = touch({folder / "globe.mkv", "--seconds", "0.1"});
    EXPECT_EQ(report["filters"]["chosen"].size(), 5);
    EXPECT_NE(report["filters"]["in_words"].get<std::string>().find("none needed"), std::string::npos);
    EXPECT_EQ(report["force_hash"],
              force_hash({folder / "globe.mkv", "--seconds", "0.1", "--filters", "off"}));
}

}  // namespace
}  // namespace touchable::test
