#pragma once

// What overlays are made of, row by row: the numbers of a pixel, their places on a scale that does not
// flicker, and the surface's normals.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/scene/scene.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/overlays.hpp"
#include "player/draw/view.hpp"

namespace touchable {

/// The colour of pixels without depth: grey in stripes, like nothing else.
PackedColour hole_colour(int x, int y);

/// What a pixel has one number of.
enum class Scalar { depth, stiffness, static_friction, dynamic_friction, height };

/// Reads a field row by row: depth and height as they are drawn (`drawn_vertex`), other numbers as the hand
/// meets them at the pixels, to a float's precision, by tables of what the frames' codes mean.
class ScalarRows {
public:
    /// `pair` is what `field` was made of; both are referred to by `read`, until the next call.
    void begin(Scalar scalar, const HeightField& field, const FramePair& pair);
    /// The numbers of row y, `field.width()`; NaN where
    /// the surface has no depth. Depth as the coding has it (range or planar), height taken off, and height:
    /// scene units. Stiffness N/m.
    void read(int y, float* values);
    /// The state of each pixel of row y: 0 where the surface has no depth, 1 where both frames have it, 2
    /// where one has, 3 where one of those that have it was given it by another frame of the clip.
    void read_validity(int y, std::uint8_t* states);
    /// Whether a frame was given any by others.
    bool has_filled() const {
        return prev_.frame->filled != nullptr || (next_.frame != nullptr && next_.frame->filled != nullptr);
    }
    /// Whether there are two frames between which the field is.
    bool is_between() const { return next_.frame != nullptr; }

private:
    /// One of the pair's frames.
    struct Frame {
        const SurfaceFrame* frame = nullptr;
        const SurfaceFrame* codes = nullptr;       // null: none, or not alone what depth is made of
        DepthCoding coding;                        // of `depths`
        std::vector<float> depths;                 // of each code
        std::array<float, 256> property{};         // of each value of the channel
        std::array<float, 256> static_friction{};  // the same, where dynamic friction is asked for
        std::vector<float> lengths;                // of a row, height taken off, where they are asked for
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
    void read_properties(Frame& frame, int y) const;
    void mix(float* values) const;
    void read_moment(Scalar scalar, int y, float* values);
    bool find_whole(int y);
    void stiffen_holes(int y, float* values);

    Scalar scalar_ = Scalar::depth;
    Scalar reading_ = Scalar::depth;  // the same, or what that needs as well
    const HeightField* field_ = nullptr;
    float blend_ = 0, height_per_code_ = 0, reach_ = 0;
    Frame prev_, next_;
    std::vector<float> static_frictions_;  // of a row
    std::vector<std::uint32_t> whole_;     // of a row, by bits: there is depth all around
};

/// The range of a scale that does not flicker with what it is of: it widens at once, and narrows in the
/// course of seconds of the clip's time. Another epoch begins anew.
class SteadyRange {
public:
    static constexpr double narrowing_s = 2;  ///< to this part of the way is left: 1 - dt / this, each frame

    const Overlays::Range& update(const Overlays::Range& seen, const HeightField& field);

private:
    std::optional<Overlays::Range> range_;
    double moment_ns_ = 0;
    std::uint64_t epoch_ = 0;
};

/// Histogram equalisation: places of depths on a scale whose steps have equally many pixels each. However far
/// away a few pixels are, the others are told apart. The places follow the picture within parts of a second
/// of the clip's time, so that they do not flicker; another epoch begins anew.
class EqualisedDepth {
public:
    static constexpr double adapting_s = 0.5;

    /// `depths`: a sample of those that are seen, scene units, > 0. `field`: that they are of.
    void update(std::span<const float> depths, const HeightField& field);

    /// Depths of one bin have one place. A bin is up to 1/4096 of its depth wide.
    std::size_t bins() const { return shares_.size(); }
    /// The bin of each value of a row; `bins()` where it is NaN.
    void find_bins(const float* depths, int width, std::uint32_t* bins) const;
    /// The share of the pixels that are nearer than those of bin k, and half of those; 0 to 1.
    double share_of_bin(std::size_t k) const { return shares_[k]; }
    /// The depth than which that share of the pixels is nearer, scene units. At least one is seen.
    double depth_at(double share) const;

private:
    std::uint32_t first_ = 0;     // key of the first bin
    std::vector<float> weights_;  // of each bin; all of them make 1
    std::vector<double> shares_;
    double moment_ns_ = 0;
    std::uint64_t epoch_ = 0;
};

/// Colours of the surface's normals at the vertices of a lattice, by rows: of the plane through the four
/// neighbours in (x, y, q), where flat stays flat; a neighbour beyond a gap (shaders/cut_rule.h) does not
/// count.
class NormalRows {
public:
    /// `q`: width x height, row-major, referred to.
    NormalRows(const Camera& camera, int width, int height, const float* q);
    /// RGB of row y; where q is 0, any.
    void paint(int y, std::uint8_t* rgb);

private:
    Camera camera_;
    int width_, height_;
    const float* q_;
    std::vector<float> u_;                  // of the columns' rays
    std::vector<float> along_x_, along_y_;  // of a row: what q gains per pixel
};

}  // namespace touchable
