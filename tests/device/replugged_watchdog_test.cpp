// A device that is plugged in again has often the number of its old descriptor, and the same last word.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

#include "device/drivers/safety_watchdog.hpp"

namespace touchable::test {
namespace {

std::string heard_at(int socket) {
    char room[16];
    const ssize_t came = recv(socket, room, sizeof room, 0);
    return {room, static_cast<std::size_t>(came > 0 ? came : 0)};
}

TEST(ReplugWatchdog, SpeaksToTheDeviceThatWasOpenedLast) {
    int old_device[2], new_device[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, old_device), 0);
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, new_device), 0);
    const pid_t process = fork();
    if (process == 0) {
        auto watchdog = SafetyWatchdog::start();
        if (!watchdog) _exit(1);
        auto kept = SafetyWatchdog::keep(*watchdog);
        if (!kept) _exit(1);
        const ZeroForcePacket word{old_device[1], {std::byte{'0'}}, {}};
        if (!kept->set_packet(word)) _exit(1);
        dup2(new_device[1], old_device[1]);
        _exit(kept->set_packet(word) ? 0 : 1);
    }
    for (const int theirs : {old_device[1], new_device[1]}) close(theirs);
    EXPECT_EQ(heard_at(new_device[0]), "0");
    EXPECT_EQ(heard_at(old_device[0]), "");
    int ended = -1;
    waitpid(process, &ended, 0);
    EXPECT_EQ(ended, 0);
    for (const int ours : {old_device[0], new_device[0]}) close(ours);
}

}  // namespace
}  // namespace touchable::test
