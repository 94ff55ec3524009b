// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable::verify {

/// Everything is computed in extended precision, so that what differs is the force and not the check.
using real = long double;

struct Vec3 {
    real x = 0, y = 0, z = 0;
    bool operator==(const Vec3&) const = default;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(real s, const Vec3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
inline real dot(const Vec3& a, const Vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline real length(const Vec3& a) {
    return std::sqrt(dot(a, a));
}
inline Vec3 unit(const Vec3& a) {
    return (1 / length(a)) * a;
}

/// Three numbers per haptic pixel: stiffness (N/m), static and dynamic friction.
struct Touch {
    real stiffness = 0, mu_static = 0, mu_dynamic = 0;
    bool operator==(const Touch&) const = default;
};

/// The contents of scene.json, read without the engine: the meaning of the numbers in the pictures.
struct Meaning {
    enum class Kind { linear, inverse, log, metric };
    int width = 0, height = 0;
    real fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
    Kind kind = Kind::linear;
    bool range = true;         ///< depth along the pixel's ray; otherwise along -Z
    bool near_is_high = true;  ///< all but metric
    real near = 0, far = 0;    ///< of the codes, scene units
    real shift = 0;            ///< of inverse and log: scene units, added to a depth
    real scene_far = 0;        ///< of holes and of what is around the picture
    real scale = 0;            ///< metric: scene units per code
    real code_max = 255;
    real largest_height = 0;  ///< scene units at the largest height code
    real height_code_max = 255;
    Touch low, high;  ///< of haptic values 0 and 255
    Touch by_default;
    std::optional<real> hole_stiffness;  ///< N/m
    bool operator==(const Meaning&) const = default;

    /// Scene units, of the coding's own kind (range or planar).
    real depth(std::uint16_t code) const;
};

/// One folder as `touchable export` writes it.
struct ExportedFrame {
    Meaning meaning;
    std::vector<std::uint16_t> codes, heights;  ///< heights: empty where there are none
    std::vector<std::uint8_t> valid;            ///< 0 or 255
    std::vector<std::uint8_t> haptic;           ///< RGB; empty: the defaults everywhere
};

Result<Meaning> read_meaning(const std::filesystem::path& folder);
Result<ExportedFrame> read_frame(const std::filesystem::path& folder);

/// Frames by number, read when first asked for; only a few are kept.
class FrameStore {
public:
    explicit FrameStore(std::filesystem::path folder) : folder_(std::move(folder)) {}
    /// The frame stays in memory until `kept` others have been asked for. All frames must mean the same.
    Result<const ExportedFrame*> get(std::int64_t number);

private:
    static constexpr std::size_t kept = 4;
    std::filesystem::path folder_;
    std::map<std::int64_t, ExportedFrame> frames_;
    std::vector<std::int64_t> recent_;  // oldest first
};

/// One tick of one finger as `touchable touch --forces` writes it: world axes, scene units, newtons, N/m.
struct ForceRow {
    std::int64_t line = 0;  ///< of the file, from 1
    std::int64_t tick = 0;
    int finger = 0;
    Vec3 goal, proxy, force;
    bool contact = false;
    real pixel_x = 0, pixel_y = 0;
    real stiffness = 0, mu_static = 0, mu_dynamic = 0;
    std::int64_t frame_prev = 0, frame_next = 0;
    real blend = 0;
    bool guarded = false;      ///< the guard changed the force
    bool braked = false;       ///< and added some: a damper's or the passivity controller's (bits 32, 64)
    real metres_per_unit = 0;  ///< S
    real share = 1;       ///< of the force, that was sent to the hand; files of older versions do not say
    bool capped = false;  ///< the solver ended at its event limit: on the surface, but not yet at the minimum
};

/// Reads a forces file row by row. Columns are found by name; all but `share` must be there, others are
/// ignored.
class ForcesReader {
public:
    static Result<ForcesReader> open(const std::filesystem::path& file);
    /// False at the end of the file.
    Result<bool> next(ForceRow& row);

private:
    static constexpr std::size_t column_count = 23;
    Error fault(const std::string& what) const;

    std::string name_;
    std::ifstream stream_;
    std::int64_t line_ = 0;
    std::array<std::size_t, column_count> position_{};  // of each wanted column in a line
    std::optional<std::size_t> share_;                  // of that column, if it is there
    std::size_t width_ = 0;                             // columns of a line
};

struct ImagePosition {
    real x = 0, y = 0;
};

/// A flat piece of the surface: half of a cell, or one of the unbounded strips outside the ring. `column` and
/// `row` are the cell's (-2 and the picture's size: outside the ring), `half` is 0 above the diagonal and 1
/// below it.
struct FacetId {
    int column = 0, row = 0, half = 0;
    bool operator==(const FacetId&) const = default;
};

struct Facet {
    FacetId id;
    Vec3 point;   ///< on it
    Vec3 normal;  ///< unit, on the camera's side
    bool operator==(const Facet&) const = default;
};

struct Vertex {
    Vec3 position;       ///< world
    real q = 0;          ///< 1 / planar depth
    bool solid = false;  ///< a valid pixel, not a hole or the ring
    real height = 0;     ///< taken off the depth, scene units
};

/// The surface between two exported frames, straight from the written conventions and in extended precision.
class Surface {
public:
    /// The frames must outlive it. 0 <= blend <= 1; 0 where the earlier frame is held.
    Surface(const ExportedFrame& earlier, const ExportedFrame& later, real blend);

    const Meaning& meaning() const { return meaning_; }
    /// -1 <= i <= width, -1 <= j <= height: the picture and its ring.
    Vertex vertex(int i, int j) const;
    /// The facet around a position that lies on no line of the lattice.
    Facet facet_at(ImagePosition at) const;
    /// 1 / planar depth of the surface.
    real q_at(ImagePosition at) const;
    /// Linear in time, bilinear in space; mu_dynamic is at most mu_static.
    Touch touch_at(ImagePosition at) const;

    /// Ray (u, v, -1).
    Vec3 ray(real x, real y) const;
    /// Where a world point in front of the camera is seen.
    ImagePosition project(const Vec3& world) const;

private:
    FacetId facet_id(ImagePosition at) const;
    Touch touch_of_pixel(int i, int j) const;
    real lacks_depth(int i, int j) const;
    real hole_around(int i, int j) const;

    const ExportedFrame& earlier_;
    const ExportedFrame& later_;
    const ExportedFrame& nearer_;
    const Meaning& meaning_;
    real blend_;
};

}  // namespace touchable::verify
