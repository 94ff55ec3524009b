// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "engine/picture/image.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

// Real recordings, touched, and every force judged by verify_forces, which knows nothing of this program but
// its files: the proxy is nowhere behind the surface, is the place nearest to the goal that friction allows,
// and pulls as its spring says.

/// Touches a clip whose frames are exported, with what is to be given to `touch`. Gives the report.
nlohmann::json expect_verified(const Words& clip_and_hand, const std::string& exported) {
    const TemporaryFolder folder;
    const std::string csv = folder / "forces.csv";
    const auto report = touch(plus(clip_and_hand, {"--forces", csv}));
    EXPECT_EQ(report["proxy_behind_mesh_ticks"], 0);
    EXPECT_EQ(report["nonfinite_ticks"], 0);
    EXPECT_GE(report["finger_contact_pct"], 50);
    const std::string command = std::string(TOUCHABLE_VERIFIER) + " --forces " + csv + " --frames " +
                                exported + " --min-contact 0.5 >" + (folder / "said").string() + " 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << file_contents(folder / "said");
    return report;
}

/// By a hand that wanders, with one finger and with five that may push hard. Slower than usual, and with faster
/// and fewer hops: a cliff stands every 12 mm in redwood5, and a crossing within the usual 0.5 m/s and 20 m/s^2
/// takes 0.3 s, so that the usual hand is in the air for most of the time.
void expect_wandering_is_verified(const std::string& clip, const std::string& scene) {
    const TemporaryFolder folder;
    const std::string exported = folder / "frames";
    succeed({"export", clip, "--scene", scene, "--frames", "all", "--out", exported});
    for (const Words& hand : {Words{"--fingers", "1"}, Words{"--fingers", "5", "--max-force", "1000"}}) {
        expect_verified(
            plus({clip, "--scene", scene, "--hand", "wander:speed=0.05,glide=30,max_speed=2"}, hand),
            exported);
    }
}

struct RealClip {
    const char *name, *folder;  ///< of the scene file; below the test data
};

class TouchRealClip : public ::testing::TestWithParam<RealClip> {};

TEST_P(TouchRealClip, EveryForceIsVerified) {
    const std::string clip = real_data(GetParam().folder);
    TOUCHABLE_NEEDS_DATA(clip);
    expect_wandering_is_verified(
        clip, std::string(TOUCHABLE_SOURCE_DIR "/tests/scenes/") + GetParam().name + ".json");
}

INSTANTIATE_TEST_SUITE_P(, TouchRealClip,
                         ::testing::Values(RealClip{"castel_sr300", "castel_sr300"},
                                           RealClip{"visp_cube_realsense", "visp_cube_realsense"},
                                           RealClip{"redwood5", "stills/redwood5"},
                                           RealClip{"icl_nuim5", "stills/icl_nuim5"}),
                         [](const auto& run) { return std::string(run.param.name); });

class TouchStandIn : public ::testing::TestWithParam<const char*> {};

TEST_P(TouchStandIn, EveryForceIsVerified) {
    const TemporaryFolder folder;
    const std::string scene = write_stand_in(folder.path(), stand_in(GetParam()));
    expect_wandering_is_verified(folder.path(), scene);
}

INSTANTIATE_TEST_SUITE_P(, TouchStandIn,
                         ::testing::Values("castel_sr300", "visp_cube_realsense", "redwood5", "icl_nuim5"),
                         [](const auto& run) { return std::string(run.param); });

/// By a recorded hand over the globe, with one finger and with three.
void expect_recorded_hand_is_verified(const std::string& csv, const std::string& keys) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", exported = folder / "frames";
    make_clip("globe", clip, {"--size", "360x240", "--frames", "20"});
    succeed({"export", clip, "--frames", "all", "--out", exported});
    const std::string hand = "csv:" + csv + ":" + keys;
    expect_verified({clip, "--hand", hand}, exported);
    expect_verified({clip, "--hand", hand, "--fingers", "3", "--max-force", "1000", "--seconds", "2"},
                    exported);
}

