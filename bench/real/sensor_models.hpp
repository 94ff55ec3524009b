// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "bench/real/depth_map.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Model of a depth camera's errors, as published; millimetres.
struct SensorModel {
    std::string name;
    double code_mm = 1;          ///< depth per stored code
    double far_mm = 0;           ///< deeper surfaces have no depth
    double disparity_step = 0;   ///< level spacing in 1 / depth, 1/mm; 0: every code is a level
    double axial_constant = 0;   ///< standard deviation at a depth z: this
    double axial_quadratic = 0;  ///< + this (z - axial_from)^2
    double axial_from = 0;
    double lateral_px = 0;   ///< standard deviation of a silhouette's position
    double mixed_share = 0;  ///< share of pixels at a silhouette with a depth between its sides
    double stray_share = 0;  ///< share of all pixels at stray_mm
    double stray_mm = 0;
    double lone_share = 0;     ///< share of all pixels two levels nearer or farther
    bool half_floats = false;  ///< stores metres as half floats: 11 bits per power of two
    int correlated_px =
        0;              ///< noise is the mean over so many pixels, across and down; 0: neighbours share half
    double blotch = 0;  ///< standard deviation of blotches 16 pixels wide that stay, over that of the noise
    double multipath_mm = 0;   ///< standard deviation of an error that stays, and varies over 96 pixels
    double wobble_mm = 0;      ///< the same over 64 pixels, new in each frame, as of depth networks
    int bleed_px = 0;          ///< near things cover so many pixels more
    double dropout_share = 0;  ///< share of all pixels without a depth
    double gain = 0;           ///< a frame's depths are off by up to this share
    bool is_stereo = false;    ///< librealsense filters it as disparity
    int every_px = 1;          ///< pictures have every so many of the room's pixels
    DepthLength stated_noise;  ///< the axial noise as stated by a scene

    /// Standard deviation of the stored value of a depth.
    double sigma(double depth) const;
    /// Spacing of levels at a depth.
    double level(double depth) const;
    /// The least distinguishable step: a level, or, if a level is less than three quarters of it, sqrt(12)
    /// sigma, the level spacing with the same roughness.
    double least_step(double depth) const;
};

/// Kinect, first generation. Axial noise 1.2 + 1.9 (z - 0.4)^2 mm, z in metres, and 0.8 pixels at
/// silhouettes: Nguyen, Izadi and Lovell 2012. Levels: even steps of disparity, 2.95 z^2 mm apart, within 3 %
/// of the 2.73 z^2 + 0.74 z - 0.58 mm of Smisek, Jancosek and Pajdla 2011 from 1 to 4 m. Millimetres.
SensorModel kinect_v1();
/// The same, with 0.3 % (assumed) lone pixels two levels off, so that 1.8 % of all faces have one as a
/// corner; in a recording about 1.7 % of the forces were off by more than 20 degrees.
SensorModel kinect_with_lone_pixels();
/// Structured light with levels 20 mm apart and noise of 6 mm at 1.5 m (both assumed).
SensorModel coarse_light();
/// Time of flight: Azure Kinect, narrow and unbinned. Noise of 0.9 + 0.3 z^2 mm (assumed; z in metres),
/// shared by neighbours. Millimetres.
SensorModel azure_kinect();
/// No camera: a render without noise, stored as half floats of metres up to 16 m.
SensorModel half_float_render();
/// Stereo with a base of 50 mm: disparity has a standard deviation of 0.08 pixels (Grunnet-Jepsen, Sweetser
/// and Woodfill 2018) and steps of 1/32 pixel (Grunnet-Jepsen, Sweetser, Khuong, Tong and Woodfill 2019).
/// Millimetres. `focal_length` in pixels.
SensorModel d435(double focal_length);
/// The same with noise that 3 to 7 pixels share, as matching by windows leaves it.
SensorModel d435_by_windows(double focal_length, int pixels);
/// Short range, coded light or time of flight: noise of 1 + z^2 mm (z in metres; assumed, 1 to 2 mm within
/// its range), three in ten pixels at silhouettes between both sides, codes of 0.125 mm.
SensorModel sr300();
/// An invented camera, drawn at random: levels of disparity or none, codes of 0.1 to 1 mm, constant or
/// growing noise, mixed or clean edges, and a few pixels at 19.7 m. `number`: from 1 on; from 9 on with some
/// of: noise correlated over 3 to 7 pixels, blotches, multipath, bleeding edges, dropouts, a gain that
/// changes from frame to frame by 0.1 to 0.6 %, half floats.
SensorModel drawn_model(int number);
/// A depth network's smooth wobble of 3 mm, no noise from pixel to pixel. `code_mm`: depth per code.
SensorModel depth_network(double code_mm);
/// A phone's LiDAR: half floats of metres in 320x240 pixels, kappa 0.12 to 0.23, and noise.
SensorModel phone(double noise_mm);
/// The same levels and codes, without noise.
SensorModel without_noise(SensorModel model);

/// A scene of this camera's pictures: 30 frames a second, 600 N/m, no friction, no filter, the model's stated
/// noise.
Scene scene_of(const SensorModel& model, int width, int height, const Camera& camera);
/// Frame `number` of this camera's stored depths. Noise is new in each frame, and neighbours share half of
/// it. The same bits on every machine.
RawFrame stored_frame(const SensorModel& model, const Scene& scene, const DepthMap& truth,
                      std::int64_t number);

}  // namespace touchable
