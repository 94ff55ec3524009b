// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files of a run: tables written tick by tick, recordings that repeat a run to the bit, and tables of forces
// that are read again and compared.
//
// An OutputFile appears whole or not at all if the run can be repeated; otherwise it is kept up to a failure
// (Pace). OutputSink is the base of the sinks that write: TickTable (forces, a device's log) and
// RecordingFile, which keeps a header (format version, rules of force, scene, settings) and for each tick its
// goals, frames and forces. `read_recording` reads recordings of this format or an older one, also those that
// were ended early; a newer format is refused by name. RepeatingHand repeats a recording's goals over another
// surface; a ReplayCheck compares each tick of a replay with the recorded one, and judge_replay tells the
// first difference. `read_force_table` and `compare_forces` are for tables of forces. docs/forces.md has the
// columns, docs/touch.md the format.
//
// Errors name the file, its line and the valid values. Files read are untrusted: every count and length is
// checked before memory is allocated for it.
// Threads: the one that consumes a session's ticks writes the files; the haptic thread only pushes ticks to a
// DeviceTickLog.

#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <glm/vec3.hpp>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>

#include "device/hand.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/same_bits.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

// ---- Output files

/// The clock that drives a run; decides how its output files treat slow readers and full disks.
enum class Pace {
    own,         ///< repeatable run: waits for its readers; a table is whole or absent
    wall_clock,  ///< live run: never waits for a reader; when the disk is full, the file so far is kept
};

/// Standard output as a file of a run, for a reader that may be slow or not read at all. Every wait can be
/// ended. Pace::own waits until the data is read or a stop is requested (an error then). Pace::wall_clock
/// does not wait, except in `finish` for a reader that still reads, until a stop is requested.
class StandardOutput {
public:
    /// Pace::wall_clock: pieces that may wait, four seconds of ticks.
    static constexpr std::size_t most_waiting = 4096;

    /// At a live run's end: a reader must take least_taken bytes, or the rest, within end_patience.
    static constexpr std::size_t least_taken = 1 << 16;
    static constexpr std::chrono::milliseconds end_patience{4000};

    explicit StandardOutput(Pace pace, std::chrono::milliseconds patience = end_patience)
        : pace_(pace), patience_(patience) {}
    /// Errors (ErrorKind::input): a write failed, or the reader lags behind.
    Result<void> write(std::string_view piece);
    /// Waits until everything is read.
    Result<void> finish();
    /// Whether its reader has closed the pipe.
    bool is_unread() const { return gone_; }
    /// Whether the error was a lagging reader.
    bool reader_lags() const { return lags_; }

private:
    enum class Taken { some, nothing_yet };
    Result<Taken> give(int patience_ms);
    Result<void> give_all();
    Error lagging();
    std::string_view rest() const { return std::string_view(waiting_).substr(given_); }

    Pace pace_;
    std::chrono::milliseconds patience_;
    std::string waiting_;                // begins with the given_ bytes already written
    std::size_t given_ = 0;              // bytes
    std::deque<std::size_t> ends_;       // ends of the waiting pieces, bytes from the run's beginning
    std::size_t written_ = 0, all_ = 0;  // bytes from the run's beginning
    bool gone_ = false, lags_ = false;
};

/// An output file of a command (`--json FILE`), or standard output (`--json -`). A file is opened before the
/// work that fills it, so that an unwritable place is reported at once. It gets its name only when complete:
/// a failure leaves no file behind and an older file unchanged. If the disk becomes full, Pace::wall_clock
/// keeps the pieces written whole.
class OutputFile : NonCopyable {
public:
    /// `what`: its name in messages: "--forces", "the recording". Unwritable, or being written by another run
    /// of this machine: an error of kind input.
    static Result<std::unique_ptr<OutputFile>> create(std::string what, const std::filesystem::path& file,
                                                      Existing existing, Pace pace = Pace::own);
    ~OutputFile();

