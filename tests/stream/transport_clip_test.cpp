// MPEG-TS, received: as a clip, as a live source, over TCP, SRT and UDP.
#include <gtest/gtest.h>

#include <optional>
#include <thread>

#include "engine/picture/ffmpeg.hpp"
#include "engine/stream/receiving.hpp"
#include "engine/stream/sending.hpp"
#include "tests/stream/loopback_sender.hpp"
#include "tests/stream/srt_peer.hpp"
#include "tests/stream/stream_of_frames.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

StreamOfFrames make_transport_stream(const Scene& scene, int frames, const Planes& planes) {
    StreamOfFrames made;
    const auto muxer = make_mpegts_muxer(scene);
    EXPECT_EQ(message(muxer), "");
    for (int n = 0; n < frames; ++n) {
        made.frames.push_back(test_frame(scene, n, planes));
        const PictureLabel label{n, labelled_from_ns + n * labelled_step_ns};
        const auto block = (*muxer)->add(made.frames.back(), label, scene.rate.time_ns(n), n % 5 == 0);
        EXPECT_EQ(message(block), "");
        if (block) made.blocks.emplace_back(block->bytes.begin(), block->bytes.end());
    }
    return made;
}

/// Sends to a port of this machine, a packet of MPEG-TS at a time, until it has all or is not heard: by SRT
/// to whoever calls, or by FFmpeg's UDP.
class NetworkSender {
public:
    NetworkSender(bool is_srt, int port, std::shared_ptr<const StreamOfFrames> stream, int pause_ms)
        : thread_([this, is_srt, port, stream = std::move(stream), pause_ms] {
              std::optional<SrtPeer> srt;
              AVIOContext* io = nullptr;
              if (is_srt)
                  srt.emplace(SrtPeer::Kind::listens, port);
              else if (avio_open(&io, ("udp://127.0.0.1:" + std::to_string(port) + "?pkt_size=1316").c_str(),
                                 AVIO_FLAG_WRITE) < 0)
                  return;
              for (std::size_t n = 0; !stopping_ && n < stream->blocks.size(); ++n) {
                  const std::string& block = stream->blocks[n];
                  for (std::size_t at = 0; at < block.size(); at += 1316) {
                      const std::string piece = block.substr(at, 1316);
                      if (srt && !srt->say(piece)) return;
                      if (srt) continue;
                      avio_write(io, reinterpret_cast<const unsigned char*>(piece.data()),
                                 static_cast<int>(piece.size()));
                      avio_flush(io);
                  }
                  std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
              }
              if (srt) srt->wait_until_arrived();
              avio_close(io);
          }) {}
    ~NetworkSender() {
        stopping_ = true;
        thread_.join();
    }
    NetworkSender(const NetworkSender&) = delete;
    NetworkSender& operator=(const NetworkSender&) = delete;

private:
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

TEST(TransportClip, IsWhatWasSentToTheBit) {
    for (const Planes& planes : {all_planes, Planes{}, Planes{true, true, false}}) {
        const auto sent = make_transport_stream(small_scene(64, 48, 16), 17, planes);
        const LoopbackSender sender(sent.bytes());
        const auto clip = open_stream_clip(source_of(sender.url()));
        ASSERT_EQ(message(clip), "");
        EXPECT_EQ((*clip)->scene().name, "small");
        EXPECT_EQ((*clip)->tracks().size(), 1U + planes.colour + planes.haptic + planes.height);
        const auto frames = read_all(**clip);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), sent.frames.size());
        for (std::size_t n = 0; n < frames->size(); ++n)
            EXPECT_TRUE(is_as_sent((*frames)[n], sent.frames[n])) << n;
    }
}

