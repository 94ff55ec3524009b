// SPDX-License-Identifier: Apache-2.0
#include "engine/stream/sending.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {
namespace {

constexpr std::size_t most_remembered = 256;  // listeners that left
constexpr std::int64_t longest_between_keys_ns = 500'000'000, most_between_keys = 15;
/// A clip that is later than this goes on from where it is, instead of catching up.
constexpr std::int64_t longest_hurry_ns = 500'000'000;

}  // namespace

// --- StreamRing

void StreamRing::begin(std::span<const std::uint8_t> header, std::span<const std::uint8_t> padding) {
    auto bytes = std::make_shared<const std::vector<std::uint8_t>>(header.begin(), header.end());
    {
        const std::lock_guard lock(mutex_);
        header_ = std::move(bytes);
        padding_.assign(padding.begin(), padding.end());
    }
    changed();
}

void StreamRing::add(StreamMuxer::Block block) {
    auto shared = std::make_shared<const StreamMuxer::Block>(std::move(block));
    {
        const std::lock_guard lock(mutex_);
        if (shared->is_key) newest_key_ = end_of_kept();
        const std::size_t before = bytes_;
        bytes_ += shared->bytes.size();
        kept_.push_back({std::move(shared), before});
        const auto is_too_old = [this] {
            return std::ssize(kept_) > bounds_.framesets ||
                   bytes_ - kept_.front().bytes_before > bounds_.bytes;
        };
        for (; first_ < newest_key_ && is_too_old(); ++first_) kept_.pop_front();
    }
    changed();
}

// --- StreamAudience

void StreamAudience::came(const std::string& name) {
    const std::lock_guard lock(mutex_);
    ++all_;
    say_(name + " listens; " + counted(there_ + 1, "listener"));
    ++there_;
}

void StreamAudience::went(Listener figures) {
    const std::lock_guard lock(mutex_);
    say_(figures.name + (figures.end.empty() ? " has all of it: " : " " + figures.end + ": ") +
         std::to_string(figures.sent) + " framesets sent, " +
         (figures.without_colour > 0 ? std::to_string(figures.without_colour) + " of them without colour, "
                                     : "") +
         std::to_string(figures.dropped) + " left out; " + counted(there_ - 1, "listener"));
    if (gone_.size() == most_remembered) gone_.erase(gone_.begin());
    gone_.push_back(std::move(figures));
    --there_;
}

// --- StreamSender::SystemTime

std::int64_t StreamSender::SystemTime::now_ns() {
    return steady_now_ns();
}

// --- StreamSender

Result<void> StreamSender::send_all() {
    begin_ns_ = time_.now_ns() + (clip_->is_live() ? 0 : lead_ns);
    figures_.rounds = 1;
    if (clip_->is_live()) {
        const std::chrono::steady_clock::time_point zero{std::chrono::nanoseconds(begin_ns_)};
        TRY(clip_->begin(zero));
    }
    while (!stop_requested()) {
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

/// The next frame of the clip; in a loop the first one follows the last.
Result<std::optional<RawFrame>> StreamSender::next() {
    TRY_ASSIGN(auto frame, clip_->next());
    if (!frame && settings_.loop && !clip_->is_live() && frames_of_round_ > 0) {
        TRY(clip_->rewind());
        round_ns_ += clip_->scene().rate.time_ns(frames_of_round_);
        frames_of_round_ = 0;
        ++figures_.rounds;
        TRY_ASSIGN(frame, clip_->next());
    }
    if (frame) {
        ++frames_of_round_;
        frame->epoch = static_cast<std::uint64_t>(figures_.rounds - 1);
    }
    return frame;
}

/// Whether this frame is a key, as the next one may come as late as the rate says.
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

/// False: a stop was requested before the frame's time came.
Result<bool> StreamSender::send(const RawFrame& frame, const Due& due) {
    const PictureLabel label{figures_.framesets, time_.utc_ns() + due.at_ns - time_.now_ns()};
    const bool key = is_key(due.time_ns);
    const bool is_ahead = !clip_->is_live() && settings_.is_paced;
    std::vector<StreamMuxer::Block> blocks;
    for (Channel& channel : channels_) {
        TRY_ASSIGN(auto block, channel.muxer->add(frame, label, due.time_ns, key));
        if (is_ahead)
            blocks.push_back(std::move(block));
        else  // encoding the next form may take a while
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

void StreamSender::keep_pace(const Due& due) {
    const std::int64_t late_ns = time_.now_ns() - due.at_ns;
    figures_.latest_ns = std::max(figures_.latest_ns, late_ns);
    if (late_ns <= longest_hurry_ns) return;
    begin_ns_ += late_ns;
    figures_.held_up_ns += late_ns;
}

}  // namespace touchable
