#pragma once

// Files of a run: what is written tick by tick, what repeats a run to the bit, and tables of forces that are
// read again and compared.
//
// An OutputFile appears whole or not at all where a run can be repeated, and is kept as far as it came where
// it cannot (Pace). OutputSink is the base of the sinks that write: TickTable (forces, a device's log) and
// RecordingFile, which keeps a header (format version, rules of force, scene, settings) and for each tick its
// goals, frames and forces. `read_recording` reads one that is whole or that ends early, of this format or an
// older one; a newer one is refused by name. RepeatingHand gives the goals of a recording again, over another
// surface. `read_force_table` and `compare_forces` are for tables of forces. docs/forces.md has the columns,
// docs/touch.md the format.
//
// Errors name the file, its line and what would be right. Bytes that are read come from outside: every count
// and length is checked before memory is taken for it. The thread that takes a session's ticks writes;
// nothing is written by the haptic thread, which only leaves ticks in a DeviceTickLog.

#include <array>
#include <atomic>
#include <glm/vec3.hpp>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>

#include "device/hand.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/same_bits.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "player/run/playback.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

class StandardOutput;

// ---- Files that are written

/// By which clock a run goes, and so what becomes of its files.
enum class Pace {
    own,         ///< it can be repeated: it waits for its readers, and a file is whole or not there
    wall_clock,  ///< it cannot: it waits for no reader, and what a full disk has taken of a file is kept
};

/// An output file of a command (`--json FILE`), or standard output (`--json -`). A file is opened before
/// the work that fills it, so that a place where nothing can be written is known at once, and has its name
/// only when it is complete: whatever goes wrong leaves nothing behind, and an older file as it was. Where
/// the disk is full, a run by the wall clock keeps the pieces that are whole by then.
class OutputFile : NonCopyable {
public:
    /// `what`: the program's name for it in messages: "--forces", "the recording". An error of kind input
    /// where nothing can be written there.
    static Result<std::unique_ptr<OutputFile>> create(std::string what, const std::filesystem::path& file,
                                                      Existing existing, Pace pace = Pace::own);
    ~OutputFile();

    /// What is whole together or not there. After an error nothing more is taken.
    Result<void> write(std::string_view piece);
    /// For messages: "--forces f.csv", "the recording f.touch".
    std::string name() const { return what_ + ' ' + (file_ ? file_->target().string() : "-"); }
    Pace pace() const { return pace_; }
    /// Gives the file its name. Nothing may be written after that. An error where anything is missing; by the
    /// wall clock the file is there nevertheless, with the pieces before, where there are two or more.
    Result<void> finish();
    /// Whether what went wrong is that standard output is not read, or not fast enough.
    bool reader_lags() const;

    // For a format that knows how such a file ends, also earlier than it was to.
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
    std::unique_ptr<StandardOutput> standard_;  // in place of a file
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
        if (kept) return kept;
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

/// Ticks of a device on their way from the haptic thread to a file.
class DeviceTickLog {
public:
    /// A tick as a device had it.
    struct Tick {
        std::int64_t tick = 0;
        std::uint32_t buttons = 0;
        double age_s = 0;                       ///< of the positions
        bool exerts = false;                    ///< forces were on, and not kept back
        std::span<const glm::dvec3> places{};   ///< device metres, not a number where there was none
        std::span<const glm::dvec3> newtons{};  ///< as given to the device
    };

    DeviceTickLog(int ticks, int fingers)
        : ring_(std::vector<Slot>(static_cast<std::size_t>(ticks), Slot(static_cast<std::size_t>(fingers)))) {
    }

