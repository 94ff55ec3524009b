// SPDX-License-Identifier: Apache-2.0
#pragma once

// Vulkan's devices: a list, what each can do, and the one that is used.
//
// GpuFacts say what a device is and, if so, why it cannot be used. GpuDevice::open takes one by name or the
// best, with the features that kernels and drawing need, and optional ones if it has them. A lost device
// stays lost: every later call fails, and its memory is not freed while it may still be written
// (docs/architecture.md, A GPU that is lost).
//
// Threads: several may use a device, each with its own commands (gpu_commands.hpp).

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

/// One of Vulkan's structs, which state their own type; all else in it is 0.
template <class T>
T vulkan_struct(VkStructureType type) {
    T made{};
    made.sType = type;
    return made;
}

/// All that a query of Vulkan lists about `of`: it is asked for their number, then for the values. Empty if
/// it fails.
template <class Value, class Query, class... Of>
std::vector<Value> vulkan_list(Query query, Of... of) {
    std::uint32_t count = 0;
    std::vector<Value> values;
    if (query(of..., &count, nullptr) == VK_SUCCESS) values.resize(count);
    if (query(of..., &count, values.data()) != VK_SUCCESS) count = 0;
    values.resize(count);
    return values;
}

/// `software` is a Vulkan that computes on the CPU, such as Mesa's lavapipe.
enum class GpuKind { discrete, integrated, virtualised, software, other };

/// For people and JSON: "discrete", "integrated", "virtual", "software", "other".
std::string_view name_of(GpuKind kind);

/// The usual name of a device that reports another: "lavapipe" for llvmpipe; else empty.
std::string_view nickname_of(std::string_view device_name);

/// Properties of a Vulkan device, and what it lacks for this engine.
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
        std::uint32_t timestamp_bits = 0;  ///< valid bits of a timestamp, which wraps beyond them
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
    /// Times measured once on this machine, ms, and kept with the device's programs. Negative: not measured.
    /// Infinite: unavailable, or its result was wrong.
    struct Measured {
        double cpu_ms = -1, vulkan_ms = -1;   ///< a frame of 1920x1080 by either builder (measure_builders)
        double mesh_ms = -1, raster_ms = -1;  ///< a picture of it by either painter (measure_painters)
    };
    Measured measured{};
    std::vector<std::string> missing;  ///< what this engine needs and it lacks, in words; empty: usable

    bool usable() const { return missing.empty(); }
};

/// The device that a request means: "auto" (discrete before integrated, virtual and software; the first of a
/// kind), an index, or, in any case of letters, a part of a name or nickname, or a kind ("software", or
/// "cpu"). Refused (ErrorKind::gpu) if there is no such device, if a word means several usable ones, or if it
/// lacks something; the message names every device and what it lacks.
Result<std::size_t> choose_gpu(std::span<const GpuFacts> gpus, std::string_view request);

class GpuMessages;
class VulkanInstance;

/// The raw Vulkan: instance, device and queue. Everything made from them (buffers, programs, images) holds a
/// shared_ptr to this, never to GpuDevice, so that objects in flight do not keep GpuDevice alive for ever.
struct VulkanDevice : NonCopyable {
    /// A pipeline and its layouts. Set 0 is made of push descriptors.
    struct Pipeline : NonCopyable {
        ~Pipeline();

        /// A shader, whose `info` is valid as long as this and the constants live.
        struct Shader : NonCopyable {
            ~Shader();
            /// Loads SPIR-V for a stage, with specialisation constants 0, 1, ...
            Result<void> load(VulkanDevice& of, VkShaderStageFlagBits stage,
                              std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants);

            VulkanDevice* gpu = nullptr;
            std::vector<VkSpecializationMapEntry> entries;
            VkSpecializationInfo special{};
            VkPipelineShaderStageCreateInfo info{};
        };

        /// Makes both layouts: a descriptor of each type in set 0, and push constants, for these stages.
        Result<void> make_layouts(std::span<const VkDescriptorType> types, std::uint32_t push_bytes,
                                  VkShaderStageFlags stages);

        std::shared_ptr<VulkanDevice> vulkan;
        VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
        VkPipelineLayout pipeline_layout = VK_NULL_HANDLE;
        VkPipeline pipeline = VK_NULL_HANDLE;
    };

    /// A device's compiled kernels and measured times, for later runs.
    struct ProgramsToKeep {
        /// Writes the file, and makes its folder. Waits for the disk.
        Result<void> keep() const;

        std::filesystem::path file;
        std::string bytes;
    };

    ~VulkanDevice();  ///< waits until the device is idle

    GpuFacts facts;
    std::unique_ptr<VulkanInstance> instance;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;  ///< externally synchronised: lock `queue_mutex`
    std::uint32_t queue_family = 0;
    std::mutex queue_mutex;
    VkPhysicalDeviceMemoryProperties memory{};

