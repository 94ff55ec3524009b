#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/formats/camera_beside.hpp"
#include "engine/formats/depth_values.hpp"
#include "engine/formats/guessed_cameras.hpp"
#include "engine/formats/guessed_scene.hpp"
#include "engine/formats/presets.hpp"
#include "engine/formats/value_estimator.hpp"
#include "engine/formats/value_evidence.hpp"

namespace touchable {

/// Whether its values are whole numbers of 16 bits.
bool holds_words(const StoredImage& picture);

/// A scene in the making, of depth as in one picture: its camera, unit, values and rate. What is not said or
/// known is guessed, and each guess is a remark.
class SceneGuess {
public:
    SceneGuess(const SourceDescription& known, const Preset* preset) : known_(known), preset_(preset) {}

    /// Of depth as in this picture; `coding`, if any, stands, whatever its values are.
    Result<void> describe(const std::filesystem::path& folder, const StoredImage& depth,
                          const DepthCoding* coding = nullptr);
    GuessedScene made() { return {std::move(described_), std::move(inputs_), {}, {}}; }
    Scene& scene() { return scene_; }
    void say(std::string guess, std::string otherwise = {}, Hints hints = {}) {
        add_remark(scene_.remarks, {std::move(guess), true, std::move(otherwise), std::move(hints)});
    }
    void say(std::string guess, Hints hints) { say(std::move(guess), {}, std::move(hints)); }
    /// What a file or a person said, and the settings that say another.
    void tell(std::string fact, std::string otherwise = {}, Hints hints = {}) {
        add_remark(scene_.remarks, {std::move(fact), false, std::move(otherwise), std::move(hints)});
    }
    /// Of a rendering, which may have colour in depth's own files.
    void tell_of_layers(const BesideDepth& beside, bool has_colour);
    void tell_of_preset(const EvidentPreset& evident);
    void tell_of_jpeg(const StoredImage& depth);
    void know_cameras(const GuessedCameras& cameras) { frames_ = cameras; }
    void know_list(const std::string& file) { list_ = file; }
    /// Where a camera's file is sought; its folder is that of `describe`.
    void know_place(PicturesOfCamera place) { place_ = std::move(place); }
    /// By the times of its frames, or a rate that a file beside them states.
    Result<void> find_rate(const std::filesystem::path& folder);
    /// Where files there say that colour does not lie on depth's pixels: takes colour's camera from them, or
    /// says that colour is taken to lie there all the same.
    void place_colour(const std::filesystem::path& folder, const std::filesystem::path& colour,
                      ReadPictures& pictures);

private:
    bool take_colour_camera(const std::filesystem::path& movement, const Image& colour);
    Result<void> find_camera(const std::filesystem::path& folder);
    std::string not_understood() const;
    void doubt_unit(const EstimatedValues& values);
    void take(const Intrinsics& intrinsics, const std::string& whose);
    void take_fov(double degrees);
    Result<void> find_unit(const EstimatedValues& values);
    void guess_unit(const EstimatedValues& values);
    bool guess_unit_of_multiples(const EstimatedValues& values);
    void set_metric(double metres_per_code);
    void set_invalid(const StoredImage& depth, bool has_negative_none);
    void set_relative(bool near_is_high, bool is_inverse);

    const SourceDescription& known_;
    const Preset* preset_;
    SceneDescription described_;
    Scene& scene_ = described_.scene;
    std::vector<std::filesystem::path> inputs_;
    PicturesOfCamera place_;
    CameraBeside beside_;
    CameraFile file_;                       // that beside_ has, if any
    std::optional<GuessedCameras> frames_;  // that have one each
    std::string list_;                      // of pictures and their times; empty: there is none
    bool has_camera_of_depth_ = false;      // which was said, or read
};

}  // namespace touchable
