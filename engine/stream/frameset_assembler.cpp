#include "engine/stream/frameset_assembler.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace touchable {
namespace {

constexpr std::size_t most_pictures_held = 64, most_missed = 256;
constexpr int most_of_before = 256;
/// Beyond these a number is of another count.
constexpr std::int64_t most_behind = 64, most_ahead = 1'000'000;

constexpr std::size_t index_of(PlaneRole role) {
    return static_cast<std::size_t>(role);
}
constexpr std::uint32_t bit_of(PlaneRole role) {
    return std::uint32_t{1} << index_of(role);
}

}  // namespace

FramesetAssembler::FramesetAssembler(const std::vector<PlaneRole>& roles) {
    for (const PlaneRole role : roles)
        if (role == PlaneRole::colour)
            has_colour_ = true;
        else
            needed_ |= bit_of(role);
}

FramesetAssembler::Anew FramesetAssembler::begins_anew(const StreamPicture& picture) const {
    if (!last_) return Anew::no;
    if (picture.number > *last_ + most_ahead || picture.number + picture.frames < *last_ - most_behind)
        return Anew::yes;
    // Whoever sends began again, or its clock was put back and this is of before.
    const bool is_newer = picture.taken_ns > last_taken_ns_ && last_taken_ns_ > 0;
    return picture.number <= *last_ && is_newer ? Anew::perhaps : Anew::no;
}

/// Numbers and times of both agree about which of them is the later one.
bool FramesetAssembler::goes_on_from_doubtful(const StreamPicture& picture) const {
    const std::int64_t frames = picture.number - doubtful_->number;
    const std::int64_t ns = picture.taken_ns - doubtful_->taken_ns;
    if (frames < -most_behind || frames > most_behind || picture.taken_ns <= last_taken_ns_) return false;
    return frames == 0 ? ns == 0 && picture.role != doubtful_->role : (frames > 0) == (ns > 0);
}

void FramesetAssembler::begin_anew(std::int64_t since_ns) {
    before_ = {since_ns, *last_, most_of_before};
    restart();
}

bool FramesetAssembler::is_of_before(const StreamPicture& picture) {
    if (before_.left == 0) return false;
    --before_.left;
    return picture.taken_ns > 0 && picture.taken_ns < before_.since_ns &&
           picture.number > before_.last - most_behind;
}

void FramesetAssembler::add(StreamPicture picture) {
    if (is_of_before(picture)) return;
    if (doubtful_) {
        if (goes_on_from_doubtful(picture)) {
            StreamPicture first = std::move(*doubtful_);
            begin_anew(std::min(first.taken_ns, picture.taken_ns));
            admit(std::move(first));
            return admit(std::move(picture));
        }
        leave_doubtful();
    }
    const Anew anew = begins_anew(picture);
    if (anew == Anew::perhaps) {
        doubtful_ = std::move(picture);
        return;
    }
    if (anew == Anew::yes) begin_anew(picture.taken_ns);
    admit(std::move(picture));
}

/// What nothing goes on from is late.
void FramesetAssembler::leave_doubtful() {
    if (doubtful_ && doubtful_->role != PlaneRole::colour) add_late(*doubtful_);
    doubtful_.reset();
}

void FramesetAssembler::admit(StreamPicture picture) {
    const PlaneRole role = picture.role;
    if (last_ && picture.number + picture.frames <= *last_ + 1 && role != PlaneRole::colour)
        return add_late(picture);
    if (last_ && picture.number + picture.frames <= *last_ + 1) {
        without_colour_in_a_row_ = 0;  // it is sent again
        newest_colour_ = std::move(picture.plane);
        return;
    }
    if (role != PlaneRole::colour) needed_ |= bit_of(role);  // it was not known before
    if (!hold(std::move(picture))) return;
    give_whole();
}

void FramesetAssembler::add_late(const StreamPicture& picture) {
    const auto found = missed_.find(picture.number);
    if (found == missed_.end() || (found->second.there & bit_of(picture.role)) != 0) {
        ++counts_.repeated;
        return;
    }
    Missed& missed = found->second;
    missed.there |= bit_of(picture.role);
    if (missed.there != needed_) return;
    count(missed, -1);
    missed_.erase(found);
    ++counts_.late;
}

