// SPDX-License-Identifier: Apache-2.0
#pragma once

// Work on a GPU: its memory, its programs, and commands on one timeline.
//
// A GpuBuffer is memory that a CPU, a GPU or both reach. A GpuProgram is a compute kernel of shaders/ with
// its specialisation constants and bindings. GpuCommands record dispatches, copies and barriers and submit
// them once; waits are for a submission's number, and end if the GPU hangs (patience).
//
// Threads: one uses GpuCommands. Errors are of kind gpu; those of invalid calls are of kind internal.

#include <vulkan/vulkan.h>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <type_traits>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/scene/plane_memory.hpp"

namespace touchable {

/// Where a buffer's memory is. All but `device` are mapped for the CPU, coherently.
enum class GpuMemory {
    shared,    ///< both sides work on it: in device memory if that is cached for the CPU, else in host memory
    device,    ///< for the GPU alone
    upload,    ///< written by the CPU once and in order, read by the GPU
    readback,  ///< written by the GPU, read by the CPU
};

/// A buffer, usable as storage, as texels (rgba32ui, the whole of it), for copies, and as indirect, vertex
/// and index data. A handle: copies are the same buffer, which lives until the last of them and the last
/// submission that uses it are gone. Its first content is undefined.
class GpuBuffer {
public:
    GpuBuffer() = default;

    /// `bytes` (at least 1) are rounded up to whole texels of 16. Fails (ErrorKind::gpu) if the memory cannot
    /// be allocated; the name identifies the buffer in errors and debuggers.
    static Result<GpuBuffer> create(const GpuDevice& device, std::string name, std::size_t bytes,
                                    GpuMemory memory);

    /// Imports the CPU's memory, to be copied from or read as storage, without a copy here. It stays in place
    /// as long as the buffer. Fails (ErrorKind::gpu) if the device imports no memory.
    static Result<GpuBuffer> import(const GpuDevice& device, std::string name,
                                    std::shared_ptr<const PlaneBlock> block);

    /// Keeps the buffer if it is large enough; else replaces it by a new one, as `create` makes it.
    Result<void> reserve(const GpuDevice& device, const char* name, std::size_t bytes, GpuMemory memory);

    explicit operator bool() const { return state_ != nullptr; }
    const std::string& name() const { return state_->name; }
    std::size_t bytes() const { return state_->bytes; }  ///< as asked for
    std::size_t size() const { return state_->size; }    ///< in whole texels: what kernels may touch
    VkBuffer handle() const { return state_->buffer; }
    /// Null if the buffer has more texels than a view may (limits.max_texel_buffer_elements).
    VkBufferView texels() const { return state_->texels; }
    /// The same with texels of one uint32 each.
    VkBufferView words() const { return state_->words; }

    /// The buffer as the CPU sees it; empty for GpuMemory::device. Writes before a submission are seen by it,
    /// and what it wrote is seen once it has completed.
    template <class T>
    std::span<T> mapped() const {
        static_assert(std::is_trivially_copyable_v<T>);
        if (!state_->mapped) return {};
        return {reinterpret_cast<T*>(state_->mapped), state_->bytes / sizeof(T)};
    }

    /// Keeps the buffer (and `mapped`) alive, for users that need not know its type.
    std::shared_ptr<const void> keep_alive() const { return state_; }

private:
    struct State {
        ~State();

        std::shared_ptr<VulkanDevice> vulkan;
        std::string name;
        std::size_t bytes = 0;
        std::size_t size = 0;  // rounded up to whole texels
        VkBuffer buffer = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        VkBufferView texels = VK_NULL_HANDLE, words = VK_NULL_HANDLE;
        void* mapped = nullptr;
        std::shared_ptr<const PlaneBlock> imported;
    };
    static Result<std::shared_ptr<State>> make_state(const GpuDevice& device, std::string name,
                                                     std::size_t bytes, bool imported = false);
    static Result<void> allocate(State& state, std::uint32_t memory_type, std::size_t bytes);
    static Result<void> make_views(State& state);

