#include "device/limp_keeper.hpp"

#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

namespace touchable {
namespace {

constexpr int longest_wait_ms = 1000;
constexpr std::size_t heart_bytes = LimpKeeper::most_devices * sizeof(Heartbeat);

Error not_started(const char* what) {
    return {ErrorKind::internal, std::string(what) + " that leaves devices limp: " + std::strerror(errno)};
}

LimpOrder::Word word_of(const std::vector<std::byte>& bytes) {
    LimpOrder::Word word;
    word.bytes = static_cast<std::uint32_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), word.text);
    return word;
}

}  // namespace

Result<std::shared_ptr<LimpKeeper>> LimpKeeper::start() {
    void* const shared =
        mmap(nullptr, heart_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) return not_started("no memory can be shared with the process");
    const std::span hearts(static_cast<Heartbeat*>(shared), most_devices);
    std::uninitialized_default_construct(hearts.begin(), hearts.end());
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
        const Error error = not_started("no socket can be had for the process");
        munmap(shared, heart_bytes);
        return error;
    }
    const std::span<char> command_line = own_command_line();
    const pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        keep_limp_until_alone(ends[1], hearts, command_line);
    }
    const Error error = not_started("no process can be started");
    close(ends[1]);
    if (process > 0) return std::shared_ptr<LimpKeeper>(new LimpKeeper(ends[0], process, hearts));
    close(ends[0]);
    munmap(shared, heart_bytes);
    return error;
}

LimpKeeper::~LimpKeeper() {
    close(socket_);
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
    munmap(hearts_.data(), heart_bytes);
}

Result<void> LimpKeeper::health() const {
    pollfd its_end{socket_, 0, 0};
    if (poll(&its_end, 1, 0) < 1) return {};
    return Error{ErrorKind::device,
                 "the process that leaves devices limp when this program cannot (limp-keeper, " +
                     std::to_string(process_) +
                     ") is gone; there is no force without it: start the program again"};
}

Result<LimpKeeper::Kept> LimpKeeper::keep(std::shared_ptr<LimpKeeper> keeper) {
    const std::lock_guard lock(keeper->mutex_);
    const auto free = std::find(std::begin(keeper->taken_), std::end(keeper->taken_), false);
    if (free == std::end(keeper->taken_))
        return Error{ErrorKind::device,
                     "no more than " + std::to_string(most_devices) + " devices can be used at a time"};
    *free = true;
    const auto place = static_cast<std::size_t>(free - std::begin(keeper->taken_));
    return Kept(std::move(keeper), place);
}

Result<void> LimpKeeper::tell(std::size_t place, const LastWord* word) {
    const std::lock_guard lock(mutex_);
    LimpOrder order;
    order.place = static_cast<std::uint32_t>(place);
    alignas(cmsghdr) char ancillary[CMSG_SPACE(sizeof(int))] = {};
    iovec part{&order, sizeof order};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    if (word) {
        if (std::max(word->bytes.size(), word->meanwhile.size()) > most_bytes)
            return Error{ErrorKind::internal, "a device's last word is too long to be kept"};
        order.endpoint = word->usb_endpoint ? *word->usb_endpoint : -1;
        order.last = word_of(word->bytes);
        order.meanwhile = word_of(word->meanwhile);
        message.msg_control = ancillary;
        message.msg_controllen = sizeof ancillary;
        cmsghdr* header = CMSG_FIRSTHDR(&message);
        header->cmsg_level = SOL_SOCKET;
        header->cmsg_type = SCM_RIGHTS;
        header->cmsg_len = CMSG_LEN(sizeof(int));
        std::memcpy(CMSG_DATA(header), &word->descriptor, sizeof(int));
    }
    hearts_[place].beat_ns = 0;
    std::byte done{};
    while (recv(socket_, &done, 1, MSG_DONTWAIT) == 1) {
    }  // the answer to an earlier order, which came too late
    ssize_t sent = 0;
    do sent = sendmsg(socket_, &message, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    // Once it is done, a socket that was let go of is free for another.
    pollfd answer{socket_, POLLIN, 0};
    int answered = 0;
    do answered = poll(&answer, 1, longest_wait_ms);
    while (answered < 0 && errno == EINTR);
    if (sent == static_cast<ssize_t>(sizeof order) && answered == 1 && recv(socket_, &done, 1, 0) == 1)
        return {};
    if (auto lives = health(); !lives.ok()) return lives;
    return Error{ErrorKind::device, "the process that leaves devices limp (limp-keeper, " +
                                        std::to_string(process_) + ") does not answer"};
}

LimpKeeper::Kept& LimpKeeper::Kept::operator=(Kept&& other) noexcept {
    std::swap(keeper_, other.keeper_);
    std::swap(place_, other.place_);
    std::swap(silences_, other.silences_);
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
    silences_ = keeper_->hearts_[place_].silences;
    return keeper_->tell(place_, &word);
}

bool LimpKeeper::Kept::was_made_limp() const {
    return keeper_->hearts_[place_].silences != silences_;
}

Result<bool> LimpKeeper::Kept::beat() {
    if (auto lives = keeper_->health(); !lives.ok()) return lives.error();
    Heartbeat& heart = keeper_->hearts_[place_];
    heart.beat_ns = boot_ns();
    const std::uint32_t silences = heart.silences;
    return std::exchange(silences_, silences) == silences;
}

}  // namespace touchable