/// Once more, or once less.
void FramesetAssembler::count(const Missed& missed, std::int64_t by) {
    if (missed.is_torn) {
        counts_.torn += by;
        return;
    }
    counts_.lost += by;
    if (missed.first_missing) counts_.lost_of[index_of(*missed.first_missing)] += by;
}

/// False where it was there.
bool FramesetAssembler::hold(StreamPicture&& picture) {
    auto& held = held_[index_of(picture.role)];
    const auto at =
        std::lower_bound(held.begin(), held.end(), picture.number,
                         [](const Held& other, std::int64_t number) { return other.first < number; });
    if (at != held.end() && at->first == picture.number && at->taken_ns == picture.taken_ns) {
        ++counts_.repeated;
        return false;
    }
    Held made{picture.number, picture.number + picture.frames, picture.taken_ns, std::move(picture.plane),
              picture.step};
    if (at != held.begin()) std::prev(at)->end = std::min(std::prev(at)->end, made.first);
    if (at != held.end() && at->first == made.first)
        *at = std::move(made);
    else {
        if (at != held.end()) made.end = std::min(made.end, at->first);
        held.insert(at, std::move(made));
    }
    if (held.size() > most_pictures_held) held.pop_front();
    drop_oldest();
    return true;
}

/// Until all that is held is few enough bytes.
void FramesetAssembler::drop_oldest() {
    std::size_t bytes = 0;
    for (const auto& held : held_)
        for (const Held& one : held) bytes += bytes_of_plane(one.plane.view);
    while (bytes > most_bytes_waiting) {
        const auto first = [](const std::deque<Held>& held) {
            return held.empty() ? std::numeric_limits<std::int64_t>::max() : held.front().first;
        };
        auto& oldest = *std::ranges::min_element(held_, {}, first);
        bytes -= bytes_of_plane(oldest.front().plane.view);
        oldest.pop_front();
        is_full_ = true;
    }
}

const FramesetAssembler::Held* FramesetAssembler::of(PlaneRole role, std::int64_t number) const {
    for (const Held& held : held_[index_of(role)])
        if (held.first <= number && number < held.end) return &held;
    return nullptr;
}

FramesetAssembler::Roles FramesetAssembler::there(std::int64_t number) const {
    Roles roles = 0;
    for (const PlaneRole role : all_roles)
        if ((needed_ & bit_of(role)) != 0 && of(role, number)) roles |= bit_of(role);
    return roles;
}

/// Or it will not come any more.
bool FramesetAssembler::has_its_colour(std::int64_t number) const {
    constexpr std::size_t most_without = 30;  // framesets that wait for the first colour
    constexpr int is_left_out_after = 3;      // framesets; then it is not waited for until it comes
    if (!has_colour_ || ended_ || of(PlaneRole::colour, number)) return true;
    if (without_colour_in_a_row_ >= is_left_out_after) return true;
    const auto& depth = held_[index_of(PlaneRole::depth)];
    if (!colour_came_) return is_full_ || depth.size() > most_without;
    const auto is_beyond = [&](PlaneRole role, std::int64_t than) {
        const auto& held = held_[index_of(role)];
        return !held.empty() && held.back().first > than;
    };
    return is_beyond(PlaneRole::colour, number) || is_beyond(PlaneRole::depth, number + 1);
}

/// What begins with colour has it from its first frameset on.
bool FramesetAssembler::came_before_colour(std::int64_t number) const {
    const auto& colour = held_[index_of(PlaneRole::colour)];
    return has_colour_ && !colour_came_ && !colour.empty() && colour.front().first > number;
}

void FramesetAssembler::give_whole() {
    for (bool gave = true; gave;) {
        gave = false;
        for (const Held& depth : held_[index_of(PlaneRole::depth)]) {
            std::int64_t number = last_ ? std::max(depth.first, *last_ + 1) : depth.first;
            while (number < depth.end && there(number) != needed_) ++number;
            if (number >= depth.end) continue;
            if (came_before_colour(number)) {
                last_ = number;
                forget();
                gave = true;
                break;
            }
            if (!has_its_colour(number)) return;
            give(number);
            gave = true;
            break;
        }
    }
}

