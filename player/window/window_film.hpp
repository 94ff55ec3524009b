#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/clip/film_writer.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {

/// What the window shows, and what is heard, as a film. Both are encoded on a thread of their own; what finds
/// no room there is left out, so that nobody waits.
class WindowFilm {
public:
    static Result<std::unique_ptr<WindowFilm>> create(const std::filesystem::path& file, Existing existing);
    ~WindowFilm();
    WindowFilm(const WindowFilm&) = delete;
    WindowFilm& operator=(const WindowFilm&) = delete;

    // The window's.
    /// Whether the film has a place for a picture of this moment, and room for it; times do not go backward.
    bool wants(double seconds);
    /// RGB; the one that it wanted last.
    void add(Image picture);
    /// FilmWriter's. After the first picture; any thread.
    void add_sound(std::int64_t sample, std::span<const StereoSample> samples);
    /// Why it gets no more; nothing where it does.
    std::optional<Error> fault();
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
    bool has_work() const;
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
