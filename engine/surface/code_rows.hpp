#pragma once

#include <functional>
#include <memory>

#include "engine/base/row_bands.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/surface/code_line.hpp"

namespace touchable {

/// What filters have made of a frame so far, by lines, for a window that reads those around its own.
class LineSource {
public:
    virtual ~LineSource() = default;
    /// To be called first, of each frame. No allocation once it has seen the size.
    virtual void begin(const RawFrame& raw, RowBands& bands) = 0;
    virtual void load(int y, CodeLine& line) const = 0;
};

/// Lines as they are decoded, one by one, when a window asks for them.
class StoredLines final : public LineSource {
public:
    StoredLines(const DepthCoding& coding, VectorUnit unit) : coding_(coding), unit_(unit) {}
    void begin(const RawFrame& raw, RowBands&) override { depth_ = raw.depth; }
    void load(int y, CodeLine& line) const override { line.decode(depth_, coding_, y, unit_); }

private:
    const DepthCoding coding_;
    const VectorUnit unit_;
    PlaneView depth_;
};

/// What to do with a band of rows that is finished, while it is still in the cache.
using BandFinished = std::function<void(const RowBand& band)>;

/// The same by bands, each made once: what lies in the cache can be filtered again before the next one is
/// made.
class BandSource {
public:
    virtual ~BandSource() = default;
    virtual void begin(const RawFrame& raw, RowBands& bands) = 0;
    /// Codes and validity of a band of `out`, which has the size. Several threads at once.
    virtual void make(const RowBand& band, SurfaceFrame& out) = 0;

    /// All codes and validity of a frame. No allocation where `out` has had the size.
    void make_all(const RawFrame& raw, RowBands& bands, SurfaceFrame& out, const BandFinished& finished = {});
    /// Of a frame that nobody is shown no more than what later ones remember of it; `scratch` is any frame.
    virtual void remember(const RawFrame& raw, RowBands& bands, SurfaceFrame& scratch) {
        make_all(raw, bands, scratch);
    }
};

/// Lines as they are.
class UnfilteredBands final : public BandSource {
public:
    explicit UnfilteredBands(std::unique_ptr<LineSource> lines) : lines_(std::move(lines)) {}
    void begin(const RawFrame& raw, RowBands& bands) override;
    void make(const RowBand& band, SurfaceFrame& out) override;

private:
    const std::unique_ptr<LineSource> lines_;
    std::vector<CodeLine> line_;  // of each thread
};

}  // namespace touchable
