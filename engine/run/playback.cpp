// SPDX-License-Identifier: Apache-2.0
#include "engine/run/playback.hpp"

#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// ns; 126 years: limit of the clip's time, so that no sum overflows.
constexpr std::int64_t end_of_time = 4'000'000'000'000'000'000;

bool is_moment(std::int64_t ns) {
    return ns >= 0 && ns <= latest_moment_ns;
}

/// What is wrong with the command; nullptr: valid.
const char* fault_of(const PlaybackCommand& command) {
    using enum PlaybackVerb;
    if (command.verb > unloop) return "is no command that this program knows";
    if (command.verb == rate && (command.first < slowest_rate || command.first > fastest_rate))
        return "rate must be 0.001 to 8";
    if (command.verb == seek && !is_moment(command.first)) return "a moment to seek must be 0 to 1e6 s";
    if (command.verb == loop && !(is_moment(command.first) && is_moment(command.second)))
        return "a loop's ends must be 0 to 1e6 s";
    if (command.verb == loop && command.second - command.first < shortest_loop_ns)
        return "a loop must be 0.1 s or longer";
    return nullptr;
}

}  // namespace

PlaybackLog::PlaybackLog(std::vector<PlaybackCommand> commands, std::size_t more)
    : is_open_(more > 0), commands_(std::move(commands)), asked_(commands_.size()), taken_(commands_.size()) {
    commands_.resize(commands_.size() + more);
}

Result<void> PlaybackLog::ask(PlaybackVerb verb, std::int64_t first, std::int64_t second) {
    const std::size_t at = asked_.load(std::memory_order_relaxed);
    if (at == commands_.size())
        return usage_error("playback: " + std::to_string(at) +
                           " commands were given, which is all that a session takes; begin another");
    commands_[at] = {0, verb, first, second};
    asked_.store(at + 1, std::memory_order_release);
    return {};
}

void PlaybackLog::take(std::int64_t tick) {
    const std::size_t asked = asked_.load(std::memory_order_acquire);
    std::size_t at = taken_.load(std::memory_order_relaxed);
    if (at == asked) return;
    for (; at < asked; ++at) commands_[at].tick = tick;
    taken_.store(asked, std::memory_order_release);
}

std::optional<std::string> fault_after(std::int64_t tick_before, const PlaybackCommand& command) {
    if (command.tick < tick_before)
        return "tick " + std::to_string(command.tick) + " is before " + std::to_string(tick_before) +
               "; commands must be in the order of their ticks";
    const char* fault = fault_of(command);
    return fault ? std::optional<std::string>(fault) : std::nullopt;
}

Result<void> validate(const std::vector<PlaybackCommand>& commands) {
    std::int64_t before = 0;
    for (std::size_t k = 0; k < commands.size(); ++k) {
        if (const auto fault = fault_after(before, commands[k]))
            return input_error("playback command " + std::to_string(k + 1) + ": " + *fault);
        before = commands[k].tick;
    }
    return {};
}

PlaybackClock::PlaybackClock(const FrameRate& rate, std::shared_ptr<const PlaybackLog> log)
    : rate_(rate), log_(std::move(log)), known_(log_->size()) {}

MediaMoment PlaybackClock::at(std::int64_t tick) {
    known_ = log_->size();
    go_on_to(tick);
    MediaMoment moment = state_.moment;
    moment.time_ns = time_at(tick);
    return moment;
}

PlaybackState PlaybackClock::state_at(std::int64_t tick) {
    PlaybackState now;
    now.moment = at(tick);
    now.playing = state_.playing;
    now.rate = state_.ns_per_tick / 1000;
    now.loops = state_.loop_end != never;
    if (now.loops) now.loop_begin_ns = state_.loop_begin;
    if (now.loops) now.loop_end_ns = state_.loop_end;
    return now;
}

MediaMoment PlaybackClock::at_newest_command() {
    known_ = log_->size();
    if (known_ > 0) go_on_to((*log_)[known_ - 1].tick);
    return state_.moment;
}

std::optional<ComingEpoch> PlaybackClock::next_epoch() {
    const std::uint64_t epoch = state_.moment.epoch;
    std::int64_t left_ns = state_.moment.time_ns;
    while (state_.moment.epoch == epoch) {
        const std::int64_t tick = tick_of_next_turn();
        if (tick == never) return std::nullopt;
        left_ns = time_at(tick);
        turn();
    }
    return ComingEpoch{state_.moment.epoch, state_.moment.start_ns, left_ns};
}

bool PlaybackClock::plays_to_the_end() const {
    PlaybackClock last = *this;
    for (; last.applied_ < known_; ++last.applied_) last.apply((*log_)[last.applied_]);
    return last.state_.playing && last.state_.loop_end == never;
}

