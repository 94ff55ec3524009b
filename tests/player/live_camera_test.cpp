// Touch of a camera: frames that come when they are taken, or do not come. No test depends on a deadline.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "engine/base/threads.hpp"
#include "engine/clip/readers.hpp"
#include "player/session/clip_choice.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/player/touched_camera.hpp"

namespace touchable::test {
namespace {

class LiveCamera : public TouchedCamera {
protected:
    LiveCamera() {
        const Outcome made = run_touchable({"make", "moving", clip, "--size", "64x48", "--frames", "30"});
        EXPECT_EQ(made.code, 0) << made.err;
    }

    const std::string clip = folder / "moving.mkv";
};

TEST_F(LiveCamera, ASessionReplaysToItsHash) {
    const std::string camera = "replay:" + clip + ",fps=100,jitter=4,drop=0.3";
    for (const Words& filter : {Words{}, Words{"--temporal", "5"}}) {
        Words words{"--live", "--camera", camera, "--seconds", "0.4", "--fingers", "2", "--record", record};
        words.insert(words.end(), filter.begin(), filter.end());
        const auto live = touch(words);
        EXPECT_EQ(live["camera"], camera);
        EXPECT_GT(live["frames_shown"], 0);
        EXPECT_GT(live["dropped_frames"], 0);
        EXPECT_LE(live["frames_shown"].get<int>() + live["dropped_frames"].get<int>(), 28);
        EXPECT_FALSE(live.contains("late_frames"));
        EXPECT_EQ(live["warnings"].dump().find("frames came too late"), std::string::npos)
            << live["warnings"];
        EXPECT_GT(live["exposure_to_force_ms"]["p50"], 0);
        EXPECT_LE(live["exposure_to_force_ms"]["p50"], live["exposure_to_force_ms"]["p99"]);
        EXPECT_NE(said.find("exposure to force"), std::string::npos) << said;
        const auto replay = touch({"--replay", record, "--builder", "reference"});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]);
        EXPECT_EQ(replay["camera"], camera);
        EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
    }
}

TEST_F(LiveCamera, ThatIsStalledIsFeltNoMoreWhereItsAgeCounts) {
    const std::string camera = "replay:" + clip + ",fps=100,stall=0.05";
    const Words words{"--live",        "--camera", camera,     "--seconds", "0.4",
                      "--stale-after", "20",       "--record", record};
    const auto live = touch(words);
    EXPECT_GT(live["stale_ticks"], 0);
    EXPECT_NE(said.find("the surface was too old"), std::string::npos) << said;
    const auto replay = touch({"--replay", record});
    EXPECT_EQ(replay["force_hash"], live["force_hash"]);
    EXPECT_EQ(replay["stale_ticks"], live["stale_ticks"]);
    const Outcome refused = run_touchable({"touch", clip, "--stale-after", "20"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("--camera"), std::string::npos) << refused.err;
}

TEST_F(LiveCamera, ThatIsStalledKeepsNobodyFromEnding) {
    const std::string camera = "replay:" + clip + ",fps=100,stall=0.05";
    const auto live = touch({"--live", "--camera", camera, "--seconds", "0.2", "--record", record,
                             "--picture", folder / "p.png", "--picture-size", "64x48", "--painter", "cpu"});
    EXPECT_GE(live["ticks"].get<int>() + live["skipped_ticks"].get<int>(), 200);
    EXPECT_LE(live["frames"], 5) << "0, 1, ... 4";
    EXPECT_EQ(touch({"--replay", record})["force_hash"], live["force_hash"]);
    const Outcome ended = run_interrupted_while_live(
        {"touch", "--live", "--camera", camera, "--overwrite", "--json", report, "--record", record});
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_NE(ended.err.find("what was asked for is written"), std::string::npos) << ended.err;
}

TEST(LiveCameraWords, AreReadOrRefused) {
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
    EXPECT_FALSE(read_live_camera("replay:a.mkv")->delivery.rate.has_value()) << "the recording's own";
    for (const auto& [words, fragment] : std::vector<std::pair<const char*, const char*>>{
             {"webcam",
              "unknown camera 'webcam'; there are v4l2:/dev/videoN, one that is plugged in (touchable "
              "cameras lists them), pipe:CMD and tcp://HOST:PORT, programs that send framesets, "
              "stream:ADDRESS, what touchable serve sends, and replay:PATH"},
             {"replay:,fps=3", "needs a recording"},
             {"replay:a,fps=0", "fps takes 0.1 to 1000 frames/s"},
             {"replay:a,drop=1", "drop takes 0 to 0.99 of the frames"},
             {"replay:a,jitter", "'jitter' is not key=value; keys are fps"},
             {"replay:a,blur=1", "unknown key 'blur'; keys are fps"},
             {"replay:a,stall=2,resume=2", "resume must be a moment after stall"},
             {"replay:a,resume=2", "resume must be a moment after stall"}}) {
        const auto refused = read_live_camera(words);
        ASSERT_FALSE(refused) << words;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
        EXPECT_NE(refused.error().message.find(fragment), std::string::npos) << refused.error().message;
    }
}

TEST(LiveCameraWords, AreRefusedWhereNoCameraCanBe) {
    for (const auto& [words, fragment] : std::vector<std::pair<Words, const char*>>{
             {{"--live", "--camera", "replay:a,fps=no"}, "fps=no is not allowed"},
             {{"--live", "--camera", "replay:a", "a"}, "CLIP and --camera are two things to touch"},
             {{"--camera", "replay:a"}, "--camera needs a live run: its frames come in real time (--live)"},
             {{"--live", "--camera", "replay:a", "--rate", "2"}, "a camera's time only goes on"},
             {{"--live", "--camera", "replay:a", "--interpolation", "linear"},
              "--interpolation linear needs the frame after, which a camera has not taken yet; leave it out"},
             {{"--replay", "a", "--camera", "replay:a"}, "--camera comes from the recording"}}) {
        Words all{"touch"};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome outcome = run_touchable(all);
        EXPECT_EQ(outcome.code, 2) << fragment;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(fragment), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(run_touchable({"touch", "--live", "--camera", "replay:no.mkv"}).code, 3);
}

TEST_F(LiveCamera, FramesThatWereReadAheadAreNotGivenBeforeTheirTime) {
    auto recording = open_clip(clip);
    ASSERT_EQ(message(recording), "");
    auto camera = make_replay_camera(std::move(*recording), {.rate = FrameRate{1000, 1}});
    std::vector<RawFrame> ahead;
    for (int n = 0; n < 20; ++n) ahead.push_back(**camera->next());
    const auto reader = with_prefetched_frames(std::move(camera), std::move(ahead));
    EXPECT_TRUE(reader->is_live());
    for (int n = 0; n < 2; ++n) EXPECT_EQ((*reader->next())->number, n);
    const auto zero = std::chrono::steady_clock::now();
    ASSERT_EQ(message(reader->begin(zero)), "");
    const auto frame = reader->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_GE((*frame)->number, 2);
    EXPECT_GE(std::chrono::steady_clock::now(), zero + std::chrono::nanoseconds((*frame)->time_ns));
    std::stop_source given_up;
    given_up.request_stop();
    const auto told = work_until(given_up.get_token(), [&] { return reader->next(); });
    EXPECT_EQ(told.error().kind, ErrorKind::interrupted);
}

}  // namespace
}  // namespace touchable::test
