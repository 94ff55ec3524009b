#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "engine/new_file.hpp"
#include "engine/result.hpp"
#include "player/audio/filmed_sound.hpp"
#include "player/audio/heard_ticks.hpp"
#include "player/audio/sound_file.hpp"
#include "player/audio/sound_output.hpp"

namespace touchable {

/// What fingers in the window feel is heard, beside the clip's own sound: by loudspeakers, in a file, or
/// both.
class WindowSound {
public:
    /// `file`: what is kept, whether there are loudspeakers or not. Those are opened on a thread of their
    /// own.
    static Result<std::unique_ptr<WindowSound>> create(bool loudspeakers,
                                                       const std::optional<std::filesystem::path>& file,
                                                       Existing existing);

    /// A session's thread, one at a time. `passed`: ticks since the one before, of which the others are not
    /// known.
    void take(HeardTick tick, std::int64_t passed);
    /// Another session's ticks come next. Any thread.
    void begin_session() {
        if (is_filmed_.load(std::memory_order_acquire)) film_->align();
    }

    // The window's.
    /// The clip's own sound, if it has any, is that of this file from now on.
    void open_clip(const std::filesystem::path& file) { clip_->open(file); }
    /// A film that began at `begun` gets what is heard from now on. Once; sessions end before `keep` does.
    void film(FilmedSound::Keep keep, std::chrono::steady_clock::time_point begun);
    void set_muted(bool muted) { muted_.store(muted, std::memory_order_relaxed); }
    /// No finger is heard; the clip's own sound is.
    void silence_fingers(bool silent) { fingers_silent_.store(silent, std::memory_order_relaxed); }
    bool is_muted() const { return muted_.load(std::memory_order_relaxed); }
    /// Why a clip with a sound track is silent, or in part; otherwise nothing.
    std::string clip_fault() const { return clip_->fault(); }
    /// Why the file gets no more; nothing where it does, or there is none.
    std::optional<Error> file_fault() const { return file_ ? file_->fault() : std::nullopt; }
    /// In a few words, for a person.
    std::string state() const;
    /// Completes the file. After the last session's end.
    Result<void> finish();

private:
    WindowSound() = default;

    std::atomic<bool> muted_{false}, fingers_silent_{false};
    std::shared_ptr<ClipSound> clip_ = std::make_shared<ClipSound>();
    std::shared_ptr<HeardTicks> ticks_ = std::make_shared<HeardTicks>(clip_);
    std::optional<FilmedSound> film_;
    std::chrono::steady_clock::time_point film_begun_;
    std::atomic<bool> is_filmed_{false};
    std::unique_ptr<SoundFile> file_;
    HeardSound kept_;  // what the file has: of every tick, whatever the loudspeakers do
    ContactSound::Samples samples_{};
    std::optional<SoundOutput> output_;
};

}  // namespace touchable
