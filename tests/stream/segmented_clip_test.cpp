// HTTP Live Streaming, received: as a clip and as a live source.
#include <gtest/gtest.h>

#include <fstream>
#include <memory>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/stream/receiving.hpp"
#include "engine/stream/sending.hpp"
#include "tests/stream/stream_of_frames.hpp"
#include "tests/stream/web_server.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

/// Segments of half a second, all of them there.
struct SegmentedStream {
    TemporaryFolder folder;
    std::vector<RawFrame> frames;

    SegmentedStream(int count, const Planes& planes, bool sounds = false) {
        const Scene scene = small_scene(64, 48, 16);
        std::optional<SoundPart> sound;
        if (sounds) sound = SoundPart{sounding_film(), 0, 2'000'000'000};
        const auto writer = HlsWriter::open({folder / "web", 500'000'000, 0}, scene, sound);
        EXPECT_EQ(message(writer), "");
        for (int n = 0; n < count; ++n) {
            frames.push_back(test_frame(scene, n, planes));
            const PictureLabel label{n, labelled_from_ns + n * labelled_step_ns};
            EXPECT_EQ(message((*writer)->add(frames.back(), label, scene.rate.time_ns(n))), "");
        }
        EXPECT_EQ(message((*writer)->finish()), "");
        EXPECT_TRUE(!sounds || (*writer)->notes().empty());
    }
    /// Two seconds of a tone, as AAC.
    std::filesystem::path sounding_film() const {
        const std::vector<std::uint8_t> grey(16 * 16 * 3, 128);
        const auto film = FilmWriter::create(folder / "film.mp4", Existing::keep);
        EXPECT_EQ(message(film), "");
        EXPECT_EQ(message((*film)->add({grey.data(), 16 * 3, 16, 16, 1, 3}, 0)), "");
        EXPECT_EQ(message((*film)->add_sound(0, tone(440, 2))), "");
        EXPECT_EQ(message((*film)->finish(60)), "");
        return folder / "film.mp4";
    }
    WebServer::Answer answer() const {
        return [this](const std::string& path) { return reply_with_file(folder / "web", path); };
    }
};

TEST(SegmentedClip, IsWhatWasSentToTheBit) {
    struct Sent {
        Planes planes;
        bool sounds;
    };
    for (const auto& [planes, sounds] : {Sent{all_planes, false}, Sent{all_planes, true}, Sent{{}, false}}) {
        const SegmentedStream sent(40, planes, sounds);
        const WebServer server(sent.answer());
        const auto clip = open_clip(server.url("/master.m3u8"));
        ASSERT_EQ(message(clip), "");
        const auto frames = read_all(**clip);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), sent.frames.size());
        for (std::size_t n = 0; n < frames->size(); ++n) {
            EXPECT_EQ((*frames)[n].number, static_cast<std::int64_t>(n));
            EXPECT_TRUE(is_as_sent((*frames)[n], sent.frames[n])) << n;
        }
    }
}

TEST(SegmentedClip, WithoutOneOfItsSegmentsIsNotWhole) {
    const SegmentedStream sent(40, {true, true, false, false});
    for (const char* const segment : {"-0.m4s", "-1.m4s", "-2.m4s"}) {
        const auto answer = sent.answer();
        const WebServer server([&](const std::string& path) {
            const bool is_missing = path.find("touch-") != std::string::npos && path.ends_with(segment);
            return is_missing ? WebReply{.status = 404} : answer(path);
        });
        const auto clip = open_clip(server.url("/master.m3u8"));
        const auto frames = clip ? read_all(**clip) : Result<std::vector<RawFrame>>(clip.error());
        ASSERT_FALSE(frames) << segment;
        EXPECT_EQ(frames.error().kind, ErrorKind::input);
        EXPECT_NE(frames.error().message.find("left out 1 of its segments"), std::string::npos)
            << frames.error().message;
    }
}

