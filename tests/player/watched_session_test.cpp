// SPDX-License-Identifier: Apache-2.0
// A watched session whose clip's clock gets commands while it runs.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <glm/geometric.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <set>
#include <string>
#include <thread>

#include "engine/base/threads.hpp"
#include "player/run/run_files.hpp"
#include "player/run/terminal.hpp"
#include "player/session/watched_session.hpp"
#include "tests/must.hpp"
#include "tests/player/in_process.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

using Verb = PlaybackVerb;

constexpr int watched_frames = 45;  // 1.5 s
constexpr std::int64_t ms = 1'000'000;

void sleep_ms(int duration) {
    std::this_thread::sleep_for(std::chrono::milliseconds(duration));
}

/// True once it came to be, within twenty seconds: far longer than any machine takes.
bool comes_true(const std::function<bool()>& what, int at_most_ms = 20'000) {
    for (int k = 0; k < at_most_ms && !what(); ++k) sleep_ms(1);
    return what();
}

/// The haptic device: one handle, which stays where the test puts it.
class Handle final : public HapticDevice {
public:
    std::string name() const override { return "handle"; }
    DeviceLimits limits() const override { return {3, 2000}; }
    int fingers() const override { return 1; }
    Result<void> open() override {
        open_ = true;
        return {};
    }
    void close() override { open_ = false; }
    bool read_positions(std::span<glm::dvec3> device_metres) override {
        device_metres[0] = {0, 0, height.load()};
        return !unplugged;
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override {
        newtons_ = newtons[0].z;
        return !unplugged;
    }
    Result<void> health() const override {
        return unplugged ? Result<void>(Error{ErrorKind::device, "the handle was pulled out"})
                         : Result<void>();
    }
    bool is_open() const { return open_; }
    double newtons() const { return newtons_; }
    std::atomic<double> height{0};  ///< m
    std::atomic<bool> unplugged{false};

private:
    std::atomic<bool> open_{false};
    std::atomic<double> newtons_{0};
};

/// The largest force, and the largest rise from tick to tick.
class Steps final : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) override {
        while (keeps_waiting) {
            is_waiting = true;
            sleep_ms(1);
        }
        const double force = glm::length(tick.forces[0].force);
        if (is_judged) rise = std::max(rise, force - before_);
        most = std::max(most.load(), force);
        before_ = force;
        return {};
    }
    std::atomic<bool> keeps_waiting{false}, is_waiting{false};  ///< as a disk that does not answer
    std::atomic<bool> is_judged{false};
    double rise = 0;              ///< N; from a tick to the next, since it is judged
    std::atomic<double> most{0};  ///< N

private:
    double before_ = 0;
};

class SessionPlayback : public testing::Test {
protected:
    SessionPlayback() {
        const SceneOptions globe{.width = 32, .height = 24, .properties = true};
        EXPECT_TRUE(write_generated_clip("globe", clip, globe, watched_frames));
    }
    SessionOptions options() const {
        SessionOptions options;
        options.clip.file = clip;
        options.held_device = handle;
        options.live = options.watched = options.recorded = true;
        return options;
    }
    void start(const SessionOptions& options) {
        handle->height = 1;  // m: far from any surface
        auto setup = must(setup_from_options(options));
        auto record =
            must(RecordingFile::create(folder / "run.rec", setup->options.fingers, Existing::replace));
        record_ = std::move(record);
        auto started =
            must(WatchedSession::start(std::move(setup), {record_.get(), &figures_.emplace(), &steps}));
        session = std::move(started);
        // Felt contacts come by the session's own thread, a little later than the held frames.
        ASSERT_TRUE(comes_true([this] {
            const WatchedMoment* const seen = session->look();
            return seen && !seen->felt.fingers.empty();
        }));
    }
    /// Presses until `steps` know of a force. Where the loop stood still as the handle came in, there is none
    /// until the handle has been out: it is lifted and pressed in again.
    void press() {
        const auto is_felt = [this] { return handle->newtons() > 0; };
        for (int go = 0; go < 10; ++go) {
            // The middle of the picture, and 4 mm further.
            const FramePair& pair = session->look()->held.pair;
            const double depth = pair.prev.frame->vertices->at(16, 12).depth;
            handle->height = session->setup().workspace.to_device({0, 0, -depth}).z - 0.004;
            if (comes_true(is_felt, 2000)) {
                ASSERT_TRUE(comes_true([this] { return steps.most > 0; }));
                return;
            }
            handle->height = 1;
            sleep_ms(200);
        }
        FAIL() << "a surface is there";
    }
    void ask(Verb verb, std::int64_t first = 0, std::int64_t second = 0) {
        const auto asked = session->ask(verb, first, second);
        EXPECT_TRUE(asked) << asked.error().message;
    }
    /// The hand's frames are those of where the clock is.
    bool has_arrived() {
        const WatchedMoment* seen = session->look();
        const MediaMoment now = session->playback().moment;
        const FrameRate& rate = session->setup().scene.rate;
        return seen->held.pair.epoch == now.epoch &&
               seen->held.pair.prev.number == rate.frame_at(now.time_ns);
    }
    void expect_replay() {
        session->stop();
        EXPECT_FALSE(session->failure()) << session->failure()->message;
        EXPECT_FALSE(handle->is_open());
        const auto facts = recorded_facts(session->setup(), figures_->force_hash());
        ASSERT_TRUE(record_->finish(facts, session->setup().options.playback));
        const auto replayed = replay_in_process(folder / "run.rec");
        EXPECT_TRUE(replayed) << replayed.error().message;
    }