const std::string pressed_keys = "columns=master_rad,scale=0.075",
                  wiped_keys = "columns=x_m+y_m+z_m,extent=0.048";

struct RealHand {
    const char *name, *file;  ///< below the test data
    const std::string& keys;
};

class TouchRealHand : public ::testing::TestWithParam<RealHand> {};

TEST_P(TouchRealHand, EveryGlobeForceIsVerified) {
    const std::string file = real_data("haptics") / GetParam().file;
    TOUCHABLE_NEEDS_DATA(file);
    expect_recorded_hand_is_verified(file, GetParam().keys);
}

INSTANTIATE_TEST_SUITE_P(
    , TouchRealHand,
    ::testing::Values(RealHand{"PressedRigid", "tue_1dof/m2_question1a_rigid.csv", pressed_keys},
                      RealHand{"PressedSpring", "tue_1dof/m2_question1e_spring.csv", pressed_keys},
                      RealHand{"Wiped0", "epfl_wiping/circular_wiping_dataset_0.csv", wiped_keys},
                      RealHand{"Wiped3", "epfl_wiping/circular_wiping_dataset_3.csv", wiped_keys}),
    [](const auto& run) { return std::string(run.param.name); });

TEST(TouchRecordedHand, EveryGlobeForceIsVerified) {
    const TemporaryFolder folder;
    std::ofstream(folder / "pressing.csv") << pressing_hand_csv();
    std::ofstream(folder / "wiping.csv") << wiping_hand_csv();
    expect_recorded_hand_is_verified(folder / "pressing.csv", pressed_keys);
    expect_recorded_hand_is_verified(folder / "wiping.csv", wiped_keys);
}

/// Wiped over a recording without regard to where its depth is missing; holes have a stiffness of their own.
void expect_soft_holes_are_verified(const std::string& clip, const std::string& scene_file,
                                    const std::string& csv) {
    const TemporaryFolder folder;
    const std::string soft = folder / "soft.json", exported = folder / "frames";
    auto scene = json_in(scene_file);
    scene["hole_stiffness"] = 0.1;
    std::ofstream(soft) << scene;
    succeed({"export", clip, "--scene", soft, "--frames", "all", "--out", exported});
    const auto report =
        expect_verified({clip, "--scene", soft, "--hand", "csv:" + csv + ":columns=x_m+y_m+z_m,extent=0.1",
                         "--fingers", "3", "--max-force", "1000", "--seconds", "2.5"},
                        exported);
    EXPECT_GT(report["hole_contact"]["finger_ticks"], 500);
}

TEST(TouchRealSoftHoles, EveryForceIsVerified) {
    const std::string clip = real_data("castel_sr300");
    const std::string file = real_data("haptics/epfl_wiping/circular_wiping_dataset_0.csv");
    TOUCHABLE_NEEDS_DATA(clip);
    TOUCHABLE_NEEDS_DATA(file);
    expect_soft_holes_are_verified(clip, TOUCHABLE_SOURCE_DIR "/tests/scenes/castel_sr300.json", file);
}

TEST(TouchSoftHoles, EveryForceIsVerified) {
    const TemporaryFolder folder;
    const std::string scene = write_stand_in(folder.path(), stand_in("castel_sr300"));
    std::ofstream(folder / "wiping.csv") << wiping_hand_csv();
    expect_soft_holes_are_verified(folder.path(), scene, folder / "wiping.csv");
}

/// Generated, and verified by what the exported codes say that they mean.
TEST(TouchFinerCodes, EveryForceIsVerified) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    make_clip("globe", clip, {"--size", "180x120", "--frames", "8", "--bits", "8"});
    for (const Words& filter : {Words{"--terraces", "on"}, Words{"--temporal", "2"}}) {
        const std::string exported = folder / filter[0];
        Words words{"export", clip, "--frames", "all", "--out", exported}, touched{clip, "--fingers", "3"};
        words.insert(words.end(), filter.begin(), filter.end());
        touched.insert(touched.end(), filter.begin(), filter.end());
        succeed(words);
        expect_verified(touched, exported);
    }
}

