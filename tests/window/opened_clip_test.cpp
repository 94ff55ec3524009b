// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "player/audio/heard_sound.hpp"
#include "tests/limits.hpp"
#include "tests/video/remuxed_clip.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

class ChangedClip : public OpenedClipTest {
protected:
    void SetUp() override {
        ASSERT_NO_FATAL_FAILURE(make_globe(60));
        begin();
    }
    PlaybackState now() const { return clip_->session().playback(); }
};

TEST_F(ChangedClip, KeepsPlaybackState) {
    WatchedSession& before = clip_->session();
    ASSERT_TRUE(before.ask(PlaybackVerb::rate, 500));
    ASSERT_TRUE(before.ask(PlaybackVerb::loop, 100'000'000, 1'500'000'000));
    ASSERT_TRUE(before.ask(PlaybackVerb::seek, 700'000'000));
    ASSERT_TRUE(before.ask(PlaybackVerb::pause));
    ASSERT_TRUE(comes_true([this] { return !now().playing; }));
    const std::int64_t moment = now().moment.time_ns;
    ASSERT_TRUE(change("median", "5"));
    ASSERT_TRUE(comes_true([this] { return now().moment.epoch > 0 && !now().playing; }));
    EXPECT_EQ(now().moment.time_ns, moment);
    EXPECT_EQ(now().rate, 500);
    EXPECT_TRUE(now().loops);
    EXPECT_EQ(now().loop_end_ns, 1'500'000'000);
    EXPECT_EQ(clip_->in_effect().at("median"), "5");
    EXPECT_EQ(clip_->scene().filter.median, 5);
    // While it plays it plays on from there, half as fast as time goes by.
    const auto since = std::chrono::steady_clock::now();
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::play));
    ASSERT_TRUE(comes_true([&] { return now().moment.time_ns > moment + 20'000'000; }));
    ASSERT_TRUE(change("metric", "pixel"));
    EXPECT_TRUE(comes_true([&] { return now().playing && now().moment.time_ns > moment + 20'000'000; }));
    const std::int64_t played_ns = now().moment.time_ns - moment;
    const std::chrono::nanoseconds gone_by = std::chrono::steady_clock::now() - since;
    EXPECT_LE(played_ns, gone_by.count() / 2 + 2'000'000) << "and by no tick more";
    EXPECT_EQ(clip_->in_effect().at("metric"), "pixel");
    EXPECT_EQ(clip_->in_effect().at("median"), "5");
}

TEST_F(ChangedClip, FollowsCommandsGivenMeanwhile) {
    ASSERT_TRUE(comes_true([this] { return now().moment.time_ns > 0; }));
    auto change = clip_->prepare(clip_->settings(), nullptr);
    ASSERT_TRUE(change) << change.error().message;
    WatchedSession& before = clip_->session();
    ASSERT_TRUE(before.ask(PlaybackVerb::rate, 700));
    ASSERT_TRUE(before.ask(PlaybackVerb::seek, 1'200'000'000));
    ASSERT_TRUE(before.ask(PlaybackVerb::loop, 1'000'000'000, 1'400'000'000));
    ASSERT_TRUE(before.ask(PlaybackVerb::pause));
    ASSERT_TRUE(comes_true([this] { return !now().playing; }));
    EXPECT_TRUE(clip_->has_come_to(*change)) << "it never will";
    ASSERT_TRUE(clip_->take(std::move(*change)));
    ASSERT_TRUE(comes_true([this] { return !now().playing; }));
    EXPECT_EQ(now().moment.time_ns, 1'200'000'000);
    EXPECT_EQ(now().rate, 700);
    EXPECT_EQ(now().loop_begin_ns, 1'000'000'000);
}

TEST_F(ChangedClip, LosesNoCommandDuringChange) {
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::loop, 0, 1'500'000'000));
    ASSERT_TRUE(comes_true([this] { return now().loops; }));
    auto change = clip_->prepare(clip_->settings(), nullptr);
    ASSERT_TRUE(change) << change.error().message;
    ASSERT_TRUE(comes_true([&] { return clip_->has_come_to(*change); }));
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::loop, 0, 1'800'000'000));
    ASSERT_TRUE(comes_true([&] { return clip_->has_come_to(*change); }));
    ASSERT_TRUE(clip_->take(std::move(*change)));
    EXPECT_TRUE(comes_true([this] { return now().loop_end_ns == 1'800'000'000; })) << now().loop_end_ns;
    auto other = clip_->prepare(clip_->settings(), nullptr);
    ASSERT_TRUE(other) << other.error().message;
    ASSERT_TRUE(comes_true([&] { return clip_->has_come_to(*other); }));
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::pause));
    ASSERT_TRUE(comes_true([&] { return clip_->has_come_to(*other); }));
    ASSERT_TRUE(clip_->take(std::move(*other)));
    EXPECT_TRUE(comes_true([this] { return !now().playing; }));
}

TEST_F(ChangedClip, ReportsFailureOfEarlierSession) {
    auto change = clip_->prepare(clip_->settings(), nullptr);
    ASSERT_TRUE(change) << change.error().message;
    std::filesystem::resize_file(choice_.file, 3000);
    ASSERT_TRUE(comes_true([this] { return clip_->session().clip_failure().has_value(); }));
    EXPECT_FALSE(clip_->failure()) << "it still goes on";
    ASSERT_TRUE(clip_->take(std::move(*change)));
    ASSERT_TRUE(clip_->failure());
    EXPECT_TRUE(contains(clip_->failure()->message, "globe.mkv"));
}

TEST_F(ChangedClip, CountsTicksOfAllSessions) {
    ASSERT_TRUE(comes_true([this] { return clip_->figures().ticks.ticks > 20; }));
    const std::int64_t before = clip_->figures().ticks.ticks;
    ASSERT_TRUE(change("metric", "pixel"));
    EXPECT_GE(clip_->figures().ticks.ticks, before);
    EXPECT_LT(clip_->session().figures().ticks.ticks, clip_->figures().ticks.ticks);
}

TEST_F(ChangedClip, KeepsItsScale) {
    const std::string file = (folder_ / "noise.mkv").string();
    ASSERT_TRUE(write_generated_clip("noise", file, {.width = 64, .height = 48}, 3));
    Scene scene = open_clip(file).value()->scene();
    scene.device_metres_per_unit.reset();  // so that the first frame decides, as it was filtered
    std::ofstream(folder_ / "scene.json") << scene_to_json(scene);
    ClipChoice noise;
    noise.file = file;
    noise.scene_file = folder_ / "scene.json";
    const auto scale = [](const TouchSetup& setup) { return setup.options.touch.metres_per_scene_unit; };
    const auto first = opened(noise);
    ASSERT_TRUE(first && first->begin());
    SessionSettings smooth;
    ASSERT_TRUE(smooth.set("median", "5"));
    const auto anew = opened(noise, smooth);
    ASSERT_TRUE(anew && anew->begin());
    const double before = scale(first->session().setup());
    ASSERT_NE(scale(anew->session().setup()), before) << "nothing is tested";
    const auto changed = first->prepare(smooth, nullptr);
    ASSERT_TRUE(changed) << changed.error().message;
    EXPECT_EQ(scale(*changed->setup), before);
}

TEST_F(ChangedClip, MarksKeepErrorBarsOfNoise) {
    for (const bool is_noisy : {false, true}) {
        MeasuredDepth& measured = choice_.measured.emplace().measured.emplace();
        measured.pixel = 1;
        measured.roughness = is_noisy ? 1 : 0;
        begin();
        ASSERT_TRUE(comes_true([&] { return clip_->session().look() != nullptr; }));
        const HeightField field(clip_->scene(), clip_->session().look()->held.pair);
        FingerMark mark{.proxy = {0, 0, -clip_->scene().depth.near}, .error_degrees = 9};
        clip_->put_on_surface({&mark, 1}, {}, field, false);
        EXPECT_EQ(std::isnan(mark.error_degrees), !is_noisy);
    }
}

/// How often each frame of a clip was read, and how often the clip was opened.
struct ReadClip {
    std::map<std::int64_t, int> times;
    int opened = 0;
};

class CountedReader final : public ReaderAround {
public:
    CountedReader(std::unique_ptr<ClipReader> clip, std::shared_ptr<ReadClip> read)
        : ReaderAround(std::move(clip)), read_(std::move(read)) {}
    Result<std::optional<RawFrame>> next() override {
        auto frame = inner().next();
        if (frame && *frame) ++read_->times[(*frame)->number];
        return frame;
    }

private:
    const std::shared_ptr<ReadClip> read_;
};

/// With a filter that remembers, its noise stated, so that all settings go with the clip.
class CountedClip : public ChangedClip {
protected:
    void open(const std::filesystem::path& record = {}) {
        Scene scene = open_clip(choice_.file).value()->scene();
        scene.filter.temporal_noise = {5, 0};
        std::ofstream(folder_ / "scene.json") << scene_to_json(scene);
        choice_.scene_file = folder_ / "scene.json";
        if (!record.empty()) options_.record = record;
        choice_.share_clip();
        const auto shared = choice_.shared_clip->open([this]() -> Result<std::unique_ptr<ClipReader>> {
            auto clip = open_clip(choice_.file, choice_.scene_file);
            if (!clip) return clip;
            ++read_->opened;
            return std::unique_ptr<ClipReader>(std::make_unique<CountedReader>(std::move(*clip), read_));
        });
        ASSERT_TRUE(shared) << shared.error().message;
        begin();
    }

    const std::shared_ptr<ReadClip> read_ = std::make_shared<ReadClip>();
};

TEST_F(CountedClip, ChangeRereadsNothing) {
#ifdef TOUCHABLE_SANITIZED
    constexpr std::int64_t speed = 100;  // thousandths: 60 frames are 20 s
#else
    constexpr std::int64_t speed = 200;
#endif
    ASSERT_NO_FATAL_FAILURE(open());
    // The files that a second opening would need are gone.
    std::filesystem::remove(choice_.file);
    std::filesystem::remove(*choice_.scene_file);
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::rate, speed));
    ASSERT_TRUE(comes_true([this] { return now().moment.time_ns > 200'000'000; }));
    for (const auto& [name, value] : {std::pair("median", "5"),
                                      {"temporal", "on"},
                                      {"fill-holes", "2"},
                                      {"detail", "0.5"},
                                      {"metric", "pixel"},
                                      {"filters", "auto"},
                                      {"interpolation", "hold"}}) {
        const auto changed = change(name, value);
        ASSERT_TRUE(changed) << name << ": " << changed.error().message;
        const std::int64_t frame = clip_->scene().rate.frame_at(now().moment.time_ns);
        ASSERT_TRUE(comes_true([this] { return clip_->session().figures().feed.frames > 2; })) << name;
        EXPECT_LT(frame, 55) << "nothing is tested where the clip has ended";
    }
    ASSERT_TRUE(clip_->finish());  // its threads count until then
    EXPECT_EQ(read_->opened, 1);
    for (const auto& [frame, times] : read_->times) EXPECT_EQ(times, 1) << "frame " << frame;
    EXPECT_GT(read_->times.size(), 10U);
}

/// In frames and in the clip's time: what it takes on a machine is the filters' time for so many. Under a
/// sanitizer, beside other tests, these take many times as long, so time is as much slower there.
TEST_F(CountedClip, ChangeFiltersFewFrames) {
#ifdef TOUCHABLE_SANITIZED
    constexpr std::int64_t speed = 20;  // thousandths
#else
    constexpr std::int64_t speed = 200;
#endif
    ASSERT_NO_FATAL_FAILURE(open(folder_ / "hand.touch"));
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::seek, 900'000'000));
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::rate, speed));
    ASSERT_TRUE(comes_true([this] { return now().rate == speed && now().moment.time_ns > 900'000'000; }));
    for (const auto& [name, value, most_frames] :
         {std::tuple("median", "5", 3), {"temporal", "on", temporal_warm_up_frames + 3}}) {
        SessionSettings settings = clip_->settings();
        ASSERT_TRUE(settings.set(name, value));
        const auto change = clip_->prepare(settings, nullptr);
        ASSERT_TRUE(change) << change.error().message;
        int filtered = 0;
        for (const FrameRun& run : change->setup->feed->built()) filtered += static_cast<int>(run.count);
        EXPECT_GE(filtered, 2);
        EXPECT_LE(filtered, most_frames) << name;
        EXPECT_LE(change->begin_ns - change->state.moment.time_ns, 100'000'000) << name;
    }
}

