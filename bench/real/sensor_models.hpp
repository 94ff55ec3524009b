#pragma once

#include <cstdint>
#include <string>

#include "bench/real/depth_map.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a depth camera makes of a true depth, as published; millimetres.
struct SensorModel {
    std::string name;
    double code_mm = 1;          ///< of a stored code
    double far_mm = 0;           ///< deeper things have no depth
    double disparity_step = 0;   ///< levels are even steps of 1 / depth, 1/mm; 0: every code is one
    double axial_constant = 0;   ///< standard deviation of a depth z: this
    double axial_quadratic = 0;  ///< + this (z - axial_from)^2
    double axial_from = 0;
    double lateral_px = 0;   ///< standard deviation of where a silhouette is seen
    double mixed_share = 0;  ///< of the pixels at a silhouette, those anywhere between its sides
    double stray_share = 0;  ///< of all pixels, those that are at stray_mm
    double stray_mm = 0;
    double lone_share = 0;     ///< of all pixels, those that are two levels nearer or farther
    bool half_floats = false;  ///< of metres: 11 bits from each power of two to the next
    DepthLength stated_noise;  ///< the axial one as a scene states it

    /// Standard deviation of what is stored of a depth.
    double sigma(double depth) const;
    /// From one level to the next.
    double level(double depth) const;
    /// The least step that it can tell from none: a level, or sqrt(12) sigma, as levels that far apart would
    /// be as rough, where a level is less than three quarters of that.
    double least_step(double depth) const;
};

/// Kinect of the first kind. Axial noise 1.2 + 1.9 (z - 0.4)^2 mm, z in metres, and 0.8 pixels at
/// silhouettes: Nguyen, Izadi and Lovell 2012. Levels: even steps of disparity, 2.95 z^2 mm apart, which are
/// the 2.73 z^2 + 0.74 z - 0.58 mm of Smisek, Jancosek and Pajdla 2011 to 3 % from 1 to 4 m. Millimetres.
SensorModel kinect_v1();
/// The same, with lone pixels two levels off: 0.3 % (assumed), so that 1.8 % of all faces have one for a
/// corner, as about 1.7 % of a recording's forces were off by more than 20 degrees.
SensorModel kinect_with_lone_pixels();
/// Structured light whose levels are 20 mm apart at 1.5 m, with noise of 6 mm there (both assumed).
SensorModel coarse_light();
/// Time of flight: Azure Kinect, narrow and unbinned. Noise of 0.9 + 0.3 z^2 mm (assumed; z in metres), which
/// neighbours share, millimetres.
SensorModel azure_kinect();
/// No camera: a render without noise, kept as half floats of metres up to 16 m.
SensorModel half_float_render();
/// Stereo with a base of 50 mm: disparity has a standard deviation of 0.08 pixels (Grunnet-Jepsen, Sweetser
/// and Woodfill 2018) and steps of 1/32 pixel (Grunnet-Jepsen, Sweetser, Khuong, Tong and Woodfill 2019).
/// Millimetres. `focal_length` in pixels.
SensorModel d435(double focal_length);
/// Short range, coded light or time of flight: noise of 1 + z^2 mm (z in metres; assumed, 1 to 2 mm within
/// its range), three in ten pixels at silhouettes anywhere between both sides, 0.125 mm codes.
SensorModel sr300();
/// An invented camera: levels of disparity or none, codes of a tenth of a millimetre to one, noise
/// that is constant or grows, edges that are mixed or not, and a few pixels at 19.7 m, drawn at random.
/// `number`: which, 1 to 8.
SensorModel drawn_model(int number);
/// The same levels and codes, without noise.
SensorModel without_noise(SensorModel model);

/// A scene of this camera's pictures: 30 frames a second, 600 N/m, no friction, no filter, noise as the model
/// states it.
Scene scene_of(const SensorModel& model, int width, int height, const Camera& camera);
/// Frame `number` of what this camera stores of true depths. Noise is new in each frame, and neighbours share
/// half of it. The same bits everywhere.
RawFrame stored_frame(const SensorModel& model, const Scene& scene, const DepthMap& truth,
                      std::int64_t number);

}  // namespace touchable
