// Touch of a camera that is plugged in, over a fake of the kernel's side. No test depends on a deadline.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "player/commands/touch_run.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/opened_clip.hpp"
#include "tests/camera/fake_video.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/full_disk.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

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
        options.session.clip.take(*camera);
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
        return nlohmann::json::parse(file_contents(report), nullptr, false);
    }

    const std::shared_ptr<FakeVideo> video = std::make_shared<FakeVideo>();
    const TemporaryFolder folder;
    const std::filesystem::path record = folder / "run.rec", film = folder / "run.rec.mkv",
                                report = folder / "r.json";
    mutable std::string said;
};

TEST_F(PluggedCamera, ASessionReplaysWithoutItToItsHash) {
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
        EXPECT_NE(lived["notes"].dump().find("are kept as " + film.string()), std::string::npos);
        EXPECT_NE(lived["warnings"].dump().find("were damaged or cut short"), std::string::npos);
        video->unplug(node);
        const auto again = touch(replay());
        EXPECT_EQ(again["force_hash"], lived["force_hash"]);
        EXPECT_EQ(again["camera"], "v4l2:" + node);
        EXPECT_EQ(again["clip"], film.string());
        EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
    }
    // The film is a clip like any other, with every value as the camera gave it.
    const auto clip = open_clip(film);
    ASSERT_EQ(message(clip), "");
    const auto frame = (*clip)->next();
    ASSERT_EQ(message(frame), "");
    const auto is_picture = [&](std::uint32_t number) {
        const auto painted = ball(number);
        for (int y = 0; y < height; ++y)
            if (std::memcmp((*frame)->depth.row(y), painted.data() + 2 * width * y, 2 * width) != 0)
                return false;
        return true;
    };
    std::uint32_t number = 0;
    while (number < 200 && !is_picture(number)) ++number;
    EXPECT_LT(number, 200u);
}

/// The last frame stands still, the hand goes on, and no force jumps.
TEST_F(PluggedCamera, ThatIsUnpluggedIsFeltToTheEnd) {
    plug_in([](std::uint32_t n) { return n == 200 ? Fate::unplugged : Fate::good; });
    const auto lived = touch(live(2.5));
    EXPECT_GE(lived["ticks"].get<int>() + lived["skipped_ticks"].get<int>(), 2500);
    const std::string warnings = lived["warnings"].dump();
    EXPECT_NE(warnings.find("the camera, " + node + ", was unplugged after "), std::string::npos) << warnings;
    EXPECT_NE(warnings.find("its last frame stands still"), std::string::npos) << warnings;
    EXPECT_EQ(touch(replay())["force_hash"], lived["force_hash"]);
}

/// The camera is felt to the end of the run; film and recording end with the last frame for which there was
/// room.
TEST_F(PluggedCamera, AFilmWhoseDiskBecomesFullReplaysUpToThere) {
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
    EXPECT_NE(message(ran).find("; it is kept, and replays, up to "), std::string::npos) << message(ran);
    EXPECT_NE(
        warned.find("touchable: warning: the film of --record: " + film.string() + ": the disk is full"),
        std::string::npos)
        << warned;
    const auto lived = nlohmann::json::parse(file_contents(report), nullptr, false);
    EXPECT_GE(lived["ticks"].get<int>() + lived["skipped_ticks"].get<int>(), 1200) << "the run goes on";
    const auto again = touch(replay());
    EXPECT_GT(again["ticks"], 20);
    EXPECT_LT(again["ticks"], lived["ticks"]);
    EXPECT_LE(std::filesystem::file_size(film), 200 * 1024U);
}

TEST_F(PluggedCamera, AFilmThatIsAnothersOrInTheWayIsRefused) {
    plug_in(good);
    (void)touch(live(0.1));
    write_bytes(film, "something else");
    TouchOptions options = live(0.1);
    const auto kept = run_touch(options);
    EXPECT_NE(message(kept).find("run.rec is there already"), std::string::npos) << message(kept);
    std::filesystem::remove(record);
    const auto film_kept = run_touch(options);
    EXPECT_NE(message(film_kept).find("run.rec.mkv is there already"), std::string::npos)
        << message(film_kept);
    EXPECT_EQ(read_bytes(film), "something else");
    std::filesystem::remove(film);
    (void)touch(live(0.1));
    ASSERT_EQ(run_touchable(
                  {"make", "moving", film, "--size", "64x48", "--frames", "3", "--bits", "16", "--overwrite"})
                  .code,
              0);
    const auto another = run_touch(replay());
    EXPECT_NE(message(another).find("it is not the film of that recording"), std::string::npos)
        << message(another);
}