/// The fingers' forces are checked tick by tick, at every change.
TEST_F(CountedClip, ForceRampsUpAfterChange) {
    const std::filesystem::path record = folder_ / "hand.touch";
    ASSERT_NO_FATAL_FAILURE(open(record));
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::pause));
    ASSERT_NO_FATAL_FAILURE(press(32, 24));
    const auto presses = [this] {
        const WatchedMoment* const moment = clip_->session().look();
        return moment && moment->felt.tick > 300 && glm::length(moment->felt.fingers[0].force.force) > 0.1;
    };
    ASSERT_TRUE(comes_true(presses));
    for (const auto& [name, value] : {std::pair("median", "5"), {"detail", "0.3"}, {"median", "0"}}) {
        ASSERT_TRUE(change(name, value));
        ASSERT_TRUE(comes_true(presses)) << name;
    }
    ASSERT_TRUE(clip_->finish());
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_EQ(recording->size(), 4U);
    double most = 0;
    for (const RecordedPart& part : *recording)
        for (const RecordedPart::Tick& tick : part.ticks) most = std::max(most, glm::length(tick.forces[0]));
    for (const RecordedPart& part : *recording) {
        const int ramp = GuardSettings().ramp_in_ticks;
        double before = 0;
        for (std::size_t k = 0; k < part.ticks.size(); ++k) {
            const double force = glm::length(part.ticks[k].forces[0]);
            const double ticks_in = static_cast<double>(part.ticks[k].time_ns) * 1e-6 + 1;
            EXPECT_LE(force, most * std::min(1.0, ticks_in / ramp) * 1.001) << part.name << ", tick " << k;
            if (ticks_in > ramp) break;
            before = force;
        }
        EXPECT_TRUE(before > 0 || &part == &recording->front()) << part.name << ": nothing is tested";
    }
}

