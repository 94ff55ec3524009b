#include "tests/device/fake_haply_service.hpp"

#include <libwebsockets.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <stdexcept>

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
