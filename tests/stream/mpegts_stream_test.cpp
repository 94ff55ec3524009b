#include "engine/stream/sending.hpp"

#include <gtest/gtest.h>

#include <string_view>

#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/input.hpp"
#include "tests/stream/labelled_stream.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr int keys_apart = 5;

struct TransportStream {
    std::vector<StreamMuxer::Block> blocks;
    std::vector<RawFrame> frames;
    std::string bytes_from(std::size_t block) const {
        std::string all;
        for (; block < blocks.size(); ++block)
            all.append(blocks[block].bytes.begin(), blocks[block].bytes.end());
        return all;
    }
};

TransportStream transport_stream(int frames, const Planes& planes) {
    const Scene scene = small_scene(64, 48, 16);
    const auto muxer = make_mpegts_muxer(scene);
    TransportStream stream;
    for (int n = 0; n < frames; ++n) {
        stream.frames.push_back(test_frame(scene, n, planes));
        auto block =
            (*muxer)->add(stream.frames.back(), sent_label(n), scene.rate.time_ns(n), n % keys_apart == 0);
        EXPECT_EQ(message(block), "");
        EXPECT_EQ(block->frame, sent_label(n).frame);
        stream.blocks.push_back(std::move(*block));
    }
    EXPECT_TRUE((*muxer)->header().empty());
    return stream;
}

/// What FFmpeg's demuxer and our decoder make of it.
struct Received {
    Came came;
    PictureFaults faults;
    int first_width = 0, tracks = 0;
};

Received received(const std::string& bytes, const std::vector<RawFrame>& frames) {
    Received all;
    auto input = open_input(bytes_in_memory(bytes), bytes.size(), "stream", {.format = "mpegts"});
    EXPECT_EQ(message(input), "");
    if (!input) return all;
    LabelledDecoder decoder(1 << 22);
    std::map<int, std::size_t> tracks;
    const PacketPtr packet(av_packet_alloc());
    while (av_read_frame(input->get(), packet.get()) >= 0) {
        const AVStream& stream = *(*input)->streams[packet->stream_index];
        if (stream.codecpar->codec_id == AV_CODEC_ID_H264) {
            if (!tracks.contains(stream.index)) tracks[stream.index] = *decoder.add_track(stream, "stream");
            auto pictures = decoder.add(tracks[stream.index], *packet);
            EXPECT_EQ(message(pictures), "");
            take_pictures(*pictures, frames, all.came);
        }
        av_packet_unref(packet.get());
    }
    auto rest = decoder.end();
    EXPECT_EQ(message(rest), "");
    take_pictures(*rest, frames, all.came);
    all.faults = decoder.faults();
    all.tracks = static_cast<int>(tracks.size());
    return all;
}

TEST(MpegtsStream, BlocksAreWholePackets) {
    const TransportStream stream = transport_stream(11, all_planes);
    for (std::size_t n = 0; n < stream.blocks.size(); ++n) {
        const StreamMuxer::Block& block = stream.blocks[n];
        EXPECT_EQ(block.is_key, n % keys_apart == 0);
        ASSERT_FALSE(block.bytes.empty());
        ASSERT_EQ(block.bytes.size() % 188, 0U);
        for (std::size_t at = 0; at < block.bytes.size(); at += 188) ASSERT_EQ(block.bytes[at], 0x47);
    }
}

TEST(MpegtsStream, StockDemuxerGivesTheSamePlanes) {
    const TransportStream stream = transport_stream(11, {true, true, false, false});
    const Received all = received(stream.bytes_from(0), stream.frames);
    EXPECT_EQ(all.tracks, 4);
    EXPECT_EQ(all.came.size(), 3U * 11U);
    EXPECT_EQ(all.faults.all(), 0);
}

TEST(MpegtsStream, BeginsAtAnyKeyBlock) {
    const TransportStream stream = transport_stream(11, {true, true, false, false});
    const Received all = received(stream.bytes_from(keys_apart), stream.frames);
    EXPECT_EQ(all.came.size(), 3U * 6U);
    for (const auto& [which, count] : all.came) EXPECT_GE(which.second, keys_apart);
    EXPECT_EQ(all.faults.all(), 0);
}

/// As UDP loses and reorders them: planes are those that were sent, whatever came between.
TEST(MpegtsStream, LostPacketsNeverGiveOtherSamples) {
    const TransportStream stream = transport_stream(20, {true, true, false, false});
    const std::string whole = stream.bytes_from(0);
    std::size_t fewest = 1000;
    for (std::uint64_t seed = 0; seed < 150; seed += sweep_step()) {
        Numbers numbers(seed);
        std::string damaged;
        for (std::size_t at = 0; at < whole.size(); at += 188)
            if (numbers.below(50) > 0) damaged += whole.substr(at, 188);
        fewest = std::min(fewest, received(damaged, stream.frames).came.size());
    }
    EXPECT_LT(fewest, 40U);
}

}  // namespace
}  // namespace touchable::test
