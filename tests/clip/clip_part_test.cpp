// SPDX-License-Identifier: Apache-2.0
// A part of a clip as a clip.

#include <cmath>
#include <set>

#include "engine/clip/readers.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

constexpr int part_width = 24, part_height = 18, part_frames = 10;

class PartialClip : public ::testing::Test {
protected:
    PartialClip() {
        Scene scene = small_scene(part_width, part_height, 12);
        scene.rate = {30000, 1001};
        EXPECT_EQ(message(write_clip(folder_ / "clip.mkv", scene, part_frames, all_planes)), "");
        const auto frames = read_clip(folder_ / "clip.mkv");
        EXPECT_EQ(message(frames), "");
        whole_ = *frames;
    }
    Result<std::unique_ptr<ClipReader>> open(const ClipPart& part) const {
        auto clip = open_clip(folder_ / "clip.mkv");
        EXPECT_EQ(message(clip), "");
        return part_of_clip(std::move(*clip), part);
    }
    TemporaryFolder folder_;
    std::vector<RawFrame> whole_;
};

TEST_F(PartialClip, HasEachNthFrame) {
    for (const ClipPart& part : {ClipPart{2}, ClipPart{0, 0}, ClipPart{1, 8, 3}, ClipPart{1, 7, 3},
                                 ClipPart{0, std::nullopt, 4}, ClipPart{9}, ClipPart{3, 3, 100}}) {
        auto reader = must(open(part));
        std::vector<RawFrame> expected;
        for (std::int64_t n = part.first; n <= part.last.value_or(part_frames - 1); n += part.every) {
            expected.push_back(whole_[static_cast<std::size_t>(n)]);
            expected.back().number = std::ssize(expected) - 1;
            // n/every frames later at a rate that is so much lower.
            expected.back().time_ns = FrameRate{30000, 1001 * part.every}.time_ns(expected.back().number);
        }
        EXPECT_EQ(reader->frame_count(), std::ssize(expected));
        for (const bool again : {false, true}) {
            EXPECT_TRUE(same_frames(must(read_all(*reader)), expected)) << part.first << " " << part.every;
            const auto back = again ? Result<void>{} : reader->rewind();
            ASSERT_EQ(message(back), "");
        }
        const std::int64_t last = std::ssize(expected) - 1;
        EXPECT_LE(reader->access_point(last), last);
        expect_seek_to(*reader, static_cast<int>(last), expected);
        EXPECT_NE(message(reader->seek(last + 2)), "");
    }
}

TEST_F(PartialClip, KeepsVerticesWhenCropped) {
    const ClipPart::Crop box{5, 3, 11, 9};
    auto whole = open_clip(folder_ / "clip.mkv");
    auto reader = must(open({0, std::nullopt, 1, box}));
    const Scene &before = (*whole)->scene(), &now = reader->scene();
    EXPECT_EQ(now.width, 11);
    EXPECT_EQ(now.height, 9);
    const auto frame = must(reader->next());
    for (int y = 0; y < box.height; ++y)
        for (int x = 0; x < box.width; ++x) {
            for (const PlaneRole role : all_roles)
                ASSERT_EQ(plane_of(*frame, role).sample(x, y),
                          plane_of(whole_[0], role).sample(x + 5, y + 3));
            for (const DepthSemantics semantics : {DepthSemantics::planar, DepthSemantics::range}) {
                const auto vertex = [&](const Camera& camera, double i, double j) {
                    return unproject(camera, i, j, planar_depth(camera, semantics, i, j, 123.4));
                };
                const glm::dvec3 was = vertex(before.camera, x + 5, y + 3), is = vertex(now.camera, x, y);
                for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(is[axis], was[axis], 1e-12 * 123.4);
            }
        }
}

TEST_F(PartialClip, RejectsFramesAndPixelsOutside) {
    for (const ClipPart& part :
         {ClipPart{10}, ClipPart{0, 10}, ClipPart{3, 2}, ClipPart{-1}, ClipPart{0, std::nullopt, 0},
          ClipPart{0, std::nullopt, 1, ClipPart::Crop{20, 0, 5, 5}},
          ClipPart{0, std::nullopt, 1, ClipPart::Crop{0, 0, 0, 5}},
          ClipPart{0, std::nullopt, 1, ClipPart::Crop{0, 14, 5, 5}}}) {
        EXPECT_TRUE(is_refused(open(part), "", ErrorKind::usage));
    }
}

