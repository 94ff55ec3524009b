#pragma once

// Vulkan's devices: which there are, what each can do, and the one that is used.
//
// GpuFacts say of each device what it is and why it cannot be used, if so. GpuDevice::open takes one by name
// or the best, with the features that kernels and drawing need, and optional ones where it has them. A device
// that is lost stays lost: every call says so from then on, and its memory is not freed while it may still be
// written (docs/architecture.md, A GPU that is lost).
//
// A device may be used by several threads; each has its own commands (gpu_commands.hpp).

#include <vulkan/vulkan.h>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"

namespace touchable {

/// `software` is a Vulkan that computes on the CPU, such as Mesa's lavapipe.
enum class GpuKind { discrete, integrated, virtualised, software, other };

/// For people and JSON: "discrete", "integrated", "virtual", "software", "other".
std::string_view name_of(GpuKind kind);

/// What people call a device that calls itself otherwise: "lavapipe", where it says llvmpipe; else empty.
std::string_view nickname_of(std::string_view device_name);

/// What a Vulkan device says of itself, and what this engine needs and it lacks.
struct GpuFacts {
    /// The limits a kernel or a buffer of this engine can run into; bytes unless said otherwise.
    struct Limits {
        std::uint64_t max_storage_buffer_range = 0;   ///< of one binding
        std::uint64_t max_allocation = 0;             ///< of one buffer
        std::uint32_t max_texel_buffer_elements = 0;  ///< texels of one view
        std::uint32_t max_push_constants = 0;
        std::uint32_t max_group_invocations = 0;  ///< invocations of one workgroup
        std::array<std::uint32_t, 3> max_group_size{};
        std::array<std::uint32_t, 3> max_group_count{};
        std::uint32_t max_shared_memory = 0;    ///< of one workgroup
        std::uint32_t subgroup_size = 0;        ///< invocations
        std::uint32_t max_storage_buffers = 0;  ///< of one kernel
        std::uint32_t min_storage_buffer_alignment = 0;
        std::uint32_t min_texel_buffer_alignment = 0;
        double timestamp_period_ns = 0;    ///< of one tick of a timestamp; 0: the queue has none
        std::uint32_t timestamp_bits = 0;  ///< of a timestamp that count; beyond, it begins anew
    };

    std::string name;         ///< "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::string driver;       ///< "llvmpipe"
    std::string driver_info;  ///< "Mesa 22.3.6 (LLVM 15.0.6)"
    std::string api;          ///< "1.3.230"
    GpuKind kind = GpuKind::other;
    Limits limits;
    bool unified_memory = false;   ///< the CPU reads and writes device memory through its caches: no copies
    bool draws_triangles = false;  ///< its queue also does graphics
    bool int64_atomics = false;    ///< 64-bit atomics on storage buffers
    bool float64 = false;          ///< doubles in kernels
    std::uint64_t import_alignment = 0;  ///< of host memory that it imports; 0: it cannot
    /// What was measured on this machine, ms, once: kept with the device's programs. Negative: nothing was.
    /// Infinite: it cannot be had, or was wrong.
    struct Measured {
        double cpu_ms = -1, vulkan_ms = -1;   ///< a frame of 1920x1080 by either builder (measure_builders)
        double over_bus_ms = -1;              ///< by the latter where kernels reach over the bus
        double mesh_ms = -1, raster_ms = -1;  ///< a picture of it by either painter (measure_painters)
    };
    Measured measured{};
    std::vector<std::string> missing;  ///< what this engine needs and it lacks, in words; empty: usable

    bool usable() const { return missing.empty(); }
};

/// Which device a request means: "auto" (discrete before integrated, virtual and software; the first of a
/// kind), the index of a device, or, upper or lower case alike, a part of one's name or nickname or its kind
/// ("software", or "cpu"). Refused (ErrorKind::gpu) where there is no such device, where a word means several
/// usable ones, or where it lacks something; the message names every device and what it lacks.
Result<std::size_t> choose_gpu(std::span<const GpuFacts> gpus, std::string_view request);

class GpuMessages;
class VulkanInstance;

/// What a device's driver made of kernels, and what was measured of it, for the runs to come.
struct ProgramsToKeep {
    std::filesystem::path file;
    std::string bytes;
};
/// Writes the file, and makes its folder. Waits for the disk.
Result<void> keep_programs(const ProgramsToKeep& programs);

/// The raw Vulkan: instance, device and queue. Everything made from them (buffers, programs, images) holds a
/// shared_ptr to this, never to GpuDevice, so that it can be in flight there without keeping it alive for
/// ever.
struct VulkanDevice : NonCopyable {
    ~VulkanDevice();  ///< waits until the device is idle

