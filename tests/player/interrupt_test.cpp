#include "player/run/terminal.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <initializer_list>
#include <thread>

namespace touchable::test {
namespace {

/// A program that is asked to stop by each of `signals`, the last one so much after the others.
[[noreturn]] void be_asked(std::initializer_list<int> signals, std::chrono::milliseconds last_after) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
    catch_interrupts();
    if (stop_requested()) std::_Exit(1);
    int left = static_cast<int>(signals.size());
    for (const int signal : signals) {
        if (--left == 0) std::this_thread::sleep_for(last_after);
        std::raise(signal);
    }
    std::_Exit(stop_requested() ? 0 : 1);
}

using std::chrono::milliseconds;

TEST(InterruptDeathTest, SignalsAtOnceAskOnce) {
    EXPECT_EXIT(be_asked({SIGINT}, milliseconds(0)), ::testing::ExitedWithCode(0), "");
    EXPECT_EXIT(be_asked({SIGINT, SIGINT, SIGINT}, milliseconds(0)), ::testing::ExitedWithCode(0), "");
    EXPECT_EXIT(be_asked({SIGINT, SIGTERM, SIGHUP}, milliseconds(0)), ::testing::ExitedWithCode(0), "");
}

TEST(InterruptDeathTest, OneThatComesLaterEndsTheProgram) {
    EXPECT_EXIT(be_asked({SIGINT, SIGINT}, same_wish), ::testing::KilledBySignal(SIGINT), "");
    EXPECT_EXIT(be_asked({SIGINT, SIGTERM}, same_wish), ::testing::KilledBySignal(SIGTERM), "");
}

}  // namespace
}  // namespace touchable::test
