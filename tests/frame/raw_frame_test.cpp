#include "engine/scene/frames.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "engine/scene/plane_memory.hpp"

namespace touchable::test {
namespace {

TEST(RawFrame, IsKeptBeyondTheMemoryItWasGivenIn) {
    std::vector<std::uint8_t> height{1, 2, 3, 0, 4, 5, 6, 0};  // rows of three, and a gap
    std::vector<std::uint16_t> depth{10, 20, 30, 40, 50, 60};
    RawFrame given;
    given.number = 7;
    given.height = {height.data(), 4, 3, 2, 1, 1};
    given.depth = {reinterpret_cast<const std::uint8_t*>(depth.data()), 6, 3, 2, 2, 1};
    const std::vector<std::uint8_t> height_then = height;
    const std::vector<std::uint16_t> depth_then = depth;
    RawFrame then = given;
    then.height.data = height_then.data();
    then.depth.data = reinterpret_cast<const std::uint8_t*>(depth_then.data());
    const RawFrame kept = kept_frame(given);
    height.assign(height.size(), 99);
    depth.assign(depth.size(), 99);
    EXPECT_TRUE(same_touch_planes(kept, then));
    EXPECT_FALSE(same_touch_planes(given, then));
    EXPECT_EQ(kept.number, 7);
    EXPECT_TRUE(kept.colour.empty());
    for (const PlaneView& plane : {kept.depth, kept.height}) {
        EXPECT_NE(plane_block_of(plane.data, static_cast<std::size_t>(plane.stride * 2)), nullptr);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(plane.data) % plane_alignment, 0U);
        EXPECT_EQ(static_cast<std::size_t>(plane.stride) % plane_row_alignment, 0U);
    }
    EXPECT_EQ(kept_frame(kept).depth.data, kept.depth.data) << "copied once more";
}

}  // namespace
}  // namespace touchable::test
