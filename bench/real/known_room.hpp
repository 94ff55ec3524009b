#pragma once

#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "bench/real/depth_plane.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/real/pressing.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The rooms of ICL-NUIM (Handa, Whelan, McDonald and Davison 2014), whose true depth is known, as a depth
/// camera would store them: from where they were seen, with new noise in each frame, and while the camera
/// goes ahead at 0.3 m/s. These sequences are made, not recorded.
class KnownRoom {
public:
    /// `factor`: the rooms are so many times as large, for a camera of short range.
    KnownRoom(std::filesystem::path data, SensorModel model, double factor)
        : data_(std::move(data)), model_(std::move(model)), factor_(factor) {}

    /// Appends what PressErrors reports of the last of some frames of each room against its true normals,
    /// what measure_rest does, lag_mm, frame_cpu_ms and frame_ms, and level_mm, the level distance that was
    /// measured, at the room's median depth (0: every code is a level). `quick`: of two rooms.
    Result<void> measure(const FilterChoice& choice, bool quick, Figures& figures);
    /// Appends what the filters that the program chooses leave, and the best of all: every median, levels of
    /// a tenth to twice the least step that the sensor can tell, and averaging of no noise, its noise or more
    /// of it. force_angle_deg_chosen, _best of those that keep edges (keeps_edges), _best_of_all; times_best.
    Result<void> search(bool quick, Figures& figures);

private:
    struct Room {
        DepthMap truth;
        std::vector<DepthPlane> smooth;  ///< places
        std::vector<RawFrame> stored;
    };
    struct Moment {
        DepthMap truth;
        std::vector<DepthPlane> smooth;
    };

    std::vector<DepthPlane> smooth_places(const DepthMap& truth, int step) const;
    Result<void> make(bool quick);
    /// Of the filters' surface, against true normals.
    Result<PressErrors> pressed(const Scene& scene) const;
    Result<void> make_approach();
    Result<double> lag(const Scene& scene, const std::vector<SurfaceFrame>& at_rest) const;

    std::filesystem::path data_;
    SensorModel model_;
    double factor_;
    std::optional<Scene> scene_;  // once all is made
    std::vector<Room> rooms_;     // fingers rest in the first one, and there the camera goes ahead
    std::vector<DepthPlane> resting_places_;
    std::vector<Moment> approach_;
    std::vector<RawFrame> approach_stored_;
};

}  // namespace touchable
