// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "engine/clip/readers.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr PlaneRole depth = PlaneRole::depth, colour = PlaneRole::colour, haptic = PlaneRole::haptic,
                    height = PlaneRole::height;
const std::vector<PlaneRole> all_of_them(all_roles.begin(), all_roles.end());

/// A picture that says which frame it is of.
StreamPicture picture(PlaneRole role, std::int64_t number, std::int64_t taken_ns = 0,
                      std::int64_t frames = 1) {
    Image image{
        1, 1, 2, 1, {static_cast<std::uint8_t>(number % 256), static_cast<std::uint8_t>(number / 256)}};
    return {role, number, frames, taken_ns, plane_from(std::move(image))};
}
void add_pictures(FramesetAssembler& assembler, std::int64_t number, std::initializer_list<PlaneRole> roles,
                  std::int64_t taken_ns = 0) {
    for (const PlaneRole role : roles) assembler.add(picture(role, number, taken_ns));
}
std::int64_t number_in(const Plane& plane) {
    return plane.view.empty() ? -1 : plane.view.sample(0, 0, 0);
}
const Plane& plane_in(const WholeFrameset& frameset, PlaneRole role) {
    return frameset.planes[static_cast<std::size_t>(role)];
}

std::vector<WholeFrameset> take_all(FramesetAssembler& assembler) {
    std::vector<WholeFrameset> all;
    while (auto frameset = assembler.take()) all.push_back(std::move(*frameset));
    return all;
}
std::vector<std::int64_t> numbers_of(const std::vector<WholeFrameset>& framesets) {
    std::vector<std::int64_t> numbers;
    for (const WholeFrameset& frameset : framesets) numbers.push_back(frameset.number);
    return numbers;
}
using Numbers64 = std::vector<std::int64_t>;

TEST(FramesetAssembler, GivesWholeFramesetsInOrder) {
    FramesetAssembler assembler({depth, haptic, height});
    add_pictures(assembler, 4, {depth, haptic});
    EXPECT_FALSE(assembler.take());
    assembler.add(picture(height, 4));
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({4}));
    add_pictures(assembler, 5, {height, depth, haptic});
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({5}));
    EXPECT_EQ(assembler.counts().whole, 2);
    EXPECT_EQ(assembler.counts().lost, 0);
    EXPECT_FALSE(assembler.has_part());
}

/// Every second frame from 4 to 12, all of them before and after.
TEST(FramesetAssembler, DoesNotMissUnsentFrames) {
    const auto counts_without = [](const std::set<std::int64_t>& lost) {
        FramesetAssembler assembler({depth});
        for (std::int64_t number = 0; number < 20; ++number) {
            const bool is_low = number >= 4 && number < 13;
            if ((is_low && number % 2 == 1) || lost.contains(number)) continue;
            StreamPicture sent = picture(depth, number);
            sent.step = is_low ? 2 : 1;
            assembler.add(std::move(sent));
        }
        return assembler.counts();
    };
    EXPECT_EQ(counts_without({}).whole, 20 - 4);  // 5, 7, 9, 11 were not sent
    EXPECT_EQ(counts_without({}).lost, 0);
    EXPECT_EQ(counts_without({8}).lost, 1);
    EXPECT_EQ(counts_without({6, 8}).lost, 2);
    EXPECT_EQ(counts_without({2, 8, 15}).lost, 3);
}

TEST(FramesetAssembler, CountsFaults) {
    FramesetAssembler assembler({depth, haptic});
    add_pictures(assembler, 0, {depth, haptic});
    assembler.add(picture(depth, 1));  // its haptic never comes
    assembler.add(picture(haptic, 2));
    assembler.add_torn(1);  // of 2
    add_pictures(assembler, 3, {depth, haptic, haptic});
    add_pictures(assembler, 7, {depth, haptic});  // of 4 to 6 nothing comes
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({0, 3, 7}));
    FramesetCounts counts = assembler.counts();
    EXPECT_EQ(counts.lost, 4);
    EXPECT_EQ(counts.torn, 1);
    EXPECT_EQ(counts.repeated, 1);
    EXPECT_EQ(counts.late, 0);
    assembler.add(picture(haptic, 1));  // now it comes
    counts = assembler.counts();
    EXPECT_EQ(counts.late, 1);
    EXPECT_EQ(counts.torn, 0) << "as which it was counted";
    EXPECT_EQ(counts.lost, 4);
    assembler.add(picture(depth, 2));
    counts = assembler.counts();
    EXPECT_EQ(counts.late, 2);
    EXPECT_EQ(counts.lost, 3);
    EXPECT_FALSE(assembler.take());
}

