#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "engine/media/film_writer.hpp"
#include "engine/media/image_file.hpp"
#include "engine/result.hpp"

namespace touchable {

/// What the window shows, as a film. Pictures are encoded on a thread of their own; one for which there is no
/// room there is left out, so that the window never waits.
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
    /// Pictures that found no room.
    std::int64_t left_out() const { return left_out_; }
    /// In the film, once it is finished.
    std::int64_t pictures() const { return pictures_; }
    /// Completes the file, so long after the first picture. An error where it could not be written; then
    /// there is none.
    Result<void> finish(double seconds);

private:
    struct Picture {
        Image image;
        std::int64_t place;
    };
    explicit WindowFilm(std::unique_ptr<FilmWriter> film) : film_(std::move(film)) {}
    void encode();
    void stop();

    static constexpr std::size_t most_waiting = 4;  // pictures, with the one that is being encoded
    std::unique_ptr<FilmWriter> film_;
    std::int64_t last_place_ = -1, left_out_ = 0, pictures_ = 0;
    std::mutex mutex_;
    std::condition_variable changed_;
    // Guarded by it.
    std::deque<Picture> waiting_;
    std::size_t in_use_ = 0;
    bool stopping_ = false;
    Result<void> encoded_;
    std::thread thread_;
};

}  // namespace touchable
