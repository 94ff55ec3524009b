// A stream that somebody sends: any bytes, through a pipe, to be opened and read to their end.
#include <fcntl.h>
#include <unistd.h>

#include <string>

#include "engine/stream/receiving.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// In the end that is read: a pipe holds 64 KiB.
int pipe_with(std::string_view bytes) {
    int ends[2];
    require(::pipe2(ends, O_CLOEXEC) == 0, "there is no pipe");
    const auto some = bytes.substr(0, std::size_t{1} << 16U);
    require(::write(ends[1], some.data(), some.size()) == static_cast<ssize_t>(some.size()),
            "a pipe takes no bytes");
    ::close(ends[1]);
    return ends[0];
}

bool parse_stream(std::string_view bytes) {
    const int descriptor = pipe_with(bytes);
    StreamSource source;
    source.url = *read_stream_url("pipe:" + std::to_string(descriptor));
    auto clip = open_stream_clip(source);
    bool taken = is_taken(clip);
    constexpr std::int64_t most_frames = 200;  // each of those missing between is given
    for (std::int64_t number = 0; clip && number < most_frames; ++number) {
        const auto frame = (*clip)->next();
        taken = is_taken(frame) && taken;
        if (!frame || !*frame) break;
        require((*frame)->number == number, "frames are not numbered one by one");
        const Scene& scene = (*clip)->scene();
        require((*frame)->depth.width == scene.width && (*frame)->depth.height == scene.height,
                "depth is not of the scene's size");
        (void)(*frame)->depth.sample(scene.width - 1, scene.height - 1);
    }
    ::close(descriptor);
    return taken;
}

const Registered stream_target{{.name = "stream",
                                .parse = parse_stream,
                                .changes = 60,
                                .most_bytes = 8192,
                                .most_mebibytes = 2048,
                                .most_live_mebibytes = 2048}};

}  // namespace
}  // namespace touchable::fuzz
