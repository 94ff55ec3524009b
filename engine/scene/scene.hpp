// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a clip means: a SceneDescription is what a scene file, a format or a guess states about it, and may
// leave members open; a Scene is complete, valid and does not change.
//
// `settle` makes a Scene of a SceneDescription with what the clip itself tells (rate, size, far plane). A
// Scene states the Camera (and lens, and a separate ColourCamera) of its pictures and where it stood
// (CameraPath), how stored depth becomes lengths (DepthCoding), how heights and haptic pictures become
// metres, N/m and friction, which filters a builder applies, and at which times frames are shown (FrameRate).
// Remarks tell a person what was guessed. docs/conventions.md has the exact definitions. parse_scene and
// read_scene_file read a scene file, JSON from outside, and check each member (docs/scene_file.md);
// scene_to_json writes a text that is read as the same scene. filter_settings is the table of filter
// settings, used by all code that reads, writes or names one.
//
// Lengths are in scene units unless a name says metres; pixels have integer coordinates at their centres,
// rows go down.
// Threads: any; plain values and pure functions.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

/// What a depth measures: the distance along the pixel's ray (Eq. 3), or along -Z.
enum class DepthSemantics { range, planar };

/// Pinhole camera at the world's origin looking along -Z (X right, Y up), in the image's pixel frame: column
/// x to the right, row y down, pixel (i, j) at integer coordinates. Focal lengths and centre in pixels.
struct Camera {
    double fx = 0, fy = 0, cx = 0, cy = 0;

    struct ImagePoint {
        double x, y;          ///< pixel frame
        double planar_depth;  ///< scene units, > 0
    };

    /// The ray of pixel (x, y) is (u, v, -1).
    double u(double x) const { return (x - cx) / fx; }
    double v(double y) const { return -((y - cy) / fy); }
    /// L = |(u, v, -1)|: range divided by planar depth.
    double ray_length(double x, double y) const {
        const double a = u(x), b = v(y);
        return std::sqrt(a * a + b * b + 1.0);
    }
    /// L at the corner of a picture that is farthest from the axis.
    double longest_ray(int width, int height) const {
        const double left = ray_length(0, 0), right = ray_length(width - 1, 0);
        return std::max({left, right, ray_length(0, height - 1), ray_length(width - 1, height - 1)});
    }
    bool operator==(const Camera&) const = default;
};

/// The paper's camera (Eq. 3): square pixels of `pixel_width`, same unit as `focal_length`; its lower-left
/// origin with W/2, H/2 becomes cx = W/2, cy = H/2 - 1 once rows are flipped.
Camera camera_from_focal_length(double focal_length, double pixel_width, int width, int height);

/// Planar depth (along -Z) of a depth of either meaning at pixel (x, y). Scene units.
double planar_depth(const Camera& camera, DepthSemantics semantics, double x, double y, double depth);
/// The depth that a pixel would have whose point this is, scene units.
double depth_of(DepthSemantics semantics, const glm::dvec3& point);

/// World point of pixel (x, y) at a planar depth. Scene units.
glm::dvec3 unproject(const Camera& camera, double x, double y, double planar_depth);

/// Where a world point is seen; nullopt for a point that is not in front of the camera (Z >= 0).
std::optional<Camera::ImagePoint> project(const Camera& camera, const glm::dvec3& point);

/// Distortion of a lens after Brown and Conrady, in OpenCV's terms and order: k1, k2, p1, p2, k3, k4, k5, k6.
/// All 0: none.
struct LensDistortion {
    std::array<double, 8> terms{};

    /// A point in the plane at distance 1 from a camera: x to the right, y down.
    struct Point {
        double x, y;
    };

    bool any() const { return *this != LensDistortion{}; }
    /// Where the lens shows what a pinhole shows at `point`.
    Point distorted(Point point) const;
    /// The distance from the axis up to which distorted distances grow with a pinhole's. Farther points would
    /// be shown on top of nearer ones: no lens does that, the terms are not valid there. At most 10.
    double reach() const;
    bool operator==(const LensDistortion&) const = default;
};

