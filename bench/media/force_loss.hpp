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

/// A clip of 8 bits in memory, and the forces of the standard stroke on it.
struct FeltClip {
    Scene scene;
    std::vector<RawFrame> frames;
    Stroke stroke;
};
struct FeltSource {
    std::string name;               ///< <scene>-<W>x<H>-8
    std::vector<PlaneRole> planes;  ///< the planes to send
    std::function<Result<FeltClip>()> make;
};
/// globe: as generated, without colour, which is not touched. materials: the same with a few flat materials.
/// castel: the depth of a recording, its range as 254 even levels; left out without the recording.
std::vector<FeltSource> felt_sources();

/// Ways to send a plane: lossless, and by H.264 at quantisers up to 24. Haptic also with chroma at half size
/// and, if it has few colours, as palette indices.
std::vector<CodecChoice> sent_choices(PlaneRole role, bool has_few_colours);

/// Encodes and decodes one plane of the clip and touches the result along the clip's own stroke
/// (bench/README.md, "Suite media").
Result<void> measure_force_loss(const FeltClip& clip, PlaneRole role, const CodecChoice& choice,
                                Figures& figures);

}  // namespace touchable