TEST(TransportClip, LostPacketsAreHeldAndNeverMixed) {
    const auto sent = make_transport_stream(small_scene(64, 48, 16), 40, all_planes);
    for (std::uint64_t seed = 1; seed < 6; ++seed) {
        Numbers numbers(seed);
        std::string damaged = sent.blocks[0];
        for (std::size_t n = 1; n < sent.blocks.size(); ++n)
            for (std::size_t at = 0; at < sent.blocks[n].size(); at += 188)
                if (numbers.below(100) > 0) damaged += sent.blocks[n].substr(at, 188);
        const LoopbackSender sender(damaged);
        const auto clip = open_stream_clip(source_of(sender.url()));
        ASSERT_EQ(message(clip), "");
        while (true) {
            const auto frame = (*clip)->next();
            if (!frame || !*frame) break;
            std::size_t of = 0;
            while (of < sent.frames.size() && !is_as_sent(**frame, sent.frames[of])) ++of;
            ASSERT_LT(of, sent.frames.size()) << "planes of different frames";
            EXPECT_LE(static_cast<std::int64_t>(of), (*frame)->number);
        }
        EXPECT_FALSE((*clip)->remarks().empty());
    }
}

TEST(TransportClip, ComesBySrtAndUdp) {
    const auto sent = std::make_shared<const StreamOfFrames>(
        make_transport_stream(small_scene(64, 48, 16), 300, {true, true, false, false}));
    for (const std::string& scheme : {std::string("srt"), std::string("udp")}) {
        const int port = unused_port();
        const std::string address = scheme + "://127.0.0.1:" + std::to_string(port);
        const bool is_srt = scheme == "srt";
        const NetworkSender sender(is_srt, port, sent, 10);
        StreamSource source = source_of(address + (is_srt ? "?mode=caller&latency=20" : ""));
        source.patience.connection = std::chrono::seconds(20);
        const auto clip = open_stream_clip(source);
        ASSERT_EQ(message(clip), "") << scheme;
        for (int n = 0; n < 20; ++n) {
            const auto frame = (*clip)->next();
            ASSERT_EQ(message(frame), "") << scheme;
            ASSERT_TRUE(*frame);
            EXPECT_TRUE(std::any_of(sent->frames.begin(), sent->frames.end(),
                                    [&](const RawFrame& other) { return is_as_sent(**frame, other); }));
        }
    }
}

TEST(TransportClip, MatroskaComesBySrtToItsEnd) {
    auto made = make_stream(small_scene(64, 48, 16), 60, all_planes);
    made.blocks.insert(made.blocks.begin(), made.header);
    const auto sent = std::make_shared<const StreamOfFrames>(std::move(made));
    const int port = unused_port();
    const std::string address = "srt://127.0.0.1:" + std::to_string(port);
    const NetworkSender sender(true, port, sent, 2);
    StreamSource source = source_of(address + "?mode=caller&latency=20");
    source.patience.connection = std::chrono::seconds(20);
    const auto clip = open_stream_clip(source);
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    EXPECT_GE(frames->size(), 50U);
    for (std::size_t n = 0; n < frames->size(); ++n)
        EXPECT_TRUE(is_as_sent((*frames)[n], sent->frames[n])) << n;
}

TEST(TransportClip, IsTouchedLive) {
    const auto sent = std::make_shared<const StreamOfFrames>(
        make_transport_stream(small_scene(64, 48, 16), 300, {true, true, false, false}));
    const LoopbackSender sender([&](const LoopbackSender::Listener& to, int) {
        for (const std::string& block : sent->blocks)
            if (!to.send(block) || !to.wait(std::chrono::milliseconds(4))) return;
    });
    const auto clip = open_live_stream({.url = *read_stream_url(sender.url())});
    ASSERT_EQ(message(clip), "");
    ASSERT_EQ(message((*clip)->begin(std::chrono::steady_clock::now())), "");
    for (int n = 0; n < 10; ++n) {
        const auto frame = (*clip)->next();
        ASSERT_EQ(message(frame), "");
        ASSERT_TRUE(*frame);
    }
    EXPECT_EQ((*clip)->stream_figures()->torn, 0);
}

}  // namespace
}  // namespace touchable::test
