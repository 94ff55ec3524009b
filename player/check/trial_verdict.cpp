#include "player/check/trial_verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace touchable {
namespace {

constexpr double ms_per_second = 1000, us_per_ms = 1000;
/// Of the machine and of each deadline: other programs run too, and no two frames take the same time.
constexpr double usable_share = 0.9;

std::string number(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string figure(double value) {
    return number(value < 100 ? "%.3g" : "%.0f", value);
}

}  // namespace

std::string TouchDemand::in_words() const {
    return std::to_string(width) + "x" + std::to_string(height) + " at " + std::to_string(rate) +
           " frames/s with " + std::to_string(fingers) + (fingers == 1 ? " finger" : " fingers");
}

double TrialFigures::cpu_ms_per_second(const TouchDemand& demand) const {
    return demand.rate * frame_cpu_ms + ms_per_second * tick_cpu_us / us_per_ms;
}

TrialVerdict judge(const TouchDemand& demand, const TrialFigures& figures, int cores) {
    const double frame_ms = ms_per_second / demand.rate;
    const double usable_ms = usable_share * cores * ms_per_second;
    const double left_ms = usable_ms - figures.tick_cpu_us;  // us of a tick are ms of a second
    struct Need {
        const char* what;
        double takes, may;
        const char* unit;
    };
    const Need needs[] = {
        {"a tick", figures.tick_us.p99, usable_share * us_per_ms, "us"},
        {"decoding a frame", figures.decode_ms.mean, usable_share * frame_ms, "ms"},
        {"building a frame", figures.build_ms.mean, usable_share * frame_ms, "ms"},
        {"all of it", figures.cpu_ms_per_second(demand), usable_ms, "ms of CPU time a second"}};
    const Need* tightest =
        std::max_element(std::begin(needs), std::end(needs),
                         [](const Need& a, const Need& b) { return a.takes / a.may < b.takes / b.may; });
    TrialVerdict verdict;
    verdict.can = tightest->takes <= tightest->may;
    verdict.why = std::string(tightest->what) + " takes " + figure(tightest->takes) + " of the " +
                  figure(tightest->may) + " " + tightest->unit + " it may";
    const double slower = std::max(figures.decode_ms.mean, figures.build_ms.mean);
    if (needs[0].takes <= needs[0].may && left_ms > 0)
        verdict.most_rate =
            std::floor(std::min(usable_share * ms_per_second / slower, left_ms / figures.frame_cpu_ms));
    return verdict;
}

nlohmann::ordered_json trial_json(const TouchDemand& demand, const TrialFigures& figures,
                                  const TrialVerdict& verdict, int cores) {
    return {{"width", demand.width},
            {"height", demand.height},
            {"fingers", demand.fingers},
            {"rate", demand.rate},
            {"can", verdict.can},
            {"why", verdict.why},
            {"most_rate", verdict.most_rate},
            {"builder", figures.builder},
            {"frames", figures.frames},
            {"ticks", figures.ticks},
            {"decode_ms", to_json(figures.decode_ms)},
            {"build_ms", to_json(figures.build_ms)},
            {"tick_us", to_json(figures.tick_us)},
            {"cpu_ms_per_second", figures.cpu_ms_per_second(demand)},
            {"cores", cores}};
}

std::string trial_to_text(const TouchDemand& demand, const TrialFigures& figures, const TrialVerdict& verdict,
                          int cores) {
    const auto spread = [](const Spread& s, const char* unit) {
        return figure(s.mean) + " " + unit + " at the mean, " + figure(s.p99) + " p99, " + figure(s.max) +
               " at worst";
    };
    std::string text = (verdict.can ? "yes: " : "no: ") + demand.in_words() +
                       (verdict.can ? "; " : " is too much here; ") + verdict.why + "\n";
    text += "decode    " + spread(figures.decode_ms, "ms") + " of " + std::to_string(figures.frames) +
            " frames (generated: depth of 16 bits and colour)\n";
    text += "build     " + spread(figures.build_ms, "ms") + "; " + figures.builder + " builder, median 3x3\n";
    text += "tick      " + spread(figures.tick_us, "us") + " of " + std::to_string(figures.ticks) +
            ", all fingers; the next one is due after 1000\n";
    text += "cpu time  " + number("%.0f ms a second, of ", figures.cpu_ms_per_second(demand)) +
            std::to_string(cores) + (cores == 1 ? " core\n" : " cores\n");
    if (figures.is_crowded())
        text += "note      other programs kept the cores busy; ask again when they rest\n";
    text += "at most   " + number("%.0f frames/s", verdict.most_rate) + " with as many fingers\n";
    return text;
}

}  // namespace touchable
