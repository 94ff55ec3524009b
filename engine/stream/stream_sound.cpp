#include "engine/stream/stream_sound.hpp"

#include <utility>

extern "C" {
#include <libavcodec/packet.h>

#include "engine/base/try.hpp"
}

namespace touchable {

Result<StreamSound> StreamSound::open(const SoundPart& part) {
    TRY_ASSIGN(auto sound, StoredSound::open(part));
    return StreamSound(part, std::move(sound));
}

Result<StoredSound::Packet> StreamSound::next(std::int64_t until_ms) {
    auto packet = sound_->next(until_ms - begin_ms_);
    if (!packet || !*packet) return packet;
    (*packet)->pts += begin_ms_;
    (*packet)->dts += begin_ms_;
    return packet;
}

Result<void> StreamSound::begin_round(std::int64_t at_ms) {
    TRY_ASSIGN(auto sound, StoredSound::open(part_));
    sound_ = std::move(sound);
    begin_ms_ = at_ms;
    return {};
}

}  // namespace touchable
