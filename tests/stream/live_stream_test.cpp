// Streams as live sources. What waits here waits for what happens, and never for a time.
#include "engine/stream/receiving.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "engine/base/threads.hpp"
#include "tests/stream/loopback_sender.hpp"
#include "tests/stream/stream_of_frames.hpp"

namespace touchable::test {
namespace {

using Clock = std::chrono::steady_clock;

/// The blocks, one every few milliseconds, over and over; their numbers count up from connection to
/// connection where `stream` says so.
LoopbackSender::Say paced(std::shared_ptr<const StreamOfFrames> stream) {
    return [stream](const LoopbackSender::Listener& to, int) {
        if (!to.send(stream->header)) return;
        for (const std::string& block : stream->blocks)
            if (!to.send(block) || !to.wait(std::chrono::milliseconds(4))) return;
    };
}

std::shared_ptr<const StreamOfFrames> stream_of(int frames, const Planes& planes = all_planes,
                                                int width = 64) {
    return std::make_shared<const StreamOfFrames>(make_stream(small_scene(width, 48, 16), frames, planes));
}

StreamSource live_choice(const std::string& url) {
    StreamSource choice{.url = *read_stream_url(url)};
    choice.patience.back_off = std::chrono::milliseconds(5);
    return choice;
}

bool is_of_one_frame(const RawFrame& frame, const StreamOfFrames& stream) {
    return std::any_of(stream.frames.begin(), stream.frames.end(),
                       [&](const RawFrame& sent) { return same_touch_planes(frame, sent); });
}

bool says(const ClipReader& clip, const std::string& what) {
    const auto remarks = clip.remarks();
    return std::any_of(remarks.begin(), remarks.end(),
                       [&](const std::string& remark) { return remark.find(what) != std::string::npos; });
}

/// Longer than any test looks on.
std::shared_ptr<const StreamOfFrames> long_stream() {
    static const auto made = stream_of(1'000);
    return made;
}

TEST(LiveStream, GivesFramesAsTheyComeBeforeARunAndInIt) {
    const auto stream = long_stream();
    const LoopbackSender sender(paced(stream));
    const auto clip = open_live_stream(live_choice(sender.url()));
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE((*clip)->is_live());
    EXPECT_EQ((*clip)->scene().interpolation, FrameInterpolation::hold);
    for (std::int64_t n = 0; n < 5; ++n) {
        const auto frame = (*clip)->next();
        ASSERT_EQ(message(frame), "");
        EXPECT_EQ((*frame)->number, n);
        EXPECT_TRUE(is_of_one_frame(**frame, *stream));
    }
    ASSERT_EQ(message((*clip)->rewind()), "");
    EXPECT_EQ((**(*clip)->next()).number, 0);
    const auto zero = Clock::now();
    ASSERT_EQ(message((*clip)->begin(zero)), "");
    std::int64_t last = 0, last_ns = 0;
    for (int n = 0; n < 20; ++n) {
        const auto frame = (*clip)->next();
        ASSERT_EQ(message(frame), "");
        ASSERT_TRUE(*frame);
        EXPECT_GT((*frame)->number, last);
        EXPECT_GT((*frame)->time_ns, last_ns);
        EXPECT_LE((*frame)->time_ns, std::chrono::nanoseconds(Clock::now() - zero).count());
        EXPECT_TRUE(is_of_one_frame(**frame, *stream));
        EXPECT_FALSE((*frame)->colour.empty());
        last = (*frame)->number;
        last_ns = (*frame)->time_ns;
    }
    EXPECT_FALSE((*clip)->seek(3));
    const auto figures = (*clip)->stream_figures();
    ASSERT_TRUE(figures);
    EXPECT_GE(figures->whole, 26);
    EXPECT_EQ(figures->torn + figures->lost + figures->late, 0);
    EXPECT_EQ(figures->connections, 1);
    EXPECT_LE(figures->delay_ms, 200);
}

TEST(LiveStream, ASenderThatBeginsAgainIsConnectedToAgain) {
    const auto stream = long_stream();
    auto sender = std::make_unique<LoopbackSender>(paced(stream));
    const int port = sender->port();
    const auto clip = open_live_stream(live_choice(sender->url()));
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->next()), "");
    ASSERT_EQ(message((*clip)->begin(Clock::now())), "");
    ASSERT_EQ(message((*clip)->next()), "");
    for (int again = 1; again <= 2; ++again) {
        sender.reset();
        while (!says(**clip, "connecting again")) std::this_thread::yield();
        EXPECT_TRUE(says(**clip, "the sender ")) << "which how it ended follows";
        sender = std::make_unique<LoopbackSender>(paced(stream), port);
        while ((*clip)->stream_figures()->connections == again) std::this_thread::yield();
        std::int64_t last = -1;
        for (int n = 0; n < 3; ++n) {
            const auto frame = (*clip)->next();
            ASSERT_EQ(message(frame), "");
            ASSERT_TRUE(*frame);
            EXPECT_GT((*frame)->number, last);
            EXPECT_TRUE(is_of_one_frame(**frame, *stream));
            last = (*frame)->number;
        }
    }
    EXPECT_TRUE(says(**clip, "was connected to again, 2 times"));
}

TEST(LiveStream, AnotherSceneEndsIt) {
    const auto stream = stream_of(10), other = stream_of(100, all_planes, 80);
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int number) {
        paced(number == 0 ? stream : other)(to, number);
    });
    const auto clip = open_live_stream(live_choice(sender.url()));
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->next()), "");
    ASSERT_EQ(message((*clip)->begin(Clock::now())), "");
    while (true) {
        const auto frame = (*clip)->next();
        ASSERT_EQ(message(frame), "");
        if (!*frame) break;
        EXPECT_EQ((*frame)->depth.width, 64);
    }
    EXPECT_TRUE(says(**clip, "sends another scene or other planes than before"));
    EXPECT_FALSE(*(*clip)->next()) << "it is gone";
}

