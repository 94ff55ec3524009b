#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/camera.hpp"
#include "engine/scene/camera_path.hpp"
#include "engine/scene/code_curve.hpp"
#include "engine/scene/colour_camera.hpp"
#include "engine/scene/depth_coding.hpp"
#include "engine/scene/frame_rate.hpp"
#include "engine/scene/lens.hpp"
#include "engine/scene/remark.hpp"

namespace touchable {

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

/// Automatic: where kappa says that it helps (terraces.hpp).
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
    bool temporal = false;  ///< noise from frame to frame is averaged (temporal.hpp)
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

/// What pictures hold where it is not the codes of `Scene::depth`. Whoever reads them makes codes of it, by
/// what is in all frames, and settles that coding then.
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
    bool is_plain() const { return kind == Kind::codes && !bytes_swapped && rotated == 0; }
    bool operator==(const StoredDepth&) const = default;
};

/// What a clip means. Everything but the pictures. What a scene file leaves open is settled before there is a
/// scene (scene_description.hpp).
struct Scene {
    std::string name;
    std::vector<Remark> remarks{};  ///< for people: what was guessed of the rest; changes nothing
    int width = 0, height = 0;      ///< of the depth plane, 1 to 16384 pixels
    FrameRate rate;
    double metres_per_unit = 0.001;
    Camera camera;
    LensDistortion
        lens;  ///< of depth as it is stored; whoever opens a clip undoes it (registered_colour.hpp)
    /// Of colour as it is stored; without it colour has depth's pixels. Whoever opens a clip brings it there.
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
    /// Where its camera stood, for who asks; null: nobody knows. A scene file does not say it: it lies beside
    /// the pictures.
    std::shared_ptr<const CameraPath> path{};
};

/// Everything that cannot be is refused here by a message that names the member and its number: sizes,
/// planes, ranges, scales, non-finite numbers, a valid range that `derive_valid_range` would set otherwise,
/// depths of which the deepest is more than a million times the nearest, and a height that could leave less
/// than a thousandth of the nearest depth or a millionth of the deepest.
Result<void> validate(const Scene& scene);

}  // namespace touchable