TEST(ClipNotes, NameLossyDepth) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "exact.mkv", small_scene(64, 48), 2, {true})), "");
    EXPECT_FALSE(has_note(must(open_clip(folder / "exact.mkv"))->notes(), "stored as"));
    for (const char* role : {"depth", "colour"}) {
        remux(folder / "exact.mkv", folder / "lossy.mkv", {.transcoded = {{role, "mjpeg"}}});
        const auto reader = must(open_clip(folder / "lossy.mkv"));
        EXPECT_EQ(has_note(reader->notes(), "depth is stored as mjpeg, which changes values"),
                  role == std::string("depth"));
    }
}

TEST(ClipNotes, NameFrameWithoutDepth) {
    const TemporaryFolder folder;
    const Planes ramp{.noisy = false};  // from 4 on
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, ramp)), "");
    EXPECT_FALSE(has_note(must(open_clip(folder / "clip.mkv"))->notes(), "no valid depth"));
    Scene scene = small_scene(40, 30);
    scene.depth.code_max = 3;
    const auto reader = must(open_as(folder / "clip.mkv", scene));
    EXPECT_TRUE(has_note(reader->notes(), "frame 0 has no valid depth"));
}

/// The error of opening a clip of so many bits with a scene of 16.
std::string of_bits(int bits, DepthCodingKind kind) {
    const TemporaryFolder folder;
    EXPECT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, bits), 1, {})), "");
    EXPECT_EQ(message(open_clip(folder / "clip.mkv")), "");
    Scene scene = small_scene(40, 30, 16);
    scene.depth.kind = kind;
    scene.depth.scale = 0.01;
    return message(open_as(folder / "clip.mkv", scene));
}

TEST(ClipNotes, RejectTooFewBits) {
    const auto refused = [](int bits, const std::string& as) {
        for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse})
            EXPECT_TRUE(has_words(of_bits(bits, kind), "track depth, frame 0: is " + as));
        EXPECT_EQ(of_bits(bits, DepthCodingKind::metric), "");  // lengths, in any number of bits
    };
    refused(10, "10-bit grey, but the scene's depth.code_max is 65535: must be at most 1023");
    refused(12, "12-bit grey, but the scene's depth.code_max is 65535: must be at most 4095");
    EXPECT_EQ(of_bits(14, DepthCodingKind::metric), "");
}

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
class MadeClip : public OwnClip {
public:
    explicit MadeClip(std::int64_t count) : OwnClip(scene_without_far(), count) {}
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
    std::vector<std::uint16_t> codes_;
};