    /// Haptic thread; neither waits nor allocates. One for which there is no room is lost, and counted.
    void push(const Tick& tick);
    /// Reader. Hands the oldest tick to `take`; false where there is none.
    template <class Take>
    bool pop(const Take& take) {
        return ring_.pop([&take](const Slot& slot) { take(slot.tick); });
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

/// A table with rows for each tick. Numbers have 17 digits, so exactly the bits that there were.
class TickTable : public OutputSink {
public:
    /// `--forces FILE`, or `-` for standard output: a header, then one row per tick and finger with all it
    /// takes to check a force with another program. World axes, scene units, newtons, N/m (docs/forces.md).
    static Result<std::unique_ptr<TickTable>> create_forces(const std::filesystem::path& file,
                                                            Existing existing, Pace pace, std::string name);
    /// `--device-log FILE`, or `-`: a row for each tick and finger (docs/devices.md, Logs), of a live run.
    /// Replays as a device. `log` outlives it.
    static Result<std::unique_ptr<TickTable>> create_device_log(const std::filesystem::path& file,
                                                                Existing existing, DeviceTickLog& log,
                                                                std::string name);
    /// Gives the file its name, as OutputFile does; without this nothing is left behind. Error: ticks are
    /// missing.
    virtual Result<void> finish() { return file_->finish(); }

protected:
    using OutputSink::OutputSink;
};

// ---- Recordings

inline constexpr int recording_format_version = 2;

/// All that a run needs to be repeated: what was set (`facts`: clip, scene, fingers, settings, hashes), and
/// what happened tick by tick. On disk (docs/touch.md): little-endian ticks and commands, the facts as
/// JSON, sizes, and an XXH64 of it all, so that a file cut short or changed is refused.
struct RecordedPart {
    /// One tick of a recording; `goals`, `forces` and `guards` have one element per finger.
    struct Tick {
        std::int64_t time_ns = 0, frame_prev = 0, frame_next = 0;
        double blend = 0;
        std::uint64_t epoch = 0;         ///< of those frames
        std::vector<glm::dvec3> goals;   ///< world, scene units, as the hand gave them
        std::vector<glm::dvec3> forces;  ///< guarded, newtons
        std::vector<std::uint32_t> guards;
    };

    std::string name;  ///< as messages call it: "recording FILE", with its number where there are more
    nlohmann::ordered_json facts;
    int fingers = 0;
    std::vector<Tick> ticks;
    std::vector<PlaybackCommand> playback;  ///< what was asked of the clip's clock; none in format 1

    /// The rules of force it was made under (haptics_cpu/touch_step.hpp), once the facts have been read.
    int rules() const { return facts.value("rules", 1); }
};
/// One part or more, each a run by settings of its own, one after the other. All have as many fingers.
using Recording = std::vector<RecordedPart>;
/// Refuses what is not a recording, is damaged, is not whole, or is of a newer version.
Result<Recording> read_recording(const std::filesystem::path& file);

/// `--record FILE`. A part has ended once it is said to; what comes after it is another one. A part without
/// ticks is left out, unless there is no other. Where a disk became full under a live run, the recording ends
/// with the last tick for which there is room, its facts included, and replays up to there.
class RecordingFile final : public OutputSink {
public:
    static Result<std::unique_ptr<RecordingFile>> create(const std::filesystem::path& file, int fingers,
                                                         Existing existing, Pace pace = Pace::own,
                                                         std::string name = "the recording");
    /// Of the ticks since the last part: the facts, and the clock's commands.
    void end_part(nlohmann::ordered_json facts, std::vector<PlaybackCommand> playback);
    /// The clip of the last part ends with this frame, for which see `why`: so does the recording, and takes
    /// no more ticks.
    void end_with_frame(std::int64_t last, const Error& why);
    /// Ends the last part, and gives the file its name; without this nothing is left behind. An error where
    /// ticks are missing, which says up to where it is kept.
    Result<void> finish(nlohmann::ordered_json facts, std::vector<PlaybackCommand> playback);

private:
    RecordingFile(std::unique_ptr<OutputFile> file, int fingers)
        : OutputSink(std::move(file)), fingers_(fingers) {}
    Result<void> write(const TouchTick& tick) override;
    Result<void> begin_part();
    Result<void> write_end(bool goes_on);
    Result<void> add(const std::string& bytes);

    struct Part {
        std::uint64_t begin = 0;  // in the file
        std::uint64_t ticks = 0;
        nlohmann::ordered_json facts{};
        std::vector<PlaybackCommand> playback{};
        bool has_ended = false;  // what is to be written behind its ticks is known
    };
    std::string tail_of(std::size_t part, std::uint64_t ticks, bool goes_on) const;
    Result<void> keep_whole_ticks(const Error& why);
    std::uint64_t ticks_up_to(std::int64_t frame) const;
    Result<std::optional<std::int64_t>> end_with(std::size_t part, std::uint64_t ticks);
    std::size_t tick_bytes() const;

    const int fingers_;
    std::vector<Part> parts_;
    std::optional<ByteHash> hash_;  // of what is written of the last one
    std::uint64_t bytes_ = 0;       // all that was written
    std::optional<std::int64_t> last_frame_;
    std::string tick_;
};

/// `--hand rec:FILE[:depth=MM]`: the very goals of a recording, over whatever is touched now, in the scene
/// units and with the device's metres per scene unit of then. Two runs of it compare: with one filter and
/// another, one solver and another.
class RepeatingHand final : public Hand {
public:
    static bool is_meant(std::string_view hand) { return hand.starts_with("rec:"); }
    /// `hand` as typed. Refuses (ErrorKind::usage) unknown keys, and what `read_recording` refuses.
    static Result<std::unique_ptr<RepeatingHand>> read(const std::string& hand);

    int fingers() const override { return recording_.fingers; }
    /// The latest goals that had been recorded by then.
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override;
    std::optional<std::int64_t> ticks() const override;
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
    std::size_t at_ = 0;  // the recorded tick whose goals were given last
};

// ---- Tables of forces

/// A forces file: `fingers` samples of each tick, ticks from 0 on.
struct ForceTable {
    /// What one finger did in one tick, of a forces file (docs/forces.md).
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

/// Reads what `touch --forces` wrote. Refuses (ErrorKind::input, with file and line) a table without its
/// columns, and rows that are not every finger of every tick in order.
Result<ForceTable> read_force_table(const std::string& file);

/// What differs between two runs of the same hand, sample by sample (a sample: one finger in one tick).
struct ForceComparison {
    /// Mean, the value that 95 % are not above, and the largest.
    struct Deviation {
        double mean = 0, p95 = 0, max = 0;
    };

    /// Frequencies that a hand tells apart: what it follows, what it feels as flutter, as vibration, as a
    /// hum.
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

    std::int64_t ticks = 0;  ///< that both have
    int fingers = 0;
    std::int64_t other_goals = 0;  ///< samples whose goals differ: they are not compared any further
    /// Samples, by who touches.
    std::int64_t both = 0, only_a = 0, only_b = 0, neither = 0;
    // Of the samples where both touch.
    double mean_a_n = 0, mean_b_n = 0;  ///< |A|, |B|
    double longer_n = 0;                ///< mean of |A| - |B|
    Deviation difference_n;             ///< |A - B|
    /// Between A and B, where both are `least_newtons` long.
    Deviation direction_degrees;
    static constexpr double least_newtons = 0.05;
    /// RMS of the force in each band, N, while both touch without a break; nothing where they never do for
    /// `noise_window` ticks.
    std::array<double, noise_bands.size()> noise_a_n{}, noise_b_n{};
    static constexpr std::size_t noise_window = 256;
    std::int64_t noise_windows = 0;
    std::vector<WorstTick> worst;  ///< up to five, at least 50 ms apart, the worst first
};

/// Refuses (ErrorKind::usage) runs of different numbers of fingers, and such as have no goal in common.
Result<ForceComparison> compare_forces(const ForceTable& a, const ForceTable& b);

}  // namespace touchable
