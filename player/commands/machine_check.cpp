// SPDX-License-Identifier: Apache-2.0
#include "player/commands/machine_check.hpp"

extern "C" {
#include <libavutil/avutil.h>
}

#include <pwd.h>
#include <sched.h>
#include <sys/prctl.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <ostream>

#include "engine/base/files.hpp"
#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "engine/gpu/gpu_commands.hpp"
#include "shaders/self_check.h"
#include "shaders/self_check.spv.h"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t texels = 16384, words = 4 * texels;

struct Bench {
    std::shared_ptr<GpuDevice> gpu;
    GpuProgram program;
    GpuBuffer in, out;
};

Result<Bench> make_bench(const std::string& request) {
    TRY_ASSIGN(auto gpu, GpuDevice::open({request, false}));
    const GpuLayout layout = {sizeof(SelfCheckPush),
                              {GpuBindingKind::uniform_texels, GpuBindingKind::storage_buffer},
                              {SELF_CHECK_GROUP, 1, 1}};
    TRY_ASSIGN(auto program, GpuProgram::create(*gpu, "self_check", self_check_spv, layout));
    TRY_ASSIGN(auto in, GpuBuffer::create(*gpu, "self-check in", words * 4, GpuMemory::shared));
    TRY_ASSIGN(auto out, GpuBuffer::create(*gpu, "self-check out", words * 4, GpuMemory::shared));
    for (std::uint32_t i = 0; i < words; ++i) in.mapped<std::uint32_t>()[i] = i * i;
    return Bench{std::move(gpu), std::move(program), std::move(in), std::move(out)};
}

Result<KernelRun> run(const Bench& bench, std::uint32_t salt) {
    const auto begun = std::chrono::steady_clock::now();
    TRY_ASSIGN(auto commands, GpuCommands::begin(bench.gpu, "self-check"));
    commands.dispatch(bench.program, SelfCheckPush{texels, salt}, {bench.in, bench.out},
                      {groups_for(texels, SELF_CHECK_GROUP)});
    commands.mark("self_check");
    TRY_ASSIGN(const auto submission, std::move(commands).submit());
    TRY(submission.wait());

    KernelRun facts;
    facts.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
    if (const auto times = submission.times(); !times.empty()) facts.device_ms = times.front().ms;
    const auto in = bench.in.mapped<std::uint32_t>(), out = bench.out.mapped<std::uint32_t>();
    facts.same_bits = true;
    for (std::uint32_t i = 0; i < words; ++i)
        if (out[i] != self_check_word(in[i], salt)) facts.same_bits = false;
    return facts;
}

Result<KernelFacts> run_often(const Bench& bench) {
    TRY_ASSIGN(const auto first, run(bench, 0));
    std::array<KernelRun, KernelFacts::runs> later;
    for (std::size_t i = 0; i < later.size(); ++i) {
        TRY_ASSIGN(later[i], run(bench, static_cast<std::uint32_t>(i) + 1));
    }
    return facts_of(first, later);
}

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
    const GpuFacts::Limits& limits = gpu.limits;
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
    const GpuFacts::Limits& limits = gpu.limits;
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

/// Tried on a thread of its own, so that the priority ends with it.
bool may_run_realtime() {
    bool permitted = false;
    std::thread trial;
    const auto started = start_thread(trial, "realtime-trial", "that tries to be real-time", [&] {
        sched_param priority = {};
        priority.sched_priority = haptic_priority;
        permitted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
    });
    if (started) trial.join();
    return permitted;
}

constexpr int trial_ticks = 1000;
constexpr double ms_per_second = 1000, us_per_ms = 1000;

/// Fewer frames if they are large: some 6 of 1920x1080.
int trial_frames(const TouchDemand& demand) {
    const double pixels = static_cast<double>(demand.width) * demand.height;
    return static_cast<int>(std::clamp(12e6 / pixels, 4.0, 30.0));
}

