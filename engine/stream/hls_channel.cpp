#include "engine/stream/hls_channel.hpp"

#include "engine/base/try.hpp"

namespace touchable {
namespace {

class HlsChannel final : public StreamMuxer {
public:
    explicit HlsChannel(HlsWriter& writer) : writer_(writer) {}
    std::span<const std::uint8_t> header() const override { return {}; }
    Result<StreamBlock> add(const RawFrame& frame, const PictureLabel& label, std::int64_t time_ns,
                            bool is_key) override {
        TRY(writer_.add(frame, label, time_ns));
        return StreamBlock{label.frame, is_key, {}};
    }

private:
    HlsWriter& writer_;
};

}  // namespace

std::unique_ptr<StreamMuxer> make_hls_channel(HlsWriter& writer) {
    return std::make_unique<HlsChannel>(writer);
}

}  // namespace touchable
