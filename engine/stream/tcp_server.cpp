// SPDX-License-Identifier: Apache-2.0
// StreamServer: one thread that polls the sockets it listens at ("doors") and all connections. It never waits
// for a client: bytes that a socket does not take at once are sent when poll reports room.

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <limits>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/readers.hpp"
#include "engine/stream/listeners.hpp"
#include "engine/stream/sending.hpp"
#include "engine/stream/stream_bytes.hpp"

namespace touchable {
namespace {

constexpr std::int64_t no_deadline = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t longest_farewell_ns = 1'000'000'000;

std::string_view scheme_words(const StreamUrl& url) {
    return url.transport == StreamTransport::http ? "http://" : "tcp://";
}

void set_option(int socket, int level, int option, int value) {
    (void)::setsockopt(socket, level, option, &value, sizeof value);
}

/// Framesets that wait in the kernel are late and can no longer be left out, so few may wait there.
void make_prompt(int socket) {
    constexpr int unsent_bytes = 1 << 17, lost_after_ms = 10'000;
    set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
    set_option(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, unsent_bytes);
    set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, lost_after_ms);
}

/// One connection: a client requests the stream (HTTP), gets it, and leaves. Never waits. Times are of the
/// server's clock, ns.
class TcpListener : NonCopyable {
public:
    /// `path`: of the stream over HTTP; nothing: the stream is sent at once, and the audience has room for
    /// it. Over HTTP a client is refused if there is no room. `page`: folders of files beside the stream. The
    /// socket is non-blocking.
    TcpListener(Descriptor socket, std::string name, const std::optional<std::string>& path,
                std::span<const std::filesystem::path> page, const StreamRing& ring, StreamAudience& audience,
                std::int64_t now_ns)
        : socket_(std::move(socket)),
          name_(std::move(name)),
          page_(page),
          ring_(ring),
          audience_(audience),
          deadline_ns_(now_ns + StreamListener::longest_request_ns) {
        if (path)
            request_.emplace(*path);
        else
            begin(now_ns);
    }

    ~TcpListener() { end("is cut off"); }

    int socket() const { return socket_.get(); }
    /// Events for poll.
    short events() const {
        return static_cast<short>((hears_no_more_ ? 0 : POLLIN) | (is_blocked_ ? POLLOUT : 0));
    }

    /// Reads, if poll says so, and sends what there is.
    void go_on(bool has_something, bool takes_something, std::int64_t now_ns) {
        if (has_something) read(now_ns);
        if (takes_something) is_blocked_ = false;
        if (!is_blocked_) write(now_ns);
        if (phase_ == Phase::over || now_ns < deadline_ns_) return;
        end(phase_ == Phase::listens ? "took no whole frameset for 10 s" : "");
    }

    /// When it is closed if nothing happens before that.
    std::int64_t deadline_ns() const { return deadline_ns_; }
    /// Whether it can be removed.
    bool is_over() const { return phase_ == Phase::over; }

private:
    enum class Phase { asks, is_answered, listens, leaves, over };
    void read(std::int64_t now_ns) {
        std::array<char, 4096> bytes;
        const auto got = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (got < 0 && would_wait(errno)) return;
        if (got < 0) return end("is lost (" + failure_words(errno) + ")");
        if (got == 0) {
            // A client that sends nothing more may still listen, unless it never got anything.
            hears_no_more_ = true;
            const bool has_begun = phase_ == Phase::listens && has_header_;
            if (!has_begun && phase_ != Phase::is_answered) end("has gone");
            return;
        }
        const auto count = static_cast<std::size_t>(got);
        if (phase_ == Phase::asks) {
            request_->take({bytes.data(), count});
            if (request_->status() != 0) answer(now_ns);
            return;
        }
        heard_bytes_ += count;
        if (heard_bytes_ > StreamListener::most_heard_bytes) end("sends, but a listener has nothing to send");
    }

