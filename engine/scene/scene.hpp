#pragma once

// What a clip means: a SceneDescription is what a scene file, a format or a guess says of it, and may leave
// things open; a Scene is whole, valid and does not change.
//
// `settle` makes the one of the other with what the clip itself tells (rate, size, far plane). A Scene says
// by which Camera (and Lens, and ColourCamera beside it) its pictures were taken and where it stood
// (CameraPath), how stored depth becomes lengths (DepthCoding), how heights and haptic
// pictures become metres, N/m and friction, which filters a builder applies, and at which times frames are
// shown (FrameRate). Remarks say to a person what was guessed. docs/conventions.md has the exact definitions.
// parse_scene and read_scene_file read a scene file, JSON from outside, of which each member is checked
// (docs/scene_file.md); scene_to_json gives a text that is read as the same scene. filter_settings is the
// table of what can be set of filters, by which all that reads, writes or names one of them goes.
//
// Lengths are in scene units unless a name says metres; pixels have integer coordinates at their centres,
// rows go down. All are plain values and pure functions, for any thread.

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
    /// L of the corner of these pictures that is farthest from the axis.
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

/// World point of pixel (x, y) at a planar depth. Scene units.
glm::dvec3 unproject(const Camera& camera, double x, double y, double planar_depth);

/// Where a world point is seen; nothing for a point that is not in front of the camera (Z >= 0).
std::optional<Camera::ImagePoint> project(const Camera& camera, const glm::dvec3& point);

/// How a lens bends what a pinhole would see, after Brown and Conrady, in OpenCV's terms and order: k1, k2,
/// p1, p2, k3, k4, k5, k6. All 0: not at all.
struct LensDistortion {
    std::array<double, 8> terms{};

    /// A place in the plane at distance 1 of a camera: x to the right, y down.
    struct Point {
        double x, y;
    };

    bool any() const { return *this != LensDistortion{}; }
    /// Where the lens shows what a pinhole shows at `point`.
    Point distorted(Point point) const;
    /// So far from the axis distances grow with those of a pinhole. What is farther off would be shown on top
    /// of what is nearer: no lens does that, the terms only say nothing of it. At most 10.
    double reach() const;
    bool operator==(const LensDistortion&) const = default;
};

/// A rotation, row by row, and then a translation, scene units, between cameras: x to the right, y down, z
/// forward, as cameras' own files have them.
struct CameraPose {
    std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::array<double, 3> translation{};

    /// Back again.
    CameraPose inverse() const;
    /// This one, after `first`.
    CameraPose after(const CameraPose& first) const;
    bool operator==(const CameraPose&) const = default;
};

/// The camera of colour pictures that has a place of its own beside depth's.
struct ColourCamera {
    Camera camera;  ///< its fx, fy, cx, cy; where it stands `from_depth` says
    int width = 0, height = 0;
    LensDistortion lens;
    CameraPose from_depth;  ///< a point of depth's camera is R p + t in this one
};

/// When frames are shown. Evenly: frame n is at floor(n 1e9 den / num) ns. Or each at a time of its own (a
/// variable rate): then num / den is the mean, by which frames beyond the last known one follow it.
struct FrameRate {
    std::int64_t num = 30, den = 1;
    std::shared_ptr<const std::vector<std::int64_t>> own_times{};  ///< ns, from 0 up; null: evenly

    std::int64_t time_ns(std::int64_t frame) const;     ///< exact; no overflow for frame < 2^40
    std::int64_t frame_at(std::int64_t time_ns) const;  ///< the last one that is not later; exact too
    std::int64_t nearest(std::int64_t time_ns) const;   ///< the frame that is, the earlier of two
    double per_second() const { return static_cast<double>(num) / static_cast<double>(den); }
};
/// Closer frames are told apart by no container's milliseconds, and by no tick.
inline constexpr std::int64_t shortest_frame_ns = 1'000'000;
/// Of frames at times of their own, ns; the first is time 0. Nothing where there are fewer than two, where
/// one is less than `shortest_frame_ns` after the one before, or where all last longer than 126 years.
std::optional<FrameRate> rate_of_own_times(std::vector<std::int64_t> times_ns);

/// Where a clip's camera stood at each frame, as its makers measured it: a point of the camera is R p + t
/// in a world that stands still. Nothing that is seen or felt goes by it.
struct CameraPath {
    std::vector<std::optional<CameraPose>> poses;  ///< of frames 0, 1, ...; nothing: not known

    struct TimedPose {
        double seconds = 0;
        CameraPose pose;
    };