    /// Writes a piece whole or not at all. After an error every call fails.
    Result<void> write(std::string_view piece);
    /// For messages: "--forces f.csv", "the recording f.touch".
    std::string name() const { return what_ + ' ' + (file_ ? file_->target().string() : "-"); }
    Pace pace() const { return pace_; }
    /// Gives the file its name; no writes after that. Error: data is missing; with Pace::wall_clock the file
    /// is kept nevertheless with its whole pieces, if there are two or more.
    Result<void> finish();
    /// Whether the error is that standard output is not read fast enough.
    bool reader_lags() const { return standard_ && standard_->reader_lags(); }
    /// Whether standard output's reader has closed the pipe, which is no error.
    bool is_unread() const { return standard_ && standard_->is_unread(); }

    // For a format that can end its file early.
    /// Writes the buffered pieces.
    Result<void> flush();
    /// Size of the pieces written whole, bytes.
    std::uint64_t size() const { return size_; }
    /// Overwrites bytes at `at`.
    Result<void> write_over(std::uint64_t at, std::string_view bytes);
    /// `size` bytes from `at`; empty if unreadable.
    std::string read(std::uint64_t at, std::size_t size) const;
    /// Truncates to `size` bytes, clears the error and continues there.
    Result<void> go_on_from(std::uint64_t size);
    /// Gives the file its name as it is.
    Result<void> keep();

private:
    OutputFile(std::string what, const std::filesystem::path& file, Existing existing, Pace pace);
    Error failed(int why) const;
    int write_out();

    std::string what_;
    Pace pace_;
    std::optional<NewFile> file_;
    std::optional<StandardOutput> standard_;  // used instead of a file
    int out_ = -1;
    std::string waiting_;            // buffered pieces
    std::vector<std::size_t> ends_;  // ends of the pieces in waiting_
    std::uint64_t size_ = 0;         // bytes of the file
    std::size_t pieces_ = 0;         // pieces in the file
    std::optional<Error> fault_;
};

/// Joins the results of several outputs: the first error, followed by the other messages.
Result<void> all_ok(const std::vector<Result<void>>& finished);

/// Writes every tick of a run. A full or missing disk ends the file, not the run: later ticks are ignored. A
/// reader of standard output that lags behind a live run, or a stop request while waiting for the reader,
/// ends the run.
class OutputSink : public TouchSink {
public:
    Result<void> consume(const TouchTick& tick) final {
        if (is_faulty_) return {};
        auto kept = write(tick);
        if (kept) return kept;
        is_faulty_ = true;
        if (kept.error().kind == ErrorKind::interrupted || file_->reader_lags()) return kept;
        spoil(kept.error());
        return {};
    }
    /// Why it takes no more ticks. Any thread.
    std::optional<Error> fault() const {
        const std::lock_guard lock(mutex_);
        return fault_;
    }
    std::string name() const { return file_->name(); }  ///< OutputFile::name
    bool is_unread() const { return file_->is_unread(); }

protected:
    explicit OutputSink(std::unique_ptr<OutputFile> file) : file_(std::move(file)) {}
    virtual Result<void> write(const TouchTick& tick) = 0;
    bool is_faulty() const { return is_faulty_; }
    /// Ignore all later ticks. Called by the thread that calls `consume`, or after it has ended.
    void spoil(const Error& why) {
        is_faulty_ = true;
        const std::lock_guard lock(mutex_);
        if (!fault_) fault_ = why;
    }

    const std::unique_ptr<OutputFile> file_;

private:
    bool is_faulty_ = false;  // used by the thread that calls `consume`
    mutable std::mutex mutex_;
    std::optional<Error> fault_;  // guarded by mutex_
};

/// Queue of a device's ticks from the haptic thread to a file.
class DeviceTickLog {
public:
    /// A device's positions, forces and state at a tick.
    struct Tick {
        std::int64_t tick = 0;
        std::uint32_t buttons = 0;
        double age_s = 0;                       ///< age of the positions
        bool exerts = false;                    ///< forces were on and not held back
        std::span<const glm::dvec3> places{};   ///< device metres; NaN: no position
        std::span<const glm::dvec3> newtons{};  ///< as sent to the device
    };

