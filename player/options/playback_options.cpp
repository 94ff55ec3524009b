#include "player/options/playback_options.hpp"

#include <cmath>

#include "player/options/file_option.hpp"
#include "player/session/playback_script.hpp"

namespace touchable {

namespace {

std::int64_t nanoseconds(double seconds) {
    return std::llround(seconds * 1e9);
}

}  // namespace

std::vector<CLI::Option*> add_playback_options(CLI::App& sub, PlaybackTyped& typed) {
    const CLI::Range seconds(0.0, 1e6);
    return {
        sub.add_option("--start", typed.start, "seconds: the moment of the clip to begin with")
            ->check(seconds),
        sub.add_option("--rate", typed.rate,
                       "how fast the clip is played, 0.001 to 8; 0.5: in slow motion. Fingers and forces "
                       "keep their own time")
            ->check(CLI::Range(slowest_rate * 1e-3, fastest_rate * 1e-3)),
        sub.add_option("--loop", typed.loop, "two times in seconds: play the clip between them, and again")
            ->expected(2)
            ->check(seconds),
        add_file_option(sub, "--play", typed.script,
                        "a file of commands to the clip's clock at their times: play, pause, rate, seek, "
                        "step, loop (docs/playback.md)")};
}

Result<std::vector<PlaybackCommand>> read_playback(const PlaybackTyped& typed) {
    std::vector<PlaybackCommand> commands;
    for (const double number : {typed.start.value_or(0), typed.rate.value_or(1)})
        if (std::isnan(number)) return usage_error("--start and --rate must be numbers");
    for (const double number : typed.loop)
        if (std::isnan(number)) return usage_error("--loop must be two numbers");
    if (typed.rate) commands.push_back({0, PlaybackVerb::rate, std::llround(*typed.rate * 1000), 0});
    const double start = typed.start.value_or(typed.loop.empty() ? 0 : typed.loop[0]);
    if (start > 0) commands.push_back({0, PlaybackVerb::seek, nanoseconds(start), 0});
    if (!typed.loop.empty()) {
        if (nanoseconds(typed.loop[1]) - nanoseconds(typed.loop[0]) < shortest_loop_ns)
            return usage_error("--loop must end 0.1 s or more after it begins");
        commands.push_back({0, PlaybackVerb::loop, nanoseconds(typed.loop[0]), nanoseconds(typed.loop[1])});
    }
    if (!typed.script) return commands;
    auto script = read_playback(*typed.script);
    if (!script.ok()) return script.error();
    commands.insert(commands.end(), script->begin(), script->end());
    return commands;
}

}  // namespace touchable
