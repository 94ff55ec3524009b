// SPDX-License-Identifier: Apache-2.0
#include "device/drivers/inverse3_device.hpp"

#include <libwebsockets.h>
#include <poll.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <deque>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using ServiceClock = std::chrono::steady_clock;

constexpr std::size_t longest_http_body = 64 * 1024;
constexpr std::size_t most_unread_messages = 1024;
constexpr milliseconds longest_write{50};
const std::string no_answer = "no answer";

/// One connection, in its own context.
struct ServiceLine {
    enum class State { opening, open, finished, failed };
    State state = State::opening;
    std::string failure;
    unsigned http_status = 0;
    std::string coming;  // part of an incomplete message, or of a body
    std::deque<std::string> messages;
    std::vector<unsigned char> going;  // message to send, after room for the frame's head; empty: none
    std::uint64_t events = 0;          // number of events so far

    void fail(std::string why) {
        if (state == State::failed) return;
        state = State::failed;
        failure = std::move(why);
    }
    bool take(const void* bytes, std::size_t count, std::size_t most) {
        if (coming.size() + count > most) {
            fail("it sent more than " + std::to_string(most) + " bytes at once");
            return false;
        }
        coming.append(static_cast<const char*>(bytes), count);
        return true;
    }
};

int write_to_service(lws* connection, ServiceLine& line) {
    if (line.going.empty()) return 0;
    const std::size_t count = line.going.size() - LWS_PRE;
    const int written = lws_write(connection, line.going.data() + LWS_PRE, count, LWS_WRITE_TEXT);
    line.going.clear();
    if (written >= static_cast<int>(count)) return 0;
    line.fail("it takes nothing any more");
    return -1;
}

/// Callback of libwebsockets. Not 0: close the connection.
int on_service_event(lws* connection, lws_callback_reasons reason, void*, void* in, std::size_t count) {
    auto* const known = static_cast<ServiceLine*>(lws_context_user(lws_get_context(connection)));
    if (!known) return 0;
    ServiceLine& line = *known;
    switch (reason) {
        case LWS_CALLBACK_CLIENT_CONNECTION_ERROR:
            line.fail(in ? printable({static_cast<const char*>(in), count}) : "no connection");
            break;
        case LWS_CALLBACK_CLIENT_ESTABLISHED:
            line.state = ServiceLine::State::open;
            break;
        case LWS_CALLBACK_CLIENT_RECEIVE:
            if (!line.take(in, count, LocalHaplyService::longest_message)) return -1;
            if (!lws_is_final_fragment(connection) || lws_remaining_packet_payload(connection) > 0) break;
            if (line.messages.size() >= most_unread_messages) {
                line.fail("it sent a thousand messages that were not asked for");
                return -1;
            }
            line.messages.push_back(std::exchange(line.coming, {}));
            break;
        case LWS_CALLBACK_CLIENT_WRITEABLE:
            return write_to_service(connection, line);
        case LWS_CALLBACK_CLIENT_CLOSED:
            line.fail("it closed the connection");
            break;
        case LWS_CALLBACK_ESTABLISHED_CLIENT_HTTP:
            line.http_status = lws_http_client_http_response(connection);
            break;
        case LWS_CALLBACK_RECEIVE_CLIENT_HTTP: {
            // The buffer has to begin with room for a chunk's head.
            char room[LWS_PRE + 2048];
            char* begin = room + LWS_PRE;
            int most = 2048;
            return lws_http_client_read(connection, &begin, &most) < 0 ? -1 : 0;
        }
        case LWS_CALLBACK_RECEIVE_CLIENT_HTTP_READ:
            if (!line.take(in, count, longest_http_body)) return -1;
            break;
        case LWS_CALLBACK_COMPLETED_CLIENT_HTTP:
            line.state = ServiceLine::State::finished;
            break;
        case LWS_CALLBACK_CLOSED_CLIENT_HTTP:
            // An answer of unknown length ends with the connection.
            if (line.state == ServiceLine::State::opening && line.http_status != 0)
                line.state = ServiceLine::State::finished;
            else if (line.state == ServiceLine::State::opening)
                line.fail("it closed the connection");
            break;
        default:
            return 0;
    }
    ++line.events;
    return 0;
}

const lws_protocols service_protocols[] = {{"service", on_service_event, 0, 4096, 0, nullptr, 0},
                                           {nullptr, nullptr, 0, 0, 0, nullptr, 0}};

/// A libwebsockets context with one connection. Used by one thread at a time.
class ServiceConnection : NonCopyable {
public:
    ServiceConnection(std::uint16_t port, const char* path, const char* method) {
        lws_set_log_level(0, nullptr);
        lws_context_creation_info info{};
        info.port = CONTEXT_PORT_NO_LISTEN;
        info.protocols = service_protocols;
        info.user = &line_;
        info.fd_limit_per_thread = 16;  // otherwise its tables have room for all descriptors of the process
        info.gid = static_cast<gid_t>(-1);
        info.uid = static_cast<uid_t>(-1);
        struct sigaction before {};
        sigaction(SIGPIPE, nullptr, &before);
        context_ = lws_create_context(&info);
        sigaction(SIGPIPE, &before, nullptr);
        if (!context_) {
            line_.fail("libwebsockets does not start");
            return;
        }
        lws_client_connect_info to{};
        to.context = context_;
        to.address = to.host = to.origin = "localhost";
        to.port = port;
        to.path = path;
        to.ssl_connection = LCCSCF_HTTP_NO_FOLLOW_REDIRECT;  // redirects would leave this machine
        to.method = method;
        to.local_protocol_name = service_protocols[0].name;
        to.pwsi = &connection_;
        if (!lws_client_connect_via_info(&to)) line_.fail("no connection");
    }
    ~ServiceConnection() {
        if (context_) lws_context_destroy(context_);
    }

