// Cameras' runs: the numbers and times of live frames, and recordings that behave like a camera.

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"

namespace touchable {
namespace {

using std::chrono::steady_clock;

constexpr std::int64_t most_lost = 1'000'000;  // in a row; more is another count

std::int64_t steady_ns(steady_clock::time_point moment) {
    return std::chrono::nanoseconds(moment.time_since_epoch()).count();
}

/// What chance decides about a frame.
enum class Chance : std::uint64_t { drop = 1, jitter = 2 };

/// 0 to below 1, the same every time.
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
    Result<void> seek(std::int64_t frame) override;
    Result<std::optional<RawFrame>> next() override;
    Result<void> begin(steady_clock::time_point zero) override;
    void interrupt() override;

private:
    CameraDelivery::Frame newest_or_next() const;
    Result<std::optional<RawFrame>> next_recorded();
    Result<std::optional<RawFrame>> read(std::int64_t number);
    bool is_interrupted();
    Result<void> wait_for(const CameraDelivery::Frame& frame);

    const CameraDelivery delivery_;
    Scene scene_;
    std::int64_t position_ = 0;  // the frame that the recording gives next
    std::optional<steady_clock::time_point> zero_;
    CameraDelivery::Frame last_;
    std::mutex mutex_;
    std::condition_variable told_;
    bool interrupted_ = false;  // guarded by mutex_
};

Result<void> ReplayCamera::seek(std::int64_t frame) {
    if (zero_) return usage_error("a camera that runs goes to no other frame than its next");
    auto there = inner().seek(frame);
    if (there) position_ = frame;
    return there;
}

Result<void> ReplayCamera::begin(steady_clock::time_point zero) {
    zero_ = zero;
    last_ = {position_ - 1, 0};
    return {};
}

void ReplayCamera::interrupt() {
    const std::lock_guard lock(mutex_);
    interrupted_ = true;
    told_.notify_all();
}

bool ReplayCamera::is_interrupted() {
    const std::lock_guard lock(mutex_);
    return interrupted_;
}

/// Of those that were not given yet: the newest that is there, or the first that comes.
CameraDelivery::Frame ReplayCamera::newest_or_next() const {
    const std::int64_t now_ns = std::chrono::nanoseconds(steady_clock::now() - *zero_).count();
    const std::int64_t end = frame_count().value_or(CameraDelivery::never);
    CameraDelivery::Frame frame, later = delivery_.after(last_, scene_.rate);
    do {
        frame = later;
        later = delivery_.after(frame, scene_.rate);
    } while (later.at_ns <= now_ns && later.number < end);
    return frame;
}

/// The recording's frame, those before it passed over; nothing beyond its end.
Result<std::optional<RawFrame>> ReplayCamera::read(std::int64_t number) {
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

Result<void> ReplayCamera::wait_for(const CameraDelivery::Frame& frame) {
    std::unique_lock lock(mutex_);
    const auto is_interrupted = [this] { return interrupted_; };
    if (frame.at_ns == CameraDelivery::never)
        told_.wait(lock, is_interrupted);
    else
        told_.wait_until(lock, *zero_ + std::chrono::nanoseconds(frame.at_ns), is_interrupted);
    if (!interrupted_) return {};
    return Error{ErrorKind::interrupted,
                 "the camera was told to stop before it gave frame " + std::to_string(frame.number)};
}

/// At the camera's time.
Result<std::optional<RawFrame>> ReplayCamera::next_recorded() {
    auto frame = inner().next();
    if (!frame || !*frame) return frame;
    ++position_;
    (*frame)->time_ns = scene_.rate.time_ns((*frame)->number);
    return frame;
}

Result<std::optional<RawFrame>> ReplayCamera::next() {
    if (!zero_) return next_recorded();
    const CameraDelivery::Frame delivery = newest_or_next();
    // A reader that was interrupted, or for which nothing comes, has no frame to decode.
    if (const bool nothing_comes = delivery.at_ns == CameraDelivery::never; nothing_comes || is_interrupted())
        return wait_for(delivery).error();
    auto frame = read(delivery.number);
    if (!frame || !*frame) return frame;
    TRY(wait_for(delivery));
    last_ = delivery;
    return frame;
}

}  // namespace

void CameraRun::begin(std::chrono::steady_clock::time_point zero) {
    constexpr std::int64_t most_before_a_run = 64;
    if (has_begun()) last_time_ns_ = most_before_a_run * ns_before_a_run;
    zero_ns_ = steady_ns(zero);
    last_count_.reset();
    interrupted_ = false;
    wake_.forget();
}

Result<void> CameraRun::seek(std::int64_t frame) {
    if (has_begun()) return usage_error("a camera that runs goes to no other frame than its next");
    if (frame > next_number_) return usage_error("a camera has not taken frame " + std::to_string(frame));
    next_number_ = frame;
    last_time_ns_ = std::max<std::int64_t>(-1, (frame - 1) * ns_before_a_run);
    return {};
}

std::optional<CameraRun::Place> CameraRun::place(std::uint32_t count, std::int64_t at_ns) {
    if (zero_ns_ && at_ns - *zero_ns_ <= last_time_ns_ && !last_count_) return std::nullopt;
    std::int64_t further = 1;
    if (last_count_) {
        const std::uint32_t counted = count - *last_count_;
        if (counted > 0 && counted <= most_lost) further = counted;
    }
    if (zero_ns_) last_count_ = count;
    Place place;
    place.number = next_number_ + further - 1;
    place.time_ns =
        zero_ns_ ? std::max(at_ns - *zero_ns_, last_time_ns_ + 1) : place.number * ns_before_a_run;
    next_number_ = place.number + 1;
    last_time_ns_ = place.time_ns;
    return place;
}

void CameraRun::interrupt() {
    interrupted_ = true;
    wake_.wake();
}

std::optional<Error> CameraRun::told_to_end() const {
    if (!interrupted_ && (has_begun() || !stop_requested())) return std::nullopt;
    return Error{ErrorKind::interrupted,
                 "the " + kind_ + " was told to stop before it gave frame " + std::to_string(next_number_)};
}

void CameraRun::gone(const std::string& why) {
    is_gone_ = true;
    std::string when;
    if (zero_ns_)
        when = formatted(" after %.1f s; its last frame stands still",
                         1e-9 * static_cast<double>(steady_ns(std::chrono::steady_clock::now()) - *zero_ns_));
    remark("the " + kind_ + ", " + name_ + ", " + why + when);
}

void CameraRun::remark(std::string words) {
    const std::lock_guard lock(mutex_);
    remarks_.push_back(std::move(words));
}

std::vector<std::string> CameraRun::remarks() const {
    const std::lock_guard lock(mutex_);
    return remarks_;
}

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

}  // namespace touchable
