#include "engine/camera/live_bytes.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

constexpr std::chrono::milliseconds step(10);

class Descriptor {
public:
    explicit Descriptor(int of = -1) : of_(of) {}
    ~Descriptor() { reset(); }
    Descriptor(Descriptor&& other) noexcept : of_(std::exchange(other.of_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(of_, other.of_);
        return *this;
    }
    int get() const { return of_; }
    void reset() {
        if (of_ >= 0) ::close(of_);
        of_ = -1;
    }

private:
    int of_;
};

std::string failure_text(int failure) {
    return std::generic_category().message(failure);
}

bool is_for_later(int failure) {
    return failure == EAGAIN || failure == EWOULDBLOCK || failure == EINTR;
}

struct Pipe {
    Descriptor out, in;  ///< to be read without waiting; to be written
};
Result<Pipe> make_pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0)
        return Error{ErrorKind::internal, "no pipe can be made: " + failure_text(errno)};
    Pipe made{Descriptor(ends[0]), Descriptor(ends[1])};
    ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    return made;
}

class Command final : public LiveBytes {
public:
    Command(::pid_t process, Descriptor output, Descriptor errors)
        : process_(process), output_(std::move(output)), errors_(std::move(errors)) {}
    ~Command() override;
    std::optional<std::size_t> read(std::span<std::uint8_t> into) override;
    std::array<pollfd, 2> waits() const override {
        return {pollfd{output_.get(), POLLIN, 0}, {errors_.get(), POLLIN, 0}};
    }
    std::string how_it_ended() override;

private:
    void hear_errors();
    std::string last_words() const;
    bool has_ended(siginfo_t& how) const;

    const ::pid_t process_;  // and its group, which is there until it is waited for
    Descriptor output_, errors_;
    std::string errors_said_;  // the last of it
};

std::optional<std::size_t> Command::read(std::span<std::uint8_t> into) {
    hear_errors();
    if (output_.get() < 0) return std::nullopt;
    const auto got = ::read(output_.get(), into.data(), into.size());
    if (got > 0) return static_cast<std::size_t>(got);
    if (got < 0 && is_for_later(errno)) return std::size_t{0};
    output_.reset();
    return std::nullopt;
}

void Command::hear_errors() {
    constexpr std::size_t most_kept = 2000;
    constexpr int most_at_once = 16;
    for (int k = 0; k < most_at_once && errors_.get() >= 0; ++k) {
        std::array<char, 4096> words;
        const auto got = ::read(errors_.get(), words.data(), words.size());
        if (got < 0 && is_for_later(errno)) return;
        if (got <= 0) return errors_.reset();
        errors_said_.append(words.data(), static_cast<std::size_t>(got));
        if (errors_said_.size() > most_kept) errors_said_.erase(0, errors_said_.size() - most_kept);
    }
}

std::string Command::last_words() const {
    constexpr std::size_t longest = 200;
    const std::size_t end = errors_said_.find_last_not_of(" \t\r\n");
    if (end == std::string::npos) return "";
    const std::size_t before = errors_said_.find_last_of("\r\n", end);
    const std::size_t begin = before == std::string::npos ? 0 : before + 1;
    return ": " + printable(errors_said_.substr(begin, end + 1 - begin), longest);
}