    ServiceLine& line() { return line_; }
    int descriptor() const {
        return connection_ && line_.state == ServiceLine::State::open ? lws_get_socket_fd(connection_) : -1;
    }
    /// Handles pending events; if there were none, waits for more, `patience` or 1 ms at most.
    void work(microseconds patience) {
        const std::uint64_t before = line_.events;
        serve();
        if (line_.events != before || line_.state == ServiceLine::State::failed || patience.count() <= 0)
            return;
        // libwebsockets may hold data that it has not delivered yet: serve it again after 1 ms at most.
        const microseconds wait = std::min<microseconds>(patience, milliseconds(1));
        pollfd waited_for{descriptor(), POLLIN, 0};
        const timespec time{0, std::chrono::nanoseconds(wait).count()};
        ppoll(&waited_for, 1, &time, nullptr);
        serve();
    }
    void ask_to_write() { lws_callback_on_writable(connection_); }

private:
    // Negative timeout: does not wait.
    void serve() {
        if (context_ && lws_service(context_, -1) < 0) line_.fail("libwebsockets gave up");
    }

    ServiceLine line_;
    lws_context* context_ = nullptr;
    lws* connection_ = nullptr;
};

/// Serves the connection until it is past `opening`.
Result<void> settle(ServiceConnection& connection, milliseconds patience) {
    const auto until = ServiceClock::now() + patience;
    while (connection.line().state == ServiceLine::State::opening) {
        if (stop_requested()) return interrupted_error();
        if (ServiceClock::now() >= until) {
            connection.line().fail(no_answer + " within " + std::to_string(patience.count()) + " ms");
            break;
        }
        connection.work(milliseconds(1));
    }
    return {};
}

class ServiceTransport final : public Transport {
public:
    ServiceTransport(std::unique_ptr<ServiceConnection> connection, std::string address)
        : connection_(std::move(connection)), address_(std::move(address)) {}

    Result<void> send(std::span<const std::byte> bytes) override {
        ServiceLine& line = connection_->line();
        TRY(failure());
        line.going.resize(LWS_PRE + bytes.size());
        std::memcpy(line.going.data() + LWS_PRE, bytes.data(), bytes.size());
        connection_->ask_to_write();
        const auto until = ServiceClock::now() + longest_write;
        do connection_->work(microseconds(100));
        while (!line.going.empty() && line.state == ServiceLine::State::open && ServiceClock::now() < until);
        if (!line.going.empty()) line.fail("it takes nothing any more");
        return failure();
    }

    Result<std::size_t> receive(std::span<std::byte> room, microseconds patience) override {
        ServiceLine& line = connection_->line();
        const auto until = ServiceClock::now() + patience;
        microseconds left = patience;
        while (line.messages.empty()) {
            TRY(failure());
            connection_->work(left);
            left = std::chrono::duration_cast<microseconds>(until - ServiceClock::now());
            if (line.messages.empty() && left.count() <= 0) {
                TRY(failure());
                return std::size_t{0};
            }
        }
        const std::string message = std::move(line.messages.front());
        line.messages.pop_front();
        if (message.size() > room.size()) return device_error(address_ + " sent a message too long");
        std::memcpy(room.data(), message.data(), message.size());
        return message.size();
    }

    int descriptor() const override { return connection_->descriptor(); }

private:
    Result<void> failure() const {
        const ServiceLine& line = connection_->line();
        if (line.state == ServiceLine::State::open) return {};
        return device_error("the Haply service at " + address_ + " is gone: " + line.failure);
    }

    std::unique_ptr<ServiceConnection> connection_;
    const std::string address_;
};

/// libwebsockets reports "HS:" for a server that answers, but not as a WebSocket.
Error no_haply_service(const std::string& address, const std::string& why) {
    if (why.find("HS:") != std::string::npos || why.starts_with(no_answer))
        return device_error("what answers at " + address + " is no Haply service (" + why +
                            "); use inverse3:port=N with the service's port");
    return device_error("no Haply service at " + address +
                        "; start it (sudo systemctl start haply-inverse-service, or open Haply Hub)");
}

}  // namespace

Result<std::string> LocalHaplyService::get(const std::string& path, milliseconds patience) {
    ServiceConnection connection(port_, path.c_str(), "GET");
    TRY(settle(connection, patience));
    ServiceLine& line = connection.line();
    if (line.state == ServiceLine::State::finished)
        return line.http_status == 200 ? std::move(line.coming) : std::string();
    if (line.http_status != 0) return std::string();
    return no_haply_service(address(), line.failure);
}

Result<std::unique_ptr<Transport>> LocalHaplyService::connect(milliseconds patience) {
    auto connection = std::make_unique<ServiceConnection>(port_, "/", nullptr);
    TRY(settle(*connection, patience));
    if (connection->line().state != ServiceLine::State::open)
        return no_haply_service(address(), connection->line().failure);
    return std::make_unique<ServiceTransport>(std::move(connection), address());
}

}  // namespace touchable
