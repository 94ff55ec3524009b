#include "device/watchdog_process.hpp"

#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace touchable {
namespace {

// Forked from a process that may have threads: only what a signal handler may call.

constexpr char process_name[] = "safety-watchdog";
constexpr int nothing_kept = -1;
// Above the threads that it watches, and at least above ordinary work.
constexpr int wanted_priorities[] = {85, 1};

struct Keeping {
    int descriptor = nothing_kept;
    WatchdogOrder order;
    HeartWatch watch;
    pid_t sender = 0;  // a process that sends, or has sent; 0: there was none
};

/// Twice: a receiver may be in the middle of something that a first one ends.
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

/// Beside other devices by a process of its own, so that one that takes no bytes keeps no other waiting.
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
    return std::count_if(kept.begin(), kept.end(),
                         [](const Keeping& each) { return each.descriptor != nothing_kept; }) < 2;
}

/// The heart is looked at last of all before the word: this process may have been late, and not the other.
void send_if_due(Keeping& kept, Heartbeat& heart, bool is_alone) {
    const auto is_due = [&] { return kept.watch.due_ns(heart.beat_ns) <= boot_ns(); };
    if (!is_due()) return;
    ++heart.silences;
    if (!is_due()) return;
    const WatchdogOrder::Packet& meanwhile = kept.order.meanwhile;
    // A word that is still on its way counts as this one.
    if (!is_sending(kept))
        send_beside_others(kept, is_alone, [&] {
            if (is_due()) send_packet(kept, meanwhile.bytes > 0 ? meanwhile : kept.order.last);
        });
    kept.watch.sent(boot_ns());
}

/// The next order; false once nobody can give one any more. `descriptor`: what came with it, or -1.
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
    ssize_t came = 0;
    do came = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
    while (came < 0 && errno == EINTR);
    if (came != static_cast<ssize_t>(sizeof order)) return false;
    descriptor = nothing_kept;
    if (const cmsghdr* header = CMSG_FIRSTHDR(&message); header && header->cmsg_type == SCM_RIGHTS)
        std::memcpy(&descriptor, CMSG_DATA(header), sizeof descriptor);
    return true;
}

/// Whether there is an order, or an end, before the first word is due. Nobody tells of a heart that begins to
/// beat, so it is looked for again and again.
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

void keep(int socket, std::span<Keeping> kept, WatchdogHeartbeats& hearts) {
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

/// A process that nobody means who signals the program: not by its terminal, nor by its name.
void become_another(std::span<char> command_line) {
    setsid();  // a terminal's Ctrl-C is for the others
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

}  // namespace

void watch_until_alone(int socket, WatchdogHeartbeats& hearts, std::span<char> command_line) {
    become_another(command_line);
    // What it does not need it must not hold open: a pipe that the other one writes would have no end.
    if (socket != 3) {
        dup2(socket, 3);
        socket = 3;
    }
    close_range(4, ~0U, 0);
    for (const int standard : {0, 1, 2}) close(standard);
    Keeping kept[WatchdogOrder::most_devices];
    keep(socket, kept, hearts);
    const bool alone = is_alone(kept);
    for (Keeping& place : kept)
        if (place.descriptor != nothing_kept)
            send_beside_others(place, alone, [&place] { send_packet(place, place.order.last); });
    // A device that takes nothing keeps no other's descriptor from being let go of.
    for (const Keeping& place : kept)
        if (place.descriptor != nothing_kept) close(place.descriptor);
    while (wait(nullptr) > 0) {  // whoever waits for this process waits for all words
    }
    _exit(0);
}

std::span<char> own_command_line() {
    std::ifstream file("/proc/self/stat");
    const std::string all{std::istreambuf_iterator<char>(file), {}};
    // The name of the process stands in brackets, and may have any sign in it; then the third field begins.
    std::istringstream fields(all.substr(std::min(all.rfind(')') + 1, all.size())));
    std::uintptr_t begin = 0, end = 0;
    std::string field;
    for (int number = 3; number < 48 && fields >> field; ++number) {
    }
    if (!(fields >> begin >> end) || begin == 0 || end <= begin) return {};
    return {reinterpret_cast<char*>(begin), end - begin};
}

}  // namespace touchable