TEST(FarPlane, IgnoresStrayPixels) {
    for (const int strays : {0, 1, 2, 3, 40}) {  // of 20 000
        auto made = std::make_unique<MadeClip>(1);
        made->strays_ = strays;
        const auto settled = must(with_far_plane(std::move(made), true, "made"));
        const DepthCoding& depth = settled->scene().depth;
        const std::string& note = settled->notes().back();
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

TEST(FarPlane, SamplesLongClips) {
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
    const auto settled = must(with_far_plane(std::move(made), true, "made"));
    EXPECT_EQ(clip.read_, telling_frames(108'000));
    // Of 640 000 pixels 64 may be beyond.
    EXPECT_NEAR(settled->scene().depth.far, 9.0 * 1.05, 0.1);
    EXPECT_EQ(settled->notes().size(), 1U);
    // Playing it reads none of the first frames again.
    for (std::int64_t number = 0; number < 20; ++number) EXPECT_EQ(next_of(*settled).number, number);
    EXPECT_EQ(clip.read_.size(), 32U + 4U);
    EXPECT_EQ(clip.read_.back(), 19);
    ASSERT_TRUE(settled->rewind());
    EXPECT_EQ((*settled->next())->number, 0);
}

TEST(FarPlane, KeepsStatedOne) {
    auto made = std::make_unique<MadeClip>(100);
    MadeClip& clip = *made;
    const auto settled = must(with_far_plane(std::move(made), false, "made"));
    EXPECT_EQ(settled.get(), &clip);
    EXPECT_TRUE(clip.read_.empty());
}

TEST(FarPlane, ReadsFirstFramesWithoutSeeking) {
    auto made = std::make_unique<MadeClip>(100);
    MadeClip& clip = *made;
    clip.can_seek_ = false;
    clip.deepest_ = {{15, 7000}, {99, 9000}};
    const auto settled = must(with_far_plane(std::move(made), true, "made"));
    EXPECT_EQ(clip.read_.size(), 16U);
    EXPECT_EQ(clip.seeks_, 0);
    EXPECT_NEAR(settled->scene().depth.far, 7.0 * 1.05, 0.1);
}

TEST(FarPlane, IgnoresDamageInLaterFrames) {
    auto made = std::make_unique<MadeClip>(100);
    MadeClip& clip = *made;
    clip.damaged_ = {5, 99};
    const auto settled = must(with_far_plane(std::move(made), true, "made"));
    EXPECT_DOUBLE_EQ(settled->scene().depth.far, 5.0 * 1.05);
    EXPECT_EQ(clip.number_, 0) << "read anew, so that a player meets the damage";
    auto hopeless = std::make_unique<MadeClip>(100);
    hopeless->damaged_ = {0};
    EXPECT_FALSE(with_far_plane(std::move(hopeless), true, "hopeless"));
}

// Pictures at another size: what is touched is never mixed, and stays where it was.

/// Columns of a picture by whose middle a pixel of another lies, in plain words.
int nearest_in_long_double(int k, int from, int to) {
    const long double middle = (k + 0.5L) * from / to;  // of the pixel, in the other picture's pixels
    return static_cast<int>(std::floor(middle + 1e-12L));
}

TEST(ResizedFrame, KeepsSamplesOfTouch) {
    const Scene scene = small_scene(30, 20, 12);
    const RawFrame frame = test_frame(scene, 3, all_planes);
    for (const auto& [width, height] : {std::pair{15, 10}, {10, 4}, {7, 13}, {60, 20}, {1, 1}}) {
        const RawFrame small = resized_frame(frame, width, height);
        EXPECT_EQ(small.number, 3);
        EXPECT_EQ(small.time_ns, frame.time_ns);
        for (const PlaneRole role : {PlaneRole::depth, PlaneRole::haptic, PlaneRole::height}) {
            const PlaneView &was = plane_of(frame, role), &is = plane_of(small, role);
            ASSERT_EQ(is.width, width);
            ASSERT_EQ(is.height, height);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    for (int channel = 0; channel < was.channels; ++channel)
                        ASSERT_EQ(is.sample(x, y, channel),
                                  was.sample(nearest_in_long_double(x, 30, width),
                                             nearest_in_long_double(y, 20, height), channel));
        }
    }
}

TEST(ResizedFrame, AveragesColour) {
    const Scene scene = small_scene(12, 9);
    const RawFrame frame = test_frame(scene, 1, {true, false, false});
    for (const auto& [width, height] : {std::pair{4, 3}, {5, 7}, {12, 9}, {24, 10}}) {
        const RawFrame small = resized_frame(frame, width, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                // By 0.1 of a percent of a pixel on each side.
                long double sum = 0, weight = 0;
                const auto overlap = [](int s, int k, int from, int to) {
                    const long double begin = static_cast<long double>(k) * from / to,
                                      end = static_cast<long double>(k + 1) * from / to;
                    return std::max(0.0L,
                                    std::min<long double>(end, s + 1) - std::max<long double>(begin, s));
                };
                for (int v = 0; v < 9; ++v)
                    for (int u = 0; u < 12; ++u) {
                        const long double share = overlap(u, x, 12, width) * overlap(v, y, 9, height);
                        sum += share * frame.colour.sample(u, v, 1);
                        weight += share;
                    }
                EXPECT_LE(std::fabs(small.colour.sample(x, y, 1) - sum / weight), 0.5L + 1e-9L);
            }
    }
}

/// Each sample of depth where it was in the world: to the last bits where pixels are left out evenly.
TEST(ResizedFrame, KeepsVertices) {
    Scene scene = small_scene(30, 20);
    scene.camera = {51.25, 49.5, 14.3, 9.7};
    for (const auto& [width, height] : {std::pair{15, 10}, {10, 4}, {6, 5}, {30, 20}}) {
        const Camera camera = resized_scene(scene, width, height).camera;
        const std::vector<int> columns = nearest_samples(30, width), rows = nearest_samples(20, height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const double i = columns[static_cast<std::size_t>(x)], j = rows[static_cast<std::size_t>(y)];
                EXPECT_NEAR(camera.u(x), scene.camera.u(i), 1e-14);
                EXPECT_NEAR(camera.v(y), scene.camera.v(j), 1e-14);
            }
    }
    // Elsewhere within half a pixel of the larger picture, and on average where it was.
    for (const int width : {7, 11, 29, 45, 64}) {
        const Camera camera = resized_scene(scene, width, 20).camera;
        const std::vector<int> columns = nearest_samples(30, width);
        double sum = 0;
        for (int x = 0; x < width; ++x) {
            const double off = (camera.u(x) - scene.camera.u(columns[static_cast<std::size_t>(x)])) * 51.25;
            EXPECT_LE(std::fabs(off), 0.5) << width;
            sum += off;
        }
        EXPECT_NEAR(sum, 0, 1e-10) << width;
    }
}

}  // namespace
}  // namespace touchable::test
