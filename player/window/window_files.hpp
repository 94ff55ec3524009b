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
#include "player/window/disk_work.hpp"

namespace touchable {

/// Pictures of the window that become files, on a thread of their own: a disk that does not answer keeps the
/// window from nothing, and the key that takes the force off least of all. All calls are the window's.
class Screenshots {
public:
    /// Writes a picture under this name. It owns all that it uses: it may outlive the window.
    using Write = std::function<Result<void>(const Image&, const std::filesystem::path&)>;

    /// PNG files; `existing`: what becomes of one that is there.
    explicit Screenshots(Existing existing);
    explicit Screenshots(Write write);
    /// Finishes.
    ~Screenshots() { finish(); }
    Screenshots(const Screenshots&) = delete;
    Screenshots& operator=(const Screenshots&) = delete;

    /// Under this name, or a free one where it is empty. An error where too many wait, or the machine has no
    /// thread left.
    Result<void> keep(Image image, std::filesystem::path name);
    /// The names of those that were written, or why one was not, since; oldest first.
    std::vector<Result<std::filesystem::path>> take();
    /// The last call but `take`: waits until all are written, for that long at most; then `take` has the
    /// rest, and those that are not finished as errors.
    void finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

    static constexpr std::size_t most_waiting = 4;

private:
    /// What the thread works on.
    struct Files;
    const std::shared_ptr<Files> files_;
    std::unique_ptr<DiskWork> disk_;  // from the first picture until the end
};

/// Texts that become files, in the order in which they are given, on a thread of their own: a disk that does
/// not answer keeps the window from nothing. All calls are the window's.
class TextFiles {
public:
    TextFiles();
    /// Finishes.
    ~TextFiles() { finish(); }
    TextFiles(const TextFiles&) = delete;
    TextFiles& operator=(const TextFiles&) = delete;

    /// Refuses, by the text of a file that is there, to replace it: why. It owns all that it uses: it may
    /// outlive the window.
    using Check = std::function<Result<void>(const std::filesystem::path& file)>;
    enum class Kind {
        history,  ///< which the window keeps by itself
        saved     ///< which a person asked for
    };
    struct Text {
        std::filesystem::path file;
        std::string text;
        Kind kind = Kind::history;
        std::string clip{};  ///< of which it is
        Check check{};
    };
    /// Whole or not at all; folders that are missing are made. A text that still waits and is for the same
    /// file is not written any more: this one has its place, before those that came after it.
    void write(Text text);
    /// Tells whether a text for this file is still to be written; for any thread, also after this has gone.
    std::function<bool()> waits_for(const std::filesystem::path& file) const;
    struct Written {
        std::filesystem::path file;
        Kind kind;
        std::string clip;
        Result<void> result;
    };
    /// Those that were written or refused since, oldest first.
    std::vector<Written> take();
    /// The last call but `take`: waits until all are written, for that long at most; then `take` has the
    /// rest, and those that are not finished as errors.
    void finish(std::chrono::milliseconds longest = std::chrono::seconds(2));

private:
    /// What the thread works on.
    struct Files;
    const std::shared_ptr<Files> files_;
    std::unique_ptr<DiskWork> disk_;  // from the first text until the end
};

/// A film of what the window shows, and of what is heard. Both are encoded on a thread of their own; pictures
/// and sound that come too fast for it are left out, so that the window does not wait.
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
