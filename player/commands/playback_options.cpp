#include "player/commands/playback_options.hpp"

#include <cmath>

#include "engine/base/try.hpp"
#include "player/commands/file_option.hpp"
#include "player/commands/number_option.hpp"
#include "player/session/playback_script.hpp"

namespace touchable {

namespace {

constexpr double longest_seconds = 1e6;

std::int64_t nanoseconds(double seconds) {
    return std::llround(seconds * 1e9);
}

}  // namespace

std::vector<CLI::Option*> add_playback_options(CLI::App& sub, PlaybackTyped& typed) {
    return {
        add_number_option(sub, "--start", typed.start, "seconds: the moment of the clip to begin with", 0,
                          longest_seconds),
        add_number_option(sub, "--rate", typed.rate,
                          "how fast the clip is played, 0.001 to 8; 0.5: in slow motion. Fingers and forces "
                          "keep their own time",
                          slowest_rate * 1e-3, fastest_rate * 1e-3),
        add_number_option(sub, "--loop", typed.loop,
                          "two times in seconds: play the clip between them, and again", 0, longest_seconds)
            ->expected(2),
        add_file_option(sub, "--play", typed.script,
                        "a file of commands to the clip's clock at their times: play, pause, rate, seek, "
                        "step, loop (docs/playback.md)")};
}

Result<std::vector<PlaybackCommand>> read_playback(const PlaybackTyped& typed) {
    std::vector<PlaybackCommand> commands;
    if (typed.rate) commands.push_back({0, PlaybackVerb::rate, std::llround(*typed.rate * 1000), 0});
    const double start = typed.start.value_or(typed.loop.empty() ? 0 : typed.loop[0]);
    if (start > 0) commands.push_back({0, PlaybackVerb::seek, nanoseconds(start), 0});
    if (!typed.loop.empty()) {
        if (nanoseconds(typed.loop[1]) - nanoseconds(typed.loop[0]) < shortest_loop_ns)
            return usage_error("--loop must end 0.1 s or more after it begins");
        commands.push_back({0, PlaybackVerb::loop, nanoseconds(typed.loop[0]), nanoseconds(typed.loop[1])});
    }
    if (!typed.script) return commands;
    TRY_ASSIGN(auto script, read_playback(*typed.script));
    commands.insert(commands.end(), script.begin(), script.end());
    return commands;
}

}  // namespace touchable
