// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/real/built_frames.hpp"
#include "bench/real/depth_plane.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// A clip of a real camera, and the criterion for patches on flat faces.
struct CameraRecording {
    std::string name;
    std::filesystem::path clip, scene_file;
    DepthLength noise;  ///< of a stored depth
    /// A patch of 31x31 pixels is flat if its residual is at most `flat` and it is no farther than
    /// farthest_mm. About twice the residual of noise and rounding: a plane with stereo's ripples passes, a
    /// creased face does not.
    DepthLength flat;
    double farthest_mm;
    SensorModel model;  ///< of such a camera
};
/// The cube of RealSense, the castle of SR300 and the room of PrimeSense in a folder of recordings
/// (docs/measurements.md).
CameraRecording cube_recording(const std::filesystem::path& data);
CameraRecording castel_recording(const std::filesystem::path& data);
CameraRecording redwood_recording(const std::filesystem::path& data);

/// The data shared by all filters: the frames, and the planes of each frame's flat patches.
class RecordingPatches {
public:
    explicit RecordingPatches(CameraRecording recording) : recording_(std::move(recording)) {}
    /// Appends the errors of forces with these filters against the planes of the stored depths, for flat
    /// patches of all frames on a grid of 8 pixels (`quick`: 16): see PressErrors; plane_error_deg, the
    /// planes' own standard error, RMS; frame_cpu_ms and frame_ms; depth_mm, the patches' mean depth;
    /// level_mm, the measured level distance at the patches' mean depth (0: every code is a level).
    Result<void> measure(const FilterChoice& choice, bool quick, Figures& figures);

    /// Appends the errors with the filters chosen by the program, for each file format of the same depth
    /// (depth_forms): force_angle_deg_png, ...; forms_apart_deg, the worst less the best.
    Result<void> measure_forms(bool quick, Figures& figures);

    /// See add_details.
    Result<void> measure_details(bool quick, Figures& figures);
    /// See compare_with_others; relief is that of the recording's `model`.
    Result<void> compare(bool quick, Figures& figures);

    /// Cross-validation: filters chosen from every second frame, measured on the frames between: the
    /// program's choice, the best of those it tried, and their ratio: force_angle_deg_chosen,
    /// force_angle_deg_best, times_best. Each half is left out once.
    Result<void> measure_left_out(bool quick, Figures& figures);

private:
    Result<void> read(bool quick);
    /// RMS angle error on every `step`th frame from `first` on.
    Result<double> force_angle_deg(const Filtering& filtering, std::size_t first, std::size_t step = 2) const;

    CameraRecording recording_;
    std::optional<Scene> scene_;  // set once the clip is read
    std::vector<RawFrame> raws_;
    std::vector<std::vector<DepthPlane>> planes_;  // frame by frame
    double plane_error_deg_ = 0;
    double depth_ = 0;  // mean depth of the patches, mm
};

}  // namespace touchable