    void write(std::int64_t now_ns) {
        while (phase_ == Phase::listens || phase_ == Phase::is_answered) {
            if (rest_.empty() && !take_piece(now_ns)) return;
            const auto done = ::send(socket_.get(), rest_.data(), rest_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
            if (done >= 0) {
                rest_ = rest_.subspan(static_cast<std::size_t>(done));
                // Between two pieces of a file it is the other clients' turn.
                is_blocked_ = phase_ == Phase::is_answered;
                if (is_blocked_) return;
                continue;
            }
            if (!would_wait(errno))
                return end(errno == EPIPE || errno == ECONNRESET ? "has gone"
                                                                 : "is lost (" + failure_words(errno) + ")");
            is_blocked_ = true;
            // Only a stream without a page has colour that can be left out.
            if (phase_ == Phase::listens && page_.empty() && ring_.has_next(cursor_) &&
                narrow_.is_behind(now_ns) && !std::exchange(is_said_, true))
                audience_.goes_without_colour(name_);
            return;
        }
    }

    /// Takes the next piece, after all of the last one was sent; false: there is none.
    bool take_piece(std::int64_t now_ns) {
        sent_ += is_frameset_ ? 1 : 0;
        is_frameset_ = false;
        piece_.reset();
        deadline_ns_ = no_deadline;
        if (phase_ == Phase::is_answered) {
            if (!read_piece()) {
                leave(now_ns);
                return false;
            }
        } else if (!has_header_) {
            const auto header = ring_.header();
            if (!header) return false;
            has_header_ = true;
            piece_ = header;
            rest_ = *header;
        } else if (const auto block = ring_.next(cursor_)) {
            is_frameset_ = true;
            piece_ = block;
            rest_ = block->given(narrow_.gives_colour(block->is_key, now_ns));
            without_colour_ += rest_.size() < block->bytes.size() ? 1 : 0;
        } else {
            narrow_.has_caught_up();
            if (ring_.is_over(cursor_)) leave(now_ns);
            return false;
        }
        deadline_ns_ = now_ns + StreamListener::longest_piece_ns;
        return true;
    }

    /// Reads more of the file that was requested. False: it is over, or shorter than it was.
    bool read_piece() {
        constexpr std::uint64_t most_bytes = 1 << 16;
        const auto bytes =
            std::make_shared<std::vector<std::uint8_t>>(std::min(most_bytes, file_.end - file_.at));
        const auto got =
            ::pread(file_.file.get(), bytes->data(), bytes->size(), static_cast<off_t>(file_.at));
        if (got <= 0) return false;
        file_.at += static_cast<std::uint64_t>(got);
        rest_ = std::span(*bytes).first(static_cast<std::size_t>(got));
        piece_ = bytes;
        return true;
    }

    void answer(std::int64_t now_ns) {
        int status = request_->status();
        if (status == 200 && !request_->is_head() && !audience_.has_room()) status = 503;
        if (status == 404 && !page_.empty())
            file_ = served_file(*request_, page_);
        else
            file_.head =
                page_.empty() ? http_answer(status) : http_answer(status, "application/octet-stream");
        if (request_->is_head()) file_.head.resize(file_.head.find("\r\n\r\n") + 4);
        rest_ = {reinterpret_cast<const std::uint8_t*>(file_.head.data()), file_.head.size()};
        if (status == 200 && !request_->is_head()) return begin(now_ns);
        phase_ = Phase::is_answered;
        deadline_ns_ = now_ns + StreamListener::longest_request_ns;
    }

    void begin(std::int64_t now_ns) {
        phase_ = Phase::listens;
        deadline_ns_ = rest_.empty() ? no_deadline : now_ns + StreamListener::longest_piece_ns;
        cursor_ = ring_.join();
        audience_.came(name_);
    }

    /// Waits before closing: sent bytes are still under way, and closing a socket with unread data loses
    /// them.
    void leave(std::int64_t now_ns) {
        if (phase_ == Phase::listens) audience_.went({name_, sent_, cursor_.dropped(), without_colour_});
        ::shutdown(socket_.get(), SHUT_WR);
        phase_ = hears_no_more_ ? Phase::over : Phase::leaves;
        deadline_ns_ = now_ns + longest_farewell_ns;
    }

    void end(const std::string& why) {
        if (phase_ == Phase::listens) audience_.went({name_, sent_, cursor_.dropped(), without_colour_, why});
        phase_ = Phase::over;
    }

    Descriptor socket_;
    const std::string name_;
    const std::span<const std::filesystem::path> page_;
    const StreamRing& ring_;
    StreamAudience& audience_;
    std::optional<HttpRequest> request_;
    ServedFile file_;  // the answer; of the stream, its head
    Phase phase_ = Phase::asks;
    StreamRing::Cursor cursor_;
    bool has_header_ = false, is_blocked_ = false, hears_no_more_ = false;
    std::size_t heard_bytes_ = 0;  // received, though a listener has nothing to send
    NarrowLink narrow_;
    bool is_said_ = false;  // the loss of its colour was reported
    std::int64_t sent_ = 0, without_colour_ = 0;
    std::int64_t deadline_ns_;
    // The piece that is being sent.
    std::shared_ptr<const void> piece_;
    std::span<const std::uint8_t> rest_;
    bool is_frameset_ = false;
};

/// StreamServer, with its own thread or turn by turn.
class TcpServer final : public StreamServer {
public:
    TcpServer(StreamRing& ring, StreamAudience& audience, Clock clock, Page page)
        : ring_(ring), audience_(audience), clock_(std::move(clock)), page_(std::move(page)) {}
    ~TcpServer() override {
        stop_ = true;
        wake_->wake();
        if (thread_.joinable()) thread_.join();
    }

