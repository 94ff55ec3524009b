#include "device/safety_watchdog.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>
#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr int longest_wait_ms = 1000;

Error not_started(const char* what) {
    return {ErrorKind::internal,
            std::string(what) + " that leaves devices unpowered: " + std::strerror(errno)};
}

WatchdogOrder::Packet packet_of(const std::vector<std::byte>& bytes) {
    WatchdogOrder::Packet packet;
    packet.bytes = static_cast<std::uint32_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), packet.text);
    return packet;
}

/// Whether the process at the other end of the socket ends by then: nobody else holds that end.
bool has_ended(int socket, int patience_ms) {
    pollfd its_end{socket, 0, 0};
    int ended = 0;
    do ended = poll(&its_end, 1, patience_ms);
    while (ended < 0 && errno == EINTR);
    return ended == 1;
}

}  // namespace

Result<std::shared_ptr<SafetyWatchdog>> SafetyWatchdog::start() {
    void* const shared =
        mmap(nullptr, sizeof(WatchdogHeartbeats), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) return not_started("no memory can be shared with the process");
    WatchdogHeartbeats& hearts = *new (shared) WatchdogHeartbeats;
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
        const Error error = not_started("no socket can be had for the process");
        munmap(shared, sizeof(WatchdogHeartbeats));
        return error;
    }
    const std::span<char> command_line = own_command_line();
    const pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        watch_until_alone(ends[1], hearts, command_line);
    }
    const Error error = not_started("no process can be started");
    close(ends[1]);
    if (process > 0) return std::shared_ptr<SafetyWatchdog>(new SafetyWatchdog(ends[0], process, hearts));
    close(ends[0]);
    munmap(shared, sizeof(WatchdogHeartbeats));
    return error;
}

/// One that is stopped does not end by itself.
SafetyWatchdog::~SafetyWatchdog() {
    shutdown(socket_, SHUT_WR);
    bool ended = has_ended(socket_, stands_still_ ? 0 : longest_wait_ms);
    if (!ended) {
        kill(process_, SIGKILL);
        ended = has_ended(socket_, longest_wait_ms);
    }
    close(socket_);
    while (waitpid(process_, nullptr, ended ? 0 : WNOHANG) < 0 && errno == EINTR) {
    }
    munmap(&hearts_, sizeof hearts_);
}

Result<void> SafetyWatchdog::health() const {
    const bool is_gone = has_ended(socket_, 0);
    if (!is_gone && !stands_still_) return {};
    return Error{ErrorKind::device,
                 "the process that leaves devices unpowered when this program cannot (safety-watchdog, " +
                     std::to_string(process_) + ") " + (is_gone ? "is gone" : "stands still") +
                     "; there is no force without it: start the program again"};
}

Result<SafetyWatchdog::Kept> SafetyWatchdog::keep(std::shared_ptr<SafetyWatchdog> watchdog) {
    const std::lock_guard lock(watchdog->mutex_);
    const auto free = std::find(std::begin(watchdog->taken_), std::end(watchdog->taken_), false);
    if (free == std::end(watchdog->taken_))
        return Error{ErrorKind::device,
                     "no more than " + std::to_string(most_devices) + " devices can be used at a time"};
    *free = true;
    const auto place = static_cast<std::size_t>(free - std::begin(watchdog->taken_));
    return Kept(std::move(watchdog), place);
}

/// What it says of an earlier order comes too late.
bool SafetyWatchdog::is_done(std::uint32_t number) const {
    const std::int64_t until = boot_ns() + std::int64_t{longest_wait_ms} * 1'000'000;
    for (;;) {
        const std::int64_t left_ms = (until - boot_ns()) / 1'000'000;
        pollfd answer{socket_, POLLIN, 0};
        const int came = poll(&answer, 1, static_cast<int>(std::max<std::int64_t>(left_ms, 0)));
        if (came < 0 && errno == EINTR) continue;
        std::uint32_t done = 0;
        if (came != 1 || recv(socket_, &done, sizeof done, 0) != sizeof done) return false;
        if (done == number) return true;
    }
}

Result<void> SafetyWatchdog::give_order(std::size_t place, const ZeroForcePacket* packet) {
    const std::lock_guard lock(mutex_);
    if (auto lives = health(); !lives.ok()) return lives;
    WatchdogOrder order;
    order.number = ++orders_;
    order.place = static_cast<std::uint32_t>(place);
    alignas(cmsghdr) char ancillary[CMSG_SPACE(sizeof(int))] = {};
    iovec part{&order, sizeof order};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (packet) {
        if (std::max(packet->bytes.size(), packet->meanwhile.size()) > most_bytes)
            return Error{ErrorKind::internal, "a device's last word is too long to be kept"};
        order.endpoint = packet->usb_endpoint ? *packet->usb_endpoint : -1;
        order.last = packet_of(packet->bytes);
        order.meanwhile = packet_of(packet->meanwhile);
        message.msg_control = ancillary;
        message.msg_controllen = sizeof ancillary;
        cmsghdr* header = CMSG_FIRSTHDR(&message);
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SCM_RIGHTS;
        header->cmsg_len = CMSG_LEN(sizeof(int));
        std::memcpy(CMSG_DATA(header), &packet->descriptor, sizeof(int));
    }
    hearts_.devices[place].beat_ns = 0;
    ssize_t sent = 0;
    do sent = sendmsg(socket_, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    // Once it is done, a socket that was let go of is free for another.
    if (sent == static_cast<ssize_t>(sizeof order) && is_done(order.number)) return {};
    if (auto lives = health(); !lives.ok()) return lives;
    return Error{ErrorKind::device, "the process that leaves devices unpowered (safety-watchdog, " +
                                        std::to_string(process_) + ") does not answer"};
}

SafetyWatchdog::Kept& SafetyWatchdog::Kept::operator=(Kept&& other) noexcept {
    std::swap(watchdog_, other.watchdog_);
    std::swap(place_, other.place_);
    std::swap(silences_, other.silences_);
    std::swap(watch_, other.watch_);
    return *this;
}

SafetyWatchdog::Kept::~Kept() {
    if (!watchdog_) return;
    if (auto given = watchdog_->give_order(place_, nullptr); !given.ok()) return;
    const std::lock_guard lock(watchdog_->mutex_);
    watchdog_->taken_[place_] = false;
}

/// Told again even where it reads the same: a device that was opened anew has often the number of its old
/// descriptor, and the watchdog would hold the old one.
Result<void> SafetyWatchdog::Kept::set_packet(const ZeroForcePacket& packet) {
    silences_ = watchdog_->hearts_.devices[place_].silences;
    return watchdog_->give_order(place_, &packet);
}

bool SafetyWatchdog::Kept::was_made_unpowered() const {
    return watchdog_->hearts_.devices[place_].silences != silences_;
}

Result<bool> SafetyWatchdog::Kept::beat() {
    const std::int64_t now = boot_ns();
    if (!watch_.is_alive(watchdog_->hearts_.watchdog_beats, now)) watchdog_->stands_still_ = true;
    TRY(watchdog_->health());
    Heartbeat& heart = watchdog_->hearts_.devices[place_];
    heart.beat_ns = now;
    const std::uint32_t silences = heart.silences;
    return std::exchange(silences_, silences) == silences;
}

}  // namespace touchable
