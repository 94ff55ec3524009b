#include "engine/clip/read_along.hpp"

#include <utility>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

struct DescriptionDeleter {
    void operator()(AVFormatContext* container) const { avformat_free_context(container); }
};

}  // namespace

Result<std::unique_ptr<ReadAlong>> ReadAlong::open(const TrackEncoder& encoder, PlaneRole role) {
    const std::unique_ptr<AVFormatContext, DescriptionDeleter> container(avformat_alloc_context());
    AVStream* const stream = container ? avformat_new_stream(container.get(), nullptr) : nullptr;
    if (!stream) return Error{ErrorKind::internal, "out of memory"};
    TRY(encoder.describe(*stream->codecpar));
    TRY_ASSIGN(auto decoder, TrackDecoder::open(*stream, role, "what is written"));
    return std::unique_ptr<ReadAlong>(new ReadAlong(std::move(decoder)));
}

/// The encoder holds no picture back, so none waits for a later one.
Result<void> ReadAlong::add(const AVPacket& packet) {
    if (auto sent = decoder_.send(&packet); !sent) return sent;
    TRY_ASSIGN(auto picture, decoder_.receive());
    if (!picture)
        return Error{ErrorKind::internal, decoder_.where() + ": is not decoded before the next one"};
    newest_ = std::move(picture->plane);
    return {};
}

}  // namespace touchable