    Result<void> open(const std::vector<StreamUrl>& urls) {
        if (wake_->descriptor() < 0)
            return Error{ErrorKind::internal, "the system has no descriptor left to wake the server with"};
        for (const StreamUrl& url : urls) TRY(open_door(url));
        ring_.watch([wake = wake_] { wake->wake(); });
        return {};
    }

    std::vector<std::string> addresses() const override {
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

    Result<void> start() override {
        return start_thread(thread_, "stream-server", "that sends a stream to its listeners", [this] {
            constexpr std::chrono::milliseconds a_while{1000};
            while (!stop_) turn(a_while);
        });
    }

    void turn(std::chrono::milliseconds longest) override {
        std::int64_t now_ns = clock_();
        std::vector<pollfd> looks{{wake_->descriptor(), POLLIN, 0}};
        const bool is_open = now_ns >= doors_closed_until_ns_ && !has_to_wait();
        const auto door_events = static_cast<short>(is_open ? POLLIN : 0);
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

    int connections() const override { return connections_; }

private:
    struct Door {
        Descriptor socket;
        StreamUrl url;
    };
    Result<void> open_door(const StreamUrl& url) {
        const auto address = own_address(url);
        if (!address)
            return usage_error(in_quotes(url.name()) +
                               ": must be an address of this machine in numbers, such as " +
                               std::string(scheme_words(url)) + "0.0.0.0:7000 for all of them");
        Door door{
            Descriptor(::socket(address->storage.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
            url};
        const int socket = door.socket.get();
        set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
        constexpr int most_waiting = 64;
        if (socket < 0 || ::bind(socket, address->get(), address->length) != 0 ||
            ::listen(socket, most_waiting) != 0)
            return input_error(printable(url.text) + ": cannot listen there: " + failure_words(errno));
        doors_.push_back(std::move(door));
        return {};
    }

    /// Whether new connections wait until others have ended: a browser's short ones, for the files of a page,
    /// are not refused.
    bool has_to_wait() const { return !page_.empty() && std::ssize(listeners_) >= most_connections; }

    void accept_from(const Door& door) {
        constexpr int most_at_once = 16;
        for (int k = 0; k < most_at_once && !has_to_wait(); ++k) {
            SocketAddress address;
            address.length = sizeof address.storage;
            Descriptor socket(::accept4(door.socket.get(), reinterpret_cast<sockaddr*>(&address.storage),
                                        &address.length, SOCK_NONBLOCK | SOCK_CLOEXEC));
            if (socket.get() < 0) {
                // While descriptors or memory are exhausted, poll would return at once again and again.
                constexpr std::int64_t rest_ns = 100'000'000;
                const bool is_full =
                    errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
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
            auto& listener = listeners_.emplace_back(std::make_unique<TcpListener>(
                std::move(socket), name, path, page_, ring_, audience_, now_ns));
            listener->go_on(false, false, now_ns);
        }
    }

    /// Sends a refused connection one line with the reason. Reports a refusal at most every 10 s, however
    /// many connect.
    void refuse(const Descriptor& socket, const Door& door, const std::string& name) {
        const bool has_room = audience_.has_room();  // true: too many connections that do not listen
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

    int timeout_ms(std::chrono::milliseconds longest, std::int64_t now_ns) const {
        std::int64_t until_ns = now_ns + std::chrono::nanoseconds(longest).count();
        for (const auto& listener : listeners_) until_ns = std::min(until_ns, listener->deadline_ns());
        if (doors_closed_until_ns_ > now_ns) until_ns = std::min(until_ns, doors_closed_until_ns_);
        constexpr std::int64_t ns_per_ms = 1'000'000;
        return static_cast<int>((std::max<std::int64_t>(until_ns - now_ns, 0) + ns_per_ms - 1) / ns_per_ms);
    }

    StreamRing& ring_;
    StreamAudience& audience_;
    const Clock clock_;
    const Page page_;
    std::shared_ptr<Wake> wake_ = std::make_shared<Wake>();  // shared with the ring
    std::vector<Door> doors_;
    std::vector<std::unique_ptr<TcpListener>> listeners_;
    std::atomic<int> connections_{0};
    std::int64_t doors_closed_until_ns_ = 0, next_refusal_said_ns_ = 0;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<StreamServer>> StreamServer::open(const std::vector<StreamUrl>& urls, StreamRing& ring,
                                                         StreamAudience& audience, Clock clock, Page page) {
    return opened_as<StreamServer>(
        std::make_unique<TcpServer>(ring, audience, clock ? std::move(clock) : steady_now_ns,
                                    std::move(page)),
        urls);
}

}  // namespace touchable