/// A planet whose stiffness, friction and heights travel; and one on which dynamic friction is painted above
/// static in places.
TEST(TouchFeltGlobe, EveryForceIsVerified) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", odd = folder / "odd.json";
    make_clip("globe", clip, {"--size", "120x80", "--frames", "6"});
    auto scene = scene_of(clip);
    scene["haptic"]["static_friction"] = {0.0, 0.6};
    scene["haptic"]["dynamic_friction"] = {0.05, 1.0};
    std::ofstream(odd) << scene;
    for (const Words& meaning : {Words{}, Words{"--scene", odd}}) {
        const std::string exported = folder / (meaning.empty() ? "frames" : "odd");
        succeed(plus({"export", clip, "--frames", "all", "--out", exported}, meaning));
        for (const std::string interpolation : {"linear", "hold"}) {
            expect_verified(
                plus({clip, "--fingers", "5", "--interpolation", interpolation, "--seconds", "1.2"}, meaning),
                exported);
        }
    }
}

constexpr int coded_width = 160, coded_height = 120;

/// A leaning wall with waves, 0.6 to 2.6 m.
double coded_depth(int x, int y) {
    return 1.5 + 0.009 * (x - 80) + 0.005 * (y - 60) + 0.02 * std::sin(x / 9.0) * std::sin(y / 7.0);
}

/// A float as a half float.
std::uint16_t half_of(double value) {
    int exponent = 0;
    const double digits = std::frexp(value, &exponent);  // 0.5 to 1
    return static_cast<std::uint16_t>(((exponent + 14) << 10) + std::lround((2 * digits - 1) * 1024));
}

template <class Number, class Coded>
void write_coded_npy(const fs::path& file, const char* kind, Coded&& coded) {
    std::string header = std::string("{'descr': '") + kind + "', 'fortran_order': False, 'shape': (" +
                         std::to_string(coded_height) + ", " + std::to_string(coded_width) + "), }";
    header.resize(117, ' ');
    std::ofstream out(file, std::ios::binary);
    out << std::string("\x93NUMPY\1\0", 8) << static_cast<char>(header.size() + 1) << '\0' << header << '\n';
    for (int y = 0; y < coded_height; ++y)
        for (int x = 0; x < coded_width; ++x) {
            const Number number = coded(coded_depth(x, y));
            out.write(reinterpret_cast<const char*>(&number), sizeof number);
        }
}

/// The colour of a share of the way round from red to red.
std::array<std::uint8_t, 3> colour_of_share(double share) {
    const int code = static_cast<int>(std::lround(share * 1535)), up = code % 256, down = 255 - up;
    const int sectors[6][3] = {{255, up, 0},   {down, 255, 0}, {0, 255, up},
                               {0, down, 255}, {up, 0, 255},   {255, 0, down}};
    std::array<std::uint8_t, 3> colour;
    for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<std::uint8_t>(sectors[code / 256][c]);
    return colour;
}

struct TouchedCoding {
    const char *name, *depth;  ///< of the scene file
    const char* filter = "{}";
};

