#include "player/check/vulkan_report.hpp"

#include <ostream>

namespace touchable {
namespace {

constexpr const char* indent = "          ";

double mebibytes(std::uint64_t bytes) {
    return static_cast<double>(bytes) / (1024 * 1024);
}

void print_device(std::ostream& out, const GpuFacts& gpu) {
    out << gpu.name << ", " << name_of(gpu.kind);
    if (const auto nickname = nickname_of(gpu.name); !nickname.empty()) out << " (" << nickname << ')';
    out << ", Vulkan " << gpu.api;
    if (!gpu.driver.empty()) out << ", driver " << gpu.driver << ' ' << gpu.driver_info;
    for (const std::string& missing : gpu.missing)
        out << (&missing == &gpu.missing.front() ? "; lacks " : ", ") << missing;
    out << '\n';
}

void print_abilities(std::ostream& out, const GpuFacts& gpu) {
    const GpuLimits& limits = gpu.limits;
    out << indent << (gpu.unified_memory ? "memory shared with the CPU" : "memory of its own")
        << (gpu.import_alignment > 0 ? ", imports the CPU's" : ", does not import the CPU's")
        << (gpu.draws_triangles ? ", draws triangles" : ", draws no triangles")
        << (gpu.int64_atomics ? ", 64-bit atomics" : ", no 64-bit atomics")
        << (gpu.float64 ? ", doubles\n" : ", no doubles\n");
    out << indent << "at most " << mebibytes(limits.max_allocation) << " MiB in a buffer, "
        << mebibytes(limits.max_storage_buffer_range) << " MiB in a binding, "
        << limits.max_texel_buffer_elements << " texels, " << limits.max_push_constants
        << " bytes of push constants, workgroups of " << limits.max_group_invocations << ", subgroups of "
        << limits.subgroup_size << '\n';
}

void print_kernel(std::ostream& out, const KernelFacts& kernel) {
    out << indent << "a small kernel: " << (kernel.same_bits ? "the same bits" : "OTHER bits")
        << " as the CPU's, " << kernel.least_ms << " ms at best and " << kernel.p50_ms
        << " ms at the median of " << KernelFacts::runs << ", " << kernel.first_ms << " ms the first time";
    if (kernel.least_device_ms) out << "; " << *kernel.least_device_ms << " ms on the device";
    out << '\n';
}

nlohmann::ordered_json device_json(const GpuFacts& gpu) {
    const GpuLimits& limits = gpu.limits;
    return {{"name", gpu.name},
            {"kind", name_of(gpu.kind)},
            {"software", gpu.kind == GpuKind::software},
            {"api", gpu.api},
            {"driver", gpu.driver},
            {"driver_info", gpu.driver_info},
            {"missing", gpu.missing},
            {"features",
             {{"unified_memory", gpu.unified_memory},
              {"import_alignment", gpu.import_alignment},
              {"draws_triangles", gpu.draws_triangles},
              {"int64_atomics", gpu.int64_atomics},
              {"float64", gpu.float64}}},
            {"limits",
             {{"max_allocation", limits.max_allocation},
              {"max_storage_buffer_range", limits.max_storage_buffer_range},
              {"max_texel_buffer_elements", limits.max_texel_buffer_elements},
              {"max_push_constants", limits.max_push_constants},
              {"max_group_invocations", limits.max_group_invocations},
              {"max_group_size", limits.max_group_size},
              {"max_group_count", limits.max_group_count},
              {"max_shared_memory", limits.max_shared_memory},
              {"subgroup_size", limits.subgroup_size},
              {"min_storage_buffer_alignment", limits.min_storage_buffer_alignment},
              {"min_texel_buffer_alignment", limits.min_texel_buffer_alignment},
              {"timestamp_period_ns", limits.timestamp_period_ns},
              {"timestamp_bits", limits.timestamp_bits}}}};
}

}  // namespace

void print_vulkan(std::ostream& out, const VulkanFacts& facts) {
    for (std::size_t i = 0; i < facts.gpus.size(); ++i) {
        out << (i == 0 ? "vulkan    " : indent) << i << ' ';
        print_device(out, facts.gpus[i]);
    }
    if (facts.used) {
        if (facts.gpus.size() > 1) out << indent << "auto is " << *facts.used << '\n';
        print_abilities(out, facts.gpus[*facts.used]);
    }
    if (facts.kernel) print_kernel(out, *facts.kernel);
    if (!facts.unusable.empty())
        out << (facts.gpus.empty() ? "vulkan    " : indent) << facts.unusable << '\n';
}

nlohmann::ordered_json vulkan_json(const VulkanFacts& facts) {
    nlohmann::ordered_json out;
    out["usable"] = facts.unusable.empty();
    if (!facts.unusable.empty()) out["unusable"] = facts.unusable;
    out["devices"] = nlohmann::ordered_json::array();
    for (const GpuFacts& gpu : facts.gpus) out["devices"].push_back(device_json(gpu));
    if (facts.used) out["used"] = *facts.used;
    if (facts.kernel) {
        out["kernel"] = {{"same_bits", facts.kernel->same_bits},
                         {"first_ms", facts.kernel->first_ms},
                         {"least_ms", facts.kernel->least_ms},
                         {"p50_ms", facts.kernel->p50_ms}};
        if (facts.kernel->least_device_ms) out["kernel"]["least_device_ms"] = *facts.kernel->least_device_ms;
    }
    return out;
}

}  // namespace touchable
