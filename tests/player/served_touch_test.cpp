// A clip that one program sends and another touches, by every transport, and over a network that fails.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/stream/relay.hpp"
#include "tests/stream/served_clip.hpp"
#include "tests/stream/web_server.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

class ServedTouch : public ::testing::Test {
protected:
    ServedTouch() { make_clip("moving", clip, {"--size", "64x48", "--frames", "20", "--rate", "100"}); }
    std::unique_ptr<ServedClip> serve(std::vector<std::string> options) const {
        auto served = ServedClip::start(clip, std::move(options), folder / "served.json");
        EXPECT_TRUE(served) << served.error().message;
        return served ? std::move(*served) : nullptr;
    }
    std::string hash_of(const std::string& what) const {
        return force_hash({what, "--fingers", "2", "--seconds", "0.19"});
    }

    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
};

TEST_F(ServedTouch, FeelsAsTheFileDoesByEveryTransport) {
    const std::string expected = hash_of(clip);
    const std::string srt = "srt://127.0.0.1:" + std::to_string(unused_port());
    const std::string ts = "srt://127.0.0.1:" + std::to_string(unused_port());
    for (const std::vector<std::string>& options : {std::vector<std::string>{"tcp://127.0.0.1:0"},
                                                    {"http://127.0.0.1:0/clip.mkv"},
                                                    {srt},
                                                    {ts, "--mpegts"}}) {
        const auto served = serve(options);
        ASSERT_TRUE(served);
        EXPECT_EQ(hash_of(served->address()), expected) << options.front();
    }
}

TEST_F(ServedTouch, FeelsAsTheFileDoesInSegments) {
    const std::string web = folder / "web";
    const Outcome served = run_touchable({"serve", clip, "--hls", web});
    ASSERT_EQ(served.code, 0) << served.err;
    const WebServer server([&](const std::string& path) { return reply_with_file(web, path); });
    const std::string expected = hash_of(clip);
    EXPECT_EQ(hash_of(server.url("/master.m3u8")), expected);
    EXPECT_EQ(hash_of(web + "/master.m3u8"), expected);
}

/// What a finger that presses feels of a stream, tick by tick, as others watch.
class Watch final : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) override {
        const GuardedForce& guarded = tick.forces[0];
        const double force = glm::length(guarded.force);
        if (last_tick_ + 1 == tick.tick)
            largest_change = std::max(largest_change, glm::length(guarded.force - last_));
        last_ = guarded.force;
        last_tick_ = tick.tick;
        frame = tick.pair.prev.number;
        is_felt = force > 0.01;
        is_gone = (guarded.reasons & guard_stale) != 0 && force == 0;
        return {};
    }
    std::atomic<bool> is_felt{false}, is_gone{false};
    std::atomic<std::int64_t> frame{-1};
    double largest_change = 0;  // N, from tick to tick

private:
    glm::dvec3 last_{0.0};
    std::int64_t last_tick_ = -2;
};

/// Waits for something that others do; a minute at most.
template <class Condition>
bool comes(const Condition& condition) {
    for (int k = 0; k < 6000 && !condition(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
}

/// A finger that rests in a plane, of which frames come over a relay.
TEST_F(ServedTouch, ANetworkThatFailsLetsTheHandGoAndGivesItBack) {
    const std::string plane = folder / "plane.mkv";
    make_clip("globe", plane, {"--size", "64x48", "--frames", "1", "--rate", "30"});
    auto served = ServedClip::start(plane, {"tcp://127.0.0.1:0", "--loop"}, folder / "served.json");
    ASSERT_TRUE(served) << served.error().message;
    const std::string address = (*served)->address();
    const int port = std::stoi(address.substr(address.rfind(':') + 1));
    const auto relay = Relay::open(Relay::Kind::tcp, port);
    ASSERT_TRUE(relay) << relay.error().message;

    SessionOptions options;
    options.live = options.start_buried = true;
    options.ticks = 300'000;
    options.hand = "press:depth=2,lift=0,period=4";
    options.camera = "stream:tcp://127.0.0.1:" + std::to_string((*relay)->port());
    options.clip.take(*read_live_camera(*options.camera));
    const auto setup = setup_from_options(options);
    ASSERT_TRUE(setup) << setup.error().message;
    TouchSetup& s = **setup;
    TouchSessionSettings settings = s.settings;
    settings.ticks = s.ticks();
    const auto hand = make_port(*s.hand);
    LiveSession session(s.scene, *s.feed, *hand, *s.solver, settings);
    Watch watch;
    TouchSink* const sinks[]{&watch};
    Result<void> ran;
    std::thread thread([&] { ran = session.run(sinks); });

    const auto& reader = s.feed->reader();
    EXPECT_TRUE(comes([&] { return watch.is_felt.load(); }));
    (*relay)->stall(true);
    EXPECT_TRUE(comes([&] { return watch.is_gone.load(); }));
    (*relay)->stall(false);
    EXPECT_TRUE(comes([&] { return watch.is_felt.load(); })) << "after a network that stood still";
    (*relay)->cut();
    EXPECT_TRUE(comes([&] { return reader.stream_figures()->connections > 1; }));
    const std::int64_t frame = watch.frame;
    EXPECT_TRUE(comes([&] { return watch.frame > frame && watch.is_felt; }))
        << "after a connection that broke";
    session.stop();
    thread.join();
    EXPECT_TRUE(ran) << ran.error().message;
    EXPECT_FALSE(session.facts().failure);
    EXPECT_EQ(reader.stream_figures()->torn, 0);
    EXPECT_LE(watch.largest_change, 0.035 * settings.guard.max_force);
}

}  // namespace
}  // namespace touchable::test