double cpu_ms() {
    return static_cast<double>(clock_ns(CLOCK_PROCESS_CPUTIME_ID)) * 1e-6;
}

/// Writes a clip whose surface moves in every frame. Colour does not affect touch.
Result<void> make_clip(const TouchDemand& demand, const fs::path& file, int frames) {
    SceneOptions options;
    options.width = demand.width;
    options.height = demand.height;
    TRY_ASSIGN(const auto source, make_scene("moving", options));
    TRY_ASSIGN(auto writer, create_clip(file, source->scene()));
    for (int n = 0; n < frames; ++n) {
        if (stop_requested()) return interrupted_error();
        TRY(writer->write(source->frame(n)));
    }
    return writer->finish();
}

/// Excludes frames read before, during which threads start and memory is allocated.
Result<void> measure_frames(TouchSetup& setup, int frames, TrialFigures& figures) {
    SurfaceFeed& feed = *setup.feed;
    const auto before = static_cast<int>(feed.frames());
    feed.forget_times();
    const double cpu_before = cpu_ms();
    for (int n = before; n < frames; ++n) {
        if (stop_requested()) return interrupted_error();
        TRY(feed.pair_at(setup.scene.rate.time_ns(n - 1)));
    }
    figures.frames = static_cast<int>(feed.frames()) - before;
    figures.frame_cpu_ms = (cpu_ms() - cpu_before) / figures.frames;
    figures.decode_ms = feed.read_ms().spread();
    figures.build_ms = feed.build_ms().spread();
    figures.builder = feed.builder_name();
    return {};
}

/// Runs between the last two frames, so that nothing is decoded.
Result<void> measure_ticks(TouchSetup& setup, int frames, TrialFigures& figures) {
    setup.options.ticks = trial_ticks;
    setup.options.given_tick = [&setup,
                                frames](std::int64_t tick) -> Result<TouchSessionSettings::GivenTick> {
        TRY_ASSIGN(const auto pair, setup.feed->pair_of(frames - 2, frames - 1,
                                                        static_cast<double>(tick) / trial_ticks));
        return {{tick * tick_ns, pair}};
    };
    TouchFigures taken;
    TouchSink* const sinks[] = {&taken};
    const double cpu_before = cpu_ms();
    TRY(TouchSession(*setup.feed, *setup.hand, *setup.solver, setup.options).run(sinks));
    figures.ticks = static_cast<int>(taken.ticks());
    figures.tick_cpu_us = us_per_ms * (cpu_ms() - cpu_before) / figures.ticks;
    figures.tick_us = taken.tick_us();
    return {};
}

/// Usable share of the machine and of each deadline: other programs run too, and frames' times vary.
constexpr double usable_share = 0.9;

std::string figure(double value) {
    return formatted(value < 100 ? "%.3g" : "%.0f", value);
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
    std::ranges::sort(ms);
    facts.least_ms = ms.front();
    facts.p50_ms = ms[ms.size() / 2];
    return facts;
}

VulkanFacts vulkan_facts() {
    VulkanFacts facts;
    const auto found = [&facts]() -> Result<void> {
        TRY_ASSIGN(facts.gpus, list_gpus());
        TRY_ASSIGN(facts.used, choose_gpu(facts.gpus, "auto"));
        TRY_ASSIGN(const auto bench, make_bench(std::to_string(*facts.used)));
        TRY_ASSIGN(facts.kernel, run_often(bench));
        return {};
    }();
    if (!found)
        facts.unusable = found.error().message;
    else if (!facts.kernel->same_bits)
        facts.unusable = "a kernel gives other bits than the CPU on " + facts.gpus[*facts.used].name;
    return facts;
}

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