class TouchCoding : public ::testing::TestWithParam<TouchedCoding> {
protected:
    /// Gives the scene file.
    std::string write() const {
        const std::string name = GetParam().name;
        const auto depth = nlohmann::json::parse(GetParam().depth);
        nlohmann::json scene{
            {"touchable_scene", 1},
            {"width", coded_width},
            {"height", coded_height},
            {"metres_per_unit", 1},
            {"camera", {{"fx", 150}, {"fy", 150}, {"cx", 79.5}, {"cy", 59.5}}},
            {"depth", depth},
            {"filter", nlohmann::json::parse(GetParam().filter)},
            {"folder",
             {{"depth", depth.contains("bits") || depth["coding"] == "hue" ? "depth.png" : "depth.npy"}}}};
        if (depth.value("near", 0.0) > 0.1) {  // heights need room before the nearest code
            scene["height_map"] = {{"max", 0.01}, {"units", "world"}};
            scene["folder"]["height"] = "height.png";
            Image heights{coded_width, coded_height, 1, 1, {}};
            for (int k = 0; k < coded_width * coded_height; ++k)
                heights.samples.push_back(static_cast<std::uint8_t>(k % 7 * 30));
            EXPECT_TRUE(write_png(folder / "height.png", heights.view()));
        }
        std::ofstream(folder / "scene.json") << scene;
        if (name == "floats")
            write_coded_npy<float>(folder / "depth.npy", "<f4",
                                   [](double z) { return static_cast<float>(z); });
        else if (name == "half_floats")
            write_coded_npy<std::uint16_t>(folder / "depth.npy", "<f2", half_of);
        else
            write_pictures(depth);
        return folder / "scene.json";
    }
    void write_pictures(const nlohmann::json& depth) const {
        const std::string coding = depth["coding"];
        const double near = depth.value("near", 0.0), far = depth.value("far", 0.0),
                     shift = depth.value("shift", 0.0), most = depth.value("code_max", 0);
        const auto towards_near = [&](double z) {
            if (coding == "inverse") return (1 / z - 1 / far) / (1 / near - 1 / far);
            if (coding == "log")
                return std::log((far + shift) / (z + shift)) / std::log((far + shift) / (near + shift));
            return (far - z) / (far - near);
        };
        Image image{
            coded_width, coded_height, coding == "hue" || most == 255 ? 1 : 2, coding == "hue" ? 3 : 1, {}};
        for (int y = 0; y < coded_height; ++y)
            for (int x = 0; x < coded_width; ++x) {
                const double z = coded_depth(x, y);
                if (coding == "hue") {
                    const auto colour = colour_of_share(1 - towards_near(z));
                    image.samples.insert(image.samples.end(), colour.begin(), colour.end());
                    continue;
                }
                const auto code = std::lround(coding == "metric" ? z / depth["scale"].get<double>()
                                                                 : most * towards_near(z));
                image.samples.push_back(static_cast<std::uint8_t>(code & 255));
                if (most != 255) image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
            }
        EXPECT_TRUE(write_png(folder / "depth.png", image.view()));
    }
    TemporaryFolder folder;
};

TEST_P(TouchCoding, EveryForceIsVerified) {
    expect_wandering_is_verified(folder.path(), write());
}

constexpr const char* removed = R"({"terraces": "on"})";
INSTANTIATE_TEST_SUITE_P(
    , TouchCoding,
    ::testing::Values(
        TouchedCoding{"metric", R"({"coding": "metric", "scale": 0.001, "bits": 16})"},
        TouchedCoding{"metric_looked_up", R"({"coding": "metric", "scale": 0.0001, "bits": 16})", removed},
        TouchedCoding{"linear", R"({"coding": "linear", "near": 0.5, "far": 3, "bits": 8, "code_max": 255})",
                      removed},
        TouchedCoding{"linear_looked_up",
                      R"({"coding": "linear", "near": 0.5, "far": 3, "bits": 16, "code_max": 65535})",
                      removed},
        TouchedCoding{"inverse",
                      R"({"coding": "inverse", "near": 0.5, "far": 4, "bits": 8, "code_max": 255})"},
        TouchedCoding{"inverse_looked_up",
                      R"({"coding": "inverse", "near": 0.5, "far": 4, "bits": 16, "code_max": 65535})",
                      removed},
        TouchedCoding{
            "log",
            R"({"coding": "log", "near": 0.01, "far": 10, "shift": 3.5, "bits": 12, "code_max": 4095})",
            R"({"terraces": "off"})"},
        TouchedCoding{
            "log_looked_up",
            R"({"coding": "log", "near": 0.01, "far": 10, "shift": 3.5, "bits": 12, "code_max": 4095})",
            removed},
        TouchedCoding{"hue", R"({"coding": "hue", "near": 0.5, "far": 3})"},
        TouchedCoding{"floats", R"({"coding": "metric", "scale": 1})"},
        TouchedCoding{"half_floats", R"({"coding": "metric", "scale": 1})"}),
    [](const auto& run) { return std::string(run.param.name); });

}  // namespace
}  // namespace touchable::test
