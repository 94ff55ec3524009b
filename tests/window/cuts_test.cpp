#include <gtest/gtest.h>

#include <vector>

#include "player/run/surface_feed.hpp"

namespace touchable::test {
namespace {

/// A slope from 100 to 1100 codes with a plateau of `code` over `share` of its columns.
class SlopeWithAPlateau {
public:
    void look(SceneCuts& cuts, std::int64_t number, int code, double share, std::uint64_t epoch = 0) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                samples_[static_cast<std::size_t>(y * width + x)] =
                    static_cast<std::uint16_t>(x < share * width ? code : 100 + 1000 * y / height);
        RawFrame frame;
        frame.number = number;
        frame.epoch = epoch;
        frame.depth.data = reinterpret_cast<const std::uint8_t*>(samples_.data());
        frame.depth.stride = 2 * width;
        frame.depth.width = width;
        frame.depth.height = height;
        frame.depth.bytes_per_sample = 2;
        DepthCoding coding;
        coding.valid_max = coding.code_max = 65535;
        cuts.look(frame, coding);
    }

private:
    static constexpr int width = 80, height = 60;
    std::vector<std::uint16_t> samples_ = std::vector<std::uint16_t>(std::size_t{width} * height);
};

TEST(SceneCuts, AreWhereMostOfThePictureHasAnotherDepthAtOnce) {
    SceneCuts cuts;
    SlopeWithAPlateau shown;
    shown.look(cuts, 0, 0, 0);
    shown.look(cuts, 1, 600, 0.3);  // somebody comes
    shown.look(cuts, 2, 640, 0.5);  // nearer, and moves
    shown.look(cuts, 3, 640, 0.5);
    EXPECT_TRUE(cuts.found().empty());
    shown.look(cuts, 4, 1100, 1);
    shown.look(cuts, 5, 1100, 1);
    shown.look(cuts, 6, 100, 1, 1);  // another epoch: somebody has gone elsewhere
    shown.look(cuts, 40, 1100, 1, 1);
    EXPECT_EQ(cuts.found(), std::set<std::int64_t>{4});
    shown.look(cuts, 41, 0, 0, 1);
    EXPECT_EQ(cuts.found(), (std::set<std::int64_t>{4, 41}));
}

}  // namespace
}  // namespace touchable::test