TEST_F(ChangedClip, AppliesColourRelief) {
    choice_.share_clip();
    const auto heights = [&] {
        auto reader = choice_.open();
        EXPECT_TRUE(reader);
        const auto frame = (*reader)->next();
        EXPECT_TRUE(frame && *frame);
        std::vector<std::uint16_t> codes;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) codes.push_back((*frame)->height.sample(x, y));
        return codes;
    };
    const auto own = heights();
    choice_.relief = ReliefChoice{};
    const auto half = [&] {
        choice_.relief->settings.amount = 50;
        return heights();
    }();
    EXPECT_NE(half, own);
    ASSERT_TRUE(choice_.shared_clip->relief_range(choice_.relief->settings.bands));
    choice_.relief->settings.amount = 100;
    const auto whole = heights();
    int higher = 0;
    for (std::size_t k = 0; k < whole.size(); ++k) {
        EXPECT_NEAR(whole[k] - 128, std::clamp(2 * (half[k] - 128), -128, 127), 2);
        higher += whole[k] != 128 ? 1 : 0;
    }
    EXPECT_GT(higher, 100);
    choice_.relief.reset();
    EXPECT_EQ(heights(), own);
    // And while it is touched.
    EXPECT_TRUE(change("relief", "200"));
    EXPECT_TRUE(comes_true([&] { return now().moment.time_ns > 0; }));
    EXPECT_FALSE(clip_->failure());
}

