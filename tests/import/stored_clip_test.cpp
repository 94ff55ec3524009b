// SPDX-License-Identifier: Apache-2.0
// Stored clips: behaviour that is common to all sources of pictures.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <stop_token>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/stored_clip.hpp"
#include "engine/formats/value_evidence.hpp"
#include "tests/clip_notes.hpp"
#include "tests/picture/results.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr int fake_wide = 8, fake_high = 6;

/// Requests to a source, in words: "depth 0", "colour 3".
using Asked = std::vector<std::string>;

std::string in_words(PlaneRole role, std::int64_t frame) {
    return std::string(role_name(role)) + " " + std::to_string(frame);
}

StoredImage picture_of(PlaneRole role, std::int64_t number, int width = fake_wide) {
    const int channels = role == PlaneRole::depth ? 1 : 3;
    StoredImage stored{{width, fake_high, 1, channels, {}}, "png", channels == 1 ? "gray" : "rgb24"};
    stored.image.samples.assign(static_cast<std::size_t>(width * fake_high * channels),
                                static_cast<std::uint8_t>(10 + number));
    return stored;
}

class FakePictures final : public FrameSource {
public:
    explicit FakePictures(Asked& asked) : asked_(asked) {}
    std::function<Result<TrackPicture>(PlaneRole, std::int64_t)> made =
        [](PlaneRole role, std::int64_t frame) { return TrackPicture{picture_of(role, frame)}; };
    std::function<std::int64_t(PlaneRole, std::int64_t)> number = [](PlaneRole, std::int64_t frame) {
        return frame;
    };

    std::string where(PlaneRole role, std::int64_t frame) const override { return in_words(role, frame); }
    Result<TrackPicture> picture(PlaneRole role, std::int64_t frame) override {
        asked_.push_back(in_words(role, frame));
        return made(role, frame);
    }
    std::int64_t picture_number(PlaneRole role, std::int64_t frame) const override {
        return number(role, frame);
    }
    std::int64_t access_point(std::int64_t frame) const override { return frame - frame % 4; }
    void keep(std::int64_t frame, StoredImage) override { asked_.push_back("keep " + std::to_string(frame)); }

private:
    Asked& asked_;
};

class StoredClips : public ::testing::Test {
protected:
    Result<std::unique_ptr<ClipReader>> opened(std::int64_t count = 5) {
        StoredClip clip{"the clip", described};
        clip.count = count;
        clip.roles = {PlaneRole::depth, PlaneRole::colour};
        clip.pictures = std::move(pictures);
        return open_stored_clip(std::move(clip));
    }
    Asked taken() { return std::exchange(asked, {}); }

    Asked asked;
    std::unique_ptr<FakePictures> pictures = std::make_unique<FakePictures>(asked);
    SceneDescription described{small_scene(fake_wide, fake_high)};
};

TEST_F(StoredClips, ReadEveryPictureOnce) {
    auto clip = must(opened(3));
    EXPECT_EQ(taken(), (Asked{"depth 0", "colour 0"}));
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(taken(), (Asked{"depth 1", "colour 1", "depth 2", "colour 2"}));
    for (const std::int64_t n : {0, 1, 2}) {
        const RawFrame& frame = frames[static_cast<std::size_t>(n)];
        EXPECT_EQ(frame.number, n);
        EXPECT_EQ(frame.time_ns, described.scene.rate.time_ns(n));
        EXPECT_EQ(frame.depth.sample(0, 0), 10 + n);
        EXPECT_EQ(frame.colour.sample(fake_wide - 1, fake_high - 1, 2), 10 + n);
    }
    ASSERT_EQ(message(clip->seek(2)), "");
    EXPECT_TRUE(same_frame(**clip->next(), frames.back()));
    EXPECT_EQ(taken(), Asked{}) << "the newest is at hand";
    ASSERT_EQ(message(clip->rewind()), "");
    EXPECT_TRUE(same_frame(**clip->next(), frames.front()));
    EXPECT_EQ(taken(), (Asked{"depth 0", "colour 0"}));
}