/// A rotation, row by row, and then a translation, scene units, between cameras: x to the right, y down, z
/// forward, as cameras' own files have them.
struct CameraPose {
    std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::array<double, 3> translation{};

    /// The inverse transform.
    CameraPose inverse() const;
    /// The transform `first`, then this one.
    CameraPose after(const CameraPose& first) const;
    bool operator==(const CameraPose&) const = default;
};

/// The camera of colour pictures, if it is not depth's.
struct ColourCamera {
    Camera camera;  ///< fx, fy, cx, cy; `from_depth` is its pose
    int width = 0, height = 0;
    LensDistortion lens;
    CameraPose from_depth;  ///< a point p of depth's camera is R p + t in this one
};

/// When frames are shown. Even: frame n is at floor(n 1e9 den / num) ns. Or each has its own time (a variable
/// rate): then num / den is the mean, at which frames follow the last known one.
struct FrameRate {
    std::int64_t num = 30, den = 1;
    std::shared_ptr<const std::vector<std::int64_t>> own_times{};  ///< ns, increasing from 0; null: even

    std::int64_t time_ns(std::int64_t frame) const;     ///< exact, clamped to 64 bits
    std::int64_t frame_at(std::int64_t time_ns) const;  ///< the last frame that is not later; exact
    std::int64_t nearest(std::int64_t time_ns) const;   ///< the nearest frame; the earlier of two
    double per_second() const { return static_cast<double>(num) / static_cast<double>(den); }
};
/// Neither a container's milliseconds nor a tick tells closer frames apart.
inline constexpr std::int64_t shortest_frame_ns = 1'000'000;
/// The rate of frames with their own times, ns; the first becomes time 0. nullopt if there are fewer than
/// two, if one is less than `shortest_frame_ns` after the one before, or if all last longer than 126 years.
std::optional<FrameRate> rate_of_own_times(std::vector<std::int64_t> times_ns);

/// Where a clip's camera stood at each frame, as its makers measured it: a point p of the camera is R p + t
/// in a fixed world. Neither display nor touch uses it.
struct CameraPath {
    std::vector<std::optional<CameraPose>> poses;  ///< of frames 0, 1, ...; nullopt: not known

    struct TimedPose {
        double seconds = 0;
        CameraPose pose;
    };

    std::size_t known() const;
    /// Length of the path along the known places, scene units.
    double length() const;
    /// The poses of frames `first`, `first + every`, ... up to `last`.
    CameraPath part(std::int64_t first, std::optional<std::int64_t> last, std::int64_t every) const;
    bool operator==(const CameraPath&) const = default;
};

/// Most frames of a path, so that its text fits a clip's header; and most poses of a list, which may have
/// more poses than the clip has frames.
inline constexpr std::size_t most_path_frames = 200'000, most_timed_poses = 2'000'000;

/// The rotation of a quaternion, whose length need not be exactly 1; nullopt if it is no rotation.
std::optional<std::array<double, 9>> rotation_of(double x, double y, double z, double w);
/// The pose at a place in metres; nullopt if that is a million kilometres away or more.
std::optional<CameraPose> pose_at(const std::array<double, 9>& rotation, const std::array<double, 3>& metres,
                                  double metres_per_unit);
/// Whether the matrix is a rotation, except for digits that were rounded off: 1e-3.
bool is_rotation(const std::array<double, 9>& matrix);

/// Lines "time tx ty tz qx qy qz qw", seconds and metres, as TUM RGB-D's groundtruth.txt; '#' begins a
/// remark. An error names the line.
Result<std::vector<CameraPath::TimedPose>> parse_timed_poses(std::string_view text, const std::string& name,
                                                             double metres_per_unit);
