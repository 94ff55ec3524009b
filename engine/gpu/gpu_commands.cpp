// SPDX-License-Identifier: Apache-2.0
#include "engine/gpu/gpu_commands.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/gpu/gpu_recording.hpp"

namespace touchable {

namespace {

struct Scope {
    VkPipelineStageFlags2 stage;
    VkAccessFlags2 writes, uses;
};

/// By GpuStage: compute, transfer, indirect and graphics.
constexpr Scope scopes[] = {
    {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_WRITE_BIT,
     VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT},
    {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
     VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT},
    {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_NONE, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT},
    {VK_PIPELINE_STAGE_2_ALL_GRAPHICS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
     VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT}};

bool is_within(std::size_t offset, std::size_t bytes, std::size_t size) {
    return offset <= size && bytes <= size - offset;
}

std::string range_text(std::size_t offset, std::size_t bytes, const GpuBuffer& buffer) {
    return std::to_string(bytes) + " bytes from " + std::to_string(offset) + " of buffer '" + buffer.name() +
           "' (" + std::to_string(buffer.size()) + " bytes)";
}

/// Refuses a binding beyond the device's limits.
Result<void> check_binding(GpuBindingKind kind, const GpuBinding& binding, const GpuFacts::Limits& limits) {
    const GpuBuffer& buffer = binding.buffer;
    if (kind != GpuBindingKind::storage_buffer && !binding.texels())
        return gpu_error("buffer '" + buffer.name() + "' has more texels than a view may");
    if (kind == GpuBindingKind::storage_buffer && buffer.size() > limits.max_storage_buffer_range)
        return gpu_error(range_text(0, buffer.size(), buffer) + ", at most " +
                         std::to_string(limits.max_storage_buffer_range) + " in one binding");
    return {};
}

/// Descriptors of one dispatch, and what they point to.
struct Descriptors {
    static constexpr std::size_t most = 32;  // what every device with push descriptors takes

    void add(GpuBindingKind kind, const GpuBinding& binding) {
        VkWriteDescriptorSet& write = writes[count];
        write = vulkan_struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
        write.dstBinding = count;
        write.descriptorCount = 1;
        write.descriptorType = descriptor_type(kind);
        if (kind == GpuBindingKind::storage_buffer) {
            buffers[count] = {binding.buffer.handle(), 0, binding.buffer.size()};
            write.pBufferInfo = &buffers[count];
        } else {
            texels[count] = binding.texels();
            write.pTexelBufferView = &texels[count];
        }
        ++count;
    }

    std::uint32_t count = 0;
    std::array<VkWriteDescriptorSet, most> writes;
    std::array<VkDescriptorBufferInfo, most> buffers;
    std::array<VkBufferView, most> texels;
};

}  // namespace

std::vector<GpuDevice::Time> GpuCommands::Submission::times() const {
    return device_->read(*times_);
}

Result<GpuCommands> GpuCommands::begin(std::shared_ptr<GpuDevice> device, const std::string& label,
                                       GpuTiming timing) {
    TRY_ASSIGN(auto recording, device->take_recording());
    TRY(recording->begin(timing));
    device->vulkan()->name_object(VK_OBJECT_TYPE_COMMAND_BUFFER,
                                  reinterpret_cast<std::uint64_t>(recording->commands), label);
    return GpuCommands(std::move(device), std::move(recording));
}

GpuCommands::GpuCommands(std::shared_ptr<GpuDevice> device, std::unique_ptr<GpuRecording> recording)
    : device_(std::move(device)),
      recording_(std::move(recording)),
      submitted_(std::make_shared<bool>(false)) {}
GpuCommands::GpuCommands(GpuCommands&&) noexcept = default;

GpuCommands::~GpuCommands() {
    if (recording_) device_->give_back(std::move(recording_));
}

void GpuCommands::fault(std::string message, ErrorKind kind) {
    if (kind == ErrorKind::gpu) message += " on " + device_->facts().name;
    if (!fault_) fault_ = Error{kind, std::move(message)};
}

bool GpuCommands::bind(const GpuProgram& program, std::span<const std::byte> push,
                       std::initializer_list<GpuBinding> bindings) {
    if (!program) return fault("a kernel that does not exist was dispatched"), false;
    const std::string kernel = "kernel " + program.name() + ": ";
    const GpuLayout& layout = program.layout();
    if (push.size() != layout.push_bytes)
        return fault(kernel + std::to_string(push.size()) + " bytes of push constants instead of " +
                     std::to_string(layout.push_bytes)),
               false;
    if (bindings.size() != layout.bindings.size() || bindings.size() > Descriptors::most)
        return fault(kernel + std::to_string(bindings.size()) + " bindings instead of " +
                     std::to_string(layout.bindings.size())),
               false;

    Descriptors descriptors;
    for (const GpuBinding& binding : bindings) {
        const std::string which = kernel + "binding " + std::to_string(descriptors.count) + ": ";
        if (!binding.buffer) return fault(which + "there is no buffer"), false;
        const GpuBindingKind kind = layout.bindings[descriptors.count];
        const auto checked = check_binding(kind, binding, device_->facts().limits);
        if (!checked) return fault(which + checked.error().message, checked.error().kind), false;
        descriptors.add(kind, binding);
        keep(binding.buffer.keep_alive());
    }
    keep(program.keep_alive());

    const VkCommandBuffer commands = recording_->commands;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, program.pipeline());
    if (descriptors.count > 0)
        device_->vulkan()->push_descriptors(commands, VK_PIPELINE_BIND_POINT_COMPUTE,
                                            program.pipeline_layout(), 0, descriptors.count,
                                            descriptors.writes.data());
    if (!push.empty())
        vkCmdPushConstants(commands, program.pipeline_layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                           static_cast<std::uint32_t>(push.size()), push.data());
    return true;
}

