// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/input.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "engine/stream/receiver.hpp"
#include "engine/stream/sending.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

inline constexpr std::int64_t a_second_ns = 1'000'000'000;

inline PictureLabel sent_label(std::int64_t number) {
    return {1000 + number, 1'700'000'000'000'000'000 + number * 33'000'000};
}

/// Packets of a clip, as an encoder gives them, and what tells a decoder of its tracks.
struct LabelledClip {
    struct StreamCloser {
        void operator()(AVFormatContext* context) const { avformat_free_context(context); }
    };
    std::unique_ptr<AVFormatContext, StreamCloser> streams{avformat_alloc_context()};
    std::vector<std::vector<PacketPtr>> packets;  // of each frame, by track
    std::vector<RawFrame> frames;

    std::size_t tracks() const { return streams->nb_streams; }
};

inline LabelledClip labelled_clip(const Scene& scene, int frames, const Planes& planes, int keys_apart = 4) {
    LabelledClip clip;
    std::optional<LabelledEncoder> encoder;
    for (int n = 0; n < frames; ++n) {
        clip.frames.push_back(test_frame(scene, n, planes));
        if (!encoder) {
            encoder.emplace(must(LabelledEncoder::open(clip.frames[0], scene, TrackCoding::h264_quick)));
            for (std::size_t k = 0; k < encoder->tracks(); ++k) {
                AVStream* const stream = avformat_new_stream(clip.streams.get(), nullptr);
                EXPECT_EQ(message(encoder->describe(k, *stream->codecpar)), "");
                stream->time_base = {1, 1000};
            }
        }
        auto packets = must(encoder->encode(clip.frames.back(), sent_label(n), n % keys_apart == 0));
        for (const auto& packet : packets) packet->pts = packet->dts = 33 * n;
        clip.packets.push_back(std::move(packets));
    }
    return clip;
}

inline LabelledDecoder decoder_for(const LabelledClip& clip) {
    LabelledDecoder decoder(1 << 22);
    for (std::size_t k = 0; k < clip.tracks(); ++k)
        EXPECT_EQ(message(decoder.add_track(*clip.streams->streams[k], "clip")), "");
    return decoder;
}

/// Which plane of which frame came, and how often.
using Came = std::map<std::pair<PlaneRole, std::int64_t>, int>;

/// Every plane of touch must be that of its frame.
inline void take_pictures(const std::vector<LabelledPicture>& pictures, const std::vector<RawFrame>& frames,
                          Came& came) {
    for (const LabelledPicture& picture : pictures) {
        const std::int64_t number = picture.label.frame - sent_label(0).frame;
        ASSERT_GE(number, 0);
        ASSERT_LT(number, static_cast<std::int64_t>(frames.size()));
        const PlaneView& sent = plane_of(frames[static_cast<std::size_t>(number)], picture.role);
        EXPECT_EQ(picture.label, sent_label(number));
        if (picture.role != PlaneRole::colour)
            EXPECT_TRUE(same_plane(picture.plane.view, sent))
                << role_name(picture.role) << ", frame " << number;
        else
            EXPECT_EQ(picture.plane.view.width, sent.width);
        ++came[{picture.role, number}];
    }
}

/// A stream of test frames, as its listeners get it.
struct StreamOfFrames {
    std::string header;
    std::vector<std::string> blocks;
    std::vector<RawFrame> frames;

    /// As a listener has it that was there from a block on.
    std::string bytes(std::size_t from = 0) const {
        std::string all = header;
        for (; from < blocks.size(); ++from) all += blocks[from];
        return all;
    }
};

inline constexpr std::int64_t labelled_from_ns = 1'700'000'000'000'000'000, labelled_step_ns = 33'333'333;

inline PictureLabel stream_label(std::int64_t number) {
    return {number, labelled_from_ns + number * labelled_step_ns};
}

struct StreamMaking {
    int keys_apart = 5;
    std::function<PictureLabel(std::int64_t)> label = stream_label;
    std::set<int> without_colour{};     ///< these go without it, as a narrow link gets them
    std::vector<std::int64_t> times{};  ///< of the frames; empty: the scene's
};