/// Writes the known poses in that form, at the times of their frames.
std::string timed_poses_text(const CameraPath& path, const FrameRate& rate, double metres_per_unit);
/// Assigns each pose to the frame at its time; poses at no frame's time are left out.
CameraPath path_of_timed_poses(const std::vector<CameraPath::TimedPose>& poses, const FrameRate& rate);

/// How a code becomes a depth in scene units; n = code / code_max, or 1 - code / code_max if !near_is_high.
/// - linear:  far + (near - far) n                   (Eq. 3)
/// - inverse: 1 / (1/far + (1/near - 1/far) n); with a shift s:
///            1 / (1/(far + s) + (1/(near + s) - 1/(far + s)) n) - s
/// - log:     e^(ln(far + shift) + (ln(near + shift) - ln(far + shift)) n) - shift
/// - metric:  scale * code
/// - hue:     as linear, of the code that shaders/hue_code.h makes from an RGB pixel
enum class DepthCodingKind { linear, inverse, metric, hue, log };

struct DepthCoding {
    static constexpr int max_invalid_codes = 4;
    /// Hue: number of codes of the colour circle; the largest code of a pixel is one less.
    static constexpr std::uint16_t hue_circle = 1536;

    DepthCodingKind kind = DepthCodingKind::linear;
    DepthSemantics semantics = DepthSemantics::range;
    bool near_is_high = true;      ///< all but metric: the largest code is the near plane
    double near = 0;               ///< scene units; for metric the smallest depth that is valid (0: any)
    double far = 0;                ///< scene units, finite; deeper codes are invalid
    double scale = 0;              ///< metric: scene units per code
    double shift = 0;              ///< scene units, added to the depth: see the kinds
    std::uint16_t code_max = 255;  ///< largest native code
    int least_sum = 0;             ///< hue: pixels with R + G + B below this, 0 to 765, are invalid
    std::array<std::uint16_t, max_invalid_codes> invalid_codes{};
    int invalid_code_count = 0;
    /// The least and the greatest valid code, so codes outside are invalid; derived by `derive_valid_range`
    /// from the members above. Least > greatest: none is valid.
    std::uint16_t valid_min = 0, valid_max = 255;

    /// Whether every code from `least` to `greatest` is valid.
    bool all_valid(std::uint16_t least, std::uint16_t greatest) const {
        for (int k = 0; k < invalid_code_count; ++k) {
            const std::uint16_t code = invalid_codes[static_cast<std::size_t>(k)];
            if (least <= code && code <= greatest) return false;
        }
        return least >= valid_min && greatest <= valid_max;
    }
    bool is_valid(std::uint16_t code) const { return all_valid(code, code); }
    /// Depth of a valid code, in scene units, of the coding's own semantics; > 0 and <= far.
    double depth(std::uint16_t code) const {
        if (kind == DepthCodingKind::metric) return scale * code;
        // Share of the way from the far plane (0) to the near plane (1).
        const double value = code, share = (near_is_high ? value : code_max - value) / code_max;
        if (share == 0.0) return far;  // the planes exactly, whatever rounding does between them
        if (share == 1.0) return near;
        const double deep = far + shift;
        const double between = kind == DepthCodingKind::inverse
                                   ? 1.0 / (1.0 / deep + (1.0 / (near + shift) - 1.0 / deep) * share) - shift
                               : kind == DepthCodingKind::log ? log_depth(share)
                                                              : far + (near - far) * share;
        return std::clamp(between, near, far);
    }
    /// Log: the depth at a share of the way from the far plane (0) to the near one (1), unclamped.
    double log_depth(double share) const;
    /// Log: ln((far + shift)/(near + shift)), the way from plane to plane.
    double log_span() const;
    /// The smallest depth of all valid codes. Needs a valid code.
    double nearest_depth() const { return depth(deeper_is_higher() ? valid_min : valid_max); }
    /// The largest depth of all valid codes. Needs a valid code.
    double deepest_depth() const { return depth(deeper_is_higher() ? valid_max : valid_min); }
    /// The valid code whose depth is nearest to `depth` (ties: the lower code).
    std::uint16_t code(double depth) const;
    /// True if a larger code is a larger depth.
    bool deeper_is_higher() const { return kind == DepthCodingKind::metric || !near_is_high; }
    /// One *level*: (far - near)/255, the paper's grey level as a length.
    double level() const { return (far - near) / 255.0; }