std::vector<std::string> ways_to_realtime(const std::string& user, const std::string& program) {
    const std::string priority = std::to_string(haptic_priority);
    return {"lines \"" + user + " - rtprio " + priority + "\" and \"" + user +
                " - memlock unlimited\" in /etc/security/limits.d/touchable.conf, then log in again",
            "sudo setcap cap_sys_nice,cap_ipc_lock=ep " + program,
            "as a systemd service: LimitRTPRIO=" + priority + " and LimitMEMLOCK=infinity in its unit",
            "in a container: start it with --cap-add=SYS_NICE --cap-add=IPC_LOCK"};
}

std::vector<std::string> ways_to_realtime() {
    const passwd* user = getpwuid(getuid());
    const fs::path program = program_file();
    return ways_to_realtime(user ? user->pw_name : "USER", program.empty() ? "touchable" : program.string());
}

CpuFacts cpu_facts() {
    CpuFacts facts;
    facts.cores = static_cast<int>(std::thread::hardware_concurrency());
    std::ifstream cpuinfo("/proc/cpuinfo");
    for (std::string line; std::getline(cpuinfo, line);) {
        if (line.rfind("model name", 0) != 0) continue;
        const std::size_t colon = line.find(':');
        if (colon != std::string::npos && colon + 2 < line.size()) facts.model = line.substr(colon + 2);
        break;
    }
    if (facts.model.empty()) facts.model = "not named by the kernel";
    return facts;
}

TimerFacts timer_facts() {
    TimerFacts facts;
    timespec resolution = {};
    clock_getres(CLOCK_MONOTONIC, &resolution);
    facts.clock_resolution_ns =
        static_cast<double>(resolution.tv_sec) * 1e9 + static_cast<double>(resolution.tv_nsec);
    facts.timer_slack_ns = static_cast<double>(prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0));
    facts.realtime_permitted = may_run_realtime();

    std::array<double, 200> late_us{};
    auto wake = std::chrono::steady_clock::now();
    for (double& late : late_us) {
        wake += std::chrono::milliseconds(1);
        sleep_until(wake);
        late = std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - wake).count();
    }
    std::ranges::sort(late_us);
    facts.late_p50_us = late_us[late_us.size() / 2];
    facts.late_max_us = late_us.back();
    return facts;
}

FfmpegFacts ffmpeg_facts() {
    return {av_version_info(),
            {{"matroska reader", av_find_input_format("matroska") != nullptr},
             {"matroska writer", av_guess_format("matroska", nullptr, nullptr) != nullptr},
             {"ffv1 decoder", avcodec_find_decoder(AV_CODEC_ID_FFV1) != nullptr},
             {"ffv1 encoder", avcodec_find_encoder(AV_CODEC_ID_FFV1) != nullptr},
             {"h264 decoder", avcodec_find_decoder(AV_CODEC_ID_H264) != nullptr},
             {"h264 encoder", avcodec_find_encoder(AV_CODEC_ID_H264) != nullptr},
             {"png decoder", avcodec_find_decoder(AV_CODEC_ID_PNG) != nullptr},
             {"png encoder", avcodec_find_encoder(AV_CODEC_ID_PNG) != nullptr},
             {"jpeg decoder", avcodec_find_decoder(AV_CODEC_ID_MJPEG) != nullptr}}};
}

Result<TrialFigures> try_touch(const TouchDemand& demand) {
    TRY_ASSIGN(const auto folder, ScratchFolder::create("check"));
    SessionOptions options;
    options.clip.file = folder->path() / "trial.mkv";
    options.fingers = demand.fingers;
    options.clip.filters =
        ClipChoice::Filters::off();  // no survey reads frames before, so all are decoded here
    options.clip.filters.settings.median = 3;
    options.live = true;
    const int frames = 2 + trial_frames(demand);  // the first two are read to place the hand
    TRY(make_clip(demand, options.clip.file, frames));
    TRY_ASSIGN(auto setup, setup_from_options(options));
    TrialFigures figures;
    TRY(measure_frames(*setup, frames, figures));
    TRY(measure_ticks(*setup, frames, figures));
    return figures;
}