TEST_F(StoredClips, ReadRepeatedPictureOnce) {
    pictures->number = [](PlaneRole role, std::int64_t frame) {
        return role == PlaneRole::depth ? frame : frame / 2;
    };
    const auto [clip, frames] = must_read(opened(4));
    EXPECT_EQ(taken(), (Asked{"depth 0", "colour 0", "depth 1", "depth 2", "colour 2", "depth 3"}));
    EXPECT_EQ(frames[1].colour.data, frames[0].colour.data);
    EXPECT_EQ(frames[3].colour.sample(0, 0), 12);
}

TEST_F(StoredClips, MixPalettesAndRgb) {
    pictures->made = [](PlaneRole role, std::int64_t frame) {
        TrackPicture picture{picture_of(role, frame)};
        if (role == PlaneRole::colour && frame % 2 == 1) picture.image.pixel_format = "pal8";
        return picture;
    };
    const auto [clip, frames] = must_read(opened(4));
    for (const RawFrame& frame : frames) EXPECT_EQ(frame.colour.sample(0, 0), 10 + frame.number);
}

TEST_F(StoredClips, BorrowDecoderSamples) {
    Samples memory;
    const PlaneView lent = test_plane(memory, fake_wide, fake_high, 1, 1, 255, 1, true);
    std::weak_ptr<const int> picture;  // of a decoder, as long as anybody has it
    pictures->made = [&](PlaneRole role, std::int64_t frame) {
        if (role == PlaneRole::colour) return TrackPicture{picture_of(role, frame)};
        EXPECT_TRUE(picture.expired()) << "its memory can serve the next, as it is unused";
        const auto made = std::make_shared<const int>(1);
        picture = made;
        return lent_picture({"depth", "h264", "gray"}, {lent, made});
    };
    auto clip = must(opened(3));
    for (int n = 0; n < 3; ++n) {
        const auto frame = must(clip->next());
        EXPECT_EQ((*frame).depth.data, lent.data);
        EXPECT_FALSE(picture.expired());
    }
    EXPECT_EQ(clip->tracks().front().codec, "h264");
    EXPECT_EQ(clip->tracks().front().width, fake_wide);
    EXPECT_TRUE(has_note(clip->notes(), "depth is stored as h264"));
}

/// A metre in frame 0, and a centimetre more in each.
class StoredClipsOfFloats : public StoredClips {
protected:
    StoredClipsOfFloats() {
        Scene& scene = described.scene;
        scene.depth.kind = DepthCodingKind::metric;
        scene.depth.semantics = DepthSemantics::planar;
        scene.depth.scale = 1;
        scene.depth.near = 0.1;
        scene.depth.far = 100;
        derive_valid_range(scene.depth);
        described.unstated.far = true;
        pictures->made = [this](PlaneRole role, std::int64_t frame) -> Result<TrackPicture> {
            if (role == PlaneRole::colour) return TrackPicture{picture_of(role, frame)};
            if (const auto found = failures.find(frame); found != failures.end()) return found->second;
            StoredImage stored{{fake_wide, fake_high, 2, 1, {}}, "pfm", "grayf32le"};
            stored.values.assign(fake_wide * fake_high, 1 + 0.01F * static_cast<float>(frame));
            return TrackPicture{std::move(stored)};
        };
    }
    std::map<std::int64_t, Error> failures;
};

TEST_F(StoredClipsOfFloats, SearchRangeInTellingFrames) {
    failures[3] = input_error("depth 3: is damaged");
    auto clip = must(opened(200));
    Asked looks;
    for (const std::int64_t frame : telling_frames(200)) {
        looks.push_back(in_words(PlaneRole::depth, frame));
        if (frame > 0 && frame < first_frames && frame != 3) looks.push_back("keep " + std::to_string(frame));
    }
    looks.emplace_back("colour 0");
    EXPECT_EQ(taken(), looks) << "and frame 0 is not read twice";
    EXPECT_NEAR(clip->scene().depth.far, 1.05 * 2.99, 1e-6) << "found once, not in the codes again";
    const auto first = must(clip->next());
    const DepthCoding& coding = clip->scene().depth;
    EXPECT_NEAR(coding.depth(static_cast<std::uint16_t>((*first).depth.sample(3, 3))), 1, 1e-4);
    ASSERT_EQ(message(clip->seek(3)), "");
    EXPECT_EQ(message(clip->next()), "depth 3: is damaged");
}

