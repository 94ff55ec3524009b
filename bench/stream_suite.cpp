// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>

#include "bench/stream/stream_run.hpp"
#include "bench/suite.hpp"

namespace touchable {
namespace {

struct Network {
    std::string name;
    test::NetworkFaults faults;
};

const std::vector<Network>& networks() {
    static const std::vector<Network> all{
        {"", {}},
        {"-loss-0.1", {.loss = 0.001}},
        {"-loss-1", {.loss = 0.01}},
        {"-loss-5", {.loss = 0.05}},
        {"-burst-1", {.loss = 0.01, .burst = 8}},
        {"-delay-20-jitter-10", {.delay_ms = 20, .jitter_ms = 10}},
        {"-delay-20-jitter-10-loss-1", {.loss = 0.01, .delay_ms = 20, .jitter_ms = 10}},
    };
    return all;
}

}  // namespace

std::vector<BenchCase> stream_cases(bool quick) {
    const auto clips = std::make_shared<LiveClips>(quick ? 15 : 45);
    const int frames = quick ? 120 : 600;
    const LiveClip small{.scene = "globe", .width = 640, .height = 480, .frames = frames};
    const LiveClip large{.scene = "globe", .width = 1280, .height = 720, .frames = frames};
    std::vector<BenchCase> cases;
    const auto add = [&](const std::string& name, auto measure) {
        cases.push_back({name, [=](Figures& figures) -> Result<void> {
                             auto done = measure(figures);
                             if (done) return done;
                             return Error{done.error().kind, name + ": " + done.error().message};
                         }});
    };
    for (const int listeners : {1, 2, 5, 10, 20, 50})
        add("listeners-640x480-" + std::to_string(listeners),
            [=](Figures& figures) { return measure_listeners(listeners, small, *clips, figures); });
    // After those, because the first live run locks this process's memory.
    for (const LiveClip& clip : {small, large})
        add("replay-" + std::to_string(clip.width) + "x" + std::to_string(clip.height),
            [=](Figures& figures) { return measure_without_network(clip, *clips, figures); });
    for (const char* const transport : {"tcp", "http", "srt", "ts"}) {
        for (const Network& network : networks())
            add(std::string(transport) + "-640x480" + network.name, [=](Figures& figures) {
                return measure_stream({transport, small, network.faults}, *clips, figures);
            });
        add(std::string(transport) + "-1280x720", [=](Figures& figures) {
            return measure_stream({transport, large}, *clips, figures);
        });
    }
    return cases;
}

}  // namespace touchable
