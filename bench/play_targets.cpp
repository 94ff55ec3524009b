#include "bench/targets.hpp"

namespace touchable {

const std::vector<Target>& play_targets() {
    using Sense = Limit::Sense;
    static const std::vector<std::string> demo{"window-globe-720x480-16"},
        full_hd{"window-globe-1920x1080-16"};
    static const std::vector<Target> targets{
        {"globe 720x480, 5 fingers: frames shown in time",
         demo,
         "frames_in_time_pct",
         {98, Sense::at_least, "%"}},
        {"  ticks late, p99", demo, "tick_late_us_p99", {200, Sense::below, "us"}},
        {"  first picture", demo, "first_picture_ms", {500, Sense::below, "ms"}},
        {"  input to picture, p99", demo, "input_ms_p99", {0, Sense::none, "ms"}},
        {"globe 1920x1080: pictures/s", full_hd, "pictures_per_s", {0, Sense::none, ""}},
    };
    return targets;
}

}  // namespace touchable
