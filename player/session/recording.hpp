#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine/byte_hash.hpp"
#include "player/session/output_file.hpp"
#include "player/session/playback_clock.hpp"
#include "player/session/touch_session.hpp"

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
struct Recording {
    nlohmann::ordered_json facts;
    int fingers = 0;
    std::vector<RecordedTick> ticks;
    std::vector<PlaybackCommand> playback;  ///< what was asked of the clip's clock; none in format 1

    /// The rules of force it was made under (haptics_cpu/force_rules.hpp), once the facts have been read.
    int rules() const { return facts.value("rules", 1); }
};
/// Refuses what is not a recording, is damaged, or is of a newer version.
Result<Recording> read_recording(const std::filesystem::path& file);

/// `--record FILE`.
class RecordingFile final : public TouchSink {
public:
    static Result<std::unique_ptr<RecordingFile>> create(const std::filesystem::path& file, int fingers,
                                                         Existing existing);
    Result<void> take(const TouchTick& tick) override;
    /// Adds the clock's commands and the facts, and gives the file its name; without this nothing is left
    /// behind.
    Result<void> finish(const nlohmann::ordered_json& facts, const std::vector<PlaybackCommand>& playback);

private:
    explicit RecordingFile(std::unique_ptr<OutputFile> file) : file_(std::move(file)) {}
    Result<void> write(const std::string& bytes);

    std::unique_ptr<OutputFile> file_;
    ByteHash hash_;  // of what is written
    std::uint64_t ticks_ = 0;
    std::string bytes_;  // of one tick
};

}  // namespace touchable