TEST(LiveStream, OneThatIsSilentIsConnectedToAgain) {
    const auto stream = long_stream();
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int number) {
        if (number > 0) return paced(stream)(to, number);
        (void)to.send(stream->header + stream->blocks[0] + stream->blocks[1]);
        while (!to.is_gone() && to.wait(std::chrono::milliseconds(5))) {
        }
    });
    StreamSource choice = live_choice(sender.url());
    choice.patience.silence = std::chrono::milliseconds(50);
    const auto clip = open_live_stream(choice);
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->begin(Clock::now())), "");
    while ((*clip)->stream_figures()->connections < 2) std::this_thread::yield();
    const auto frame = (*clip)->next();
    ASSERT_EQ(message(frame), "");
    ASSERT_TRUE(*frame);
}

TEST(LiveStream, AWaitIsInterrupted) {
    const auto stream = stream_of(1);
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int) {
        (void)to.send(stream->header + stream->blocks[0]);
        (void)to.wait(std::chrono::hours(1));
    });
    const auto clip = open_live_stream(live_choice(sender.url()));
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->begin(Clock::now())), "");
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    std::jthread teller([&] { given_up.request_stop(); });
    auto frame = (*clip)->next();
    while (frame && *frame) frame = (*clip)->next();
    ASSERT_FALSE(frame);
    EXPECT_EQ(frame.error().kind, ErrorKind::interrupted);
}

TEST(LiveStream, APipeThatEndsIsGone) {
    const auto stream = stream_of(5, {});
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    const std::string bytes = stream->bytes();
    ASSERT_LT(bytes.size(), 65'536U);
    ASSERT_EQ(::write(ends[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    const auto clip = open_live_stream(live_choice("pipe:" + std::to_string(ends[0])));
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->begin(Clock::now())), "");
    ::close(ends[1]);
    auto frame = (*clip)->next();
    while (frame && *frame) frame = (*clip)->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_TRUE(says(**clip, "its last frame stands still"));
    ::close(ends[0]);
}

TEST(LiveStream, WhatWasNeverWholeIsSaid) {
    const LoopbackSender sender(std::string("nothing of use"));
    const auto clip = open_live_stream(live_choice(sender.url()));
    ASSERT_FALSE(clip);
    EXPECT_TRUE(message(clip).starts_with(sender.url() + ": ")) << message(clip);
}

/// Framesets of a sender on this machine are shown when they come.
TEST(LiveStream, ALoopbackAddsNearlyNothing) {
    const auto stream = long_stream();
    const LoopbackSender sender(paced(stream));
    const auto clip = open_live_stream(live_choice(sender.url()));
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->begin(Clock::now())), "");
    for (int n = 0; n < 100; ++n) ASSERT_EQ(message((*clip)->next()), "");
    EXPECT_LE((*clip)->stream_figures()->delay_ms, 200);
    RecordProperty("delay_us", static_cast<int>(1000 * (*clip)->stream_figures()->delay_ms));
}

}  // namespace
}  // namespace touchable::test
