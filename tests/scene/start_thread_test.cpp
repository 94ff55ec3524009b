#include "engine/base/threads.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <array>
#include <string>

namespace touchable::test {
namespace {

TEST(StartThread, CarriesItsNameAndDoesItsWork) {
    std::array<char, 16> name{};
    std::thread thread;
    ASSERT_TRUE(start_thread(thread, "fifteen-letters", "that is a test",
                             [&name] { pthread_getname_np(pthread_self(), name.data(), name.size()); }));
    thread.join();
    EXPECT_EQ(std::string(name.data()), "fifteen-letters");
}

}  // namespace
}  // namespace touchable::test
