// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `info` tells of a clip, and `touch` of a run: facts and findings, as words and as JSON.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/scene.hpp"
#include "player/draw/pictures.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/clip_choice.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// A scene's filters in words and as values, which of them were chosen by measurement, and the measurements:
/// docs/forces.md.
nlohmann::ordered_json filters_json(const Scene& scene, const std::optional<ChosenFilters>& chosen,
                                    const std::optional<MeasuredDepth>& measured);

/// Steepness of one step of the depth staircase: depth step of one code / width of one pixel at that depth.
struct Kappa {
    double depth = 0;  ///< scene units
    double kappa = 0;
};

/// All facts of a clip that `info` prints.
struct ClipFacts {
    std::string clip;
    Scene scene;                          ///< as applied for touch
    std::optional<ChosenFilters> chosen;  ///< nothing: all stated
    std::vector<TrackInfo> tracks;
    std::optional<std::int64_t> frames;
    std::vector<std::string> notes;
    std::string unit_doubt;  ///< one of the notes; empty: the unit is plausible
    double fov_x_degrees = 0, fov_y_degrees = 0;
    double invalid_pct = 0;  ///< share of the first frame's stored values
    double nearest = 0,
           farthest = 0;  ///< valid depths of the first frame, scene units; both 0: none
    /// Share of the first frame's neighbouring pixels with depths that differ by more than a factor of 2.
    double torn = 0;
    std::optional<MeasuredDepth> measured;  ///< nothing: no pixel of the first frames is valid
    /// Bars of a force's direction in one of the first frames (ErrorBar), degrees: a tenth, half, and nine
    /// tenths of its surface have less. Nothing: not known.
    std::optional<std::array<double, 3>> error_degrees;
    bool bars_hold = false;  ///< somewhere (error_bars_hold); false: they count in the verdict only
    Kappa near, mid, far;    ///< at the near plane (metric without one: `nearest`), between, at far

    bool has_track(const std::string& role) const {
        return std::ranges::find(tracks, role, &TrackInfo::role) != tracks.end();
    }
};

/// Reads the description and the first frames; both can fail.
Result<ClipFacts> clip_facts(const ClipChoice& choice);

/// The picture in which findings are drawn.
struct VerifyPicture {
    std::optional<std::filesystem::path> file;
    Existing existing = Existing::keep;
};

/// A fault of a clip that would feel wrong.
struct Finding {
    std::string name;      ///< one word, for a program: "registration"
    std::string what;      ///< for the user, with figures
    std::string mend;      ///< the remedy: a command, or otherwise what to do
    std::string colour{};  ///< of its marks in the picture, "red"; empty: no marks
};

/// Findings and the measures behind them.
struct Verified {
    std::vector<Finding> findings;
    bool drawn = false;  ///< a picture was written
    nlohmann::ordered_json measures;
    std::string measures_in_words;
};

/// Reads the whole clip, finds faults that would feel wrong and draws their places.
Result<Verified> verify_clip(const ClipChoice& choice, const ClipFacts& facts, const VerifyPicture& picture);

/// Lines to follow the clip's facts.
std::string verified_in_words(const Verified& verified);
/// Adds `findings` and `measures`.
void add_verified(const Verified& verified, nlohmann::ordered_json& json);

/// The next step for a user who wants to touch the clip, in one line: "good to touch: touchable play CLIP",
/// or the one change that would help most. `findings`: verify_clip's; nullptr: not run.
std::string verdict_on(const ClipFacts& facts, const std::vector<Finding>* findings);

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

nlohmann::ordered_json to_json(const StreamFigures::Link& link);

}  // namespace touchable