    bool operator==(const DepthCoding&) const = default;
};

/// Sets valid_min and valid_max to the least and the greatest code with 0 < depth, near <= depth <= far and
/// code <= code_max that is not marked invalid. Codes between them are valid unless marked invalid.
void derive_valid_range(DepthCoding& coding);

/// A length that grows with depth z: constant + quadratic z^2, scene units.
struct DepthLength {
    double constant = 0, quadratic = 0;

    double at(double depth) const { return constant + quadratic * depth * depth; }
    DepthLength times(double factor) const { return {factor * constant, factor * quadratic}; }
    bool operator==(const DepthLength&) const = default;
};

/// What a remark guesses, in order of how much a wrong guess changes what is felt and how often it is wrong;
/// all but the place of colour change metres.
enum class RemarkKind {
    unit_doubt,    ///< no guess: the unit may be wrong, as no depth camera measures the median depth
    direction,     ///< that values are lengths, though they look like 1/depth: the scene may be inside out
    planes,        ///< of a depth buffer, which are assumed: shapes are wrong with others
    scale,         ///< depth has none, or its ends are assumed
    unclear_unit,  ///< other units fit as well
    camera,
    unit,
    storage,       ///< the preset by which depth is stored, by its values or its name
    axis,          ///< whether depth is along the camera's axis or along each pixel's ray
    colour_place,  ///< changes only what is seen
    other          ///< a fact, or a guess that changes little
};

/// A note to a person about where a scene's values come from.
struct Remark {
    std::string what;       ///< "the camera sees 60 degrees from left to right"
    bool is_guess = false;  ///< neither a person nor a file said it
    std::string
        otherwise{};  ///< of a new remark: what states another value: "a scene file's rate says otherwise"
    Hints hints{};    ///< of a new remark: the settings that would change it
    RemarkKind kind = RemarkKind::other;
};

/// Limits of a scene file's remarks.
inline constexpr std::size_t most_remarks = 100, longest_remark = 2000;  ///< bytes

/// Adds a remark, on one line and short enough for a scene file; skips duplicates, and all beyond
/// `most_remarks`.
void add_remark(std::vector<Remark>& remarks, Remark remark);
/// `first`, then `rest`, added one by one.
std::vector<Remark> joined_remarks(std::vector<Remark> first, const std::vector<Remark>& rest);

/// The text in a scene file: a guess begins with "guessed: ". `otherwise` is left out, as it may apply only
/// to the clip that was guessed.
std::string remark_text(const Remark& remark);
/// The remark of a text; its kind by how the text begins, and `unit` for an unclear one.
Remark remark_of_text(std::string_view text);

/// The text for a person: a guess says what would state another value, by default a scene file. Without the
/// hints, whose names only a program knows.
std::string remark_in_words(const Remark& remark);

/// What a finger feels at a pixel.
struct HapticProperties {
    double stiffness = 600.0;  ///< N/m
    double static_friction = 0.4;
    double dynamic_friction = 0.3;
    bool operator==(const HapticProperties&) const = default;
};

/// Range of one haptic channel; P = min + (max - min) p / 255 (Eq. 1).
struct PropertyRange {
    double min = 0, max = 0;
    double at(std::uint8_t p) const { return min + (max - min) * p / 255.0; }
    /// The code that stands for `value`, rounded to the nearest.
    std::uint8_t nearest(double value) const {
        const double share = max > min ? (value - min) / (max - min) : 0;
        return static_cast<std::uint8_t>(std::clamp(share, 0.0, 1.0) * 255 + 0.5);
    }
};

