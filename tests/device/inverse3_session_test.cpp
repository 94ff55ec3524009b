// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <libwebsockets.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "device/drivers/device_catalog.hpp"
#include "device/drivers/inverse3_device.hpp"
#include "tests/unused_port.hpp"

struct lws;
struct lws_context;

namespace touchable::test {

/// Haply's service as its public description has it, on a free port: it tells its inventory to each
/// client, and answers each message with one state. In the service's axes.
class FakeHaplyService {
public:
    struct Manner {
        std::string version = "3.5.0.0";  ///< empty: GET /version is not found
        std::string force_member = "vector";
        std::vector<std::string> ids{"049D"};
        std::string basis = "XYZ";
        double damping = 0, force_scale = 1;
        bool split = false;    ///< each message in three fragments
        int garbage_each = 0;  ///< every so many answers is none; 0: never
        int answers_after_ms = 0;
    };
    struct Force {
        std::string id;
        glm::dvec3 newtons;
    };

    explicit FakeHaplyService(Manner manner, std::uint16_t port = 0);
    ~FakeHaplyService();

    std::uint16_t port() const { return port_; }
    void put_cursor(const glm::dvec3& place);
    std::vector<Force> forces() const;  ///< so far, as understood
    int misunderstood() const { return misunderstood_; }
    int connections() const { return connections_; }
    int still_connected() const { return still_connected_; }

    /// libwebsockets' thread.
    int on_event(lws* connection, int reason, const void* in, std::size_t count);

private:
    struct Going {
        std::int64_t due_ns;
        std::string text;
        int flags;
    };
    void tell(lws* connection, const std::string& text);
    void answer(lws* connection, const std::string& message);
    std::string state(bool with_configurations) const;
    std::string body(const std::string& path) const;
    int write_body(lws* connection);
    int write_message(lws* connection);

