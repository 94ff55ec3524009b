#pragma once

#include <nlohmann/json.hpp>

#include "engine/authoring/recorded_clip.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

/// The filters that a scene has, in words and for a program, which of them were chosen by measurement, and
/// what was measured: docs/forces.md.
nlohmann::ordered_json filters_json(const Scene& scene, const std::optional<ChosenFilters>& chosen,
                                    const std::optional<MeasuredDepth>& measured);

/// How steep one step of the depth staircase feels: depth step of one code / width of one pixel, at that
/// depth.
struct Kappa {
    double depth = 0;  ///< scene units
    double kappa = 0;
};

/// All that `info` says of a clip.
struct ClipFacts {
    std::string clip;
    Scene scene;                          ///< as it is touched
    std::optional<ChosenFilters> chosen;  ///< nothing: all filters are stated
    std::vector<TrackInfo> tracks;
    std::optional<std::int64_t> frames;
    std::vector<std::string> notes;
    std::string unit_doubt;  ///< one of the notes; empty: the unit may be right
    double fov_x_degrees = 0, fov_y_degrees = 0;
    double invalid_pct = 0;  ///< of the first frame's stored values
    double nearest = 0,
           farthest = 0;  ///< valid depths of the first frame, scene units; both 0: none is valid
    /// Share of the first frame's neighbours of which one is more than twice as deep as the other.
    double torn = 0;
    std::optional<MeasuredDepth> measured;  ///< nothing: no pixel of the first frames is valid
    Kappa near, mid, far;  ///< at the near plane (metric without one: at `nearest`), between, at far

    bool has_track(const std::string& role) const {
        return std::ranges::find(tracks, role, &TrackInfo::role) != tracks.end();
    }
};

/// Reads the description and the first frames; both can fail.
Result<ClipFacts> clip_facts(const ClipChoice& choice);

/// Something of a clip that would feel wrong.
struct Finding {
    std::string name;  ///< one word, for a program: "registration"
    std::string what;  ///< for a person, with its figures
    std::string mend;  ///< what helps: a command, or where there is none what to do
    /// Pixels of the first frame, 1 where it is; nothing: it has no place.
    const std::vector<std::uint8_t>* where = nullptr;
};

/// The first frame, darkened, with the places of findings in their colours.
Image picture_of(const std::vector<Finding>& findings, const Image& first_frame);
/// "red": of the k-th finding; empty where the first frame shows nothing of it.
std::string colour_of(const std::vector<Finding>& findings, std::size_t k);

/// Where findings are to be drawn.
struct VerifyPicture {
    std::optional<std::filesystem::path> file;
    Existing existing = Existing::keep;
};

/// A finding as it is printed.
struct NamedFinding {
    std::string name, what, mend;
    std::string colour;  ///< of its marks in the picture; empty: it has none there
};

/// What was found, and the measures by which it was decided.
struct Verified {
    std::vector<NamedFinding> findings;
    bool drawn = false;  ///< into a picture
    nlohmann::ordered_json measures;
    std::string measures_in_words;
};

/// Reads the whole clip for what would feel wrong, and draws where.
Result<Verified> verify_clip(const ClipChoice& choice, const ClipFacts& facts, const VerifyPicture& picture);

/// Lines after the clip's facts.
std::string verified_in_words(const Verified& verified);
/// Adds `findings` and `measures`.
void add_verified(const Verified& verified, nlohmann::ordered_json& json);

/// What a person who wants to touch a clip should do next, in one line: "good to touch: touchable play CLIP",
/// or the one thing that would help most. With what reading all of it found, if that was done.
std::string verdict_on(const ClipFacts& facts, const std::vector<NamedFinding>* findings);

}  // namespace touchable
