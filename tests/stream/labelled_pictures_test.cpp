#include <gtest/gtest.h>

#include <algorithm>

#include "engine/scene/scene.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// All pictures of a clip, its packets as they are.
Came decoded(const LabelledClip& clip, LabelledDecoder& decoder) {
    Came came;
    for (const auto& packets : clip.packets)
        for (std::size_t k = 0; k < packets.size(); ++k) {
            auto pictures = decoder.add(k, *packets[k]);
            EXPECT_EQ(message(pictures), "");
            take_pictures(*pictures, clip.frames, came);
        }
    auto rest = decoder.end();
    EXPECT_EQ(message(rest), "");
    take_pictures(*rest, clip.frames, came);
    return came;
}

Scene scene_of_bits(int bits) {
    Scene scene = small_scene(54, 38, bits);
    scene.height_coding.code_max = bits > 8 ? 1000 : 255;
    return scene;
}

TEST(LabelledPictures, EveryBitDepthComesBackExactly) {
    for (const int bits : {8, 9, 10, 12, 16})
        for (const bool noisy : {true, false}) {
            const LabelledClip clip = labelled_clip(scene_of_bits(bits), 6, {true, true, true, noisy});
            LabelledDecoder decoder = decoder_for(clip);
            const Came came = decoded(clip, decoder);
            EXPECT_EQ(came.size(), 4U * 6U) << bits;
            for (const auto& [which, count] : came) EXPECT_EQ(count, 1) << bits;
            EXPECT_EQ(decoder.faults().all(), 0) << bits;
        }
}

/// Depth as hue is RGB, of which every value is kept too.
TEST(LabelledPictures, HueComesBackExactly) {
    Scene scene = small_scene(54, 38);
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.code_max = DepthCoding::hue_circle - 1;
    derive_valid_range(scene.depth);
    RawFrame frame = test_frame(scene, 0, {false, true});
    frame.depth = frame.haptic;  // any RGB
    frame.haptic = {};
    auto encoder = LabelledEncoder::open(frame, scene, TrackCoding::h264_quick);
    ASSERT_EQ(message(encoder), "");
    ASSERT_EQ(encoder->tracks(), 1U);
    LabelledClip clip;
    AVStream* const stream = avformat_new_stream(clip.streams.get(), nullptr);
    ASSERT_EQ(message(encoder->describe(0, *stream->codecpar)), "");
    stream->time_base = {1, 1000};
    clip.frames.push_back(frame);
    auto packets = encoder->encode(frame, sent_label(0), true);
    ASSERT_EQ(message(packets), "");
    clip.packets.push_back(std::move(*packets));
    LabelledDecoder decoder = decoder_for(clip);
    EXPECT_EQ(decoded(clip, decoder).size(), 1U);
    EXPECT_EQ(decoder.faults().all(), 0);
}

/// A frame whose planes are not those of the first one is no frame of the stream.
TEST(LabelledPictures, OtherPlanesThanTheFirstAreRefused) {
    const Scene scene = scene_of_bits(12);
    auto encoder = LabelledEncoder::open(test_frame(scene, 0, {true}), scene, TrackCoding::h264_quick);
    ASSERT_EQ(message(encoder), "");
    const auto packets = encoder->encode(test_frame(scene, 1, {}), sent_label(1), true);
    ASSERT_FALSE(packets);
    EXPECT_EQ(packets.error().kind, ErrorKind::input);
}

TEST(LabelledPictures, EachKeyframeOfDepthHasTheScene) {
    const Scene scene = scene_of_bits(12);
    const LabelledClip clip = labelled_clip(scene, 5, {true, true});
    LabelledDecoder decoder = decoder_for(clip);
    int scenes = 0;
    for (const auto& packets : clip.packets)
        for (std::size_t k = 0; k < packets.size(); ++k) {
            auto pictures = decoder.add(k, *packets[k]);
            ASSERT_EQ(message(pictures), "");
            for (const LabelledPicture& picture : *pictures) {
                EXPECT_EQ(picture.scene != nullptr, picture.role == PlaneRole::depth && picture.is_key);
                if (!picture.scene) continue;
                ++scenes;
                const auto read = parse_scene(*picture.scene, "sent");
                ASSERT_EQ(message(read), "");
                EXPECT_EQ(read->scene.depth, scene.depth);
            }
        }
    EXPECT_EQ(scenes, 2);
}