    TemporaryFolder folder;
    std::string clip = folder / "clip.mkv";
    std::shared_ptr<Handle> handle = std::make_shared<Handle>();
    Steps steps;

private:
    std::unique_ptr<RecordingFile> record_;
    std::optional<TouchFigures> figures_;

protected:
    std::unique_ptr<WatchedSession> session;  // goes first
};

std::vector<std::uint8_t> bytes_of(const PlaneView& plane) {
    std::vector<std::uint8_t> bytes;
    for (int y = 0; y < plane.height; ++y)
        bytes.insert(bytes.end(), plane.row(y),
                     plane.row(y) + plane.width * plane.channels * plane.bytes_per_sample);
    return bytes;
}

/// A random command, mostly in the wrong moment.
void ask_anything(WatchedSession& session, Random& random) {
    const auto verb = static_cast<Verb>(random.below(7));
    std::int64_t first = 0, second = 0;
    if (verb == Verb::rate) first = 200 + random.below(7000);
    if (verb == Verb::seek || verb == Verb::loop) first = random.below(1499) * ms;
    if (verb == Verb::loop) second = first + shortest_loop_ns + random.below(200) * ms;
    const auto asked = session.ask(verb, first, second);
    EXPECT_TRUE(asked) << asked.error().message;
}

/// A camera at (1, 2, 3) m of a robot's frame that looks along its x axis; up is z.
TEST_F(SessionPlayback, WorldFromCameraPlacesRobotsHand) {
    SessionOptions wanted = options();
    wanted.control = std::make_shared<HandControl>(1, HandMapping{});
    wanted.world_from_camera = glm::dmat4(0, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 1, 2, 3, 1);
    const auto setup = must(setup_from_options(wanted));
    const HandMapping& mapping = wanted.control->mapping();
    EXPECT_EQ(mapping.workspace.metres_per_scene_unit, setup->scene.metres_per_unit);
    // 2 m before the camera, 0.1 m to the right, 0.2 m down.
    const glm::dvec3 seen = mapping.turn * glm::dvec3(3, 1.9, 2.8) + mapping.offset;
    EXPECT_LT(glm::distance(seen, {0.1, -0.2, -2}), 1e-12);
    EXPECT_EQ(mapping.workspace.to_scene(seen), seen / setup->scene.metres_per_unit);
}

