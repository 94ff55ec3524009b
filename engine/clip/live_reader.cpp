// SPDX-License-Identifier: Apache-2.0
// Live sources: their common rules, and recordings that behave like a camera.

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {
namespace {

using std::chrono::steady_clock;

constexpr std::int64_t most_lost = 1'000'000;  // in a row; more: the counter began anew

Error runs_on() {
    return usage_error("a camera that runs goes to no other frame than its next");
}
Error told_to_stop(const std::string& kind, std::int64_t before_frame) {
    return {ErrorKind::interrupted,
            "the " + kind + " was told to stop before it gave frame " + std::to_string(before_frame)};
}

/// Random decisions about a frame.
enum class Chance : std::uint64_t { drop = 1, jitter = 2 };

/// A reproducible random number, 0 to below 1.
double drawn(Chance what, std::int64_t number) {
    const std::array<std::uint64_t, 2> key{static_cast<std::uint64_t>(what),
                                           static_cast<std::uint64_t>(number)};
    ByteHash hash;
    hash.add(key.data(), sizeof key);
    return static_cast<double>(hash.value() >> 11) * 0x1p-53;
}

class ReplayCamera final : public ReaderAround {
public:
    ReplayCamera(std::unique_ptr<ClipReader> recording, const CameraDelivery& delivery)
        : ReaderAround(std::move(recording)), delivery_(delivery), scene_(inner().scene()) {
        scene_.rate = delivery_.rate.value_or(scene_.rate);
        scene_.interpolation = FrameInterpolation::hold;
    }
    const Scene& scene() const override { return scene_; }
    bool is_live() const override { return true; }
    Result<void> seek(std::int64_t frame) override {
        if (zero_) return runs_on();
        auto there = inner().seek(frame);
        if (there) position_ = frame;
        return there;
    }
    Result<std::optional<RawFrame>> next() override {
        if (!zero_) return next_recorded();
        const CameraDelivery::Frame delivery = newest_or_next();
        // Decode nothing if no frame will come or the thread is to stop.
        if (delivery.at_ns == CameraDelivery::never || stop_requested()) return wait_for(delivery).error();
        auto frame = read(delivery.number);
        if (!frame || !*frame) return frame;
        TRY(wait_for(delivery));
        last_ = delivery;
        return frame;
    }
    Result<void> begin(steady_clock::time_point zero) override {
        zero_ = zero;
        last_ = {position_ - 1, 0};
        return {};
    }

private:
    /// The newest delivered frame that was not given yet, or else the next to come.
    CameraDelivery::Frame newest_or_next() const {
        const std::int64_t now_ns = std::chrono::nanoseconds(steady_clock::now() - *zero_).count();
        const std::int64_t end = frame_count().value_or(CameraDelivery::never);
        CameraDelivery::Frame frame, later = delivery_.after(last_, scene_.rate);
        do {
            frame = later;
            later = delivery_.after(frame, scene_.rate);
        } while (later.at_ns <= now_ns && later.number < end);
        return frame;
    }
    /// The recording's next frame, with the camera's time.
    Result<std::optional<RawFrame>> next_recorded() {
        auto frame = inner().next();
        if (!frame || !*frame) return frame;
        ++position_;
        (*frame)->time_ns = scene_.rate.time_ns((*frame)->number);
        return frame;
    }
    /// Reads this frame of the recording, skipping those before it; nullopt beyond its end.
    Result<std::optional<RawFrame>> read(std::int64_t number) {
        if (const auto count = frame_count()) {
            if (number >= *count) return std::optional<RawFrame>();
            if (const std::int64_t nearer = access_point(number); nearer > position_) {
                TRY(inner().seek(nearer));
                position_ = nearer;
            }
        }
        while (true) {
            auto frame = next_recorded();
            if (!frame || !*frame || (*frame)->number == number) return frame;
        }
    }
    Result<void> wait_for(const CameraDelivery::Frame& frame) {
        const bool never_comes = frame.at_ns == CameraDelivery::never;
        const auto at =
            never_comes ? steady_clock::time_point::max() : *zero_ + std::chrono::nanoseconds(frame.at_ns);
        if (wait_unless_stopped(at)) return {};
        return told_to_stop("camera", frame.number);
    }

    const CameraDelivery delivery_;
    Scene scene_;
    std::int64_t position_ = 0;  // the frame that the recording gives next
    std::optional<steady_clock::time_point> zero_;
    CameraDelivery::Frame last_;
};

/// ns; later times of a sender's clock count as unknown.
constexpr std::int64_t latest_known_ns = std::int64_t{1} << 61U;

}  // namespace

void add_count(std::vector<std::string>& remarks, std::int64_t count, const std::string& of_what) {
    if (count > 0) remarks.push_back(std::to_string(count) + " of " + of_what);
}

// --- LiveReader

Result<std::optional<RawFrame>> LiveReader::next() {
    while (true) {
        TRY_ASSIGN(auto taken, wait_for_frame());
        if (!taken) return std::optional<RawFrame>();
        const auto placed = place(*taken);
        if (!placed) continue;
        RawFrame& frame = taken->frame;
        frame.number = placed->number;
        frame.time_ns = placed->time_ns;
        const std::lock_guard lock(mutex_);
        ways_[static_cast<std::size_t>(frame.number) % ways_.size()] = {frame.number, taken->way_ns};
        return std::optional(std::move(frame));
    }
}

/// Returns nullopt in a run whose source is gone.
LiveReader::MaybeTaken LiveReader::wait_for_frame() {
    const auto since = steady_clock::now();
    while (!is_gone_) {
        if (stop_requested()) return told_to_stop(kind_, next_number_);
        auto taken = poll();
        if (!taken || *taken) return taken;
        if (is_gone_) break;
        if (!has_begun())
            if (auto why = nothing_came(since)) return *why;
        wait();
    }
    if (has_begun()) return std::optional<Taken>();
    const std::lock_guard lock(mutex_);
    return input_error(remarks_.back());
}

Result<LiveReader::Taken> LiveReader::first_frame() {
    TRY_ASSIGN(auto taken, wait_for_frame());
    return std::move(taken.value());  // before a run: a frame or an error
}

Result<void> LiveReader::begin(std::chrono::steady_clock::time_point zero) {
    constexpr std::int64_t most_before_a_run = 64;
    if (has_begun()) last_time_ns_ = most_before_a_run * ns_before_a_run;
    zero_ns_ = steady_ns_of(zero);
    last_count_.reset();
    if (!is_gone_) drain();
    return {};
}

Result<void> LiveReader::seek(std::int64_t frame) {
    if (has_begun()) return runs_on();
    if (frame > next_number_) return usage_error("a camera has not taken frame " + std::to_string(frame));
    next_number_ = frame;
    last_time_ns_ = std::max<std::int64_t>(-1, (frame - 1) * ns_before_a_run);
    return {};
}

/// Returns nullopt if it was taken before the run.
std::optional<LiveReader::Place> LiveReader::place(const Taken& taken) {
    if (zero_ns_ && taken.at_ns - *zero_ns_ <= last_time_ns_ && !last_count_) return std::nullopt;
    std::int64_t further = 1;
    if (last_count_) {
        const std::uint32_t counted = taken.count - *last_count_;
        if (counted > 0 && counted <= most_lost) further = counted;
    }
    if (zero_ns_) last_count_ = taken.count;
    Place place;
    place.number = next_number_ + further - 1;
    place.time_ns =
        zero_ns_ ? std::max(taken.at_ns - *zero_ns_, last_time_ns_ + 1) : place.number * ns_before_a_run;
    next_number_ = place.number + 1;
    last_time_ns_ = place.time_ns;
    return place;
}

LiveReader::MaybeTaken LiveReader::gone(const std::string& why) {
    is_gone_ = true;
    std::string when;
    if (zero_ns_)
        when = formatted(" after %.1f s; its last frame stands still",
                         1e-9 * static_cast<double>(steady_now_ns() - *zero_ns_));
    remark("the " + kind_ + ", " + name_ + ", " + why + when);
    return std::optional<Taken>();
}

void LiveReader::remark(std::string words) {
    const std::lock_guard lock(mutex_);
    remarks_.push_back(std::move(words));
}

void LiveReader::take_meaning(Meaning meaning) {
    scene_ = std::move(meaning.scene);
    scene_.interpolation = FrameInterpolation::hold;
    unstated_filters_ = meaning.unstated_filters;
    for (auto& input : meaning.inputs) add_input(std::move(input));
}

std::int64_t LiveReader::taken_before(std::int64_t frame) const {
    const std::lock_guard lock(mutex_);
    const Way& way = ways_[static_cast<std::size_t>(frame) % ways_.size()];
    return way.frame == frame ? way.ns : 0;
}

std::vector<std::string> LiveReader::remarks() const {
    std::vector<std::string> all;
    add_count(all, damaged_, "the camera's frames were damaged or cut short, and left out");
    add_count(all, repeated_, "the camera's frames came twice, and were left out once");
    const std::lock_guard lock(mutex_);
    all.insert(all.end(), remarks_.begin(), remarks_.end());
    return all;
}

// --- CameraDelivery

CameraDelivery::Frame CameraDelivery::after(const Frame& last, const FrameRate& recorded) const {
    std::int64_t number = last.number + 1;
    while (drawn(Chance::drop, number) < drop) ++number;
    const double late_ns = drawn(Chance::jitter, number) * static_cast<double>(jitter_ns);
    const std::int64_t delivered_ns = recorded.time_ns(number) + static_cast<std::int64_t>(late_ns);
    const std::int64_t at_ns = std::max(last.at_ns, delivered_ns);  // none overtakes another
    if (!stall_ns || at_ns < *stall_ns) return {number, at_ns};
    return {number, std::max(at_ns, resume_ns.value_or(never))};
}

std::unique_ptr<ClipReader> make_replay_camera(std::unique_ptr<ClipReader> recording,
                                               const CameraDelivery& delivery) {
    return std::make_unique<ReplayCamera>(std::move(recording), delivery);
}

void JitterBuffer::restart() {
    shortest_ = {};
    last_sent_ns_ = 0;
}

/// The shortest transit time of the last ten seconds.
std::int64_t JitterBuffer::shortest_way(std::int64_t way_ns, std::int64_t arrived_ns) {
    const std::int64_t bucket = arrived_ns / bucket_ns;
    auto& now = shortest_[static_cast<std::size_t>(bucket) % buckets];
    if (!now || now->bucket != bucket) now = Shortest{bucket, way_ns};
    now->way_ns = std::min(now->way_ns, way_ns);
    std::int64_t shortest = now->way_ns;
    for (const auto& one : shortest_)
        if (one && bucket - one->bucket < static_cast<std::int64_t>(buckets))
            shortest = std::min(shortest, one->way_ns);
    return shortest;
}

void JitterBuffer::adapt(std::int64_t jitter_ns, std::int64_t arrived_ns) {
    constexpr std::int64_t fall_ns = 8'000'000'000;  // time in which a delay falls to about a third
    jitters_[jitter_count_++ % kept] = jitter_ns;
    std::vector<std::int64_t> all(
        jitters_.begin(), jitters_.begin() + static_cast<std::ptrdiff_t>(std::min(jitter_count_, kept)));
    const std::int64_t high = sorted_element(all, (all.size() - 1) * 97 / 100),
                       wanted = std::clamp<std::int64_t>(high, 0, latency_ns_);
    const std::int64_t passed = std::clamp<std::int64_t>(arrived_ns - last_arrived_ns_, 0, fall_ns);
    if (wanted >= delay_ns_)
        delay_ns_ = wanted;
    else
        delay_ns_ -= static_cast<std::int64_t>(static_cast<double>(delay_ns_ - wanted) *
                                               static_cast<double>(passed) / static_cast<double>(fall_ns));
}

JitterBuffer::Moments JitterBuffer::add(std::int64_t sent_ns, std::int64_t arrived_ns) {
    const bool goes_on = sent_ns > 0 && sent_ns < latest_known_ns && sent_ns > last_sent_ns_;
    const bool is_first = last_sent_ns_ == 0;
    Moments moments{arrived_ns, arrived_ns};
    if (goes_on) {
        const std::int64_t way_ns = arrived_ns - sent_ns;
        std::int64_t jitter_ns = way_ns - shortest_way(way_ns, arrived_ns);
        if (jitter_ns > longest_way_ns_) {  // the sender's clock went back, or all was held up
            shortest_ = {};
            (void)shortest_way(way_ns, arrived_ns);
            jitter_ns = 0;
        } else if (!is_first) {
            adapt(jitter_ns, arrived_ns);
        }
        moments.taken_ns = arrived_ns - jitter_ns;
        moments.shown_ns = std::max(arrived_ns, moments.taken_ns + delay_ns_);
    } else {
        shortest_ = {};
        if (sent_ns > 0 && sent_ns < latest_known_ns) (void)shortest_way(arrived_ns - sent_ns, arrived_ns);
    }
    last_sent_ns_ = sent_ns > 0 && sent_ns < latest_known_ns ? sent_ns : 0;
    last_arrived_ns_ = arrived_ns;
    moments.shown_ns = std::max(moments.shown_ns, last_shown_ns_);
    last_shown_ns_ = moments.shown_ns;
    return moments;
}

JitterBuffer::Moments SegmentPace::add(std::int64_t sent_ns, std::int64_t arrived_ns) {
    constexpr std::int64_t most_ahead_ns = 60'000'000'000;
    if (sent_ns <= 0 || sent_ns >= latest_known_ns) return {arrived_ns, arrived_ns};
    if (!apart_ns_) apart_ns_ = arrived_ns + margin_ns_ - sent_ns;
    std::int64_t shown_ns = sent_ns + *apart_ns_;
    if (shown_ns < arrived_ns || shown_ns > arrived_ns + most_ahead_ns) {
        apart_ns_ = arrived_ns - sent_ns;
        shown_ns = arrived_ns;
    }
    return {shown_ns, shown_ns};
}

}  // namespace touchable