/// In whatever order tracks come, and from wherever.
TEST(LabelledPictures, OrderOfTracksSaysNothing) {
    const LabelledClip clip = labelled_clip(scene_of_bits(16), 8, {true, true, true});
    LabelledDecoder decoder(1 << 22);
    std::vector<std::size_t> track(clip.tracks());
    for (std::size_t k = clip.tracks(); k-- > 0;)
        track[k] = *decoder.add_track(*clip.streams->streams[k], "x");
    Came came;
    for (std::size_t k = clip.tracks(); k-- > 0;)
        for (std::size_t n = 2; n < 8; ++n) {
            auto pictures = decoder.add(track[k], *clip.packets[n][k]);
            ASSERT_EQ(message(pictures), "");
            take_pictures(*pictures, clip.frames, came);
        }
    EXPECT_EQ(came.size(), 4U * 4U);  // frames 4 to 7
    EXPECT_EQ(decoder.faults().all(), 0);
}

TEST(LabelledPictures, AHalfAloneIsNone) {
    const LabelledClip clip = labelled_clip(scene_of_bits(16), 3, {});
    ASSERT_EQ(clip.tracks(), 2U);
    LabelledDecoder decoder = decoder_for(clip);
    for (const auto& packets : clip.packets) EXPECT_TRUE(decoder.add(0, *packets[0])->empty());
    EXPECT_TRUE(decoder.end()->empty());
    EXPECT_EQ(decoder.faults().halved, 3);
}

TEST(LabelledPictures, LargerThanAllowedIsNotDecoded) {
    const LabelledClip clip = labelled_clip(scene_of_bits(8), 2, {});
    AVStream& stream = *clip.streams->streams[0];
    LabelledDecoder decoder(54 * 38 - 1);
    EXPECT_FALSE(decoder.add_track(stream, "clip")) << "its header says so";
    stream.codecpar->width = stream.codecpar->height = 0;
    const auto track = decoder.add_track(stream, "clip");
    ASSERT_EQ(message(track), "");
    EXPECT_TRUE(decoder.add(*track, *clip.packets[0][0])->empty());
    EXPECT_EQ(decoder.faults().undecodable, 1);
}

TEST(LabelledPictures, AnotherEncodersAreUnlabelled) {
    const Scene scene = scene_of_bits(8);
    const RawFrame frame = test_frame(scene, 0, {});
    auto encoder = TrackEncoder::open(PlaneRole::depth, TrackCoding::h264_quick, frame.depth, scene);
    ASSERT_EQ(message(encoder), "");
    LabelledClip clip;
    AVStream* const stream = avformat_new_stream(clip.streams.get(), nullptr);
    ASSERT_EQ(message((*encoder)->describe(*stream->codecpar)), "");
    stream->time_base = {1, 1000};
    LabelledDecoder decoder = decoder_for(clip);
    auto packet = (*encoder)->encode(frame.depth, true);
    ASSERT_EQ(message(packet), "");
    EXPECT_TRUE(decoder.add(0, **packet)->empty());
    EXPECT_EQ(decoder.faults().unlabelled, 1);
}

/// What is given in spite of damage is what was sent, and after the next keyframe everything is there again.
TEST(LabelledPictures, DamageNeverGivesOtherSamples) {
    const LabelledClip clip = labelled_clip(scene_of_bits(12), 12, {true, true, false, false});
    std::int64_t lost = 0;
    for (std::uint64_t seed = 0; seed < 700; seed += sweep_step()) {
        Numbers numbers(seed);
        LabelledDecoder decoder = decoder_for(clip);
        Came came;
        for (std::size_t n = 0; n < clip.packets.size(); ++n)
            for (std::size_t k = 0; k < clip.tracks(); ++k) {
                PacketPtr packet(av_packet_clone(clip.packets[n][k].get()));
                const bool is_spared = n >= 8;  // from the last keyframe on
                const int fate = is_spared ? 9 : numbers.below(10);
                if (fate == 0) continue;  // lost
                if (fate <= 3) {
                    ASSERT_GE(av_packet_make_writable(packet.get()), 0);
                    for (int flips = 1 + numbers.below(4); flips > 0; --flips)
                        packet->data[numbers.below(packet->size)] ^=
                            static_cast<std::uint8_t>(1 << numbers.below(8));
                    if (fate == 3) av_shrink_packet(packet.get(), 1 + numbers.below(packet->size));
                }
                auto pictures = decoder.add(k, *packet);
                ASSERT_EQ(message(pictures), "") << seed;
                take_pictures(*pictures, clip.frames, came);
            }
        for (const PlaneRole role : {PlaneRole::depth, PlaneRole::colour, PlaneRole::haptic})
            for (std::int64_t n = 8; n < 12; ++n)
                EXPECT_EQ((came[{role, n}]), 1) << seed << " " << role_name(role) << " " << n;
        lost += decoder.faults().all();
    }
    EXPECT_GT(lost, 100);
}

}  // namespace
}  // namespace touchable::test
