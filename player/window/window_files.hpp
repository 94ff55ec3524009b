#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <span>
#include <thread>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/picture/image.hpp"
#include "player/window/background_writer.hpp"

namespace touchable {

/// Pictures of the window that may wait for their disk.
inline constexpr std::size_t most_screenshots = 4;
/// Writes a picture of the window as a PNG file, under this name or, if it is empty, a free one.
/// `existing`: what becomes of a file that is there.
BackgroundWriter::Job screenshot(Image image, std::filesystem::path name, Existing existing);

/// Whole or not at all; folders that are missing are made.
Result<void> write_text(const std::filesystem::path& file, std::string_view text);
/// Refuses to replace a file that is there: why. It owns all that it uses.
using TextCheck = std::function<Result<void>(const std::filesystem::path& file)>;
/// Writes a text as `write_text` does. A text for the same file that still waits is not written any more:
/// this one has its place, before those that came after it.
BackgroundWriter::Job text_file(std::filesystem::path file, std::string text, std::string tag = {},
                                TextCheck check = {});

/// A film of what the window shows, and of what is heard. Both are encoded on a thread of their own; pictures
/// and sound that come too fast for it are left out, so that the window does not wait.
class WindowFilm : NonCopyable {
public:
    static Result<std::unique_ptr<WindowFilm>> create(const std::filesystem::path& file, Existing existing);
    ~WindowFilm() { stop(); }

    // The window's.
    /// Whether the film has a place for a picture of this moment, and room for it; times do not go backward.
    bool wants(double seconds);
    /// RGB; the one that it wanted last.
    void add(Image picture);
    /// FilmWriter's. After the first picture; any thread.
    void add_sound(std::int64_t sample, std::span<const StereoSample> samples);
    /// Why it gets no more; nothing where it does.
    std::optional<Error> fault() {
        const std::lock_guard lock(mutex_);
        return encoded_ ? std::nullopt : std::optional(encoded_.error());
    }
    /// Pictures that found no room.
    std::int64_t left_out() const { return left_out_; }
    /// In the film, once it is finished.
    std::int64_t pictures() const { return pictures_; }
    /// Completes the file, so long after the first picture. An error where it could not be written; then
    /// there is none, or, where its disk became full, what there was room for.
    Result<void> finish(double seconds);

private:
    struct Picture {
        Image image;
        std::int64_t place;
    };
    struct Sound {
        std::int64_t first;
        std::vector<StereoSample> samples;
    };
    explicit WindowFilm(std::unique_ptr<FilmWriter> film) : film_(std::move(film)) {}
    bool has_work() const {
        return !waiting_.empty() || sound_waits_ > much_sound || (stopping_ && sound_waits_ > 0);
    }
    void encode();
    Result<void> encode(const std::optional<Picture>& picture, const std::vector<Sound>& sounds);
    void stop();

    static constexpr std::size_t most_waiting = 4;  // pictures, with the one that is being encoded
    // Of sound; so much that pictures rarely have it wait in vain, and so much at most.
    static constexpr std::size_t much_sound = SoundTrack::rate / 2, most_sound = 10 * SoundTrack::rate;
    std::unique_ptr<FilmWriter> film_;
    std::int64_t last_place_ = -1, left_out_ = 0, pictures_ = 0;
    std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by it.
    std::deque<Picture> waiting_;
    std::size_t in_use_ = 0;
    std::vector<Sound> sounds_;
    std::size_t sound_waits_ = 0;  // samples of them
    bool stopping_ = false;
    Result<void> encoded_;
    std::thread thread_;
};

}  // namespace touchable
