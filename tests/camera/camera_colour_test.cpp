// The colour camera beside one of depth.
#include <gtest/gtest.h>

#include <chrono>

#include "engine/camera/v4l2_camera.hpp"
#include "engine/clip/readers.hpp"
#include "engine/picture/image.hpp"
#include "tests/camera/fake_video.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int cw = 16, ch = 8;
const std::string depth_node = "/dev/video0", colour_node = "/dev/video2";

using Bytes = std::vector<std::uint8_t>;

/// Red tells the number of the picture, green and blue the place.
Bytes rgb_of(std::uint32_t number, bool bgr) {
    Bytes bytes;
    for (int y = 0; y < ch; ++y)
        for (int x = 0; x < cw; ++x) {
            const std::uint8_t rgb[] = {static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(10 * x),
                                        static_cast<std::uint8_t>(20 * y)};
            for (int k = 0; k < 3; ++k) bytes.push_back(rgb[bgr ? 2 - k : k]);
        }
    return bytes;
}

/// Grey of 16 + 219/255 of this, as cameras write it, without colour.
constexpr int grey = 100;
constexpr auto luma = static_cast<std::uint8_t>(16 + (grey * 219 + 127) / 255);

class CameraColour : public ::testing::Test {
protected:
    CameraColour() { add_depth_node(*video, depth_node, cw, ch); }
    void TearDown() override {
        EXPECT_EQ(video->misuse(), std::vector<std::string>());
        EXPECT_EQ(video->left_over(), std::vector<std::string>());
    }
    FakeNode& add(std::uint32_t code, std::function<Bytes(std::uint32_t)> paint) {
        FakeNode& made = video->add(colour_node);
        made.formats = {{code, {{64, 48}, {cw, ch}}}};
        made.paint = std::move(paint);
        return made;
    }
    Result<std::unique_ptr<ClipReader>> open() const {
        V4l2Choice choice{depth_node};
        choice.colour = colour_node;
        choice.system = video;
        return open_v4l2_camera(choice, SourceDescription{{}, 60, 0.001, {}, {}, {}});
    }
    const std::shared_ptr<FakeVideo> video = std::make_shared<FakeVideo>();
};

TEST_F(CameraColour, ComesInEveryFormat) {
    const auto uniform = [](Bytes pair, std::size_t bytes) {
        Bytes all;
        while (all.size() < bytes) all.insert(all.end(), pair.begin(), pair.end());
        return [all](std::uint32_t) { return all; };
    };
    const TemporaryFolder folder;
    Bytes nv12(cw * ch, luma);
    nv12.resize(cw * ch * 3 / 2, 128);
    struct Case {
        std::uint32_t code;
        std::function<Bytes(std::uint32_t)> paint;
        bool is_exact;
    };
    for (const Case& each : {Case{V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); }, true},
                             Case{V4L2_PIX_FMT_BGR24, [](std::uint32_t n) { return rgb_of(n, true); }, true},
                             Case{V4L2_PIX_FMT_YUYV, uniform({luma, 128}, cw * ch * 2), false},
                             Case{V4L2_PIX_FMT_UYVY, uniform({128, luma}, cw * ch * 2), false},
                             Case{V4L2_PIX_FMT_NV12, [&](std::uint32_t) { return nv12; }, false}}) {
        add(each.code, each.paint).row_padding = 5;
        const auto camera = open();
        ASSERT_EQ(message(camera), "");
        EXPECT_EQ((*camera)->tracks().size(), 2u);
        const auto frame = (*camera)->next();
        ASSERT_EQ(message(frame), "");
        const PlaneView& colour = (*frame)->colour;
        ASSERT_EQ(colour.width, cw) << "the size of the depth, where it is offered";
        ASSERT_EQ(colour.channels, 3);
        for (int y = 0; y < ch; ++y)
            for (int x = 0; x < cw; ++x) {
                if (each.is_exact) {
                    EXPECT_EQ(colour.sample(x, y, 1), 10 * x);
                    EXPECT_EQ(colour.sample(x, y, 2), 20 * y);
                    continue;
                }
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(colour.sample(x, y, c), grey, 1);
            }
    }
}

/// Depth is taken each 40 ms of a virtual clock, and with each a colour picture, so long after it. What is
/// nearest to a depth picture is the colour of a few before it then, of the four that are kept.
TEST_F(CameraColour, IsThatOfTheNearestTime) {
    constexpr std::int64_t ms = 1'000'000, frame = 40 * ms;
    // In the machine's past, of which ten seconds are believed: the virtual clock runs for one.
    const std::int64_t begun = steady_now_ns() - 5000 * ms;
    struct Case {
        std::int64_t late;
        int before;
    };
    for (const Case& each : {Case{0, 0}, Case{-50 * ms, 0}, Case{15 * ms, 0}, Case{25 * ms, 1},
                             Case{70 * ms, 2}, Case{110 * ms, 3}, Case{300 * ms, 3}}) {
        std::int64_t depth_at = begun;
        int newest = -1;  // colour picture
        FakeNode& depth = add_depth_node(*video, depth_node, cw, ch);
        depth.stamp = [&](std::uint32_t n) { return depth_at = begun + n * frame; };
        FakeNode& colour = add(V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); });
        colour.stamp = [&](std::uint32_t n) {
            newest = static_cast<int>(n);
            return depth_at + each.late;
        };
        const auto camera = open();
        ASSERT_EQ(message(camera), "");
        for (int k = 0; k < 8; ++k) {
            const auto taken = (*camera)->next();
            ASSERT_EQ(message(taken), "");
            if (k < 3) continue;  // until four are there
            EXPECT_EQ((*taken)->colour.sample(0, 0, 0), newest - each.before) << each.late / ms << " ms late";
        }
    }
}

TEST_F(CameraColour, IsClosedWhereNobodyLooks) {
    add(V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); });
    const auto camera = open();
    ASSERT_EQ(message(camera), "");
    (*camera)->leave_out_colour();
    EXPECT_EQ(video->left_over().size(), 6u) << "depth's node, its stream and four buffers";
    const auto frame = (*camera)->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_TRUE((*frame)->colour.empty());
}

TEST_F(CameraColour, ThatIsUnpluggedLeavesDepthAlone) {
    add(V4L2_PIX_FMT_RGB24, [](std::uint32_t n) { return rgb_of(n, false); });
    const auto camera = open();
    ASSERT_EQ(message(camera), "");
    ASSERT_EQ(message((*camera)->begin(std::chrono::steady_clock::now() - std::chrono::milliseconds(1))), "");
    ASSERT_EQ(message((*camera)->next()), "");
    video->unplug(colour_node);
    for (int k = 0; k < 3; ++k) {
        const auto frame = (*camera)->next();
        ASSERT_EQ(message(frame), "");
        EXPECT_FALSE((*frame)->depth.empty());
    }
    ASSERT_EQ((*camera)->remarks().size(), 1u);
    EXPECT_EQ((*camera)->remarks()[0], "the camera of colour, /dev/video2, was unplugged");
}

TEST_F(CameraColour, IsRefusedWhereThereIsNone) {
    add(V4L2_PIX_FMT_Y16, nullptr);
    EXPECT_EQ(message(open()), colour_node +
                                   ": gives no colour that can be shown (Y16); colour= takes a "
                                   "node of RGB3, BGR3, YUYV, UYVY, NV12 or MJPG");
    add(V4L2_PIX_FMT_RGB24, nullptr).refusals[VIDIOC_S_FMT] = EBUSY;
    EXPECT_NE(message(open()).find(colour_node + ": another program has the camera"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