    std::size_t known() const;
    /// The way from each known place to the next one, scene units.
    double length() const;
    /// Of frames `first`, `first + every`, ... up to `last`.
    CameraPath part(std::int64_t first, std::optional<std::int64_t> last, std::int64_t every) const;
    bool operator==(const CameraPath&) const = default;
};

/// Most frames of a path, whose text a clip's head has room for; and most poses of a list, which may be more
/// often than frames.
inline constexpr std::size_t most_path_frames = 200'000, most_timed_poses = 2'000'000;

/// The rotation of a quaternion, which need not be exactly of length 1; nothing where it is no rotation.
std::optional<std::array<double, 9>> rotation_of(double x, double y, double z, double w);
/// At a place in metres; nothing where that is a million kilometres away or more.
std::optional<CameraPose> pose_at(const std::array<double, 9>& rotation, const std::array<double, 3>& metres,
                                  double metres_per_unit);
/// The nearest rotation's matrix is this one but for what digits were rounded off: 1e-3.
bool is_rotation(const std::array<double, 9>& matrix);

/// Lines "time tx ty tz qx qy qz qw", seconds and metres, as TUM RGB-D's groundtruth.txt; '#' begins a
/// remark. An error names the line.
Result<std::vector<CameraPath::TimedPose>> parse_timed_poses(std::string_view text, const std::string& name,
                                                             double metres_per_unit);
/// The known poses in that form, at the times of their frames.
std::string timed_poses_text(const CameraPath& path, const FrameRate& rate, double metres_per_unit);
/// Poses with the frames of these times; those that are at no frame's time are left out.
CameraPath path_of_timed_poses(const std::vector<CameraPath::TimedPose>& poses, const FrameRate& rate);

/// How a code becomes a depth in scene units; n = code / code_max where near_is_high, 1 - that otherwise.
/// - linear:  far + (near - far) n                   (Eq. 3)
/// - inverse: 1 / (1/far + (1/near - 1/far) n); with a shift s 1 / (1/(far + s) + (1/(near + s) - 1/(far +
/// s)) n)
///            - s
/// - log:     e^(ln(far + shift) + (ln(near + shift) - ln(far + shift)) n) - shift
/// - metric:  scale * code
/// - hue:     as linear, of the code that shaders/hue_code.h makes from an RGB pixel
enum class DepthCodingKind { linear, inverse, metric, hue, log };

struct DepthCoding {
    static constexpr int max_invalid_codes = 4;
    /// Hue: codes of the whole colour circle; the last that a pixel can have is one less.
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
    /// Of all valid codes the smallest depth. Needs one.
    double nearest_depth() const { return depth(deeper_is_higher() ? valid_min : valid_max); }
    /// Of all valid codes the largest depth. Needs one.
    double deepest_depth() const { return depth(deeper_is_higher() ? valid_max : valid_min); }
    /// The valid code whose depth is nearest to `depth` (ties: the lower code).
    std::uint16_t code(double depth) const;
    /// True where a larger code is a larger depth.
    bool deeper_is_higher() const { return kind == DepthCodingKind::metric || !near_is_high; }
    /// One *level*: (far - near)/255, the paper's grey level as a length.
    double level() const { return (far - near) / 255.0; }

    bool operator==(const DepthCoding&) const = default;
};

/// Sets valid_min and valid_max to the least and the greatest code with 0 < depth, near <= depth <= far and
/// code <= code_max that is none of the invalid ones. All between them fit too, but for invalid ones.
void derive_valid_range(DepthCoding& coding);

/// A length that grows with depth z: constant + quadratic z^2, scene units.
struct DepthLength {
    double constant = 0, quadratic = 0;

    double at(double depth) const { return constant + quadratic * depth * depth; }
    DepthLength times(double factor) const { return {factor * constant, factor * quadratic}; }
    bool operator==(const DepthLength&) const = default;
};

/// What a person should know of how a scene came to mean what it means.
struct Remark {
    std::string what;       ///< "the camera sees 60 degrees from left to right"
    bool is_guess = false;  ///< neither a person nor a file said it
    std::string
        otherwise{};  ///< of one just made: what says another, as in "a scene file's rate says otherwise"
    Hints hints{};    ///< of one just made: the settings that do
};

/// What a scene file holds of them at most.
inline constexpr std::size_t most_remarks = 100, longest_remark = 2000;  ///< bytes

/// Adds one, on one line and short enough for a scene file; once only, and none beyond `most_remarks`.
void add_remark(std::vector<Remark>& remarks, Remark remark);
/// `first`, then `rest`, added one by one.
std::vector<Remark> joined_remarks(std::vector<Remark> first, const std::vector<Remark>& rest);

