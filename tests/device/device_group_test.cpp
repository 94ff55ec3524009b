#include "device/haptic_device.hpp"

#include <gtest/gtest.h>

#include <array>
#include <utility>
#include <vector>

namespace touchable {
namespace {

/// Says of itself what a test wants.
class ToldDevice final : public HapticDevice {
public:
    ToldDevice(std::string name, bool over, std::string prompt, const char* first_button = nullptr)
        : name_(std::move(name)), over_(over), prompt_(std::move(prompt)) {
        if (first_button) can_.first_button = first_button;
    }
    std::string name() const override { return name_; }
    DeviceLimits limits() const override { return {10, 1000}; }
    int fingers() const override { return 1; }
    DeviceCapabilities capabilities() const override { return can_; }
    Result<void> open() override { return {}; }
    void close() override {}
    bool read_positions(std::span<glm::dvec3>) override { return true; }
    bool write_forces(std::span<const glm::dvec3>) override { return true; }
    bool is_over() const override { return over_; }
    std::string prompt() const override { return prompt_; }
    Result<void> health() const override { return {}; }

private:
    std::string name_;
    bool over_;
    std::string prompt_;
    DeviceCapabilities can_;
};

template <class... Devices>
std::unique_ptr<HapticDevice> group_of(Devices... devices) {
    std::vector<std::unique_ptr<HapticDevice>> all;
    (all.push_back(std::move(devices)), ...);
    return make_device_group(std::move(all));
}

TEST(DeviceGroup, IsOverOnceAllOfItAre) {
    const auto told = [](bool over) { return std::make_unique<ToldDevice>("log", over, ""); };
    EXPECT_FALSE(group_of(told(true), told(false))->is_over());
    EXPECT_TRUE(group_of(told(true), told(true))->is_over());
}

TEST(DeviceGroup, SaysOfEachWhyItNeverToldAPosition) {
    const auto group = group_of(std::make_unique<ToldDevice>("grip", false, "pull it out"),
                                std::make_unique<ToldDevice>("pen", false, ""));
    EXPECT_EQ(group->why_no_position(),
              "the grip never told a position: pull it out; the pen never told a position");
}

TEST(DeviceGroup, NamesAFirstButtonThatAllOfThemHave) {
    const auto told = [](const char* button) { return std::make_unique<ToldDevice>("a", false, "", button); };
    EXPECT_STREQ(group_of(told("bit 0"), told("bit 0"))->capabilities().first_button, "bit 0");
    EXPECT_STREQ(group_of(told("bit 0"), told("the red one"))->capabilities().first_button,
                 "the device's first button");
}

/// What it was told, and whether it works, outlive it.
struct Hardware {
    DeviceLimits limits{10, 1000};
    DeviceCapabilities can{};
    int fingers = 1;
    bool works = true, plugged = true, open = false;
    double first_x = 0;  // of finger 0; the next fingers are one to the right each
    std::uint32_t pressed = 0;
    double age_s = 0;
    std::vector<glm::dvec3> forces{};  // of the newest tick
};

class HardwareDevice final : public HapticDevice {
public:
    explicit HardwareDevice(Hardware& hardware) : hardware_(hardware) {}
    std::string name() const override { return "fake"; }
    DeviceLimits limits() const override { return hardware_.limits; }
    int fingers() const override { return hardware_.fingers; }
    DeviceCapabilities capabilities() const override { return hardware_.can; }
    Result<void> open() override {
        if (!hardware_.plugged) return gone();
        hardware_.open = true;
        return {};
    }
    void close() override { hardware_.open = false; }
    bool read_positions(std::span<glm::dvec3> metres) override {
        if (!hardware_.works) return false;
        for (std::size_t finger = 0; finger < metres.size(); ++finger)
            metres[finger] = {hardware_.first_x + static_cast<double>(finger), 0, 0};
        return true;
    }
    bool write_forces(std::span<const glm::dvec3> newtons) override {
        if (!hardware_.works) return false;
        hardware_.forces.assign(newtons.begin(), newtons.end());
        return true;
    }
    std::uint32_t buttons() override { return hardware_.pressed; }
    double age_s() const override { return hardware_.age_s; }
    Result<void> health() const override { return hardware_.works ? Result<void>{} : gone(); }

private:
    static Result<void> gone() { return Error{ErrorKind::device, "fake: gone"}; }
    Hardware& hardware_;
};

/// One finger, then two.
class GroupOfTwo : public ::testing::Test {
protected:
    Hardware first, second{.fingers = 2, .first_x = 10};
    const std::unique_ptr<HapticDevice> group =
        group_of(std::make_unique<HardwareDevice>(first), std::make_unique<HardwareDevice>(second));
    std::array<glm::dvec3, 3> places{glm::dvec3(-1), glm::dvec3(-1), glm::dvec3(-1)};
    const std::array<glm::dvec3, 3> push{glm::dvec3(1), glm::dvec3(2), glm::dvec3(3)};
};

TEST_F(GroupOfTwo, FingersOfTheFirstComeFirst) {
    EXPECT_EQ(group->fingers(), 3);
    ASSERT_TRUE(group->read_positions(places));
    EXPECT_EQ(places[0].x, 0);
    EXPECT_EQ(places[1].x, 10);
    EXPECT_EQ(places[2].x, 11);
    ASSERT_TRUE(group->write_forces(push));
    EXPECT_EQ(first.forces, std::vector{push[0]});
    EXPECT_EQ(second.forces, (std::vector{push[1], push[2]}));
}

TEST_F(GroupOfTwo, ExertsWhatTheWeakestOfThemCan) {
    for (const bool is_turned : {false, true}) {
        first.limits = {10, 1000};
        second.limits = {4, 3000};
        if (is_turned) std::swap(first.limits, second.limits);
        EXPECT_EQ(group->limits().max_force, 4);
        EXPECT_EQ(group->limits().max_stiffness, 1000);
    }
}

TEST_F(GroupOfTwo, HasWhatAllOfThemHave) {
    first.can = {
        .axes_driven = 0, .reach = {0.1, 0.3, 0.1}, .rate_hz = 500, .buttons = 1, .own_watchdog = true};
    second.can = {.axes_driven = 3, .reach = {0.2, 0.2, 0.2}, .rate_hz = 1000, .buttons = 4};
    for (const bool is_turned : {false, true}) {
        if (is_turned) std::swap(first.can, second.can);
        const DeviceCapabilities can = group->capabilities();
        EXPECT_EQ(can.axes_driven, 3) << "somebody may feel something";
        EXPECT_EQ(can.reach, glm::dvec3(0.1, 0.2, 0.1));
        EXPECT_EQ(can.rate_hz, 500);
        EXPECT_EQ(can.buttons, 4);
        EXPECT_FALSE(can.own_watchdog) << "one holds its last force";
    }
}

TEST_F(GroupOfTwo, NoneIsLeftWithAForceBecauseAnotherHasFailed) {
    ASSERT_TRUE(group->write_forces(push));
    for (Hardware* const broken : {&first, &second}) {
        Hardware& other = broken == &first ? second : first;
        broken->works = false;
        EXPECT_FALSE(group->read_positions(places));
        EXPECT_FALSE(group->health());
        ASSERT_TRUE(other.forces[0] != glm::dvec3(0));
        EXPECT_FALSE(group->write_forces(std::vector<glm::dvec3>(3, glm::dvec3(0))));
        for (const glm::dvec3& force : other.forces) EXPECT_EQ(force, glm::dvec3(0));
        broken->works = true;
        ASSERT_TRUE(group->write_forces(push));
    }
}

TEST_F(GroupOfTwo, PlacesOfOneAreReadThoughAnotherHasFailed) {
    first.works = false;
    EXPECT_FALSE(group->read_positions(places));
    EXPECT_EQ(places[1].x, 10);
    EXPECT_EQ(places[2].x, 11);
}

TEST_F(GroupOfTwo, ButtonsAreThoseOfAllAndItsAgeIsThatOfTheOldest) {
    first.pressed = 1;
    second.pressed = 2;
    EXPECT_EQ(group->buttons(), 3U);
    first.age_s = 0.5;
    second.age_s = 0.001;
    EXPECT_EQ(group->age_s(), 0.5);
    std::swap(first.age_s, second.age_s);
    EXPECT_EQ(group->age_s(), 0.5);
}

TEST_F(GroupOfTwo, IsOpenAsAWholeOrNotAtAll) {
    ASSERT_TRUE(group->open());
    EXPECT_TRUE(first.open && second.open);
    group->close();
    EXPECT_FALSE(first.open || second.open);
    second.plugged = false;
    const auto opened = group->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().message, "fake: gone");
    EXPECT_FALSE(first.open);
}

}  // namespace
}  // namespace touchable