/// The haptic image's three channels; stiffness in N/mm as the paper's metadata has it.
struct HapticRanges {
    PropertyRange stiffness{0.1, 10.0};
    PropertyRange static_friction{0.1, 1.0};
    PropertyRange dynamic_friction{0.1, 1.0};

    /// Properties of a haptic pixel, stiffness converted to N/m.
    HapticProperties at(std::uint8_t r, std::uint8_t g, std::uint8_t b) const {
        return {stiffness.at(r) * 1000.0, static_friction.at(g), dynamic_friction.at(b)};
    }
};

enum class HeightUnits { levels, world };

/// Height (Eq. 2) is a length subtracted from the depth: depth' = depth - max_height h / code_max, in levels
/// of the depth coding or in scene units.
struct HeightCoding {
    double max_height = 0;
    HeightUnits units = HeightUnits::levels;
    std::uint16_t code_max = 255;
};

/// Length in scene units of the largest height code.
double largest_height(const HeightCoding& height, const DepthCoding& depth);

/// How the surface is found between two frames.
enum class FrameInterpolation { hold, linear };

/// Automatic: on if kappa says that it helps (filter_codes.hpp).
enum class TerraceRemoval { off, on, automatic };
/// Limits of the reach of terrace removal, pixels: a power of two.
inline constexpr int least_terrace_reach = 16, most_terrace_reach = 128;

/// Integer filters between stored values and codes; see engine/surface.
struct FilterSettings {
    int median = 0;      ///< window side: 0 (off), 3 or 5
    int fill_holes = 0;  ///< passes, 0 to 16
    TerraceRemoval terraces = TerraceRemoval::off;
    double terrace_noise = 0;  ///< standard deviation of the stored depth, codes, 0 to 4
    /// Distance from one depth that occurs to the next, if it is more than a code's step: cameras that
    /// measure disparity and store millimetres have levels that grow with depth squared.
    DepthLength levels{};
    bool temporal = false;  ///< noise from frame to frame is averaged (filter_codes.hpp)
    /// Standard deviation of a stored depth. Time of flight: mostly constant; stereo and structured light:
    /// mostly quadratic.
    DepthLength temporal_noise{};
    /// Depths that differ by no more belong to one surface; a pixel that hangs between two surfaces is pulled
    /// to one (flying_pixels.hpp). Zero: off.
    DepthLength flying_pixels{};
    /// Pixels; terraces about this wide become slopes.
    int terrace_reach = least_terrace_reach;
    bool operator==(const FilterSettings&) const = default;
};

/// Numbers of a plane's pictures, if they differ from depth's. A member that is left out is as for depth.
struct PictureNumbers {
    std::optional<int> first{};
    std::optional<int> step{};
    bool any() const { return first.has_value() || step.has_value(); }
    bool operator==(const PictureNumbers&) const = default;
};

/// Files of a folder of images: a pattern with one printf-like field of digits ("depth_%04d.png"), or with
/// one star ("depth/*.png": all files, in order), or a list of them (".txt": one per line, with an optional
/// time before the name). If depth is none of these, it names a still: a clip of one frame. Stills of other
/// planes serve all frames.
struct FolderSource {
    std::string depth, colour, haptic, height;  ///< empty: no such plane; depth is required
    int first = 0;                              ///< number of the first image
    int count = 0;                              ///< 0: as many as there are without a gap
    int step = 1;                               ///< from one frame's number to the next one's, 1 or more
    PictureNumbers colour_numbers{}, haptic_numbers{}, height_numbers{};
    /// Files with the camera of each frame, if it changes: numbered, with a star, or a list. Empty: none.
    std::string cameras{};
    PictureNumbers camera_numbers{};
    /// Haptic pictures are read even if their coding mixes materials. Not in scene files.
    bool haptic_may_be_lossy = false;
};

/// Whether a pattern names a single picture.
bool is_still(std::string_view pattern);
/// Whether a pattern has a field of digits.
bool is_numbered(std::string_view pattern);

