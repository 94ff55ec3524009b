// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/picture/image.hpp"

namespace touchable::test {

/// A small recording in the place of a real one, as its camera would store it: what a test that reads
/// recordings guards is guarded where there are none, too. A wall that leans, a box and a ball before it, and
/// noise, levels and holes.
struct StandIn {
    const char* name;     ///< of the real one's scene file, whose camera, unit and far plane it has
    double wall_mm;       ///< the wall's depth in the picture's middle; what stands before it begins at 3/4
    double level_per_mm;  ///< levels this times depth^2 apart (mm), as of disparities; 0: every code is one
    double noise_mm;      ///< RMS
    double hole_share;    ///< of the pixels, and a shadow beside the box; 0: no holes at all
    double moves_px;      ///< the whole picture from frame to frame
    int colours;          ///< channels of the picture beside depth: 3, or 1 of grey
    int frames = 4;
    int width = 320, height = 240;  ///< the middle of the real one's pictures
};

/// By the names of the real ones' scene files: a depth camera in front of its subject, one that is noisier,
/// structured light that is carried about, and a rendered room.
inline const std::vector<StandIn>& stand_ins() {
    static const std::vector<StandIn> all{{"castel_sr300", 320, 0, 0.15, 0.01, 0, 1},
                                          {"visp_cube_realsense", 560, 2e-5, 1, 0.02, 0, 3},
                                          {"redwood5", 2100, 3.55e-6, 0, 0.01, 9, 3},
                                          {"icl_nuim5", 3000, 0, 0, 0, 5, 3}};
    return all;
}

inline StandIn stand_in(const std::string& name) {
    for (const StandIn& each : stand_ins())
        if (each.name == name) return each;
    ADD_FAILURE() << "there is no stand-in for " << name;
    return stand_ins().front();
}

/// Writes the frames and their description, which it gives: folder/scene.json.
inline std::filesystem::path write_stand_in(const std::filesystem::path& folder, const StandIn& what) {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR "/tests/scenes/") + what.name + ".json");
    auto scene = nlohmann::json::parse(in);
    auto& camera = scene["camera"];
    camera["cx"] = camera["cx"].get<double>() - (scene["width"].get<double>() - what.width) / 2;
    camera["cy"] = camera["cy"].get<double>() - (scene["height"].get<double>() - what.height) / 2;
    scene["width"] = what.width;
    scene["height"] = what.height;
    auto& files = scene["folder"];
    std::string depth_files = files["depth"], colour_files = files["colour"];
    colour_files = std::filesystem::path(colour_files).replace_extension(".png").string();
    files["colour"] = colour_files;
    files["count"] = what.frames;
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "scene.json") << scene;

    const double scale = scene["depth"]["scale"], cx = camera["cx"], cy = camera["cy"], fx = camera["fx"];
    const int first = files["first"];
    SplitMix64 random(5);
    for (int n = 0; n < what.frames; ++n) {
        Image depth{what.width, what.height, 2, 1, {}}, colour{what.width, what.height, 1, what.colours, {}};
        for (int y = 0; y < what.height; ++y)
            for (int x = 0; x < what.width; ++x) {
                const double at = x + what.moves_px * n, u = (at - cx) / fx, v = (y - cy) / fx;
                // In shares of the picture's height, so that larger pictures show the same.
                const double a = at / what.height, b = static_cast<double>(y) / what.height;
                const bool in_box = a > 0.25 && a < 0.55 && b > 0.3 && b < 0.65;
                const double off = std::hypot(a - 0.95, b - 0.5) / 0.22;
                double z = what.wall_mm / (1 + 0.25 * u + 0.15 * v);
                if (in_box) z = 0.75 * what.wall_mm / (1 + 0.3 * u - 0.1 * v);
                if (off < 1) z = what.wall_mm * (0.85 - 0.08 * std::sqrt(1 - off * off));
                double noise = -6;
                for (int k = 0; k < 12; ++k) noise += random.unit();
                z += what.noise_mm * noise;
                if (what.level_per_mm > 0)
                    z = 1 / (what.level_per_mm * std::floor(1 / (what.level_per_mm * z)));
                const bool shadow = a > 0.22 && a <= 0.25 && b > 0.3 && b < 0.65;
                const bool hole = what.hole_share > 0 && (shadow || random.unit() < what.hole_share);
                const auto code =
                    hole ? 0U : static_cast<unsigned>(std::clamp(std::floor(z / scale + 0.5), 1.0, 65535.0));
                depth.samples.push_back(static_cast<std::uint8_t>(code & 0xff));
                depth.samples.push_back(static_cast<std::uint8_t>(code >> 8));
                for (int c = 0; c < what.colours; ++c)
                    colour.samples.push_back(
                        static_cast<std::uint8_t>(static_cast<int>(7 * at + 13 * y) % (251 - c)));
            }
        const auto named = [&](const std::string& pattern) {
            char name[64];
            std::snprintf(name, sizeof name, pattern.c_str(), first + n);
            return folder / name;
        };
        EXPECT_TRUE(write_png(named(depth_files), depth.view()));
        EXPECT_TRUE(write_png(named(colour_files), colour.view()));
    }
    return folder / "scene.json";
}

/// A pressing hand's angle, 2000 times a second, and a wiping hand's places: as the real recordings of hands
/// are stored.
inline std::string pressing_hand_csv() {
    std::string text = "t_s,master_rad,slave_rad\n";
    for (int row = 0; row < 5000; ++row) {
        char line[80];
        const double t = 0.0005 * row, angle = 0.04 * std::sin(5 * t) + 0.02 * std::sin(23 * t) - 0.05;
        std::snprintf(line, sizeof line, "%.4f,%.7f,%.7f\n", t, angle, 0.9 * angle);
        text += line;
    }
    return text;
}
inline std::string wiping_hand_csv() {
    std::string text = "t_s,x_m,y_m,z_m,q0\n";
    for (int row = 0; row < 250; ++row) {
        char line[120];
        const double t = 0.01 * row;
        std::snprintf(line, sizeof line, "%.2f,%.6f,%.6f,%.6f,0\n", t, -0.39 + 0.06 * std::cos(4 * t),
                      -0.04 + 0.03 * std::sin(4 * t), 0.57 + 0.004 * std::sin(9 * t));
        text += line;
    }
    return text;
}

}  // namespace touchable::test
