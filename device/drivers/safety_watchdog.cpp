// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/safety_watchdog.hpp"

#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <new>
#include <sstream>

#include "engine/base/try.hpp"

namespace touchable {

/// In memory that both processes share.
struct WatchdogHeartbeats {
    std::array<Heartbeat, SafetyWatchdog::most_devices> devices;
    std::atomic<std::uint32_t> watchdog_beats{0};  ///< counted by the process while it keeps a device
};

namespace {

/// Message to the watchdog's process: what to send to one device. The device's descriptor comes with it
/// (SCM_RIGHTS); a message without one ends the care for the device. The process carries out each message,
/// then answers with its number.
struct WatchdogOrder {
    struct Packet {
        std::uint32_t bytes = 0;
        std::byte text[SafetyWatchdog::most_bytes] = {};
    };
    std::uint32_t number = 0;
    std::uint32_t place = 0;     ///< index of the device and its Heartbeat: below most_devices
    std::int32_t endpoint = -1;  ///< -1: write(2)
    Packet last, meanwhile;      ///< ZeroForcePacket's
};

// ---- The process. Its parent may have threads, so it does only what a signal handler may.

constexpr char process_name[] = "safety-watchdog";
constexpr int nothing_kept = -1;
constexpr int longest_wait_ms = 1000;
/// For an answer, before a device is powered: at a load of 10 the process may not run for a second.
constexpr int answer_within_ms = 5000;
// Above the threads that it watches; if that is not permitted, above ordinary work.
constexpr int wanted_priorities[] = {85, 1};

struct Keeping {
    int descriptor = nothing_kept;
    WatchdogOrder order;
    HeartWatch watch;
    pid_t sender = 0;  // process that sends, or has sent; 0: none
};

/// Sends twice: the first packet may only end a message that the receiver is in the middle of.
void send_packet(const Keeping& kept, const WatchdogOrder::Packet& packet) {
    for (int again = 0; again < 2; ++again) {
        if (kept.order.endpoint < 0) {
            [[maybe_unused]] const auto written = write(kept.descriptor, packet.text, packet.bytes);
        } else {
            WatchdogOrder::Packet copy = packet;
            usbdevfs_bulktransfer transfer{static_cast<unsigned>(kept.order.endpoint), copy.bytes, 50,
                                           copy.text};
            ioctl(kept.descriptor, USBDEVFS_BULK, &transfer);
        }
    }
}

bool is_sending(const Keeping& kept) {
    return kept.sender > 0 && waitpid(kept.sender, nullptr, WNOHANG) == 0;
}

/// Sends in a child process if other devices are kept, so that a device that blocks does not delay them.
template <class Send>
void send_beside_others(Keeping& kept, bool is_alone, Send&& sends) {
    if (is_alone) return sends();
    kept.sender = _Fork();
    if (kept.sender > 0) return;
    if (kept.sender < 0) return sends();
    const auto its_own = static_cast<unsigned>(kept.descriptor);
    if (its_own > 0) close_range(0, its_own - 1, 0);
    close_range(its_own + 1, ~0U, 0);
    sends();
    _exit(0);
}

bool is_alone(std::span<const Keeping> kept) {
    return std::ranges::count_if(kept, [](const Keeping& each) { return each.descriptor != nothing_kept; }) <
           2;
}

/// The heartbeat is checked again right before sending: this process may have been late, not the other.
void send_if_due(Keeping& kept, Heartbeat& heart, bool is_alone) {
    const auto is_due = [&] { return kept.watch.due_ns(heart.beat_ns) <= boot_ns(); };
    if (!is_due()) return;
    ++heart.silences;
    if (!is_due()) return;
    const WatchdogOrder::Packet& meanwhile = kept.order.meanwhile;
    // A packet that is still being sent counts as this one.
    if (!is_sending(kept))
        send_beside_others(kept, is_alone, [&] {
            if (is_due()) send_packet(kept, meanwhile.bytes > 0 ? meanwhile : kept.order.last);
        });
    kept.watch.sent(boot_ns());
}

/// Receives an order; false once the socket's other end is closed. `descriptor`: the one with it, or -1.
bool next_order(int socket, WatchdogOrder& order, int& descriptor) {
    union {
        cmsghdr header;
        char room[CMSG_SPACE(sizeof(int))];
    } ancillary{};
    iovec part{&order, sizeof order};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = &ancillary;
    message.msg_controllen = sizeof ancillary;
    const ssize_t came = TEMP_FAILURE_RETRY(recvmsg(socket, &message, MSG_CMSG_CLOEXEC));
    if (came != static_cast<ssize_t>(sizeof order)) return false;
    descriptor = nothing_kept;
    if (const cmsghdr* header = CMSG_FIRSTHDR(&message); header && header->cmsg_type == SCM_RIGHTS)
        std::memcpy(&descriptor, CMSG_DATA(header), sizeof descriptor);
    return true;
}

/// Whether an order, or the socket's end, comes before the first packet is due. No message announces a first
/// heartbeat, so it is polled.
bool waits_for_order(int socket, std::span<Keeping> kept, WatchdogHeartbeats& hearts) {
    const std::int64_t now = boot_ns();
    std::int64_t due = now + Heartbeat::longest_ns;
    bool is_any_kept = false;
    for (std::size_t place = 0; place < kept.size(); ++place) {
        if (kept[place].descriptor == nothing_kept) continue;
        is_any_kept = true;
        due = std::min(due, kept[place].watch.due_ns(hearts.devices[place].beat_ns));
    }
    const timespec patience{0, std::max<std::int64_t>(due - now, 0)};
    pollfd waited_for{socket, POLLIN, 0};
    return ppoll(&waited_for, 1, is_any_kept ? &patience : nullptr, nullptr) == 1;
}

void keep_devices(int socket, std::span<Keeping> kept, WatchdogHeartbeats& hearts) {
    for (;;) {
        ++hearts.watchdog_beats;
        if (waits_for_order(socket, kept, hearts)) {
            WatchdogOrder order;
            int descriptor = nothing_kept;
            if (!next_order(socket, order, descriptor)) return;
            Keeping& place = kept[order.place % kept.size()];
            if (is_sending(place)) kill(place.sender, SIGKILL);
            if (place.descriptor != nothing_kept) close(place.descriptor);
            place = {descriptor, order, {}, 0};
            [[maybe_unused]] const auto answered =
                send(socket, &order.number, sizeof order.number, MSG_NOSIGNAL);
        }
        const bool alone = is_alone(kept);
        for (std::size_t place = 0; place < kept.size(); ++place)
            if (kept[place].descriptor != nothing_kept)
                send_if_due(kept[place], hearts.devices[place], alone);
    }
}

/// Signals to the program, by its terminal or its name, do not reach this process afterwards.
void become_another(std::span<char> command_line) {
    setsid();  // out of reach of the terminal's Ctrl-C
    prctl(PR_SET_NAME, process_name);
    std::fill(command_line.begin(), command_line.end(), '\0');
    if (!command_line.empty())
        std::copy_n(process_name, std::min(sizeof process_name, command_line.size()) - 1,
                    command_line.begin());
    for (const int ignored : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGCHLD}) {
        struct sigaction action = {};
        action.sa_handler = SIG_IGN;
        sigaction(ignored, &action, nullptr);
    }
    prctl(PR_SET_TIMERSLACK, 1UL);
    for (const int priority : wanted_priorities) {
        const sched_param wanted{.sched_priority = priority};
        if (sched_setscheduler(0, SCHED_FIFO, &wanted) == 0) break;
    }
}

/// All that the process does, from its fork to its end. `command_line`: its own, as the system shows it; it
/// is overwritten, so that a signal to the program by name does not end this process.
[[noreturn]] void watch_until_alone(int socket, WatchdogHeartbeats& hearts, std::span<char> command_line) {
    become_another(command_line);
    // An inherited descriptor must not stay open: a pipe that the parent writes would have no end.
    if (socket != 3) {
        dup2(socket, 3);
        socket = 3;
    }
    close_range(4, ~0U, 0);
    for (const int standard : {0, 1, 2}) close(standard);
    Keeping kept[SafetyWatchdog::most_devices];
    keep_devices(socket, kept, hearts);
    const bool alone = is_alone(kept);
    for (Keeping& place : kept)
        if (place.descriptor != nothing_kept)
            send_beside_others(place, alone, [&place] { send_packet(place, place.order.last); });
    // Closed afterwards: a device that blocks must not delay the others' zeros.
    for (const Keeping& place : kept)
        if (place.descriptor != nothing_kept) close(place.descriptor);
    while (wait(nullptr) > 0) {  // whatever waits for this process waits for its senders
    }
    _exit(0);
}

// ---- The process that is watched.

/// Memory from which the system reads this process's command line; empty: unknown.
std::span<char> own_command_line() {
    std::ifstream file("/proc/self/stat");
    const std::string all{std::istreambuf_iterator<char>(file), {}};
    // The process's name is in brackets and may contain any character; the third field follows it.
    std::istringstream fields(all.substr(std::min(all.rfind(')') + 1, all.size())));
    std::uintptr_t begin = 0, end = 0;
    std::string field;
    for (int number = 3; number < 48 && fields >> field; ++number) {
    }
    if (!(fields >> begin >> end) || begin == 0 || end <= begin) return {};
    return {reinterpret_cast<char*>(begin), end - begin};
}

Error not_started(const char* what) {
    return internal_error(std::string(what) + " that leaves devices unpowered: " + std::strerror(errno));
}

WatchdogOrder::Packet packet_of(const std::vector<std::byte>& bytes) {
    WatchdogOrder::Packet packet;
    packet.bytes = static_cast<std::uint32_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), packet.text);
    return packet;
}

