#include "player/run/touch_session.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "player/session/touch_setup.hpp"
#include "tests/player/in_process.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

/// A device that is pulled out in the middle.
class PulledOut final : public HapticPort {
public:
    bool read_goals(std::int64_t tick, const HeightField&, std::span<glm::dvec3> goals) override {
        for (glm::dvec3& goal : goals) goal = {0, 0, 0};
        is_out = is_out || tick >= 20;
        return !is_out;
    }
    bool write_forces(std::span<const glm::dvec3>) override { return !is_out; }
    std::atomic<bool> is_out{false};
};

/// A file that cannot be written from then on.
class FailsThen final : public TouchSink {
public:
    explicit FailsThen(const PulledOut& port) : port_(port) {}
    Result<void> take(const TouchTick&) override {
        while (!port_.is_out) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        has_failed = true;
        return input_error("the disk is full");
    }
    bool has_failed = false;

private:
    const PulledOut& port_;
};

TEST(LiveSession, SaysOfTwoFaultsTheOneThatEndedIt) {
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
    ASSERT_TRUE(write_generated_clip("globe", clip, {.width = 32, .height = 24, .properties = true}, 30));
    SessionOptions options;
    options.clip.file = clip;
    options.live = true;
    const auto setup = setup_from_options(options);
    ASSERT_TRUE(setup) << setup.error().message;
    TouchSetup& s = **setup;
    PulledOut port;
    FailsThen sink(port);
    TouchSink* const sinks[] = {&sink};
    LiveSession session(s.scene, *s.feed, port, *s.solver, s.settings);
    ASSERT_TRUE(session.run(sinks)) << "what was touched until then counts";
    ASSERT_TRUE(sink.has_failed);
    ASSERT_TRUE(session.facts().failure);
    EXPECT_EQ(session.facts().failure->kind, ErrorKind::device) << session.facts().failure->message;
}

}  // namespace
}  // namespace touchable::test