TEST(FramesetAssembler, WaitsForColourUntilNext) {
    FramesetAssembler assembler({depth, colour});
    assembler.add(picture(depth, 0));
    EXPECT_FALSE(assembler.take());
    assembler.add(picture(colour, 0));
    add_pictures(assembler, 1, {depth, colour});
    assembler.add(picture(depth, 2));  // its colour is lost
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({0, 1}));
    assembler.add(picture(colour, 3));
    const auto held = take_all(assembler);
    ASSERT_EQ(numbers_of(held), Numbers64({2}));
    EXPECT_EQ(number_in(plane_in(held.front(), colour)), 1);
    assembler.add(picture(depth, 3));
    const auto next = take_all(assembler);
    ASSERT_EQ(next.size(), 1U);
    EXPECT_EQ(number_in(plane_in(next.front(), colour)), 3);
    assembler.add(picture(depth, 4));
    EXPECT_FALSE(assembler.take());
    assembler.end();
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({4}));
}

TEST(FramesetAssembler, HoldsPicturesForTheirFrames) {
    FramesetAssembler assembler({depth, haptic});
    assembler.add(picture(depth, 0));
    assembler.add(picture(haptic, 0, 0, 4));
    for (std::int64_t n = 1; n < 4; ++n) assembler.add(picture(depth, n));
    const auto given = take_all(assembler);
    EXPECT_EQ(numbers_of(given), Numbers64({0, 1, 2, 3}));
    for (const WholeFrameset& frameset : given) EXPECT_EQ(number_in(plane_in(frameset, haptic)), 0);
    assembler.add(picture(depth, 4));
    EXPECT_FALSE(assembler.take());
}

TEST(FramesetAssembler, FollowsRestartedSender) {
    FramesetAssembler assembler({depth, haptic});
    const auto add_whole = [&](std::int64_t number, std::int64_t taken_ns) {
        add_pictures(assembler, number, {depth, haptic}, taken_ns);
    };
    for (std::int64_t n = 10; n < 20; ++n) add_whole(n, 1000 + n);
    assembler.add(picture(depth, 20, 1020));  // then it is killed, and begins again at 0
    for (std::int64_t n = 0; n < 30; ++n) add_whole(n, 5000 + n);
    add_whole(std::int64_t{1} << 40U, 9000);
    const auto given = take_all(assembler);
    ASSERT_EQ(given.size(), 41U);
    EXPECT_EQ(given[10].number, 0);
    EXPECT_EQ(given.back().number, std::int64_t{1} << 40U);
    EXPECT_EQ(assembler.counts().restarts, 2);
    // Of what it begins with anew, the second frame comes first.
    FramesetAssembler swapped({depth, haptic});
    add_pictures(swapped, 10, {depth, haptic}, 1010);
    for (const std::int64_t n : {1, 0}) swapped.add(picture(depth, n, 5000 + n));
    for (const std::int64_t n : {0, 1}) swapped.add(picture(haptic, n, 5000 + n));
    EXPECT_EQ(numbers_of(take_all(swapped)), Numbers64({10, 0, 1}));
}

