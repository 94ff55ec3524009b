// SPDX-License-Identifier: Apache-2.0
#include "engine/stream/receiver.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/containers.hpp"
#include "engine/stream/listeners.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_pictures_held = 64, most_missed = 256;

/// Why a sender refuses a listener (StreamServer), in its first line; empty: it sends something else.
std::string refusal_in(StreamBytes& bytes) {
    constexpr std::size_t longest = 200;
    std::string line;
    bytes.allow(longest);
    for (std::uint8_t letter = 0; line.size() < longest && line.find('\n') == std::string::npos;) {
        const auto got = bytes.read(&letter, 1);
        if (!got || *got == 0) break;
        line += static_cast<char>(letter);
        if (!stream_refusal.starts_with(line.substr(0, stream_refusal.size()))) return "";
    }
    if (line.size() <= stream_refusal.size()) return "";
    return line.substr(stream_refusal.size(), line.find('\n') - stream_refusal.size());
}

}  // namespace

// --- FramesetAssembler

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

void FramesetAssembler::admit(StreamPicture picture) {
    const PlaneRole role = picture.role;
    if (last_ && picture.number + picture.frames <= *last_ + 1) {
        if (role != PlaneRole::colour) return add_late(picture);
        without_colour_in_a_row_ = 0;  // colour is sent again
        newest_colour_ = std::move(picture.plane);
        return;
    }
    if (role != PlaneRole::colour) needed_ |= bit_of(role);  // a plane that was unknown before
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

/// False if it was held already.
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

/// Drops the oldest pictures until those that are held are few enough bytes.
void FramesetAssembler::drop_oldest() {
    std::size_t bytes = 0;
    for (const auto& held : held_)
        for (const Held& one : held) bytes += one.plane.view.bytes();
    while (bytes > most_bytes_waiting) {
        const auto first = [](const std::deque<Held>& held) {
            return held.empty() ? std::numeric_limits<std::int64_t>::max() : held.front().first;
        };
        auto& oldest = *std::ranges::min_element(held_, {}, first);
        bytes -= oldest.front().plane.view.bytes();
        oldest.pop_front();
        is_full_ = true;
    }
}

/// Whether the frameset's colour is there, or will not come any more.
bool FramesetAssembler::has_its_colour(std::int64_t number) const {
    constexpr std::size_t most_without = 30;  // framesets that wait for the first colour
    constexpr int is_left_out_after = 3;      // framesets; then colour is not waited for until it comes
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
            } else if (has_its_colour(number)) {
                give(number);
            } else {
                return;
            }
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
    // If the stream changes its step, the numbers between belong to neither step.
    count_missing(number, std::max(last_step_, depth->step));
    last_ = number;
    last_step_ = depth->step;
    forget();
    if (!is_one) {  // equal numbers, but different moments
        ++counts_.lost;
        return;
    }
    if (frameset.taken_ns > 0) last_taken_ns_ = frameset.taken_ns;
    ++counts_.whole;
    counts_.without_colour += lacks_colour ? 1 : 0;
    whole_.push_back(std::move(frameset));
}