TEST_F(SessionPlayback, ReplaysRandomCommands) {
    std::vector<std::vector<std::uint8_t>> colours, depths;
    auto reader = open_clip(clip).value();
    for (auto raw = reader->next(); raw && *raw; raw = reader->next()) {
        colours.push_back(bytes_of((*raw)->colour));
        depths.push_back(bytes_of((*raw)->depth));
    }
    ASSERT_EQ(colours.size(), std::size_t{watched_frames});
    Random random(15);
    for (const bool temporal : {false, true}) {
        SessionOptions wanted = options();
        if (temporal)
            wanted.clip.single_filters = {.settings = {.temporal = true, .temporal_noise = {5, 0}},
                                          .stated = {.temporal = true}};
        start(wanted);
        press();
        for (int k = 0; k < 150; ++k) {
            if (random.below(3) == 0) ask_anything(*session, random);
            sleep_ms(random.below(7));
            const WatchedMoment& seen = *session->look();
            const FramePair& pair = seen.held.pair;
            ASSERT_TRUE(pair.prev.frame->vertices && pair.next.frame->vertices);
            ASSERT_FALSE(seen.colour().empty());
            const auto number = static_cast<std::size_t>((pair.blend < 0.5 ? pair.prev : pair.next).number);
            ASSERT_EQ(bytes_of(seen.colour()), colours[number]);
            ASSERT_EQ(bytes_of(seen.stored->depth), depths[number]);
            ASSERT_EQ(seen.felt.fingers.size(), 1U);
        }
        EXPECT_GT(session->setup().feed->figures().frames, 10);
        ASSERT_NO_FATAL_FAILURE(expect_replay());
        EXPECT_GT(session->setup().options.playback.size(), 20U);
        EXPECT_EQ(session->figures().ticks.ticks, session->facts().loop.ticks);
    }
}

TEST_F(SessionPlayback, StopUnpowersHandFirst) {
    start(options());
    press();
    steps.keeps_waiting = true;
    ASSERT_TRUE(comes_true([this] { return steps.is_waiting.load(); }));
    EXPECT_NO_FATAL_FAILURE(press()) << "the hand does not wait";
    std::thread stops([this] { session->stop(); });
    EXPECT_TRUE(comes_true([this] { return handle->newtons() == 0; })) << "while the disk keeps it waiting";
    steps.keeps_waiting = false;
    stops.join();
    EXPECT_FALSE(session->failure()) << session->failure()->message;
}

/// As `top -H` and a debugger show them.
std::set<std::string> thread_names() {
    std::set<std::string> names;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        std::string name;
        std::getline(std::ifstream(task.path() / "comm"), name);
        names.insert(name);
    }
    return names;
}

TEST_F(SessionPlayback, ThreadsHaveNames) {
    start(options());
    const std::set<std::string> names = thread_names();
    for (const char* name : {"session", "haptic-loop", "feed-decoder", "feed-builder"})
        EXPECT_TRUE(names.contains(name)) << name;
}

TEST_F(SessionPlayback, SeekWhilePausedFadesIn) {
    start(options());
    press();
    steps.is_judged = true;
    ask(Verb::pause);
    ASSERT_TRUE(comes_true([this] { return !session->playback().playing; }));
    for (const std::int64_t to : {1400, 30, 700, 1499}) {
        const std::uint64_t epoch = session->playback().moment.epoch;
        ask(Verb::seek, to * ms);
        ASSERT_TRUE(comes_true([&] { return session->playback().moment.epoch > epoch && has_arrived(); }))
            << to;
        EXPECT_EQ(session->playback().at_end, to == 1499);
        sleep_ms(30);
    }
    ASSERT_NO_FATAL_FAILURE(expect_replay());
    EXPECT_GT(steps.most, 0);
    // A fade of twice the largest force there was, and half of it again where two meet.
    EXPECT_LE(steps.rise, 2 * 1.5 * steps.most / JumpCancellation::fade_ticks);
    EXPECT_LE(steps.most, 3) << "the device's";
}

TEST_F(SessionPlayback, LoopsAfterClipEnd) {
    start(options());
    ask(Verb::rate, 8000);
    ASSERT_TRUE(comes_true([this] { return session->playback().at_end && has_arrived(); }) ||
                session->look()->held.pair.prev.number == watched_frames - 1);
    EXPECT_EQ(session->look()->held.pair.prev.number, watched_frames - 1);
    ask(Verb::rate, 1000);
    ask(Verb::loop, 0, 100 * ms);
    ASSERT_TRUE(comes_true([this] { return session->playback().moment.epoch > 2 && has_arrived(); }));
    EXPECT_FALSE(session->playback().at_end);
    EXPECT_TRUE(session->playback().loops);
    ask(Verb::unloop);
    ASSERT_TRUE(comes_true([this] { return session->look()->held.pair.prev.number > 5; }))
        << "beyond the loop";
    ASSERT_NO_FATAL_FAILURE(expect_replay());
}

