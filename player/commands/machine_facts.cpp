#include "player/commands/machine_facts.hpp"

#include <pthread.h>
#include <pwd.h>
#include <sched.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <thread>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avutil.h>
}

#include "engine/base/start_thread.hpp"
#include "haptics_cpu/realtime.hpp"

namespace touchable {
namespace {

constexpr long nanoseconds_per_second = 1'000'000'000;

double nanoseconds(const timespec& t) {
    return static_cast<double>(t.tv_sec) * static_cast<double>(nanoseconds_per_second) +
           static_cast<double>(t.tv_nsec);
}

/// Tried on a thread of its own, which ends with what it was given.
bool may_run_realtime() {
    bool permitted = false;
    std::thread trial;
    const auto started = start_thread(trial, "realtime-trial", "that tries to be real-time", [&] {
        sched_param priority = {};
        priority.sched_priority = haptic_priority;
        permitted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
    });
    if (started.ok()) trial.join();
    return permitted;
}

}  // namespace

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
    std::error_code fault;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", fault);
    return ways_to_realtime(user ? user->pw_name : "USER", fault ? "touchable" : program.string());
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
    facts.clock_resolution_ns = nanoseconds(resolution);
    facts.timer_slack_ns = static_cast<double>(prctl(PR_GET_TIMERSLACK, 0, 0, 0, 0));
    facts.realtime_permitted = may_run_realtime();

    std::array<double, 200> late_us{};
    timespec wake = {};
    clock_gettime(CLOCK_MONOTONIC, &wake);
    for (double& late : late_us) {
        wake.tv_nsec += 1'000'000;
        if (wake.tv_nsec >= nanoseconds_per_second) {
            wake.tv_nsec -= nanoseconds_per_second;
            ++wake.tv_sec;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
        timespec now = {};
        clock_gettime(CLOCK_MONOTONIC, &now);
        late = (nanoseconds(now) - nanoseconds(wake)) / 1000.0;
    }
    std::sort(late_us.begin(), late_us.end());
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
             {"libx264 encoder", avcodec_find_encoder_by_name("libx264") != nullptr},
             {"libx264rgb encoder", avcodec_find_encoder_by_name("libx264rgb") != nullptr},
             {"png decoder", avcodec_find_decoder(AV_CODEC_ID_PNG) != nullptr},
             {"png encoder", avcodec_find_encoder(AV_CODEC_ID_PNG) != nullptr},
             {"jpeg decoder", avcodec_find_decoder(AV_CODEC_ID_MJPEG) != nullptr}}};
}

}  // namespace touchable
