// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cmath>
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

/// Maximum number of screenshots waiting for their disk.
inline constexpr std::size_t most_screenshots = 4;
/// Writes a screenshot as a PNG file, under this name or, if it is empty, a free one. `existing`: the
/// treatment of an existing file.
BackgroundWriter::Job screenshot(Image image, std::filesystem::path name, Existing existing);

/// Writes a file completely or not at all; creates missing folders.
Result<void> write_text(const std::filesystem::path& file, std::string_view text);
/// Returns an error to keep an existing file from being replaced. Owns all its data.
using TextCheck = std::function<Result<void>(const std::filesystem::path& file)>;
/// Writes a text as `write_text` does. A queued text for the same file is not written: this one takes its
/// place in the queue.
BackgroundWriter::Job text_file(std::filesystem::path file, std::string text, std::string tag = {},
                                TextCheck check = {});

/// A film of the window's picture and sound, encoded on a separate thread. What comes too fast is dropped, so
/// that the window does not wait; a film of which nothing may be left out (`is_whole`) lets it wait.
class WindowFilm : NonCopyable {
public:
    static Result<std::unique_ptr<WindowFilm>> create(const std::filesystem::path& file, Existing existing,
                                                      int rate = FilmWriter::usual_rate,
                                                      bool is_whole = false);
    ~WindowFilm() { stop(); }

    // For the window's thread.
    /// Whether a picture is due that was not wanted before.
    bool is_due(double seconds) const { return place_at(seconds) > last_place_; }
    /// Whether the film needs a picture of this moment, and has room for it; times must not go backward.
    bool wants(double seconds);
    /// Adds the picture last wanted, RGB.
    void add(Image picture);
    /// Arguments as in FilmWriter. Call after the first picture; any thread.
    void add_sound(std::int64_t sample, std::span<const StereoSample> samples);
    /// Why encoding stopped; nullopt: it continues.
    std::optional<Error> fault() {
        const std::lock_guard lock(mutex_);
        return encoded_ ? std::nullopt : std::optional(encoded_.error());
    }
    /// Pictures dropped for lack of room.
    std::int64_t left_out() const { return left_out_; }
    /// Number of pictures in the finished film.
    std::int64_t pictures() const { return pictures_; }
    /// Completes the file, `seconds` after the first picture. Fails if it could not be written; then there is
    /// no file, or, if its disk became full, the part that fitted.
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
    WindowFilm(std::unique_ptr<FilmWriter> film, int rate, bool is_whole)
        : film_(std::move(film)), rate_(rate), is_whole_(is_whole) {}
    /// Exact for whole nanoseconds.
    std::int64_t place_at(double seconds) const {
        return std::llround(seconds * 1e9) * rate_ / 1'000'000'000;
    }
    bool has_work() const {
        return !waiting_.empty() || sound_waits_ > much_sound || (stopping_ && sound_waits_ > 0);
    }
    void encode();
    Result<void> encode(const std::optional<Picture>& picture, const std::vector<Sound>& sounds);
    void stop();

    static constexpr std::size_t most_waiting = 4;  // pictures, including the one being encoded
    // Sound samples: enough that pictures rarely lack their sound, and the maximum.
    static constexpr std::size_t much_sound = SoundTrack::rate / 2, most_sound = 10 * SoundTrack::rate;
    std::unique_ptr<FilmWriter> film_;
    const int rate_;
    const bool is_whole_;
    std::int64_t last_place_ = -1, left_out_ = 0, pictures_ = 0;
    std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by `mutex_`.
    std::deque<Picture> waiting_;
    std::size_t in_use_ = 0;
    std::vector<Sound> sounds_;
    std::size_t sound_waits_ = 0;  // samples in sounds_
    bool stopping_ = false;
    Result<void> encoded_;
    std::thread thread_;
};

}  // namespace touchable