/// Which one it was is said.
TEST(SegmentedClip, IsOpenedWithinATimeForAllOfIt) {
    const SegmentedStream sent(40, {true, true, false, false});
    for (const std::string silent : {"/master.m3u8", "/touch.m3u8", "-0.m4s"}) {
        const auto answer = sent.answer();
        const WebServer server([&](const std::string& path) {
            const bool is_colour = path.find("colour") != std::string::npos;
            return path.ends_with(silent) && !is_colour ? WebReply{.is_silent = true} : answer(path);
        });
        StreamSource source{.url = *read_stream_url(server.url("/master.m3u8"))};
        source.patience.opening = std::chrono::seconds(2);
        source.patience.frameset = std::chrono::hours(1);
        const auto clip = open_stream_clip(source);
        ASSERT_FALSE(clip) << silent;
        EXPECT_EQ(clip.error().kind, ErrorKind::input);
        EXPECT_TRUE(message(clip).starts_with(server.url("/"))) << message(clip);
        EXPECT_TRUE(message(clip).ends_with(silent + ": did not come in time")) << message(clip);
    }
}

TEST(SegmentedClip, OpensWithoutColourThatDoesNotCome) {
    const SegmentedStream sent(40, {true, true, false, false});
    for (const char* silent : {"/colour.m3u8", "-0.m4s"}) {
        const auto answer = sent.answer();
        const WebServer server([&](const std::string& path) {
            const bool is_colour = path.find("colour") != std::string::npos;
            return is_colour && path.ends_with(silent) ? WebReply{.is_silent = true} : answer(path);
        });
        const auto clip = open_clip(server.url("/master.m3u8"));
        ASSERT_EQ(message(clip), "") << silent;
        const auto frame = (*clip)->next();
        ASSERT_EQ(message(frame), "") << silent;
        EXPECT_TRUE(same_plane((*frame)->depth, sent.frames[0].depth)) << silent;
        EXPECT_TRUE((*frame)->colour.empty()) << silent;
    }
}

TEST(SegmentedClip, PlaylistThatIsTooLargeIsNamed) {
    const TemporaryFolder folder;
    const std::string file = folder / "b.m3u8";
    std::ofstream(file) << "#EXTM3U\n" << std::string(2 << 20, '#');
    const auto clip = open_clip(file);
    EXPECT_TRUE(message(clip).starts_with(file + ": is larger than 1 MiB; right would be")) << message(clip);
}

TEST(SegmentedClip, IsTouchedLiveToItsEnd) {
    const SegmentedStream sent(40, {true, true, false, false});
    const WebServer server(sent.answer());
    const auto clip = open_live_stream({.url = *read_stream_url(server.url("/master.m3u8"))});
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->next()), "");
    const auto begun = std::chrono::steady_clock::now();
    ASSERT_EQ(message((*clip)->begin(begun)), "");
    std::int64_t last = 0, frames = 0;
    while (true) {
        const auto frame = (*clip)->next();
        ASSERT_EQ(message(frame), "");
        if (!*frame) break;
        EXPECT_GT((*frame)->number, last);
        last = (*frame)->number;
        ++frames;
    }
    EXPECT_GT(frames, 5);
    EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(1'200))
        << "they are as far apart as they were taken";
    EXPECT_NE((*clip)->remarks().front().find("has come to its end"), std::string::npos);
}

TEST(SegmentPace, KeepsFramesAsFarApartAsTheyWereTaken) {
    constexpr std::int64_t ms = 1'000'000, step = 33 * ms, sent = labelled_from_ns;
    SegmentPace pace(100 * ms);
    for (int n = 0; n < 60; ++n) {  // two segments at once
        const auto moments = pace.add(sent + n * step, 5'000 * ms);
        EXPECT_EQ(moments.shown_ns, 5'100 * ms + n * step);
        EXPECT_EQ(moments.taken_ns, moments.shown_ns);
    }
    const std::int64_t late = 5'100 * ms + 60 * step + 400 * ms;
    EXPECT_EQ(pace.add(sent + 60 * step, late).shown_ns, late);
    EXPECT_EQ(pace.add(sent + 61 * step, late).shown_ns, late + step);
    EXPECT_EQ(pace.add(sent + 3'600'000 * ms, late + step).shown_ns, late + step) << "the clock jumped";
    EXPECT_EQ(pace.add(sent, late + 2 * step).shown_ns, late + 2 * step) << "and back";
    EXPECT_EQ(pace.add(0, late + 3 * step).shown_ns, late + 3 * step);
    EXPECT_EQ(pace.add(INT64_MAX, late + 3 * step).shown_ns, late + 3 * step);
    EXPECT_EQ(pace.add(INT64_MIN, late + 3 * step).shown_ns, late + 3 * step);
}

}  // namespace
}  // namespace touchable::test