void FramesetAssembler::give(std::int64_t number) {
    WholeFrameset frameset;
    frameset.number = number;
    bool is_one = true;
    const Held* const depth = of(PlaneRole::depth, number);
    for (const PlaneRole role : all_roles) {
        const Held* const held = of(role, number);
        if (!held) continue;
        const bool is_of_another =
            depth->first == number && held->first == number && held->taken_ns != depth->taken_ns;
        if (is_of_another && role == PlaneRole::colour) continue;
        is_one = is_one && !is_of_another;
        frameset.planes[index_of(role)] = held->plane;
    }
    frameset.taken_ns = depth->first == number ? depth->taken_ns : 0;
    auto& colour = frameset.planes[index_of(PlaneRole::colour)];
    if (!colour.view.empty()) newest_colour_ = colour;
    colour_came_ = colour_came_ || !colour.view.empty();
    const bool lacks_colour = has_colour_ && colour_came_ && colour.view.empty();
    without_colour_in_a_row_ = lacks_colour ? without_colour_in_a_row_ + 1 : 0;
    colour = newest_colour_;
    // Where a stream goes over to another step, what lies between was of neither.
    count_missing(number, std::max(last_step_, depth->step));
    last_ = number;
    last_step_ = depth->step;
    forget();
    if (!is_one) {  // of the same number, but not of the same moment
        ++counts_.lost;
        return;
    }
    if (frameset.taken_ns > 0) last_taken_ns_ = frameset.taken_ns;
    ++counts_.whole;
    counts_.without_colour += lacks_colour ? 1 : 0;
    whole_.push_back(std::move(frameset));
}

/// Between the last one given and this, of those that were sent.
void FramesetAssembler::count_missing(std::int64_t next, std::int64_t step) {
    if (!last_) return;
    const std::int64_t first = std::max(*last_ + 1, next - std::int64_t{most_missed});
    counts_.lost += (first - (*last_ + 1)) / step;  // too many to tell of each
    for (std::int64_t number = first; number < next; ++number) {
        if ((next - number) % step != 0) continue;
        Missed missed{there(number), std::nullopt, false};
        for (const PlaneRole role : all_roles)
            if (!missed.first_missing && (needed_ & ~missed.there & bit_of(role)) != 0)
                missed.first_missing = role;
        missed.is_torn = missed.first_missing && torn_ > 0;
        if (missed.is_torn) --torn_;
        count(missed, 1);
        missed_[number] = missed;
    }
    while (missed_.size() > most_missed) missed_.erase(missed_.begin());
}

void FramesetAssembler::forget() {
    for (const PlaneRole role : all_roles) {
        auto& held = held_[index_of(role)];
        while (!held.empty() && held.front().end <= *last_ + 1) {
            if (role == PlaneRole::colour) newest_colour_ = held.front().plane;
            held.pop_front();
        }
    }
}

void FramesetAssembler::end() {
    ended_ = true;
    leave_doubtful();
    give_whole();
}

void FramesetAssembler::restart() {
    for (auto& held : held_) held.clear();
    doubtful_.reset();
    torn_ = 0;
    missed_.clear();
    last_.reset();
    last_step_ = 1;
    last_taken_ns_ = 0;
    ended_ = false;
    ++counts_.restarts;
}

bool FramesetAssembler::has_part() const {
    for (const PlaneRole role : all_roles)
        for (const Held& held : held_[index_of(role)])
            if ((needed_ & bit_of(role)) != 0 && (!last_ || held.end > *last_ + 1)) return true;
    return false;
}

std::optional<WholeFrameset> FramesetAssembler::take() {
    if (whole_.empty()) return std::nullopt;
    WholeFrameset frameset = std::move(whole_.front());
    whole_.pop_front();
    return frameset;
}

}  // namespace touchable
