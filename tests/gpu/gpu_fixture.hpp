#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/gpu/gpu_device.hpp"
#include "engine/gpu/vulkan_instance.hpp"

namespace touchable::test {

/// A device watched by the validation layer, which must have nothing to say, not even at the device's end.
class GpuTest : public ::testing::Test {
protected:
    void SetUp() override {
        // Else it is unloaded with the last device, and the leak checker cannot tell its leaks (lsan.supp)
        // from ours.
        dlopen("libVkLayer_khronos_validation.so", RTLD_NOW | RTLD_NODELETE);
        GpuOptions options;
        options.validation = true;
        auto opened = GpuDevice::open(options);
        ASSERT_TRUE(opened) << opened.error().message;
        gpu = std::move(*opened);
        messages = gpu->messages();
    }

    void TearDown() override {
        if (!messages) return;
        EXPECT_LE(gpu.use_count(), 1) << "something keeps the device";
        gpu.reset();
        for (const std::string& message : messages->all()) ADD_FAILURE() << message;
    }

    std::shared_ptr<GpuDevice> gpu;
    std::shared_ptr<const GpuMessages> messages;
};

/// The value; where there is none, the test fails with the reason.
template <class T>
T must(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
}

inline void must(const Result<void>& result) {
    if (!result) throw std::runtime_error(result.error().message);
}

}  // namespace touchable::test
