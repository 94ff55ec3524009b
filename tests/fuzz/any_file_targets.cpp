// What a person gives the program: any file.
#include "engine/formats/formats_read.hpp"
#include "engine/formats/open_clip.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace touchable::fuzz {
namespace {

/// Opened as it is, and with a camera that is known. Without an ending: its first bytes tell.
bool parse_any_file(std::string_view bytes) {
    const auto file = file_of(bytes, "input");
    const bool taken = is_clip(open_clip(file));
    SourceDescription known;
    known.fov = 60;
    known.metres_per_code = 0.001;
    (void)is_clip(open_clip(file, std::nullopt, known));
    return taken;
}

/// An archive of pictures, which is unpacked.
bool parse_zip(std::string_view bytes) {
    return is_clip(open_clip(file_of(bytes, "pictures.zip")));
}

/// A video of depth as others write them, whose demuxers and decoders are FFmpeg's.
bool parse_video(std::string_view bytes) {
    return is_clip(open_clip(file_of(bytes, "video.mp4")));
}

const Registered any_file_target{{.name = "any_file",
                                  .parse = parse_any_file,
                                  .changes = 100,
                                  .most_mebibytes = 2048,
                                  .most_live_mebibytes = 2048}};
const Registered zip_folder_target{{.name = "zip_folder",
                                    .parse = parse_zip,
                                    .cuts_are_refused = true,
                                    .changes = 100,
                                    .most_mebibytes = 2048,
                                    .most_live_mebibytes = 2048}};
const Registered video_target{{.name = "video",
                               .parse = parse_video,
                               .changes = 60,
                               .most_bytes = 8192,
                               .most_mebibytes = 2048,
                               .most_live_mebibytes = 2048}};

}  // namespace
}  // namespace touchable::fuzz
