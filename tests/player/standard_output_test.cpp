#include "player/run/standard_output.hpp"
#include "player/run/terminal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <string>
#include <thread>

#include "engine/base/threads.hpp"

namespace touchable::test {
namespace {
using namespace std::chrono_literals;

/// Standard output into a pipe, as long as it lives.
class PipedOutput {
public:
    PipedOutput() : before_(dup(STDOUT_FILENO)) {
        std::cout.flush();
        if (pipe(ends_.data()) != 0 || dup2(ends_[1], STDOUT_FILENO) < 0) std::abort();
    }
    ~PipedOutput() {
        dup2(before_, STDOUT_FILENO);
        for (const int end : {before_, ends_[0], ends_[1]}) close(end);
    }
    PipedOutput(const PipedOutput&) = delete;
    PipedOutput& operator=(const PipedOutput&) = delete;

    std::size_t read(std::size_t bytes) {
        std::string to(bytes, '\0');
        const ssize_t count = ::read(ends_[0], to.data(), to.size());
        return count > 0 ? static_cast<std::size_t>(count) : 0;
    }
    int waiting() const {
        int bytes = 0;
        ioctl(ends_[0], FIONREAD, &bytes);
        return bytes;
    }

private:
    std::array<int, 2> ends_{};
    int before_;
};

constexpr std::size_t much = 300'000;

TEST(StandardOutput, AReaderWhoTakesALittleNowAndThenDoesNotHoldALiveRun) {
    PipedOutput pipe;
    StandardOutput output(Pace::wall_clock, 300ms);
    ASSERT_TRUE(output.write(std::string(much, 'x')));
    std::atomic<bool> over{false};
    std::thread reader([&] {
        while (!over) {  // a quarter of what is the least
            (void)pipe.read(4096);
            std::this_thread::sleep_for(75ms);
        }
        while (pipe.waiting() > 0) (void)pipe.read(much);
    });
    const auto done = output.finish();
    over = true;
    reader.join();
    ASSERT_FALSE(done) << "it went on as long as anything was read";
    EXPECT_EQ(done.error().kind, ErrorKind::input);
    EXPECT_TRUE(output.reader_lags());
}

TEST(StandardOutput, AReaderWhoReadsGetsAllOfALiveRun) {
    PipedOutput pipe;
    StandardOutput output(Pace::wall_clock, 1h);
    ASSERT_TRUE(output.write(std::string(much, 'x')));
    std::size_t heard = 0;
    std::thread reader([&] {
        while (heard < much) heard += pipe.read(10'000);
    });
    const auto done = output.finish();
    reader.join();
    EXPECT_TRUE(done);
    EXPECT_EQ(heard, much);
}

/// Somebody asks to stop while a live run waits at its end.
[[noreturn]] void stop_at_the_end() {
    alarm(60);
    PipedOutput pipe;
    StandardOutput output(Pace::wall_clock, 1h);
    if (!output.write(std::string(much, 'x'))) std::_Exit(2);
    const int full = pipe.waiting();
    std::thread person([&] {
        (void)pipe.read(static_cast<std::size_t>(full));
        while (pipe.waiting() < full) std::this_thread::sleep_for(1ms);  // it is giving the rest
        request_stop();
    });
    const auto done = output.finish();
    person.join();
    std::_Exit(!done && done.error().kind == ErrorKind::interrupted ? 0 : 1);
}

TEST(StandardOutput, ALiveRunThatWaitsAtItsEndEndsWhenItIsAskedTo) {
    EXPECT_EXIT(stop_at_the_end(), ::testing::ExitedWithCode(0), "");
}

TEST(StandardOutput, WhatSomebodyEndedIsGivenStill) {
    EXPECT_EXIT(
        {
            alarm(60);
            PipedOutput pipe;
            StandardOutput output(Pace::wall_clock, 1h);
            if (!output.write(std::string(much, 'x'))) std::_Exit(2);
            request_stop();
            std::size_t heard = 0;
            std::thread reader([&] {
                while (heard < much) heard += pipe.read(10'000);
            });
            const bool is_whole = bool(output.finish());
            reader.join();
            std::_Exit(is_whole && heard == much ? 0 : 1);
        },
        ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace touchable::test
