// A struct that has grown is understood from programs that were compiled before it did.
#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "capi/api_common.hpp"
#include "tests/capi/hill.hpp"

namespace touchable::capi {

/// `later` came with a second version.
struct Grown {
    std::uint32_t struct_size;
    int first;
    int later;
};
template <>
inline constexpr std::size_t first_size<Grown> = 8;

namespace {

struct AsItWas {
    std::uint32_t struct_size;
    int first;
    int beyond;  ///< of the program, behind the struct
};

Grown& as_grown(AsItWas& old) {
    return reinterpret_cast<Grown&>(old);
}

TEST(StructSizes, OfAnOlderProgramAreFilledInAndNoFurther) {
    AsItWas old{0, 0, 77};
    EXPECT_EQ(give_defaults(Grown{0, 1, 2}, &as_grown(old), 8), TOUCH_OK);
    EXPECT_EQ(old.struct_size, 8U);
    EXPECT_EQ(old.first, 1);
    EXPECT_EQ(old.beyond, 77);
    hand_out(Grown{0, 5, 6}, as_grown(old));
    EXPECT_EQ(old.struct_size, 8U);
    EXPECT_EQ(old.first, 5);
    EXPECT_EQ(old.beyond, 77);
}

TEST(StructSizes, OfAnOlderProgramAreReadAndNoFurther) {
    AsItWas old{8, 3, 77};
    EXPECT_TRUE(has_known_size(&as_grown(old)));
    const Grown wanted = over_defaults(&as_grown(old), Grown{sizeof(Grown), 1, 2});
    EXPECT_EQ(wanted.first, 3);
    EXPECT_EQ(wanted.later, 2) << "its default";
}

TEST(StructSizes, OlderFramesGetNoCount) {
    const touch_camera camera = test::Hill::camera();
    touch_scene scene{};
    touch_surface surface{};
    ASSERT_EQ(touch_scene_from_camera(&camera, &scene, nullptr), TOUCH_OK);
    ASSERT_EQ(touch_surface_create(scene, nullptr, &surface, nullptr), TOUCH_OK);
    std::vector<float> metres(
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height), 0.5F);
    metres[3] = 7;  // beyond the far plane
    std::int64_t lost = -1;
    // Of a part of the pointer, too, nothing is written.
    std::int64_t number = 0;
    for (const std::size_t size : {offsetof(touch_frame, lost_pixels), sizeof(touch_frame) - 1}) {
        touch_frame frame = test::Hill().frame(number++);
        frame.depth = {metres.data(), 4 * camera.width, camera.width, camera.height, TOUCH_F32, 1};
        frame.lost_pixels = &lost;
        frame.struct_size = static_cast<std::uint32_t>(size);
        EXPECT_EQ(touch_surface_push(surface, &frame, nullptr), TOUCH_OK);
        EXPECT_EQ(lost, -1);
    }
    touch_frame old{};
    old.lost_pixels = &lost;
    EXPECT_EQ(touch_frame_defaults(&old, offsetof(touch_frame, lost_pixels)), TOUCH_OK);
    EXPECT_EQ(old.lost_pixels, &lost) << "of the program, behind the struct";
    touch_surface_destroy(surface);
    touch_scene_destroy(scene);
}

TEST(StructSizes, ThatNobodyKnowsAreRefused) {
    Grown grown{4, 0, 0};
    EXPECT_FALSE(has_known_size(&grown));
    grown.struct_size = sizeof grown + 4;
    EXPECT_FALSE(has_known_size(&grown));
    EXPECT_FALSE(has_known_size<Grown>(nullptr));
    EXPECT_EQ(give_defaults(Grown{}, &grown, 4), TOUCH_USAGE);
    EXPECT_EQ(give_defaults(Grown{}, &grown, sizeof grown + 4), TOUCH_USAGE);
}

}  // namespace
}  // namespace touchable::capi