/// Where depth is in each picture of a video. Colour is the other half.
enum class VideoLayout { alone, left, right, top, bottom };
/// Which value of a pixel is its depth: its grey value or luma as stored, (R + G + B) / 3, or for coding hue
/// its colour.
enum class VideoValues { grey, mean, hue };

VideoValues usual_values(DepthCodingKind kind);

/// A video of depth, or one that has colour beside depth in each picture.
struct VideoSource {
    std::string depth;
    std::string colour;  ///< another video; empty: none, or in the other half
    VideoLayout layout = VideoLayout::alone;
    VideoValues values = VideoValues::grey;
    std::string haptic{}, height{};  ///< stills that serve all frames; empty: none
};

/// A number in the bytes of a picture's red, green, blue and alpha. The name has them from the lowest byte
/// on, so gr16 is green + 256 red, of 16 bits. rgb24: whole numbers; all bits set is no depth. bgr24: shares
/// of 2^24 - 1, and bgr255, to base 255, of 255^3; 1 is no depth. 32f: floats.
/// half: one channel of 16 bits, a 16-bit float.
enum class Packing { none, rgb24, bgr24, bgr255, rg16, gr16, rgba32f, bgra32f, abgr32f, half };

/// What pictures hold if it is not the codes of `Scene::depth`. The reader makes codes of it, using the
/// values of all frames, and then settles that coding.
struct StoredDepth {
    enum class Kind {
        codes,      ///< of Scene::depth; floats are lengths (metric) or shares of code_max (others)
        disparity,  ///< depth = fx baseline / (scale value + offset)
        relative,   ///< from the least value to the largest, evenly in depth or 1 / depth
                    ///< (Scene::depth)
    };
    Kind kind = Kind::codes;
    double baseline = 0;           ///< scene units
    double scale = 1, offset = 0;  ///< pixels of disparity per stored value, and at 0
    bool bytes_swapped = false;    ///< 16 bits: low byte first, contrary to the file's format
    int rotated = 0;               ///< 16 bits: rotation to the left, 0 to 15 bits
    /// 16 bits, once in order: number of low bits that are depth, 8 to 16; upper bits mean something else.
    int used_bits = 16;
    Packing packed = Packing::none;
    bool is_reordered() const { return bytes_swapped || rotated > 0 || used_bits < 16; }
    bool is_plain() const { return kind == Kind::codes && !is_reordered() && packed == Packing::none; }
    bool operator==(const StoredDepth&) const = default;
};

/// What a clip means: everything except the pictures. Members that a scene file leaves open are settled
/// before the Scene exists (SceneDescription).
struct Scene {
    std::string name;
    std::vector<Remark> remarks{};  ///< for people: which members were guessed; no effect
    int width = 0, height = 0;      ///< of the depth plane, 1 to 16384 pixels
    FrameRate rate;
    double metres_per_unit = 0.001;
    Camera camera;
    /// Lens of stored depth; opening a clip undoes its distortion (engine/formats/pinhole_frames.hpp).
    LensDistortion lens;
    /// Camera of stored colour; null: colour has depth's pixels. Opening a clip moves colour to these pixels.
    std::optional<ColourCamera> colour_camera;
    DepthCoding depth;
    StoredDepth stored;
    int depth_bits = 8;  ///< bits of a stored depth value, 8 to 16; of each of three channels for hue: 8
    /// Metric: what depth that a program has as floats is rounded to, scene units per code, while nothing
    /// says whether depth comes as integers, of `depth.scale`, or as floats; 0: `depth.scale` for both.
    double float_scale = 0;
    HeightCoding height_coding;
    HapticRanges haptic;
    HapticProperties default_properties;  ///< where there is no haptic image
    /// Stiffness of holes in the depth and of their walls, N/mm, whatever the haptic image says there; 0 or
    /// above. Without it a hole has the stiffness of its pixels.
    std::optional<double> hole_stiffness;
    /// Of a camera's pictures without a scene file: a wall that no camera saw must not push with full force
    /// (docs/scene_file.md, Holes).
    static constexpr double soft_holes = 0.1;
    FilterSettings filter;
    FrameInterpolation interpolation = FrameInterpolation::linear;
    /// Device metres per scene unit (S of F = k S (P - G)); without it the Workspace's default.
    std::optional<double> device_metres_per_unit;
    std::optional<FolderSource> folder;
    std::optional<VideoSource> video;  ///< at most one of folder and video
    /// Where the camera stood; null: not known. Not in the scene file: it lies beside the pictures.
    std::shared_ptr<const CameraPath> path{};
};

