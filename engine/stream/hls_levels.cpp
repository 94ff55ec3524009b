#include "engine/stream/hls_levels.hpp"

#include <utility>

#include "engine/base/try.hpp"

namespace touchable {

Result<std::unique_ptr<HlsLevels>> HlsLevels::open(HlsLevelPlaces places, bool is_touch, WaitIsOver is_over,
                                                   HlsHosts hosts, std::shared_ptr<HlsLevelReading> reading,
                                                   std::optional<std::string> text) {
    std::unique_ptr<HlsLevels> levels(
        new HlsLevels(std::move(places), is_touch, std::move(is_over), hosts, std::move(reading)));
    HlsSegmentWatch* const watch = levels->reading_ ? &levels->watches_[0] : nullptr;
    TRY_ASSIGN(auto full, HlsRendition::open(levels->places_.full, levels->is_over_, hosts,
                                             {.text = std::move(text), .watch = watch}));
    levels->read_ = std::move(full);
    return levels;
}

/// Asked by the rendition that is read, in the middle of its reading: it is given up in `peek`.
bool HlsLevels::goes_over_before(std::int64_t number, bool from_low) {
    const bool to_low = reading_->choice.is_low();
    if (is_opening_ || next_ || to_low == from_low) return false;
    is_opening_ = true;
    auto other = HlsRendition::open(to_low ? places_.low : places_.full, is_over_, hosts_,
                                    {.from = number, .watch = &watches_[to_low ? 1 : 0]});
    is_opening_ = false;
    if (other) next_ = std::move(*other);
    return next_ != nullptr;
}

void HlsLevels::note(FetchedSegment segment, bool is_low) {
    segment.is_touch = is_touch_;
    segment.is_low = is_low;
    if (segment.bytes > 0) fetched_ns_[is_low ? 1 : 0] += segment.duration_ns;
    reading_->choice.add(segment);
}

Result<const AVPacket*> HlsLevels::peek() {
    auto packet = read_->peek();
    if (!packet || *packet || !next_) return packet;
    lost_before_ += read_->segments_lost();
    read_ = std::move(next_);
    is_low_ = !is_low_;
    ++changes_;
    return read_->peek();
}

}  // namespace touchable
