// SPDX-License-Identifier: Apache-2.0
#pragma once

// From pictures to framesets: FramesetAssembler puts them together, and StreamReceiver is one connection to a
// sender. stream_clip.cpp and live_stream.cpp pass on what is received.

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/stream/stream_bytes.hpp"
#include "engine/stream/stream_pictures.hpp"

namespace touchable {

/// The planes of one frame. A plane that was not received is empty.
struct WholeFrameset {
    std::int64_t number = 0, taken_ns = 0;
    std::array<Plane, all_roles.size()> planes{};  ///< by PlaneRole
};

/// Counts of framesets by outcome.
struct FramesetCounts {
    std::int64_t whole = 0;           ///< returned
    std::int64_t late = 0;            ///< whole only after a later one was returned
    std::int64_t lost = 0;            ///< never whole
    std::int64_t torn = 0;            ///< never whole, because a picture was damaged
    std::int64_t repeated = 0;        ///< pictures that came twice
    std::int64_t without_colour = 0;  ///< returned with the colour of a frameset before, or none
    std::int64_t restarts = 0;        ///< times that numbers began anew

    FramesetCounts& operator+=(const FramesetCounts& more) {
        using Counts = FramesetCounts;
        for (const auto count : {&Counts::whole, &Counts::late, &Counts::lost, &Counts::torn,
                                 &Counts::repeated, &Counts::without_colour, &Counts::restarts})
            this->*count += more.*count;
        return *this;
    }
};

/// Makes framesets of pictures that come in any order, or not at all. A frameset is whole when all touch
/// planes with its number are there; its colour may be that of a frame before. Framesets are returned in
/// order: one that becomes whole after a later one was returned is late. Keeps 64 pictures of each plane, and
/// 512 MiB of all of them; the oldest are dropped first.
class FramesetAssembler {
public:
    /// `roles`: planes of the stream.
    explicit FramesetAssembler(const std::vector<PlaneRole>& roles) {
        for (const PlaneRole role : roles)
            if (role == PlaneRole::colour)
                has_colour_ = true;
            else
                needed_ |= bit_of(role);
    }

    void add(StreamPicture picture);
    /// Adds to the number of damaged touch pictures.
    void add_torn(std::int64_t pictures) { torn_ += pictures; }
    /// Framesets no longer wait for their colour.
    void leave_out_colour() { has_colour_ = false; }
    /// To be called after the last picture: framesets no longer wait for their colour.
    void end() {
        ended_ = true;
        leave_doubtful();
        give_whole();
    }
    /// To be called when numbers begin anew.
    void restart();
    /// The next whole frameset; nothing: there is none yet.
    std::optional<WholeFrameset> take() {
        if (whole_.empty()) return std::nullopt;
        WholeFrameset frameset = std::move(whole_.front());
        whole_.pop_front();
        return frameset;
    }
    /// Whether there are pictures of a frame that is not whole.
    bool has_part() const {
        for (const PlaneRole role : all_roles)
            for (const Held& held : held_[index_of(role)])
                if ((needed_ & bit_of(role)) != 0 && (!last_ || held.end > *last_ + 1)) return true;
        return false;
    }
    const FramesetCounts& counts() const { return counts_; }

private:
    static constexpr int most_of_before = 256;
    /// A number farther behind or ahead belongs to another count.
    static constexpr std::int64_t most_behind = 64, most_ahead = 1'000'000;

    static constexpr std::size_t index_of(PlaneRole role) { return static_cast<std::size_t>(role); }
    static constexpr std::uint32_t bit_of(PlaneRole role) { return std::uint32_t{1} << index_of(role); }

    struct Held {
        std::int64_t first = 0, end = 0, taken_ns = 0;
        Plane plane;
        std::int64_t step = 1;
    };
    using Roles = std::uint32_t;  // a bit for each
    /// A frameset that was not whole when a later one was returned.
    struct Missed {
        Roles there = 0;
        bool is_torn = false;  // counted as torn; else as lost
    };
    /// The count before numbers began anew: its pictures may still come.
    struct Before {
        std::int64_t since_ns = 0, last = 0;
        int left = 0;  // pictures that are still checked
    };
    enum class Anew { no, perhaps, yes };
    Anew begins_anew(const StreamPicture& picture) const {
        if (!last_) return Anew::no;
        if (picture.number > *last_ + most_ahead || picture.number + picture.frames < *last_ - most_behind)
            return Anew::yes;
        // The sender began again, or its clock was put back and the picture is an older one.
        const bool is_newer = picture.taken_ns > last_taken_ns_ && last_taken_ns_ > 0;
        return picture.number <= *last_ && is_newer ? Anew::perhaps : Anew::no;
    }
    /// Whether numbers and times agree on the order of both pictures.
    bool goes_on_from_doubtful(const StreamPicture& picture) const {
        const std::int64_t frames = picture.number - doubtful_->number;
        const std::int64_t ns = picture.taken_ns - doubtful_->taken_ns;
        if (frames < -most_behind || frames > most_behind || picture.taken_ns <= last_taken_ns_) return false;
        return frames == 0 ? ns == 0 && picture.role != doubtful_->role : (frames > 0) == (ns > 0);
    }
    void begin_anew(std::int64_t since_ns) {
        before_ = {since_ns, *last_, most_of_before};
        restart();
    }
    /// A doubtful picture without a successor is late.
    void leave_doubtful() {
        if (doubtful_ && doubtful_->role != PlaneRole::colour) add_late(*doubtful_);
        doubtful_.reset();
    }
    void admit(StreamPicture picture);
    bool is_of_before(const StreamPicture& picture) {
        if (before_.left == 0) return false;
        --before_.left;
        return picture.taken_ns > 0 && picture.taken_ns < before_.since_ns &&
               picture.number > before_.last - most_behind;
    }
    void add_late(const StreamPicture& picture);
    bool hold(StreamPicture&& picture);
    void drop_oldest();
    const Held* of(PlaneRole role, std::int64_t number) const {
        for (const Held& held : held_[index_of(role)])
            if (held.first <= number && number < held.end) return &held;
        return nullptr;
    }
    Roles there(std::int64_t number) const {
        Roles roles = 0;
        for (const PlaneRole role : all_roles)
            if ((needed_ & bit_of(role)) != 0 && of(role, number)) roles |= bit_of(role);
        return roles;
    }
    bool has_its_colour(std::int64_t number) const;
    /// Skips framesets before the first colour, so that a stream with colour has it from its first one on.
    bool came_before_colour(std::int64_t number) const {
        const auto& colour = held_[index_of(PlaneRole::colour)];
        return has_colour_ && !colour_came_ && !colour.empty() && colour.front().first > number;
    }
    void give_whole();
    void give(std::int64_t number);
    /// `by`: 1, or -1 to take a count back.
    void count(const Missed& missed, std::int64_t by) {
        (missed.is_torn ? counts_.torn : counts_.lost) += by;
    }
    void count_missing(std::int64_t next, std::int64_t step);
    void forget();

