// SPDX-License-Identifier: Apache-2.0
#pragma once

// What guesses of a scene are made from (guessed_scene.cpp): evidence of names and files, and the draft that
// takes them. Private to the module.

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/value_evidence.hpp"

namespace touchable {

/// A unit of length as a word of a name.
struct UnitInName {
    double metres;
    const char* words;
};

/// What is known of depth besides its values: by a person, by names, by files beside it.
struct DepthEvidence {
    const SourceDescription& known;
    const SourceDescription::Preset* preset = nullptr;
    std::string why_preset{};                ///< its evidence; empty: a person or a file says it
    std::optional<GuessedCameras> frames{};  ///< cameras of frames that have one each
    std::string list{};                      ///< of pictures and their times; empty: there is none
    bool is_named = false;                   ///< whether the following names were looked at
    bool says_disparity = false, says_range = false;
    std::optional<UnitInName> unit{};
    bool are_heights = false;  ///< a height map's or an elevation model's: what is high is near
    bool are_points = false;   ///< of a cloud
    double usual_unit = 0;     ///< metres of a stored 1, as the format defines it; 0: it does not
    CameraBeside beside{};

    void set_preset(EvidentPreset evident) {
        preset = evident.preset;
        why_preset = std::move(evident.why);
    }
    /// Takes evidence from the pictures' name, or their folder's if theirs has no letters (disp/0001.png).
    void know_name(const std::filesystem::path& path);
    /// Takes evidence from the name of depth's array, which says more than the file's.
    void know_array(const std::string& name);
    /// Whether a preset tells what values stand for, and not only how they are packed.
    bool has_values() const { return preset && preset->has_values(); }
    bool has_unit() const { return has_values() || known.metres_per_code.has_value(); }
    /// Whether a person or the frames' own files state the camera, which counts for more than `beside`.
    bool has_stated_camera() const { return known.intrinsics || known.fov || frames; }
    bool has_camera() const { return has_stated_camera() || beside.camera; }
};

/// A scene as far as it is guessed.
struct SceneDraft : GuessedScene {
    std::filesystem::path own_file{};  ///< the pictures', which is an input in any case

    /// Adds a guess, with the settings that override it.
    void say(std::string guess, Hints hints = {}, RemarkKind kind = RemarkKind::other,
             std::string otherwise = {}) {
        add_remark(scene.remarks, {std::move(guess), true, std::move(otherwise), std::move(hints), kind});
    }
    /// Adds what a file or a person stated, with the settings that override it.
    void tell(std::string fact, Hints hints = {}, std::string otherwise = {}) {
        add_remark(scene.remarks, {std::move(fact), false, std::move(otherwise), std::move(hints)});
    }
    /// Counts a file as read for the scene.
    void add_input(const std::filesystem::path& file) {
        if (file != own_file && std::ranges::find(inputs, file) == inputs.end()) inputs.push_back(file);
    }
};

/// Finds what depth's values mean: their unit, the axis along which they go, and which are no depth. Evidence
/// gets the preset that names and files show together.
Result<void> guess_values(const StoredImage& depth, DepthEvidence& evidence, SceneDraft& draft);

}  // namespace touchable