/// As a scene file has it: a guess begins with "guessed: ". What says another is left out, as it may be of
/// the clip that was guessed alone.
std::string remark_text(const Remark& remark);
Remark remark_of_text(std::string_view text);

/// As a person reads it: of a guess that comes from a scene file another scene file says another. Without the
/// hints, whose names a program knows.
std::string remark_in_words(const Remark& remark);

/// What a finger feels at a pixel.
struct HapticProperties {
    double stiffness = 600.0;  ///< N/m
    double static_friction = 0.4;
    double dynamic_friction = 0.3;
};

/// Range of one haptic channel; P = min + (max - min) p / 255 (Eq. 1).
struct PropertyRange {
    double min = 0, max = 0;
    double at(std::uint8_t p) const { return min + (max - min) * p / 255.0; }
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

/// Height (Eq. 2) is a length taken off the depth: depth' = depth - max_height h / code_max, in levels of the
/// depth coding or in scene units.
struct HeightCoding {
    double max_height = 0;
    HeightUnits units = HeightUnits::levels;
    std::uint16_t code_max = 255;
};

/// Length in scene units of the largest height code.
double largest_height(const HeightCoding& height, const DepthCoding& depth);

/// How the surface is found between two frames.
enum class FrameInterpolation { hold, linear };

/// Automatic: where kappa says that it helps (filter_codes.hpp).
enum class TerraceRemoval { off, on, automatic };
/// How far terrace removal may look, in pixels: a power of two from the one to the other.
inline constexpr int least_terrace_reach = 16, most_terrace_reach = 128;

/// Integer filters between stored values and codes; see engine/surface.
struct FilterSettings {
    int median = 0;      ///< window side: 0 (off), 3 or 5
    int fill_holes = 0;  ///< passes, 0 to 16
    TerraceRemoval terraces = TerraceRemoval::off;
    double terrace_noise = 0;  ///< standard deviation of the stored depth, codes, 0 to 4
    /// Distance from one depth that occurs to the next, where that is more than a code's step: cameras that
    /// measure disparity and store millimetres have levels that grow with depth squared.
    DepthLength levels{};
    bool temporal = false;  ///< noise from frame to frame is averaged (filter_codes.hpp)
    /// Standard deviation of a stored depth. Time of flight: mostly constant; stereo and structured light:
    /// mostly quadratic.
    DepthLength temporal_noise{};
    /// Depths that differ by no more belong to one surface; a pixel that hangs between two of them is pulled
    /// to one (flying_pixels.hpp). Zero: off.
    DepthLength flying_pixels{};
    /// Terraces about as wide become slopes.
    int terrace_reach = least_terrace_reach;
    bool operator==(const FilterSettings&) const = default;
};

/// Numbers of a plane whose pictures are not numbered as depth's are. What is left out is as of depth.
struct PictureNumbers {
    std::optional<int> first{};
    std::optional<int> step{};
    bool any() const { return first.has_value() || step.has_value(); }
    bool operator==(const PictureNumbers&) const = default;
};

/// Files of a folder of images: a pattern with one printf-like field of digits ("depth_%04d.png"), or with
/// one star ("depth/*.png": all there are, in order), or a list of them (".txt": a line each, a time before
/// the name where it has one). Where depth is none of these it names a still: a clip of one frame. Stills
/// of other planes serve all frames.
struct FolderSource {
    std::string depth, colour, haptic, height;  ///< empty: no such plane; depth is required
    int first = 0;                              ///< number of the first image
    int count = 0;                              ///< 0: as many as there are without a gap
    int step = 1;                               ///< from one frame's number to the next one's, 1 or more
    PictureNumbers colour_numbers{}, haptic_numbers{}, height_numbers{};
    /// Files with the camera of each frame, where it changes: numbered, with a star, or a list. Empty: none.
    std::string cameras{};
    PictureNumbers camera_numbers{};
    /// Haptic pictures are read though their coding mixes materials. No scene file says so.
    bool haptic_may_be_lossy = false;
};

/// Whether a pattern names a single picture.
bool is_still(std::string_view pattern);
/// Whether it has a field of digits.
bool is_numbered(std::string_view pattern);

/// Where depth is in each picture of a video. Colour is the other half.
enum class VideoLayout { alone, left, right, top, bottom };
/// What of a pixel its depth is: its grey value or luma as stored, (R + G + B) / 3, or for coding hue its
/// colour.
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

/// What pictures hold where it is not the codes of `Scene::depth`. Their reader makes codes of it, by what is
/// in all frames, and settles that coding then.
struct StoredDepth {
    enum class Kind {
        codes,      ///< of Scene::depth; of floats, lengths (metric) or shares of code_max (others)
        disparity,  ///< depth = fx baseline / (scale value + offset)
        relative,   ///< from the least value to the largest there is, evenly in depth or 1 / depth
                    ///< (Scene::depth)
    };
    Kind kind = Kind::codes;
    double baseline = 0;           ///< scene units
    double scale = 1, offset = 0;  ///< pixels of disparity per stored value, and at 0
    bool bytes_swapped = false;    ///< of 16 bits: low byte first where the file's format has it last
    int rotated = 0;               ///< 16 bits: so many to the left, 0 to 15, the upper ones come back below
    /// 16 bits, in that order: so many low ones are depth, 8 to 16; those above mean something else.
    int used_bits = 16;
    bool packed = false;  ///< 24 bits in three channels: red + 256 green + 65536 blue; all bits set: no depth
    bool is_reordered() const { return bytes_swapped || rotated > 0 || used_bits < 16; }
    bool is_plain() const { return kind == Kind::codes && !is_reordered() && !packed; }
    bool operator==(const StoredDepth&) const = default;
};

/// What a clip means. Everything but the pictures. What a scene file leaves open is settled before there is a
/// scene (SceneDescription).
struct Scene {
    std::string name;
    std::vector<Remark> remarks{};  ///< for people: what was guessed of the rest; changes nothing
    int width = 0, height = 0;      ///< of the depth plane, 1 to 16384 pixels
    FrameRate rate;
    double metres_per_unit = 0.001;
    Camera camera;
    /// Of depth as it is stored; opening a clip undoes it (engine/formats/pinhole_frames.hpp).
    LensDistortion lens;
    /// Of colour as it is stored; without it colour has depth's pixels. Opening a clip brings it there.
    std::optional<ColourCamera> colour_camera;
    DepthCoding depth;
    StoredDepth stored;
    int depth_bits = 8;  ///< bits of a stored depth value, 8 to 16; of each of three channels for hue: 8
    HeightCoding height_coding;
    HapticRanges haptic;
    HapticProperties default_properties;  ///< where there is no haptic image
    /// Of holes in the depth and of their walls, N/mm, whatever the haptic image says there; 0 or above.
    /// Without it a hole is as stiff as its pixels are otherwise.
    std::optional<double> hole_stiffness;
    FilterSettings filter;
    FrameInterpolation interpolation = FrameInterpolation::linear;
    /// Device metres per scene unit (S of F = k S (P - G)); without it the Workspace's default.
    std::optional<double> device_metres_per_unit;
    std::optional<FolderSource> folder;
    std::optional<VideoSource> video;  ///< beside a folder: neither, or one of them
    /// Where its camera stood; null: not known. A scene file does not say it: it lies beside the pictures.
    std::shared_ptr<const CameraPath> path{};
};

/// Everything that cannot be is refused here by a message that names the member and its number: sizes,
/// planes, ranges, scales, non-finite numbers, a valid range that `derive_valid_range` would set otherwise,
/// depths of which the deepest is more than a million times the nearest, and a height that could leave less
/// than a thousandth of the nearest depth or a millionth of the deepest.
Result<void> validate(const Scene& scene);

/// Some of the filters.
struct FilterSet {
    bool median = false, fill_holes = false, terraces = false, temporal = false, flying_pixels = false;
    /// Of terrace removal, whether that is among them or not.
    bool terrace_reach = false;
    bool any() const { return median || fill_holes || terraces || temporal || flying_pixels; }
    bool operator==(const FilterSet&) const = default;
};
/// Filters that were not stated. They are chosen when a clip is opened to be played, by what its first frames
/// tell (choose_filters); in the scene they are off.
using UnstatedFilters = FilterSet;
inline constexpr UnstatedFilters all_unstated{true, true, true, true, true, true};

/// What a setting can be: one of some words, a number, or a length along the depth.
struct SettingRange {
    std::vector<const char*> words{};  ///< names, or whole numbers; empty: any in the range
    double least = 0, most = 0;
    bool whole = false;      ///< of numbers, among words too
    const char* unit = "";   ///< of a number
    bool by_ratio = false;   ///< numbers differ by a factor: a slider is logarithmic
    bool is_length = false;  ///< a DepthLength above 0