TEST_F(ChangedClip, KeepsSessionOnUnfitSettings) {
    const WatchedSession* const before = &clip_->session();
    ASSERT_TRUE(comes_true([this] { return now().moment.time_ns > 0; }));
    const auto refused = change("temporal", "on");
    ASSERT_FALSE(refused) << "a made clip has no noise";
    EXPECT_TRUE(contains(refused.error().message, "temporal"));
    EXPECT_EQ(&clip_->session(), before);
    EXPECT_TRUE(clip_->session().running());
    EXPECT_TRUE(comes_true([this] { return now().playing; }));
    EXPECT_EQ(clip_->settings(), SessionSettings());
}

TEST_F(ChangedClip, FingerStaysPressed) {
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::pause));
    ASSERT_NO_FATAL_FAILURE(press(32, 24));
    const auto presses = [&] { return glm::length(felt().force.force) > 0.1; };
    ASSERT_TRUE(comes_true(presses));
    const glm::dvec3 before = felt().goal;
    ASSERT_TRUE(change("metric", "pixel"));
    ASSERT_TRUE(comes_true([&] { return glm::length(felt().goal) > 0; }));
    // It is on its way in still; had it gone away, it would come from the camera.
    EXPECT_LT(glm::length(felt().goal - before), 0.2 * glm::length(before));
    EXPECT_TRUE(comes_true(presses));
}

