#pragma once

#include <string>
#include <string_view>

#include "device/goal_watch.hpp"
#include "device/hand.hpp"
#include "player/run/recording.hpp"

namespace touchable {

/// `--hand rec:FILE[:depth=MM]`: the very goals of a recording, over whatever is touched now, in the scene
/// units and with the device's metres per scene unit of then. Two runs of it compare: with one filter and
/// another, one solver and another.
class RepeatingHand final : public Hand {
public:
    static bool is_meant(std::string_view hand) { return hand.starts_with("rec:"); }
    /// `hand` as typed. Refuses (ErrorKind::usage) unknown keys, and what `read_recording` refuses.
    static Result<std::unique_ptr<RepeatingHand>> read(const std::string& hand);

    int fingers() const override { return recording_.fingers; }
    /// The latest goals that had been recorded by then.
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override;
    std::optional<std::int64_t> ticks() const override;
    std::optional<std::string> file() const override { return file_; }
    std::vector<std::string> remarks() const override { return watch_.remarks(); }
    double metres_per_scene_unit() const { return metres_per_scene_unit_; }

private:
    RepeatingHand(std::string file, RecordedPart recording, double metres_per_scene_unit,
                  const GoalWatch& watch)
        : file_(std::move(file)),
          recording_(std::move(recording)),
          metres_per_scene_unit_(metres_per_scene_unit),
          watch_(watch) {}

    std::string file_;
    RecordedPart recording_;  // all parts as one
    double metres_per_scene_unit_;
    GoalWatch watch_;
    std::size_t at_ = 0;  // the recorded tick whose goals were given last
};

}  // namespace touchable