    DeviceTickLog(int ticks, int fingers)
        : ring_(std::vector<Slot>(static_cast<std::size_t>(ticks), Slot(static_cast<std::size_t>(fingers)))) {
    }

    /// Haptic thread; neither waits nor allocates. Without room the tick is dropped and counted.
    void push(const Tick& tick);
    /// Reader. Passes the oldest tick to `consume`; false: none.
    template <class Consume>
    bool pop(const Consume& consume) {
        return ring_.pop([&consume](const Slot& slot) { consume(slot.tick); });
    }
    std::int64_t lost() const { return lost_.load(std::memory_order_relaxed); }

private:
    struct Slot {
        explicit Slot(std::size_t fingers) : places(fingers), newtons(fingers) {}
        Tick tick;
        std::vector<glm::dvec3> places, newtons;
    };

    SpscRing<Slot> ring_;
    std::atomic<std::int64_t> lost_{0};
};

/// A table with rows per tick. Numbers have 17 digits, which preserves their bits.
class TickTable : public OutputSink {
public:
    /// `--forces FILE`, or `-` for standard output: a header, then one row per tick and finger with
    /// everything needed to check a force with another program. World axes, scene units, newtons, N/m
    /// (docs/forces.md).
    static Result<std::unique_ptr<TickTable>> create_forces(const std::filesystem::path& file,
                                                            Existing existing, Pace pace, std::string name);
    /// `--device-log FILE`, or `-`: one row per tick and finger of a live run (docs/devices.md, Logs). Can be
    /// replayed as a device. `log` must outlive it.
    static Result<std::unique_ptr<TickTable>> create_device_log(const std::filesystem::path& file,
                                                                Existing existing, DeviceTickLog& log,
                                                                std::string name);
    /// Gives the file its name (OutputFile::finish); without this no file is left. Error: ticks are missing.
    virtual Result<void> finish() { return file_->finish(); }

protected:
    using OutputSink::OutputSink;
};

// ---- Recordings

inline constexpr int recording_format_version = 2;

/// Everything needed to repeat a run: its settings (`facts`: clip, scene, fingers, settings, hashes) and its
/// ticks. On disk (docs/touch.md): little-endian ticks and commands, the facts as JSON, sizes, and an XXH64
/// of it all, so that a truncated or changed file is refused.
struct RecordedPart {
    /// A tick of a recording; `goals`, `forces` and `guards` have one element per finger.
    struct Tick {
        std::int64_t time_ns = 0, frame_prev = 0, frame_next = 0;
        double blend = 0;
        std::uint64_t epoch = 0;         ///< of frame_prev and frame_next
        std::vector<glm::dvec3> goals;   ///< world, scene units, as given by the hand
        std::vector<glm::dvec3> forces;  ///< guarded, newtons
        std::vector<std::uint32_t> guards;
    };

    std::string name;  ///< name in messages: "recording FILE", with the number if there are several
    nlohmann::ordered_json facts;
    int fingers = 0;
    std::vector<Tick> ticks;
    std::vector<PlaybackCommand> playback;  ///< commands to the clip's clock; none in format 1

    /// Version of the force rules of this recording (haptics_cpu/touch_step.hpp); needs `facts`.
    int rules() const { return facts.value("rules", 1); }
};
/// One or more consecutive parts, each a run with its own settings. All have the same number of fingers.
using Recording = std::vector<RecordedPart>;
/// Refuses files that are not recordings, damaged, incomplete or of a newer version.
Result<Recording> read_recording(const std::filesystem::path& file);