TEST_F(StoredClipsOfFloats, StopSearchWhenCancelled) {
    failures[5] = {ErrorKind::interrupted, "depth 5: given up"};
    EXPECT_EQ(message(opened(20)), "depth 5: given up");
    pictures = std::make_unique<FakePictures>(asked);
    std::stop_source person;
    pictures->made = [&](PlaneRole, std::int64_t frame) {
        if (frame == 2) person.request_stop();
        StoredImage stored{{fake_wide, fake_high, 2, 1, {}}, "pfm", "grayf32le"};
        stored.values.assign(fake_wide * fake_high, 1);
        return TrackPicture{std::move(stored)};
    };
    taken();
    const StopScope until(person.get_token());
    const auto clip = opened(20);
    ASSERT_FALSE(clip);
    EXPECT_EQ(clip.error().kind, ErrorKind::interrupted);
    EXPECT_EQ(taken(), (Asked{"depth 0", "depth 1", "keep 1", "depth 2", "keep 2"}));
}

TEST_F(StoredClips, RefuseFloatsAsColour) {
    pictures->made = [](PlaneRole role, std::int64_t frame) {
        StoredImage stored = picture_of(role, frame);
        if (role == PlaneRole::colour) stored.values.assign(fake_wide * fake_high, 0.5F);
        return TrackPicture{std::move(stored)};
    };
    EXPECT_EQ(message(opened()), "colour 0: is a picture of floats: must be of integers");
}

TEST_F(StoredClips, FillDescriptionFromSource) {
    const Camera one{50, 50, 4, 3}, other{60, 60, 4, 3};
    for (const auto& [cameras, kept] :
         {std::pair{std::vector{one, one}, 0U}, {std::vector{one, other}, 2U}}) {
        pictures = std::make_unique<FakePictures>(asked);
        StoredClip clip{"the clip", described};
        clip.described.unstated.rate = clip.described.unstated.camera = true;
        clip.count = 2;
        clip.roles = {PlaneRole::depth};
        clip.found = {.rate = FrameRate{25, 1}, .camera = one};
        clip.cameras = cameras;
        clip.inputs = {"some/file"};
        clip.pictures = std::move(pictures);
        auto reader = must(open_stored_clip(std::move(clip)));
        EXPECT_EQ(reader->scene().rate.num, 25);
        EXPECT_EQ(reader->frame_cameras().size(), kept) << "none where all are the scene's";
        EXPECT_EQ(reader->inputs().front(), "some/file");
    }
    described.unstated.camera = true;
    EXPECT_TRUE(is_refused(opened(), "the clip: camera is missing"));
}

constexpr int many = 5000;

/// The nearest float of 11 bits, by a second way: it is the sum that rounds.
float half_of(double value) {
    int exponent = 0;
    std::frexp(value, &exponent);
    return static_cast<float>(std::ldexp(std::nearbyint(std::ldexp(value, 11 - exponent)), exponent - 11));
}

std::optional<FloatLattice> lattice_of(int count, double metres, const std::function<float(int k)>& value) {
    LatticeSearch search;
    for (int k = 0; k < count; ++k) search.add(value(k));
    return search.of_lengths(metres);
}

/// Codes of a scene: what lies before a wall that leans.
std::vector<int> scene_codes(SplitMix64& random, int least, int most, int count = many) {
    std::vector<int> codes;
    for (int k = 0; k < count; ++k) {
        const double share = random.unit(), lean = 0.3 * random.unit();
        codes.push_back(least + static_cast<int>((most - least) * (share < 0.4 ? lean : 1 - lean)));
    }
    return codes;
}

TEST(FloatLattice, FindsMultiplesOfAnyUnit) {
    SplitMix64 random(1);
    for (int round = 0; round < 300; round += static_cast<int>(sweep_step())) {
        // From 10 um to 1 cm, of any digits; and what people use.
        constexpr double usual[] = {0.001, 0.000125, 0.0001, 1.0 / 5000, 0.00025, 1.0 / 256, 1.0 / 3000};
        const double unit =
            round % 2 == 0 ? usual[(round / 2 + round / 14) % 7] : 1e-5 * std::exp(6.9 * random.unit());
        const int most = 2000 + static_cast<int>(60000 * random.unit()), least = most / 3;
        const auto codes = scene_codes(random, least, most);
        for (const int way : {0, 1, 2}) {
            const auto found = lattice_of(many, 1, [&](int k) {
                const int code = codes[static_cast<std::size_t>(k)];
                if (way == 0) return static_cast<float>(code) * static_cast<float>(unit);
                if (way == 1) return static_cast<float>(code) / static_cast<float>(1 / unit);
                return static_cast<float>(code * unit);
            });
            ASSERT_TRUE(found) << "unit " << unit << " most " << most << " way " << way;
            EXPECT_EQ(found->first, 0) << unit;
            EXPECT_FALSE(found->of_reciprocals) << unit;
            EXPECT_EQ(found->off, 0) << unit;
            EXPECT_NEAR(found->step, unit, 0.2 * unit / most) << "way " << way << " most " << most;
            if (round % 2 == 0) {
                EXPECT_DOUBLE_EQ(found->step, unit);
            }
        }
    }
}

