#pragma once

#include <string>
#include <vector>

#include "engine/authoring/segments.hpp"

namespace touchable::test {

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
