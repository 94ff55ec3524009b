#include "player/commands/touch_trial.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <utility>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr int trial_ticks = 1000;
constexpr double microseconds_per_ms = 1000;

/// Fewer where they are large: some 6 of 1920x1080.
int trial_frames(const TouchDemand& demand) {
    const double pixels = static_cast<double>(demand.width) * demand.height;
    return static_cast<int>(std::clamp(12e6 / pixels, 4.0, 30.0));
}

/// A folder of temporary files, gone with this.
class ScratchFolder {
public:
    static Result<ScratchFolder> create() {
        std::error_code fault;
        const fs::path parent = fs::temp_directory_path(fault);
        std::string name = (parent / "touchable-check-XXXXXX").string();
        if (fault || !mkdtemp(name.data()))
            return input_error("no folder of temporary files can be made in '" + parent.string() +
                               "'; TMPDIR may name another place");
        return ScratchFolder(name);
    }
    ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
    ScratchFolder& operator=(ScratchFolder&&) = delete;
    ~ScratchFolder() {
        std::error_code ignored;
        if (!path_.empty()) fs::remove_all(path_, ignored);
    }
    const fs::path& path() const { return path_; }

private:
    explicit ScratchFolder(fs::path path) : path_(std::move(path)) {}
    fs::path path_;
};

double cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

/// A surface that moves in every frame. Colour is no part of touch.
Result<void> make_clip(const TouchDemand& demand, const fs::path& file, int frames) {
    SceneOptions options;
    options.width = demand.width;
    options.height = demand.height;
    TRY_ASSIGN(const auto source, make_scene("moving", options));
    TRY_ASSIGN(auto writer, create_clip(file, source->scene()));
    for (int n = 0; n < frames; ++n) {
        if (interrupted()) return interrupted_error();
        if (auto written = writer->write(source->frame(n)); !written.ok()) return written;
    }
    return writer->finish();
}

/// Without those that were there before, in which threads are started and memory is fetched.
Result<void> measure_frames(TouchSetup& setup, int frames, TrialFigures& figures) {
    SurfaceFeed& feed = *setup.feed;
    const auto before = static_cast<int>(feed.frames());
    feed.forget_times();
    const double cpu_before = cpu_ms();
    for (int n = before; n < frames; ++n) {
        if (interrupted()) return interrupted_error();
        TRY(feed.pair_at(setup.scene.rate.time_ns(n - 1)));
    }
    figures.frames = static_cast<int>(feed.frames()) - before;
    figures.frame_cpu_ms = (cpu_ms() - cpu_before) / figures.frames;
    figures.decode_ms = feed.read_ms().spread();
    figures.build_ms = feed.build_ms().spread();
    figures.builder = feed.builder_name();
    return {};
}

/// Between the last two frames, where nothing more is decoded.
Result<void> measure_ticks(TouchSetup& setup, int frames, TrialFigures& figures) {
    setup.settings.ticks = trial_ticks;
    setup.settings.pair_of_tick = [&setup, frames](std::int64_t tick) {
        return setup.feed->pair_of(frames - 2, frames - 1, static_cast<double>(tick) / trial_ticks);
    };
    TouchFigures taken;
    TouchSink* const sinks[] = {&taken};
    const double cpu_before = cpu_ms();
    auto ran = TouchSession(setup.scene, *setup.feed, *setup.hand, *setup.solver, setup.settings).run(sinks);
    if (!ran.ok()) return ran;
    figures.ticks = static_cast<int>(taken.ticks());
    figures.tick_cpu_us = microseconds_per_ms * (cpu_ms() - cpu_before) / figures.ticks;
    figures.tick_us = taken.tick_us();
    return {};
}

}  // namespace

Result<TrialFigures> try_touch(const TouchDemand& demand) {
    TRY_ASSIGN(const auto folder, ScratchFolder::create());
    SessionOptions options;
    options.clip.file = folder.path() / "trial.mkv";
    options.fingers = demand.fingers;
    options.clip.filters = FiltersChoice{};  // nothing is measured, so that every frame is decoded here
    options.clip.median = 3;
    options.live = true;
    const int frames = 2 + trial_frames(demand);  // the first two are read to find out where the surface is
    TRY(make_clip(demand, options.clip.file, frames));
    TRY_ASSIGN(auto setup, setup_from_options(options));
    TrialFigures figures;
    TRY(measure_frames(*setup, frames, figures));
    TRY(measure_ticks(*setup, frames, figures));
    return figures;
}

namespace {

constexpr double ms_per_second = 1000, us_per_ms = 1000;
/// Of the machine and of each deadline: other programs run too, and no two frames take the same time.
constexpr double usable_share = 0.9;

std::string figure(double value) {
    return formatted(value < 100 ? "%.3g" : "%.0f", value);
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
    text += "cpu time  " + formatted("%.0f ms a second, of ", figures.cpu_ms_per_second(demand)) +
            std::to_string(cores) + (cores == 1 ? " core\n" : " cores\n");
    if (figures.is_crowded())
        text += "note      other programs kept the cores busy; ask again when they rest\n";
    text += "at most   " + formatted("%.0f frames/s", verdict.most_rate) + " with as many fingers\n";
    return text;
}

}  // namespace touchable
