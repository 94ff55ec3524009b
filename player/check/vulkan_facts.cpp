#include "player/check/vulkan_facts.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <utility>

#include "engine/gpu/gpu_commands.hpp"
#include "shaders/self_check.h"
#include "shaders/self_check.spv.h"

namespace touchable {
namespace {

constexpr std::uint32_t texels = 16384, words = 4 * texels;

struct Bench {
    std::shared_ptr<GpuDevice> gpu;
    GpuProgram program;
    GpuBuffer in, out;
};

Result<Bench> make_bench(const std::string& request) {
    auto gpu = GpuDevice::open({request, false});
    if (!gpu.ok()) return gpu.error();
    const GpuLayout layout = {sizeof(SelfCheckPush),
                              {GpuBindingKind::uniform_texels, GpuBindingKind::storage_buffer},
                              {SELF_CHECK_GROUP, 1, 1}};
    auto program = GpuProgram::create(**gpu, "self_check", self_check_spv, layout);
    if (!program.ok()) return program.error();
    auto in = GpuBuffer::create(**gpu, "self-check in", words * 4, GpuMemory::shared);
    if (!in.ok()) return in.error();
    auto out = GpuBuffer::create(**gpu, "self-check out", words * 4, GpuMemory::shared);
    if (!out.ok()) return out.error();
    for (std::uint32_t i = 0; i < words; ++i) in->mapped<std::uint32_t>()[i] = i * i;
    return Bench{std::move(*gpu), std::move(*program), std::move(*in), std::move(*out)};
}

Result<KernelRun> run(const Bench& bench, std::uint32_t salt) {
    const auto begun = std::chrono::steady_clock::now();
    auto commands = GpuCommands::begin(bench.gpu, "self-check");
    if (!commands.ok()) return commands.error();
    commands->dispatch(bench.program, SelfCheckPush{texels, salt}, {bench.in, bench.out},
                       {groups_for(texels, SELF_CHECK_GROUP)});
    commands->mark("self_check");
    const auto submission = std::move(*commands).submit();
    if (!submission.ok()) return submission.error();
    if (auto waited = submission->wait(); !waited.ok()) return waited.error();

    KernelRun facts;
    facts.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
    if (const auto times = submission->times(); !times.empty()) facts.device_ms = times.front().ms;
    const auto in = bench.in.mapped<std::uint32_t>(), out = bench.out.mapped<std::uint32_t>();
    facts.same_bits = true;
    for (std::uint32_t i = 0; i < words; ++i)
        if (out[i] != self_check_word(in[i], salt)) facts.same_bits = false;
    return facts;
}

Result<KernelFacts> run_often(const Bench& bench) {
    const auto first = run(bench, 0);
    if (!first.ok()) return first.error();
    std::array<KernelRun, KernelFacts::runs> later;
    for (std::size_t i = 0; i < later.size(); ++i) {
        const auto next = run(bench, static_cast<std::uint32_t>(i) + 1);
        if (!next.ok()) return next.error();
        later[i] = *next;
    }
    return facts_of(*first, later);
}

}  // namespace

KernelFacts facts_of(const KernelRun& first, std::span<const KernelRun> later) {
    KernelFacts facts;
    facts.first_ms = first.ms;
    facts.same_bits = first.same_bits;
    facts.least_device_ms = first.device_ms;
    std::vector<double> ms;
    for (const KernelRun& run : later) {
        ms.push_back(run.ms);
        facts.same_bits = facts.same_bits && run.same_bits;
        if (run.device_ms)
            facts.least_device_ms = std::min(facts.least_device_ms.value_or(*run.device_ms), *run.device_ms);
    }
    std::sort(ms.begin(), ms.end());
    facts.least_ms = ms.front();
    facts.p50_ms = ms[ms.size() / 2];
    return facts;
}

VulkanFacts vulkan_facts() {
    VulkanFacts facts;
    auto gpus = list_gpus();
    if (!gpus.ok()) {
        facts.unusable = gpus.error().message;
        return facts;
    }
    facts.gpus = std::move(*gpus);
    const auto chosen = choose_gpu(facts.gpus, "auto");
    if (!chosen.ok()) {
        facts.unusable = chosen.error().message;
        return facts;
    }
    facts.used = *chosen;
    const auto bench = make_bench(std::to_string(*chosen));
    const Result<KernelFacts> kernel = bench.ok() ? run_often(*bench) : bench.error();
    if (!kernel.ok()) {
        facts.unusable = kernel.error().message;
        return facts;
    }
    facts.kernel = *kernel;
    if (!kernel->same_bits)
        facts.unusable = "a kernel gives other bits than the CPU on " + facts.gpus[*chosen].name;
    return facts;
}

}  // namespace touchable
