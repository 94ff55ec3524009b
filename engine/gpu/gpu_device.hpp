#pragma once

#include <vulkan/vulkan.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_facts.hpp"
#include "engine/gpu/vulkan_device.hpp"

namespace touchable {

/// What Vulkan has here, usable or not, in the order of `--gpu INDEX`. Empty where there is a Vulkan loader
/// without a driver; fails where there is not even an instance to be had.
Result<std::vector<GpuFacts>> list_gpus();

struct GpuOptions {
    std::string request = "auto";  ///< as in choose_gpu
    /// Ask the validation layer, synchronisation checks included, to watch every call; refused where it is
    /// not installed. TOUCHABLE_VULKAN_VALIDATION=1 in the environment asks as well, and prints what it says
    /// to stderr.
    bool validation = false;
    /// Of the window system that pictures are to be shown by; where there are any, the device also gets
    /// swapchains, and one without them is refused.
    std::vector<std::string> window_extensions{};
};

struct GpuTime;
struct GpuRecording;  // a command buffer and what it needs (gpu_recording.hpp)

/// An open device with its one queue. Submissions run in order, each sees all that earlier ones wrote, and
/// what they use is kept alive until they have completed. Safe from any thread.
class GpuDevice {
public:
    static Result<std::shared_ptr<GpuDevice>> open(const GpuOptions& options = {});
    /// Waits for what is in flight, but not for a lost device: what that may still be at work on is left as
    /// it is, for ever or until another one is opened after it has finished.
    ~GpuDevice();

    const GpuFacts& facts() const { return vulkan_->facts; }
    const std::shared_ptr<VulkanDevice>& vulkan() const { return vulkan_; }
    std::shared_ptr<const GpuMessages> messages() const { return vulkan_->instance->messages(); }

    /// The timeline's value so far: every submission up to it has completed. No lock; a lost device stands
    /// still.
    std::uint64_t completed() const;

    /// Waits for a value that GpuCommands::submit gave. Fails (ErrorKind::gpu) on a lost device, and where
    /// that takes longer than the patience there is, or than `at_most`: a device that hangs is lost.
    Result<void> wait(std::uint64_t value,
                      std::chrono::nanoseconds at_most = std::chrono::nanoseconds::max());
    /// For whoever waits where a person's keys are taken: no longer than this.
    static constexpr std::chrono::seconds longest_picture{10};
    /// 10 s where nobody says; a minute for a software Vulkan, which compiles a kernel at its first dispatch
    /// and never hangs, but is slow where others want the processor too.
    std::chrono::nanoseconds patience() const { return patience_; }
    void set_patience(std::chrono::nanoseconds patience) { patience_ = patience; }

    /// Whether all that was submitted has completed. Waits for it, as long as `wait` would; for a lost device
    /// not at all.
    bool comes_to_rest();

    /// A driver that lost the device, a wait in vain, or `lose`. Sticky: open another one.
    bool lost() const { return vulkan_->lost; }

    /// From now on the device behaves as if the driver had lost it: how tests kill it in the middle.
    void lose() { vulkan_->lost = true; }

private:
    friend class GpuCommands;
    friend class GpuSubmission;

    GpuDevice(std::shared_ptr<VulkanDevice> vulkan, VkSemaphore timeline);
    Result<std::unique_ptr<GpuRecording>> take_recording();   ///< a used one where there is one
    void give_back(std::unique_ptr<GpuRecording> recording);  ///< one that was not submitted
    Result<std::uint64_t> submit(std::unique_ptr<GpuRecording> recording);
    void collect();  ///< reads timestamps of completed recordings and lets go of what they used
    VkResult wait_for(std::uint64_t value, std::chrono::nanoseconds timeout) const;
    void abandon();

    std::vector<GpuTime> read(
        const std::vector<GpuTime>& times);  ///< under the lock `collect` writes them in

    std::shared_ptr<VulkanDevice> vulkan_;
    VkSemaphore timeline_ = VK_NULL_HANDLE;
    std::atomic<std::chrono::nanoseconds> patience_;
    mutable std::atomic<std::uint64_t> completed_ = 0;  // as last seen
    std::mutex mutex_;
    std::uint64_t submitted_ = 0;
    std::deque<std::unique_ptr<GpuRecording>> in_flight_;
    std::vector<std::unique_ptr<GpuRecording>> idle_;
};

/// At a program's end, before `main` returns: waits for software Vulkans that were given up at work, for each
/// as long as its patience. They compute and compile on threads of this process, which must not meet what
/// `exit` takes from the driver's libraries. A GPU of hardware needs nothing of this process, and is not
/// waited for. What has finished is let go.
void wait_for_given_up_gpus();

}  // namespace touchable