    // Functions of extensions; null if the extension is optional and absent.
    PFN_vkCmdPushDescriptorSetKHR push_descriptors = nullptr;
    PFN_vkSetDebugUtilsObjectNameEXT set_name = nullptr;
    PFN_vkGetMemoryHostPointerPropertiesEXT host_memory_types = nullptr;

    /// The driver's compiled kernels of this run, and of earlier ones in `programs_file`, which has
    /// facts.measured, too. Null if unavailable.
    VkPipelineCache programs = VK_NULL_HANDLE;
    std::filesystem::path programs_file;  ///< empty: nothing is kept
    std::uint64_t kept_hash = 0;          ///< of its content

    /// Makes `programs`, from what an earlier run kept for this device and driver in `folder`, if anything.
    void open_programs(const std::filesystem::path& folder);
    /// Programs that were not kept or taken yet; nullopt if there are none. The destructor keeps the rest.
    /// One thread at a time.
    std::optional<ProgramsToKeep> take_new_programs();

    /// Sticky: once true, every submission and every wait fails.
    std::atomic<bool> lost = false;

    /// The error of a failed call ("vkQueueSubmit2: VK_ERROR_DEVICE_LOST on llvmpipe"); marks the device lost
    /// if the result says so.
    Error failed(std::string_view call, VkResult result);
    /// That error, if the call failed.
    Result<void> checked(std::string_view call, VkResult result);

    std::string take_kept(std::string bytes);

    /// The instance, as window systems want it.
    VkInstance instance_handle() const;

    /// Names an object for debuggers and validation messages; without the debug extension does nothing.
    void name_object(VkObjectType type, std::uint64_t handle, const std::string& name) const;
};

/// Keeps an object until the process ends: what a hanging GPU may still use must not be freed, nor its
/// device.
void leave_for_good(std::shared_ptr<const void> what);

/// Vulkan's devices, usable or not, in the order of `--gpu INDEX`. Empty for a Vulkan loader without a
/// driver; fails if no instance can be created.
Result<std::vector<GpuFacts>> list_gpus();

struct GpuOptions {
    std::string request = "auto";  ///< as in choose_gpu
    /// Enables the validation layer, synchronisation checks included; refused if it is not installed.
    /// TOUCHABLE_VULKAN_VALIDATION=1 in the environment enables it, too, and prints its messages to stderr.
    bool validation = false;
    /// Extensions of the window system that shows pictures; if there are any, the device also gets
    /// swapchains, and one without them is refused.
    std::vector<std::string> window_extensions{};
    /// Folder of programs kept from run to run, so that they are made quickly; it need not exist. Empty:
    /// none.
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
    /// Waits for work in flight, but not for a lost device: what that may still use is kept, for ever or
    /// until another one is opened after it has finished.
    ~GpuDevice();

    const GpuFacts& facts() const { return vulkan_->facts; }
    const std::shared_ptr<VulkanDevice>& vulkan() const { return vulkan_; }
    /// The validation layer's messages (vulkan_instance.hpp).
    std::shared_ptr<const GpuMessages> messages() const;

    /// The timeline's value so far: every submission up to it has completed. No lock; a lost device stands
    /// still.
    std::uint64_t completed() const;

    /// Waits for a value that GpuCommands::submit gave. Fails (ErrorKind::gpu) on a lost device, and if it
    /// takes longer than `patience` or `at_most`: a device that hangs is lost.
    Result<void> wait(std::uint64_t value,
                      std::chrono::nanoseconds at_most = std::chrono::nanoseconds::max());
    /// The longest wait of a thread that handles the user's keys.
    static constexpr std::chrono::seconds longest_picture{10};
    /// The longest wait. By default 10 s; a minute for software Vulkan, which compiles a kernel at its first
    /// dispatch and never hangs, but is slow on a busy processor.
    std::chrono::nanoseconds patience() const { return patience_; }
    void set_patience(std::chrono::nanoseconds patience) { patience_ = patience; }

    /// Whether all that was submitted has completed. Waits for it, as long as `wait` would; for a lost device
    /// not at all.
    bool comes_to_rest();

    /// True after the driver lost the device, a wait timed out, or `lose`. Sticky: open another one.
    bool lost() const { return vulkan_->lost; }

    /// From now on the device behaves as if the driver had lost it: for tests.
    void lose() { vulkan_->lost = true; }

private:
    friend class GpuCommands;

    GpuDevice(std::shared_ptr<VulkanDevice> vulkan, VkSemaphore timeline);
    Result<std::unique_ptr<GpuRecording>> take_recording();   ///< a used one if there is one
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

/// Call before `main` returns: waits for software Vulkans that were given up at work, each up to its
/// patience. They compute and compile on threads of this process, which must not use what `exit` destroys in
/// the driver's libraries. Hardware needs nothing of this process, and is not waited for. Frees what has
/// finished.
void wait_for_given_up_gpus();

}  // namespace touchable
