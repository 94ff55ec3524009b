// Streams in the program: what is touched of one is what is touched of its file.
#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tests/clip/clip_fixture.hpp"
#include "tests/player/touched_camera.hpp"
#include "tests/stream/loopback_sender.hpp"

namespace touchable::test {
namespace {

class StreamedClip : public TouchedCamera {
protected:
    StreamedClip() {
        const Outcome made = run_touchable({"make", "moving", clip, "--size", "64x48", "--frames", "30"});
        EXPECT_EQ(made.code, 0) << made.err;
        bytes = read_bytes(clip);
    }
    /// A web server with that one file, of which it gives parts.
    std::unique_ptr<LoopbackSender> web_server() const {
        return std::make_unique<LoopbackSender>([this](const LoopbackSender::Listener& to, int) {
            const std::string asked = to.request();
            std::size_t from = 0;
            if (const auto range = asked.find("Range: bytes="); range != std::string::npos)
                from = std::stoul(asked.substr(range + 13));
            const std::string size = std::to_string(bytes.size());
            (void)to.send("HTTP/1.1 206 Partial Content\r\nAccept-Ranges: bytes\r\nContent-Range: bytes " +
                          std::to_string(from) + "-" + std::to_string(bytes.size() - 1) + "/" + size +
                          "\r\nContent-Length: " + std::to_string(bytes.size() - from) +
                          "\r\nConnection: close\r\n\r\n" + bytes.substr(from));
        });
    }
    /// As often as somebody connects, in pieces, over and over.
    std::unique_ptr<LoopbackSender> paced_sender() const {
        return std::make_unique<LoopbackSender>([this](const LoopbackSender::Listener& to, int) {
            constexpr std::size_t pieces = 60;
            for (std::size_t at = 0; at < bytes.size(); at += bytes.size() / pieces)
                if (!to.send(std::string_view(bytes).substr(at, bytes.size() / pieces)) ||
                    !to.wait(std::chrono::milliseconds(5)))
                    return;
        });
    }

    const std::string clip = folder / "moving.mkv";
    std::string bytes;
};

TEST_F(StreamedClip, FeelsAsItsFileDoes) {
    const auto felt = touch({clip, "--fingers", "2"});
    const LoopbackSender sender(bytes);
    const auto server = web_server();
    for (const std::string& url : {sender.url(), server->url("http", "/moving.mkv")}) {
        const auto streamed = touch({url, "--fingers", "2"});
        EXPECT_EQ(streamed["force_hash"], felt["force_hash"]) << url;
        EXPECT_EQ(streamed["clip"], url);
        EXPECT_TRUE(streamed["warnings"].empty() || streamed["warnings"] == felt["warnings"]);
        const Outcome info = run_touchable({"info", url});
        EXPECT_EQ(info.code, 0) << info.err;
        EXPECT_EQ(info.out.find(url), 0U) << info.out;
        const std::string saved = folder / "saved.mkv";
        const Outcome converted = run_touchable({"convert", url, saved, "--overwrite"});
        EXPECT_EQ(converted.code, 0) << converted.err;
        EXPECT_EQ(touch({saved, "--fingers", "2"})["force_hash"], felt["force_hash"]) << url;
    }
}

TEST_F(StreamedClip, ALiveRunReplaysToItsHashWithoutIt) {
    std::string url;
    nlohmann::json lived;
    {
        const auto sender = paced_sender();
        url = sender->url();
        lived = touch({"--live", url, "--seconds", "2", "--hand", "press", "--fingers", "2", "--latency",
                       "50", "--record", record});
    }
    EXPECT_EQ(lived["camera"], "stream:" + url);
    EXPECT_GT(lived["frames_shown"], 0) << said;
    EXPECT_GT(lived["contact_ticks"], 0) << said;
    EXPECT_GT(lived["stream"]["whole"], 0);
    EXPECT_EQ(lived["stream"]["torn"], 0);
    EXPECT_LE(lived["stream"]["delay_ms"], 50);
    EXPECT_NE(said.find("framesets whole"), std::string::npos) << said;
    const auto again = touch({"--replay", record, "--builder", "reference"});
    EXPECT_EQ(again["force_hash"], lived["force_hash"]);
    EXPECT_EQ(said.find("not the recorded ones"), std::string::npos) << said;
}

TEST_F(StreamedClip, AFileOnAServerIsAClipAlsoInALiveRun) {
    const auto server = web_server();
    const auto lived = touch({"--live", server->url("http", "/moving.mkv"), "--seconds", "0.3"});
    EXPECT_FALSE(lived.contains("camera"));
    EXPECT_TRUE(lived.contains("late_frames"));
}

TEST_F(StreamedClip, WhatWillNotDoIsRefused) {
    const LoopbackSender sender(bytes);
    for (const auto& [words, code, fragment] : std::vector<std::tuple<Words, int, std::string>>{
             {{"touch", clip, "--latency", "5"}, 2, "--latency is for a stream"},
             {{"touch", "--live", sender.url(), "--latency", "0"}, 2, "1 to 5000"},
             {{"touch", "tcp://127.0.0.1"}, 2, "HOST:PORT"},
             {{"touch", "--live", "srt://127.0.0.1:1?key=1"}, 2, "has no setting"},
             {{"touch", sender.url(), "--fov", "60"}, 2, "has its scene in it"},
             {{"touch", "--live", sender.url(), "--fov", "60"}, 2, "has its scene in it"},
             {{"info", "pipe:77"}, 3, "no open descriptor 77"}}) {
        const Outcome outcome = run_touchable(words);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(fragment), std::string::npos) << outcome.err;
    }
}

TEST_F(StreamedClip, OneThatIsSilentKeepsNobodyFromEnding) {
    const LoopbackSender silent(
        [](const LoopbackSender::Listener& to, int) { (void)to.wait(std::chrono::hours(1)); });
    for (const Words& words : {Words{"touch", silent.url()}, Words{"touch", "--live", silent.url()}}) {
        const Outcome ended = run_interrupted_at_once(words);
        EXPECT_EQ(ended.code, 130) << ended.err;
        EXPECT_TRUE(ended.one_line_of_error()) << ended.err;
    }
}

}  // namespace
}  // namespace touchable::test