/// Time at a tick before the next turn.
std::int64_t PlaybackClock::time_at(std::int64_t tick) const {
    if (!state_.playing) return state_.moment.time_ns;
    const std::int64_t ticks = tick - state_.tick;
    const std::int64_t most = (end_of_time - state_.moment.time_ns) / state_.ns_per_tick;
    return state_.moment.time_ns + std::min(ticks, most) * state_.ns_per_tick;
}

std::int64_t PlaybackClock::tick_of_loops_end() const {
    if (!state_.playing || state_.loop_end == never) return never;
    const std::int64_t left = std::max<std::int64_t>(state_.loop_end - state_.moment.time_ns, 0);
    return state_.tick + (left + state_.ns_per_tick - 1) / state_.ns_per_tick;
}

/// Applies the next event, a command or the loop's end; at the same tick the command first.
void PlaybackClock::turn() {
    const std::int64_t tick = tick_of_next_turn();
    state_.moment.time_ns = time_at(tick);
    state_.tick = tick;
    if (applied_ < known_ && (*log_)[applied_].tick == tick) return apply((*log_)[applied_++]);
    // Carry the overshoot beyond the loop's end over, unless it exceeds a tick; then start at the loop's
    // beginning.
    const std::int64_t beyond = state_.moment.time_ns - state_.loop_end;
    begin_epoch(state_.loop_begin);
    if (beyond < state_.ns_per_tick) state_.moment.time_ns += beyond;
}

void PlaybackClock::apply(const PlaybackCommand& command) {
    switch (command.verb) {
        case PlaybackVerb::play:
            state_.playing = true;
            break;
        case PlaybackVerb::pause:
            state_.playing = false;
            break;
        case PlaybackVerb::rate:
            state_.ns_per_tick = 1000 * command.first;
            break;
        case PlaybackVerb::seek:
            begin_epoch(command.first);
            break;
        case PlaybackVerb::step:
            state_.moment.time_ns = rate_.time_ns(rate_.frame_at(state_.moment.time_ns) + 1);
            state_.playing = false;
            break;
        case PlaybackVerb::loop:
            state_.loop_begin = command.first;
            state_.loop_end = command.second;
            break;
        case PlaybackVerb::unloop:
            state_.loop_end = never;
            break;
    }
}

Result<void> PlaybackControl::play_or_pause() {
    const PlaybackState state = state_();
    if (!state.at_end) return ask(state.playing ? PlaybackVerb::pause : PlaybackVerb::play);
    seek_to(0);
    return ask(PlaybackVerb::play);
}

void PlaybackControl::seek_to(double seconds) {
    // A clip of unknown length may be sought to any moment.
    const std::int64_t last_ns = frames_ > 0 ? rate_.time_ns(frames_ - 1) : latest_moment_ns;
    wanted_ns_ = static_cast<std::int64_t>(std::clamp(seconds * 1e9, 0.0, static_cast<double>(last_ns)));
}

Result<void> PlaybackControl::step(double frames) {
    if (frames > 0) return state_().at_end ? Result<void>{} : ask(PlaybackVerb::step);
    const std::int64_t now = wanted_ns_.value_or(state_().moment.time_ns);
    wanted_ns_ = rate_.time_ns(std::max<std::int64_t>(0, rate_.frame_at(now) - 1));
    return ask(PlaybackVerb::pause);
}

Result<void> PlaybackControl::begin_anew(std::span<const PlaybackCommand> first, bool loops) {
    wanted_ns_.reset();
    TRY(ask(PlaybackVerb::rate, 1000));
    TRY(ask(PlaybackVerb::unloop));
    TRY(ask(PlaybackVerb::seek));
    const std::int64_t end_ns = rate_.time_ns(frames_);
    if (loops && end_ns >= shortest_loop_ns) TRY(ask(PlaybackVerb::loop, 0, end_ns));
    for (const PlaybackCommand& command : first) TRY(ask(command.verb, command.first, command.second));
    return ask(PlaybackVerb::play);
}

Result<void> PlaybackControl::toggle_loop() {
    if (state_().loops) return ask(PlaybackVerb::unloop);
    if (frames_ == 0) return usage_error("the clip does not say how long it is: there is no end to loop at");
    return ask(PlaybackVerb::loop, 0, rate_.time_ns(frames_));
}

Result<void> PlaybackControl::go_on(const FramePair* shown) {
    if (!wanted_ns_ || !shown || shown->epoch != state_().moment.epoch) return {};
    return ask(PlaybackVerb::seek, *std::exchange(wanted_ns_, std::nullopt));
}

PlaybackState until_end(PlaybackState state, const FrameRate& rate, std::int64_t end_ns) {
    if (end_ns <= 0 || state.loops) return state;
    const std::int64_t last_ns = rate.time_ns(rate.frame_at(end_ns) - 1);
    state.at_end = state.moment.time_ns >= last_ns;
    state.moment.time_ns = std::min(state.moment.time_ns, last_ns);
    return state;
}

}  // namespace touchable
