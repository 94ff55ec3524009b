#include "player/audio/window_sound.hpp"

#include <algorithm>
#include <utility>

namespace touchable {
namespace {

constexpr std::int64_t longest_gap = 1000;  // ticks: a computer that slept is no sound

}  // namespace

Result<std::unique_ptr<WindowSound>> WindowSound::create(bool loudspeakers,
                                                         const std::optional<std::filesystem::path>& file,
                                                         Existing existing) {
    std::unique_ptr<WindowSound> made(new WindowSound);
    if (file) {
        auto created = SoundFile::create(*file, existing);
        if (!created.ok()) return created.error();
        made->file_ = std::move(*created);
    }
    if (loudspeakers) made->output_.emplace(made->ticks_);
    return made;
}

void WindowSound::take(HeardTick tick, std::int64_t passed) {
    tick.muted = is_muted();
    if (fingers_silent_.load(std::memory_order_relaxed)) tick.fingers = {};
    if (output_) ticks_->push(tick);
    if (is_filmed_.load(std::memory_order_acquire)) {
        const auto since = std::chrono::steady_clock::now() - film_begun_;
        film_->take(tick, passed, *clip_, std::chrono::floor<std::chrono::milliseconds>(since).count());
    }
    if (!file_) return;
    for (std::int64_t k = std::min(passed, longest_gap); k > 1; --k) {
        kept_.render(going_on(tick), *clip_, samples_);
        file_->add(samples_);
    }
    kept_.render(tick, *clip_, samples_);
    file_->add(samples_);
}

void WindowSound::film(FilmedSound::Keep keep, std::chrono::steady_clock::time_point begun) {
    film_.emplace(std::move(keep));
    film_begun_ = begun;
    is_filmed_.store(true, std::memory_order_release);
}

std::string WindowSound::state() const {
    if (is_muted()) return "sound off";
    if (std::string fault = clip_->fault(); !fault.empty()) return fault;
    return output_ ? output_->state() : "no sound without a window";
}

Result<void> WindowSound::finish() {
    return file_ ? file_->finish() : Result<void>();
}

}  // namespace touchable
