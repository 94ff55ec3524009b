#include "engine/authoring/segments.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <sstream>

#include "engine/authoring/segment_parts.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

TEST(Palette, HasMaterialsThatCanBeFelt) {
    std::set<std::string_view> names;
    for (const PaletteMaterial& material : palette()) {
        SCOPED_TRACE(material.name);
        EXPECT_TRUE(names.insert(material.name).second);
        EXPECT_GT(material.stiffness, 0);
        EXPECT_LE(material.stiffness, as_stiff_as_the_device);
        EXPECT_EQ(material.stiffness == as_stiff_as_the_device,
                  material.stiffness_source == "as stiff as the device can");
        EXPECT_GE(material.dynamic_friction, 0);
        EXPECT_LE(material.dynamic_friction, material.static_friction);
        // No source has both: the static one is estimated.
        EXPECT_NEAR(material.static_friction, material.dynamic_friction * 4 / 3, 0.0051);
        EXPECT_FALSE(material.friction_source.empty());
        EXPECT_EQ(find_material(material.name), &material);
    }
    EXPECT_GE(names.size(), 16U);
}

TEST(Palette, SaysWhichMaterialsThereAre) {
    EXPECT_EQ(find_material("wod"), nullptr);
    const std::string why = no_such_material("wod");
    EXPECT_NE(why.find("\"wod\" is no material (wood?)"), std::string::npos) << why;
    for (const PaletteMaterial& material : palette())
        EXPECT_NE(why.find(material.name), std::string::npos) << material.name;
}

TEST(Palette, IsCodedToHalfAStepAndKeepsTheOrderOfFrictions) {
    const HapticRanges ranges = ranges_of_palette({}, {});
    for (const PaletteMaterial& material : palette()) {
        const auto code = haptic_code(material.feel().properties, ranges);
        const HapticProperties felt = ranges.at(code[0], code[1], code[2]);
        EXPECT_NEAR(felt.stiffness / 1000, material.stiffness, 0.0039) << material.name;
        EXPECT_NEAR(felt.static_friction, material.static_friction, 0.003) << material.name;
        EXPECT_NEAR(felt.dynamic_friction, material.dynamic_friction, 0.003) << material.name;
        EXPECT_LE(code[2], code[1]) << material.name;
    }
    const Feel stone{{5e3, 3, 2}, 100};
    EXPECT_EQ(ranges_of_palette({}, {stone}).stiffness.max, 5);
    EXPECT_EQ(ranges_of_palette({}, {stone}).dynamic_friction.max, 3);
}

/// What docs/content.md prints.
TEST(Palette, IsInTheDocumentsAsItIs) {
    const std::string docs = read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "docs/content.md");
    for (const PaletteMaterial& material : palette()) {
        std::ostringstream row;
        row << "| `" << material.name << "` | " << material.stiffness << " | " << material.static_friction
            << ", " << material.dynamic_friction << " | " << material.relief << " | ";
        EXPECT_NE(docs.find(row.str()), std::string::npos) << row.str();
    }
}

TEST(Palette, GuessesWhatColoursSuggest) {
    const auto guess = [](std::array<std::uint8_t, 3> colour, int levels, int per_cent) {
        return guess_material({1, per_cent, colour, 0, 0, levels * 16}, 100).name;
    };
    EXPECT_EQ(guess({150, 100, 60}, 3, 30), "wood");
    EXPECT_EQ(guess({220, 170, 150}, 1, 10), "skin");
    EXPECT_EQ(guess({170, 70, 50}, 8, 30), "brick");
    EXPECT_EQ(guess({70, 130, 50}, 9, 30), "grass");
    EXPECT_EQ(guess({240, 240, 238}, 1, 10), "paper");
    EXPECT_EQ(guess({140, 140, 145}, 1, 5), "metal");
    EXPECT_EQ(guess({140, 140, 145}, 1, 10), "plastic");
    EXPECT_EQ(guess({140, 140, 140}, 9, 10), "stone");
    EXPECT_EQ(guess({30, 30, 30}, 1, 10), "rubber");
    EXPECT_EQ(guess({220, 30, 40}, 1, 5), "plastic");
    EXPECT_EQ(guess({60, 70, 150}, 4, 10), "cloth");
    EXPECT_EQ(guess({60, 70, 150}, 4, 40), "carpet");
}

TEST(Palette, HasAGuessForWhateverIsSeen) {
    for (int red = 0; red < 256; red += 15)
        for (int green = 0; green < 256; green += 15)
            for (int blue = 0; blue < 256; blue += 15)
                for (const int contrast : {0, 32, 33, 96, 97, 5000})
                    for (const int pixels : {0, 1, 300, 1000}) {
                        const Segment segment{
                            1,
                            pixels,
                            {static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green),
                             static_cast<std::uint8_t>(blue)},
                            0,
                            0,
                            contrast};
                        ASSERT_NE(find_material(guess_material(segment, 1000).name), nullptr);
                    }
}

}  // namespace
}  // namespace touchable::test
