// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <vulkan/vulkan.h>

#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/gpu/vulkan_instance.hpp"
#include "tests/must.hpp"

namespace touchable::test {

/// A device watched by the validation layer, which must have nothing to say, not even at the device's end.
class GpuTest : public ::testing::Test {
protected:
    void SetUp() override {
        // Else it is unloaded with the last device, and the leak checker cannot tell its leaks (lsan.supp)
        // from ours.
        dlopen("libVkLayer_khronos_validation.so", RTLD_NOW | RTLD_NODELETE);
        gpu = must(GpuDevice::open({.validation = true}));
        messages = gpu->messages();
    }

    void TearDown() override {
        if (!messages) return;
        EXPECT_LE(gpu.use_count(), 1) << "something keeps the device";
        gpu.reset();
        for (const std::string& message : messages->all()) ADD_FAILURE() << message;
    }

    /// Submits, and has done the work when it returns.
    static GpuCommands::Submission run(GpuCommands commands) {
        auto submission = must(std::move(commands).submit());
        must(submission.wait());
        return submission;
    }

    std::shared_ptr<GpuDevice> gpu;
    std::shared_ptr<const GpuMessages> messages;
};

/// Keeps a device's queue from getting on, as a GPU that hangs does: all that is submitted from now on waits.
class Blockade {
public:
    explicit Blockade(const GpuDevice& device) : vulkan_(device.vulkan()) {
        VkSemaphoreTypeCreateInfo type{};
        type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
        type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
        VkSemaphoreCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
        info.pNext = &type;
        expect(vkCreateSemaphore(vulkan_->device, &info, nullptr, &semaphore_));
        VkSemaphoreSubmitInfo wait{};
        wait.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
        wait.semaphore = semaphore_;
        wait.value = 1;
        wait.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
        VkSubmitInfo2 submit{};
        submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
        submit.waitSemaphoreInfoCount = 1;
        submit.pWaitSemaphoreInfos = &wait;
        const std::lock_guard lock(vulkan_->queue_mutex);
        expect(vkQueueSubmit2(vulkan_->queue, 1, &submit, VK_NULL_HANDLE));
    }
    Blockade(const Blockade&) = delete;
    Blockade& operator=(const Blockade&) = delete;
    ~Blockade() { lift(); }

    /// The queue goes on, and has done all its work when this returns.
    void lift() {
        if (!semaphore_) return;
        VkSemaphoreSignalInfo signal{};
        signal.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO;
        signal.semaphore = semaphore_;
        signal.value = 1;
        vkSignalSemaphore(vulkan_->device, &signal);
        {
            const std::lock_guard lock(vulkan_->queue_mutex);
            vkQueueWaitIdle(vulkan_->queue);
        }
        vkDestroySemaphore(vulkan_->device, semaphore_, nullptr);
        semaphore_ = VK_NULL_HANDLE;
    }

private:
    static void expect(VkResult result) {
        if (result != VK_SUCCESS) throw std::runtime_error("a blockade cannot be made here");
    }

    std::shared_ptr<VulkanDevice> vulkan_;
    VkSemaphore semaphore_ = VK_NULL_HANDLE;
};

}  // namespace touchable::test
