#pragma once

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "engine/stream/receiver.hpp"
#include "engine/stream/sending.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {

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