/// `--record FILE`. `end_part` ends a part; the next tick begins another. A part without ticks is left out
/// unless it is the only one. If the disk becomes full, the recording ends with the last tick that fits
/// together with its facts, and replays up to there.
class RecordingFile final : public OutputSink {
public:
    static Result<std::unique_ptr<RecordingFile>> create(const std::filesystem::path& file, int fingers,
                                                         Existing existing, Pace pace = Pace::own,
                                                         std::string name = "the recording");
    /// Ends the part: facts and clock commands of the ticks since the previous part.
    void end_part(nlohmann::ordered_json facts, std::vector<PlaybackCommand> playback);
    /// The last part's clip ended with this frame because of `why`: the recording ends there and takes no
    /// more ticks.
    void end_with_frame(std::int64_t last, const Error& why);
    /// Ends the last part and gives the file its name; without this no file is left. Error: ticks are
    /// missing; says up to where it is kept.
    Result<void> finish(nlohmann::ordered_json facts, std::vector<PlaybackCommand> playback);

private:
    RecordingFile(std::unique_ptr<OutputFile> file, int fingers)
        : OutputSink(std::move(file)), fingers_(fingers) {}
    Result<void> write(const TouchTick& tick) override;
    Result<void> begin_part();
    Result<void> write_end(bool goes_on);
    Result<void> add(const std::string& bytes);

    struct Part {
        std::uint64_t begin = 0;  // offset in the file
        std::uint64_t ticks = 0;
        nlohmann::ordered_json facts{};
        std::vector<PlaybackCommand> playback{};
        bool has_ended = false;  // its facts and commands are known
    };
    std::string tail_of(std::size_t part, std::uint64_t ticks, bool goes_on) const;
    Result<void> keep_whole_ticks(const Error& why);
    std::uint64_t ticks_up_to(std::int64_t frame) const;
    Result<std::optional<std::int64_t>> end_with(std::size_t part, std::uint64_t ticks);
    std::size_t tick_bytes() const;

    const int fingers_;
    std::vector<Part> parts_;
    std::optional<ByteHash> hash_;  // of the last part so far
    std::uint64_t bytes_ = 0;       // all bytes written
    std::optional<std::int64_t> last_frame_;
    std::string tick_;
};

/// `--hand rec:FILE[:depth=MM]`: a recording's exact goals over the present clip, in the recording's scene
/// units and device metres per scene unit. For comparing two runs, for example with different filters or
/// solvers.
class RepeatingHand final : public Hand {
public:
    static bool is_meant(std::string_view hand) { return hand.starts_with("rec:"); }
    /// `hand` as typed. Refuses unknown keys (ErrorKind::usage) and invalid recordings as `read_recording`
    /// does.
    static Result<std::unique_ptr<RepeatingHand>> read(const std::string& hand);

    int fingers() const override { return recording_.fingers; }
    /// The latest goals recorded up to this tick.
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override;
    std::optional<std::int64_t> ticks() const override {
        return recording_.ticks.back().time_ns / tick_ns + 1;
    }
    std::optional<std::string> file() const override { return file_; }
    std::vector<std::string> remarks() const override { return watch_.remarks(); }
    double metres_per_scene_unit() const { return metres_per_scene_unit_; }

private:
    RepeatingHand(std::string file, RecordedPart recording, double metres_per_scene_unit,
                  const GoalWatch& watch)
        : file_(std::move(file)),
          recording_(std::move(recording)),
          metres_per_scene_unit_(metres_per_scene_unit),
          watch_(watch) {}

    std::string file_;
    RecordedPart recording_;  // all parts as one
    double metres_per_scene_unit_;
    GoalWatch watch_;
    std::size_t at_ = 0;  // the recorded tick whose goals were returned last
};

/// Compares each tick with the recorded one, bit for bit, and remembers the first difference.
class ReplayCheck final : public TouchSink {
public:
    /// Result of a part's replay.
    struct Outcome {
        int rules = 0;  ///< version of the force rules of the recording
        std::optional<std::string>
            difference;                 ///< first difference: tick, finger, both values; nothing: none
        bool has_other_frames = false;  ///< the clip's frames differ from the recorded ones
    };

    /// `recording`: its header was checked (read_recorded_facts).
    explicit ReplayCheck(const RecordedPart& recording) : recording_(recording) {}
    Result<void> consume(const TouchTick& tick) override;
    /// After the last tick. `force_hash`: of the part's ticks. `has_other_frames`: Outcome's.
    Outcome outcome(const std::string& force_hash, bool has_other_frames) const;

private:
    const RecordedPart& recording_;
    std::size_t next_ = 0;  // index of the next tick in the recording
    std::optional<std::string> difference_;
};

