#pragma once

#include <array>
#include <map>
#include <memory>

#include "engine/authoring/segments.hpp"

namespace touchable::test {

/// A segment for each of 8 x 8 x 8 colours, where there is depth: simple, and known beforehand.
class ColourSegments {
public:
    const Segmentation& next(const RawFrame& frame) {
        const PlaneView &colour = frame.colour, &depth = frame.depth;
        std::map<int, Segment> seen;
        std::map<int, std::array<std::int64_t, 3>> sums;
        frame_ = {colour.width, colour.height, {}, {}};
        for (int y = 0; y < colour.height; ++y)
            for (int x = 0; x < colour.width; ++x) {
                const int key = colour.sample(x, y, 0) / 32 * 64 + colour.sample(x, y, 1) / 32 * 8 +
                                colour.sample(x, y, 2) / 32;
                const bool is_hole = depth.sample(x, y) == 0;
                if (!is_hole) labels_.try_emplace(key, static_cast<std::uint16_t>(labels_.size() + 1));
                frame_.labels.push_back(is_hole ? std::uint16_t{0} : labels_[key]);
                if (is_hole) continue;
                Segment& segment = seen[labels_[key]];
                segment.label = labels_[key];
                ++segment.pixels;
                segment.x = x;
                segment.y = y;
                for (int c = 0; c < 3; ++c)
                    sums[segment.label][static_cast<std::size_t>(c)] += colour.sample(x, y, c);
            }
        for (auto& [label, segment] : seen) {
            for (std::size_t c = 0; c < 3; ++c)
                segment.colour[c] = static_cast<std::uint8_t>(sums[label][c] / segment.pixels);
            frame_.segments.push_back(segment);
        }
        return frame_;
    }
    static SegmentFrames begin(const Scene&) {
        auto segments = std::make_shared<ColourSegments>();
        return
            [segments](const RawFrame& frame, bool) -> const Segmentation& { return segments->next(frame); };
    }

private:
    std::map<int, std::uint16_t> labels_;  // by colour, as they came
    Segmentation frame_;
};

}  // namespace touchable::test
