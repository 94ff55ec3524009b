#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "device/drivers/inverse3_device.hpp"
#include "tests/device/fault_sessions.hpp"

namespace touchable::test {
namespace {

/// The service of an Inverse3 that answers each text with one. Now and then the arm is unplugged from it.
class FaultyInverse3 final : public FaultyDevice {
public:
    FaultyInverse3() : FaultyDevice("inverse3", {.longest_force = 5.0 + 1e-9}) {}

    std::unique_ptr<DeviceDriver> driver() override {
        gone_until_ns_ = 0;
        return std::make_unique<Inverse3Driver>(Inverse3Choice{}, std::make_unique<Service>(*this),
                                                [this] { return time.now_ns(); });
    }
    void live(double angle) override { place_ = 0.02 * glm::dvec3(std::cos(angle), std::sin(angle), 0); }
    void suffer_its_own() override { gone_until_ns_ = time.now_ns() + 30 * VirtualTime::ms; }

private:
    void answer() {
        const bool is_there = time.now_ns() >= gone_until_ns_;
        char text[160] = R"({"inverse3":[]})";
        // From its base, in its axes: x right, y forward, z up.
        if (is_there)
            std::snprintf(
                text, sizeof text,
                R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":%.9f,"y":%.9f,"z":%.9f}}}]})",
                place_.x, -(place_.z + 0.12), place_.y + 0.15);
        FaultyLine::Message message;
        for (const char* at = text; *at != 0; ++at) message.push_back(static_cast<std::byte>(*at));
        line.tell(std::move(message), is_there ? place_ : glm::dvec3(std::nan("")));
    }
    void hear(const std::string& text) {
        const auto at = text.find(R"({"x":)");
        glm::dvec3 force(0);
        if (at != std::string::npos) {
            EXPECT_EQ(
                std::sscanf(text.c_str() + at, R"({"x":%lf,"y":%lf,"z":%lf)", &force.x, &force.y, &force.z),
                3)
                << text;
            line.went_out(glm::length(force));
        }
        answer();
    }

    class Texts final : public Transport {
    public:
        explicit Texts(FaultyInverse3& to) : to_(to) {}
        Result<void> send(std::span<const std::byte> bytes) override {
            if (!to_.line.passes()) return cut();
            to_.hear(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
            return {};
        }
        Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override {
            if (to_.line.is_cut()) return cut();
            const auto came = to_.line.next(patience);
            if (to_.line.is_cut()) return cut();
            if (!came) return std::size_t{0};
            std::copy(came->begin(), came->end(), room.begin());
            return came->size();
        }

    private:
        FaultyInverse3& to_;
    };
    class Service final : public HaplyService {
    public:
        explicit Service(FaultyInverse3& to) : to_(to) {}
        std::string address() const override { return "ws://fake"; }
        Result<std::string> get(const std::string& path, std::chrono::milliseconds) override {
            if (to_.line.is_cut()) return cut();
            return path == "/version" ? std::string(R"({"project_version":"3.5.0.0"})") : std::string();
        }
        Result<std::unique_ptr<Transport>> connect(std::chrono::milliseconds) override {
            if (to_.line.is_cut()) return cut();
            to_.line.clear();
            to_.answer();
            return std::unique_ptr<Transport>(std::make_unique<Texts>(to_));
        }

    private:
        FaultyInverse3& to_;
    };
    static Error cut() { return {ErrorKind::device, "fake: the wire is cut"}; }

    glm::dvec3 place_{0.0};
    std::int64_t gone_until_ns_ = 0;
};

TEST(Inverse3Faults, AtRandomMoments) {
    FaultyInverse3 arm;
    run_fault_sessions(arm);
}

TEST(Inverse3Faults, ForceAfterSilence) {
    FaultyInverse3 arm;
    expect_force_after_silence(arm);
}

}  // namespace
}  // namespace touchable::test
