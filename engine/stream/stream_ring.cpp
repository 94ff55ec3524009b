#include "engine/stream/stream_ring.hpp"

#include <utility>

namespace touchable {

void StreamRing::changed() {
    there_is_more_.notify_all();
    for (const auto& wake : watchers_) wake();
}

void StreamRing::begin(std::span<const std::uint8_t> header, std::span<const std::uint8_t> padding) {
    auto bytes = std::make_shared<const std::vector<std::uint8_t>>(header.begin(), header.end());
    {
        const std::lock_guard lock(mutex_);
        header_ = std::move(bytes);
        padding_.assign(padding.begin(), padding.end());
    }
    changed();
}

void StreamRing::add(StreamBlock block) {
    auto shared = std::make_shared<const StreamBlock>(std::move(block));
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

void StreamRing::end() {
    {
        const std::lock_guard lock(mutex_);
        is_over_ = true;
    }
    changed();
}

StreamRing::Cursor StreamRing::join() const {
    const std::lock_guard lock(mutex_);
    Cursor cursor;
    cursor.next_ = newest_key_;
    return cursor;
}

StreamRing::Bytes StreamRing::header() const {
    const std::lock_guard lock(mutex_);
    return header_;
}

std::vector<std::uint8_t> StreamRing::padding() const {
    const std::lock_guard lock(mutex_);
    return padding_;
}

/// What is not kept any more is out of bounds.
StreamRing::Block StreamRing::take(Cursor& cursor) const {
    if (cursor.next_ < first_) {
        cursor.dropped_ += newest_key_ - cursor.next_;
        cursor.next_ = newest_key_;
    }
    if (cursor.next_ >= end_of_kept()) return nullptr;
    return kept_[static_cast<std::size_t>(cursor.next_++ - first_)].block;
}

StreamRing::Block StreamRing::next(Cursor& cursor) const {
    const std::lock_guard lock(mutex_);
    return take(cursor);
}

StreamRing::Block StreamRing::wait_next(Cursor& cursor, std::chrono::milliseconds longest) const {
    std::unique_lock lock(mutex_);
    there_is_more_.wait_for(lock, longest, [&] { return is_over_ || cursor.next_ < end_of_kept(); });
    return take(cursor);
}

bool StreamRing::has_next(const Cursor& cursor) const {
    const std::lock_guard lock(mutex_);
    return cursor.next_ < end_of_kept();
}

bool StreamRing::go_to_newest_key(Cursor& cursor) const {
    const std::lock_guard lock(mutex_);
    if (cursor.next_ >= newest_key_) return false;
    cursor.dropped_ += newest_key_ - cursor.next_;
    cursor.next_ = newest_key_;
    return true;
}

bool StreamRing::is_over(const Cursor& cursor) const {
    const std::lock_guard lock(mutex_);
    return is_over_ && cursor.next_ >= end_of_kept();
}

bool StreamRing::is_ended() const {
    const std::lock_guard lock(mutex_);
    return is_over_;
}

}  // namespace touchable
