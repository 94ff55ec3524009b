// Whole sessions with a service on a real port: WebSocket, HTTP, threads.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <thread>

#include "device/drivers/device_catalog.hpp"
#include "device/drivers/inverse3_device.hpp"
#include "tests/device/fake_haply_service.hpp"
#include "tests/unused_port.hpp"

namespace touchable {
namespace {

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

TEST(Inverse3Session, From35On) {
    play_a_session({});
}

TEST(Inverse3Session, Before35) {
    play_a_session({.version = "3.3.2.0", .force_member = "values"});
}

TEST(Inverse3Session, SplitMessagesAndGarbageAndSlowAnswers) {
    play_a_session({.split = true, .garbage_each = 3, .answers_after_ms = 8});
}

TEST(Inverse3Session, LongForcesAreShortened) {
    FakeHaplyService service({});
    const auto device = device_at(service.port(), ",force=2");
    ASSERT_TRUE(device->open());
    EXPECT_TRUE(is_felt(*device, service, {0, 50, 0}, {0, 0, 2}));
}

TEST(Inverse3Session, OneOfTwoArmsIsChosen) {
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

TEST(Inverse3Session, AServiceThatRestartsIsFoundAgain) {
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

TEST(Inverse3Session, NoServiceIsOneLine) {
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

/// Answers whoever connects with "403", as something else at that port might.
class SomethingElse {
public:
    SomethingElse() : listener_(socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in here{};
        here.sin_family = AF_INET;
        here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
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

TEST(Inverse3Session, SomethingElseAtThatPortIsNoService) {
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

TEST(Inverse3Session, AnotherGenerationAndAServiceWithoutAVersionAreRefused) {
    FakeHaplyService next({.version = "4.1.0.0"});
    const auto opened = device_at(next.port())->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().message,
              "Haply Inverse Service 4.1 is not known here; right would be 3.1 to any other 3.x");
    FakeHaplyService silent({.version = ""});
    const auto asked = device_at(silent.port())->open();
    ASSERT_FALSE(asked);
    EXPECT_NE(asked.error().message.find("does not say which version it is"), std::string::npos);
    EXPECT_TRUE(device_at(silent.port(), ",service=3.6")->open());
}

TEST(Inverse3Session, TheZeroForcePacketLeavesTheArmLimp) {
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