    GpuFacts facts;
    std::unique_ptr<VulkanInstance> instance;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;  ///< externally synchronised: lock `queue_mutex`
    std::uint32_t queue_family = 0;
    std::mutex queue_mutex;
    VkPhysicalDeviceMemoryProperties memory{};

    // Functions of extensions; null where the extension is optional and absent.
    PFN_vkCmdPushDescriptorSetKHR push_descriptors = nullptr;
    PFN_vkSetDebugUtilsObjectNameEXT set_name = nullptr;
    PFN_vkGetMemoryHostPointerPropertiesEXT host_memory_types = nullptr;

    /// What the driver has made of kernels: of this run, and of earlier ones in `programs_file`, where
    /// facts.measured is kept too. Null where it cannot be had.
    VkPipelineCache programs = VK_NULL_HANDLE;
    std::filesystem::path programs_file;  ///< empty: nothing is kept
    std::uint64_t kept_hash = 0;          ///< of what is in it

    /// Makes `programs`, of what an earlier run kept for this device and driver in `folder`, if anything.
    void open_programs(const std::filesystem::path& folder);
    /// What is new since it was kept or taken, to be kept; nothing where nothing is. The device's end keeps
    /// the rest. One thread at a time.
    std::optional<ProgramsToKeep> take_new_programs();

    /// Sticky: once true, every submission and every wait fails.
    std::atomic<bool> lost = false;

    /// The error of a failed call ("vkQueueSubmit2: VK_ERROR_DEVICE_LOST on llvmpipe"); marks the device lost
    /// where the result says so.
    Error failed(std::string_view call, VkResult result);
    /// That error, where the call failed.
    Result<void> checked(std::string_view call, VkResult result);

    std::string take_kept(std::string bytes);

    /// The instance, as window systems want it.
    VkInstance instance_handle() const;

    /// What debuggers and validation messages call an object; nothing without the debug extension.
    void name_object(VkObjectType type, std::uint64_t handle, const std::string& name) const;
};

/// Keeps something until the process ends: what a GPU that hangs may still use must not be freed under it,
/// nor the device it belongs to.
void leave_for_good(std::shared_ptr<const void> what);

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
    /// Where programs are kept from run to run, so that they are made quickly; it need not exist. Empty:
    /// nowhere.
    std::filesystem::path cache_folder{};
};

struct GpuRecording;  // a command buffer and what it needs (gpu_recording.hpp)

/// An open device with its one queue. Submissions run in order, each sees all that earlier ones wrote, and
/// what they use is kept alive until they have completed. Safe from any thread.
class GpuDevice {
public:
    /// Milliseconds on the device between a mark and the one before it (the first: since `begin`).
    struct Time {
        std::string label;
        double ms = 0;
    };
    static Result<std::shared_ptr<GpuDevice>> open(const GpuOptions& options = {});
    /// Waits for what is in flight, but not for a lost device: what that may still be at work on is left as
    /// it is, for ever or until another one is opened after it has finished.
    ~GpuDevice();

    const GpuFacts& facts() const { return vulkan_->facts; }
    const std::shared_ptr<VulkanDevice>& vulkan() const { return vulkan_; }
    /// What the validation layer says (vulkan_instance.hpp).
    std::shared_ptr<const GpuMessages> messages() const;

    /// The timeline's value so far: every submission up to it has completed. No lock; a lost device stands
    /// still.
    std::uint64_t completed() const;

    /// Waits for a value that GpuCommands::submit gave. Fails (ErrorKind::gpu) on a lost device, and where
    /// that takes longer than the patience there is, or than `at_most`: a device that hangs is lost.
    Result<void> wait(std::uint64_t value,
                      std::chrono::nanoseconds at_most = std::chrono::nanoseconds::max());
    /// The longest wait of a thread that takes a person's keys.
    static constexpr std::chrono::seconds longest_picture{10};
    /// By default 10 s; a minute for a software Vulkan, which compiles a kernel at its first dispatch
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

    GpuDevice(std::shared_ptr<VulkanDevice> vulkan, VkSemaphore timeline);
    Result<std::unique_ptr<GpuRecording>> take_recording();   ///< a used one where there is one
    void give_back(std::unique_ptr<GpuRecording> recording);  ///< one that was not submitted
    Result<std::uint64_t> submit(std::unique_ptr<GpuRecording> recording);
    void collect();  ///< reads timestamps of completed recordings and lets go of what they used
    void abandon();
    std::vector<Time> read(const std::vector<Time>& times);  ///< under the lock `collect` writes them in

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
