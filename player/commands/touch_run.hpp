#pragma once

#include <deque>
#include <glm/vec2.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "player/commands/run_options.hpp"
#include "player/draw/pictures.hpp"
#include "player/run/run_files.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/run_record.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// What a run came to (docs/forces.md). `live`: how the session on the wall clock went, nullptr for one of
/// virtual time; `painter`: the picture's, if there is one. Names are part of the interface: add to them, do
/// not rename.
nlohmann::ordered_json make_report(const TouchSetup& setup, const TouchFigures& figures,
                                   const LiveFacts* live, const SurfacePainter* painter);
/// Of a replay of several parts: what `all` figures say of them together, and in "parts" the report of each.
nlohmann::ordered_json join_reports(const std::vector<nlohmann::ordered_json>& parts,
                                    const TouchFigures& all);
/// The same as a table for a person; of several parts each after the other.
std::string report_to_text(const nlohmann::ordered_json& report);
/// What most people want to know of it: warnings, what was touched, the force, whether it is sound, and where
/// the figures are. `files`: those that were written; nothing where none was asked for.
std::string report_in_short(const nlohmann::ordered_json& report,
                            const std::optional<std::vector<std::string>>& files);

/// A run, and what is written of it.
struct TouchOptions {
    /// With `replay` only the builder and the clip, which may be empty: the recorded one then.
    SessionOptions session;
    HeldDeviceWords held;
    std::optional<std::filesystem::path> json, forces, record, replay, device_log;
    std::optional<std::filesystem::path> play;  ///< read into `session.playback` already
    Existing existing = Existing::keep;         ///< what becomes of earlier files of those names
    bool verbose = false;                       ///< prints the whole table
    bool strict = false;                        ///< what the report warns of is an error of kind check
    PictureOptions picture;
    std::optional<std::int64_t> picture_tick;  ///< nothing: usual_picture_tick
};

/// Touches a clip at 1 kHz, of virtual time or (live) of the wall clock, prints a table, and writes what was
/// asked for. With `replay`, does again what a recording holds: a first different force is an error of kind
/// check that names tick and finger. A live run that a person ends is complete, and an error that says how
/// long it was.
Result<void> run_touch(const TouchOptions& options);

/// `touch --picture`: remembers the fingers at a moment of the run and where they went just before; once the
/// run is over, reads the frames of that moment again and draws them.
class TouchPicture final : public TouchSink {
public:
    /// `tick`: the moment; the first tick that is not before it, where some are skipped.
    TouchPicture(PictureOrder order, std::int64_t tick) : order_(std::move(order)), tick_(tick) {}
    Result<void> take(const TouchTick& tick) override;
    bool is_reached() const { return reached_; }  ///< the moment
    const SurfacePainter& painter() const { return *order_.painter; }
    /// Draws. Where the run ended before the moment: its last tick, if it was `cut_short`, else refused
    /// (ErrorKind::usage).
    Result<void> finish(const TouchSetup& setup, bool cut_short);
    /// What was drawn, for a person; empty before `finish`.
    const std::string& line() const { return line_; }

private:
    using Place = glm::dvec2;  // of a proxy in the image, pixels
    struct Moment {
        std::uint64_t epoch = 0;
        std::int64_t frame_prev = 0, frame_next = 0;
        double blend = 0;
        std::vector<FingerMark> fingers;  // trails are still empty
    };
    std::vector<FingerMark> fingers_on(const HeightField& field) const;

    PictureOrder order_;
    std::int64_t tick_;
    std::vector<std::deque<Place>> trails_;  // of each finger, since it last came into contact
    std::optional<Moment> moment_;           // the newest tick, until the moment
    bool reached_ = false;
    std::string line_;
};

/// The tick that a picture shows by default: 60 % of the run, or of its shortest length (3 s) where
/// only reading the clip tells how long it is.
std::int64_t usual_picture_tick(const TouchSetup& setup);

/// The files that were asked for of a run: opened before it, so that what cannot be written is known at once,
/// and named after it, so that a run that fails leaves none. A full disk under one ends neither the run nor
/// another file.
class TouchOutputs {
public:
    /// Refuses names that are also inputs' or each other's, and files that are there already and may not be
    /// replaced, and a picture of a moment that the run does not come to, where its length is known. `ticks`:
    /// of all parts, where that is known. `options` outlive it.
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
    /// The files that `finish` has completed, but for standard output; nothing where none was asked for.
    const std::optional<std::vector<std::string>>& written() const { return written_; }
    /// What else there is to say of them after the table; may be empty.
    std::string remark() const { return picture_ ? picture_->line() : std::string(); }

private:
    explicit TouchOutputs(const TouchOptions& options) : options_(options) {}
    Result<void> finish_record(const std::string& force_hash, const TouchSetup& setup);
    Result<void> finish_json(const nlohmann::ordered_json& report);

    const TouchOptions& options_;
    std::optional<std::vector<std::string>> written_;
    std::unique_ptr<TickTable> forces_, device_log_;
    std::unique_ptr<RecordingFile> record_;
    std::unique_ptr<OutputFile> json_;
    std::optional<TouchPicture> picture_;
    bool is_drawn_ = false;                // the picture
    std::shared_ptr<CameraCapture> film_;  // beside the recording
    std::set<const void*> told_;           // of whose fault was told
};

}  // namespace touchable