/// The same depths in millimetres, as floats.
TEST(FloatLattice, FindsWholeMillimetres) {
    SplitMix64 random(2);
    const auto codes = scene_codes(random, 350, 4000);
    const auto found = lattice_of(
        many, 0.001, [&](int k) { return static_cast<float>(codes[static_cast<std::size_t>(k)]); });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 1);
}

/// A camera that measures disparities and writes millimetres leaves most of these out.
TEST(FloatLattice, FindsUnitOfSparseLevels) {
    SplitMix64 random(3);
    const auto found = lattice_of(many, 1, [&](int) {
        const int disparity = 60 + static_cast<int>(200 * random.unit());
        return static_cast<float>(std::floor(75e3 / disparity)) * 0.001F;
    });
    ASSERT_TRUE(found);
    EXPECT_DOUBLE_EQ(found->step, 0.001);
}

TEST(FloatLattice, FindsDisparitiesByReciprocals) {
    SplitMix64 random(4);
    for (int round = 0; round < 200; ++round) {
        constexpr double parts[] = {1, 8, 16, 32};
        const double part = parts[round % 4], focal_baseline = 20 + 400 * random.unit();
        const int least = static_cast<int>(part * (12 + 40 * random.unit())), most = 2 * least + 60;
        const auto codes = scene_codes(random, least, most);
        const auto found = lattice_of(many, 1, [&](int k) {
            return static_cast<float>(focal_baseline) /
                   (static_cast<float>(codes[static_cast<std::size_t>(k)]) / static_cast<float>(part));
        });
        ASSERT_TRUE(found) << round;
        EXPECT_TRUE(found->of_reciprocals);
        EXPECT_EQ(found->first, 0);
        const double step = 1 / (part * focal_baseline);
        EXPECT_NEAR(found->step, step, 0.1 * step / most) << round;
    }
}

/// Kinect's formula, and planes of codes evenly in depth and in 1/depth: these do not go through zero.
TEST(FloatLattice, FindsStepsFromAnywhere) {
    SplitMix64 random(5);
    const auto codes = scene_codes(random, 400, 950);
    const auto kinect = lattice_of(many, 1, [&](int k) {
        const double raw = codes[static_cast<std::size_t>(k)];
        return static_cast<float>(1 / (raw * -0.0030711016 + 3.3309495161));
    });
    ASSERT_TRUE(kinect);
    EXPECT_TRUE(kinect->of_reciprocals);
    EXPECT_NEAR(kinect->step, 0.0030711016, 1e-9);
    const double places = (3.3309495161 - kinect->first) / kinect->step;
    EXPECT_NEAR(places, std::round(places), 1e-3);
    const auto linear = lattice_of(many, 1, [&](int k) {
        return static_cast<float>(0.713 + 1.9 * (codes[static_cast<std::size_t>(k)] & 255) / 255);
    });
    ASSERT_TRUE(linear);
    EXPECT_FALSE(linear->of_reciprocals);
    EXPECT_NEAR(linear->step, 1.9 / 255, 1e-8);
}

TEST(FloatLattice, IgnoresNoise) {
    SplitMix64 random(6);
    for (int round = 0; round < 200; ++round) {
        const double near = 0.2 + 3 * random.unit(), range = 0.01 + 5 * random.unit();
        const int count = round % 4 == 0 ? 9 + round / 4 : many;
        // Noise; a wall that leans; a ball before it.
        const auto found = lattice_of(count, 1, [&](int k) {
            const double share = round % 3 == 0 ? random.unit() : k / static_cast<double>(count);
            if (round % 3 == 2 && k % 2 == 0)
                return static_cast<float>(near + range * (1 - std::sqrt(1 - share * share)));
            return static_cast<float>(near +
                                      range * share * (1 + (round % 3 == 1 ? 0.1 * std::sqrt(share) : 0)));
        });
        EXPECT_FALSE(found) << round << " step " << (found ? found->step : 0) << " of " << count;
    }
}

