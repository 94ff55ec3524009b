// A recording that behaves like a camera. No test depends on a deadline.
#include "engine/clip/readers.hpp"

#include <chrono>
#include <thread>

#include "engine/base/threads.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr int recorded_frames = 24;
const FrameRate fast{1000, 1};

std::vector<CameraDelivery::Frame> deliveries(const CameraDelivery& settings, int count) {
    std::vector<CameraDelivery::Frame> all;
    CameraDelivery::Frame last;
    for (int k = 0; k < count; ++k) all.push_back(last = settings.after(last, *settings.rate));
    return all;
}

TEST(CameraDeliveries, AreInOrderAndLaterThanExposureByTheJitterAtMost) {
    const CameraDelivery settings{.rate = fast, .jitter_ns = 3'000'000};
    std::int64_t before = 0, late = 0;
    for (const CameraDelivery::Frame& frame : deliveries(settings, 1000)) {
        const std::int64_t after_ns = frame.at_ns - fast.time_ns(frame.number);
        EXPECT_GE(after_ns, 0);
        EXPECT_LE(after_ns, settings.jitter_ns);
        EXPECT_GE(frame.at_ns, before);
        before = frame.at_ns;
        late += after_ns;
    }
    EXPECT_NEAR(static_cast<double>(late), 1000 * 2e6, 1000 * 0.4e6) << "none overtakes, so above 1.5 ms";
}

TEST(CameraDeliveries, LeaveOutTheirShare) {
    for (const double drop : {0.0, 0.2, 0.9}) {
        const auto all = deliveries({.rate = fast, .drop = drop}, 2000);
        EXPECT_NEAR(2000.0 / static_cast<double>(all.back().number + 1), 1 - drop, 0.03);
    }
}

/// The same everywhere and every time.
TEST(CameraDeliveries, AreDrawnFromTheFramesNumberAlone) {
    std::vector<std::int64_t> numbers;
    for (const CameraDelivery::Frame& frame : deliveries({.rate = fast, .drop = 0.5}, 8))
        numbers.push_back(frame.number);
    EXPECT_EQ(numbers, (std::vector<std::int64_t>{1, 3, 4, 6, 8, 12, 16, 20}));
    const CameraDelivery settings{.rate = fast, .jitter_ns = 1'000'000, .drop = 0.5};
    const CameraDelivery::Frame alone = settings.after({numbers[4], 0}, fast);
    EXPECT_EQ(alone.number, numbers[5]);
    EXPECT_EQ(alone.at_ns, deliveries(settings, 6)[5].at_ns);
}

TEST(CameraDeliveries, StopWhileTheCameraIsStalled) {
    const CameraDelivery pause{.rate = fast, .stall_ns = 5'000'000, .resume_ns = 9'500'000};
    const auto all = deliveries(pause, 12);
    for (const int frame : {0, 4, 10, 11})
        EXPECT_EQ(all[static_cast<std::size_t>(frame)].at_ns, frame * 1'000'000);
    for (std::size_t frame = 5; frame < 10; ++frame) EXPECT_EQ(all[frame].at_ns, 9'500'000);
    const auto ever = deliveries({.rate = fast, .stall_ns = 5'000'000}, 6);
    EXPECT_EQ(ever[4].at_ns, 4'000'000);
    EXPECT_EQ(ever[5].at_ns, CameraDelivery::never);
}

class ReplayCamera : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(message(write_clip(file_, small_scene(16, 12), recorded_frames, all_planes)), "");
        auto recorded = read_clip(file_);
        ASSERT_EQ(message(recorded), "");
        recorded_ = std::move(*recorded);
    }
    std::unique_ptr<ClipReader> open(const CameraDelivery& delivery) const {
        auto recording = open_clip(file_);
        EXPECT_EQ(message(recording), "");
        return make_replay_camera(std::move(*recording), delivery);
    }
    /// The recording's frame of that number, at the camera's time.
    void expect_true(RawFrame frame, const FrameRate& rate) const {
        EXPECT_EQ(frame.time_ns, rate.time_ns(frame.number));
        const RawFrame& recorded = recorded_.at(static_cast<std::size_t>(frame.number));
        frame.time_ns = recorded.time_ns;
        EXPECT_TRUE(same_frame(frame, recorded)) << frame.number;
    }

    const TemporaryFolder folder_;
    const std::filesystem::path file_ = folder_ / "recording.mkv";
    std::vector<RawFrame> recorded_;
};

