#pragma once

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <memory>
#include <utility>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

/// A clip of a wall, brown on its left half and blue on its right one: a segment each. 96x64 pixels, 0.16 m
/// of the hand wide; pixels (20, 32) and (70, 32) are of either.
inline void write_two_surfaces(const std::filesystem::path& file, int frames) {
    constexpr int width = 96, height = 64;
    Scene scene = small_scene(width, height, 8);
    scene.camera = {400, 400, 47.5, 31.5};
    scene.metres_per_unit = 0.001;
    auto writer = create_clip(file, scene, exact_clip);
    ASSERT_TRUE(writer) << writer.error().message;
    for (int n = 0; n < frames; ++n) {
        auto memory = std::make_shared<std::array<Image, 2>>();
        auto& [depth, colour] = *memory;
        depth = {width, height, 1, 1, std::vector<std::uint8_t>(std::size_t{width} * height, 120)};
        colour = {width, height, 1, 3, {}};
        for (int k = 0; k < width * height; ++k)
            for (const int value : k % width < width / 2 ? std::array{150, 100, 60} : std::array{60, 70, 150})
                colour.samples.push_back(static_cast<std::uint8_t>(value));
        RawFrame frame;
        frame.number = n;
        frame.time_ns = scene.rate.time_ns(n);
        frame.depth = depth.view();
        frame.colour = colour.view();
        frame.storage = std::move(memory);
        const auto written = (*writer)->write(frame);
        ASSERT_TRUE(written) << written.error().message;
    }
    ASSERT_TRUE((*writer)->finish());
}

}  // namespace touchable::test