void GpuCommands::dispatch_bytes(const GpuProgram& program, std::span<const std::byte> push,
                                 std::initializer_list<GpuBinding> bindings, Groups groups) {
    const auto& most = device_->facts().limits.max_group_count;
    if (groups.x > most[0] || groups.y > most[1] || groups.z > most[2])
        return fault("kernel " + (program ? program.name() : "") + ": " + size_text(groups.x, groups.y) +
                         "x" + std::to_string(groups.z) + " workgroups are too many",
                     ErrorKind::gpu);
    if (!bind(program, push, bindings)) return;
    if (groups.x > 0 && groups.y > 0 && groups.z > 0)
        vkCmdDispatch(recording_->commands, groups.x, groups.y, groups.z);
}

void GpuCommands::dispatch_indirect_bytes(const GpuProgram& program, std::span<const std::byte> push,
                                          std::initializer_list<GpuBinding> bindings, const GpuBuffer& groups,
                                          std::size_t offset) {
    if (!groups || offset % 4 != 0 || !is_within(offset, sizeof(VkDispatchIndirectCommand), groups.bytes()))
        return fault("kernel " + (program ? program.name() : "") + ": there are no workgroup counts at " +
                     std::to_string(offset));
    if (!bind(program, push, bindings)) return;
    keep(groups.keep_alive());
    vkCmdDispatchIndirect(recording_->commands, groups.handle(), offset);
}

void GpuCommands::copy(const GpuBuffer& from, std::size_t from_offset, const GpuBuffer& to,
                       std::size_t to_offset, std::size_t bytes) {
    if (!from || !to) return fault("a copy from or to no buffer");
    if (!is_within(from_offset, bytes, from.size()))
        return fault("a copy: " + range_text(from_offset, bytes, from) + " are not there");
    if (!is_within(to_offset, bytes, to.size()))
        return fault("a copy: " + range_text(to_offset, bytes, to) + " are not there");
    if (from.handle() == to.handle() && from_offset < to_offset + bytes && to_offset < from_offset + bytes)
        return fault("a copy within buffer '" + from.name() + "' overlaps");
    if (bytes == 0) return;
    const VkBufferCopy region{from_offset, to_offset, bytes};
    vkCmdCopyBuffer(recording_->commands, from.handle(), to.handle(), 1, &region);
    keep(from.keep_alive());
    keep(to.keep_alive());
}

void GpuCommands::fill(const GpuBuffer& buffer, std::uint32_t value, std::size_t offset, std::size_t bytes) {
    if (!buffer) return fault("a fill of no buffer");
    if (offset % 4 != 0 || bytes % 4 != 0 || !is_within(offset, bytes, buffer.size()))
        return fault("a fill: " + range_text(offset, bytes, buffer) + " are not whole words of it");
    if (bytes == 0) return;
    vkCmdFillBuffer(recording_->commands, buffer.handle(), offset, bytes, value);
    keep(buffer.keep_alive());
}

void GpuCommands::barrier(GpuStage from, GpuStage to) {
    const Scope before = scopes[static_cast<std::size_t>(from)], after = scopes[static_cast<std::size_t>(to)];
    record_barrier(recording_->commands, before.stage, before.writes, after.stage, after.uses);
}

void GpuCommands::mark(const std::string& label) {
    if (recording_->labels.size() == GpuRecording::max_marks)
        return fault("mark '" + label + "' is one too many for one submission");
    recording_->labels.push_back(label);
    recording_->stamp();
}

VkCommandBuffer GpuCommands::handle() const {
    return recording_->commands;
}

void GpuCommands::keep(std::shared_ptr<const void> resource) {
    recording_->kept.push_back(std::move(resource));
}