/// Nothing is left to publish before the hand has come to the loop's way back.
TEST_F(SessionPlayback, BeginsOnLastLoopFrame) {
    SessionOptions last = options();
    const std::int64_t end_ns = FrameRate{30, 1}.time_ns(watched_frames);
    last.playback = {{0, Verb::seek, end_ns - 2 * ms, 0}, {0, Verb::loop, 0, end_ns}};
    ASSERT_NO_FATAL_FAILURE(start(last));
    EXPECT_TRUE(comes_true([this] { return session->playback().moment.epoch > 1 && has_arrived(); }));
}

TEST_F(SessionPlayback, RejectsInvalidCommands) {
    SessionOptions planned = options();
    planned.playback = {{5, Verb::pause, 0, 0}};
    const auto refused = WatchedSession::start(setup_from_options(planned).value(), {});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("0.005 pause"), std::string::npos) << refused.error().message;
    start(options());
    for (const auto& [verb, first, second, fragment] :
         std::initializer_list<std::tuple<Verb, std::int64_t, std::int64_t, const char*>>{
             {Verb::rate, 0, 0, "0.001 to 8"},
             {Verb::seek, 1500 * ms, 0, "the clip ends at 1.5"},
             {Verb::loop, 0, 50 * ms, "0.1 s or longer"}}) {
        const auto asked = session->ask(verb, first, second);
        ASSERT_FALSE(asked) << fragment;
        EXPECT_EQ(asked.error().kind, ErrorKind::usage);
        EXPECT_NE(asked.error().message.find(fragment), std::string::npos) << asked.error().message;
    }
    session->stop();
    EXPECT_FALSE(session->ask(Verb::play)) << "the session has ended";
}

TEST_F(SessionPlayback, UnplugEndsSessionWithReason) {
    start(options());
    handle->unplugged = true;
    ASSERT_TRUE(comes_true([this] { return !session->running(); }));
    session->stop();
    ASSERT_TRUE(session->failure());
    EXPECT_EQ(session->failure()->kind, ErrorKind::device);
    EXPECT_EQ(session->failure()->message, "the handle was pulled out");
}

TEST(PlaybackLog, KeepsCommandsUpToCapacity) {
    PlaybackLog log({{0, Verb::rate, 500, 0}}, 2);
    EXPECT_TRUE(log.is_open());
    ASSERT_TRUE(log.ask(Verb::pause, 0, 0));
    EXPECT_EQ(log.size(), 1U) << "not taken yet";
    log.take(7);
    ASSERT_TRUE(log.ask(Verb::seek, 5 * ms, 0));
    log.take(9);
    log.take(10);
    const auto full = log.ask(Verb::play, 0, 0);
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().kind, ErrorKind::usage);
    const std::vector<PlaybackCommand> wanted{
        {0, Verb::rate, 500, 0}, {7, Verb::pause, 0, 0}, {9, Verb::seek, 5 * ms, 0}};
    EXPECT_EQ(log.commands(), wanted);
    EXPECT_FALSE(PlaybackLog(wanted).is_open());
}

using namespace std::chrono_literals;

/// Standard output into a pipe, as long as it lives.
class PipedOutput {
public:
    PipedOutput() : before_(dup(STDOUT_FILENO)) {
        std::cout.flush();
        if (pipe(ends_.data()) != 0 || dup2(ends_[1], STDOUT_FILENO) < 0) std::abort();
    }
    ~PipedOutput() {
        dup2(before_, STDOUT_FILENO);
        for (const int end : {before_, ends_[0], ends_[1]}) close(end);
    }
    PipedOutput(const PipedOutput&) = delete;
    PipedOutput& operator=(const PipedOutput&) = delete;

