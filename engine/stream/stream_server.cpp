#include "engine/stream/stream_server.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"
#include "engine/stream/socket_address.hpp"

namespace touchable {
namespace {

std::string_view scheme_words(const StreamUrl& url) {
    return url.transport == StreamTransport::http ? "http://" : "tcp://";
}

void set_option(int socket, int level, int option, int value) {
    (void)::setsockopt(socket, level, option, &value, sizeof value);
}

/// What waits in the kernel cannot be left out any more, and is late: little does.
void make_prompt(int socket) {
    constexpr int unsent_bytes = 1 << 17, lost_after_ms = 10'000;
    set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
    set_option(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, unsent_bytes);
    set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, lost_after_ms);
}

}  // namespace

StreamServer::Clock StreamServer::steady_clock() {
    return
        [] { return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count(); };
}

Result<std::unique_ptr<StreamServer>> StreamServer::open(const std::vector<StreamUrl>& urls, StreamRing& ring,
                                                         StreamAudience& audience, Clock clock) {
    auto server = std::unique_ptr<StreamServer>(new StreamServer(ring, audience, std::move(clock)));
    if (server->wake_->descriptor() < 0)
        return Error{ErrorKind::internal, "the system has no descriptor left to wake the server with"};
    for (const StreamUrl& url : urls) TRY(server->open_door(url));
    ring.watch([wake = server->wake_] { wake->wake(); });
    return server;
}

Result<void> StreamServer::open_door(const StreamUrl& url) {
    const auto address = own_address(url);
    if (!address)
        return usage_error(in_quotes(url.name()) +
                           ": right would be an address of this machine in numbers, such as " +
                           std::string(scheme_words(url)) + "0.0.0.0:7000 for all of them");
    Door door{
        OwnedSocket(::socket(address->storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
        url};
    const int socket = door.socket.get();
    set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
    constexpr int most_waiting = 64;
    if (socket < 0 || ::bind(socket, address->get(), address->length) != 0 ||
        ::listen(socket, most_waiting) != 0)
        return input_error(printable(url.text) +
                           ": cannot listen there: " + std::generic_category().message(errno));
    doors_.push_back(std::move(door));
    return {};
}

StreamServer::~StreamServer() {
    stop_ = true;
    wake_->wake();
    if (thread_.joinable()) thread_.join();
}

std::vector<std::string> StreamServer::addresses() const {
    std::vector<std::string> all;
    for (const Door& door : doors_) {
        SocketAddress address;
        address.length = sizeof address.storage;
        (void)::getsockname(door.socket.get(), reinterpret_cast<sockaddr*>(&address.storage),
                            &address.length);
        all.push_back(std::string(scheme_words(door.url)) + address.text() + door.url.path);
    }
    return all;
}

Result<void> StreamServer::start() {
    return start_thread(thread_, "stream-server", "that sends a stream to its listeners", [this] {
        constexpr std::chrono::milliseconds a_while{1000};
        while (!stop_) turn(a_while);
    });
}

int StreamServer::timeout_ms(std::chrono::milliseconds longest, std::int64_t now_ns) const {
    std::int64_t until_ns = now_ns + std::chrono::nanoseconds(longest).count();
    for (const auto& listener : listeners_) until_ns = std::min(until_ns, listener->deadline_ns());
    if (doors_closed_until_ns_ > now_ns) until_ns = std::min(until_ns, doors_closed_until_ns_);
    constexpr std::int64_t ns_per_ms = 1'000'000;
    return static_cast<int>((std::max<std::int64_t>(until_ns - now_ns, 0) + ns_per_ms - 1) / ns_per_ms);
}

void StreamServer::turn(std::chrono::milliseconds longest) {
    std::int64_t now_ns = clock_();
    std::vector<pollfd> looks{{wake_->descriptor(), POLLIN, 0}};
    const auto door_events = static_cast<short>(now_ns >= doors_closed_until_ns_ ? POLLIN : 0);
    for (const Door& door : doors_) looks.push_back({door.socket.get(), door_events, 0});
    for (const auto& listener : listeners_) looks.push_back({listener->socket(), listener->events(), 0});
    if (::poll(looks.data(), looks.size(), timeout_ms(longest, now_ns)) < 0 || stop_) return;
    if (looks.front().revents != 0) wake_->forget();
    now_ns = clock_();
    auto look = looks.begin() + 1 + std::ssize(doors_);
    for (const auto& listener : listeners_) {
        const int seen = (look++)->revents;
        listener->go_on((seen & (POLLIN | POLLHUP | POLLERR)) != 0, (seen & (POLLOUT | POLLERR)) != 0,
                        now_ns);
    }
    for (std::size_t k = 0; k < doors_.size(); ++k)
        if ((looks[k + 1].revents & POLLIN) != 0) accept_from(doors_[k]);
    std::erase_if(listeners_, [](const auto& listener) { return listener->is_over(); });
    connections_ = static_cast<int>(listeners_.size());
}

void StreamServer::accept_from(const Door& door) {
    constexpr int most_at_once = 16;
    for (int k = 0; k < most_at_once; ++k) {
        SocketAddress address;
        address.length = sizeof address.storage;
        OwnedSocket socket(::accept4(door.socket.get(), reinterpret_cast<sockaddr*>(&address.storage),
                                     &address.length, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (socket.get() < 0) {
            // Of no descriptors or no memory left, poll would tell at once again and again.
            constexpr std::int64_t rest_ns = 100'000'000;
            const bool is_full = errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
            if (is_full) doors_closed_until_ns_ = clock_() + rest_ns;
            return;
        }
        const std::string name = std::string(scheme_words(door.url)) + address.text();
        const bool is_http = door.url.transport == StreamTransport::http;
        if (std::ssize(listeners_) >= most_connections || (!is_http && !audience_.has_room())) {
            refuse(socket, door, name);
            continue;
        }
        make_prompt(socket.get());
        const auto path = is_http ? std::optional(door.url.path) : std::nullopt;
        const std::int64_t now_ns = clock_();
        auto& listener = listeners_.emplace_back(
            std::make_unique<StreamListener>(std::move(socket), name, path, ring_, audience_, now_ns));
        listener->go_on(false, false, now_ns);
    }
}

/// A refused connection gets one line that says why. The person at this server reads one at most every 10 s,
/// however many connect.
void StreamServer::refuse(const OwnedSocket& socket, const Door& door, const std::string& name) {
    const bool has_room = audience_.has_room();  // but too many connect that do not listen
    const std::string there = has_room ? std::to_string(most_connections) + " connections"
                                       : std::to_string(StreamAudience::most_listeners) + " listeners";
    const std::string answer =
        door.url.transport == StreamTransport::http
            ? http_answer(503)
            : std::string(stream_refusal) + "there are " + there + " already; try again later\n";
    (void)::send(socket.get(), answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    constexpr std::int64_t silence_ns = 10'000'000'000;
    const std::int64_t now_ns = clock_();
    if (now_ns < next_refusal_said_ns_) return;
    next_refusal_said_ns_ = now_ns + silence_ns;
    audience_.remark(name + " is refused: there are " + there + ", which is as many as there may be");
}

}  // namespace touchable
