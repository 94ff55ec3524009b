#include "engine/stream/memory_muxer.hpp"

#include <new>

#include "engine/base/try.hpp"

namespace touchable {

Result<std::unique_ptr<MemoryMuxer>> MemoryMuxer::open(const char* format) {
    silence_ffmpeg();
    AVFormatContext* context = nullptr;
    const int status = avformat_alloc_output_context2(&context, nullptr, format, nullptr);
    if (status < 0)
        return Error{ErrorKind::internal, "muxer " + std::string(format) + ": " + ffmpeg_text(status)};
    std::unique_ptr<MemoryMuxer> muxer(new MemoryMuxer(context));
    context->flags |= AVFMT_FLAG_BITEXACT;  // no random identifiers, no dates: same frames, same bytes
    constexpr int buffer_bytes = 1 << 16;
    auto* const buffer = static_cast<unsigned char*>(av_malloc(buffer_bytes));
    if (buffer)
        context->pb = avio_alloc_context(buffer, buffer_bytes, 1, muxer.get(), nullptr, append, nullptr);
    if (context->pb) return muxer;
    av_free(buffer);
    return muxer->check(AVERROR(ENOMEM)).error();
}

int MemoryMuxer::append(void* own, MuxedBytes* bytes, int count) {
    auto& all = static_cast<MemoryMuxer*>(own)->bytes_;
    try {
        all.insert(all.end(), bytes, bytes + count);
    } catch (const std::bad_alloc&) {
        return AVERROR(ENOMEM);
    }
    return count;
}

Result<int> MemoryMuxer::add_sound(const AVCodecParameters& codec, AVRational tick) {
    TRY_ASSIGN(AVStream* const stream, add_stream(tick));
    if (avcodec_parameters_copy(stream->codecpar, &codec) < 0) return memory_error();
    stream->codecpar->codec_tag = 0;  // of the other container
    return stream->index;
}

Result<StreamSound> StreamSound::open(const SoundPart& part) {
    TRY_ASSIGN(auto sound, StoredSound::open(part));
    return StreamSound(part, std::move(sound));
}

Result<void> StreamSound::give_until(std::int64_t until_ms, const Take& take) {
    while (true) {
        TRY_ASSIGN(const auto packet, sound_->next(until_ms - begin_ms_));
        if (!packet) return {};
        packet->pts += begin_ms_;
        packet->dts += begin_ms_;
        TRY(take(*packet));
    }
}

Result<void> StreamSound::give(std::uint64_t epoch, std::int64_t time_ns, const Take& take) {
    const std::int64_t time_ms = (time_ns + 500'000) / 1'000'000;
    if (epoch_ && *epoch_ != epoch) {
        TRY(give_until(time_ms - 1, take));
        TRY_ASSIGN(sound_, StoredSound::open(part_));
        begin_ms_ = time_ms;
    }
    epoch_ = epoch;
    return give_until(time_ms, take);
}

}  // namespace touchable