    Roles needed_ = 0;
    bool has_colour_ = false, colour_came_ = false, ended_ = false;
    int without_colour_in_a_row_ = 0;  // framesets
    bool is_full_ = false;             // all bytes are used, before the first colour came
    std::array<std::deque<Held>, all_roles.size()> held_;
    std::int64_t torn_ = 0;             // not counted yet
    std::optional<std::int64_t> last_;  // newest returned
    std::int64_t last_step_ = 1;
    std::int64_t last_taken_ns_ = 0;
    Before before_;
    std::optional<StreamPicture> doubtful_;  // it may be the first one after a sender began again
    Plane newest_colour_;
    std::map<std::int64_t, Missed> missed_;
    std::deque<WholeFrameset> whole_;
    FramesetCounts counts_;
};

/// A received frameset.
struct Received {
    std::int64_t number = 0;
    std::int64_t sent_ns = 0;  ///< by the sender's clock, or by its frames' times; 0: not known
    RawFrame frame;            ///< its planes, without number and time
};

std::size_t bytes_of_planes(const RawFrame& frame);

/// One connection to a sender: whole framesets only, in order, with the meaning that `Scene` gives them.
class StreamReceiver {
public:
    /// Connects, and reads up to the first whole frameset. Errors name the stream. `wait` ends its reads;
    /// `described` replaces the stream's own scene; `now_ns` as in HlsInput::open.
    static Result<std::unique_ptr<StreamReceiver>> open(const StreamSource& source,
                                                        std::shared_ptr<StreamWait> wait,
                                                        const std::optional<SceneDescription>& described,
                                                        std::function<std::int64_t()> now_ns = {});

    const Scene& scene() const { return scene_; }
    const SceneDescription::Unstated& unstated() const { return unstated_; }
    const std::vector<TrackInfo>& tracks() const { return tracks_; }
    const std::vector<ClipNote>& notes() const { return notes_; }
    /// Whether both have the same scene and planes.
    bool is_like(const StreamReceiver& other) const {
        const auto is_same = [](const TrackInfo& a, const TrackInfo& b) {
            return a.role == b.role && a.width == b.width && a.height == b.height;
        };
        return scene_text_ == other.scene_text_ &&
               std::equal(tracks_.begin(), tracks_.end(), other.tracks_.begin(), other.tracks_.end(),
                          is_same);
    }

    /// The next whole frameset, within `longest`; nothing after the sender's end.
    Result<std::optional<Received>> next(std::chrono::milliseconds longest);
    /// Closes the connection; `next` may not be called afterwards.
    void hang_up() {
        pictures_.reset();
        bytes_.reset();
    }
    void leave_out_colour() {
        with_colour_ = false;
        pictures_->leave_out_colour();
        assembler_->leave_out_colour();
    }
    /// Figures of the connection's datagrams, if its transport counts them.
    std::optional<StreamFigures::Link> link() const { return bytes_ ? bytes_->link() : std::nullopt; }
    std::optional<StreamFigures::Levels> levels() const { return pictures_->levels(); }
    FramesetCounts counts() const { return assembler_->counts(); }
    /// To be called after the end.
    std::string how_it_ended() const { return pictures_->how_it_ended(); }
    /// Whether the end was in the middle of a frameset, or of the connection.
    bool was_broken_off() const { return pictures_->was_lost() || assembler_->has_part(); }

private:
    StreamReceiver(const StreamSource& source, std::shared_ptr<StreamWait> wait)
        : name_(source.url.name()), wait_(std::move(wait)) {}
    Result<void> connect(const StreamSource& source, const std::optional<SceneDescription>& described,
                         std::function<std::int64_t()> now_ns);
    Result<void> read_first();
    Result<void> take(StreamPictures::Came came);
    Received received(WholeFrameset frameset) const;

    const std::string name_;
    const std::shared_ptr<StreamWait> wait_;
    std::shared_ptr<const StreamBytes> bytes_;  // null: segments
    std::unique_ptr<StreamPictures> pictures_;
    Scene scene_;
    std::string scene_text_;
    SceneDescription::Unstated unstated_;
    std::optional<FramesetAssembler> assembler_;
    std::vector<TrackInfo> tracks_;
    std::vector<ClipNote> notes_;
    std::optional<Received> first_;
    bool with_colour_ = true, has_ended_ = false;
};

}  // namespace touchable
