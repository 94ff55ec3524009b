#pragma once

#include <vulkan/vulkan.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_buffer.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/gpu/gpu_program.hpp"

namespace touchable {

/// What one binding of a dispatch is: a buffer, or for storage buffers a part of one. Offsets are multiples
/// of limits.min_storage_buffer_alignment; texels are always the whole buffer.
struct GpuBinding {
    GpuBinding(const GpuBuffer& whole) : buffer(whole) {}
    GpuBinding(const GpuBuffer& part_of, std::size_t offset_bytes, std::size_t size_bytes)
        : buffer(part_of), offset(offset_bytes), bytes(size_bytes) {}

    /// Of texels: a uint32 each, and not four of them.
    static GpuBinding words(const GpuBuffer& whole) {
        GpuBinding binding(whole);
        binding.is_words = true;
        return binding;
    }

    const GpuBuffer& buffer;  ///< outlives the call it is handed to
    std::size_t offset = 0;
    std::optional<std::size_t> bytes;  ///< none: to the end
    bool is_words = false;

    VkBufferView texels() const { return is_words ? buffer.words() : buffer.texels(); }
};

/// Workgroups in x, y and z.
struct GpuGroups {
    std::uint32_t x = 1, y = 1, z = 1;
};

/// Who wrote, and who reads or writes next. Host needs no barrier: what the CPU wrote before the submission
/// is seen, and when a submission has completed the CPU sees what it wrote.
enum class GpuStage { compute, transfer, indirect, graphics };

/// Whether marks are timed. On a GPU that is software each timestamp ends what was drawn together, and its
/// threads wait for each other.
enum class GpuTiming { by_marks, none };

/// Milliseconds on the device between a mark and the one before it (the first: since `begin`).
struct GpuTime {
    std::string label;
    double ms = 0;
};

/// Work given to the queue; a handle.
class GpuSubmission {
public:
    std::uint64_t value() const { return value_; }  ///< on the device's timeline
    bool done() const { return device_->completed() >= value_; }
    Result<void> wait() const { return device_->wait(value_); }
    /// Of a picture that a person waits for.
    Result<void> wait_for_picture() const { return device_->wait(value_, GpuDevice::longest_picture); }
    /// By mark, in order; empty before it is done, and without timing.
    std::vector<GpuTime> times() const;

private:
    friend class GpuCommands;
    GpuSubmission(std::shared_ptr<GpuDevice> device, std::uint64_t value,
                  std::shared_ptr<const std::vector<GpuTime>> times)
        : device_(std::move(device)), value_(value), times_(std::move(times)) {}

    std::shared_ptr<GpuDevice> device_;
    std::uint64_t value_;
    std::shared_ptr<const std::vector<GpuTime>> times_;  // written by GpuDevice::collect under its lock
};

/// Records work and submits it. Not for two threads at once; any number of these may be recorded side by
/// side.
///
/// A call that makes no sense (wrong push constants, bindings, ranges: ErrorKind::internal) or is more than
/// this device can (too many groups, texels or bytes in one binding: ErrorKind::gpu) records nothing; the
/// first such fault is what `submit` returns, naming program and binding. Everything used is kept alive until
/// the submission has completed.
class GpuCommands {
public:
    /// Fails (ErrorKind::gpu) on a lost device. The label is for debuggers.
    static Result<GpuCommands> begin(std::shared_ptr<GpuDevice> device, const std::string& label,
                                     GpuTiming timing = GpuTiming::by_marks);
    GpuCommands(GpuCommands&&) noexcept;
    ~GpuCommands();  ///< what was not submitted is forgotten

    /// Runs `groups` workgroups; none where one of them is 0. `push` has exactly the size of the program's
    /// push constants, `bindings` are as many as its layout's.
    template <class Push>
    void dispatch(const GpuProgram& program, const Push& push, std::initializer_list<GpuBinding> bindings,
                  GpuGroups groups) {
        static_assert(std::is_trivially_copyable_v<Push>);
        dispatch_bytes(program, std::as_bytes(std::span(&push, 1)), bindings, groups);
    }
    /// For a program without push constants.
    void dispatch(const GpuProgram& program, std::initializer_list<GpuBinding> bindings, GpuGroups groups) {
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
    /// Writes `value` over and over; offset and size are multiples of 4.
    void fill(const GpuBuffer& buffer, std::uint32_t value, std::size_t offset, std::size_t bytes);
    void fill(const GpuBuffer& buffer, std::uint32_t value);

    /// What `from` has done before is done, and seen by what `to` does after.
    void barrier(GpuStage from, GpuStage to);

    /// Ends the stretch since the mark before (or `begin`); at most 31 of them.
    void mark(const std::string& label);

    /// For commands this class does not know (drawing): the command buffer, and what to keep alive for them.
    VkCommandBuffer handle() const;
    void keep(std::shared_ptr<const void> resource);

    /// Becomes true when these are submitted, and outlives them (GpuMade).
    std::shared_ptr<const bool> submitted() const { return submitted_; }

    /// Gives the work to the queue and does not wait for it.
    Result<GpuSubmission> submit() &&;
    /// Gives the work to the queue and waits until it is done, as `wait` does; nobody learns what its marks
    /// took, nor asks the driver.
    Result<void> run() &&;

private:
    GpuCommands(std::shared_ptr<GpuDevice> device, std::unique_ptr<GpuRecording> recording);
    void dispatch_bytes(const GpuProgram& program, std::span<const std::byte> push,
                        std::initializer_list<GpuBinding> bindings, GpuGroups groups);
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

/// How many groups of `size` cover `count` items.
constexpr std::uint32_t groups_for(std::uint32_t count, std::uint32_t size) {
    return count / size + (count % size != 0);
}

}  // namespace touchable