    std::size_t read(std::size_t bytes) {
        std::string to(bytes, '\0');
        const ssize_t count = ::read(ends_[0], to.data(), to.size());
        return count > 0 ? static_cast<std::size_t>(count) : 0;
    }
    int waiting() const {
        int bytes = 0;
        ioctl(ends_[0], FIONREAD, &bytes);
        return bytes;
    }

private:
    std::array<int, 2> ends_{};
    int before_;
};

constexpr std::size_t much = 300'000;

TEST(StandardOutput, SlowReaderCannotBlockRun) {
    PipedOutput pipe;
    StandardOutput output(Pace::wall_clock, 300ms);
    ASSERT_TRUE(output.write(std::string(much, 'x')));
    std::atomic<bool> over{false};
    std::thread reader([&] {
        while (!over) {  // a quarter of what is the least
            (void)pipe.read(4096);
            std::this_thread::sleep_for(75ms);
        }
        while (pipe.waiting() > 0) (void)pipe.read(much);
    });
    const auto done = output.finish();
    over = true;
    reader.join();
    ASSERT_FALSE(done) << "it went on as long as anything was read";
    EXPECT_EQ(done.error().kind, ErrorKind::input);
    EXPECT_TRUE(output.reader_lags());
}

TEST(StandardOutput, ReaderGetsWholeOutput) {
    PipedOutput pipe;
    StandardOutput output(Pace::wall_clock, 1h);
    ASSERT_TRUE(output.write(std::string(much, 'x')));
    std::size_t heard = 0;
    std::thread reader([&] {
        while (heard < much) heard += pipe.read(10'000);
    });
    const auto done = output.finish();
    reader.join();
    EXPECT_TRUE(done);
    EXPECT_EQ(heard, much);
}

/// Asks to stop while a live run waits at its end.
[[noreturn]] void stop_at_the_end() {
    alarm(60);
    PipedOutput pipe;
    StandardOutput output(Pace::wall_clock, 1h);
    if (!output.write(std::string(much, 'x'))) std::_Exit(2);
    const int full = pipe.waiting();
    std::thread person([&] {
        (void)pipe.read(static_cast<std::size_t>(full));
        while (pipe.waiting() < full) std::this_thread::sleep_for(1ms);  // it is giving the rest
        request_stop();
    });
    const auto done = output.finish();
    person.join();
    std::_Exit(!done && done.error().kind == ErrorKind::interrupted ? 0 : 1);
}

TEST(StandardOutput, WaitingForReaderIsInterruptible) {
    EXPECT_EXIT(stop_at_the_end(), ::testing::ExitedWithCode(0), "");
}

TEST(StandardOutput, InterruptedRunDeliversOutput) {
    EXPECT_EXIT(
        {
            alarm(60);
            PipedOutput pipe;
            StandardOutput output(Pace::wall_clock, 1h);
            if (!output.write(std::string(much, 'x'))) std::_Exit(2);
            request_stop();
            std::size_t heard = 0;
            std::thread reader([&] {
                while (heard < much) heard += pipe.read(10'000);
            });
            const bool is_whole = bool(output.finish());
            reader.join();
            std::_Exit(is_whole && heard == much ? 0 : 1);
        },
        ::testing::ExitedWithCode(0), "");
}

TEST(LiveLine, WritesSilenceOnceWithoutTerminal) {
    ::testing::internal::CaptureStderr();
    {
        LiveLine line(nullptr, {}, [](std::int64_t silent_ns) {
            return std::string(silent_ns > 250 * ms ? "no frame" : "");
        });
        TouchTick tick;
        for (const int at_ms : {100, 200, 300, 400, 500}) {
            tick.tick = at_ms;
            tick.time_ns = at_ms * ms;
            tick.pair.next.time_ns = at_ms == 500 ? 490 * ms : 0;
            EXPECT_TRUE(line.consume(tick));
            line.show({.is_camera = true});
        }
    }
    EXPECT_EQ(::testing::internal::GetCapturedStderr(),
              "touchable: no frame\ntouchable: frames come again\n");
}

}  // namespace
}  // namespace touchable::test
