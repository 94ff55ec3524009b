#include <string>

#include "bench/capi/read_run.hpp"
#include "bench/capi/tick_run.hpp"
#include "bench/suite.hpp"

namespace touchable {

std::vector<BenchCase> capi_cases(bool quick) {
    std::vector<BenchCase> cases;
    for (const int fingers : {1, 5})
        cases.push_back({"tick-640x480-" + std::to_string(fingers) + "f", [=](Figures& figures) {
                             return measure_c_ticks(fingers, quick ? 15 : 60, figures);
                         }});
    for (const auto& [width, height] : {std::pair(640, 480), std::pair(1920, 1080)})
        cases.push_back(
            {"read-" + std::to_string(width) + "x" + std::to_string(height), [=](Figures& figures) {
                 return measure_c_reading(width, height, quick ? 15 : 45, quick ? 3 : 7, figures);
             }});
    return cases;
}

}  // namespace touchable
