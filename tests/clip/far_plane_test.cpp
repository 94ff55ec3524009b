#include "engine/clip/readers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace touchable::test {
namespace {

constexpr int wide_columns = 200, wide_rows = 100;

DepthCoding millimetres() {
    DepthCoding coding;
    coding.kind = DepthCodingKind::metric;
    coding.semantics = DepthSemantics::planar;
    coding.scale = 0.001;
    coding.code_max = 65535;
    coding.far = 65.535;
    coding.invalid_code_count = 1;  // 0
    derive_valid_range(coding);
    return coding;
}

Scene scene_without_far() {
    Scene scene;
    scene.width = wide_columns;
    scene.height = wide_rows;
    scene.camera = {150, 150, 100, 50};
    scene.depth = millimetres();
    scene.depth_bits = 16;
    return scene;
}

/// 1 m to 5 m, and so many pixels at 19.7 m.
std::vector<std::uint16_t> depth_with_strays(int strays, int deepest = 5000) {
    std::vector<std::uint16_t> codes(wide_columns * wide_rows);
    for (std::size_t k = 0; k < codes.size(); ++k)
        codes[k] = static_cast<std::uint16_t>(1000 + k % static_cast<std::size_t>(deepest - 999));
    for (int k = 0; k < strays; ++k) codes[static_cast<std::size_t>(k) * 37] = 19700;
    return codes;
}

PlaneView wide_view(const std::vector<std::uint16_t>& codes) {
    return {
        reinterpret_cast<const std::uint8_t*>(codes.data()), wide_columns * 2, wide_columns, wide_rows, 2, 1};
}

/// A clip whose frames are made as they are read.
class MadeClip : public ClipReader {
public:
    explicit MadeClip(std::int64_t count) : count_(count), scene_(scene_without_far()) {}
    const Scene& scene() const override { return scene_; }
    const std::vector<TrackInfo>& tracks() const override { return tracks_; }
    std::optional<std::int64_t> frame_count() const override { return count_; }
    const std::vector<std::string>& notes() const override { return notes_; }
    Result<std::optional<RawFrame>> next() override {
        if (number_ == count_) return std::optional<RawFrame>{};
        const std::int64_t number = number_++;
        read_.push_back(number);
        if (damaged_.contains(number)) return input_error("damaged");
        codes_ = depth_with_strays(strays_, deepest_.contains(number) ? deepest_.at(number) : 5000);
        if (is_empty_) std::fill(codes_.begin(), codes_.end(), std::uint16_t{0});
        RawFrame frame;
        frame.number = number;
        frame.depth = wide_view(codes_);
        return std::optional(frame);
    }
    Result<void> rewind() override { return seek(0); }
    Result<void> seek(std::int64_t frame) override {
        number_ = frame;
        ++seeks_;
        return {};
    }
    std::int64_t access_point(std::int64_t frame) const override { return can_seek_ ? frame : 0; }

    bool can_seek_ = true, is_empty_ = false;
    int seeks_ = 0, strays_ = 0;
    std::set<std::int64_t> damaged_;
    std::map<std::int64_t, int> deepest_;
    std::vector<std::int64_t> read_;
    std::int64_t number_ = 0;

