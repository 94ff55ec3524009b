// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "bench/real/built_frames.hpp"
#include "bench/real/depth_plane.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/real/pressing.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The rooms of ICL-NUIM (Handa, Whelan, McDonald and Davison 2014), whose true depth is known, as stored by
/// a depth camera: from their original viewpoints with new noise in each frame, and with the camera moving
/// forward at 0.3 m/s. These sequences are generated, not recorded.
class KnownRoom {
public:
    /// `factor`: scales the rooms, for a camera of short range.
    KnownRoom(std::filesystem::path data, SensorModel model, double factor)
        : data_(std::move(data)), model_(std::move(model)), factor_(factor) {}

    /// Appends the figures of PressErrors for the last of some frames of each room against its true normals,
    /// those of measure_rest, lag_mm, frame_cpu_ms and frame_ms, and level_mm, the measured level distance at
    /// the room's median depth (0: every code is a level). `quick`: two rooms.
    Result<void> measure(const FilterChoice& choice, bool quick, Figures& figures);
    /// The errors of the chosen filters, in two rooms.
    Result<PressErrors> press_chosen();
    /// See add_details.
    Result<void> measure_details(Figures& figures);
    /// See compare_with_others.
    Result<void> compare(bool quick, Figures& figures);
    /// Appends the error with the filters chosen by the program, and the best of all: every median, levels of
    /// a tenth to twice the sensor's least step, and averaging for no noise, its noise or more.
    /// force_angle_deg_chosen, _best among those that keep edges (keeps_edges), _best_of_all; times_best.
    Result<void> search(bool quick, Figures& figures);

    /// RMS angles of force, degrees: with the chosen filters, with none, and with the best edge-keeping one.
    struct Judged {
        double chosen = 0, off = 0, best = 0;
    };
    /// Of a film, and of one frame alone whose holes are filled, without averaging.
    struct Searched {
        Judged film, still;
        std::size_t details = 0;  ///< points between smooth and as recorded, of the film
    };
    /// The same with fewer candidates, in two rooms.
    Result<Searched> search_quickly();
    /// Forces on a film or on stills with the chosen filters, and what their frames say of them.
    Result<std::vector<BarPlace>> press_with_bars(bool still, bool quick);
    /// Chooses anew by five other seeds of noise, half of the frames, half of the picture's width and height,
    /// and another room. The largest error of these choices over that of the first one, on the first room.
    Result<double> choose_again();

private:
    struct Room {
        DepthMap truth;
        std::vector<DepthPlane> smooth;  ///< smooth places
        std::vector<RawFrame> stored;
    };
    struct Moment {
        DepthMap truth;
        std::vector<DepthPlane> smooth;
    };

    std::vector<DepthPlane> smooth_places(const DepthMap& truth, int step) const;
    Result<void> make_rooms(bool quick, int frames_of_first, int frames_of_others);
    Result<void> make(bool quick);
    RawFrame filled(const RawFrame& raw) const;
    using Press = std::function<Result<double>(const Scene&)>;  // degrees
    Result<double> best_by_hand(const Scene& scene, std::span<const double> averaging,
                                std::span<const double> levels, const Press& press,
                                double* best_of_all) const;
    /// Errors of forces on the filtered surface, against true normals.
    Result<PressErrors> pressed(const Filtering& filtering,
                                double trusted_to = std::numeric_limits<double>::infinity()) const;
    Result<void> make_approach();
    Result<double> lag(const Filtering& filtering, const std::vector<SurfaceFrame>& at_rest) const;

    std::filesystem::path data_;
    SensorModel model_;
    double factor_;
    std::optional<Scene> scene_;  // set once everything is made
    std::vector<Room> rooms_;     // resting fingers and the moving camera use the first one
    std::vector<DepthPlane> resting_places_;
    std::vector<Moment> approach_;
    std::vector<RawFrame> approach_stored_;
};

/// How often the error bars of forces hold, in these rooms as these cameras film them (bench/README.md).
Result<void> measure_error_bars(const std::filesystem::path& data, const std::vector<SensorModel>& models,
                                bool quick, Figures& figures);

}  // namespace touchable
