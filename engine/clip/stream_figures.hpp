#pragma once

#include <cstdint>
#include <optional>

namespace touchable {

/// What is known of a connection's datagrams, at either end.
struct LinkFigures {
    double rtt_ms = 0;            ///< the way there and back, now
    std::int64_t datagrams = 0;   ///< with a part of the stream, those that were sent again included
    std::int64_t lost = 0;        ///< known to be lost; one that is lost twice counts twice
    std::int64_t sent_again = 0;  ///< because they were lost
};

/// Which level of a stream in segments was read, full or low.
struct LevelFigures {
    double full_s = 0, low_s = 0;  ///< of the stream
    std::int64_t changes = 0;      ///< from one to the other
    bool is_low = false;           ///< now
};

/// What became of the framesets of a live stream, and how it was.
struct StreamFigures {
    std::int64_t whole = 0;     ///< received with all planes that are felt
    std::int64_t held = 0;      ///< in place of which the one before was felt on: those below
    std::int64_t late = 0;      ///< whole only once a later one had been shown
    std::int64_t lost = 0;      ///< never whole, or overdue while nothing whole comes
    std::int64_t torn = 0;      ///< damaged
    std::int64_t repeated = 0;  ///< pictures that came twice
    std::int64_t connections = 0;
    double delay_ms = 0;                   ///< that framesets wait for others' sake, now
    double longest_gap_ms = 0;             ///< between two that were whole
    std::optional<LinkFigures> link{};     ///< of the newest connection, where its transport counts (SRT)
    std::optional<LevelFigures> levels{};  ///< where the stream has two
};

}  // namespace touchable
