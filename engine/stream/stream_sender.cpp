#include "engine/stream/stream_sender.hpp"

#include <algorithm>

#include "engine/base/try.hpp"

namespace touchable {

void StreamSender::end() {
    is_told_to_end_ = true;
    time_.end();
    clip_->interrupt();
}

Result<void> StreamSender::run() {
    auto sent = send_all();
    for (const StreamChannel& channel : channels_) channel.ring.end();
    const bool is_ended = is_told_to_end_ && !sent && sent.error().kind == ErrorKind::interrupted;
    return is_ended ? Result<void>{} : std::move(sent);
}

Result<void> StreamSender::send_all() {
    begin_ns_ = time_.now_ns() + (clip_->is_live() ? 0 : lead_ns);
    figures_.rounds = 1;
    if (clip_->is_live()) {
        const std::chrono::steady_clock::time_point zero{std::chrono::nanoseconds(begin_ns_)};
        if (auto begun = clip_->begin(zero); !begun) return begun;
    }
    while (!is_told_to_end_) {
        TRY_ASSIGN(const auto frame, next());
        if (!frame) {
            figures_.clip_ended = true;
            return {};
        }
        const Due when = due(*frame);
        if (settings_.longest_ns && when.time_ns >= *settings_.longest_ns) return {};
        TRY_ASSIGN(const auto sent, send(*frame, when));
        if (!sent) return {};
    }
    return {};
}

/// The next frame of the clip; after its last one the first again, where it is sent in a loop.
Result<std::optional<RawFrame>> StreamSender::next() {
    auto frame = clip_->next();
    if (!frame) return frame;
    if (!*frame && settings_.loop && !clip_->is_live() && frames_of_round_ > 0) {
        TRY(clip_->rewind());
        round_ns_ += clip_->scene().rate.time_ns(frames_of_round_);
        frames_of_round_ = 0;
        ++figures_.rounds;
        frame = clip_->next();
        if (!frame) return frame;
    }
    if (*frame) {
        ++frames_of_round_;
        (*frame)->epoch = static_cast<std::uint64_t>(figures_.rounds - 1);
    }
    return frame;
}

/// Of a rate that is even, rounds of a loop go on evenly, to the nanosecond.
StreamSender::Due StreamSender::due(const RawFrame& frame) const {
    const FrameRate& rate = clip_->scene().rate;
    const bool has_own_times = clip_->is_live() || rate.own_times;
    const std::int64_t time_ns = has_own_times ? round_ns_ + frame.time_ns : rate.time_ns(figures_.framesets);
    return {time_ns, begin_ns_ + time_ns};
}

/// The frame after this one may come as late as the rate says.
bool StreamSender::is_key(std::int64_t time_ns) {
    const std::int64_t period_ns = clip_->scene().rate.time_ns(1);
    const bool is_one = figures_.framesets == 0 || figures_.framesets - key_frame_ >= most_between_keys ||
                        time_ns - key_time_ns_ + period_ns > longest_between_keys_ns;
    if (is_one) {
        key_frame_ = figures_.framesets;
        key_time_ns_ = time_ns;
    }
    return is_one;
}

/// False: it was told to end before the frame's time came.
Result<bool> StreamSender::send(const RawFrame& frame, const Due& due) {
    const PictureLabel label{figures_.framesets, time_.utc_ns() + due.at_ns - time_.now_ns()};
    const bool key = is_key(due.time_ns);
    const bool is_ahead = !clip_->is_live() && settings_.is_paced;
    std::vector<StreamBlock> blocks;
    for (StreamChannel& channel : channels_) {
        TRY_ASSIGN(auto block, channel.muxer->add(frame, label, due.time_ns, key));
        if (is_ahead)
            blocks.push_back(std::move(block));
        else  // the next form may take its time
            give(channel, std::move(block));
    }
    if (is_ahead) {
        if (!time_.wait_until(due.at_ns)) return false;
        keep_pace(due);
        for (std::size_t k = 0; k < channels_.size(); ++k) give(channels_[k], std::move(blocks[k]));
    }
    ++figures_.framesets;
    figures_.keys += key ? 1 : 0;
    sent_ = figures_.framesets;
    return true;
}

void StreamSender::give(StreamChannel& channel, StreamBlock block) {
    if (figures_.framesets == 0) channel.ring.begin(channel.muxer->header(), channel.muxer->padding());
    figures_.bytes += std::ssize(block.bytes);
    channel.ring.add(std::move(block));
}

void StreamSender::keep_pace(const Due& due) {
    const std::int64_t late_ns = time_.now_ns() - due.at_ns;
    figures_.latest_ns = std::max(figures_.latest_ns, late_ns);
    if (late_ns <= longest_hurry_ns) return;
    begin_ns_ += late_ns;
    figures_.held_up_ns += late_ns;
}

}  // namespace touchable
