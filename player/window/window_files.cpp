// SPDX-License-Identifier: Apache-2.0
#include "player/window/window_files.hpp"

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

fs::path free_name() {
    for (int number = 1;; ++number) {
        fs::path file = "touchable-" + std::to_string(number) + ".png";
        std::error_code ignored;
        if (!fs::exists(file, ignored)) return file;
    }
}

}  // namespace

BackgroundWriter::Job screenshot(Image image, fs::path name, Existing existing) {
    return {.file = std::move(name),
            .write = [image = std::move(image), existing](const fs::path& file) -> Result<void> {
                NewFile out(file, existing);
                TRY(out.check());
                TRY(write_png(out, image.view()));
                return out.commit();
            },
            .name = free_name};
}

Result<void> write_text(const fs::path& file, std::string_view text) {
    std::error_code failed;
    if (file.has_parent_path()) fs::create_directories(file.parent_path(), failed);
    if (failed) return input_error(file.parent_path().string() + ": cannot be made: " + failed.message());
    NewFile out(file);
    TRY(out.write(text));
    return out.commit();
}

BackgroundWriter::Job text_file(fs::path file, std::string text, std::string tag, TextCheck check) {
    return {.file = std::move(file),
            .write = [text = std::move(text), check = std::move(check)](const fs::path& to) -> Result<void> {
                if (check) TRY(check(to));
                return write_text(to, text);
            },
            .tag = std::move(tag),
            .replaces = true};
}

Result<std::unique_ptr<WindowFilm>> WindowFilm::create(const std::filesystem::path& file, Existing existing,
                                                       int rate, bool is_whole) {
    TRY_ASSIGN(auto film, FilmWriter::create(file, existing, rate));
    std::unique_ptr<WindowFilm> made(new WindowFilm(std::move(film), rate, is_whole));
    TRY(start_thread(made->thread_, "film-encoder", "of the film", [it = made.get()] { it->encode(); }));
    return made;
}

void WindowFilm::stop() {
    stop_thread(mutex_, stopping_, changed_, thread_);
}

bool WindowFilm::wants(double seconds) {
    constexpr std::chrono::milliseconds pause(20);
    if (!is_due(seconds)) return false;
    last_place_ = place_at(seconds);
    std::unique_lock lock(mutex_);
    while (is_whole_ && encoded_ && in_use_ == most_waiting && !stop_requested())
        changed_.wait_for(lock, pause);
    if (!encoded_) return false;
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
    if (sound_waits_ + samples.size() > most_sound || !encoded_) return;
    const bool goes_on =
        !sounds_.empty() && sounds_.back().first + std::ssize(sounds_.back().samples) == sample;
    if (!goes_on) sounds_.push_back({sample, {}});
    sounds_.back().samples.insert(sounds_.back().samples.end(), samples.begin(), samples.end());
    sound_waits_ += samples.size();
    if (sound_waits_ > much_sound) changed_.notify_all();
}

Result<void> WindowFilm::encode(const std::optional<Picture>& picture, const std::vector<Sound>& sounds) {
    if (picture) TRY(film_->add(picture->image.view(), picture->place));
    for (const Sound& sound : sounds) TRY(film_->add_sound(sound.first, sound.samples));
    return {};
}

/// Runs until stopped with nothing waiting, or until the film cannot be written.
void WindowFilm::encode() {
    std::unique_lock lock(mutex_);
    while (encoded_) {
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
        changed_.notify_all();
    }
}

Result<void> WindowFilm::finish(double seconds) {
    stop();
    pictures_ = std::max(place_at(seconds - 1e-9) + 1, last_place_ + 1);
    return film_->finish(pictures_);
}

}  // namespace touchable
