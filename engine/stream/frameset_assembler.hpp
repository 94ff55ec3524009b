#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "engine/clip/plane_role.hpp"

namespace touchable {

/// A decoded picture of a stream.
struct StreamPicture {
    PlaneRole role = PlaneRole::depth;
    std::int64_t number = 0;    ///< of the first frame that shows it
    std::int64_t frames = 1;    ///< that show it
    std::int64_t taken_ns = 0;  ///< of that frame, by the sender's clock; 0: not known
    Plane plane{};
    std::int64_t step = 1;  ///< frames from one that was sent to the next
};

/// Of its samples.
inline std::size_t bytes_of_plane(const PlaneView& plane) {
    return static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.height) *
           static_cast<std::size_t>(plane.channels * plane.bytes_per_sample);
}

/// What a stream's pictures may have: pixels each, and bytes all those together that wait for others.
inline constexpr std::int64_t most_stream_pixels = std::int64_t{1} << 24U;
inline constexpr std::size_t most_bytes_waiting = std::size_t{512} << 20U;

/// Planes of one frame. What is not there is empty.
struct WholeFrameset {
    std::int64_t number = 0, taken_ns = 0;
    std::array<Plane, all_roles.size()> planes{};  ///< by PlaneRole
};

/// What became of framesets, by cause.
struct FramesetCounts {
    std::int64_t whole = 0;           ///< given
    std::int64_t late = 0;            ///< whole once a later one had been given
    std::int64_t lost = 0;            ///< never whole
    std::int64_t torn = 0;            ///< likewise, because a checksum of theirs was wrong
    std::int64_t repeated = 0;        ///< pictures that came twice
    std::int64_t without_colour = 0;  ///< given with the colour of a frameset before, or none
    std::int64_t restarts = 0;        ///< numbers began anew
    std::array<std::int64_t, all_roles.size()> lost_of{};  ///< of those lost, by the first plane missing

    FramesetCounts& operator+=(const FramesetCounts& more) {
        whole += more.whole;
        late += more.late;
        lost += more.lost;
        torn += more.torn;
        repeated += more.repeated;
        without_colour += more.without_colour;
        restarts += more.restarts;
        for (std::size_t k = 0; k < lost_of.size(); ++k) lost_of[k] += more.lost_of[k];
        return *this;
    }
};

/// Makes framesets of pictures that come in any order, or not at all. A frameset is whole when all planes
/// that are felt are there, of its number and no other; colour may be that of a frame before. They are given
/// in order: what becomes whole behind a later one is late. Keeps 64 pictures of each plane, and 512 MiB of
/// all of them: the oldest ones go first.
class FramesetAssembler {
public:
    /// `roles`: those of the stream.
    explicit FramesetAssembler(const std::vector<PlaneRole>& roles);

    void add(StreamPicture picture);
    /// So many pictures of planes that are felt had a wrong checksum.
    void add_torn(std::int64_t pictures) { torn_ += pictures; }
    /// Nobody looks at colour: it is not waited for.
    void leave_out_colour() { has_colour_ = false; }
    /// No more will come: what waits for its colour does so no longer.
    void end();
    /// Numbers begin anew.
    void restart();
    /// The next whole one.
    std::optional<WholeFrameset> take();
    /// Whether there are pictures of a frame that is not whole.
    bool has_part() const;
    const FramesetCounts& counts() const { return counts_; }

private:
    struct Held {
        std::int64_t first = 0, end = 0, taken_ns = 0;
        Plane plane;
        std::int64_t step = 1;
    };
    using Roles = std::uint32_t;  // a bit for each
    /// A frameset that was not whole when a later one was given.
    struct Missed {
        Roles there = 0;
        std::optional<PlaneRole> first_missing;
        bool is_torn = false;  // as which it is counted, else as lost
    };
    /// Where numbers began anew: what was sent before may still come.
    struct Before {
        std::int64_t since_ns = 0, last = 0;
        int left = 0;  // pictures
    };
    enum class Anew { no, perhaps, yes };
    Anew begins_anew(const StreamPicture& picture) const;
    bool goes_on_from_doubtful(const StreamPicture& picture) const;
    void begin_anew(std::int64_t since_ns);
    void leave_doubtful();
    void admit(StreamPicture picture);
    bool is_of_before(const StreamPicture& picture);
    void add_late(const StreamPicture& picture);
    bool hold(StreamPicture&& picture);
    void drop_oldest();
    const Held* of(PlaneRole role, std::int64_t number) const;
    Roles there(std::int64_t number) const;
    bool has_its_colour(std::int64_t number) const;
    bool came_before_colour(std::int64_t number) const;
    void give_whole();
    void give(std::int64_t number);
    void count(const Missed& missed, std::int64_t by);
    void count_missing(std::int64_t next, std::int64_t step);
    void forget();

    Roles needed_ = 0;
    bool has_colour_ = false, colour_came_ = false, ended_ = false;
    int without_colour_in_a_row_ = 0;  // framesets
    bool is_full_ = false;             // of bytes, before the first colour came
    std::array<std::deque<Held>, all_roles.size()> held_;
    std::int64_t torn_ = 0;             // not counted yet
    std::optional<std::int64_t> last_;  // given
    std::int64_t last_step_ = 1;
    std::int64_t last_taken_ns_ = 0;
    Before before_;
    std::optional<StreamPicture> doubtful_;  // it may be the first of a sender that began again
    Plane newest_colour_;
    std::map<std::int64_t, Missed> missed_;
    std::deque<WholeFrameset> whole_;
    FramesetCounts counts_;
};

}  // namespace touchable
