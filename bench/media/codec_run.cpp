#include "bench/media/codec_run.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bench/clocks.hpp"
#include "bench/peak_memory.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {
namespace {

/// Least time per frame over the rounds, and the mean of these over the frames.
class LeastTimes {
public:
    explicit LeastTimes(std::size_t frames) : ms_(frames, HUGE_VAL) {}
    template <class Work>
    Result<void> time(std::size_t frame, Work&& work) {
        const std::int64_t begin = thread_cpu_ns();
        Result<void> done = work();
        const double ns = static_cast<double>(thread_cpu_ns() - begin) - clock_costs().thread_cpu;
        ms_[frame] = std::min(ms_[frame], std::max(ns, 0.0) * 1e-6);
        return done;
    }
    double mean() const {
        return std::accumulate(ms_.begin(), ms_.end(), 0.0) / static_cast<double>(ms_.size());
    }

private:
    std::vector<double> ms_;
};

double squared_error(const PlaneView& a, const PlaneView& b) {
    double sum = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width * a.channels; ++x) {
            const double d = a.row(y)[x] - b.row(y)[x];
            sum += d * d;
        }
    return sum / (static_cast<double>(a.width) * a.height * a.channels);
}

double mean_size(const std::vector<Packet>& packets) {
    double sum = 0;
    for (const Packet& packet : packets) sum += static_cast<double>(packet.size());
    return sum / static_cast<double>(packets.size());
}

double raw_bytes(const PlaneView& plane) {
    return static_cast<double>(plane.width) * plane.height * plane.channels * plane.bytes_per_sample;
}

/// Peak memory of an encoder and of a decoder, for two frames each.
Result<void> add_memory(const CodecChoice& choice, const std::vector<PlaneView>& planes, Figures& figures) {
    std::vector<Packet> packets(std::min<std::size_t>(planes.size(), 2));
    for (std::size_t n = 0; n < packets.size(); ++n)
        packets[n].reserve(static_cast<std::size_t>(2 * raw_bytes(planes[n])));
    const PeakMemory encoder;
    auto codec = choice.open(planes.front());
    if (!codec) return codec.error();
    for (std::size_t n = 0; n < packets.size(); ++n)
        if (auto done = (*codec)->encode(planes[n], packets[n]); !done) return done;
    if (const auto bytes = encoder.extra())
        figures.push_back({"encoder_mb", static_cast<double>(*bytes) * 1e-6, "MB"});
    const PeakMemory decoder;
    for (const Packet& packet : packets) {
        if (auto done = (*codec)->decode(packet); !done) return done;
        if (auto plane = (*codec)->plane(); !plane) return plane.error();
    }
    if (const auto bytes = decoder.extra())
        figures.push_back({"decoder_mb", static_cast<double>(*bytes) * 1e-6, "MB"});
    return {};
}

struct CodecTimes {
    explicit CodecTimes(std::size_t frames) : encode(frames), decode(frames), plane(frames) {}
    LeastTimes encode, decode, plane;
};

/// Encodes and decodes all frames once; returns the mean squared error.
Result<double> run_once(PlaneCodec& codec, const CodecChoice& choice, const std::vector<PlaneView>& planes,
                        std::vector<Packet>& packets, CodecTimes& times) {
    for (std::size_t n = 0; n < planes.size(); ++n)
        if (auto done = times.encode.time(n, [&] { return codec.encode(planes[n], packets[n]); }); !done)
            return done.error();
    double error = 0;
    for (std::size_t n = 0; n < planes.size(); ++n) {
        if (auto done = times.decode.time(n, [&] { return codec.decode(packets[n]); }); !done)
            return done.error();
        PlaneView plane;
        const auto taken = times.plane.time(n, [&]() -> Result<void> {
            auto decoded = codec.plane();
            if (!decoded) return decoded.error();
            plane = *decoded;
            return {};
        });
        if (!taken) return taken.error();
        if (choice.lossless && !same_samples(plane, planes[n]))
            return Error{ErrorKind::check, "frame " + std::to_string(n) + " is not what went in"};
        if (!choice.lossless) error += squared_error(plane, planes[n]);
    }
    return error / static_cast<double>(planes.size());
}

}  // namespace

Result<double> bytes_per_frame(const CodecChoice& choice, const std::vector<PlaneView>& planes) {
    auto codec = choice.open(planes.front());
    if (!codec) return codec.error();
    std::vector<Packet> packets(planes.size());
    for (std::size_t n = 0; n < planes.size(); ++n)
        if (auto done = (*codec)->encode(planes[n], packets[n]); !done) return done.error();
    return mean_size(packets);
}

Result<void> measure_codec(const CodecChoice& choice, const std::vector<PlaneView>& planes, double ffv1_bytes,
                           int rounds, Figures& figures) {
    auto codec = choice.open(planes.front());
    if (!codec) return codec.error();
    std::vector<Packet> packets(planes.size());
    CodecTimes times(planes.size());
    double error = 0, bytes = 0;
    for (int round = 0; round < rounds; ++round) {
        const auto ran = run_once(**codec, choice, planes, packets, times);
        if (!ran) return ran.error();
        if (round > 0) continue;
        error = *ran;
        bytes = mean_size(packets);
    }
    figures.push_back({"bytes", bytes, ""});
    figures.push_back({"vs_raw", bytes / raw_bytes(planes.front()), ""});
    figures.push_back({"vs_ffv1", bytes / ffv1_bytes, ""});
    figures.push_back({"encode_ms", times.encode.mean(), "ms"});
    figures.push_back({"decode_ms", times.decode.mean(), "ms"});
    figures.push_back({"plane_ms", times.plane.mean(), "ms"});
    if (auto done = add_memory(choice, planes, figures); !done) return done;
    if (!choice.lossless) figures.push_back({"psnr_db", 10 * std::log10(255.0 * 255 / error), "dB"});
    return {};
}

}  // namespace touchable
