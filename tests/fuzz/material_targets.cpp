// What is said of segments, and what a brush did to them: files that anybody may have written.
#include "engine/authoring/materials.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

bool parse_names(std::string_view bytes) {
    const auto names = parse_segment_names(bytes, "names");
    if (!names) return false;
    const std::string text = segment_names_to_json(*names);
    const auto again = parse_segment_names(text, "again");
    require(bool(again), "names that were written are refused");
    require(segment_names_to_json(*again) == text, "names come back as others");
    return true;
}

/// Four segments in three frames of 12 x 8 pixels; one goes to the right, and another comes late.
SegmentStore small_segments() {
    SegmentStore store(12, 8);
    for (int frame = 0; frame < 3; ++frame) {
        Segmentation segmentation{12, 8, {}, {}};
        for (int k = 0; k < 96; ++k) {
            const int x = k % 12, y = k / 12;
            const int label = y == 7                                    ? (frame == 2 ? 4 : 0)
                              : y > 4 && x > 2 + frame && x < 8 + frame ? 3
                              : x < 6                                   ? 1
                                                                        : 2;
            segmentation.labels.push_back(static_cast<std::uint16_t>(label));
        }
        for (std::uint16_t label = 1; label <= (frame == 2 ? 4 : 3); ++label)
            segmentation.segments.push_back({label, 20, {100, 80, 60}, 1, 1, 0});
        store.add(segmentation);
    }
    return store;
}

bool parse_history(std::string_view bytes) {
    auto brush = MaterialBrush::begin(small_segments());
    require(bool(brush), "a brush does not begin");
    if (!brush->repeat(bytes, "history")) return false;
    const std::string history = brush->history();
    auto again = MaterialBrush::begin(small_segments());
    require(bool(again->repeat(history, "again")), "a history that was written is refused");
    require(again->history() == history, "a history comes back as another");
    while (brush->undo()) continue;
    while (brush->redo()) continue;
    return true;
}

const Registered names_target{
    {.name = "segment_names", .parse = parse_names, .cuts_are_refused = true, .needless_bytes = 1}};
const Registered history_target{
    {.name = "brush_history", .parse = parse_history, .cuts_are_refused = true, .needless_bytes = 1}};

}  // namespace
}  // namespace touchable::fuzz
