#include "engine/clip/camera_run.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/stop_request.hpp"

namespace touchable {
namespace {

constexpr std::int64_t most_lost = 1'000'000;  // in a row; more is another count

std::int64_t steady_ns(std::chrono::steady_clock::time_point moment) {
    return std::chrono::nanoseconds(moment.time_since_epoch()).count();
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

void CameraRun::remark(std::string words) {
    const std::lock_guard lock(mutex_);
    remarks_.push_back(std::move(words));
}

void CameraRun::gone(const std::string& why) {
    is_gone_ = true;
    std::string when;
    if (zero_ns_)
        when = formatted(" after %.1f s; its last frame stands still",
                         1e-9 * static_cast<double>(steady_ns(std::chrono::steady_clock::now()) - *zero_ns_));
    remark("the " + kind_ + ", " + name_ + ", " + why + when);
}

std::vector<std::string> CameraRun::remarks() const {
    const std::lock_guard lock(mutex_);
    return remarks_;
}

}  // namespace touchable
