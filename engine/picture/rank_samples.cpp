// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/picture/image.hpp"

namespace touchable {
namespace {

using enum RankMode;

constexpr std::size_t possible_values = 65536;

/// 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
std::uint16_t folded(int difference) {
    const bool negative = (difference & 0x8000) != 0;
    return static_cast<std::uint16_t>(difference << 1 ^ (negative ? 0xFFFF : 0));
}

std::uint32_t unfolded(std::uint32_t code) {
    return code >> 1 ^ (0U - (code & 1));  // its lower 16 bits count
}

/// Numbers of two bytes as they are stored: all low bytes, then all high ones.
struct SplitBytes {
    std::uint8_t *low, *high;
    void put(std::size_t at, std::uint16_t number) const {
        low[at] = static_cast<std::uint8_t>(number);
        high[at] = static_cast<std::uint8_t>(number >> 8);
    }
};

struct SplitNumbers {
    const std::uint8_t *low, *high;
    std::uint32_t operator[](std::size_t at) const {
        return low[at] | static_cast<std::uint32_t>(high[at]) << 8;
    }
};

/// Stores how much each value exceeds the value before plus 1.
void put_distinct(const std::vector<std::uint16_t>& values, SplitBytes to) {
    int next = 0;
    for (std::size_t n = 0; n < values.size(); ++n) {
        to.put(n, static_cast<std::uint16_t>(values[n] - next));
        next = values[n] + 1;
    }
}

/// False if a value exceeds the largest sample. Values cannot be out of order.
bool take_distinct(SplitNumbers from, std::size_t count, std::uint16_t* values) {
    std::uint32_t next = 0;
    for (std::size_t n = 0; n < count; ++n, ++next) {
        next += from[n];
        if (next >= possible_values) return false;
        values[n] = static_cast<std::uint16_t>(next);
    }
    return true;
}

void put_codes(const std::vector<std::uint16_t>& values, int width, bool by_left, SplitBytes to) {
    const auto row = static_cast<std::size_t>(width);
    const std::vector<std::uint16_t> nothing(row);
    for (std::size_t begin = 0; begin < values.size(); begin += row) {
        const std::uint16_t* const at = values.data() + begin;
        const std::uint16_t* const above = begin > 0 ? at - row : nothing.data();
        to.put(begin, folded(at[0] - above[0]));
        if (by_left)
            for (std::size_t x = 1; x < row; ++x) to.put(begin + x, folded(at[x] - at[x - 1]));
        else
            for (std::size_t x = 1; x < row; ++x)
                to.put(begin + x, folded(at[x] - above[x] - at[x - 1] + above[x - 1]));
    }
}

void take_codes(SplitNumbers from, int width, int height, bool by_left, std::uint16_t* values,
                std::ptrdiff_t stride) {
    const auto row = static_cast<std::size_t>(width);
    const std::vector<std::uint16_t> nothing(row);
    const std::uint16_t* above = nothing.data();
    for (int y = 0; y < height; ++y, from.low += row, from.high += row, above = values, values += stride) {
        std::uint32_t left = by_left ? above[0] : 0;  // by gradient: left less above left
        for (std::size_t x = 0; x < row; ++x) {
            left += unfolded(from[x]);
            values[x] = static_cast<std::uint16_t>(by_left ? left : left + above[x]);
        }
    }
}

/// Turns ranks into samples. False if a rank is beyond the distinct values.
bool look_up(const std::vector<std::uint16_t>& distinct, int width, int height, std::uint16_t* samples,
             std::ptrdiff_t stride) {
    for (int y = 0; y < height; ++y, samples += stride) {
        std::uint16_t largest = 0;
        for (int x = 0; x < width; ++x) largest = std::max(largest, samples[x]);
        if (largest >= distinct.size()) return false;
        for (int x = 0; x < width; ++x) samples[x] = distinct[samples[x]];
    }
    return true;
}

}  // namespace

std::optional<RankHead> rank_head(std::span<const std::uint8_t> packet, std::size_t samples) {
    if (packet.empty() || packet[0] > static_cast<std::uint8_t>(ranks_by_gradient)) return std::nullopt;
    RankHead head{static_cast<RankMode>(packet[0]), 0, 1};
    if (head.mode != samples_by_gradient) {
        if (packet.size() < 3) return std::nullopt;
        head.distinct = 1U + packet[1] + (std::size_t{packet[2]} << 8);
        head.bytes = 3;
    }
    return head.distinct <= samples ? std::optional(head) : std::nullopt;
}

bool take_rank_content(const RankHead& head, std::span<const std::uint8_t> content, int width, int height,
                       std::uint16_t* samples, std::ptrdiff_t stride) {
    const std::size_t count = pixel_count(width, height);
    if (content.size() != head.content(count)) return false;
    std::vector<std::uint16_t> distinct(head.distinct);
    const std::uint8_t *const dictionary = content.data(), *const codes = dictionary + 2 * head.distinct;
    if (!take_distinct({dictionary, dictionary + head.distinct}, head.distinct, distinct.data()))
        return false;
    take_codes({codes, codes + count}, width, height, head.mode == ranks_by_left, samples, stride);
    return head.mode == samples_by_gradient || look_up(distinct, width, height, samples, stride);
}

bool take_rank_plane(const RankHead& head, std::span<const std::uint8_t> content, const PlaneView& form,
                     std::vector<std::uint8_t>& samples) {
    const int rows = form.height * form.channels;
    std::vector<std::uint16_t> values(pixel_count(form.width, rows));
    if (!take_rank_content(head, content, form.width, rows, values.data(), form.width)) return false;
    samples.resize(form.bytes());
    const auto bytes = static_cast<std::size_t>(form.bytes_per_sample);
    const std::size_t stride = pixel_count(form.channels, form.bytes_per_sample);
    const std::uint16_t* value = values.data();
    for (std::size_t first = 0; first < stride; first += bytes)
        for (std::size_t at = first; at < samples.size(); at += stride, ++value) {
            samples[at] = static_cast<std::uint8_t>(*value);
            if (bytes == 2) std::memcpy(&samples[at], value, 2);
        }
    return true;
}

void RankEncoder::take_samples(const PlaneView& plane) {
    width_ = plane.width;
    samples_.resize(pixel_count(plane.width, plane.height));
    plane.copy_rows(reinterpret_cast<std::uint8_t*>(samples_.data()), plane.row_bytes());
    distinct_.clear();
}

void RankEncoder::find_ranks() {
    rank_of_.assign(possible_values, 0);
    for (const std::uint16_t sample : samples_) rank_of_[sample] = 1;  // the value occurs
    for (std::size_t value = 0; value < possible_values; ++value) {
        if (rank_of_[value] == 0) continue;
        rank_of_[value] = static_cast<std::uint16_t>(distinct_.size());
        distinct_.push_back(static_cast<std::uint16_t>(value));
    }
    ranks_.resize(samples_.size());
    std::transform(samples_.begin(), samples_.end(), ranks_.begin(),
                   [this](std::uint16_t sample) { return rank_of_[sample]; });
}

/// Compresses into `newest_`. False if memory runs out.
bool RankEncoder::pack(RankMode mode) {
    const bool ranked = mode != samples_by_gradient;
    if (ranked && distinct_.empty()) find_ranks();
    const std::size_t samples = samples_.size(), distinct = ranked ? distinct_.size() : 0;
    const std::size_t head = ranked ? 3 : 1, plain = packs_head_ ? 0 : head;
    bytes_.resize(head + 2 * (distinct + samples));
    bytes_[0] = static_cast<std::uint8_t>(mode);
    if (ranked) {
        bytes_[1] = static_cast<std::uint8_t>(distinct - 1);
        bytes_[2] = static_cast<std::uint8_t>((distinct - 1) >> 8);
    }
    std::uint8_t *const dictionary = bytes_.data() + head, *const codes = dictionary + 2 * distinct;
    if (ranked) put_distinct(distinct_, {dictionary, dictionary + distinct});
    put_codes(ranked ? ranks_ : samples_, width_, mode == ranks_by_left, {codes, codes + samples});

    newest_.memory.resize(bytes_.size() + bytes_.size() / 8 + 1024);  // zlib and zstd need less
    std::copy_n(bytes_.begin(), plain, newest_.memory.begin());
    const std::size_t size =
        compress_(std::span(bytes_).subspan(plain), std::span(newest_.memory).subspan(plain));
    newest_.size = plain + size;
    return size > 0;
}

std::span<const std::uint8_t> RankEncoder::encode(const PlaneView& plane, bool choose) {
    take_samples(plane);
    if (!choose && mode_) {
        if (!pack(*mode_)) return {};
        if (newest_.size <= size_then_ + size_then_ / 16)
            return std::span(newest_.memory).first(newest_.size);
    }
    mode_.reset();
    for (const RankMode mode : {samples_by_gradient, ranks_by_left, ranks_by_gradient}) {
        if (!pack(mode)) return {};
        const std::size_t needed = mode_ == samples_by_gradient ? chosen_.size / 64 : 0;
        if (mode_ && newest_.size + needed >= chosen_.size) continue;
        std::swap(newest_, chosen_);
        mode_ = mode;
    }
    size_then_ = chosen_.size;
    return std::span(chosen_.memory).first(chosen_.size);
}

}  // namespace touchable