    bool has_names() const { return !words.empty() && !whole; }
    /// The number, or of names the place among them, which is the value of an enumeration or a bool. Nothing:
    /// it is none.
    std::optional<double> value_of(std::string_view word) const;
    std::string word_of(double value) const;
    bool has(double value) const;
    /// What is right, for a message: "off, on or auto", "a whole number from 0 to 16 passes".
    std::string in_words() const;
};

/// A row of the table of filters' settings. The table is the one place that knows a member of FilterSettings
/// by name: scene files, `--filters`, the filters' own options, window, scripts, kept settings and reports
/// read it. A setting is a member of FilterSettings, one of FilterSet where it can be left open, and a row.
struct FilterSetting {
    /// The member. Of a length both terms, otherwise the first, as `SettingRange::value_of` has it.
    struct Value {
        DepthLength (*of)(const FilterSettings& filter);
        void (*set)(FilterSettings& filter, const DepthLength& value);
    };

    const char* name;  ///< in scene files and reports
    Value value;
    SettingRange range{};
    /// Whether it was left open, stated or chosen; null: a scene file that leaves it out has its default.
    bool FilterSet::*open = nullptr;
    /// Whether leaving it out leaves it open, by members that are above it in the table; null: it does.
    bool (*opens)(const FilterSettings&, const FilterSet&) = nullptr;
    const char* what = "";  ///< for a person who sees it for the first time; empty: no option has it alone
    /// As a part of `--filters`, "holes[=PASSES]", and the value that its name alone stands for there; empty:
    /// it is no part of it, and there has to be a value.
    const char *in_list = "", *usual = "";
    DepthLength FilterSettings::*length = nullptr;  ///< that switches it on as well; zero: it is not stated