    std::shared_ptr<const State> state_;
};

/// The memory type that serves a use best, among those whose bit is set in `allowed`; nullopt if no type
/// serves it.
std::optional<std::uint32_t> choose_memory_type(const VkPhysicalDeviceMemoryProperties& memory,
                                                std::uint32_t allowed, GpuMemory use);

enum class GpuBindingKind {
    storage_buffer,
    uniform_texels,  ///< usamplerBuffer / utextureBuffer, rgba32ui
};

/// A kernel's interface as C++ knows it, from its shaders/name.h.
struct GpuLayout {
    std::uint32_t push_bytes = 0;          ///< sizeof the push constants; 0: none
    std::vector<GpuBindingKind> bindings;  ///< of set 0, binding numbers 0, 1, 2...
    std::array<std::uint32_t, 3> group_size{1, 1, 1};
};

/// The difference between a kernel's SPIR-V and its GpuLayout, in words; empty if there is none. Only tests
/// define it (tests/gpu/spirv_layout.hpp), to check each kernel that they create: the program need not, as
/// both are of one build.
[[gnu::weak]] std::string layout_fault(std::span<const std::uint32_t> spirv, const GpuLayout& layout,
                                       std::span<const std::uint32_t> constants);

/// A compute pipeline. A handle, as GpuBuffer is.
class GpuProgram {
public:
    GpuProgram() = default;

    /// `constants` are the values of specialisation constants 0, 1, 2... (floats and ints as their bits, bool
    /// 0 or 1). Refused with ErrorKind::gpu if the device or its driver cannot, and in tests with
    /// ErrorKind::internal if there is a `layout_fault`; the message names the kernel.
    static Result<GpuProgram> create(const GpuDevice& device, std::string name,
                                     std::span<const std::uint32_t> spirv, GpuLayout layout,
                                     std::span<const std::uint32_t> constants = {});

    explicit operator bool() const { return state_ != nullptr; }
    const std::string& name() const { return state_->name; }
    const GpuLayout& layout() const { return state_->layout; }
    VkPipeline pipeline() const { return state_->pipeline; }
    VkPipelineLayout pipeline_layout() const { return state_->pipeline_layout; }
    std::shared_ptr<const void> keep_alive() const { return state_; }

private:
    struct State : VulkanDevice::Pipeline {
        std::string name;
        GpuLayout layout;
    };
    std::shared_ptr<const State> state_;
};

/// One binding of a dispatch: a whole buffer.
struct GpuBinding {
    GpuBinding(const GpuBuffer& whole) : buffer(whole) {}

    /// Texels of one uint32 each, not four.
    static GpuBinding words(const GpuBuffer& whole) {
        GpuBinding binding(whole);
        binding.is_words = true;
        return binding;
    }

    const GpuBuffer& buffer;  ///< outlives the call it is handed to
    bool is_words = false;

    VkBufferView texels() const { return is_words ? buffer.words() : buffer.texels(); }
};

/// The stage that wrote, and the one that reads or writes next. The CPU needs no barrier: a submission sees
/// what it wrote before, and once a submission has completed the CPU sees its writes.
enum class GpuStage { compute, transfer, indirect, graphics };

/// Whether marks are timed. On a software GPU each timestamp ends a batch of drawing, and its threads wait
/// for each other.
enum class GpuTiming { by_marks, none };

/// How many groups of `size` cover `count` items.
constexpr std::uint32_t groups_for(std::uint32_t count, std::uint32_t size) {
    return count / size + (count % size != 0);
}

/// Records work and submits it. Used by one thread; several may be recorded in parallel.
///
/// An invalid call (wrong push constants, bindings, ranges: ErrorKind::internal) or one beyond the device's
/// limits (too many groups, texels or bytes in one binding: ErrorKind::gpu) records nothing; `submit` returns
/// the first such fault, naming program and binding. Everything used is kept alive until the submission has
/// completed.
class GpuCommands {
public:
    /// Workgroups in x, y and z.
    struct Groups {
        std::uint32_t x = 1, y = 1, z = 1;
    };
    /// Work given to the queue; a handle.
    class Submission {
    public:
        std::uint64_t value() const { return value_; }  ///< on the device's timeline
        bool done() const { return device_->completed() >= value_; }
        Result<void> wait() const { return device_->wait(value_); }
        /// The same for a picture that the user waits for.
        Result<void> wait_for_picture() const { return device_->wait(value_, GpuDevice::longest_picture); }
        /// By mark, in order; empty before it is done, and without timing.
        std::vector<GpuDevice::Time> times() const;

    private:
        friend class GpuCommands;
        Submission(std::shared_ptr<GpuDevice> device, std::uint64_t value,
                   std::shared_ptr<const std::vector<GpuDevice::Time>> times)
            : device_(std::move(device)), value_(value), times_(std::move(times)) {}

