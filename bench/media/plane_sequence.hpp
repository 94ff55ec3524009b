#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/clip/clip.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// Pictures whose planes are encoded by every codec.
struct PictureSource {
    std::string name;               ///< <scene>-<W>x<H>-<bits of depth>
    std::vector<PlaneRole> planes;  ///< the planes to measure
    std::function<Result<std::vector<RawFrame>>()> make;
};

/// Frames per source: as many as between two access points of a clip.
inline constexpr int frames_of_source = 15;

/// globe: all planes; its depth stands still. moving, noise (a slope with noise that is new in each frame,
/// +-16 codes of 16 bits, +-1 of 8) and castel, a recording: depth. A missing recording is reported on
/// stderr. 1920x1080 (`quick`: 720x480), castel as recorded.
std::vector<PictureSource> picture_sources(bool quick);

/// One plane of all frames.
std::vector<PlaneView> planes_of(const std::vector<RawFrame>& frames, PlaneRole role);

}  // namespace touchable