/// Steps of 10 um over 4 m are more than codes of 16 bits: finding them is of no use.
TEST(FloatLattice, IgnoresMoreStepsThanCodes) {
    SplitMix64 random(7);
    const auto codes = scene_codes(random, 40'000, 400'000);
    EXPECT_FALSE(lattice_of(
        many, 1, [&](int k) { return static_cast<float>(codes[static_cast<std::size_t>(k)] * 1e-5); }));
}

/// A few walls at whole metres, or anywhere, are not what a sensor rounds to.
TEST(FloatLattice, IgnoresFlatWalls) {
    for (const int walls : {1, 3, 7}) {
        EXPECT_FALSE(lattice_of(many, 1, [&](int k) { return static_cast<float>(1 + k % walls); }));
        EXPECT_FALSE(lattice_of(many, 0.001, [&](int k) { return static_cast<float>(1 + k % walls); }));
    }
    EXPECT_FALSE(lattice_of(many, 1, [](int k) { return 0.51713F * static_cast<float>(k % 12) + 0.5F; }));
    EXPECT_FALSE(lattice_of(0, 1, [](int) { return 1.0F; }));
}

TEST(FloatLattice, CountsFloatsBetweenSteps) {
    SplitMix64 random(8);
    const auto codes = scene_codes(random, 500, 3000);
    for (const double off : {0.002, 0.008, 0.03, 0.5}) {
        const auto found = lattice_of(many, 1, [&](int k) {
            const double between = random.unit() < off ? 0.2 + 0.6 * random.unit() : 0;
            return static_cast<float>(0.000731 * (codes[static_cast<std::size_t>(k)] + between));
        });
        ASSERT_EQ(found.has_value(), off < 0.01) << off;
        if (!found) continue;
        EXPECT_NEAR(found->step, 0.000731, 1e-8);
        EXPECT_NEAR(found->off, off, 0.004);
    }
}

TEST(FloatLattice, FindsFinestStepOfHalves) {
    SplitMix64 random(9);
    const auto found = lattice_of(many, 1, [&](int) { return half_of(0.6 + 3 * random.unit()); });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 0x1p-11);
    EXPECT_FALSE(found->is_rounded);
    EXPECT_EQ(found->off, 0);
}

TEST(FloatLattice, FindsMillimetresOfHalves) {
    SplitMix64 random(10);
    const auto codes = scene_codes(random, 450, 3500);
    const auto found = lattice_of(many, 1, [&](int k) {
        return half_of(static_cast<float>(codes[static_cast<std::size_t>(k)]) * 0.001F);
    });
    ASSERT_TRUE(found);
    EXPECT_EQ(found->step, 0.001);
    EXPECT_TRUE(found->is_rounded);
}

TEST(FloatLattice, IgnoresOrder) {
    SplitMix64 random(11);
    std::vector<float> values;
    for (const int code : scene_codes(random, 700, 6000))
        values.push_back(static_cast<float>(code * 0.000317));
    LatticeSearch one, other;
    for (const float value : values) one.add(value);
    std::reverse(values.begin(), values.end());
    for (const float value : values) other.add(value);
    const auto a = one.of_lengths(1), b = other.of_lengths(1);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->step, b->step);
    EXPECT_EQ(a->first, b->first);
}

TEST(FloatLattice, FindsStepsWithoutUnit) {
    SplitMix64 random(12);
    LatticeSearch shares, network;
    for (int k = 0; k < many; ++k) {
        shares.add(static_cast<float>(std::floor(256 * random.unit()) / 255));
        network.add(static_cast<float>(-3 + 20 * random.unit()));
    }
    const auto found = shares.of_numbers();
    ASSERT_TRUE(found);
    EXPECT_DOUBLE_EQ(found->step, 1.0 / 255);
    EXPECT_FALSE(network.of_numbers());
}

}  // namespace
}  // namespace touchable::test
