#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "device/goal_watch.hpp"
#include "device/hand.hpp"

namespace touchable {

/// Fingers that repeat a recorded motion, one copy each; after its end they rest at the last position.
class RecordedHand final : public Hand {
public:
    /// `positions`: of the hand's centre, one per tick, world, scene units; `offsets`: of the fingers from
    /// it; `file`: where the motion is from.
    RecordedHand(std::string file, std::vector<glm::dvec3> positions, std::vector<glm::dvec3> offsets,
                 const GoalWatch& watch)
        : file_(std::move(file)),
          positions_(std::move(positions)),
          offsets_(std::move(offsets)),
          watch_(watch) {}

    int fingers() const override { return static_cast<int>(offsets_.size()); }
    void goals_at(std::int64_t tick, const SurfaceProbe& probe, std::span<glm::dvec3> goals) override;
    std::optional<std::int64_t> ticks() const override {
        return static_cast<std::int64_t>(positions_.size());
    }
    std::optional<std::string> file() const override { return file_; }
    std::vector<std::string> remarks() const override { return watch_.remarks(); }

private:
    std::string file_;
    std::vector<glm::dvec3> positions_;
    std::vector<glm::dvec3> offsets_;
    GoalWatch watch_;
};

/// Makes a hand from "FILE[:key=value,...]" (the keys are in docs/hands.md). A file's name may hold ':': the
/// options begin after the last one that is followed by a '='. Refuses impossible options (ErrorKind::usage)
/// and files that cannot be used (ErrorKind::input, with line and column).
Result<std::unique_ptr<Hand>> make_recorded_hand(std::string_view description, int fingers,
                                                 const Workspace& workspace, const SurfaceProbe& probe);

}  // namespace touchable