/// Refuses impossible values with a message that names the member and its number: sizes, planes, ranges,
/// scales, non-finite numbers, a valid range that `derive_valid_range` would set otherwise, a deepest depth
/// more than a million times the nearest, and a height that could leave less than a thousandth of the nearest
/// depth or a millionth of the deepest.
Result<void> validate(const Scene& scene);

/// A set of filters.
struct FilterSet {
    bool median = false, fill_holes = false, terraces = false, temporal = false, flying_pixels = false;
    /// The reach of terrace removal, whether or not `terraces` is set.
    bool terrace_reach = false;
    /// How much of the relief the choice of those that are left open keeps: 0 (smooth) to 1 (as recorded);
    /// nothing: as much as can be kept while hardly more noise is left than with the smoothest.
    std::optional<double> detail{};
    bool any() const { return median || fill_holes || terraces || temporal || flying_pixels; }
    bool operator==(const FilterSet&) const = default;
};
/// Filters that were not stated. They are chosen from the first frames when a clip is opened to be played
/// (choose_filters); in the scene they are off.
using UnstatedFilters = FilterSet;
inline constexpr UnstatedFilters all_unstated{true, true, true, true, true, true};

/// The possible values of a setting: one of some words, a number, or a length along the depth.
struct SettingRange {
    std::vector<const char*> words{};  ///< names, or whole numbers; empty: any in the range
    double least = 0, most = 0;
    bool whole = false;      ///< numbers are whole, also among words
    const char* unit = "";   ///< of a number
    bool by_ratio = false;   ///< numbers differ by a factor: a slider is logarithmic
    bool is_length = false;  ///< a DepthLength above 0

    bool has_names() const { return !words.empty() && !whole; }
    /// The number, or the index of a name, which is the value of an enumeration or a bool. nullopt: not a
    /// possible value.
    std::optional<double> value_of(std::string_view word) const;
    std::string word_of(double value) const;
    bool has(double value) const;
    /// The possible values, for a message: "off, on or auto", "a whole number from 0 to 16 passes".
    std::string in_words() const;
};

/// A row of the table of filter settings. The table is the one place that knows a member of FilterSettings by
/// name, beside the words for what was chosen (chosen_filters.cpp): scene files, `--filters`, the filters'
/// own options, window, scripts, kept settings and reports read it. A setting is a member of FilterSettings,
/// one of FilterSet if it can be left open, and a row.
struct FilterSetting {
    /// Access to the member: a length has both terms, another value only the first, as in
    /// `SettingRange::value_of`.
    struct Value {
        DepthLength (*of)(const FilterSettings& filter);
        void (*set)(FilterSettings& filter, const DepthLength& value);
    };

    const char* name;  ///< in scene files and reports; options and windows have it with_dashes
    Value value;
    SettingRange range{};
    /// The flag of a setting that can be left open; null: a scene file that leaves it out means its default.
    bool FilterSet::*open = nullptr;
    /// Whether leaving it out leaves it open, given the settings above it in the table; null: always.
    bool (*opens)(const FilterSettings&, const FilterSet&) = nullptr;
    const char* what = "";  ///< explanation for a new user; empty: it has no option of its own
    /// Its form in `--filters`, "holes[=PASSES]", and the value that its name alone stands for there; empty:
    /// it has no place there, or needs a value. What has a place there can be left open.
    const char *in_list = "", *usual = "";
    DepthLength FilterSettings::*length = nullptr;  ///< a length that also switches it on; zero: not stated

