// The senders of examples/senders, each over a fake of its camera's module, into the program. Python says
// what they say; no test depends on a deadline.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "player/session/clip_choice.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/player/touched_camera.hpp"

namespace touchable::test {
namespace {

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
        EXPECT_NE(notes.find("sends depth of 64x48, " + unit + " m a code, fx 60, fy 60, at "),
                  std::string::npos)
            << notes;
        EXPECT_EQ(lived["warnings"].dump().find("the camera"), std::string::npos) << lived["warnings"];
        const auto again = touch({"--replay", record, "--builder", "reference"});
        EXPECT_EQ(again["force_hash"], lived["force_hash"]);
        EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
    }
};

TEST_F(SenderCamera, RealSenseIsTouched) {
    is_touched("realsense", "0.0001");
}
TEST_F(SenderCamera, AzureKinectIsTouched) {
    is_touched("azure_kinect", "0.001");
}
TEST_F(SenderCamera, OakIsTouched) {
    is_touched("oak", "0.001");
}
TEST_F(SenderCamera, Ros2IsTouched) {
    is_touched("ros2", "0.001");
}

/// The block of Python in docs/streaming.md.
TEST_F(SenderCamera, TheDocumentedOneIsTouched) {
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

TEST_F(SenderCamera, ThatHasNoModuleSaysSo) {
    const std::string script = std::string(TOUCHABLE_SOURCE_DIR) + "/examples/senders/realsense.py";
    const Outcome outcome =
        run_touchable({"touch", "--live", "--camera", "pipe:PYTHONPATH= exec python3 -S '" + script + "'"});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
    EXPECT_NE(outcome.err.find("ended with status 1: ModuleNotFoundError: No module named 'pyrealsense2'"),
              std::string::npos)
        << outcome.err;
}

TEST_F(SenderCamera, ItsColourIsShownOnDepthsPixels) {
    for (const char* name : {"realsense", "azure_kinect"}) {
        auto camera = read_live_camera(sender(name));
        ASSERT_EQ(message(camera), "");
        const auto reader = open_plugged_camera(*camera->plugged);
        ASSERT_EQ(message(reader), "");
        const auto frame = (*reader)->next();
        ASSERT_EQ(message(frame), "");
        const PlaneView& colour = (*frame)->colour;
        ASSERT_EQ(colour.width, 64);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_EQ(colour.sample(10, 20, channel),
                      (std::array{200, 100, 50}[static_cast<std::size_t>(channel)]))
                << name;
    }
}

TEST_F(SenderCamera, ARunEndsWhenItIsInterrupted) {
    const Outcome ended = run_interrupted_while_live(
        {"touch", "--live", "--camera", sender("oak"), "--record", record, "--json", report, "--overwrite"});
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_NE(ended.err.find("what was asked for is written"), std::string::npos) << ended.err;
}

TEST_F(SenderCamera, OneThatIsSilentKeepsNobodyFromEnding) {
    const Outcome ended = run_interrupted_at_once({"touch", "--live", "--camera", "pipe:exec sleep 1000"});
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_TRUE(ended.one_line_of_error()) << ended.err;
}

/// The last frame stands still, and is felt to the run's end.
TEST_F(SenderCamera, ThatEndsIsFeltToTheEnd) {
    // 6244 bytes a frameset: 8 to find out what it is, 2 of before, 20 of the run.
    const std::string camera = "pipe:(" + sender("oak").substr(5) + ") | head -c 187320";
    const auto lived =
        touch({"--live", "--camera", camera, "--seconds", "3", "--hand", "press", "--record", record});
    EXPECT_GE(lived["ticks"].get<int>() + lived["skipped_ticks"].get<int>(), 3000);
    EXPECT_NE(lived["warnings"].dump().find("its last frame stands still"), std::string::npos)
        << lived["warnings"];
    EXPECT_EQ(touch({"--replay", record})["force_hash"], lived["force_hash"]);
}

TEST_F(SenderCamera, ThatEndsEndsServe) {
    const std::string camera = "pipe:(" + sender("oak").substr(5) + ") | head -c 187320";
    const Outcome sent =
        run_touchable({"serve", "--camera", camera, "tcp://127.0.0.1:0", "--json", report, "--overwrite"});
    EXPECT_EQ(sent.code, 5) << sent.err;
    EXPECT_NE(sent.err.find("touchable: the camera, "), std::string::npos) << sent.err;
    EXPECT_NE(sent.err.find(", ended after "), std::string::npos) << sent.err;
    EXPECT_NE(sent.out.find(" framesets in "), std::string::npos) << sent.out;
    EXPECT_GT(nlohmann::json::parse(file_contents(report), nullptr, false)["framesets"], 0);
}

TEST(SenderWords, AreReadOrRefusedAndStartNothing) {
    const TemporaryFolder folder;
    const std::string made = folder / "made";
    const auto pipe = read_live_camera("pipe:touch " + made + "; a,b=c");
    ASSERT_EQ(message(pipe), "");
    EXPECT_EQ(std::get<FramesetChoice>(*pipe->plugged).command, "touch " + made + "; a,b=c");
    EXPECT_FALSE(std::filesystem::exists(made));
    const auto tcp = read_live_camera("tcp://[::1]:7000");
    ASSERT_EQ(message(tcp), "");
    EXPECT_EQ(std::get<FramesetChoice>(*tcp->plugged).address, "[::1]:7000");
    for (const auto& [words, fragment] : std::vector<std::pair<const char*, const char*>>{
             {"pipe:", "needs a command that writes framesets"},
             {"pipe:  ", "needs a command that writes framesets"},
             {"tcp://", "right would be an address in numbers"},
             {"tcp://a.b:1", "right would be an address in numbers"}}) {
        const auto refused = read_live_camera(words);
        ASSERT_FALSE(refused) << words;
        EXPECT_EQ(refused.error().kind, ErrorKind::usage);
        EXPECT_NE(refused.error().message.find(fragment), std::string::npos) << refused.error().message;
    }
}

}  // namespace
}  // namespace touchable::test
