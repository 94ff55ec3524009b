#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "player/commands/touch_picture.hpp"
#include "player/commands/touch_run.hpp"
#include "player/record/forces_file.hpp"
#include "player/record/output_file.hpp"
#include "player/record/recording.hpp"
#include "player/session/touch_figures.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// The files that were asked for of a run: opened before it, so that what cannot be written is known at once,
/// and named after it, so that a run that fails leaves none. A full disk under one ends neither the run nor
/// another file.
class TouchOutputs {
public:
    /// Refuses names that are also inputs' or each other's, and files that are there already and may not be
    /// replaced. `ticks`: of all parts, where that is known.
    static Result<std::unique_ptr<TouchOutputs>> open(const TouchOptions& options, const TouchSetup& setup,
                                                      std::optional<std::int64_t> ticks);

    /// Those that want to know of every tick.
    std::vector<TouchSink*> sinks();
    /// The file of one of those, for messages: "--forces f.csv"; empty: it writes none as it goes.
    std::string name_of(const TouchSink* sink) const;
    /// Of the picture; nullptr where none is asked for.
    const SurfacePainter* painter() const;
    /// After a part that is not the last: draws the picture, where its moment was in it.
    Result<void> end_part(const TouchSetup& setup);
    /// What can no longer be written, each once, as it is met.
    std::vector<std::string> new_faults();
    /// After the run, or its last part, which was that of `setup`: completes every file, whatever becomes of
    /// the others. An error says of which something is missing.
    Result<void> finish(const nlohmann::ordered_json& report, const std::string& force_hash,
                        const TouchSetup& setup);
    /// What else there is to say of them after the table; may be empty.
    std::string remark() const { return picture_ ? picture_->line() : std::string(); }

private:
    TouchOutputs() = default;
    Result<void> finish_record(const std::string& force_hash, const TouchSetup& setup);
    Result<void> finish_json(const nlohmann::ordered_json& report);

    std::unique_ptr<ForcesFile> forces_;
    std::unique_ptr<DeviceLogFile> device_log_;
    std::unique_ptr<RecordingFile> record_;
    std::unique_ptr<OutputFile> json_;
    std::optional<TouchPicture> picture_;
    bool is_drawn_ = false;                // the picture
    std::shared_ptr<CameraCapture> film_;  // beside the recording
    std::set<const void*> told_;           // of whose fault was told
};

}  // namespace touchable
