// SPDX-License-Identifier: Apache-2.0
// Touch of a camera: frames that come when they are taken, or do not come. No test depends on a deadline.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "player/commands/run_options.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/opened_clip.hpp"
#include "tests/camera/fake_video.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

class LiveCamera : public TouchedCamera {
protected:
    LiveCamera() { succeed({"make", "moving", clip, "--size", "64x48", "--frames", "30"}); }

    const std::string clip = folder / "moving.mkv";
};

TEST_F(LiveCamera, SessionReplaysToSameHash) {
    const std::string camera = "replay:" + clip + ",fps=100,jitter=4,drop=0.3";
    for (const Words& filter : {Words{}, Words{"--temporal", "5"}}) {
        const auto live = touch(
            plus({"--live", "--camera", camera, "--seconds", "0.4", "--fingers", "2", "--record", record},
                 filter));
        EXPECT_EQ(live["camera"], camera);
        EXPECT_GT(live["frames_shown"], 0);
        EXPECT_GT(live["dropped_frames"], 0);
        EXPECT_LE(live["frames_shown"].get<int>() + live["dropped_frames"].get<int>(), 28);
        EXPECT_FALSE(live.contains("late_frames"));
        EXPECT_FALSE(says(live["warnings"].dump(), "frames came too late")) << live["warnings"];
        EXPECT_GT(live["exposure_to_force_ms"]["p50"], 0);
        EXPECT_LE(live["exposure_to_force_ms"]["p50"], live["exposure_to_force_ms"]["p99"]);
        EXPECT_PRED2(says, said, "exposure to force");
        const auto replay = touch({"--replay", record, "--builder", "reference"});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]);
        EXPECT_EQ(replay["camera"], camera);
        EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
    }
}

TEST_F(LiveCamera, StalledSurfaceGoesStale) {
    const std::string camera = "replay:" + clip + ",fps=100,stall=0.05";
    const Words words{"--live",        "--camera", camera,     "--seconds", "0.4",
                      "--stale-after", "20",       "--record", record};
    const auto live = touch(words);
    EXPECT_GT(live["stale_ticks"], 0);
    EXPECT_PRED2(says, said, "the surface was too old");
    const auto replay = touch({"--replay", record});
    EXPECT_EQ(replay["force_hash"], live["force_hash"]);
    EXPECT_EQ(replay["stale_ticks"], live["stale_ticks"]);
    expect_failure({"touch", clip, "--stale-after", "20"}, 2, "--camera");
}

TEST_F(LiveCamera, StallDoesNotBlockEnd) {
    const std::string camera = "replay:" + clip + ",fps=100,stall=0.05";
    const auto live = touch({"--live", "--camera", camera, "--seconds", "0.2", "--record", record,
                             "--picture", folder / "p.png", "--picture-size", "64x48", "--painter", "cpu"});
    EXPECT_GE(live["ticks"].get<int>() + live["skipped_ticks"].get<int>(), 200);
    EXPECT_LE(live["frames"], 5) << "0, 1, ... 4";
    EXPECT_EQ(touch({"--replay", record})["force_hash"], live["force_hash"]);
    expect_failure(run_interrupted_while_live({"touch", "--live", "--camera", camera, "--overwrite", "--json",
                                               report, "--record", record}),
                   130, "what was asked for is written");
}