/// With any pictures lost, torn, sent twice, mixed or out of order, each frameset is of one frame and one
/// moment, in order, and every frame that came whole and in order is given.
TEST(FramesetAssembler, NeverMixesFrames) {
    Random numbers(7);
    for (int round = 0; round < 300; ++round) {
        FramesetAssembler assembler(all_of_them);
        const bool restarts = round % 3 == 0, steps_back = round % 3 == 1;
        const int loss = numbers.below(4) * 5, twice = numbers.below(20),
                  shuffle = steps_back ? 0 : numbers.below(24);
        std::vector<StreamPicture> sent;
        for (int n = 0; n < 200; ++n) {
            const std::int64_t number = restarts && n >= 100 ? n - 95 : n;
            for (const PlaneRole role : all_roles) {
                if (numbers.below(100) < loss) continue;
                const bool is_before_step = steps_back && n < 100;
                sent.push_back(picture(role, number, (is_before_step ? 1'000'000 : 1'000) + n));
                if (numbers.below(100) < twice) sent.push_back(sent.back());
            }
        }
        if (steps_back) {  // one of before the sender's clock was put back comes late
            const std::int64_t of = 80 + numbers.below(20);
            sent.insert(sent.begin() + static_cast<std::ptrdiff_t>(sent.size() * 6 / 10),
                        picture(round % 2 == 0 ? colour : haptic, of, 1'000'000 + of));
        }
        if (shuffle > 0)
            for (std::size_t k = 0; k + 1 < sent.size(); ++k)
                std::swap(
                    sent[k],
                    sent[std::min(sent.size() - 1, k + static_cast<std::size_t>(numbers.below(shuffle)))]);
        std::int64_t last = -1, last_taken = 0, given = 0;
        const auto check = [&] {
            for (const WholeFrameset& frameset : take_all(assembler)) {
                ++given;
                for (const PlaneRole role : {depth, haptic, height})
                    ASSERT_EQ(number_in(plane_in(frameset, role)), frameset.number);
                ASSERT_LE(number_in(plane_in(frameset, colour)),
                          std::max<std::int64_t>(frameset.number, 105));
                ASSERT_TRUE(restarts || frameset.number > last);
                ASSERT_TRUE(frameset.number > last || frameset.taken_ns > last_taken);
                last = frameset.number;
                last_taken = frameset.taken_ns;
            }
        };
        for (StreamPicture& one : sent) {
            assembler.add(std::move(one));
            check();
        }
        assembler.end();
        check();
        const FramesetCounts& counts = assembler.counts();
        EXPECT_EQ(counts.whole, given);
        EXPECT_EQ(counts.restarts, restarts && shuffle == 0 ? 1 : restarts ? counts.restarts : 0) << round;
        EXPECT_TRUE(loss > 0 || shuffle > 1 || given == 200);
        EXPECT_TRUE(restarts || counts.whole + counts.late + counts.lost + counts.torn <= 200);
    }
}

/// 32 MiB by what it says; its samples are not read here.
StreamPicture large_picture(PlaneRole role, std::int64_t number) {
    static const std::uint8_t sample = 0;
    StreamPicture large{role, number, 1, 0, {}};
    large.plane.view = {&sample, 8192, 4096, 4096, 2, 1};
    large.plane.storage = std::make_shared<int>(0);
    return large;
}

TEST(FramesetAssembler, BoundsBytes) {
    FramesetAssembler assembler({depth, haptic});
    add_pictures(assembler, 0, {depth, haptic});
    std::vector<std::weak_ptr<const void>> all;
    for (std::int64_t n = 1; n < 60; ++n) {
        StreamPicture large = large_picture(depth, n);
        all.emplace_back(large.plane.storage);
        assembler.add(std::move(large));
        const auto kept = std::ranges::count_if(all, [](const auto& one) { return !one.expired(); });
        EXPECT_EQ(kept, std::min<std::int64_t>(n, 16));
        EXPECT_EQ(all.back().expired(), false);
    }
    assembler.add(picture(haptic, 2));  // whose depth is dropped
    assembler.add(picture(haptic, 59));
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({0, 59}));
    EXPECT_EQ(assembler.counts().lost, 58);
}

/// A frameset that waits for the first colour is given before it would be dropped.
TEST(FramesetAssembler, GivesLargePicturesWithoutColour) {
    FramesetAssembler assembler({depth, colour});
    for (std::int64_t n = 0; n < 40; ++n) assembler.add(large_picture(depth, n));
    EXPECT_GT(take_all(assembler).size(), 20U);
}

TEST(FramesetAssembler, BoundsPictures) {
    FramesetAssembler assembler({depth, haptic});
    for (std::int64_t n = 0; n < 10'000; ++n) assembler.add(picture(depth, n));
    assembler.add(picture(haptic, 9'999));
    EXPECT_EQ(numbers_of(take_all(assembler)), Numbers64({9'999}));
    add_pictures(assembler, 10'000'000, {depth, haptic});
    EXPECT_EQ(assembler.counts().lost, 0) << "numbers that jump so far are of another count";
}

// When what a sender sends is shown.

constexpr std::int64_t ms = 1'000'000, apart = 33'333'333, bound = 200 * ms;
constexpr std::int64_t sender_begins = 1'700'000'000 * a_second_ns;

struct Shown {
    std::vector<std::int64_t> waits, late;  // ns
};

/// 30 a second, sent by a clock that is `drift` parts in a million too fast, each `way(n)` under way.
Shown show(JitterBuffer& buffer, int frames, const std::function<std::int64_t(int)>& way,
           std::int64_t drift = 0, int from = 0) {
    Shown shown;
    std::int64_t last_arrived = 0, last_shown = 0;
    for (int n = from; n < from + frames; ++n) {
        const std::int64_t sent = n * apart;
        const std::int64_t arrived = std::max(a_second_ns + sent + way(n), last_arrived);
        const auto moments = buffer.add(sender_begins + sent + sent / 1'000'000 * drift, arrived);
        EXPECT_GE(moments.shown_ns, arrived);
        EXPECT_GE(moments.shown_ns, last_shown);
        EXPECT_LE(moments.taken_ns, arrived);
        EXPECT_LE(moments.shown_ns - arrived, bound);
        shown.waits.push_back(moments.shown_ns - arrived);
        shown.late.push_back(std::max<std::int64_t>(0, arrived - moments.taken_ns - buffer.delay_ns()));
        last_arrived = arrived;
        last_shown = moments.shown_ns;
    }
    return shown;
}

std::int64_t quantile(std::vector<std::int64_t> all, double part) {
    std::sort(all.begin(), all.end());
    return all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
}

std::function<std::int64_t(int)> jitter_of(std::int64_t most) {
    return [most](int n) {
        Random numbers(static_cast<std::uint64_t>(n) + 1);
        return 20 * ms +
               (most > 0 ? static_cast<std::int64_t>(numbers.next() % static_cast<std::uint64_t>(most)) : 0);
    };
}

TEST(JitterBuffer, AddsNothingWithoutJitter) {
    JitterBuffer buffer(bound);
    const Shown shown = show(buffer, 900, jitter_of(0));
    EXPECT_EQ(*std::max_element(shown.waits.begin(), shown.waits.end()), 0);
}

TEST(JitterBuffer, DelaysAsNearlyAllNeed) {
    for (const std::int64_t most : {5 * ms, 50 * ms}) {
        JitterBuffer buffer(bound);
        const Shown shown = show(buffer, 900, jitter_of(most));
        EXPECT_GT(buffer.delay_ns(), most * 8 / 10);
        EXPECT_LE(buffer.delay_ns(), most);
        const std::vector<std::int64_t> settled(shown.late.begin() + 300, shown.late.end());
        EXPECT_EQ(quantile(settled, 0.9), 0) << "most are there in time";
    }
}

TEST(JitterBuffer, RisesQuicklyAndFallsSlowly) {
    JitterBuffer buffer(bound);
    show(buffer, 300, jitter_of(0));
    show(
        buffer, 10, [](int n) { return n % 2 == 0 ? 20 * ms : 80 * ms; }, 0, 300);
    const std::int64_t risen = buffer.delay_ns();
    EXPECT_GT(risen, 40 * ms);
    show(buffer, 150, jitter_of(0), 0, 310);  // five seconds
    EXPECT_GT(buffer.delay_ns(), risen / 4);
    show(buffer, 1'500, jitter_of(0), 0, 460);
    EXPECT_LT(buffer.delay_ns(), 2 * ms);
}

TEST(JitterBuffer, ForgetsSingleBurst) {
    JitterBuffer buffer(bound);
    const Shown shown = show(buffer, 600, [](int n) { return n == 200 ? 150 * ms : 20 * ms; });
    const std::vector<std::int64_t> after(shown.waits.begin() + 220, shown.waits.end());
    EXPECT_LT(*std::max_element(after.begin(), after.end()), 5 * ms);
}

TEST(JitterBuffer, FollowsDriftingClock) {
    for (const std::int64_t drift : {200, -200}) {
        JitterBuffer buffer(bound);
        const Shown shown = show(buffer, 30 * 600, jitter_of(0), drift);  // ten minutes: 120 ms
        EXPECT_LE(*std::max_element(shown.waits.begin(), shown.waits.end()), 3 * ms);
        EXPECT_LE(*std::max_element(shown.late.begin(), shown.late.end()), 3 * ms);
    }
}

TEST(JitterBuffer, RestartsWhenClockJumps) {
    for (const std::int64_t jump : {3'600 * a_second_ns, -3'600 * a_second_ns, 100'000'000 * a_second_ns,
                                    -1'600'000'000 * a_second_ns, 500 * ms, -500 * ms}) {
        JitterBuffer buffer(bound);
        std::int64_t last = 0, worst = 0;
        for (int n = 0; n < 900; ++n) {
            const std::int64_t arrived = a_second_ns + n * apart;
            const auto moments = buffer.add(sender_begins + n * apart + (n >= 300 ? jump : 0), arrived);
            EXPECT_GE(moments.shown_ns, last);
            last = moments.shown_ns;
            worst = std::max(worst, moments.shown_ns - arrived);
        }
        EXPECT_LE(worst, bound) << jump;
    }
}

TEST(JitterBuffer, ReplacesImpossibleClocksByArrival) {
    Random numbers(3);
    JitterBuffer buffer(bound);
    std::int64_t last = 0;
    for (int n = 0; n < 10'000; ++n) {
        const std::int64_t arrived = a_second_ns + n * apart;
        const std::int64_t sent = n % 3 == 0   ? 0
                                  : n % 3 == 1 ? static_cast<std::int64_t>(numbers.next())
                                               : sender_begins;  // stands still
        const auto moments = buffer.add(sent, arrived);
        EXPECT_GE(moments.shown_ns, arrived);
        EXPECT_LE(moments.shown_ns, std::max(arrived + bound, last));
        EXPECT_LE(arrived - moments.taken_ns, JitterBuffer::most_way_ns);
        last = moments.shown_ns;
    }
}

/// All pictures of a clip, its packets as they are.
Came decoded(const LabelledClip& clip, LabelledDecoder& decoder) {
    Came came;
    for (const auto& packets : clip.packets)
        for (std::size_t k = 0; k < packets.size(); ++k)
            take_pictures(must(decoder.add(k, *packets[k])), clip.frames, came);
    take_pictures(must(decoder.end()), clip.frames, came);
    return came;
}

Scene scene_of_bits(int bits) {
    Scene scene = small_scene(54, 38, bits);
    scene.height_coding.code_max = bits > 8 ? 1000 : 255;
    return scene;
}

TEST(LabelledPictures, RoundTripEveryBitDepth) {
    for (const int bits : {8, 9, 10, 12, 16})
        for (const bool noisy : {true, false}) {
            const LabelledClip clip = labelled_clip(scene_of_bits(bits), 6, {true, true, true, noisy});
            LabelledDecoder decoder = decoder_for(clip);
            const Came came = decoded(clip, decoder);
            EXPECT_EQ(came.size(), 4U * 6U) << bits;
            for (const auto& [which, count] : came) EXPECT_EQ(count, 1) << bits;
            EXPECT_EQ(decoder.damaged(), 0) << bits;
        }
}

/// Depth as hue is RGB, of which every value is kept too.
TEST(LabelledPictures, RoundTripHue) {
    Scene scene = small_scene(54, 38);
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.code_max = DepthCoding::hue_circle - 1;
    derive_valid_range(scene.depth);
    RawFrame frame = test_frame(scene, 0, {false, true});
    frame.depth = frame.haptic;  // any RGB
    frame.haptic = {};
    auto encoder = must(LabelledEncoder::open(frame, scene, TrackCoding::h264_quick));
    ASSERT_EQ(encoder.tracks(), 1U);
    LabelledClip clip;
    AVStream* const stream = avformat_new_stream(clip.streams.get(), nullptr);
    ASSERT_EQ(message(encoder.describe(0, *stream->codecpar)), "");
    stream->time_base = {1, 1000};
    clip.frames.push_back(frame);
    auto packets = must(encoder.encode(frame, sent_label(0), true));
    clip.packets.push_back(std::move(packets));
    LabelledDecoder decoder = decoder_for(clip);
    EXPECT_EQ(decoded(clip, decoder).size(), 1U);
    EXPECT_EQ(decoder.damaged(), 0);
}

/// A frame whose planes are not those of the first one is no frame of the stream.
TEST(LabelledPictures, RejectOtherPlanesThanFirst) {
    const Scene scene = scene_of_bits(12);
    auto encoder = must(LabelledEncoder::open(test_frame(scene, 0, {true}), scene, TrackCoding::h264_quick));
    EXPECT_TRUE(
        is_refused(encoder.encode(test_frame(scene, 1, {}), sent_label(1), true), "", ErrorKind::input));
}

TEST(LabelledPictures, CarrySceneInDepthKeyframes) {
    const Scene scene = scene_of_bits(12);
    const LabelledClip clip = labelled_clip(scene, 5, {true, true});
    LabelledDecoder decoder = decoder_for(clip);
    int scenes = 0;
    for (const auto& packets : clip.packets)
        for (std::size_t k = 0; k < packets.size(); ++k) {
            auto pictures = must(decoder.add(k, *packets[k]));
            for (const LabelledPicture& picture : pictures) {
                EXPECT_EQ(picture.scene != nullptr, picture.role == PlaneRole::depth && picture.is_key);
                if (!picture.scene) continue;
                ++scenes;
                const auto read = must(parse_scene(*picture.scene, "sent"));
                EXPECT_EQ(read.scene.depth, scene.depth);
            }
        }
    EXPECT_EQ(scenes, 2);
}

/// Tracks come in any order, from any frame on.
TEST(LabelledPictures, AllowAnyOrderOfTracks) {
    const LabelledClip clip = labelled_clip(scene_of_bits(16), 8, {true, true, true});
    LabelledDecoder decoder(1 << 22);
    std::vector<std::size_t> track(clip.tracks());
    for (std::size_t k = clip.tracks(); k-- > 0;)
        track[k] = *decoder.add_track(*clip.streams->streams[k], "x");
    Came came;
    for (std::size_t k = clip.tracks(); k-- > 0;)
        for (std::size_t n = 2; n < 8; ++n) {
            take_pictures(must(decoder.add(track[k], *clip.packets[n][k])), clip.frames, came);
        }
    EXPECT_EQ(came.size(), 4U * 4U);  // frames 4 to 7
    EXPECT_EQ(decoder.damaged(), 0);
}

TEST(LabelledPictures, NeedBothHalves) {
    const LabelledClip clip = labelled_clip(scene_of_bits(16), 3, {});
    ASSERT_EQ(clip.tracks(), 2U);
    LabelledDecoder decoder = decoder_for(clip);
    for (const auto& packets : clip.packets) EXPECT_TRUE(decoder.add(0, *packets[0])->empty());
    EXPECT_TRUE(decoder.end()->empty());
}

TEST(LabelledPictures, RejectTooLargeOnes) {
    const LabelledClip clip = labelled_clip(scene_of_bits(8), 2, {});
    AVStream& stream = *clip.streams->streams[0];
    LabelledDecoder decoder(54 * 38 - 1);
    EXPECT_FALSE(decoder.add_track(stream, "clip")) << "its header says so";
    stream.codecpar->width = stream.codecpar->height = 0;
    const auto track = must(decoder.add_track(stream, "clip"));
    EXPECT_TRUE(decoder.add(track, *clip.packets[0][0])->empty());
}

TEST(LabelledPictures, LeaveOutUnlabelledOnes) {
    const Scene scene = scene_of_bits(8);
    const RawFrame frame = test_frame(scene, 0, {});
    auto encoder = must(TrackEncoder::open(PlaneRole::depth, TrackCoding::h264_quick, frame.depth, scene));
    LabelledClip clip;
    AVStream* const stream = avformat_new_stream(clip.streams.get(), nullptr);
    ASSERT_EQ(message(encoder->describe(*stream->codecpar)), "");
    stream->time_base = {1, 1000};
    LabelledDecoder decoder = decoder_for(clip);
    auto packet = must(encoder->encode(frame.depth, true));
    EXPECT_TRUE(decoder.add(0, *packet)->empty());
}

/// Pictures that come in spite of damage are those that were sent; after the next keyframe all come again.
TEST(LabelledPictures, DamageNeverChangesSamples) {
    const LabelledClip clip = labelled_clip(scene_of_bits(12), 12, {true, true, false, false});
    std::int64_t lost = 0;
    for (std::uint64_t seed = 0; seed < 700; seed += sweep_step()) {
        Random numbers(seed);
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
                take_pictures(must(decoder.add(k, *packet)), clip.frames, came);
            }
        for (const PlaneRole role : {PlaneRole::depth, PlaneRole::colour, PlaneRole::haptic})
            for (std::int64_t n = 8; n < 12; ++n)
                EXPECT_EQ((came[{role, n}]), 1) << seed << " " << role_name(role) << " " << n;
        lost += 3 * 12 - std::ssize(came);
    }
    EXPECT_GT(lost, 100);
}

}  // namespace
}  // namespace touchable::test

namespace touchable {
namespace {

std::span<const std::uint8_t> bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

constexpr std::array<std::uint8_t, 6> samples{1, 2, 3, 4, 5, 6};
const PlaneView plane{samples.data(), 3, 3, 2, 1, 1};
const PictureMessage message_of_depth{PlaneRole::depth, PlanePart::high, 16, {12, 1'700'000'000'000'000'000}};

TEST(PictureMessage, DescribesItsPicture) {
    const std::string sei = sei_of(message_of_depth, plane);
    // XXH64 of that text and of 1 to 6, by an implementation in Python
    EXPECT_EQ(sei.substr(16),
              "touchable=1 role=depth part=high bits=16 frame=12 taken_ns=1700000000000000000 "
              "xxh64=405067dddc054acd");
    const auto read = read_sei(bytes_of(sei));
    ASSERT_TRUE(read && read->picture);
    EXPECT_EQ(*read->picture, message_of_depth);
    EXPECT_TRUE(is_sound(*read, plane));
}

TEST(PictureMessage, DetectsAnyOtherSample) {
    const auto read = read_sei(bytes_of(sei_of(message_of_depth, plane)));
    for (std::size_t k = 0; k < samples.size(); ++k) {
        auto other = samples;
        other[k] ^= 1;
        EXPECT_FALSE(is_sound(*read, {other.data(), 3, 3, 2, 1, 1})) << k;
    }
    EXPECT_FALSE(is_sound(*read, {samples.data(), 3, 3, 1, 1, 1}));
}

TEST(PictureMessage, DetectsItsOwnDamage) {
    const std::string colour = sei_of({PlaneRole::colour, PlanePart::whole, 8, {12, 5}}, plane);
    for (const std::string& sei : {sei_of(message_of_depth, plane), colour, sei_of_scene("{\"a\": 1}")})
        for (std::size_t at = 0; at < sei.size(); ++at)
            for (int bit = 0; bit < 8; ++bit) {
                std::string damaged = sei;
                damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
                const auto read = read_sei(bytes_of(damaged));
                if (!read) continue;
                EXPECT_FALSE(read->scene) << at;
                EXPECT_FALSE(read->picture && is_sound(*read, plane)) << at << ", bit " << bit;
            }
}

TEST(PictureMessage, RejectsInvalid) {
    const std::string uuid = sei_of(message_of_depth, plane).substr(0, 16);
    const auto reads = [&](const std::string& text) { return read_sei(bytes_of(uuid + text)).has_value(); };
    EXPECT_TRUE(reads("touchable=1 role=depth part=low bits=9 frame=0 taken_ns=0 xxh64=0000000000000000"));
    for (const char* const text :
         {"", "touchable=1",
          "touchable=2 role=depth part=low bits=9 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=17 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=haptic part=low bits=9 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=whole bits=9 frame=0 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=-1 taken_ns=0 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=0 taken_ns=-1 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=0 taken_ns=0 more=1 xxh64=0000000000000000",
          "touchable=1 role=depth part=low bits=9 frame=0 taken_ns=0",
          "touchable=1 role=depth part=low bits=9 frame=99999999999999999999 taken_ns=0 "
          "xxh64=0000000000000000",
          "touchable_scene=1 xxh64=", "touchable_scene=1 xxh64=0000000000000000 {}"})
        EXPECT_FALSE(reads(text)) << text;
    EXPECT_FALSE(read_sei({}));
}

TEST(PictureMessage, RoundTripsScene) {
    const std::string json = "{\"name\": \"globe\"}";
    const auto read = read_sei(bytes_of(sei_of_scene(json)));
    ASSERT_TRUE(read && read->scene);
    EXPECT_EQ(*read->scene, json);
}

}  // namespace
}  // namespace touchable
