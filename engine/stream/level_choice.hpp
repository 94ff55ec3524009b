#pragma once

#include <array>
#include <cstdint>

namespace touchable {

/// A segment of a stream, as it was fetched.
struct FetchedSegment {
    bool is_touch = true;          ///< of the planes that are felt; else of colour
    bool is_low = false;           ///< of the low level
    std::int64_t bytes = 0;        ///< 0: it could not be had
    std::int64_t fetch_ns = 0;     ///< that it took
    std::int64_t duration_ns = 0;  ///< of the stream
};

/// Which of a stream's two levels its link carries, full or low, judged as players of HLS do by how fast
/// segments come. The link's rate is the lesser of a quick and a slow running mean. Down when fetching a
/// segment, with its colour, took longer than it lasts, or the rate is below what the full level needs; up
/// again once four segments in a row left at least twice that rate.
class LevelChoice {
public:
    void add(const FetchedSegment& fetched);
    /// Colour is fetched no more.
    void leave_out_colour();
    bool is_low() const { return is_low_; }
    /// Bytes a second: of the link, 0 where nothing was fetched yet, and what a level was seen to need.
    double rate() const;
    double need(bool of_low) const;

private:
    using OfRenditions = std::array<double, 2>;  // touch, colour
    OfRenditions bytes_{}, seconds_{};           // of the newest segments
    std::array<OfRenditions, 2> needs_{};        // of the full and of the low level
    bool has_rate_ = false, is_low_ = false;
    double quick_ = 0, slow_ = 0;
    int good_ = 0;  // segments in a row
};

}  // namespace touchable