Result<GpuCommands::Submission> GpuCommands::submit() && {
    if (fault_) return *fault_;
    TRY(recording_->end());
    std::shared_ptr<const std::vector<GpuDevice::Time>> times = recording_->times;
    TRY_ASSIGN(const auto value, device_->submit(std::move(recording_)));
    *submitted_ = true;
    return Submission(device_, value, std::move(times));
}

Result<void> GpuCommands::run() && {
    const std::shared_ptr<GpuDevice> device = device_;
    std::uint64_t value = 0;
    {
        TRY_ASSIGN(const auto submission, std::move(*this).submit());
        value = submission.value();
    }
    return device->wait(value);
}

void record_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 written,
                    VkPipelineStageFlags2 to, VkAccessFlags2 used) {
    auto barrier = vulkan_struct<VkMemoryBarrier2>(VK_STRUCTURE_TYPE_MEMORY_BARRIER_2);
    barrier.srcStageMask = from;
    barrier.srcAccessMask = written;
    barrier.dstStageMask = to;
    barrier.dstAccessMask = used;
    auto info = vulkan_struct<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
    info.memoryBarrierCount = 1;
    info.pMemoryBarriers = &barrier;
    vkCmdPipelineBarrier2(commands, &info);
}

std::uint64_t ticks_between(std::uint64_t from, std::uint64_t to, std::uint32_t bits) {
    const std::uint64_t passed = to - from;
    return bits < 64 ? passed & ((std::uint64_t{1} << bits) - 1) : passed;
}

Result<std::unique_ptr<GpuRecording>> GpuRecording::create(std::shared_ptr<VulkanDevice> vulkan) {
    auto made = std::make_unique<GpuRecording>();
    made->vulkan = std::move(vulkan);
    VulkanDevice& gpu = *made->vulkan;

    auto pool = vulkan_struct<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.queueFamilyIndex = gpu.queue_family;
    TRY(gpu.checked("vkCreateCommandPool", vkCreateCommandPool(gpu.device, &pool, nullptr, &made->pool)));

    auto buffer = vulkan_struct<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    buffer.commandPool = made->pool;
    buffer.commandBufferCount = 1;
    TRY(gpu.checked("vkAllocateCommandBuffers",
                    vkAllocateCommandBuffers(gpu.device, &buffer, &made->commands)));

    if (gpu.facts.limits.timestamp_period_ns > 0) {
        auto stamps = vulkan_struct<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
        stamps.queryType = VK_QUERY_TYPE_TIMESTAMP;
        stamps.queryCount = max_marks + 1;
        TRY(gpu.checked("vkCreateQueryPool", vkCreateQueryPool(gpu.device, &stamps, nullptr, &made->stamps)));
    }
    return made;
}

GpuRecording::~GpuRecording() {
    if (stamps) vkDestroyQueryPool(vulkan->device, stamps, nullptr);
    if (pool) vkDestroyCommandPool(vulkan->device, pool, nullptr);  // and its command buffer
}

Result<void> GpuRecording::begin(GpuTiming timing) {
    release();
    is_timed = stamps && timing == GpuTiming::by_marks;
    times = std::make_shared<std::vector<GpuDevice::Time>>();
    TRY(vulkan->checked("vkResetCommandPool", vkResetCommandPool(vulkan->device, pool, 0)));
    auto info = vulkan_struct<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    TRY(vulkan->checked("vkBeginCommandBuffer", vkBeginCommandBuffer(commands, &info)));
    record_barrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                   VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                   VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
    if (is_timed) vkCmdResetQueryPool(commands, stamps, 0, max_marks + 1);
    stamp();
    return {};
}

void GpuRecording::stamp() {
    if (is_timed) vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, stamps, stamp_count++);
}

Result<void> GpuRecording::end() {
    record_barrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                   VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT);
    return vulkan->checked("vkEndCommandBuffer", vkEndCommandBuffer(commands));
}

void GpuRecording::read_times() {
    if (labels.empty() || !is_timed) return;
    std::array<std::uint64_t, max_marks + 1> ticks{};
    const VkResult result =
        vkGetQueryPoolResults(vulkan->device, stamps, 0, stamp_count, stamp_count * sizeof(ticks[0]),
                              ticks.data(), sizeof(ticks[0]), VK_QUERY_RESULT_64_BIT);
    if (result != VK_SUCCESS) return;  // work without times is still work
    const GpuFacts::Limits& limits = vulkan->facts.limits;
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const auto passed = static_cast<double>(ticks_between(ticks[i], ticks[i + 1], limits.timestamp_bits));
        times->push_back({labels[i], passed * limits.timestamp_period_ns * 1e-6});
    }
}

void GpuRecording::release() {
    kept.clear();
    labels.clear();
    stamp_count = 0;
    value = 0;
    times.reset();
}

}  // namespace touchable
