#pragma once

// A recording by itself, without its segments: what of it would feel wrong, and what it lacks.
//
// measure_quality reads a clip once and gives figures (the command `info`, when it verifies): colour that
// does not lie on depth, depth that pulses, frames that are missing or late, haptic values that no device
// renders. Nothing is judged here. with_filled_holes and with_relief give the clip with holes of its depth
// filled with what other frames saw there, or with heights that its colour suggests (docs/content.md):
// look_at_relief reads some frames, which tell how strong its details are.
//
// A reader is one thread's; a stop is heard between frames.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// N/mm. The stiffest that a hand-held device renders by what its makers and the literature say
/// (docs/devices.md); most render less.
inline constexpr double stiffest_of_devices = 3.0;

/// What was measured of a whole clip.
struct ClipQuality {
    /// How frames follow each other.
    struct FrameTimes {
        std::int64_t frames = 0;
        /// Whose depth, haptic and height are those of the one before, though the surface moves: it changes
        /// within longest_repeat frames before and after. A surface that stands still for longer is no fault.
        std::int64_t repeated = 0;
        std::int64_t changed = 0;        ///< that are others than the one before
        std::int64_t of_new_colour = 0;  ///< of those: colour has changed
        static constexpr std::int64_t longest_repeat = 4;
        double usual_ms = 0;       ///< from one to the next, the median
        std::int64_t missing = 0;  ///< as many fit into longer times
        std::int64_t jumps = 0;  ///< times that stand still, go back, or follow within a quarter of the usual
        double longest_ms = 0;
        std::int64_t longest_at = 0;  ///< the frame after it
    };
    /// How colour lies on depth: medians, in pixels of the depth plane.
    struct ColourFit {
        std::int64_t edges = 0;  ///< places that were compared
        /// Share of them within two steps of their median, across or down, whichever is less. Where colour
        /// lies far beside depth, by more than is looked at, edges of colour are found by chance, all over
        /// the window: then the other figures mean nothing.
        double agreement = 0;
        bool agrees() const { return agreement >= 0.45; }
        /// By how much colour lies to the right of depth, and below it. Nothing: too few edges face both
        /// ways.
        std::optional<double> right, below;
        /// By how much near surfaces reach beyond their colour, so that the background's colour lies on
        /// their rims; below 0: their colour reaches beyond them.
        double rim = 0;
    };
    /// What the haptic pictures of a clip ask of a device. Shares are of the pixels that have a surface.
    struct HapticValues {
        double stiffest = 0;      ///< N/mm
        double too_stiff = 0;     ///< share that is stiffer than stiffest_of_devices
        double more_dynamic = 0;  ///< share with dynamic friction above static friction
        /// Share that has the value of no neighbour on either side, though these agree among themselves:
        /// noise of a codec that mixes materials.
        double mixed = 0;
    };

    FrameTimes times;
    std::int64_t blank = 0;           ///< frames without any depth
    std::int64_t first_blank = 0;     ///< number of the first of them
    std::optional<double> pumping;    ///< share of the whole depth that goes to and fro from frame to frame
    std::optional<ColourFit> colour;  ///< nothing: no colour, or too few edges
    std::optional<HapticValues> haptic;  ///< nothing: no haptic picture

    /// In the first frame: pixels that are concerned are 1, row by row.
    struct Where {
        Image picture;  ///< colour, or without it depth as grey, near is bright
        std::vector<std::uint8_t> colour_edges, level_steps;
        struct Haptic {
            std::vector<std::uint8_t> too_stiff, more_dynamic, mixed;
        } haptic;
    } where;
};

/// Reads all frames of a clip that is at its beginning. `scene`: with the levels of its depth
/// (FilterSettings::levels), where these are known. `progress` is given the number of frames that were read.
/// An error of kind interrupted where the program is asked to stop.
Result<ClipQuality> measure_quality(ClipReader& clip, const Scene& scene,
                                    const std::function<void(std::int64_t)>& progress);

/// The clip with holes of its depth filled from frames that saw what is behind, where its camera rests;
/// RawFrame::filled says which. All frames are read once before, so that a frame is the same whichever frames
/// were read before it, and those of up to 32 places once more. What the camera saw while it moved stays as
/// it is, to the bit. A note says how large the share of holes is, before and after, or why nothing is
/// filled. Codes are those that some frame had. The clip is at its beginning, before and after, with its
/// colour, which goes on being read. Refused for live sources. Memory: per pixel 48 bytes meanwhile, and 8
/// for each rest that is kept, of which as many are as 512 MiB hold.
Result<std::unique_ptr<ClipReader>> with_filled_holes(std::unique_ptr<ClipReader> clip);

/// What of a picture's details becomes relief.
struct ReliefSettings {
    std::array<int, 3> bands{100, 70, 40};  ///< per cent of fine, medium, coarse; -400 to 400
    int amount = 100;                       ///< per cent of the largest height, 0 to 400
    bool invert = false;                    ///< dark stands out, not bright
    bool operator==(const ReliefSettings&) const = default;
};

/// What a clip's relief is like, in sixteenths of a level of brightness.
struct ReliefRange {
    /// 99 % of what counts is no higher and no deeper: this becomes the largest height.
    std::int32_t full = 1;
    /// Standard deviation from frame to frame of what does not move. Nothing: no two frames followed each
    /// other.
    std::optional<std::int32_t> noise{};
};

/// A clip at its beginning, and what its relief is like.
struct LookedAt {
    std::unique_ptr<ClipReader> clip;
    ReliefRange range;
};
/// Looks at some frames (telling_frames) of a clip that is at its beginning: they say what the largest height
/// stands for, and how much of it is the camera's noise. Amount and direction change nothing of it. Refused
/// without colour.
Result<LookedAt> look_at_relief(std::unique_ptr<ClipReader> clip, const ReliefSettings& settings);

/// The clip with heights that its colour suggests, in place of its own: codes of 8 bits, 128 is level, from
/// -max_height / 2 to max_height / 2 around it. `max_height`: scene units, more than 0; where that leaves no
/// room before the camera it is half of the nearest depth, and a note says so. `notes`: what else a person
/// should know, before what is noted here. After the last frame a note says how far heights flicker.
Result<std::unique_ptr<ClipReader>> with_relief(std::unique_ptr<ClipReader> clip,
                                                const ReliefSettings& settings, const ReliefRange& range,
                                                double max_height, std::vector<std::string> notes = {});

}  // namespace touchable