TEST_F(ReplayCamera, IsAClipUntilItsRunBegins) {
    const FrameRate slow{1, 100};
    const auto camera = open({.rate = slow, .drop = 0.5, .stall_ns = 0});
    EXPECT_TRUE(camera->is_live());
    EXPECT_EQ(camera->scene().rate.num, slow.num);
    EXPECT_EQ(camera->scene().rate.den, slow.den);
    EXPECT_EQ(camera->scene().interpolation, FrameInterpolation::hold);
    const auto frames = test::read_all(*camera);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), std::size_t{recorded_frames});
    for (const RawFrame& frame : *frames) expect_true(frame, slow);
    ASSERT_EQ(message(camera->seek(7)), "");
    EXPECT_EQ((*camera->next())->number, 7);
    EXPECT_EQ(open({})->scene().rate.num, small_scene(16, 12).rate.num) << "the recording's own";
}

TEST_F(ReplayCamera, GivesNoFrameBeforeItsTimeAndNoneTwice) {
    const CameraDelivery delivery{.rate = fast, .jitter_ns = 2'000'000, .drop = 0.2};
    const auto camera = open(delivery);
    for (int n = 0; n < 3; ++n) ASSERT_EQ((*camera->next())->number, n);
    const auto zero = steady_clock::now();
    ASSERT_EQ(message(camera->begin(zero)), "");
    CameraDelivery::Frame expected{2, 0};
    while (true) {
        const auto frame = camera->next();
        const auto now = steady_clock::now();
        ASSERT_EQ(message(frame), "");
        if (!*frame) break;
        // Whoever is slow misses some.
        do expected = delivery.after(expected, fast);
        while (expected.number < (*frame)->number);
        EXPECT_EQ(expected.number, (*frame)->number);
        EXPECT_GE(now, zero + std::chrono::nanoseconds(expected.at_ns));
        expect_true(**frame, fast);
    }
    EXPECT_GT(expected.number, 2);
    EXPECT_EQ(camera->seek(0).error().kind, ErrorKind::usage);
}

TEST_F(ReplayCamera, GivesTheNewestToWhoeverComesLate) {
    const auto camera = open({.rate = fast});
    ASSERT_EQ((*camera->next())->number, 0);
    ASSERT_EQ(message(camera->begin(steady_clock::now() - std::chrono::hours(1))), "");
    const auto frame = camera->next();
    ASSERT_EQ(message(frame), "");
    expect_true(**frame, fast);
    EXPECT_EQ((*frame)->number, recorded_frames - 1);
    EXPECT_FALSE((*camera->next()).has_value());
}

TEST_F(ReplayCamera, ThatIsStalledEndsWhenItIsTold) {
    for (const auto& delivery : {CameraDelivery{.stall_ns = 0}, CameraDelivery{.rate = FrameRate{1, 1000}}}) {
        const auto camera = open(delivery);
        ASSERT_EQ((*camera->next())->number, 0);
        ASSERT_EQ(message(camera->begin(steady_clock::now())), "");
        steady_clock::time_point told;
        std::stop_source given_up;
        const StopScope until(given_up.get_token());
        std::thread teller([&] {
            std::this_thread::sleep_for(milliseconds(5));
            told = steady_clock::now();
            given_up.request_stop();
        });
        const auto frame = camera->next();
        const auto ended = steady_clock::now();
        teller.join();
        ASSERT_FALSE(frame);
        EXPECT_EQ(frame.error().kind, ErrorKind::interrupted);
        EXPECT_EQ(frame.error().message, "the camera was told to stop before it gave frame 1");
        EXPECT_LT(ended - told, std::chrono::seconds(60))
            << "20 ms where nothing else runs; the frame comes in 1000 s";
        EXPECT_EQ(camera->next().error().kind, ErrorKind::interrupted);
    }
}

}  // namespace
}  // namespace touchable::test