double TrialFigures::cpu_ms_per_second(const TouchDemand& demand) const {
    return demand.rate * frame_cpu_ms + ms_per_second * tick_cpu_us / us_per_ms;
}

TrialVerdict judge(const TouchDemand& demand, const TrialFigures& figures, int cores) {
    const double frame_ms = ms_per_second / demand.rate;
    const double usable_ms = usable_share * cores * ms_per_second;
    const double left_ms = usable_ms - figures.tick_cpu_us;  // us per tick = ms per second
    struct Need {
        const char* what;
        double takes, may;
        const char* unit;
    };
    const Need needs[] = {
        {"a tick", figures.tick_us.p99, usable_share * us_per_ms, "us"},
        {"decoding a frame", figures.decode_ms.mean, usable_share * frame_ms, "ms"},
        {"building a frame", figures.build_ms.mean, usable_share * frame_ms, "ms"},
        {"all of it", figures.cpu_ms_per_second(demand), usable_ms, "ms of CPU time a second"}};
    const Need* tightest = std::ranges::max_element(
        needs, [](const Need& a, const Need& b) { return a.takes / a.may < b.takes / b.may; });
    TrialVerdict verdict;
    verdict.can = tightest->takes <= tightest->may;
    verdict.why = std::string(tightest->what) + " takes " + figure(tightest->takes) + " of the " +
                  figure(tightest->may) + " " + tightest->unit + " it may";
    const double slower = std::max(figures.decode_ms.mean, figures.build_ms.mean);
    if (needs[0].takes <= needs[0].may && left_ms > 0)
        verdict.most_rate =
            std::floor(std::min(usable_share * ms_per_second / slower, left_ms / figures.frame_cpu_ms));
    return verdict;
}

nlohmann::ordered_json trial_json(const TouchDemand& demand, const TrialFigures& figures,
                                  const TrialVerdict& verdict, int cores) {
    return {{"touchable_trial", 1},
            {"width", demand.width},
            {"height", demand.height},
            {"fingers", demand.fingers},
            {"rate", demand.rate},
            {"can", verdict.can},
            {"why", verdict.why},
            {"most_rate", verdict.most_rate},
            {"builder", figures.builder},
            {"frames", figures.frames},
            {"ticks", figures.ticks},
            {"decode_ms", to_json(figures.decode_ms)},
            {"build_ms", to_json(figures.build_ms)},
            {"tick_us", to_json(figures.tick_us)},
            {"cpu_ms_per_second", figures.cpu_ms_per_second(demand)},
            {"cores", cores}};
}

std::string trial_to_text(const TouchDemand& demand, const TrialFigures& figures, const TrialVerdict& verdict,
                          int cores) {
    const auto spread = [](const Spread& s, const char* unit) {
        return figure(s.mean) + " " + unit + " at the mean, " + figure(s.p99) + " p99, " + figure(s.max) +
               " at worst";
    };
    std::string text = (verdict.can ? "yes: " : "no: ") + demand.in_words() +
                       (verdict.can ? "; " : " is too much here; ") + verdict.why + "\n";
    text += "decode    " + spread(figures.decode_ms, "ms") + " of " + std::to_string(figures.frames) +
            " frames (generated: depth of 16 bits and colour)\n";
    text += "build     " + spread(figures.build_ms, "ms") + "; " + figures.builder + " builder, median 3x3\n";
    text += "tick      " + spread(figures.tick_us, "us") + " of " + std::to_string(figures.ticks) +
            ", all fingers; the next one is due after 1000\n";
    text += "cpu time  " + formatted("%.0f ms a second, of ", figures.cpu_ms_per_second(demand)) +
            counted(cores, "core") + '\n';
    if (figures.is_crowded())
        text += "note      other programs kept the cores busy; ask again when they rest\n";
    text += "at most   " + formatted("%.0f frames/s", verdict.most_rate) + " with as many fingers\n";
    return text;
}

}  // namespace touchable
