#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

#include "device/drivers/safety_watchdog.hpp"

namespace touchable {
namespace {

/// A device that is lost and found again often has its old descriptor's number.
TEST(ZeroForcePacket, GoesToTheDeviceThatCameBackUnderTheSameNumber) {
    int lost[2], found[2];
    ASSERT_EQ(pipe(lost), 0);
    ASSERT_EQ(pipe(found), 0);
    const pid_t child = fork();
    if (child == 0) {
        const ZeroForcePacket word{lost[1], {std::byte{'0'}}, {}};
        auto watchdog = SafetyWatchdog::start();
        if (!watchdog) _exit(1);
        auto kept = SafetyWatchdog::keep(*watchdog);
        if (!kept || !kept->set_packet(word)) _exit(1);
        if (dup2(found[1], lost[1]) < 0 || !kept->set_packet(word)) _exit(1);
        _exit(0);
    }
    close(lost[1]);
    close(found[1]);
    std::string heard;
    for (char byte = 0; read(found[0], &byte, 1) == 1;) heard += byte;
    EXPECT_EQ(heard, "00");  // a watchdog says it twice
    char byte = 0;
    EXPECT_EQ(read(lost[0], &byte, 1), 0);
    close(lost[0]);
    close(found[0]);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace touchable
