#include "player/window/window_film.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"

namespace touchable {

Result<std::unique_ptr<WindowFilm>> WindowFilm::create(const std::filesystem::path& file, Existing existing) {
    TRY_ASSIGN(auto film, FilmWriter::create(file, existing));
    std::unique_ptr<WindowFilm> made(new WindowFilm(std::move(film)));
    TRY(start_thread(made->thread_, "film-encoder", "of the film", [it = made.get()] { it->encode(); }));
    return made;
}

WindowFilm::~WindowFilm() {
    stop();
}

void WindowFilm::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

bool WindowFilm::wants(double seconds) {
    const auto place = static_cast<std::int64_t>(std::floor(seconds * FilmWriter::pictures_per_second));
    const std::lock_guard lock(mutex_);
    if (place <= last_place_ || !encoded_.ok()) return false;
    last_place_ = place;
    if (in_use_ < most_waiting) return true;
    ++left_out_;
    return false;
}

void WindowFilm::add(Image picture) {
    {
        const std::lock_guard lock(mutex_);
        waiting_.push_back({std::move(picture), last_place_});
        ++in_use_;
    }
    changed_.notify_all();
}

void WindowFilm::add_sound(std::int64_t sample, std::span<const StereoSample> samples) {
    const std::lock_guard lock(mutex_);
    if (sound_waits_ + samples.size() > most_sound || !encoded_.ok()) return;
    const bool goes_on =
        !sounds_.empty() && sounds_.back().first + std::ssize(sounds_.back().samples) == sample;
    if (!goes_on) sounds_.push_back({sample, {}});
    sounds_.back().samples.insert(sounds_.back().samples.end(), samples.begin(), samples.end());
    sound_waits_ += samples.size();
    if (sound_waits_ > much_sound) changed_.notify_all();
}

std::optional<Error> WindowFilm::fault() {
    const std::lock_guard lock(mutex_);
    return encoded_.ok() ? std::nullopt : std::optional(encoded_.error());
}

bool WindowFilm::has_work() const {
    return !waiting_.empty() || sound_waits_ > much_sound || (stopping_ && sound_waits_ > 0);
}

Result<void> WindowFilm::encode(const std::optional<Picture>& picture, const std::vector<Sound>& sounds) {
    if (picture)
        if (auto added = film_->add(picture->image.view(), picture->place); !added.ok()) return added;
    for (const Sound& sound : sounds)
        if (auto added = film_->add_sound(sound.first, sound.samples); !added.ok()) return added;
    return {};
}

/// Until it is to stop and nothing waits, or the film cannot be written.
void WindowFilm::encode() {
    std::unique_lock lock(mutex_);
    while (encoded_.ok()) {
        changed_.wait(lock, [this] { return stopping_ || has_work(); });
        if (!has_work()) return;
        std::optional<Picture> picture;
        if (!waiting_.empty()) {
            picture = std::move(waiting_.front());
            waiting_.pop_front();
        }
        const std::vector<Sound> sounds = std::exchange(sounds_, {});
        sound_waits_ = 0;
        lock.unlock();
        auto added = encode(picture, sounds);
        lock.lock();
        encoded_ = std::move(added);
        if (picture) --in_use_;
    }
}

Result<void> WindowFilm::finish(double seconds) {
    stop();
    const auto end = static_cast<std::int64_t>(std::ceil(seconds * FilmWriter::pictures_per_second));
    pictures_ = std::max(end, last_place_ + 1);
    return film_->finish(pictures_);
}

}  // namespace touchable
