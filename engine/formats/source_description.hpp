// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is known of depth pictures, videos and recordings that have no scene file: a SourceDescription. A
// program fills it in from what a person typed and passes it to open_clip, guess_clip (open_clip.hpp) or a
// camera (engine/camera, guess_camera). Everything that it leaves out is guessed, and the scene's remarks say
// so. with_still_maps lays a person's touch pictures (StillMaps) under all frames of an open clip.
//
//   SourceDescription known;
//   known.metres_per_code = 0.001;
//   known.preset = "tum";
//   TRY_ASSIGN(known.intrinsics, read_intrinsics("camera.json"));
//   TRY_ASSIGN(auto clip, open_clip("pictures", {}, known));
//
// A stated value counts for more than a preset, and a preset for more than a file beside the pictures, except
// for intrinsics: a camera's file beside the pictures counts for more than the preset's. Lengths are metres,
// angles degrees, places in a picture pixels from the middle of its upper left pixel.
//
// Threads: any may call any function: types are plain values, the table of presets is constant, and nothing
// else is shared. A clip is one thread's at a time.

#include <filesystem>
#include <span>
#include <variant>

#include "engine/base/result.hpp"
#include "engine/clip/clip.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Focal lengths and principal point, pixels.
struct Intrinsics {
    double fx = 0, fy = 0;
    std::optional<double> cx{}, cy{};  ///< nothing: the middle of the picture
    int width = 0, height = 0;         ///< of the camera's pictures; 0: any size
    /// Degrees from edge to edge, across and down, used if fx is 0; 0: not stated, and pixels are square.
    double fov_x = 0, fov_y = 0;
    bool is_fov_either_way = false;  ///< whether it goes across or down is a guess
    bool is_ndc = false;  ///< PyTorch3D's: of halves of the shorter side, from the middle, left and up
    bool operator==(const Intrinsics&) const = default;
};

/// The camera with this view whose pictures are `width` x `height`.
Camera scaled_camera(const Intrinsics& intrinsics, int width, int height);

/// What a person states of pictures without a scene file. What is left out is guessed, with remarks.
struct SourceDescription {
    /// What is known of the pictures of a data set, a camera or a program.
    struct Preset {
        const char* name;
        const char* what;            ///< in words
        Intrinsics intrinsics{};     ///< fx 0: from `fov` or a file beside the pictures
        double fov = 0;              ///< from edge to edge, degrees
        double metres_per_code = 0;  ///< 0: not metric
        int invalid = 0;             ///< a code other than 0 that is no depth
        StoredDepth stored{};
        /// Whether it tells what a value stands for; otherwise only in which bytes it is.
        bool has_values() const { return metres_per_code > 0 || stored.kind != StoredDepth::Kind::codes; }
    };

    std::optional<Intrinsics> intrinsics;
    std::optional<double> fov;                  ///< from the left edge to the right one, degrees
    std::optional<double> metres_per_code;      ///< for metric depth: metres of a stored 1
    std::filesystem::path file;                 ///< from which `intrinsics` were read, if any
    std::optional<DepthSemantics> semantics{};  ///< along the camera's axis (planar) or along the ray (range)
    std::string preset;                         ///< a name of a Preset or of VideoValues; empty: none
    /// Planes of depth buffers and of depth without a scale, metres; both or neither.
    std::optional<double> near{}, far{};
    /// For arrays with a confidence beside depth (open_npy_stack).
    std::optional<double> least_confidence{};
    std::string channel{};  ///< of renderings (OpenEXR): depth's channel or layer; empty: found by its name
    std::string dataset{};  ///< of HDF5 and .npz: depth's data set or array; empty: found by its name
    bool operator==(const SourceDescription&) const = default;
};

/// A row of the table of source settings. The table is the one place that knows a member of SourceDescription
/// by name: options, messages, recordings and the C API read it. A setting is a member and a row; intrinsics
/// are no row, as they are several numbers or a file.
struct SourceSetting {
    using Value = std::variant<double, std::string>;

    Setting::Name name;         ///< in recordings and hints
    const char* what;           ///< explanation for a new user
    const char* form = "NAME";  ///< of its value, as typed
    SettingRange range{};       ///< of a number, or a text's possible words; neither: any text
    /// Whether it describes pictures, so that no scene file may do so. Otherwise the rest still comes from a
    /// scene file or from guesses.
    bool describes = true;
    std::optional<Value> (*get)(const SourceDescription& known) = nullptr;  ///< nothing: not stated
    void (*set)(const Value& value, SourceDescription& known) = nullptr;    ///< to a value in its range

    bool is_number() const { return range.least < range.most; }
    /// Sets it to a number or a text, as `is_number` says; false: the value is out of range.
    bool state(const Value& value, SourceDescription& known) const;
};
/// All settings, in the order in which a recording has them.
std::span<const SourceSetting> source_settings();
/// Null: no setting has that name.
const SourceSetting* source_setting(Setting::Name name);

std::span<const SourceDescription::Preset> all_presets();
/// Null: no preset has that name.
const SourceDescription::Preset* preset_named(const std::string& name);

/// The preset of pictures packed so; null: of none.
const SourceDescription::Preset* preset_of(Packing packing);

/// What of a video's pixels is depth, by the name of a preset that is for videos alone.
std::optional<VideoValues> video_values_named(const std::string& name);

/// Reads the first camera in a camera's own file of up to 16 MiB: JSON, YAML, XML, a matrix, or the files of
/// COLMAP, Kalibr, Middlebury, ORB-SLAM and ARKitScenes. An error says what a file without a camera should
/// have.
Result<Intrinsics> read_intrinsics(const std::filesystem::path& file);

/// Guesses the scene of a live depth camera by its first picture; it names no files. `inputs` gets the files
/// that were read for it.
Result<SceneDescription> guess_camera(const StoredImage& first, const SourceDescription& known,
                                      std::vector<std::filesystem::path>& inputs);

/// A remark that doubts the unit of a clip whose median depth, in metres, no depth camera measures; nothing
/// if the unit may be right. `otherwise` and `hints` are the remark's.
std::optional<Remark> unit_doubt(double median_m, std::string otherwise, Hints hints);

/// Touch pictures that serve a whole clip, in place of its own.
struct StillMaps {
    /// A picture (RGB: stiffness, static and dynamic friction; grey: stiffness), X3D with a
    /// HapticTexturesSurface, or glTF with MPEG_haptic_material.
    std::optional<std::filesystem::path> haptic;
    std::optional<std::filesystem::path> height;  ///< a picture in grey
};
/// The clip with these maps under every frame.
Result<std::unique_ptr<ClipReader>> with_still_maps(Result<std::unique_ptr<ClipReader>> clip,
                                                    const StillMaps& maps);

}  // namespace touchable