    const std::int64_t count_;
    Scene scene_;
    std::vector<TrackInfo> tracks_;
    std::vector<std::string> notes_;
    std::vector<std::uint16_t> codes_;
};

TEST(FarPlane, IsNotThatOfStrayPixels) {
    for (const int strays : {0, 1, 2, 3, 40}) {  // of 20 000
        auto made = std::make_unique<MadeClip>(1);
        made->strays_ = strays;
        const auto settled = with_far_plane(std::move(made), true, "made");
        ASSERT_TRUE(settled) << settled.error().message;
        const DepthCoding& depth = (*settled)->scene().depth;
        const std::string& note = (*settled)->notes().back();
        const bool left_out = strays <= 2;
        EXPECT_DOUBLE_EQ(depth.far, (left_out ? 5.0 : 19.7) * 1.05) << strays;
        EXPECT_EQ(depth.is_valid(19700), !left_out) << strays;
        EXPECT_EQ(note.find("count as holes") != std::string::npos, strays == 1 || strays == 2) << note;
    }
}

TEST(FarPlane, NeedsAValidPixel) {
    auto made = std::make_unique<MadeClip>(1);
    made->is_empty_ = true;
    EXPECT_FALSE(with_far_plane(std::move(made), true, "made"));
}

TEST(FarPlane, TakesAsManyFramesOfAnHourAsOfASecond) {
    EXPECT_EQ(telling_frames(0), std::vector<std::int64_t>());
    EXPECT_EQ(telling_frames(3), (std::vector<std::int64_t>{0, 1, 2}));
    EXPECT_EQ(telling_frames(18).size(), 18U);
    for (const std::int64_t count :
         {std::int64_t{32}, std::int64_t{33}, std::int64_t{1000}, std::int64_t{1} << 40}) {
        const auto frames = telling_frames(count);
        EXPECT_EQ(frames.size(), 32U) << count;
        EXPECT_EQ(frames[15], 15) << count;
        EXPECT_EQ(frames.back(), count - 1);
        EXPECT_TRUE(std::is_sorted(frames.begin(), frames.end())) << count;
    }
    auto made = std::make_unique<MadeClip>(108'000);
    MadeClip& clip = *made;
    clip.deepest_ = {{107'999, 9000}, {20'000, 12'000}};
    const auto settled = with_far_plane(std::move(made), true, "made");
    ASSERT_TRUE(settled) << settled.error().message;
    EXPECT_EQ(clip.read_, telling_frames(108'000));
    // Of 640 000 pixels 64 may be beyond.
    EXPECT_NEAR((*settled)->scene().depth.far, 9.0 * 1.05, 0.1);
    EXPECT_EQ((*settled)->notes().size(), 1U);
    // Whoever plays it reads none of the first frames again.
    for (std::int64_t number = 0; number < 20; ++number) {
        const auto frame = (*settled)->next();
        ASSERT_TRUE(frame && *frame);
        EXPECT_EQ((*frame)->number, number);
    }
    EXPECT_EQ(clip.read_.size(), 32U + 4U);
    EXPECT_EQ(clip.read_.back(), 19);
    ASSERT_TRUE((*settled)->rewind());
    EXPECT_EQ((**(*settled)->next()).number, 0);
}

TEST(FarPlane, ThatIsGivenStays) {
    auto made = std::make_unique<MadeClip>(100);
    MadeClip& clip = *made;
    const auto settled = with_far_plane(std::move(made), false, "made");
    ASSERT_TRUE(settled);
    EXPECT_EQ(settled->get(), &clip);
    EXPECT_TRUE(clip.read_.empty());
}

TEST(FarPlane, OfAClipThatCannotSeekIsThatOfItsFirstFrames) {
    auto made = std::make_unique<MadeClip>(100);
    MadeClip& clip = *made;
    clip.can_seek_ = false;
    clip.deepest_ = {{15, 7000}, {99, 9000}};
    const auto settled = with_far_plane(std::move(made), true, "made");
    ASSERT_TRUE(settled);
    EXPECT_EQ(clip.read_.size(), 16U);
    EXPECT_EQ(clip.seeks_, 0);
    EXPECT_NEAR((*settled)->scene().depth.far, 7.0 * 1.05, 0.1);
}

TEST(FarPlane, DamageInALaterFrameIsNoMatter) {
    auto made = std::make_unique<MadeClip>(100);
    MadeClip& clip = *made;
    clip.damaged_ = {5, 99};
    const auto settled = with_far_plane(std::move(made), true, "made");
    ASSERT_TRUE(settled);
    EXPECT_DOUBLE_EQ((*settled)->scene().depth.far, 5.0 * 1.05);
    EXPECT_EQ(clip.number_, 0) << "read anew, so that whoever plays it meets the damage";
    auto hopeless = std::make_unique<MadeClip>(100);
    hopeless->damaged_ = {0};
    EXPECT_FALSE(with_far_plane(std::move(hopeless), true, "hopeless"));
}

}  // namespace
}  // namespace touchable::test
