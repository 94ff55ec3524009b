// SPDX-License-Identifier: Apache-2.0
#pragma once

// A recording by itself, without its segments: what would feel wrong, and what is missing.
//
// measure_quality reads a clip once and returns figures (the command `info`, when it verifies): colour that
// does not lie on depth, depth that pulses, missing or late frames, haptic values that no device renders. It
// judges nothing. with_filled_holes and with_relief return the clip with depth holes filled with what other
// frames saw there, or with heights that its colour suggests (docs/content.md): look_at_relief reads some
// frames to find how strong its details are. with_filtered_depth returns it with filters applied.
//
// Threads: one uses a reader; stop requests are checked between frames.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// N/mm; the greatest stiffness that a hand-held device renders, according to its makers and the literature
/// (docs/devices.md); most render less.
inline constexpr double stiffest_of_devices = 3.0;

/// Measurements of a whole clip.
struct ClipQuality {
    /// How frames follow each other.
    struct FrameTimes {
        std::int64_t frames = 0;
        /// Frames with the depth, haptic and height of the one before, though the surface moves: it changes
        /// within longest_repeat frames before and after. A surface that stands still longer is no fault.
        std::int64_t repeated = 0;
        std::int64_t changed = 0;        ///< frames that differ from the one before
        std::int64_t of_new_colour = 0;  ///< of `repeated`: those whose colour has changed
        static constexpr std::int64_t longest_repeat = 4;
        double usual_ms = 0;       ///< from frame to frame, the median
        std::int64_t missing = 0;  ///< frames that fit into longer times
        std::int64_t jumps = 0;  ///< times that stand still, go back, or follow within a quarter of the usual
        double longest_ms = 0;
        std::int64_t longest_at = 0;  ///< number of the frame after it
    };
    /// How colour lies on depth: medians, in pixels of the depth plane.
    struct ColourFit {
        std::int64_t edges = 0;  ///< number of places compared
        /// Share of edges within two steps of their median, across or down, whichever is less. If colour is
        /// farther beside depth than the search window, edges of colour are found by chance, all over the
        /// window: then the other figures mean nothing.
        double agreement = 0;
        bool agrees() const { return agreement >= 0.45; }
        /// Offset of colour to the right of depth, and below it. nullopt: too few edges face both ways.
        std::optional<double> right, below;
        /// By how much near surfaces reach beyond their colour, so that the background's colour lies on
        /// their rims; below 0: their colour reaches beyond them.
        double rim = 0;
    };
    /// Demands of a clip's haptic pictures on a device. Shares are of the pixels that have a surface.
    struct HapticValues {
        double stiffest = 0;      ///< N/mm
        double too_stiff = 0;     ///< share that is stiffer than stiffest_of_devices
        double more_dynamic = 0;  ///< share with dynamic friction above static friction
        /// Share whose value differs from both neighbours in the row, though these agree with each other:
        /// noise of a codec that mixes materials.
        double mixed = 0;
    };

    FrameTimes times;
    std::int64_t blank = 0;              ///< frames without any depth
    std::int64_t first_blank = 0;        ///< number of the first of them
    std::optional<double> pumping;       ///< oscillation of the whole depth from frame to frame, share of it
    std::optional<ColourFit> colour;     ///< nullopt: no colour, or too few edges
    std::optional<HapticValues> haptic;  ///< nullopt: no haptic picture

    /// The first frame: affected pixels are 1, row by row.
    struct Where {
        Image picture;  ///< colour, or without it depth as grey, near is bright
        std::vector<std::uint8_t> colour_edges, level_steps;
        struct Haptic {
            std::vector<std::uint8_t> too_stiff, more_dynamic, mixed;
        } haptic;
    } where;
};

/// Reads all frames of a clip that is at its beginning. `scene`: with the levels of its depth
/// (FilterSettings::levels), if known. `progress` gets the number of frames read. ErrorKind::interrupted if
/// the program is asked to stop.
Result<ClipQuality> measure_quality(ClipReader& clip, const Scene& scene,
                                    const std::function<void(std::int64_t)>& progress);

/// Returns the clip with its depth holes filled from frames that saw the background, while its camera rests;
/// RawFrame::filled marks the pixels. All frames are read once before, so that a frame does not depend on
/// which frames were read before it, and up to 32 frames once more. Frames of a moving camera stay as they
/// are, to the bit. A note gives the share of holes before and after, or says why nothing is filled. Every
/// code occurred in some frame. The clip must be at its beginning, and is afterwards, with its colour, which
/// is still read. An error for live sources. Memory: per pixel 48 bytes meanwhile, and 8 for each rest that
/// is kept, as many as fit into 512 MiB.
Result<std::unique_ptr<ClipReader>> with_filled_holes(std::unique_ptr<ClipReader> clip);

/// Returns the clip with the depth that `scene`'s filters leave: its scene is filtered_scene(scene), and it
/// feels as the clip with these filters does, to the bit. Holes stay holes, unless a filter fills them.
/// `scene`: the clip's, with all filters settled; `filters`: them in words, for a remark. With a temporal
/// filter a frame depends on those before it: a reader that seeks begins temporal_warm_up_frames earlier.
std::unique_ptr<ClipReader> with_filtered_depth(std::unique_ptr<ClipReader> clip, const Scene& scene,
                                                const std::string& filters);

/// Which details of a picture become relief.
struct ReliefSettings {
    std::array<int, 3> bands{100, 70, 40};  ///< per cent of fine, medium, coarse; -400 to 400
    int amount = 100;                       ///< per cent of the largest height, 0 to 400
    bool invert = false;                    ///< dark stands out, not bright
    bool operator==(const ReliefSettings&) const = default;
};

/// Strength of a clip's relief, in sixteenths of a level of brightness.
struct ReliefRange {
    /// 99 % of the relief that counts is no higher and no deeper; this becomes the largest height.
    std::int32_t full = 1;
    /// Standard deviation of resting pixels from frame to frame. nullopt: no two frames were consecutive.
    std::optional<std::int32_t> noise{};
};

/// A clip at its beginning, and the strength of its relief.
struct LookedAt {
    std::unique_ptr<ClipReader> clip;
    ReliefRange range;
};
/// Reads some frames (telling_frames) of a clip that is at its beginning, to find what the largest height
/// stands for, and how much is the camera's noise. Amount and direction do not matter. An error without
/// colour.
Result<LookedAt> look_at_relief(std::unique_ptr<ClipReader> clip, const ReliefSettings& settings);

/// Returns the clip with its heights replaced by those that its colour suggests: codes of 8 bits, 128 is
/// level, from -max_height / 2 to max_height / 2 around it. `max_height`: scene units, more than 0; if that
/// leaves no room in front of the camera, half of the nearest depth is used, and a note says so. `notes`: put
/// before the notes made here. After the last frame a note says how much heights flicker.
Result<std::unique_ptr<ClipReader>> with_relief(std::unique_ptr<ClipReader> clip,
                                                const ReliefSettings& settings, const ReliefRange& range,
                                                double max_height, std::vector<std::string> notes = {});

}  // namespace touchable
