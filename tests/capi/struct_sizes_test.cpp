// A struct that has grown is understood from programs that were compiled before it did.
#include <gtest/gtest.h>

#include "capi/status.hpp"

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
    const Grown wanted = over_defaults(as_grown(old), Grown{sizeof(Grown), 1, 2});
    EXPECT_EQ(wanted.first, 3);
    EXPECT_EQ(wanted.later, 2) << "its default";
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
