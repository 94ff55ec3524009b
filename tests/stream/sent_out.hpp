#pragma once

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/stream/sending.hpp"

namespace touchable::test {

/// A stream of bytes that goes out by an SrtOutput.
struct SentOut {
    static std::span<const std::uint8_t> header() {
        static constexpr std::array<std::uint8_t, 6> letters{'H', 'E', 'A', 'D', 'E', 'R'};
        return letters;
    }
    /// Twenty framesets, a key every five: larger than a datagram, and of different sizes.
    void add_all(std::int64_t larger_by = 700) {
        ring.begin(header(), padding);
        all = "HEADER";
        for (std::int64_t n = 0; n < 20; ++n) {
            std::vector<std::uint8_t> bytes(static_cast<std::size_t>(larger_by * n + 1),
                                            static_cast<std::uint8_t>('a' + n));
            all.append(bytes.begin(), bytes.end());
            ring.add({n, n % 5 == 0, std::move(bytes)});
        }
    }
    void wait_for_somebody() const {
        while (audience.there() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    void wait_for_nobody() const {
        while (audience.there() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    bool has_said(const std::string& what) {
        const std::lock_guard lock(mutex);
        for (const std::string& line : lines)
            if (line.find(what) != std::string::npos) return true;
        return false;
    }
    std::string newest_line() {
        const std::lock_guard lock(mutex);
        return lines.empty() ? "" : lines.back();
    }
    void wait_until_said(const std::string& what) {
        while (!has_said(what)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    std::unique_ptr<SrtOutput> open(const std::string& url) {
        auto output = SrtOutput::create(*read_stream_url(url), ring, audience);
        EXPECT_TRUE(output);
        EXPECT_TRUE((*output)->start());
        return std::move(*output);
    }

    std::vector<std::uint8_t> padding;
    std::mutex mutex;
    std::vector<std::string> lines;  // guarded by mutex while an output runs
    StreamAudience audience{[this](const std::string& line) {
        const std::lock_guard lock(mutex);
        lines.push_back(line);
    }};
    StreamRing ring;
    std::string all;
};

}  // namespace touchable::test