/// Judges a replay. Error of kind input if the recording was made under other rules of force, so that nothing
/// can be compared; of kind check if something differs, naming the first difference, its part, and whether
/// the clip's frames differ from the recorded ones. Else the message: a clip may have changed where no finger
/// went. `force_hash`: of all parts.
Result<std::string> judge_replay(std::span<const ReplayCheck::Outcome> parts, const std::string& force_hash);

// ---- Tables of forces

/// A forces file: `fingers` samples per tick, ticks from 0 on.
struct ForceTable {
    /// One finger at one tick in a forces file (docs/forces.md).
    struct Sample {
        glm::dvec3 goal{0.0};   ///< world, scene units
        glm::dvec3 force{0.0};  ///< N, guarded
        bool contact = false;
    };

    int fingers = 0;
    std::vector<Sample> samples;

    std::size_t ticks() const { return samples.size() / static_cast<std::size_t>(fingers); }
    const Sample& at(std::size_t tick, int finger) const {
        return samples[tick * static_cast<std::size_t>(fingers) + static_cast<std::size_t>(finger)];
    }
};

/// Reads a table of `touch --forces`. Refuses (ErrorKind::input, with file and line) missing columns, and
/// rows that do not list every finger of every tick in order.
Result<ForceTable> read_force_table(const std::string& file);

/// Differences between two runs of the same hand, per sample (one finger at one tick).
struct ForceComparison {
    /// Mean, 95th percentile and maximum.
    struct Deviation {
        double mean = 0, p95 = 0, max = 0;
    };

    /// Frequency bands that a hand distinguishes: motion it follows, flutter, vibration, hum.
    struct Band {
        double from_hz, to_hz;
    };
    static constexpr std::array<Band, 4> noise_bands{{{4, 30}, {30, 100}, {100, 300}, {300, 500}}};
    /// Tick and finger where two runs differ most.
    struct WorstTick {
        std::int64_t tick = 0;
        int finger = 0;
        double newtons = 0;  ///< |A - B|
    };

    std::int64_t ticks = 0;  ///< common to both
    int fingers = 0;
    std::int64_t other_goals = 0;  ///< samples with different goals, otherwise not compared
    /// Samples by contact in A and B.
    std::int64_t both = 0, only_a = 0, only_b = 0, neither = 0;
    // Of samples with contact in both.
    double mean_a_n = 0, mean_b_n = 0;  ///< |A|, |B|
    double longer_n = 0;                ///< mean of |A| - |B|
    Deviation difference_n;             ///< |A - B|
    /// Angle between A and B if both are at least `least_newtons`.
    Deviation direction_degrees;
    static constexpr double least_newtons = 0.05;
    /// RMS of the force per band, N, while both touch without a break; 0 unless for `noise_window` ticks.
    std::array<double, noise_bands.size()> noise_a_n{}, noise_b_n{};
    static constexpr std::size_t noise_window = 256;
    std::int64_t noise_windows = 0;
    std::vector<WorstTick> worst;  ///< up to five, at least 50 ms apart, the worst first
};

/// Refuses (ErrorKind::usage) runs with different numbers of fingers or without a common goal.
Result<ForceComparison> compare_forces(const ForceTable& a, const ForceTable& b);

// ---- Commands to a clip's clock, as text

/// Reads commands to the clip's clock, one per line: "SECONDS play", "pause", "rate X", "seek SECONDS",
/// "step", "loop SECONDS SECONDS" or "unloop", in the order of their times (docs/touch.md). Empty lines and
/// text after '#' are ignored. Anything else is refused (ErrorKind::input) with `name` and the line.
Result<std::vector<PlaybackCommand>> parse_playback(std::string_view text, const std::string& name);
/// As parse_playback, from a file.
Result<std::vector<PlaybackCommand>> read_playback(const std::filesystem::path& file);

/// The commands as parse_playback's lines, joined by ", ".
std::string in_words(const std::vector<PlaybackCommand>& commands);
/// The settings that may have given these commands.
Hints settings_of(const std::vector<PlaybackCommand>& commands);

}  // namespace touchable
