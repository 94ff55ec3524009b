#include "player/window/playback_control.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace touchable {

Result<void> PlaybackControl::play_or_pause() {
    const PlaybackState state = clip_->session().playback();
    if (!state.at_end) return ask(state.playing ? PlaybackVerb::pause : PlaybackVerb::play);
    seek_to(0);
    return ask(PlaybackVerb::play);
}

void PlaybackControl::seek_to(double seconds) {
    // Of a clip whose length nobody knows yet, any moment.
    const std::int64_t last_ns =
        clip_->frames() > 0 ? clip_->scene().rate.time_ns(clip_->frames() - 1) : latest_moment_ns;
    wanted_ns_ = static_cast<std::int64_t>(std::clamp(seconds * 1e9, 0.0, static_cast<double>(last_ns)));
}

void PlaybackControl::seek_by(double seconds) {
    const std::int64_t from = wanted_ns_.value_or(clip_->session().playback().moment.time_ns);
    seek_to(static_cast<double>(from) * 1e-9 + seconds);
}

Result<void> PlaybackControl::step(double frames) {
    if (frames > 0) return clip_->session().playback().at_end ? Result<void>{} : ask(PlaybackVerb::step);
    const FrameRate& rate = clip_->scene().rate;
    const std::int64_t now = wanted_ns_.value_or(clip_->session().playback().moment.time_ns);
    wanted_ns_ = rate.time_ns(std::max<std::int64_t>(0, rate.frame_at(now) - 1));
    return ask(PlaybackVerb::pause);
}

Result<void> PlaybackControl::set_speed(double times) {
    return ask(PlaybackVerb::rate, std::lround(std::clamp(times, slowest, fastest) * 1000));
}

Result<void> PlaybackControl::change_speed(double factor) {
    return set_speed(factor * static_cast<double>(clip_->session().playback().rate) / 1000);
}

Result<void> PlaybackControl::begin_anew(std::span<const PlaybackCommand> first, bool loops) {
    wanted_ns_.reset();
    std::vector<PlaybackCommand> commands{
        {0, PlaybackVerb::rate, 1000, 0}, {0, PlaybackVerb::unloop, 0, 0}, {0, PlaybackVerb::seek, 0, 0}};
    const auto end_ns = static_cast<std::int64_t>(clip_->seconds() * 1e9);
    if (loops && end_ns >= shortest_loop_ns) commands.push_back({0, PlaybackVerb::loop, 0, end_ns});
    commands.insert(commands.end(), first.begin(), first.end());
    commands.push_back({0, PlaybackVerb::play, 0, 0});
    for (const PlaybackCommand& command : commands)
        if (auto asked = ask(command.verb, command.first, command.second); !asked.ok()) return asked;
    return {};
}

Result<void> PlaybackControl::toggle_loop() {
    if (clip_->session().playback().loops) return ask(PlaybackVerb::unloop);
    if (clip_->frames() == 0)
        return usage_error("the clip does not say how long it is: there is no end to loop at");
    return ask(PlaybackVerb::loop, 0, static_cast<std::int64_t>(clip_->seconds() * 1e9));
}

Result<void> PlaybackControl::go_on(const WatchedMoment* moment) {
    if (!wanted_ns_ || !moment || moment->held.pair.epoch != clip_->session().playback().moment.epoch)
        return {};
    return ask(PlaybackVerb::seek, *std::exchange(wanted_ns_, std::nullopt));
}

}  // namespace touchable