/// A film is given up where its recording has ended before it began: the recording keeps what it has.
TEST_F(PluggedCamera, InAWindowARecordingThatIsFullKeepsWhatItHas) {
    plug_in(good).paint = [](std::uint32_t) { return ball(0); };  // which takes no room in the film
    PlayOptions options;
    options.record = record;
    options.session = live(600).session;
    options.session.builder.name = "cpu";
    const auto sound = std::move(*WindowSound::create(false, {}, Existing::keep));
    {
        const FullDisk full(400 * 1024);
        auto opened = OpenedClip::open(options, options.session.clip, {}, *sound);
        ASSERT_EQ(message(opened), "");
        OpenedClip& clip = **opened;
        ASSERT_EQ(message(clip.begin()), "");
        for (int k = 0; k < 20'000 && !clip.record_fault(); ++k)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ASSERT_TRUE(clip.record_fault());
        ASSERT_FALSE(clip.session().setup().film->fault()) << "the recording is to be full, not its film";
        SessionSettings settings = clip.settings();
        ASSERT_EQ(message(settings.set("median", "5")), "");
        auto change = clip.prepare(settings);
        ASSERT_EQ(message(change), "");
        ASSERT_EQ(message(clip.take(std::move(*change))), "");
        const auto done = clip.finish();
        EXPECT_NE(message(done).find("; it is kept, and replays, up to "), std::string::npos)
            << message(done);
    }
    const auto recording = read_recording(record);
    ASSERT_EQ(message(recording), "");
    EXPECT_GT(recording->front().ticks.size(), 100U);
    EXPECT_FALSE(std::filesystem::exists(film_beside(record, 2))) << "nothing was to be kept any more";
}

/// Settings are changed while the camera goes on: it is opened once, and each part has a film of its own.
TEST_F(PluggedCamera, InAWindowGoesOnWithOtherSettings) {
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
        auto opened = OpenedClip::open(options, options.session.clip, {}, *sound);
        ASSERT_EQ(message(opened), "");
        OpenedClip& clip = **opened;
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
        auto change = clip.prepare(settings);
        ASSERT_EQ(message(change), "");
        EXPECT_TRUE(clip.has_come_to(*change));
        const std::int64_t before = *taken;
        ASSERT_EQ(message(clip.take(std::move(*change))), "");
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
    EXPECT_NE(said.find("every force is as recorded, to the bit in all 2 parts"), std::string::npos) << said;
}

TEST(PluggedCameraWords, AreReadOrRefused) {
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
    for (const auto& [words, fragment] : std::vector<std::pair<const char*, const char*>>{
             {"v4l2:", "needs a node, such as v4l2:/dev/video0"},
             {"v4l2:a,size=3", "size=3 is not allowed; must be WIDTHxHEIGHT"},
             {"v4l2:a,size=0x4", "size=0x4 is not allowed"},
             {"v4l2:a,fps=0", "fps takes 0.1 to 1000 frames/s"},
             {"v4l2:a,jitter=2", "unknown key 'jitter'"}}) {
        const auto refused = read_live_camera(words);
        ASSERT_FALSE(refused) << words;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
        EXPECT_NE(refused.error().message.find(fragment), std::string::npos) << refused.error().message;
    }
    const Outcome absent =
        run_touchable({"touch", "--live", "--camera", "v4l2:/dev/video/none", "--fov", "60"});
    EXPECT_EQ(absent.code, 3);
    EXPECT_TRUE(absent.one_line_of_error()) << absent.err;
    EXPECT_NE(absent.err.find("does not exist; touchable cameras lists"), std::string::npos) << absent.err;
}

}  // namespace
}  // namespace touchable::test
