#include "device/device_group.hpp"

#include <gtest/gtest.h>

namespace touchable {
namespace {

/// Says of itself what a test wants.
class ToldDevice final : public HapticDevice {
public:
    ToldDevice(std::string name, bool over, std::string wish, const char* first_button = nullptr)
        : name_(std::move(name)), over_(over), wish_(std::move(wish)) {
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
    std::string wish() const override { return wish_; }
    Result<void> health() const override { return {}; }

private:
    std::string name_;
    bool over_;
    std::string wish_;
    DeviceCapabilities can_;
};

template <class... Devices>
DeviceGroup group_of(Devices... devices) {
    std::vector<std::unique_ptr<HapticDevice>> all;
    (all.push_back(std::move(devices)), ...);
    return DeviceGroup(std::move(all));
}

TEST(DeviceGroup, IsOverOnceAllOfItAre) {
    const auto told = [](bool over) { return std::make_unique<ToldDevice>("log", over, ""); };
    EXPECT_FALSE(group_of(told(true), told(false)).is_over());
    EXPECT_TRUE(group_of(told(true), told(true)).is_over());
}

TEST(DeviceGroup, SaysOfEachWhyItNeverToldAPosition) {
    const DeviceGroup group = group_of(std::make_unique<ToldDevice>("grip", false, "pull it out"),
                                       std::make_unique<ToldDevice>("pen", false, ""));
    EXPECT_EQ(group.absence(), "the grip never told a position: pull it out; the pen never told a position");
}

TEST(DeviceGroup, NamesAFirstButtonThatAllOfThemHave) {
    const auto told = [](const char* button) { return std::make_unique<ToldDevice>("a", false, "", button); };
    EXPECT_STREQ(group_of(told("bit 0"), told("bit 0")).capabilities().first_button, "bit 0");
    EXPECT_STREQ(group_of(told("bit 0"), told("the red one")).capabilities().first_button,
                 "the device's first button");
}

}  // namespace
}  // namespace touchable