    std::string typed_name() const;  ///< in options and windows: '-' in place of '_'
    /// Takes a word that a person typed, or refuses it by false.
    bool read(std::string_view word, FilterSettings& filter) const;
    std::string right() const;  ///< what `read` takes, for a message
    /// Its value, and the length that goes with it where that is stated.
    void copy(const FilterSettings& from, FilterSettings& to) const;
    bool is_default(const FilterSettings& filter) const { return value.of(filter) == value.of({}); }
    bool is_open_if_left_out(const FilterSettings& filter, const FilterSet& unstated) const {
        return open && (!opens || opens(filter, unstated));
    }
};
/// All of them, as a scene file has them.
std::span<const FilterSetting> filter_settings();

inline constexpr int largest_material_index = 65535;
inline constexpr std::size_t most_materials = 256;

/// What a scene file, a format or a person says of a clip. `settle` makes its scene of that, once the clip
/// itself is there.
struct SceneDescription {
    /// What it leaves open.
    struct Unstated {
        bool rate = false;    ///< the frames' own times stand
        bool camera = false;  ///< the median of the cameras in `folder.cameras` stands
        bool far = false;     ///< of metric coding: what the frames reach stands (engine/clip/readers.hpp)
        UnstatedFilters filters{};
        bool operator==(const Unstated&) const = default;
    };
    /// What the clip tells of that.
    struct FoundInClip {
        std::optional<FrameRate> rate{};  ///< without it 30 frames a second
        std::optional<Camera> camera{};
        std::optional<double> far{};  ///< without it the depth of the deepest code
    };
    /// What a renderer's material of this index, 0 to 65535, feels like.
    struct Material {
        int index = 0;
        HapticProperties properties;
    };

    SceneDescription() = default;
    /// Of a scene, which leaves nothing open.
    SceneDescription(Scene settled) : scene(std::move(settled)) {}

    Scene scene;  ///< what is stated. Of what is not: a camera that could be, the deepest code as far plane
    Unstated unstated;
    /// Where there are any, haptic pictures are of material indices; their reader makes properties of them,
    /// by Scene::haptic, which holds them all. By index, each once, at most 256.
    std::vector<Material> materials{};
};

/// As `validate` of a scene, of what is known already.
Result<void> validate(const SceneDescription& described);

/// The one place where a description becomes a scene. What is stated stands, and what was found fills in the
/// rest. Refused without a place: a camera that was neither stated nor found, and what `validate` refuses.
Result<Scene> settle(const SceneDescription& described, const SceneDescription::FoundInClip& found);

inline constexpr int scene_format_version = 1;

/// Reads and validates a scene file: JSON (docs/scene_file.md). `where` names the text in messages.
/// A newer format version, an unknown member or an impossible number is refused by name.
Result<SceneDescription> parse_scene(std::string_view json, std::string_view where);
Result<SceneDescription> read_scene_file(const std::filesystem::path& file);

/// The same description as text; parse_scene gives back the same, every double to its last bit. (Of a remark
/// what says otherwise is not kept.) What it leaves open stays open.
std::string scene_to_json(const SceneDescription& described);

}  // namespace touchable