    const Manner manner_;
    std::uint16_t port_ = 0;
    lws_context* context_ = nullptr;
    std::map<lws*, std::deque<Going>> going_;
    std::map<lws*, std::string> coming_, bodies_;
    int answers_ = 0;
    mutable std::mutex mutex_;
    glm::dvec3 cursor_{0, -0.12, 0.15};
    std::vector<Force> forces_;
    std::atomic<int> misunderstood_{0}, connections_{0}, still_connected_{0};
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

}  // namespace touchable::test
namespace touchable::test {
namespace {

using nlohmann::json;

std::int64_t fake_now_ns() {
    return std::chrono::steady_clock::now().time_since_epoch().count();
}

int on_fake_event(lws* connection, lws_callback_reasons reason, void*, void* in, std::size_t count) {
    auto* service = static_cast<FakeHaplyService*>(lws_context_user(lws_get_context(connection)));
    return service->on_event(connection, reason, in, count);
}

const lws_protocols fake_protocols[] = {{"haply", on_fake_event, 0, 4096, 0, nullptr, 0},
                                        {nullptr, nullptr, 0, 0, 0, nullptr, 0}};

json xyz(const glm::dvec3& vector) {
    return {{"x", vector.x}, {"y", vector.y}, {"z", vector.z}};
}

}  // namespace

FakeHaplyService::FakeHaplyService(Manner manner, std::uint16_t port) : manner_(std::move(manner)) {
    lws_set_log_level(0, nullptr);
    lws_context_creation_info info{};
    info.port = port;
    info.iface = "127.0.0.1";
    info.protocols = fake_protocols;
    info.user = this;
    info.fd_limit_per_thread = 32;
    info.gid = static_cast<gid_t>(-1);
    info.uid = static_cast<uid_t>(-1);
    info.options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS;
    context_ = lws_create_context(&info);
    lws_vhost* host = context_ ? lws_create_vhost(context_, &info) : nullptr;
    if (!host) throw std::runtime_error("the fake service does not start");
    port_ = static_cast<std::uint16_t>(lws_get_vhost_listen_port(host));
    thread_ = std::thread([this] {
        while (!stopping_) {
            lws_service(context_, -1);
            const std::int64_t now = fake_now_ns();
            for (const auto& [connection, messages] : going_)
                if (!messages.empty() && messages.front().due_ns <= now) lws_callback_on_writable(connection);
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        }
        lws_context_destroy(context_);
    });
}

FakeHaplyService::~FakeHaplyService() {
    stopping_ = true;
    thread_.join();
}

void FakeHaplyService::put_cursor(const glm::dvec3& place) {
    const std::lock_guard lock(mutex_);
    cursor_ = place;
}

std::vector<FakeHaplyService::Force> FakeHaplyService::forces() const {
    const std::lock_guard lock(mutex_);
    return forces_;
}

int FakeHaplyService::on_event(lws* connection, int reason, const void* in, std::size_t count) {
    switch (reason) {
        case LWS_CALLBACK_HTTP: {
            bodies_[connection] = body(static_cast<const char*>(in));
            if (bodies_[connection].empty()) {
                if (lws_return_http_status(connection, HTTP_STATUS_NOT_FOUND, nullptr)) return -1;
                return lws_http_transaction_completed(connection) ? -1 : 0;
            }
            unsigned char head[LWS_PRE + 1024];
            unsigned char *const begin = head + LWS_PRE, *end = head + sizeof head - 1, *at = begin;
            if (lws_add_http_common_headers(connection, HTTP_STATUS_OK, "application/json",
                                            bodies_[connection].size(), &at, end) ||
                lws_finalize_write_http_header(connection, begin, &at, end))
                return -1;
            lws_callback_on_writable(connection);
            return 0;
        }
        case LWS_CALLBACK_HTTP_WRITEABLE:
            return write_body(connection);
        case LWS_CALLBACK_ESTABLISHED:
            ++connections_;
            ++still_connected_;
            tell(connection, state(true));
            return 0;
        case LWS_CALLBACK_RECEIVE: {
            std::string& coming = coming_[connection];
            coming.append(static_cast<const char*>(in), count);
            if (lws_is_final_fragment(connection) && lws_remaining_packet_payload(connection) == 0)
                answer(connection, std::exchange(coming, {}));
            return 0;
        }
        case LWS_CALLBACK_SERVER_WRITEABLE:
            return write_message(connection);
        case LWS_CALLBACK_CLOSED:
            --still_connected_;
            going_.erase(connection);
            coming_.erase(connection);
            return 0;
        default:
            return 0;
    }
}

int FakeHaplyService::write_body(lws* connection) {
    std::string room = std::string(LWS_PRE, ' ') + bodies_[connection];
    auto* bytes = reinterpret_cast<unsigned char*>(room.data()) + LWS_PRE;
    if (lws_write(connection, bytes, room.size() - LWS_PRE, LWS_WRITE_HTTP_FINAL) < 0) return -1;
    return lws_http_transaction_completed(connection) ? -1 : 0;
}

int FakeHaplyService::write_message(lws* connection) {
    auto& messages = going_[connection];
    if (messages.empty() || messages.front().due_ns > fake_now_ns()) return 0;
    std::string room = std::string(LWS_PRE, ' ') + messages.front().text;
    auto* bytes = reinterpret_cast<unsigned char*>(room.data()) + LWS_PRE;
    const auto flags = static_cast<lws_write_protocol>(messages.front().flags);
    messages.pop_front();
    return lws_write(connection, bytes, room.size() - LWS_PRE, flags) < 0 ? -1 : 0;
}

void FakeHaplyService::tell(lws* connection, const std::string& text) {
    const std::int64_t due = fake_now_ns() + manner_.answers_after_ms * std::int64_t{1'000'000};
    auto& messages = going_[connection];
    if (!manner_.split) {
        messages.push_back({due, text, LWS_WRITE_TEXT});
        return;
    }
    const std::size_t third = text.size() / 3;
    messages.push_back({due, text.substr(0, third), LWS_WRITE_TEXT | LWS_WRITE_NO_FIN});
    messages.push_back({due, text.substr(third, third), LWS_WRITE_CONTINUATION | LWS_WRITE_NO_FIN});
    messages.push_back({due, text.substr(2 * third), LWS_WRITE_CONTINUATION});
}

void FakeHaplyService::answer(lws* connection, const std::string& message) {
    const json asked = json::parse(message, nullptr, false);
    bool understood = asked.is_object() && asked.contains("session");
    if (asked.is_object() && asked.contains("inverse3"))
        for (const json& arm : asked["inverse3"]) {
            const json& force = arm["commands"]["set_cursor_force"];
            if (!force.contains(manner_.force_member)) continue;
            const json& vector = force[manner_.force_member];
            const std::lock_guard lock(mutex_);
            forces_.push_back({arm["device_id"], {vector["x"], vector["y"], vector["z"]}});
            understood = true;
        }
    if (!understood) ++misunderstood_;
    ++answers_;
    if (manner_.garbage_each > 0 && answers_ % manner_.garbage_each == 0)
        tell(connection, "{\"inverse3\":[{\"device_id\":");
    else
        tell(connection, state(asked.is_object() && asked.contains("session")));
}

std::string FakeHaplyService::state(bool with_configurations) const {
    json arms = json::array();
    for (const std::string& id : manner_.ids) {
        json arm = {{"device_id", id},
                    {"status",
                     {{"calibrated", true},
                      {"in_use", false},
                      {"power_supply", true},
                      {"ready", true},
                      {"started", true}}}};
        if (with_configurations)
            arm["config"] = {
                {"basis", {{"permutation", manner_.basis}}},
                {"handedness", "right"},
                {"gravity_compensation", {{"enabled", true}, {"scaling_factor", 1.0}}},
                {"filters", {{"force_gate", {{"gain", 0.3}}}, {"damping", {{"scalar", manner_.damping}}}}}};
        const std::lock_guard lock(mutex_);
        arm["state"] = {{"cursor_position", xyz(cursor_)}, {"cursor_velocity", xyz(glm::dvec3(0))}};
        arms.push_back(std::move(arm));
    }
    return json{{"session_id", 7}, {"inverse3", std::move(arms)}}.dump();
}

std::string FakeHaplyService::body(const std::string& path) const {
    if (path == "/version" && !manner_.version.empty())
        return json{{"project_name", "haply-inverse-service"}, {"project_version", manner_.version}}.dump();
    if (path == "/settings/devices/force_scale")
        return json{{"ok", true}, {"data", manner_.force_scale}}.dump();
    return {};
}

}  // namespace touchable::test
namespace touchable {
namespace {

// Whole sessions with a service on a real port: WebSocket, HTTP, threads.

using test::FakeHaplyService;

bool eventually(const std::function<bool()>& holds) {
    for (int looks = 0; looks < 10'000; ++looks) {
        if (holds()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
}

std::unique_ptr<HapticDevice> device_at(std::uint16_t port, const std::string& more = "",
                                        DrivenSettings driven = {}) {
    auto device = make_device("inverse3:port=" + std::to_string(port) + more, driven);
    EXPECT_TRUE(device);
    return std::move(*device);
}

glm::dvec3 place_of(HapticDevice& device) {
    glm::dvec3 place(NAN);
    if (!device.read_positions(std::span(&place, 1))) place = glm::dvec3(NAN);
    return place;
}

/// Keeps pushing as a haptic thread would, until the service has felt it.
bool is_felt(HapticDevice& device, const FakeHaplyService& service, const glm::dvec3& newtons,
             const glm::dvec3& in_its_axes) {
    return eventually([&] {
        [[maybe_unused]] const glm::dvec3 place = place_of(device);
        if (!device.write_forces(std::span(&newtons, 1))) return false;
        const auto forces = service.forces();
        return !forces.empty() && forces.back().newtons == in_its_axes;
    });
}

void play_a_session(FakeHaplyService::Manner manner) {
    FakeHaplyService service(manner);
    const auto device = device_at(service.port());
    const auto opened = device->open();
    ASSERT_TRUE(opened) << opened.error().message;
    ASSERT_FALSE(service.forces().empty());
    EXPECT_EQ(service.forces().front().newtons, glm::dvec3(0));
    ASSERT_TRUE(eventually([&] { return !std::isnan(place_of(*device).x); }));
    EXPECT_NEAR(glm::dvec3(place_of(*device)).y, 0, 1e-12);
    service.put_cursor({0.005, -0.12, 0.15});
    ASSERT_TRUE(eventually([&] { return std::abs(place_of(*device).x - 0.005) < 1e-12; }));
    EXPECT_TRUE(is_felt(*device, service, {1, 2, 3}, {1, -3, 2}));
    EXPECT_EQ(device->capabilities().axes_driven, 3);
    device->close();
    ASSERT_TRUE(eventually([&] { return service.still_connected() == 0; }));
    EXPECT_EQ(service.forces().back().newtons, glm::dvec3(0));
    EXPECT_EQ(service.misunderstood(), 0);
}

TEST(Inverse3Session, SpeaksVersion35) {
    play_a_session({});
}

TEST(Inverse3Session, SpeaksVersionBefore35) {
    play_a_session({.version = "3.3.2.0", .force_member = "values"});
}

TEST(Inverse3Session, ToleratesSplitAndGarbledAnswers) {
    play_a_session({.split = true, .garbage_each = 3, .answers_after_ms = 8});
}

TEST(Inverse3Session, ShortensLongForces) {
    FakeHaplyService service({});
    const auto device = device_at(service.port(), ",force=2");
    ASSERT_TRUE(device->open());
    EXPECT_TRUE(is_felt(*device, service, {0, 50, 0}, {0, 0, 2}));
}

TEST(Inverse3Session, ChoosesOneOfTwoArms) {
    FakeHaplyService service({.ids = {"049D", "04BA"}});
    const auto opened = device_at(service.port())->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().message, "there are several Inverse3, 049D, 04BA: choose one");
    EXPECT_EQ(opened.error().hints.at(0).setting, Setting::device);
    EXPECT_EQ(opened.error().hints.at(0).value, "inverse3:id=049D");
    const auto device = device_at(service.port(), ",id=04BA");
    ASSERT_TRUE(device->open());
    ASSERT_TRUE(is_felt(*device, service, {1, 0, 0}, {1, 0, 0}));
    device->close();
    for (const auto& force : service.forces()) EXPECT_EQ(force.id, "04BA");
}

TEST(Inverse3Session, ReconnectsAfterServiceRestart) {
    const std::uint16_t port = test::unused_port();
    auto service = std::make_unique<FakeHaplyService>(FakeHaplyService::Manner{}, port);
    DrivenSettings driven;
    driven.look_again_s = 0.02;
    const auto device = device_at(port, "", driven);
    ASSERT_TRUE(device->open());
    ASSERT_TRUE(is_felt(*device, *service, {1, 0, 0}, {1, 0, 0}));
    service.reset();
    ASSERT_TRUE(eventually([&] { return !device->health(); }));
    ASSERT_TRUE(eventually([&] { return std::isnan(place_of(*device).x); }));
    service = std::make_unique<FakeHaplyService>(FakeHaplyService::Manner{}, port);
    ASSERT_TRUE(eventually([&] { return device->health() && !std::isnan(place_of(*device).x); }));
    ASSERT_FALSE(service->forces().empty());
    EXPECT_EQ(service->forces().front().newtons, glm::dvec3(0)) << "unpowered when it is met anew";
    EXPECT_TRUE(is_felt(*device, *service, {0, 1, 0}, {0, 0, 1}));
}

TEST(Inverse3Session, ReportsMissingService) {
    const std::uint16_t port = test::unused_port();
    const std::string where = "ws://localhost:" + std::to_string(port);
    for (const std::string more : {"", ",service=3.5"}) {
        const auto opened = device_at(port, more)->open();
        ASSERT_FALSE(opened);
        EXPECT_EQ(opened.error().kind, ErrorKind::device);
        EXPECT_EQ(opened.error().message,
                  "no Haply service at " + where +
                      "; start it (sudo systemctl start haply-inverse-service, or open Haply Hub)");
    }
}

/// A server that answers each client with "403", as another program at that port might.
class SomethingElse {
public:
    SomethingElse() : listener_(socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in here = test::loopback(0);
        socklen_t size = sizeof here;
        auto* address = reinterpret_cast<sockaddr*>(&here);
        if (bind(listener_, address, size) == 0 && listen(listener_, 1) == 0 &&
            getsockname(listener_, address, &size) == 0)
            port_ = ntohs(here.sin_port);
        thread_ = std::thread([this] {
            for (int peer; (peer = accept(listener_, nullptr, nullptr)) >= 0; close(peer)) {
                char room[2048];
                const std::string answer = "HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\n\r\n";
                if (recv(peer, room, sizeof room, 0) > 0)
                    send(peer, answer.data(), answer.size(), MSG_NOSIGNAL);
                while (recv(peer, room, sizeof room, 0) > 0) {
                }
            }
        });
    }
    ~SomethingElse() {
        shutdown(listener_, SHUT_RDWR);
        thread_.join();
        close(listener_);
    }
    std::uint16_t port() const { return port_; }

private:
    int listener_;
    std::uint16_t port_ = 0;
    std::thread thread_;
};

TEST(Inverse3Session, RejectsOtherServiceAtPort) {
    const SomethingElse there;
    const auto opened = device_at(there.port(), ",service=3.5")->open();
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().message.find("is no Haply service"), std::string::npos)
        << opened.error().message;
    const auto asked = device_at(there.port())->open();
    ASSERT_FALSE(asked);
    EXPECT_NE(asked.error().message.find("does not say which version it is"), std::string::npos)
        << asked.error().message;
}

TEST(Inverse3Session, RejectsUnsupportedServiceVersions) {
    FakeHaplyService next({.version = "4.1.0.0"});
    const auto opened = device_at(next.port())->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().message,
              "Haply Inverse Service 4.1 is not known here; must be 3.1 to any other 3.x");
    FakeHaplyService silent({.version = ""});
    const auto asked = device_at(silent.port())->open();
    ASSERT_FALSE(asked);
    EXPECT_NE(asked.error().message.find("does not say which version it is"), std::string::npos);
    EXPECT_TRUE(device_at(silent.port(), ",service=3.6")->open());
}

TEST(Inverse3Session, ZeroForcePacketUnpowersArm) {
    FakeHaplyService service({});
    Inverse3Choice choice;
    Inverse3Driver driver(choice, std::make_unique<LocalHaplyService>(service.port()));
    const auto connected = driver.connect();
    ASSERT_TRUE(connected) << connected.error().message;
    const glm::dvec3 push(0, 0, -4);
    ASSERT_TRUE(driver.send(std::span(&push, 1)));
    ASSERT_TRUE(eventually([&] { return service.forces().back().newtons == glm::dvec3(0, 4, 0); }));
    const auto word = driver.zero_force_packet();
    ASSERT_TRUE(word);
    ASSERT_EQ(write(word->descriptor, word->bytes.data(), word->bytes.size()),
              static_cast<ssize_t>(word->bytes.size()));
    EXPECT_TRUE(eventually([&] { return service.forces().back().newtons == glm::dvec3(0); }));
    EXPECT_EQ(service.misunderstood(), 0);
}

}  // namespace
}  // namespace touchable
