#pragma once

#include <memory>
#include <span>
#include <vector>

#include "player/draw/graphics_program.hpp"
#include "player/draw/surface_dents.hpp"
#include "player/draw/upload_pool.hpp"

namespace touchable {

/// A picture of a surface as painters leave it in memory, rows of `pitch`.
struct FlatPicture {
    std::span<const PackedColour> colours;
    std::span<const float> z;  ///< ViewCamera's; 0: background
    int width = 0, height = 0, pitch = 0;
};

/// What `draw_dents` draws, by the CPU for devices that compute on it: a shader took ten times as long there.
/// How far a pixel's place has come, and its light, are found at some places and straight in between; a
/// channel differs from `draw_dents` by a few of 255.
class DentPatches {
public:
    explicit DentPatches(std::shared_ptr<GpuDevice> device) : uploads_(std::move(device)) {}

    /// Records the dents that fingers make over `target`, which shows `flat`, and is and stays in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL. `flat` is read at once.
    Result<void> record(GpuCommands& commands, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                        const ViewCamera& camera, const FlatPicture& flat, const GpuImage& target);

private:
    struct Node {
        float right = 0, down = 0;  // from a pixel to what it shows, pixels
        float light = 1, gloss = 0;
    };
    struct Sight;
    void find_nodes(const Sight& sight, const FlatPicture& flat, const PixelBounds& bounds);
    void draw(const FlatPicture& flat, const PixelBounds& bounds, PackedColour* to) const;

    UploadPool uploads_;
    std::vector<SurfaceDent> dents_;
    std::vector<Node> nodes_;
    int step_ = 1, across_ = 0;  // pixels from one node to the next; nodes in a row
};

}  // namespace touchable
