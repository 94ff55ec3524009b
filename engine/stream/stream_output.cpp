#include "engine/stream/stream_output.hpp"

#include <algorithm>

#include "engine/printable.hpp"

namespace touchable {

std::int64_t wait_before_call_ns(int calls_in_vain) {
    constexpr std::int64_t shortest_ns = 500'000'000;
    constexpr int most_doublings = 4;
    return shortest_ns << std::clamp(calls_in_vain - 1, 0, most_doublings);
}

Result<std::unique_ptr<StreamOutput>> StreamOutput::create(const StreamUrl& url, const StreamRing& ring,
                                                           StreamAudience& audience) {
    const auto refused = [&](const std::string& right) {
        return usage_error(in_quotes(url.name()) + " cannot be sent to: " + right);
    };
    const bool is_srt = url.transport == StreamTransport::srt;
    if (!is_srt && url.transport != StreamTransport::udp) return refused("right would be srt:// or udp://");
    if (url.port == 0) return refused("it needs a port from 1 to 65535");
    auto output = (is_srt ? make_srt_output : make_udp_output)(url, ring, audience);
    if (!output && output.error().kind == ErrorKind::usage) return refused(output.error().message);
    if (!output) return input_error(url.name() + ": " + output.error().message);
    return output;
}

}  // namespace touchable
