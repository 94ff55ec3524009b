#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/depth_coding.hpp"

namespace touchable {

struct SurfaceFrame;
struct TileBounds;

/// Depth of one pixel, before height is taken off. Where it is not valid, depth means nothing.
struct DepthSample {
    double depth = 0;  ///< scene units, of the coding's semantics
    bool valid = false;
};

/// Bounds on the valid depths of a tile's 17x17 vertices; may be wider than they need to be.
struct TileDepths {
    double nearest = 0, farthest = 0;  ///< scene units; nearest > farthest: no pixel is valid
    bool any_invalid = false;
};

/// Bounds of codes as bounds of depths.
TileDepths depths_of(const TileBounds& bounds, const DepthCoding& coding);

/// Depth and validity at a pixel, wherever they come from. Wait-free, no allocation; safe to call from one
/// haptic thread while others read too.
class VertexSource {
public:
    virtual ~VertexSource() = default;
    /// 0 <= x < width, 0 <= y < height.
    virtual DepthSample at(int x, int y) const = 0;
    /// 0 <= tx < tiles_x, 0 <= ty < tiles_y of the frame (see TileGrid).
    virtual TileDepths tile(int tx, int ty) const = 0;
    /// The frame whose codes and validity these vertices are, where they are no more than that: who asks for
    /// many reads them there (`sample_of`).
    virtual const SurfaceFrame* read_from() const { return nullptr; }
};

/// Reads the filtered codes, validity and bounds of a SurfaceFrame, which must outlive it.
class FilteredVertices : public VertexSource {
public:
    explicit FilteredVertices(const SurfaceFrame& frame) : frame_(frame) {}
    DepthSample at(int x, int y) const override;
    TileDepths tile(int tx, int ty) const override;
    const SurfaceFrame* read_from() const override { return &frame_; }

private:
    const SurfaceFrame& frame_;
};

/// Unquantised depths, for scenes whose truth is known. No depth is invalid unless it is not finite.
class ExactVertices final : public VertexSource {
public:
    /// `depths`: width x height, row-major, scene units. Where there are fewer, the rest is not valid.
    ExactVertices(int width, int height, std::vector<double> depths);
    DepthSample at(int x, int y) const override;
    TileDepths tile(int tx, int ty) const override;

private:
    TileDepths bound(int tx, int ty) const;

    int width_, height_;
    std::vector<double> depths_;
    std::vector<TileDepths> tiles_;
};

}  // namespace touchable
