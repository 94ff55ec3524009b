// A proxy on the very rim of a face belongs to what is on the other side of the rim as well.
#include <gtest/gtest.h>

#include "tests/haptics/small_field.hpp"
#include "tests/reference/certificate.hpp"

namespace touchable::test {
namespace {

/// Columns that come nearer to the right; above row 4 the ground falls away. Focal length and depths are
/// powers of two and their sums, so that goals of height 0 run along row 4 to the bit.
TEST(Rim, AFootOnTheRimIsNoRestWhereTheOtherSideFallsAway) {
    SmallField cliff(9, 9, 256, DepthSemantics::planar);
    cliff.scene.camera = {8, 8, 4, 4};
    cliff.shape(cliff.prev, [](int x, int y) { return y < 4 ? 256.0 : 128.0 - 8 * x; });
    const reference::Surface surface(cliff.scene, cliff.pair());
    FingerState finger;
    cliff.touch(finger, {5.5, 0, -32});
    for (int k = 0; k < 20; ++k) {
        const Contact contact = cliff.touch(finger, {5.5 + 0.125 * k, 0, -93});
        ASSERT_TRUE(contact.touching);
        EXPECT_LT(reference::way_left(surface, finger.proxy, contact.goal), 1e-9L) << "tick " << k;
    }
}

}  // namespace
}  // namespace touchable::test
