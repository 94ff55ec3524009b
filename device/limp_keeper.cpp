#include "device/limp_keeper.hpp"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

namespace touchable {
namespace {

constexpr int nothing_kept = -1;
constexpr int longest_wait_ms = 1000;

/// What goes to the keeper, with a descriptor beside it where there is one.
struct Order {
    std::int32_t place = 0;
    std::int32_t endpoint = -1;  // -1: write(2)
    std::uint32_t bytes = 0;
    std::byte word[LimpKeeper::most_bytes] = {};
};

union Ancillary {
    cmsghdr header;
    char room[CMSG_SPACE(sizeof(int))];
};

// ---- The keeper's process. Forked from one that may have threads: only what a signal handler may call.

struct Keeping {
    int descriptor = nothing_kept;
    Order order;
};

/// Twice: a receiver may be in the middle of something that a first one ends.
void speak_for(Keeping& kept) {
    for (int again = 0; again < 2; ++again) {
        if (kept.order.endpoint < 0) {
            [[maybe_unused]] const auto written = write(kept.descriptor, kept.order.word, kept.order.bytes);
        } else {
            usbdevfs_bulktransfer transfer{static_cast<unsigned>(kept.order.endpoint), kept.order.bytes, 50,
                                           kept.order.word};
            ioctl(kept.descriptor, USBDEVFS_BULK, &transfer);
        }
    }
}

/// The next order; false once nobody can give one any more. `descriptor`: what came with it, or -1.
bool next_order(int socket, Order& order, int& descriptor) {
    iovec part{&order, sizeof order};
    Ancillary ancillary{};
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

[[noreturn]] void keep_until_alone(int socket) {
    prctl(PR_SET_NAME, "touchable-limp");
    setsid();  // a terminal's Ctrl-C is for the others
    for (const int ignored : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
        struct sigaction action = {};
        action.sa_handler = SIG_IGN;
        sigaction(ignored, &action, nullptr);
    }
    // What it does not need it must not hold open: a pipe that the other one writes would have no end.
    if (socket != 3) {
        dup2(socket, 3);
        socket = 3;
    }
    close_range(4, ~0U, 0);
    for (const int standard : {0, 1, 2}) close(standard);
    Keeping kept[LimpKeeper::most_devices];
    Order order;
    int descriptor = nothing_kept;
    while (next_order(socket, order, descriptor)) {
        Keeping& place = kept[order.place % LimpKeeper::most_devices];
        if (place.descriptor != nothing_kept) close(place.descriptor);
        place.descriptor = descriptor;
        place.order = order;
        const std::byte done{1};
        [[maybe_unused]] const auto told = send(socket, &done, 1, MSG_NOSIGNAL);
    }
    for (Keeping& place : kept)
        if (place.descriptor != nothing_kept) speak_for(place);
    _exit(0);
}

}  // namespace

Result<std::shared_ptr<LimpKeeper>> LimpKeeper::start() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
        return Error{
            ErrorKind::internal,
            std::string("no socket for the process that leaves devices limp: ") + std::strerror(errno)};
    const pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        keep_until_alone(ends[1]);
    }
    close(ends[1]);
    if (process < 0) {
        close(ends[0]);
        return Error{
            ErrorKind::internal,
            std::string("no process that leaves devices limp can be started: ") + std::strerror(errno)};
    }
    return std::shared_ptr<LimpKeeper>(new LimpKeeper(ends[0], process));
}

LimpKeeper::~LimpKeeper() {
    close(socket_);
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

Result<LimpKeeper::Kept> LimpKeeper::keep(std::shared_ptr<LimpKeeper> keeper) {
    const std::lock_guard lock(keeper->mutex_);
    const auto free = std::find(std::begin(keeper->taken_), std::end(keeper->taken_), false);
    if (free == std::end(keeper->taken_))
        return Error{ErrorKind::device,
                     "no more than " + std::to_string(most_devices) + " devices can be used at a time"};
    *free = true;
    const auto place = static_cast<int>(free - std::begin(keeper->taken_));
    return Kept(std::move(keeper), place);
}

Result<void> LimpKeeper::tell(int place, const LastWord* word) {
    const std::lock_guard lock(mutex_);
    Order order;
    order.place = place;
    Ancillary ancillary{};
    iovec part{&order, sizeof order};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (word) {
        if (word->bytes.size() > most_bytes)
            return Error{ErrorKind::internal, "a device's last word is too long to be kept"};
        order.endpoint = word->usb_endpoint ? *word->usb_endpoint : -1;
        order.bytes = static_cast<std::uint32_t>(word->bytes.size());
        std::copy(word->bytes.begin(), word->bytes.end(), order.word);
        message.msg_control = &ancillary;
        message.msg_controllen = sizeof ancillary;
        cmsghdr* header = CMSG_FIRSTHDR(&message);
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SCM_RIGHTS;
        header->cmsg_len = CMSG_LEN(sizeof(int));
        std::memcpy(CMSG_DATA(header), &word->descriptor, sizeof(int));
    }
    ssize_t sent = 0;
    do sent = sendmsg(socket_, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    // Once it is done, a socket that was let go of is free for another.
    pollfd answer{socket_, POLLIN, 0};
    std::byte done{};
    if (sent == static_cast<ssize_t>(sizeof order) && poll(&answer, 1, longest_wait_ms) == 1 &&
        recv(socket_, &done, 1, 0) == 1)
        return {};
    return Error{ErrorKind::device,
                 std::string("the process that leaves devices limp is gone (") + std::strerror(errno) + ")"};
}

LimpKeeper::Kept& LimpKeeper::Kept::operator=(Kept&& other) noexcept {
    std::swap(keeper_, other.keeper_);
    std::swap(place_, other.place_);
    return *this;
}

LimpKeeper::Kept::~Kept() {
    if (!keeper_) return;
    if (auto told = keeper_->tell(place_, nullptr); !told.ok()) return;
    const std::lock_guard lock(keeper_->mutex_);
    keeper_->taken_[place_] = false;
}

/// Told again even where it reads the same: a device that was opened anew has often the number of its old
/// descriptor, and the keeper would hold the old one.
Result<void> LimpKeeper::Kept::say(const LastWord& word) {
    return keeper_->tell(place_, &word);
}

}  // namespace touchable