TEST_F(ChangedClip, TakesCommandsAcrossSessions) {
    for (int k = 0; k < 65000; ++k) ASSERT_TRUE(clip_->session().ask(PlaybackVerb::rate, 1000));
    ASSERT_TRUE(clip_->session().ask(PlaybackVerb::rate, 500));
    ASSERT_TRUE(comes_true([this] { return clip_->is_nearly_full() && now().rate == 500; }));
    ASSERT_TRUE(change("metric", "world"));
    EXPECT_FALSE(clip_->is_nearly_full());
    EXPECT_TRUE(comes_true([this] { return now().rate == 500; }));
    for (int k = 0; k < 1000; ++k) ASSERT_TRUE(clip_->session().ask(PlaybackVerb::rate, 2000));
    EXPECT_TRUE(comes_true([this] { return now().rate == 2000; }));
}

// The clip's own sound in the window: at the clip's moments, whatever is done to its time.

class ClipHeard : public ::testing::Test {
protected:
    void SetUp() override { begin(tone(480, 3)); }
    void begin(std::vector<StereoSample> sound) {
        sound_ = std::move(sound);
        const auto file = folder_ / (std::to_string(++files_) + ".mkv");
        write_sounding_clip(file, sound_);
        clip_.open(file);
        wait_for(0);
    }
    /// Until a second and a half from there has been decoded.
    void wait_for(double seconds) {
        std::vector<StereoSample> samples(72'000);
        const auto first = static_cast<std::int64_t>(seconds * SoundTrack::rate) - 1;
        ASSERT_TRUE(comes_true([&] { return clip_.read(first, samples); })) << seconds << " s";
    }
    /// Ticks from a moment on, at a speed.
    std::vector<StereoSample> hear(double from_s, int ticks, float speed = 1, std::uint64_t epoch = 0) {
        std::vector<StereoSample> heard;
        for (int k = 0; k < ticks; ++k) {
            HeardTick tick;
            tick.clip = {true, static_cast<std::int64_t>(1e9 * from_s + 1e6 * speed * k), epoch, speed};
            add(tick, heard);
        }
        return heard;
    }
    std::vector<StereoSample> hear_nothing(int ticks) {
        std::vector<StereoSample> heard;
        for (int k = 0; k < ticks; ++k) add(HeardTick{}, heard);
        return heard;
    }
    void add(const HeardTick& tick, std::vector<StereoSample>& heard) {
        ContactSound::Samples samples{};
        voice_.render(tick, clip_, samples);
        heard.insert(heard.end(), samples.begin(), samples.end());
    }
    static int zero_crossings(const std::vector<StereoSample>& heard) {
        int count = 0;
        for (std::size_t k = 1; k < heard.size(); ++k)
            if ((heard[k - 1].left < 0) != (heard[k].left < 0)) ++count;
        return count;
    }
    static double largest_step(const std::vector<StereoSample>& heard) {
        double most = 0;
        for (std::size_t k = 1; k < heard.size(); ++k)
            most = std::max<double>(most, std::abs(heard[k].left - heard[k - 1].left));
        return most;
    }

    TemporaryFolder folder_;
    int files_ = 0;
    std::vector<StereoSample> sound_;
    ClipSound clip_;
    HeardSound voice_;
};

TEST_F(ClipHeard, MatchesTrackAtNormalSpeed) {
    wait_for(0.2);
    const auto heard = hear(0.5, 200);
    for (std::size_t k = 48; k < heard.size(); ++k) {  // after it has risen
        ASSERT_NEAR(heard[k].left, sound_[24'000 + k].left, 1e-5) << k;
        ASSERT_NEAR(heard[k].right, sound_[24'000 + k].right, 1e-5) << k;
    }
}

TEST_F(ClipHeard, PitchFollowsSpeed) {
    wait_for(0.2);
    const int once = zero_crossings(hear(0.5, 200));
    EXPECT_NEAR(zero_crossings(hear(0.5, 200, 2, 1)), 2 * once, 3);
    EXPECT_NEAR(zero_crossings(hear(0.5, 200, 0.5F, 2)), once / 2, 3);
}

TEST_F(ClipHeard, SeeksAndPausesWithoutClicks) {
    wait_for(0.2);
    const double step = 1.3 * largest_step(sound_);
    auto heard = hear(0.5, 50);
    for (const auto& part :
         {hear(1.0012, 50, 1, 1), hear_nothing(20), hear(0.2507, 50, 1, 1), hear(0.9, 50, 1, 1)})
        heard.insert(heard.end(), part.begin(), part.end());
    EXPECT_LT(largest_step(heard), step + 0.5 / 48);
}

/// The newest block replaces the oldest: one block is there, and the one behind it is not yet.
TEST_F(ClipHeard, LateDecodingDoesNotClick) {
    const double step = 1.3 * largest_step(sound_);
    for (std::uint64_t go = 0; go < 20; ++go) {
        wait_for(1.4);
        for (const double from_s : {0.16, 0.0, 0.08}) {
            const auto heard = hear(from_s, 300, 4, 3 * go + static_cast<std::uint64_t>(100 * from_s));
            ASSERT_LT(largest_step(heard), 4 * step + 0.5 / 48) << go;
        }
    }
}

TEST_F(ClipHeard, IsSilentWhileNothingPlays) {
    hear(0.5, 50);
    hear_nothing(2);
    for (const StereoSample& sample : hear_nothing(50)) ASSERT_EQ(sample.left, 0);
}

TEST_F(ClipHeard, FollowsFastTicks) {
    // A hundredth of a percent is what clocks differ by; a tenth is far more.
    wait_for(0.1);
    std::vector<StereoSample> heard;
    HeardTick tick;
    for (int k = 0; k < 1000; ++k) {
        tick.clip = {true, static_cast<std::int64_t>(200'000'000 + 1'001'000.0 * k), 0, 1};
        add(tick, heard);
    }
    EXPECT_LT(largest_step(heard), 1.1 * largest_step(sound_));
    EXPECT_GT(zero_crossings(heard), 2 * 480 - 3);
}

TEST_F(ClipHeard, FollowsOpenedFile) {
    hear(0.1, 20);
    begin(tone(960, 1));
    hear_nothing(2);
    const auto heard = hear(0, 100);
    EXPECT_NEAR(zero_crossings(heard), 192, 4);
    clip_.open(folder_ / "missing.mkv");
    hear_nothing(2);
    for (const StereoSample& sample : hear(0, 50)) ASSERT_EQ(sample.left, 0);
    EXPECT_EQ(clip_.fault(), "");
}

TEST_F(ClipHeard, FollowsReplacedFile) {
    hear(0.1, 20);
    std::filesystem::remove(folder_ / "1.mkv");
    files_ = 0;
    begin(tone(960, 1));
    hear_nothing(2);
    EXPECT_NEAR(zero_crossings(hear(0, 100)), 192, 4);
}

TEST_F(ClipHeard, DecodesAfterAnySeek) {
    begin(tone(480, 20));
    for (const double moment : {15.0, 3.0, 19.5, 0.0, 7.77}) wait_for(moment);
    wait_for(7.77);
    const auto heard = hear(7.77, 20);
    for (std::size_t k = 48; k < heard.size(); ++k)
        ASSERT_NEAR(heard[k].left, sound_[372'960 + k].left, 1e-4) << k;
}

/// However far its thread has come with opening the file.
TEST_F(ClipHeard, OfflineReadWaitsForFile) {
    for (int go = 0; go < 200; ++go) {
        ClipSound sound;
        sound.wait_for_decoding();
        sound.open(folder_ / "1.mkv");
        std::this_thread::sleep_for(std::chrono::microseconds(10 * go));
        std::vector<StereoSample> samples(480);
        ASSERT_TRUE(sound.read(0, samples)) << go;
        EXPECT_NEAR(samples[100].left, sound_[100].left, 1e-4);
    }
}

TEST(ClipSound, ReportsDamagedTrack) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / "film.mkv";
    auto film = FilmWriter::create(file, Existing::keep);
    ASSERT_TRUE(film);
    const Image grey{64, 48, 1, 3, std::vector<std::uint8_t>(64 * 48 * 3, 128)};
    ASSERT_TRUE((*film)->add(grey.view(), 0));
    ASSERT_TRUE((*film)->add_sound(0, tone(480, 1.5)));  // FLAC, which knows when it is not whole
    ASSERT_TRUE((*film)->finish(45));
    const auto fault_of = [](const std::filesystem::path& clip) {
        ClipSound sound;
        sound.open(clip);
        std::vector<StereoSample> samples(60'000);
        comes_true([&] { return sound.read(0, samples); }, 10'000);
        return sound.fault();
    };
    EXPECT_EQ(fault_of(file), "");
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp(static_cast<std::streamoff>(std::filesystem::file_size(file) / 2));
    bytes << std::string(6000, '\xAA');
    bytes.close();
    EXPECT_TRUE(contains(fault_of(file), "film.mkv: its sound is damaged"));
}

}  // namespace
}  // namespace touchable::test
