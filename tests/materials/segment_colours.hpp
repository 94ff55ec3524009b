// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/authoring/segments.hpp"
#include "tests/must.hpp"

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

/// Segments as letters: 'a' is label 1, 'b' 2, '.' a hole. Rows of one length.
inline Segmentation drawn(const std::vector<std::string>& rows) {
    Segmentation frame{static_cast<int>(rows.front().size()), static_cast<int>(rows.size()), {}, {}};
    std::vector<Segment> by_label(27);
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) {
            const char letter = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
            const auto label = static_cast<std::uint16_t>(letter == '.' ? 0 : letter - 'a' + 1);
            frame.labels.push_back(label);
            Segment& segment = by_label[label];
            segment.label = label;
            segment.x = x;
            segment.y = y;
            ++segment.pixels;
            segment.colour = {static_cast<std::uint8_t>(30 * label), 100, 60};
        }
    for (const Segment& segment : by_label)
        if (segment.label != 0) frame.segments.push_back(segment);
    return frame;
}

/// Back to letters.
inline std::vector<std::string> drawing(const SegmentStore& store, std::int64_t frame) {
    std::vector<std::uint16_t> labels;
    store.read_labels(frame, labels);
    std::vector<std::string> rows(static_cast<std::size_t>(store.height()));
    for (std::size_t k = 0; k < labels.size(); ++k)
        rows[k / static_cast<std::size_t>(store.width())] +=
            labels[k] == 0 ? '.' : static_cast<char>('a' + labels[k] - 1);
    return rows;
}

inline SegmentStore stored(const std::vector<std::vector<std::string>>& frames) {
    const Segmentation first = drawn(frames.front());
    SegmentStore store(first.width, first.height);
    for (const auto& frame : frames) store.add(drawn(frame));
    return store;
}

}  // namespace touchable::test
