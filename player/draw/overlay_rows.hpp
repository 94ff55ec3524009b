// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inputs of overlays, row by row: pixel values, their places on a scale that does not flicker, and the
// surface's normals.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/scene/scene.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/overlays.hpp"
#include "player/view/view.hpp"

namespace touchable {

/// The colour of pixels without depth: grey stripes, unlike any other colour.
PackedColour hole_colour(int x, int y);

/// A property with one number per pixel.
enum class Scalar { depth, stiffness, static_friction, dynamic_friction, height, errors };

/// Reads a field row by row, to float precision, with tables from the frames' codes: depth and height as
/// drawn (`drawn_vertex`), other values as felt at the pixels. Errors are those of the nearer frame.
class ScalarRows {
public:
    /// `field` was made from `pair`; `read` refers to both until the next `begin`.
    void begin(Scalar scalar, const HeightField& field, const FramePair& pair);
    /// The `field.width()` values of row y; NaN without depth. Depth in the coding's semantics (range or
    /// planar), height subtracted, and height: scene units. Stiffness N/m. Errors: degrees, NaN if not
    /// measured.
    void read(int y, float* values);
    /// The state of each pixel of row y: 0 without depth, 1 depth in both frames, 2 in one, 3 in at least one
    /// that took it from another frame of the clip.
    void read_validity(int y, std::uint8_t* states);
    /// Whether a frame has depth filled in from other frames.
    bool has_filled() const {
        return prev_.frame->filled != nullptr || (next_.frame != nullptr && next_.frame->filled != nullptr);
    }
    /// Whether the field lies between two frames.
    bool is_between() const { return next_.frame != nullptr; }

private:
    /// One of the pair's frames.
    struct Frame {
        const SurfaceFrame* frame = nullptr;
        const SurfaceFrame* codes = nullptr;       // null: none, or depth needs more than codes
        DepthCoding coding;                        // of `depths`
        std::vector<float> depths;                 // of each code
        std::array<float, 256> property{};         // by haptic byte
        std::array<float, 256> static_friction{};  // the same, for dynamic friction
        std::vector<float> lengths;                // depths of a row, height subtracted, if needed
        std::vector<float> values;                 // of a row
        std::vector<std::uint8_t> valid;           // of a row, 0 or 1
    };
    void begin_frame(Frame& frame, const SurfaceFrame* of);
    void make_properties(Frame& frame) const;
    void read_validity(Frame& frame, int y) const;
    void mark_filled(const Frame& frame, int y, std::uint8_t* states) const;
    void read_frame(Frame& frame, int y) const;
    void read_depths(Frame& frame, int y, std::vector<float>& to) const;
    void read_heights(Frame& frame, int y) const;
    void read_errors(Frame& frame, int y) const;
    void read_properties(Frame& frame, int y) const;
    void mix(float* values) const;
    void read_moment(Scalar scalar, int y, float* values);
    bool find_whole(int y);
    void stiffen_holes(int y, float* values);

    Scalar scalar_ = Scalar::depth;
    Scalar reading_ = Scalar::depth;  // scalar_, or a value that it depends on
    const HeightField* field_ = nullptr;
    float blend_ = 0, height_per_code_ = 0, reach_ = 0;
    Frame prev_, next_;
    std::vector<float> static_frictions_;  // of a row
    std::vector<std::uint32_t> whole_;     // of a row, bit set: depth at the pixel and all neighbours
};

/// A scale's range that does not flicker: widens at once, narrows over seconds of the clip's time. A new
/// epoch resets it.
class SteadyRange {
public:
    static constexpr double narrowing_s = 2;  ///< time constant: the remaining part shrinks by 1 - dt /
                                              ///< narrowing_s each frame

    const Overlays::Range& update(const Overlays::Range& seen, const HeightField& field);

private:
    std::optional<Overlays::Range> range_;
    double moment_ns_ = 0;
    std::uint64_t epoch_ = 0;
};

/// Histogram equalisation: maps depths to a scale with equally many pixels per step. A few distant outliers
/// do not reduce the contrast of the rest. Adapts within parts of a second of the clip's time, to avoid
/// flicker; a new epoch resets it.
class EqualisedDepth {
public:
    static constexpr double adapting_s = 0.5;

    /// `depths`: a sample of the visible ones, > 0, scene units, from `field`.
    void update(std::span<const float> depths, const HeightField& field);

    /// Number of bins; depths in one bin share a place. A bin is up to 1/4096 of its depth wide.
    std::size_t bins() const { return shares_.size(); }
    /// The bin of each value of a row; `bins()` for NaN.
    void find_bins(const float* depths, int width, std::uint32_t* bins) const;
    /// Share of pixels nearer than bin k, plus half of bin k's own; 0 to 1.
    double share_of_bin(std::size_t k) const { return shares_[k]; }
    /// The depth with that share of pixels nearer, scene units. Needs at least one visible pixel.
    double depth_at(double share) const;

private:
    std::uint32_t first_ = 0;     // key of the first bin
    std::vector<float> weights_;  // of each bin; their sum is 1
    std::vector<double> shares_;
    double moment_ns_ = 0;
    std::uint64_t epoch_ = 0;
};

/// Colours of the surface's normals at lattice vertices, by rows: from the plane through the four neighbours
/// in (x, y, q), where planes stay planes; neighbours beyond a gap (shaders/cut_rule.h) do not count.
class NormalRows {
public:
    /// `q`: width x height, row-major; must outlive this.
    NormalRows(const Camera& camera, int width, int height, const float* q);
    /// RGB of row y; undefined where q is 0.
    void paint(int y, std::uint8_t* rgb);

private:
    Camera camera_;
    int width_, height_;
    const float* q_;
    std::vector<float> u_;                  // of the columns' rays
    std::vector<float> along_x_, along_y_;  // of a row: change of q per pixel
};

}  // namespace touchable
