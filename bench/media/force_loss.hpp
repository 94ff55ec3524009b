#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/media/plane_codec.hpp"
#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// A clip of 8 bits in memory, and what a finger felt of it on the standard stroke.
struct FeltClip {
    Scene scene;
    std::vector<RawFrame> frames;
    Stroke stroke;
};
struct FeltSource {
    std::string name;               ///< <scene>-<W>x<H>-8
    std::vector<PlaneRole> planes;  ///< of it those that are sent
    std::function<Result<FeltClip>()> make;
};
/// globe: as generated, but colour, which is not touched. materials: the same with few of them, each flat.
/// castel: the depth of a recording, its range as 254
/// even levels; left out where it is not there.
std::vector<FeltSource> felt_sources();

/// How such a plane may be sent: without loss, and by H.264 at quantisers up to 24. Haptic also with its
/// colours at half size and, where it has few, as indices into them.
std::vector<CodecChoice> sent_choices(PlaneRole role, bool has_few_colours);

/// Sends one plane of the clip and touches what comes back, on the way of the clip's own stroke
/// (bench/README.md, "Suite media").
Result<void> measure_force_loss(const FeltClip& clip, PlaneRole role, const CodecChoice& choice,
                                Figures& figures);

}  // namespace touchable
