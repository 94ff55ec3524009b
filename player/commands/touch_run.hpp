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

/// Report of a run (docs/forces.md). `live`: facts of a live session, nullptr in virtual time; `painter`: the
/// picture's, or nullptr. Names are part of the interface: add to them, do not rename.
nlohmann::ordered_json make_report(const TouchSetup& setup, const TouchFigures& figures,
                                   const LiveFacts* live, const SurfacePainter* painter);
/// Report of a replay of several parts: the figures of `all`, and each part's report in "parts".
nlohmann::ordered_json join_reports(const std::vector<nlohmann::ordered_json>& parts,
                                    const TouchFigures& all);
/// The same as a text table; several parts follow each other.
std::string report_to_text(const nlohmann::ordered_json& report);
/// Short report: warnings, what was touched, the force, whether the run is sound, and where the figures are.
/// `files`: the files written; nothing: none requested.
std::string report_in_short(const nlohmann::ordered_json& report,
                            const std::optional<std::vector<std::string>>& files);

/// Options of a run and its outputs.
struct TouchOptions {
    /// With `replay` only the builder and the clip are used; an empty clip: the recorded one.
    SessionOptions session;
    HeldDeviceWords held;
    std::optional<std::filesystem::path> json, forces, record, replay, device_log;
    std::optional<std::filesystem::path> play;  ///< already read into `session.playback`
    Existing existing = Existing::keep;         ///< treatment of existing output files
    bool verbose = false;                       ///< print the whole table
    bool strict = false;                        ///< warnings are an error of kind check
    PictureOptions picture;
    std::optional<std::int64_t> picture_tick;  ///< nothing: 60 % of the run
};

/// Touches a clip at 1 kHz, in virtual time or (live) on the wall clock, prints a table and writes the
/// requested files. With `replay`, repeats a recording: the first different force is an error of kind check
/// that names tick and finger. A live run ended by the user is complete and returns an error that states its
/// length.
Result<void> run_touch(const TouchOptions& options);

/// `touch --picture`: stores the fingers at a moment of the run and their trails just before; after the run,
/// reads that moment's frames again and draws them.
class TouchPicture final : public TouchSink {
public:
    /// `tick`: the moment; if ticks are skipped, the first tick not before it.
    TouchPicture(PictureOrder order, std::int64_t tick) : order_(std::move(order)), tick_(tick) {}
    Result<void> consume(const TouchTick& tick) override;
    bool is_reached() const { return reached_; }  ///< whether the moment was reached
    const SurfacePainter& painter() const { return *order_.painter; }
    /// Draws the moment. If the run ended before it: draws the last tick if `cut_short`,
    /// otherwise refused (ErrorKind::usage).
    Result<void> finish(const TouchSetup& setup, bool cut_short);
    /// A line about the picture; empty before `finish`.
    const std::string& line() const { return line_; }

private:
    using Place = glm::dvec2;  // proxy in the image, pixels
    struct Moment {
        std::uint64_t epoch = 0;
        std::int64_t frame_prev = 0, frame_next = 0;
        double blend = 0;
        std::vector<FingerMark> fingers;  // trails are still empty
    };
    std::vector<FingerMark> fingers_on(const HeightField& field) const;

    PictureOrder order_;
    std::int64_t tick_;
    std::vector<std::deque<Place>> trails_;  // per finger, since its last contact began
    std::optional<Moment> moment_;           // the newest tick, until the moment
    bool reached_ = false;
    std::string line_;
};

/// The requested files of a run: opened before it, so that unwritable places are reported at once, and named
/// after it, so that a failed run leaves none. A full disk ends neither the run nor the other files.
class TouchOutputs {
public:
    /// Refuses files that are also inputs or named twice, existing files that may not be replaced, and a
    /// picture of a moment beyond the run's end, if its length is known. `ticks`: length of all parts, if
    /// known. `options` must outlive this.
    static Result<std::unique_ptr<TouchOutputs>> open(const TouchOptions& options, const TouchSetup& setup,
                                                      std::optional<std::int64_t> ticks);

    /// The outputs that take every tick.
    std::vector<TouchSink*> sinks();
    /// The file of a sink, for messages: "--forces f.csv"; empty: writes none during the run.
    std::string name_of(const TouchSink* sink) const;
    /// The picture's painter; nullptr: no picture.
    const SurfacePainter* painter() const;
    /// After a part that is not the last: draws the picture if its moment was in the part.
    Result<void> end_part(const TouchSetup& setup);
    /// Whether the run has no more use: its only output is a pipe that its reader has closed.
    bool are_unread() const { return only_forces_ && forces_->is_unread(); }
    /// Faults of outputs since the last call; each is reported once.
    std::vector<std::string> new_faults();
    /// After the run's last part, that of `setup`: completes every file even if others fail. An error names
    /// the incomplete ones.
    Result<void> finish(const nlohmann::ordered_json& report, const std::string& force_hash,
                        const TouchSetup& setup);
    /// The files completed by `finish`, without standard output; nothing: none requested.
    const std::optional<std::vector<std::string>>& written() const { return written_; }
    /// A remark to print after the table; may be empty.
    std::string remark() const { return picture_ ? picture_->line() : std::string(); }

private:
    explicit TouchOutputs(const TouchOptions& options) : options_(options) {}
    Result<void> finish_record(const std::string& force_hash, const TouchSetup& setup);

    const TouchOptions& options_;
    std::optional<std::vector<std::string>> written_;
    std::unique_ptr<TickTable> forces_, device_log_;
    std::unique_ptr<RecordingFile> record_;
    std::unique_ptr<OutputFile> json_;
    std::optional<TouchPicture> picture_;
    bool only_forces_ = false;             // nothing else is written, checked or felt
    bool is_drawn_ = false;                // the picture is drawn
    std::shared_ptr<CameraCapture> film_;  // beside the recording
    std::set<const void*> told_;           // outputs whose fault was reported
};

}  // namespace touchable
