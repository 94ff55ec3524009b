#include "player/window/window_files.hpp"

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

Result<void> write_screenshot(const Image& image, const fs::path& file, Existing existing) {
    NewFile out(file, existing);
    TRY(out.check());
    TRY(write_png(out, image.view()));
    return out.commit();
}

Result<void> write_now(const TextFiles::Text& text) {
    if (text.check) TRY(text.check(text.file));
    std::error_code failed;
    if (text.file.has_parent_path()) fs::create_directories(text.file.parent_path(), failed);
    if (failed)
        return input_error(text.file.parent_path().string() + ": cannot be made: " + failed.message());
    NewFile file(text.file);
    TRY(file.check());
    TRY(file.write(text.text));
    return file.commit();
}

}  // namespace

struct Screenshots::Files {
    explicit Files(Write by) : write(std::move(by)) {}

    void write_next(const Image& image);
    void give_up();

    const Write write;
    std::mutex mutex;
    // Guarded by it.
    std::deque<fs::path> waiting;  // the first one is being written; empty: it has no name yet
    std::vector<Result<fs::path>> done;
    bool is_given_up = false;
};

void Screenshots::Files::write_next(const Image& image) {
    std::unique_lock lock(mutex);
    if (is_given_up) return;
    fs::path name = waiting.front();
    if (name.empty()) {
        lock.unlock();
        name = free_name();
        lock.lock();
        if (is_given_up) return;
        waiting.front() = name;
    }
    lock.unlock();
    const Result<void> written = write(image, name);
    lock.lock();
    if (is_given_up) return;
    done.push_back(written ? Result<fs::path>(std::move(name)) : written.error());
    waiting.pop_front();
}

void Screenshots::Files::give_up() {
    const std::lock_guard lock(mutex);
    is_given_up = true;
    for (const fs::path& name : waiting)
        done.push_back(disk_does_not_answer(name.empty() ? "the window's picture" : name));
    waiting.clear();
}

Screenshots::Screenshots(Write write) : files_(std::make_shared<Files>(std::move(write))) {}

Screenshots::Screenshots(Existing existing)
    : Screenshots([existing](const Image& image, const fs::path& name) {
          return write_screenshot(image, name, existing);
      }) {}

Result<void> Screenshots::keep(Image image, fs::path name) {
    if (!disk_) {
        TRY_ASSIGN(disk_, DiskWork::start("screenshots", "that writes pictures of the window"));
    }
    {
        const std::lock_guard lock(files_->mutex);
        if (files_->waiting.size() == most_waiting)
            return input_error("the window's picture is not kept: " + std::to_string(most_waiting) +
                               " earlier ones are still being written");
        files_->waiting.push_back(std::move(name));
    }
    disk_->give([files = files_, image = std::move(image)] { files->write_next(image); });
    return {};
}

std::vector<Result<fs::path>> Screenshots::take() {
    const std::lock_guard lock(files_->mutex);
    return std::exchange(files_->done, {});
}

void Screenshots::finish(std::chrono::milliseconds longest) {
    if (!disk_) return;
    if (!disk_->finish(longest)) files_->give_up();
    disk_.reset();
}

struct TextFiles::Files {
    /// False: it has the place of one that waits.
    bool add(Text text);
    void write_next();
    void give_up();
    void note(const Text& text, Result<void> result) {
        done.push_back({text.file, text.kind, text.clip, std::move(result)});
    }

    std::mutex mutex;
    // Guarded by it.
    std::deque<Text> waiting;  // where one lies it stays: only the thread takes it away
    bool is_writing = false;   // the first one
    std::vector<Written> done;
    bool is_given_up = false;
};

bool TextFiles::Files::add(Text text) {
    const std::lock_guard lock(mutex);
    const auto earlier = std::find_if(waiting.begin() + (is_writing ? 1 : 0), waiting.end(),
                                      [&text](const Text& waits) { return waits.file == text.file; });
    const bool is_another = earlier == waiting.end();
    if (is_another)
        waiting.push_back(std::move(text));
    else
        *earlier = std::move(text);
    return is_another;
}

void TextFiles::Files::write_next() {
    std::unique_lock lock(mutex);
    if (is_given_up) return;
    is_writing = true;
    const Text& text = waiting.front();
    lock.unlock();
    auto written = write_now(text);
    lock.lock();
    if (!is_given_up) note(text, std::move(written));
    waiting.pop_front();
    is_writing = false;
}

void TextFiles::Files::give_up() {
    const std::lock_guard lock(mutex);
    is_given_up = true;
    for (const Text& text : waiting) note(text, disk_does_not_answer(text.file));
}

TextFiles::TextFiles() : files_(std::make_shared<Files>()) {}

std::function<bool()> TextFiles::waits_for(const fs::path& file) const {
    return [files = files_, file] {
        const std::lock_guard lock(files->mutex);
        return !files->is_given_up &&
               std::ranges::any_of(files->waiting, [&](const Text& text) { return text.file == file; });
    };
}

void TextFiles::write(Text text) {
    if (!disk_) {
        auto started = DiskWork::start("text-files", "that writes what is painted");
        if (!started) {
            const std::lock_guard lock(files_->mutex);
            return files_->note(text, started.error());
        }
        disk_ = std::move(*started);
    }
    if (files_->add(std::move(text))) disk_->give([files = files_] { files->write_next(); });
}

std::vector<TextFiles::Written> TextFiles::take() {
    const std::lock_guard lock(files_->mutex);
    return std::exchange(files_->done, {});
}

void TextFiles::finish(std::chrono::milliseconds longest) {
    if (!disk_) return;
    if (!disk_->finish(longest)) files_->give_up();
    disk_.reset();
}

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
    if (place <= last_place_ || !encoded_) return false;
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
    if (sound_waits_ + samples.size() > most_sound || !encoded_) return;
    const bool goes_on =
        !sounds_.empty() && sounds_.back().first + std::ssize(sounds_.back().samples) == sample;
    if (!goes_on) sounds_.push_back({sample, {}});
    sounds_.back().samples.insert(sounds_.back().samples.end(), samples.begin(), samples.end());
    sound_waits_ += samples.size();
    if (sound_waits_ > much_sound) changed_.notify_all();
}

std::optional<Error> WindowFilm::fault() {
    const std::lock_guard lock(mutex_);
    return encoded_ ? std::nullopt : std::optional(encoded_.error());
}

bool WindowFilm::has_work() const {
    return !waiting_.empty() || sound_waits_ > much_sound || (stopping_ && sound_waits_ > 0);
}

Result<void> WindowFilm::encode(const std::optional<Picture>& picture, const std::vector<Sound>& sounds) {
    if (picture) TRY(film_->add(picture->image.view(), picture->place));
    for (const Sound& sound : sounds) TRY(film_->add_sound(sound.first, sound.samples));
    return {};
}

/// Until it is to stop and nothing waits, or the film cannot be written.
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
    }
}

Result<void> WindowFilm::finish(double seconds) {
    stop();
    const auto end = static_cast<std::int64_t>(std::ceil(seconds * FilmWriter::pictures_per_second));
    pictures_ = std::max(end, last_place_ + 1);
    return film_->finish(pictures_);
}

}  // namespace touchable