TEST(LiveCameraWords, ParseOrNameTheFault) {
    const auto camera = read_live_camera("replay:a/b.mkv,fps=29.97,jitter=2.5,drop=0.1,stall=2,resume=3.5");
    ASSERT_EQ(message(camera), "");
    EXPECT_EQ(camera->recording, "a/b.mkv");
    const CameraDelivery& delivery = camera->delivery;
    EXPECT_EQ(delivery.rate->num, 2997);
    EXPECT_EQ(delivery.rate->den, 100);
    EXPECT_EQ(delivery.jitter_ns, 2'500'000);
    EXPECT_EQ(delivery.drop, 0.1);
    EXPECT_EQ(delivery.stall_ns, 2'000'000'000);
    EXPECT_EQ(delivery.resume_ns, 3'500'000'000);
    EXPECT_EQ(read_live_camera("replay:file:///a%20b.mkv,fps=3")->recording, "/a b.mkv");
    EXPECT_FALSE(read_live_camera("replay:a.mkv")->delivery.rate.has_value()) << "the recording's own";
    for (const auto& [words, fragment] : std::vector<std::pair<const char*, const char*>>{
             {"webcam",
              "unknown camera 'webcam'; there are v4l2:/dev/videoN, one that is plugged in (touchable "
              "cameras lists them), pipe:CMD and tcp://HOST:PORT, programs that send framesets, "
              "stream:ADDRESS, what touchable serve sends, and replay:PATH"},
             {"/dev/video0,fps=30",
              "unknown camera '/dev/video0,fps=30': did you mean v4l2:/dev/video0,fps=30?"},
             {"2", "unknown camera '2': did you mean v4l2:/dev/video2?"},
             {"replay:,fps=3", "needs a recording"},
             {"replay:a,fps=0", "fps takes 0.1 to 1000 frames/s"},
             {"replay:a,drop=1", "drop takes 0 to 0.99 of the frames"},
             {"replay:a,jitter", "'jitter' is not key=value; keys are fps"},
             {"replay:a,blur=1", "unknown key 'blur'; keys are fps"},
             {"replay:a,stall=2,resume=2", "resume must be a moment after stall"},
             {"replay:a,resume=2", "resume must be a moment after stall"},
             {"v4l2:", "needs a node, such as v4l2:/dev/video0"},
             {"v4l2:a,size=3", "size=3 is not allowed; must be WIDTHxHEIGHT"},
             {"v4l2:a,size=0x4", "size=0x4 is not allowed"},
             {"v4l2:a,size=16385x4", "size=16385x4 is not allowed"},
             {"v4l2:a,fps=0", "fps takes 0.1 to 1000 frames/s"},
             {"v4l2:a,jitter=2", "unknown key 'jitter'"},
             {"pipe:  ", "needs a command that writes framesets"},
             {"tcp://a.b:1", "must be an address in numbers"}}) {
        const auto refused = read_live_camera(words);
        ASSERT_FALSE(refused) << words;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
        EXPECT_PRED2(says, refused.error().message, fragment);
    }
}

TEST(LiveCameraWords, ConflictWithOtherOptions) {
    for (const auto& [words, fragment] : std::vector<std::pair<Words, const char*>>{
             {{"--live", "--camera", "replay:a,fps=no"}, "fps=no is not allowed"},
             {{"--live", "--camera", "replay:a", "a"}, "CLIP and --camera are two things to touch"},
             {{"--camera", "replay:a"}, "--camera needs a live run: its frames come in real time (--live)"},
             {{"--live", "--camera", "replay:a", "--rate", "2"}, "a camera's time only goes on"},
             {{"--live", "--camera", "replay:a", "--interpolation", "linear"},
              "--interpolation linear needs the frame after, which a camera has not taken yet; leave it out"},
             {{"--replay", "a", "--camera", "replay:a"}, "--camera comes from the recording"}}) {
        expect_failure(plus({"touch"}, words), 2, fragment);
    }
    EXPECT_EQ(run_touchable({"touch", "--live", "--camera", "replay:no.mkv"}).code, 3);
}

TEST_F(LiveCamera, PrefetchedFramesWaitTheirTime) {
    auto recording = must(open_clip(clip));
    auto camera = make_replay_camera(std::move(recording), {.rate = FrameRate{1000, 1}});
    std::vector<RawFrame> ahead;
    for (int n = 0; n < 20; ++n) ahead.push_back(**camera->next());
    const auto reader = with_prefetched_frames(std::move(camera), std::move(ahead));
    EXPECT_TRUE(reader->is_live());
    for (int n = 0; n < 2; ++n) EXPECT_EQ((*reader->next())->number, n);
    const auto zero = std::chrono::steady_clock::now();
    ASSERT_EQ(message(reader->begin(zero)), "");
    const auto frame = must(reader->next());
    EXPECT_GE(frame->number, 2);
    EXPECT_GE(std::chrono::steady_clock::now(), zero + std::chrono::nanoseconds(frame->time_ns));
    std::stop_source given_up;
    given_up.request_stop();
    const auto told = work_until(given_up.get_token(), [&] { return reader->next(); });
    EXPECT_EQ(told.error().kind, ErrorKind::interrupted);
}

// Touch of a camera that is plugged in, over a fake of the kernel's side. No test depends on a deadline.

constexpr int width = 64, height = 48;
const std::string node = "/dev/video3";

/// A ball that comes nearer and goes away, before a wall; millimetres.
std::vector<std::uint8_t> ball(std::uint32_t number) {
    std::vector<std::uint8_t> bytes;
    const double nearer = 100 * std::sin(0.2 * number);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double dx = x - 32, dy = y - 24, inside = 400 - dx * dx - dy * dy;
            const auto depth =
                static_cast<std::uint16_t>(900 - nearer - (inside > 0 ? 10 * std::sqrt(inside) : 0));
            bytes.push_back(static_cast<std::uint8_t>(depth & 0xff));
            bytes.push_back(static_cast<std::uint8_t>(depth >> 8));
        }
    return bytes;
}

class PluggedCamera : public ::testing::Test {
protected:
    FakeNode& plug_in(std::function<Fate(std::uint32_t)> fate) {
        FakeNode& made = add_depth_node(*video, node, width, height);
        made.formats[0].modes[0].intervals = {{1, 200}};
        made.paint = ball;
        made.period_ns = 5'000'000;
        made.fate = std::move(fate);
        return made;
    }
    static Fate good(std::uint32_t) { return Fate::good; }
    void TearDown() override {
        EXPECT_EQ(video->misuse(), std::vector<std::string>());
        EXPECT_EQ(video->left_over(), std::vector<std::string>());
    }
    TouchOptions live(double seconds) const {
        TouchOptions options;
        options.session.live = options.session.recorded = true;
        options.session.camera = "v4l2:" + node;
        auto camera = read_live_camera(*options.session.camera);
        EXPECT_EQ(message(camera), "");
        std::get<V4l2Choice>(*camera->plugged).system = video;
        options.session.clip.choose(*camera);
        options.session.hand = "press";
        options.session.fingers = 2;
        options.session.ticks = static_cast<std::int64_t>(1000 * seconds);
        options.record = record;
        return options;
    }
    TouchOptions replay() const {
        TouchOptions options;
        options.replay = record;
        options.session.builder.name = "reference";
        return options;
    }
    nlohmann::json touch(TouchOptions options) const {
        options.existing = Existing::replace;
        options.json = report;
        ::testing::internal::CaptureStdout();
        const auto ran = run_touch(options);
        said = ::testing::internal::GetCapturedStdout();
        EXPECT_EQ(message(ran), "") << said;
        return json_in(report);
    }

    const std::shared_ptr<FakeVideo> video = std::make_shared<FakeVideo>();
    const TemporaryFolder folder;
    const std::filesystem::path record = folder / "run.rec", film = folder / "run.rec.mkv",
                                report = folder / "r.json";
    mutable std::string said;
};

TEST_F(PluggedCamera, SessionReplaysWithoutCamera) {
    for (const bool temporal : {false, true}) {
        plug_in([](std::uint32_t n) {
            if (n % 7 == 3) return Fate::lost;
            return n % 11 == 5 ? Fate::damaged : Fate::good;
        });
        TouchOptions options = live(1.2);
        if (temporal)
            options.session.clip.single_filters = {
                .settings = {.temporal = true, .temporal_noise = {0.002, 0}}, .stated = {.temporal = true}};
        const auto lived = touch(options);
        EXPECT_GT(lived["frames_shown"], 5);
        EXPECT_GT(lived["dropped_frames"], 5);
        EXPECT_GT(lived["exposure_to_force_ms"]["p50"], 0);
        EXPECT_GT(lived["contact_ticks"], 0);
        EXPECT_PRED2(says, lived["notes"].dump(), "are kept as " + film.string());
        EXPECT_PRED2(says, lived["warnings"].dump(), "were damaged or cut short");
        video->unplug(node);
        const auto again = touch(replay());
        EXPECT_EQ(again["force_hash"], lived["force_hash"]);
        EXPECT_EQ(again["camera"], "v4l2:" + node);
        EXPECT_EQ(again["clip"], film.string());
        EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
    }
    // The film is a clip like any other, with every value as the camera gave it.
    const auto clip = must(open_clip(film));
    const auto frame = must(clip->next());
    const auto is_picture = [&](std::uint32_t number) {
        const auto painted = ball(number);
        for (int y = 0; y < height; ++y)
            if (std::memcmp(frame->depth.row(y), painted.data() + 2 * width * y, 2 * width) != 0)
                return false;
        return true;
    };
    std::uint32_t number = 0;
    while (number < 200 && !is_picture(number)) ++number;
    EXPECT_LT(number, 200u);
}

/// The last frame stands still, the hand goes on, and no force jumps.
TEST_F(PluggedCamera, UnplugKeepsLastFrame) {
    plug_in([](std::uint32_t n) { return n == 200 ? Fate::unplugged : Fate::good; });
    const auto lived = touch(live(2.5));
    EXPECT_GE(lived["ticks"].get<int>() + lived["skipped_ticks"].get<int>(), 2500);
    const std::string warnings = lived["warnings"].dump();
    EXPECT_PRED2(says, warnings, "the camera, " + node + ", was unplugged after ");
    EXPECT_PRED2(says, warnings, "its last frame stands still");
    EXPECT_EQ(touch(replay())["force_hash"], lived["force_hash"]);
}

/// The camera is felt to the end of the run; film and recording end with the last frame for which there was
/// room.
TEST_F(PluggedCamera, FullDiskKeepsPlayableFilm) {
    plug_in(good);
    TouchOptions options = live(1.2);
    options.json = report;
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const auto ran = [&] {
        const FullDisk full(200 * 1024);
        return run_touch(options);
    }();
    said = ::testing::internal::GetCapturedStdout();
    const std::string warned = ::testing::internal::GetCapturedStderr();
    EXPECT_EQ(ran ? ErrorKind::internal : ran.error().kind, ErrorKind::input);
    EXPECT_PRED2(says, message(ran), "; it is kept, and replays, up to ");
    EXPECT_PRED2(says, warned,
                 "touchable: warning: the film of --record: " + film.string() + ": the disk is full");
    const auto lived = json_in(report);
    EXPECT_GE(lived["ticks"].get<int>() + lived["skipped_ticks"].get<int>(), 1200) << "the run goes on";
    const auto again = touch(replay());
    EXPECT_GT(again["ticks"], 20);
    EXPECT_LT(again["ticks"], lived["ticks"]);
    EXPECT_LE(std::filesystem::file_size(film), 200 * 1024U);
}

TEST_F(PluggedCamera, RejectsForeignFilm) {
    plug_in(good);
    (void)touch(live(0.1));
    write_bytes(film, "something else");
    TouchOptions options = live(0.1);
    const auto kept = run_touch(options);
    EXPECT_PRED2(says, message(kept), "run.rec is there already");
    std::filesystem::remove(record);
    const auto film_kept = run_touch(options);
    EXPECT_PRED2(says, message(film_kept), "run.rec.mkv is there already");
    EXPECT_EQ(read_bytes(film), "something else");
    std::filesystem::remove(film);
    (void)touch(live(0.1));
    succeed({"make", "moving", film, "--size", "64x48", "--frames", "3", "--bits", "16", "--overwrite"});
    const auto another = run_touch(replay());
    EXPECT_PRED2(says, message(another), "it is not the film of that recording");
}

/// A film is given up where its recording has ended before it began: the recording keeps what it has.
TEST_F(PluggedCamera, FullRecordingKeepsItsTicks) {
    plug_in(good).paint = [](std::uint32_t) { return ball(0); };  // which takes no room in the film
    PlayOptions options;
    options.record = record;
    options.session = live(600).session;
    options.session.builder.name = "cpu";
    const auto sound = std::move(*WindowSound::create(false, {}, Existing::keep));
    {
        const FullDisk full(400 * 1024);
        auto opened = must(OpenedClip::open(options, options.session.clip, {}, *sound));
        OpenedClip& clip = *opened;
        ASSERT_EQ(message(clip.begin()), "");
        for (int k = 0; k < 20'000 && !clip.record_fault(); ++k)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ASSERT_TRUE(clip.record_fault());
        ASSERT_FALSE(clip.session().setup().film->fault()) << "the recording is to be full, not its film";
        SessionSettings settings = clip.settings();
        ASSERT_EQ(message(settings.set("median", "5")), "");
        auto change = must(clip.prepare(settings, nullptr));
        ASSERT_EQ(message(clip.take(std::move(change))), "");
        const auto done = clip.finish();
        EXPECT_PRED2(says, message(done), "; it is kept, and replays, up to ");
    }
    const auto recording = must(read_recording(record));
    EXPECT_GT(recording.front().ticks.size(), 100U);
    EXPECT_FALSE(std::filesystem::exists(film_beside(record, 2))) << "nothing was to be kept any more";
}

/// Settings are changed while the camera goes on: it is opened once, and each part has a film of its own.
TEST_F(PluggedCamera, SettingsChangeKeepsCameraOpen) {
    // The newest picture that the driver took, by its own count, which goes on through both sessions.
    const auto taken = std::make_shared<std::atomic<std::int64_t>>(0);
    plug_in(good).sequence = [taken](std::uint32_t number) {
        *taken = number;
        return number;
    };
    FakeNode& colour = video->add("/dev/video5");
    colour.formats = {{V4L2_PIX_FMT_RGB24, {{width, height}}}};
    colour.period_ns = 5'000'000;
    PlayOptions options;
    options.record = record;
    options.session = live(1).session;
    options.session.builder.name = "cpu";
    std::get<V4l2Choice>(*options.session.clip.plugged).colour = "/dev/video5";
    {
        const auto sound = std::move(*WindowSound::create(false, {}, Existing::keep));
        auto opened = must(OpenedClip::open(options, options.session.clip, {}, *sound));
        OpenedClip& clip = *opened;
        ASSERT_EQ(message(clip.begin()), "");
        const auto goes_on = [&](std::int64_t frames) {
            for (int k = 0; k < 60'000 && clip.session().figures().feed.frames < frames; ++k)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return clip.session().figures().feed.frames >= frames;
        };
        ASSERT_TRUE(goes_on(20));
        const WatchedMoment* seen = clip.session().look();
        ASSERT_NE(seen, nullptr);
        EXPECT_TRUE(seen->colour().data != nullptr);
        EXPECT_EQ(clip.session().ask(PlaybackVerb::seek, 0).error().kind, ErrorKind::usage);
        SessionSettings settings = clip.settings();
        ASSERT_EQ(message(settings.set("median", "5")), "");
        auto change = must(clip.prepare(settings, nullptr));
        EXPECT_TRUE(clip.has_come_to(change));
        const std::int64_t before = *taken;
        ASSERT_EQ(message(clip.take(std::move(change))), "");
        EXPECT_EQ(clip.in_effect().at("median"), "5");
        ASSERT_TRUE(goes_on(20));
        // However slow the machine is: of the 20 frames and more before, none counts, but for those in
        // buffers.
        const auto feed = clip.session().figures().feed;
        EXPECT_LE(feed.frames + feed.dropped, *taken - before + 10) << "numbers begin anew";
        ASSERT_EQ(message(clip.finish()), "");
        EXPECT_FALSE(clip.failure());
    }
    EXPECT_TRUE(std::filesystem::exists(film_beside(record, 2)));
    const auto again = touch(replay());
    EXPECT_PRED2(says, said, "every force is as recorded, to the bit in all 2 parts");
}

TEST(PluggedCameraWords, ParseOrNameTheFault) {
    const auto camera = read_live_camera("v4l2:/dev/video4,size=848x480,fps=60,colour=/dev/video6");
    ASSERT_EQ(message(camera), "");
    ASSERT_TRUE(camera->plugged);
    const auto& choice = std::get<V4l2Choice>(*camera->plugged);
    EXPECT_EQ(choice.node, "/dev/video4");
    EXPECT_EQ(choice.width, 848);
    EXPECT_EQ(choice.height, 480);
    EXPECT_EQ(choice.rate, 60);
    EXPECT_EQ(choice.colour, "/dev/video6");
    EXPECT_FALSE(std::get<V4l2Choice>(*read_live_camera("v4l2:/dev/video4")->plugged).rate);
    expect_failure({"touch", "--live", "--camera", "v4l2:/dev/video/none", "--fov", "60"}, 3,
                   "does not exist; touchable cameras lists");
}

// The senders of examples/senders, each over a fake of its camera's module, into the program. Python says
// what they say; no test depends on a deadline.

class SenderCamera : public TouchedCamera {
protected:
    void SetUp() override {
        if (std::system("command -v python3 >/dev/null") != 0) GTEST_SKIP() << "python3 is not installed";
    }
    static std::string sender(const std::string& name) {
        const std::string source = TOUCHABLE_SOURCE_DIR;
        return "pipe:PYTHONDONTWRITEBYTECODE=1 PYTHONPATH='" + source +
               "/tests/camera/fakes' exec python3 '" + source + "/examples/senders/" + name + ".py'";
    }
    /// The same from every sender: a ball that moves, felt, kept, and felt again without the sender.
    void is_touched(const std::string& name, const std::string& unit) const {
        const auto lived = touch({"--live", "--camera", sender(name), "--seconds", "1.2", "--hand", "press",
                                  "--fingers", "2", "--record", record});
        EXPECT_EQ(lived["camera"], sender(name));
        EXPECT_GT(lived["frames_shown"], 0) << said;
        EXPECT_GT(lived["contact_ticks"], 0) << said;
        EXPECT_GT(lived["exposure_to_force_ms"]["p50"], 0);
        const std::string notes = lived["notes"].dump();
        EXPECT_PRED2(says, notes, "sends depth of 64x48, " + unit + " m a code, fx 60, fy 60, at ");
        EXPECT_EQ(lived["warnings"].dump().find("the camera"), std::string::npos) << lived["warnings"];
        const auto again = touch({"--replay", record, "--builder", "reference"});
        EXPECT_EQ(again["force_hash"], lived["force_hash"]);
        EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
    }
};

TEST_F(SenderCamera, TouchesRealSense) {
    is_touched("realsense", "0.0001");
}
TEST_F(SenderCamera, TouchesAzureKinect) {
    is_touched("azure_kinect", "0.001");
}
TEST_F(SenderCamera, TouchesOak) {
    is_touched("oak", "0.001");
}
TEST_F(SenderCamera, TouchesRos2) {
    is_touched("ros2", "0.001");
}

/// The block of Python in docs/streaming.md.
TEST_F(SenderCamera, TouchesDocumentedSender) {
    std::ifstream in(std::string(TOUCHABLE_SOURCE_DIR) + "/docs/streaming.md");
    std::string line;
    while (std::getline(in, line) && line != "```python") {
    }
    const std::string script = folder / "sender.py";
    std::ofstream out(script);
    while (std::getline(in, line) && line != "```") out << line << "\n";
    out.close();
    const std::string started = folder / "started";
    const auto lived = touch({"--live", "--camera", "pipe:echo >>" + started + "; exec python3 " + script,
                              "--seconds", "1.2", "--hand", "press", "--record", record});
    EXPECT_GT(lived["frames_shown"], 0);
    EXPECT_GT(lived["contact_ticks"], 0);
    const std::string starts = file_contents(started);
    EXPECT_NE(starts, "");
    EXPECT_EQ(touch({"--replay", record})["force_hash"], lived["force_hash"]);
    EXPECT_EQ(file_contents(started), starts) << "what a recording says is not started";
}

TEST_F(SenderCamera, ReportsMissingModule) {
    const std::string script = std::string(TOUCHABLE_SOURCE_DIR) + "/examples/senders/realsense.py";
    expect_failure({"touch", "--live", "--camera", "pipe:PYTHONPATH= exec python3 -S '" + script + "'"}, 3,
                   "ended with status 1: ModuleNotFoundError: No module named 'pyrealsense2'");
}

TEST_F(SenderCamera, AlignsColourWithDepth) {
    for (const char* name : {"realsense", "azure_kinect"}) {
        auto camera = must(read_live_camera(sender(name)));
        const auto reader = must(open_plugged_camera(*camera.plugged));
        const auto frame = must(reader->next());
        const PlaneView& colour = frame->colour;
        ASSERT_EQ(colour.width, 64);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_EQ(colour.sample(10, 20, channel),
                      (std::array{200, 100, 50}[static_cast<std::size_t>(channel)]))
                << name;
    }
}

TEST_F(SenderCamera, StopsWhenInterrupted) {
    expect_failure(run_interrupted_while_live({"touch", "--live", "--camera", sender("oak"), "--record",
                                               record, "--json", report, "--overwrite"}),
                   130, "what was asked for is written");
}

TEST_F(SenderCamera, SilentSenderIsInterruptible) {
    expect_failure(run_interrupted_at_once({"touch", "--live", "--camera", "pipe:exec sleep 1000"}), 130);
}

/// The last frame stands still, and is felt to the run's end.
TEST_F(SenderCamera, EndKeepsLastFrame) {
    // 6244 bytes a frameset: 8 to find out what it is, 2 of before, 20 of the run.
    const std::string camera = "pipe:(" + sender("oak").substr(5) + ") | head -c 187320";
    const auto lived =
        touch({"--live", "--camera", camera, "--seconds", "3", "--hand", "press", "--record", record});
    EXPECT_GE(lived["ticks"].get<int>() + lived["skipped_ticks"].get<int>(), 3000);
    EXPECT_PRED2(says, lived["warnings"].dump(), "its last frame stands still") << lived["warnings"];
    EXPECT_EQ(touch({"--replay", record})["force_hash"], lived["force_hash"]);
}

TEST_F(SenderCamera, EndOfSenderEndsServe) {
    const std::string camera = "pipe:(" + sender("oak").substr(5) + ") | head -c 187320";
    const Outcome sent =
        run_touchable({"serve", "--camera", camera, "tcp://127.0.0.1:0", "--json", report, "--overwrite"});
    EXPECT_EQ(sent.code, 5) << sent.err;
    EXPECT_PRED2(says, sent.err, "touchable: the camera, ");
    EXPECT_PRED2(says, sent.err, ", ended after ");
    EXPECT_PRED2(says, sent.out, " framesets in ");
    EXPECT_GT(json_in(report)["framesets"], 0);
}

TEST(SenderWords, ParseWithoutStartingCommand) {
    const TemporaryFolder folder;
    const std::string made = folder / "made";
    const auto pipe = must(read_live_camera("pipe:touch " + made + "; a,b=c"));
    EXPECT_EQ(std::get<FramesetChoice>(*pipe.plugged).command, "touch " + made + "; a,b=c");
    EXPECT_FALSE(std::filesystem::exists(made));
    const auto tcp = must(read_live_camera("tcp://[::1]:7000"));
    EXPECT_EQ(std::get<FramesetChoice>(*tcp.plugged).address, "[::1]:7000");
}

}  // namespace
}  // namespace touchable::test
