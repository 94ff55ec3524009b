#pragma once

#include <nlohmann/json.hpp>

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

}  // namespace touchable
