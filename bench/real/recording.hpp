#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/real/depth_plane.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// A clip of a real camera, and which of its patches are the flat faces of things.
struct CameraRecording {
    std::string name;
    std::filesystem::path clip, scene_file;
    DepthLength noise;  ///< of a stored depth
    /// A patch of 31x31 pixels is flat whose residual is at most this, and no farther than that. About twice
    /// what noise and rounding make: a plane passes with the waves that stereo puts on it, a creased face
    /// does not.
    DepthLength flat;
    double farthest_mm;
};
/// The cube of RealSense and the room of PrimeSense in a folder of recordings (docs/measurements.md).
CameraRecording cube_recording(const std::filesystem::path& data);
CameraRecording redwood_recording(const std::filesystem::path& data);

/// What is the same for each filter: its frames, and the planes of the flat patches of each.
class RecordingPatches {
public:
    explicit RecordingPatches(CameraRecording recording) : recording_(std::move(recording)) {}
    /// Appends what fingers feel with these filters against the planes of the stored depths, flat patches of
    /// all frames on a grid of 8 pixels (`quick`: 16): see PressErrors; plane_error_deg, the planes' own
    /// standard error, RMS; frame_cpu_ms and frame_ms; depth_mm, the patches' mean depth; level_mm, the level
    /// distance that was measured, at the patches' mean depth (0: every code is a level).
    Result<void> measure(const FilterChoice& choice, bool quick, Figures& figures);

    /// Appends what fingers feel with the filters that the program chooses, in each form of the same depth
    /// (depth_forms): force_angle_deg_png, ...; forms_apart_deg, the worst less the best.
    Result<void> measure_forms(bool quick, Figures& figures);

    /// What is chosen by every second frame, on the frames between them: the filters that the program
    /// chooses, and the best of those that it tried: force_angle_deg_chosen, force_angle_deg_best, and the
    /// one over the other, times_best. Each half is left out once.
    Result<void> measure_left_out(bool quick, Figures& figures);

private:
    Result<void> read(bool quick);
    /// Of every second frame from `first` on, RMS.
    Result<double> force_angle_deg(const Scene& scene, std::size_t first) const;

    CameraRecording recording_;
    std::optional<Scene> scene_;  // once it is read
    std::vector<RawFrame> raws_;
    std::vector<std::vector<DepthPlane>> planes_;  // frame by frame
    double plane_error_deg_ = 0;
    double depth_ = 0;  // of the patches, mean
};

}  // namespace touchable