bool Command::has_ended(siginfo_t& how) const {
    how = {};
    return ::waitid(P_PID, static_cast<::id_t>(process_), &how, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           how.si_pid == process_;
}

std::string Command::how_it_ended() {
    constexpr int most_looks = 20;
    siginfo_t how;
    bool ended = has_ended(how);
    for (int looks = 0; !ended && looks < most_looks; ++looks) {
        std::this_thread::sleep_for(step);
        ended = has_ended(how);
    }
    hear_errors();
    if (!ended) return "closed its standard output" + last_words();
    if (how.si_code != CLD_EXITED) return "ended by signal " + std::to_string(how.si_status) + last_words();
    if (how.si_status == 0) return "ended";
    return "ended with status " + std::to_string(how.si_status) + last_words();
}

/// While the first process is not waited for, its group's number is nobody else's.
Command::~Command() {
    ::kill(-process_, SIGTERM);
    siginfo_t how;
    // Whoever of the group still writes holds the output open.
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    while (!(has_ended(how) && output_.get() < 0) && std::chrono::steady_clock::now() < until) {
        std::array<std::uint8_t, 65536> unread;
        if (read(unread).value_or(0) == 0) std::this_thread::sleep_for(step);
    }
    ::kill(-process_, SIGKILL);
    constexpr int most_steps = 200;
    for (int k = 0; k < most_steps && ::waitpid(process_, nullptr, WNOHANG) == 0; ++k)
        std::this_thread::sleep_for(step);
}

class Connection final : public LiveBytes {
public:
    explicit Connection(Descriptor socket) : socket_(std::move(socket)) {}
    std::optional<std::size_t> read(std::span<std::uint8_t> into) override {
        const auto got = ::recv(socket_.get(), into.data(), into.size(), MSG_DONTWAIT);
        if (got > 0) return static_cast<std::size_t>(got);
        if (got < 0 && is_for_later(errno)) return std::size_t{0};
        if (got < 0) failure_ = errno;
        return std::nullopt;
    }
    std::array<pollfd, 2> waits() const override {
        return {pollfd{socket_.get(), POLLIN, 0}, {-1, POLLIN, 0}};
    }
    std::string how_it_ended() override {
        return failure_ == 0 ? "closed the connection" : "was lost (" + failure_text(failure_) + ")";
    }

private:
    Descriptor socket_;
    int failure_ = 0;
};

struct Address {
    ::sockaddr_storage bytes = {};
    ::socklen_t length = 0;
};
Result<Address> read_address(const std::string& words) {
    const Error wrong =
        usage_error("tcp://" + printable(words) +
                    ": right would be an address in numbers or localhost, and a port, such as "
                    "tcp://192.168.0.5:7000 or tcp://[::1]:7000");
    const std::size_t colon = words.rfind(':');
    if (colon == std::string::npos || colon + 1 == words.size()) return wrong;
    std::string host = words.substr(0, colon);
    const std::string port = words.substr(colon + 1);
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
    if (host == "localhost") host = "127.0.0.1";
    if (host.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos ||
        std::stoi(port) < 1 || std::stoi(port) > 65535)
        return wrong;
    Address address;
    const auto port_there = htons(static_cast<std::uint16_t>(std::stoi(port)));
    if (::sockaddr_in four = {}; ::inet_pton(AF_INET, host.c_str(), &four.sin_addr) == 1) {
        four.sin_family = AF_INET;
        four.sin_port = port_there;
        std::memcpy(&address.bytes, &four, address.length = sizeof four);
        return address;
    }
    ::sockaddr_in6 six = {};
    if (::inet_pton(AF_INET6, host.c_str(), &six.sin6_addr) != 1) return wrong;
    six.sin6_family = AF_INET6;
    six.sin6_port = port_there;
    std::memcpy(&address.bytes, &six, address.length = sizeof six);
    return address;
}

/// 0, or why there is no connection.
Result<int> wait_for_connection(int socket) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    constexpr int look_again_ms = 100;
    while (std::chrono::steady_clock::now() < until) {
        if (stop_requested()) return interrupted_error();
        pollfd waited{socket, POLLOUT, 0};
        if (::poll(&waited, 1, look_again_ms) <= 0) continue;
        int failure = 0;
        ::socklen_t length = sizeof failure;
        return ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &failure, &length) == 0 ? failure : errno;
    }
    return ETIMEDOUT;
}

}  // namespace

Result<std::unique_ptr<LiveBytes>> start_command(const std::string& command) {
    TRY_ASSIGN(auto output, make_pipe());
    TRY_ASSIGN(auto errors, make_pipe());
    constexpr int roomy = 1 << 20;
    (void)::fcntl(output.in.get(), F_SETPIPE_SZ, roomy);  // otherwise what it is
    ::posix_spawn_file_actions_t files;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&files, output.in.get(), STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, errors.in.get(), STDERR_FILENO);
    ::posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    ::posix_spawnattr_t attributes;
    ::posix_spawnattr_init(&attributes);
    sigset_t none, all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    ::posix_spawnattr_setflags(&attributes,
                               POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    std::string shell = "sh", option = "-c", words = command;
    char* const arguments[] = {shell.data(), option.data(), words.data(), nullptr};
    ::pid_t process = -1;
    const int failure = ::posix_spawn(&process, "/bin/sh", &files, &attributes, arguments, ::environ);
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
    if (failure != 0)
        return input_error("pipe:" + printable(command) + ": cannot be started: " + failure_text(failure));
    return std::unique_ptr<LiveBytes>(
        std::make_unique<Command>(process, std::move(output.out), std::move(errors.out)));
}

Result<void> check_address(const std::string& address) {
    const auto read = read_address(address);
    return read ? Result<void>() : read.error();
}

Result<std::unique_ptr<LiveBytes>> connect_to(const std::string& address) {
    TRY_ASSIGN(const auto read, read_address(address));
    Descriptor socket(::socket(read.bytes.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    const auto no_connection = [&](int failure) {
        return input_error("tcp://" + address + ": no connection: " + failure_text(failure) +
                           "; does the sender listen there?");
    };
    if (socket.get() < 0) return no_connection(errno);
    const auto* const to = reinterpret_cast<const ::sockaddr*>(&read.bytes);
    if (::connect(socket.get(), to, read.length) != 0 && errno != EINPROGRESS) return no_connection(errno);
    TRY_ASSIGN(const auto failure, wait_for_connection(socket.get()));
    if (failure != 0) return no_connection(failure);
    return std::unique_ptr<LiveBytes>(std::make_unique<Connection>(std::move(socket)));
}

}  // namespace touchable
