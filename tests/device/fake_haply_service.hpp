#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

struct lws;
struct lws_context;

namespace touchable::test {

/// Haply's service as its public description has it, on a free port: it tells its inventory to whoever
/// connects, and answers each message with one state. In the service's axes.
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
