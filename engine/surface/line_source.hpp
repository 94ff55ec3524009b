#pragma once

#include "engine/surface/code_line.hpp"

namespace touchable {

/// Where a filter's rows come from. It must not change meanwhile: a band reads beyond its own rows.
class LineSource {
public:
    virtual ~LineSource() = default;
    virtual void load(int y, CodeLine& line) const = 0;
};

/// Rows as they are decoded, one by one, when a filter asks for them.
class StoredLines final : public LineSource {
public:
    StoredLines(const PlaneView& depth, const DepthCoding& coding, VectorUnit unit)
        : depth_(depth), coding_(coding), unit_(unit) {}
    void load(int y, CodeLine& line) const override { line.decode(depth_, coding_, y, unit_); }

private:
    const PlaneView& depth_;
    const DepthCoding& coding_;
    VectorUnit unit_;
};

/// Rows of a frame's codes and validity.
class FrameLines final : public LineSource {
public:
    explicit FrameLines(const SurfaceFrame& frame) : frame_(frame) {}
    void load(int y, CodeLine& line) const override { line.copy(frame_, y); }

private:
    const SurfaceFrame& frame_;
};

}  // namespace touchable