/// Counts those missing since the last frameset, out of those that were sent.
void FramesetAssembler::count_missing(std::int64_t next, std::int64_t step) {
    if (!last_) return;
    const std::int64_t first = std::max(*last_ + 1, next - std::int64_t{most_missed});
    counts_.lost += (first - (*last_ + 1)) / step;  // too many to track each
    for (std::int64_t number = first; number < next; ++number) {
        if ((next - number) % step != 0) continue;
        Missed missed{there(number)};
        missed.is_torn = missed.there != needed_ && torn_ > 0;
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

// --- StreamReceiver

std::size_t bytes_of_planes(const RawFrame& frame) {
    std::size_t bytes = 0;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        bytes += plane->bytes();
    return bytes;
}

Result<std::unique_ptr<StreamReceiver>> StreamReceiver::open(const StreamSource& source,
                                                             std::shared_ptr<StreamWait> wait,
                                                             const std::optional<SceneDescription>& described,
                                                             std::function<std::int64_t()> now_ns) {
    std::unique_ptr<StreamReceiver> receiver(new StreamReceiver(source, wait));
    const auto until_called = source.url.is_called() ? source.patience.caller : std::chrono::milliseconds(0);
    if (!wait->is_together()) wait->together_at_most(until_called + source.patience.opening);
    auto begun = receiver->connect(source, described, std::move(now_ns));
    if (begun) begun = receiver->read_first();
    wait->each_alone();
    TRY(begun);
    return receiver;
}

Result<void> StreamReceiver::connect(const StreamSource& source,
                                     const std::optional<SceneDescription>& described,
                                     std::function<std::int64_t()> now_ns) {
    if (source.url.is_playlist()) {
        wait_->at_most(source.patience.opening);
        TRY_ASSIGN(pictures_, open_hls_stream(source.url, wait_, described, std::move(now_ns)));
        return {};
    }
    std::shared_ptr<StreamBytes> bytes = source.connection;
    if (!bytes) {
        TRY_ASSIGN(bytes, error_at(name_, StreamBytes::connect(source.url, wait_, source.patience)));
    }
    bytes_ = bytes;
    wait_->at_most(source.patience.frameset);
    bytes->allow(1);
    TRY_ASSIGN(const auto first, error_at(name_, bytes->peek()));
    const bool is_transport_stream = first == 0x47;  // sync byte of its packets
    constexpr int first_of_matroska = 0x1a;
    if (!is_transport_stream && first != first_of_matroska) {
        if (const std::string why = refusal_in(*bytes); !why.empty())
            return input_error(name_ + ": the sender refuses: " + printable(why));
        return input_error(name_ + ": sends neither Matroska nor MPEG-TS; expected a touchable serve there");
    }
    TRY_ASSIGN(pictures_, (is_transport_stream ? open_transport_stream : open_matroska_pictures)(
                              std::move(bytes), name_, described));
    return {};
}

Result<void> StreamReceiver::read_first() {
    const SceneDescription& described = pictures_->described();
    if (!described.unstated.rate)
        if (auto note = clip_tags::rate_note(described.scene.rate, pictures_->rate()))
            notes_.push_back(std::move(*note));
    TRY_ASSIGN(scene_, error_at(name_, settle(described, {.rate = pictures_->rate()})));
    scene_text_ = pictures_->scene_text();
    unstated_ = described.unstated;
    assembler_.emplace(pictures_->roles());
    TRY_ASSIGN(auto first, next(std::chrono::milliseconds::max()));
    if (!first) return input_error(name_ + ": " + how_it_ended() + " before it sent a whole frameset");
    tracks_ = pictures_->tracks();
    const auto notes = describe_planes(tracks_, first->frame, scene_);
    notes_.insert(notes_.end(), notes.begin(), notes.end());
    first_ = std::move(first);
    return {};
}

Result<void> StreamReceiver::take(StreamPictures::Came came) {
    assembler_->add_torn(came.torn);
    for (StreamPicture& picture : came.pictures) {
        if (picture.role == PlaneRole::colour && !with_colour_) continue;
        TRY_ASSIGN(picture.plane, fit_plane(picture.role, std::move(picture.plane), scene_,
                                            name_ + ": " + std::string(role_name(picture.role)) + ", frame " +
                                                std::to_string(picture.number)));
        assembler_->add(std::move(picture));
    }
    return {};
}

Received StreamReceiver::received(WholeFrameset frameset) const {
    Received received{frameset.number, frameset.taken_ns, {}};
    if (received.sent_ns == 0) received.sent_ns = scene_.rate.time_ns(frameset.number) + 1;
    for (const PlaneRole role : all_roles) {
        Plane& plane = frameset.planes[static_cast<std::size_t>(role)];
        if (!plane.view.empty()) add_plane(received.frame, role, std::move(plane));
    }
    return received;
}

Result<std::optional<Received>> StreamReceiver::next(std::chrono::milliseconds longest) {
    if (first_) return std::exchange(first_, std::nullopt);
    if (longest != std::chrono::milliseconds::max()) wait_->at_most(longest);
    while (true) {
        if (auto whole = assembler_->take()) return std::optional(received(std::move(*whole)));
        if (has_ended_) return std::optional<Received>();
        TRY_ASSIGN(auto came, pictures_->next());
        if (came) {
            TRY(take(std::move(*came)));
        } else {
            has_ended_ = true;
            assembler_->end();
        }
    }
}

}  // namespace touchable
