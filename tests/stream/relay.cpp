// SPDX-License-Identifier: Apache-2.0
#include "tests/stream/relay.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <deque>
#include <list>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "engine/clip/readers.hpp"
#include "tests/unused_port.hpp"

namespace touchable::test {
namespace {

using Clock = std::chrono::steady_clock;

const sockaddr* plain(const sockaddr_in& address) {
    return reinterpret_cast<const sockaddr*>(&address);
}

Descriptor new_socket(int type) {
    return Descriptor(::socket(AF_INET, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

/// Decides what is lost, by a chain of two states, and when the rest arrives.
class Faults {
public:
    explicit Faults(const NetworkFaults& faults) : faults_(faults), random_(faults.seed) {}
    bool loses() {
        const double ends = 1 / std::max(1.0, faults_.burst);
        const double begins = ends * faults_.loss / (1 - faults_.loss);
        is_losing_ = even_(random_) < (is_losing_ ? 1 - ends : begins);
        return is_losing_;
    }
    /// How long a datagram waits in front of a narrow link; nothing: there is no room for it.
    std::optional<double> queued_ms(Clock::time_point now, std::size_t bytes) {
        if (faults_.bytes_per_second <= 0) return 0;
        constexpr std::chrono::seconds longest{2};
        const std::chrono::duration<double> takes(static_cast<double>(bytes) / faults_.bytes_per_second);
        const auto leaves = std::max(link_is_free_, now) + std::chrono::duration_cast<Clock::duration>(takes);
        if (leaves - now > longest) return std::nullopt;
        link_is_free_ = leaves;
        return std::chrono::duration<double, std::milli>(leaves - now).count();
    }
    /// Not before what was sent earlier.
    Clock::time_point arrival(Clock::time_point sent, double further_ms = 0) {
        const double ms = faults_.delay_ms + further_ms + faults_.jitter_ms * even_(random_);
        last_ = std::max(last_, sent + std::chrono::microseconds(static_cast<std::int64_t>(1000 * ms)));
        return last_;
    }
    double retransmission_ms() const { return 2 * faults_.delay_ms + 10; }

private:
    NetworkFaults faults_;
    std::mt19937_64 random_;
    std::uniform_real_distribution<double> even_{0, 1};
    bool is_losing_ = false;
    Clock::time_point last_{}, link_is_free_{};
};

struct OnTheWay {
    Clock::time_point arrives;
    std::vector<char> bytes;
    std::size_t sent = 0;
};

/// From one socket to another.
struct Direction {
    explicit Direction(const NetworkFaults& with) : faults(with) {}
    Faults faults;
    std::deque<OnTheWay> on_the_way;
    std::size_t bytes = 0;   // on the way
    bool has_ended = false;  // no more is sent into it
};

class ThreadedRelay : public Relay {
public:
    int port() const override { return port_; }
    void stall(bool is_stalled) override { stalled_ = is_stalled; }
    void cut() override { cutting_ = true; }
    std::int64_t passed() const override { return passed_; }
    std::int64_t lost() const override { return lost_; }

protected:
    ThreadedRelay(int target_port, const NetworkFaults& faults)
        : faults_(faults), target_port_(target_port) {}
    Result<void> begin(int type) {
        own_ = new_socket(type);
        const sockaddr_in any = loopback(0);
        sockaddr_in bound{};
        socklen_t size = sizeof bound;
        if (::bind(own_.get(), plain(any), sizeof any) != 0 ||
            (type == SOCK_STREAM && ::listen(own_.get(), 64) != 0) ||
            ::getsockname(own_.get(), reinterpret_cast<sockaddr*>(&bound), &size) != 0)
            return Error{ErrorKind::internal,
                         "a relay cannot listen: " + std::generic_category().message(errno)};
        port_ = ntohs(bound.sin_port);
        thread_ = std::jthread([this](const std::stop_token& ended) {
            while (!ended.stop_requested()) turn();
        });
        return {};
    }
    void end() {
        thread_.request_stop();
        if (thread_.joinable()) thread_.join();
    }
    virtual void turn() = 0;

    const NetworkFaults faults_;
    const int target_port_;
    Descriptor own_;
    std::atomic<bool> stalled_{false}, cutting_{false};
    std::atomic<std::int64_t> passed_{0}, lost_{0};

private:
    int port_ = 0;
    std::jthread thread_;
};

/// Bytes that may be read at once, and that may wait on the way.
constexpr std::size_t chunk_bytes = 1U << 16, most_on_the_way = 1U << 20;

class TcpRelay final : public ThreadedRelay {
public:
    TcpRelay(int target_port, const NetworkFaults& faults) : ThreadedRelay(target_port, faults) {}
    ~TcpRelay() override { end(); }
    Result<void> open() { return begin(SOCK_STREAM); }

private:
    struct Connection {
        Connection(Descriptor client, Descriptor server, const NetworkFaults& faults)
            : ends{std::move(client), std::move(server)}, ways{Direction(faults), Direction(faults)} {}
        Descriptor ends[2];
        Direction ways[2];  // from end k to the other
        bool is_broken = false;
    };

    void accept_one() {
        Descriptor client(::accept4(own_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
        if (client.get() < 0) return;
        Descriptor server = new_socket(SOCK_STREAM);
        const int at_once = 1;
        for (const Descriptor* const end : {&client, &server})
            ::setsockopt(end->get(), IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once);
        const sockaddr_in target = loopback(target_port_);
        if (::connect(server.get(), plain(target), sizeof target) != 0 && errno != EINPROGRESS) return;
        connections_.emplace_back(std::move(client), std::move(server), faults_);
    }

    void take(Connection& connection, int from) {
        Direction& way = connection.ways[from];
        if (way.has_ended || way.bytes > most_on_the_way) return;
        std::vector<char> bytes(chunk_bytes);
        const ssize_t got = ::recv(connection.ends[from].get(), bytes.data(), bytes.size(), 0);
        if (got < 0) {
            connection.is_broken |= errno != EAGAIN && errno != EINTR && errno != ENOTCONN;
            return;
        }
        bytes.resize(static_cast<std::size_t>(got));
        way.has_ended = got == 0;
        constexpr std::size_t segment_bytes = 1448;
        double further_ms = 0;
        for (std::size_t k = 0; k < bytes.size(); k += segment_bytes)
            if (way.faults.loses()) {
                further_ms += way.faults.retransmission_ms();
                ++lost_;
            }
        ++passed_;
        way.bytes += bytes.size();
        way.on_the_way.push_back({way.faults.arrival(Clock::now(), further_ms), std::move(bytes)});
    }

    void give(Connection& connection, int from) {
        Direction& way = connection.ways[from];
        const int to = connection.ends[1 - from].get();
        while (!way.on_the_way.empty() && way.on_the_way.front().arrives <= Clock::now()) {
            OnTheWay& next = way.on_the_way.front();
            const std::size_t left = next.bytes.size() - next.sent;
            const ssize_t given =
                left > 0 ? ::send(to, next.bytes.data() + next.sent, left, MSG_NOSIGNAL) : 0;
            if (given < 0) {
                connection.is_broken |= errno != EAGAIN && errno != EINTR && errno != ENOTCONN;
                return;
            }
            next.sent += static_cast<std::size_t>(given);
            if (next.sent < next.bytes.size()) return;
            if (next.bytes.empty()) ::shutdown(to, SHUT_WR);
            way.bytes -= next.bytes.size();
            way.on_the_way.pop_front();
        }
    }

    void turn() override {
        if (cutting_.exchange(false)) connections_.clear();
        std::vector<pollfd> all{{own_.get(), POLLIN, 0}};
        for (const Connection& connection : connections_)
            for (const int k : {0, 1}) {
                const Direction& way = connection.ways[k];
                const bool reads = !stalled_ && !way.has_ended && way.bytes <= most_on_the_way;
                all.push_back({connection.ends[k].get(), static_cast<short>(reads ? POLLIN : 0), 0});
            }
        (void)::poll(all.data(), all.size(), 1);
        if ((all[0].revents & POLLIN) != 0) accept_one();
        if (stalled_) return;
        for (Connection& connection : connections_)
            for (const int k : {0, 1}) {
                take(connection, k);
                give(connection, k);
            }
        connections_.remove_if([](const Connection& connection) {
            const auto is_over = [](const Direction& way) { return way.has_ended && way.on_the_way.empty(); };
            return connection.is_broken || (is_over(connection.ways[0]) && is_over(connection.ways[1]));
        });
    }

    std::list<Connection> connections_;
};

class UdpRelay final : public ThreadedRelay {
public:
    UdpRelay(int target_port, const NetworkFaults& faults) : ThreadedRelay(target_port, faults) {}
    ~UdpRelay() override { end(); }
    Result<void> open() { return begin(SOCK_DGRAM); }

private:
    struct Path {
        Path(sockaddr_in from, Descriptor to, const NetworkFaults& faults)
            : client(from), server(std::move(to)), ways{Direction(faults), Direction(faults)} {}
        sockaddr_in client;
        Descriptor server;
        Direction ways[2];  // to the server, and back
    };

    Path* path_of(const sockaddr_in& client) {
        for (Path& path : paths_)
            if (path.client.sin_port == client.sin_port) return &path;
        Descriptor server = new_socket(SOCK_DGRAM);
        const sockaddr_in target = loopback(target_port_);
        const int bytes = 1 << 22;
        ::setsockopt(server.get(), SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
        if (::connect(server.get(), plain(target), sizeof target) != 0) return nullptr;
        return &paths_.emplace_back(client, std::move(server), faults_);
    }

    void send_on(Direction& way, const char* bytes, ssize_t size) {
        const auto now = Clock::now();
        const auto queued_ms = stalled_ || way.faults.loses()
                                   ? std::nullopt
                                   : way.faults.queued_ms(now, static_cast<std::size_t>(size));
        if (!queued_ms) {
            ++lost_;
            return;
        }
        ++passed_;
        way.on_the_way.push_back(
            {way.faults.arrival(now, *queued_ms), std::vector<char>(bytes, bytes + size)});
    }

    void take() {
        char bytes[chunk_bytes];
        sockaddr_in client{};
        socklen_t size = sizeof client;
        ssize_t got;
        while ((got = ::recvfrom(own_.get(), bytes, sizeof bytes, 0, reinterpret_cast<sockaddr*>(&client),
                                 &size)) >= 0)
            if (Path* const path = path_of(client)) send_on(path->ways[0], bytes, got);
        for (Path& path : paths_)
            while ((got = ::recv(path.server.get(), bytes, sizeof bytes, 0)) >= 0)
                send_on(path.ways[1], bytes, got);
    }

    void turn() override {
        if (cutting_.exchange(false)) paths_.clear();
        std::vector<pollfd> all{{own_.get(), POLLIN, 0}};
        for (const Path& path : paths_) all.push_back({path.server.get(), POLLIN, 0});
        (void)::poll(all.data(), all.size(), 1);
        take();
        const auto give = [](Direction& way, const auto& send) {
            while (!way.on_the_way.empty() && way.on_the_way.front().arrives <= Clock::now()) {
                send(way.on_the_way.front().bytes);
                way.on_the_way.pop_front();
            }
        };
        for (Path& path : paths_) {
            give(path.ways[0], [&](const std::vector<char>& bytes) {
                (void)::send(path.server.get(), bytes.data(), bytes.size(), 0);
            });
            give(path.ways[1], [&](const std::vector<char>& bytes) {
                (void)::sendto(own_.get(), bytes.data(), bytes.size(), 0, plain(path.client),
                               sizeof path.client);
            });
        }
    }

    std::list<Path> paths_;
};

template <class Opened>
Result<std::unique_ptr<Relay>> opened(int target_port, const NetworkFaults& faults) {
    auto relay = std::make_unique<Opened>(target_port, faults);
    if (auto open = relay->open(); !open) return open.error();
    return std::unique_ptr<Relay>(std::move(relay));
}

}  // namespace

Result<std::unique_ptr<Relay>> Relay::open(Kind kind, int target_port, const NetworkFaults& faults) {
    return kind == Kind::tcp ? opened<TcpRelay>(target_port, faults) : opened<UdpRelay>(target_port, faults);
}

}  // namespace touchable::test
