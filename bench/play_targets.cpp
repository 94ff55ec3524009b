// SPDX-License-Identifier: Apache-2.0
#include "bench/targets.hpp"

namespace touchable {

const std::vector<Target>& play_targets() {
    using Sense = Limit::Sense;
    static const std::vector<std::string> demo{"window-globe-720x480-16"},
        turned{"window-globe-720x480-16-turned-7", "window-globe-720x480-16-turned-30",
               "window-globe-720x480-16-turned-70"},
        full_hd{"window-globe-1920x1080-16", "window-globe-1920x1080-16-turned-7",
                "window-globe-1920x1080-16-turned-30", "window-globe-1920x1080-16-turned-70"};
    static const std::vector<Target> targets{
        {"globe 720x480, 5 fingers: frames shown in time",
         demo,
         "frames_in_time_pct",
         {98, Sense::at_least, "%"}},
        {"  ticks late, p99", demo, "tick_late_us_p99", {200, Sense::below, "us"}},
        {"  first picture", demo, "first_picture_ms", {500, Sense::below, "ms"}},
        {"  input to picture, p99", demo, "input_ms_p99", {40, Sense::at_most, "ms"}},
        {"  turned by 7, 30, 70 degrees: in time", turned, "frames_in_time_pct", {98, Sense::at_least, "%"}},
        {"  turned: input to picture, p99", turned, "input_ms_p99", {40, Sense::at_most, "ms"}},
        {"  watched: processor time",
         {"window-globe-720x480-16-watched"},
         "cpu_pct",
         {50, Sense::at_most, "%"}},
        {"  paused: pictures/s",
         {"window-globe-720x480-16-paused"},
         "pictures_per_s",
         {0.5, Sense::below, ""}},
        {"globe 1920x1080, any angle: pictures/s", full_hd, "pictures_per_s", {30, Sense::at_least, ""}},
    };
    return targets;
}

}  // namespace touchable