inline StreamOfFrames stream_by(Result<std::unique_ptr<StreamMuxer>> opened, const Scene& scene, int frames,
                                const Planes& planes, const StreamMaking& making = {}) {
    const auto muxer = must(std::move(opened));
    const auto text = [](const auto& bytes) { return std::string(bytes.begin(), bytes.end()); };
    StreamOfFrames made{{}, {}, test_frames(scene, frames, planes)};
    for (int n = 0; n < frames; ++n) {
        const auto at = static_cast<std::size_t>(n);
        const bool is_key = n % making.keys_apart == 0;
        const std::int64_t time_ns = making.times.empty() ? scene.rate.time_ns(n) : making.times[at];
        const auto block = must(muxer->add(made.frames[at], making.label(n), time_ns, is_key));
        EXPECT_EQ(block.frame, making.label(n).frame);
        EXPECT_EQ(block.is_key, is_key);
        if (n == 0) made.header = text(muxer->header());
        made.blocks.push_back(text(block.given(!making.without_colour.contains(n))));
    }
    return made;
}

/// Frame n has number first + n.
inline StreamOfFrames make_stream(const Scene& scene, int frames, const Planes& planes,
                                  std::int64_t first = 0, const std::set<int>& without_colour = {}) {
    const auto label = [first](std::int64_t n) { return stream_label(first + n); };
    return stream_by(open_matroska_stream(scene), scene, frames, planes,
                     {.label = label, .without_colour = without_colour});
}

inline StreamOfFrames make_transport_stream(const Scene& scene, int frames, const Planes& planes,
                                            const StreamMaking& making = {}) {
    return stream_by(make_mpegts_muxer(scene), scene, frames, planes, making);
}

/// What FFmpeg's demuxer and our decoder make of bytes that have labels of `sent_label`.
struct DemuxedPictures {
    Came came;
    std::int64_t damaged = 0;
    int tracks = 0, sounds = 0;
};

inline DemuxedPictures demuxed(const std::string& bytes, const char* format,
                               const std::vector<RawFrame>& frames) {
    DemuxedPictures all;
    const auto input = must(open_input(bytes_in_memory(bytes), bytes.size(), "stream", {.format = format}));
    LabelledDecoder decoder(1 << 22);
    std::map<int, std::size_t> tracks;
    const PacketPtr packet(av_packet_alloc());
    for (; av_read_frame(input.get(), packet.get()) >= 0; av_packet_unref(packet.get())) {
        const AVStream& stream = *input->streams[packet->stream_index];
        all.sounds += stream.codecpar->codec_type == AVMEDIA_TYPE_AUDIO;
        if (stream.codecpar->codec_id != AV_CODEC_ID_H264) continue;
        if (!tracks.contains(stream.index)) tracks[stream.index] = *decoder.add_track(stream, "stream");
        take_pictures(must(decoder.add(tracks[stream.index], *packet)), frames, all.came);
    }
    take_pictures(must(decoder.end()), frames, all.came);
    all.damaged = decoder.damaged();
    all.tracks = static_cast<int>(tracks.size());
    return all;
}

/// All that is felt as it was sent, and colour where there was any.
inline bool is_as_sent(const RawFrame& frame, const RawFrame& sent) {
    return same_touch_planes(frame, sent) && frame.colour.empty() == sent.colour.empty();
}

inline void expect_as_sent(const std::vector<RawFrame>& read, const std::vector<RawFrame>& sent) {
    ASSERT_EQ(read.size(), sent.size());
    for (std::size_t n = 0; n < read.size(); ++n) {
        EXPECT_EQ(read[n].number, static_cast<std::int64_t>(n));
        EXPECT_EQ(read[n].time_ns, sent[n].time_ns);
        EXPECT_TRUE(is_as_sent(read[n], sent[n])) << n;
    }
}

inline StreamSource source_of(const std::string& url) {
    return {.url = must(read_stream_url(url))};
}

}  // namespace touchable::test