        std::shared_ptr<GpuDevice> device_;
        std::uint64_t value_;
        std::shared_ptr<const std::vector<GpuDevice::Time>>
            times_;  // written by GpuDevice::collect under its lock
    };
    /// Whether something that is made on a device once may be used: by the commands that make it, after that,
    /// and by other commands once these were submitted. Commands that are never submitted make nothing. What
    /// the CPU makes may be used at once.
    class Made {
    public:
        void by(const GpuCommands& commands) { submitted_ = commands.submitted(); }
        void by_cpu() { submitted_ = std::make_shared<const bool>(true); }
        void reset() { submitted_.reset(); }
        bool is_there_for(const GpuCommands& commands) const {
            return submitted_ && (*submitted_ || submitted_ == commands.submitted());
        }

    private:
        std::shared_ptr<const bool> submitted_;
    };

    /// Fails (ErrorKind::gpu) on a lost device. The label is for debuggers.
    static Result<GpuCommands> begin(std::shared_ptr<GpuDevice> device, const std::string& label,
                                     GpuTiming timing = GpuTiming::by_marks);
    GpuCommands(GpuCommands&&) noexcept;
    ~GpuCommands();  ///< drops what was not submitted

    /// Runs `groups` workgroups; none if one of them is 0. `push` has exactly the size of the program's push
    /// constants, `bindings` are as many as its layout's.
    template <class Push>
    void dispatch(const GpuProgram& program, const Push& push, std::initializer_list<GpuBinding> bindings,
                  Groups groups) {
        static_assert(std::is_trivially_copyable_v<Push>);
        dispatch_bytes(program, std::as_bytes(std::span(&push, 1)), bindings, groups);
    }
    /// For a program without push constants.
    void dispatch(const GpuProgram& program, std::initializer_list<GpuBinding> bindings, Groups groups) {
        dispatch_bytes(program, {}, bindings, groups);
    }
    /// The groups are three uint32 at `offset` (a multiple of 4) of `groups`, written before (barrier to
    /// GpuStage::indirect) or by the CPU.
    template <class Push>
    void dispatch_indirect(const GpuProgram& program, const Push& push,
                           std::initializer_list<GpuBinding> bindings, const GpuBuffer& groups,
                           std::size_t offset = 0) {
        static_assert(std::is_trivially_copyable_v<Push>);
        dispatch_indirect_bytes(program, std::as_bytes(std::span(&push, 1)), bindings, groups, offset);
    }

    /// Copies bytes; the ranges lie in the buffers and do not overlap.
    void copy(const GpuBuffer& from, std::size_t from_offset, const GpuBuffer& to, std::size_t to_offset,
              std::size_t bytes);
    /// Writes `value` repeatedly; offset and size are multiples of 4.
    void fill(const GpuBuffer& buffer, std::uint32_t value, std::size_t offset, std::size_t bytes);
    void fill(const GpuBuffer& buffer, std::uint32_t value) {
        fill(buffer, value, 0, buffer ? buffer.size() : 0);
    }

    /// Earlier work of `from` is completed, and seen by later work of `to`.
    void barrier(GpuStage from, GpuStage to);

    /// Ends the interval since the mark before (or `begin`); at most 31 marks.
    void mark(const std::string& label);

    /// For commands this class does not know (drawing): the command buffer, and what to keep alive for them.
    VkCommandBuffer handle() const;
    void keep(std::shared_ptr<const void> resource);

    /// Becomes true when these commands are submitted; outlives them (Made).
    std::shared_ptr<const bool> submitted() const { return submitted_; }

    /// Gives the work to the queue and does not wait for it.
    Result<Submission> submit() &&;
    /// Gives the work to the queue and waits until it is done, as `wait` does; the times of its
    /// marks are not read.
    Result<void> run() &&;

private:
    GpuCommands(std::shared_ptr<GpuDevice> device, std::unique_ptr<GpuRecording> recording);
    void dispatch_bytes(const GpuProgram& program, std::span<const std::byte> push,
                        std::initializer_list<GpuBinding> bindings, Groups groups);
    void dispatch_indirect_bytes(const GpuProgram& program, std::span<const std::byte> push,
                                 std::initializer_list<GpuBinding> bindings, const GpuBuffer& groups,
                                 std::size_t offset);
    bool bind(const GpuProgram& program, std::span<const std::byte> push,
              std::initializer_list<GpuBinding> bindings);
    void fault(std::string message, ErrorKind kind = ErrorKind::internal);

    std::shared_ptr<GpuDevice> device_;
    std::unique_ptr<GpuRecording> recording_;
    std::shared_ptr<bool> submitted_;
    std::optional<Error> fault_;
};

}  // namespace touchable
