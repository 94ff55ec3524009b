#pragma once

// Files that a run writes tick by tick: tables of forces, a device's log, and what they have in common.
//
// An OutputFile appears whole or not at all where a run can be repeated, and is kept as far as it came where
// it cannot (Pace). OutputSink is the base of what takes ticks and writes them. docs/forces.md has the
// columns.
//
// The thread that takes a session's ticks writes; nothing is written by the haptic thread.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/files.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

/// A file that somebody asked for (`--json FILE`), or standard output (`--json -`). A file is opened before
/// the work that fills it, so that a place where nothing can be written is known at once, and has its name
/// only when it is complete: whatever goes wrong leaves nothing behind, and an older file as it was. Where
/// the disk is full, a run by the wall clock keeps the pieces that are whole by then.
class OutputFile {
public:
    /// `what`: for messages, as whoever asked for it calls it: "--forces", "the recording". An error of kind
    /// input where nothing can be written there.
    static Result<std::unique_ptr<OutputFile>> create(std::string what, const std::filesystem::path& file,
                                                      Existing existing, Pace pace = Pace::own);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// What is whole together or not there. After an error nothing more is taken.
    Result<void> write(std::string_view piece);
    /// For messages: "--forces f.csv", "the recording f.touch".
    std::string name() const;
    Pace pace() const { return pace_; }
    /// Gives the file its name. Nothing may be written after that. An error where anything is missing; by the
    /// wall clock the file is there nevertheless, with the pieces before, where there are two or more.
    Result<void> finish();
    /// Whether what went wrong is that nobody reads standard output, or not fast enough.
    bool reader_lags() const { return standard_ && standard_->reader_lags(); }

    // For who knows how such a file ends, also earlier than it was to.
    /// Writes out what waits for more.
    Result<void> flush();
    /// Bytes of the pieces that are whole.
    std::uint64_t size() const { return size_; }
    /// Other bytes for some that stand there.
    Result<void> write_over(std::uint64_t at, std::string_view bytes);
    /// What stands there; empty where it cannot be read.
    std::string read(std::uint64_t at, std::size_t size) const;
    /// Only the first `size` bytes, and what is written from now on.
    Result<void> go_on_from(std::uint64_t size);
    /// Gives it its name as it is.
    Result<void> keep();

private:
    OutputFile(std::string what, const std::filesystem::path& file, Existing existing, Pace pace);
    Error failed(int why) const;
    int write_out();

    std::string what_;
    Pace pace_;
    std::optional<NewFile> file_;
    std::optional<StandardOutput> standard_;  ///< in place of a file
    int out_ = -1;
    std::string waiting_;            // of the file, until there is enough to write
    std::vector<std::size_t> ends_;  // of the pieces in it
    std::uint64_t size_ = 0;         // of the file
    std::size_t pieces_ = 0;         // in it
    std::optional<Error> fault_;
};

/// Of outputs that are finished each for itself: what went wrong first, and behind it what else did.
Result<void> all_ok(const std::vector<Result<void>>& finished);

/// What a run writes of every tick. A disk that is full, or gone, ends the file and not the run: nothing more
/// is taken. A reader of standard output that lags behind a live run, or a person who asks to stop while one
/// is waited for, ends the run.
class OutputSink : public TouchSink {
public:
    Result<void> take(const TouchTick& tick) final {
        if (is_faulty_) return {};
        auto kept = write(tick);
        if (kept.ok()) return kept;
        is_faulty_ = true;
        if (kept.error().kind == ErrorKind::interrupted || file_->reader_lags()) return kept;
        spoil(kept.error());
        return {};
    }
    /// Why it takes no more ticks; any thread.
    std::optional<Error> fault() const {
        const std::lock_guard lock(mutex_);
        return fault_;
    }
    std::string name() const { return file_->name(); }  ///< as OutputFile has it

protected:
    explicit OutputSink(std::unique_ptr<OutputFile> file) : file_(std::move(file)) {}
    virtual Result<void> write(const TouchTick& tick) = 0;
    bool is_faulty() const { return is_faulty_; }
    /// Nothing more is taken. By the thread that takes, or after it.
    void spoil(const Error& why) {
        is_faulty_ = true;
        const std::lock_guard lock(mutex_);
        if (!fault_) fault_ = why;
    }

    const std::unique_ptr<OutputFile> file_;

private:
    bool is_faulty_ = false;  // the thread's that takes
    mutable std::mutex mutex_;
    std::optional<Error> fault_;  // guarded by it
};

/// `--forces FILE`, or `-` for standard output: a header, then one row per tick and finger with all it takes
/// to check a force with another program. World axes, scene units, newtons, N/m; numbers to 17 digits, so
/// exactly the bits that were felt.
class ForcesFile final : public OutputSink {
public:
    static Result<std::unique_ptr<ForcesFile>> create(const std::filesystem::path& file, Existing existing,
                                                      Pace pace, std::string name);
    /// Gives the file its name, as OutputFile does; without this nothing is left behind.
    Result<void> finish() { return file_->finish(); }

private:
    using OutputSink::OutputSink;
    Result<void> write(const TouchTick& tick) override;

    std::string rows_;  // of one tick
};

/// A tick as a device had it.
struct DeviceTick {
    std::int64_t tick = 0;
    std::uint32_t buttons = 0;
    double age_s = 0;                       ///< of the positions
    bool exerts = false;                    ///< forces were on, and not kept back
    std::span<const glm::dvec3> places{};   ///< device metres, not a number where there was none
    std::span<const glm::dvec3> newtons{};  ///< as given to the device
};

/// Ticks of a device on their way from the haptic thread to a file.
class DeviceTickLog {
public:
    DeviceTickLog(int ticks, int fingers);

    /// Haptic thread; neither waits nor allocates. One for which there is no room is lost, and counted.
    void push(const DeviceTick& tick);
    /// Reader. Hands the oldest tick to `take`; false where there is none.
    template <class Take>
    bool pop(const Take& take) {
        return ring_.pop([&take](const Slot& slot) { take(slot.tick); });
    }
    std::int64_t lost() const { return lost_.load(std::memory_order_relaxed); }

private:
    struct Slot {
        DeviceTick tick;
        std::vector<glm::dvec3> places, newtons;
    };
    static std::vector<Slot> slots_for(int ticks, int fingers);

    SpscRing<Slot> ring_;
    std::atomic<std::int64_t> lost_{0};
};

/// `--device-log FILE`, or `-`: a row for each tick and finger (docs/devices.md, Logs). Replays as a device.
class DeviceLogFile final : public OutputSink {
public:
    /// `log` outlives it. Only live runs have one. `name`: as OutputFile has it, here and wherever one is
    /// made.
    static Result<std::unique_ptr<DeviceLogFile>> create(const std::filesystem::path& file, Existing existing,
                                                         DeviceTickLog& log, std::string name);
    /// Gives the file its name, as OutputFile does. Error: ticks are missing.
    Result<void> finish();

private:
    DeviceLogFile(std::unique_ptr<OutputFile> file, DeviceTickLog& log)
        : OutputSink(std::move(file)), log_(log) {}
    /// All that has come by now.
    Result<void> write(const TouchTick&) override;

    DeviceTickLog& log_;
    std::string rows_;
};

}  // namespace touchable