/// Whether the process at the socket's other end ends in time; no other process holds that end.
bool has_ended(int socket, int patience_ms) {
    pollfd its_end{socket, 0, 0};
    return TEMP_FAILURE_RETRY(poll(&its_end, 1, patience_ms)) == 1;
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

/// A stopped process does not end by itself.
SafetyWatchdog::~SafetyWatchdog() {
    shutdown(socket_, SHUT_WR);
    bool ended = has_ended(socket_, stands_still_ ? 0 : longest_wait_ms);
    if (!ended) {
        kill(process_, SIGKILL);
        ended = has_ended(socket_, longest_wait_ms);
    }
    close(socket_);
    (void)TEMP_FAILURE_RETRY(waitpid(process_, nullptr, ended ? 0 : WNOHANG));
    munmap(&hearts_, sizeof hearts_);
}

Result<void> SafetyWatchdog::health() const {
    const bool is_gone = has_ended(socket_, 0);
    if (!is_gone && !stands_still_) return {};
    return device_error(
        "the process that leaves devices unpowered when this program cannot (safety-watchdog, " +
        std::to_string(process_) + ") " + (is_gone ? "is gone" : "stands still") +
        "; there is no force without it: start the program again");
}

Result<std::unique_ptr<SafetyWatchdog::Kept>> SafetyWatchdog::keep(std::shared_ptr<SafetyWatchdog> watchdog) {
    const std::lock_guard lock(watchdog->mutex_);
    const auto free = std::ranges::find(watchdog->taken_, false);
    if (free == std::end(watchdog->taken_))
        return device_error("no more than " + std::to_string(most_devices) +
                            " devices can be used at a time");
    *free = true;
    const auto place = static_cast<std::size_t>(free - std::begin(watchdog->taken_));
    return std::unique_ptr<Kept>(new Kept(std::move(watchdog), place));
}

/// Waits for the answer to an order; late answers to earlier ones are skipped.
bool SafetyWatchdog::is_done(std::uint32_t number) const {
    const std::int64_t until = boot_ns() + std::int64_t{answer_within_ms} * 1'000'000;
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
    TRY(health());
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
            return internal_error("a device's last word is too long to be kept");
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
    const ssize_t sent = TEMP_FAILURE_RETRY(sendmsg(socket_, &message, MSG_NOSIGNAL));
    // Once the order is done, the process has closed the old descriptor, and its port is free.
    if (sent == static_cast<ssize_t>(sizeof order) && is_done(order.number)) return {};
    TRY(health());
    return device_error("the process that leaves devices unpowered (safety-watchdog, " +
                        std::to_string(process_) + ") does not answer");
}

SafetyWatchdog::Kept::~Kept() {
    if (!watchdog_->give_order(place_, nullptr)) return;
    const std::lock_guard lock(watchdog_->mutex_);
    watchdog_->taken_[place_] = false;
}

/// Sent even if it is unchanged: a reopened device's descriptor often has the old number, and the watchdog
/// would hold the old one.
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
