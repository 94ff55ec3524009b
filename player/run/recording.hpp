#pragma once

// Recordings of a run: what is needed to repeat it to the bit, and its forces (docs/recording.md has the
// format).
//
// A RecordingFile is a sink of ticks: a header (format version, rules of force, scene, settings) and for each
// tick its goals, frames and forces. read_recording reads one that is whole or that ends early, of this
// format or an older one; a newer one is refused by name. RepeatingHand gives the goals of a recording again,
// over another surface.
//
// The bytes come from outside: every count and length is checked before memory is taken for it. A file and a
// hand are one thread's.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "device/hand.hpp"
#include "engine/base/same_bits.hpp"
#include "player/run/output_file.hpp"
#include "player/run/playback.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

inline constexpr int recording_format_version = 2;

/// One tick of a recording; `goals`, `forces` and `guards` have one element per finger.
struct RecordedTick {
    std::int64_t time_ns = 0, frame_prev = 0, frame_next = 0;
    double blend = 0;
    std::uint64_t epoch = 0;         ///< of those frames
    std::vector<glm::dvec3> goals;   ///< world, scene units, as the hand gave them
    std::vector<glm::dvec3> forces;  ///< guarded, newtons
    std::vector<std::uint32_t> guards;
};

/// All that a run needs to be repeated: what was set (`facts`: clip, scene, fingers, settings, hashes), and
/// what happened tick by tick. On disk (docs/recording.md): little-endian ticks and commands, the facts as
/// JSON, sizes, and an XXH64 of it all, so that a file cut short or changed is refused.
struct RecordedPart {
    std::string name;  ///< as messages call it: "recording FILE", with its number where there are more
    nlohmann::ordered_json facts;
    int fingers = 0;
    std::vector<RecordedTick> ticks;
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

}  // namespace touchable
