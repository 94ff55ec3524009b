#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/stream/labelled_codec.hpp"
#include "engine/stream/receiver.hpp"
#include "engine/stream/sending.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

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
            auto opened = LabelledEncoder::open(clip.frames[0], scene, TrackCoding::h264_quick);
            EXPECT_EQ(message(opened), "");
            encoder.emplace(std::move(*opened));
            for (std::size_t k = 0; k < encoder->tracks(); ++k) {
                AVStream* const stream = avformat_new_stream(clip.streams.get(), nullptr);
                EXPECT_EQ(message(encoder->describe(k, *stream->codecpar)), "");
                stream->time_base = {1, 1000};
            }
        }
        auto packets = encoder->encode(clip.frames.back(), sent_label(n), n % keys_apart == 0);
        EXPECT_EQ(message(packets), "");
        for (const auto& packet : *packets) packet->pts = packet->dts = 33 * n;
        clip.packets.push_back(std::move(*packets));
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

    std::string bytes() const {
        std::string all = header;
        for (const std::string& block : blocks) all += block;
        return all;
    }
};

inline constexpr std::int64_t labelled_from_ns = 1'700'000'000'000'000'000, labelled_step_ns = 33'333'333;

/// Frame n has number first + n. Every fifth is a key. Frames of a number in `without_colour` go without it,
/// as a narrow link gets them.
inline StreamOfFrames make_stream(const Scene& scene, int frames, const Planes& planes,
                                  std::int64_t first = 0, const std::set<int>& without_colour = {}) {
    StreamOfFrames made;
    auto muxer = open_matroska_stream(scene);
    EXPECT_EQ(message(muxer), "");
    if (!muxer) return made;
    const auto text = [](const auto& bytes) { return std::string(bytes.begin(), bytes.end()); };
    for (int n = 0; n < frames; ++n) {
        made.frames.push_back(test_frame(scene, n, planes));
        const PictureLabel label{first + n, labelled_from_ns + (first + n) * labelled_step_ns};
        const auto block = (*muxer)->add(made.frames.back(), label, scene.rate.time_ns(n), n % 5 == 0);
        EXPECT_EQ(message(block), "");
        if (!block) return made;
        if (n == 0) made.header = text((*muxer)->header());
        made.blocks.push_back(text(block->given(!without_colour.contains(n))));
    }
    return made;
}

/// All that is felt as it was sent, and colour where there was any.
inline bool is_as_sent(const RawFrame& frame, const RawFrame& sent) {
    return same_touch_planes(frame, sent) && frame.colour.empty() == sent.colour.empty();
}

inline StreamSource source_of(const std::string& url) {
    StreamSource source;
    const auto read = read_stream_url(url);
    EXPECT_EQ(message(read), "");
    if (read) source.url = *read;
    return source;
}

}  // namespace touchable::test