    /// Sets it to a word that a person typed; returns false if the word is not allowed.
    bool read(std::string_view word, FilterSettings& filter) const;
    std::string right() const;  ///< what `read` takes, for a message
    /// Copies its value, and its `length` if that is stated.
    void copy(const FilterSettings& from, FilterSettings& to) const;
    bool is_default(const FilterSettings& filter) const { return value.of(filter) == value.of({}); }
    bool is_open_if_left_out(const FilterSettings& filter, const FilterSet& unstated) const {
        return open && (!opens || opens(filter, unstated));
    }
};
/// All settings, as a scene file has them.
std::span<const FilterSetting> filter_settings();

inline constexpr int largest_material_index = 65535;
inline constexpr std::size_t most_materials = 256;

/// What a scene file, a format or a person states about a clip. `settle` makes a Scene of it once the clip
/// itself is open.
struct SceneDescription {
    /// Members that are left open.
    struct Unstated {
        bool rate = false;    ///< the frames' own times are used
        bool camera = false;  ///< the median of the cameras in `folder.cameras` is used
        bool far = false;     ///< metric coding: the frames' deepest depth is used (engine/clip/readers.hpp)
        UnstatedFilters filters{};
        bool operator==(const Unstated&) const = default;
    };
    /// Their values as found in the clip.
    struct FoundInClip {
        std::optional<FrameRate> rate{};  ///< without it 30 frames a second
        std::optional<Camera> camera{};
        std::optional<double> far{};  ///< without it the depth of the deepest code
    };
    /// Properties of a renderer's material with this index, 0 to 65535.
    struct Material {
        int index = 0;
        HapticProperties properties;
    };

    SceneDescription() = default;
    /// Makes one of a scene, which leaves nothing open.
    SceneDescription(Scene settled) : scene(std::move(settled)) {}

    Scene scene;  ///< stated members; for open ones, a possible camera and the deepest code as far plane
    Unstated unstated;
    /// If not empty, haptic pictures hold material indices; their reader makes properties of them, by
    /// Scene::haptic, whose ranges hold them all. By index, each once, at most 256.
    std::vector<Material> materials{};
    double error_bars_to = 0;  ///< MeasuredDepth::error_bars_to, where it was measured
};

/// As `validate` of a scene, for what is known already.
Result<void> validate(const SceneDescription& described);

/// The one place where a description becomes a scene: stated values stay, and found values fill in the rest.
/// Errors name no file: a camera that was neither stated nor found, and what `validate` refuses.
Result<Scene> settle(const SceneDescription& described, const SceneDescription::FoundInClip& found);

/// A scene as numbers, for programs without a reader of scene files: every member on which forces depend,
/// except the frames' own times. Always the same names, in the same order; NaN: an optional member without a
/// value.
struct SceneNumber {
    std::string name;
    double value = 0;
};
std::vector<SceneNumber> numbers_of(const Scene& scene);
/// The scene of these numbers, without names, times, lens and remarks. Refuses (ErrorKind::input) other
/// counts, and what `validate` refuses, by name.
Result<Scene> scene_of_numbers(std::span<const double> numbers);

inline constexpr int scene_format_version = 1;

/// Reads and validates a scene file: JSON (docs/scene_file.md). `where` names the text in messages.
/// A newer format version, an unknown member or an impossible number is refused by name.
Result<SceneDescription> parse_scene(std::string_view json, std::string_view where);
Result<SceneDescription> read_scene_file(const std::filesystem::path& file);

/// The description as text; parse_scene returns the same, every double to its last bit, and what is left open
/// stays open. (A remark's `otherwise` is not kept.)
std::string scene_to_json(const SceneDescription& described);

}  // namespace touchable
