#pragma once

// A rendition of HlsInput in both levels, for this room's .cpp files only.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "engine/stream/hls_rendition.hpp"
#include "engine/stream/level_choice.hpp"

namespace touchable {

/// What both renditions of a stream are read by: the level, and the clock by which it is chosen.
struct HlsLevelReading {
    LevelChoice choice;
    std::function<std::int64_t()> now_ns;
};

/// Where a rendition's media playlists are.
struct HlsLevelPlaces {
    std::string full, low;  ///< low: empty where there is none
};

/// One rendition, full or low as `reading` chooses. It goes over at a segment's beginning, once the other
/// level is open there; where that cannot be had, it stays, and tries again before the next segment.
class HlsLevels {
public:
    /// `reading`: null: the full level alone. `text`: of the full level's playlist, where it was fetched.
    static Result<std::unique_ptr<HlsLevels>> open(HlsLevelPlaces places, bool is_touch, WaitIsOver is_over,
                                                   HlsHosts hosts, std::shared_ptr<HlsLevelReading> reading,
                                                   std::optional<std::string> text = {});
    HlsLevels(const HlsLevels&) = delete;
    HlsLevels& operator=(const HlsLevels&) = delete;

    /// As HlsRendition has them.
    Result<const AVPacket*> peek();
    PacketPtr take() { return read_->take(); }
    const AVStream& stream_of(const AVPacket& packet) const { return read_->stream_of(packet); }
    std::int64_t time_ns(const AVPacket& packet) const { return read_->time_ns(packet); }
    bool has_ended() const { return read_->has_ended(); }
    std::int64_t segments_lost() const { return lost_before_ + read_->segments_lost(); }

    /// The level of the packet that `peek` gave.
    bool is_low() const { return is_low_; }
    std::int64_t changes() const { return changes_; }
    /// So much of the stream was fetched of a level.
    std::int64_t fetched_ns(bool of_low) const { return fetched_ns_[of_low ? 1 : 0]; }

private:
    struct Watch final : HlsSegmentWatch {
        Watch(HlsLevels& levels, bool low) : of(levels), is_low(low) {}
        bool ends_before(std::int64_t number) override { return of.goes_over_before(number, is_low); }
        void fetched(const FetchedSegment& segment) override { of.note(segment, is_low); }
        std::int64_t now_ns() const override { return of.reading_->now_ns(); }
        HlsLevels& of;
        const bool is_low;
    };
    HlsLevels(HlsLevelPlaces places, bool is_touch, WaitIsOver is_over, HlsHosts hosts,
              std::shared_ptr<HlsLevelReading> reading)
        : places_(std::move(places)),
          is_touch_(is_touch),
          is_over_(std::move(is_over)),
          hosts_(hosts),
          reading_(places_.low.empty() ? nullptr : std::move(reading)) {}
    bool goes_over_before(std::int64_t number, bool from_low);
    void note(FetchedSegment segment, bool is_low);

    const HlsLevelPlaces places_;
    const bool is_touch_;
    const WaitIsOver is_over_;
    const HlsHosts hosts_;
    const std::shared_ptr<HlsLevelReading> reading_;
    Watch watches_[2]{{*this, false}, {*this, true}};
    std::unique_ptr<HlsRendition> read_, next_;  // next_: of the other level, which follows
    bool is_low_ = false, is_opening_ = false;
    std::int64_t changes_ = 0, lost_before_ = 0, fetched_ns_[2]{};
};

}  // namespace touchable
