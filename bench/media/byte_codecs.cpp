#include "bench/media/byte_codecs.hpp"

#include <zstd.h>

#include <cstring>
#include <span>
#include <type_traits>

#include "engine/clip/track_codecs.hpp"
#include "engine/clip/tracks.hpp"

namespace touchable {
namespace {

/// A codec with its own memory for the decoded plane.
class ByteCodec : public PlaneCodec {
public:
    explicit ByteCodec(const PlaneView& form) : form_(form) {
        form_.stride = std::ptrdiff_t{form.width} * form.channels * form.bytes_per_sample;
        samples_.resize(static_cast<std::size_t>(form_.stride) * static_cast<std::size_t>(form.height));
        form_.data = samples_.data();
    }
    Result<PlaneView> plane() override { return form_; }

protected:
    std::size_t row_bytes() const { return static_cast<std::size_t>(form_.stride); }
    /// A row of the decoded plane.
    std::uint8_t* row(int y) { return samples_.data() + form_.stride * y; }
    static Error damaged(const char* what) {
        return {ErrorKind::check, std::string(what) + ": a packet cannot be read back"};
    }

    PlaneView form_;
    std::vector<std::uint8_t> samples_;
};

class RawCodec final : public ByteCodec {
public:
    using ByteCodec::ByteCodec;
    Result<void> encode(const PlaneView& plane, Packet& packet) override {
        packet.resize(samples_.size());
        for (int y = 0; y < plane.height; ++y)
            std::memcpy(packet.data() + form_.stride * y, plane.row(y), row_bytes());
        return {};
    }
    Result<void> decode(const Packet& packet) override {
        if (packet.size() != samples_.size()) return damaged("raw");
        std::memcpy(samples_.data(), packet.data(), packet.size());
        return {};
    }
};

template <class Sample>
std::uint32_t folded(int difference) {
    using Signed = std::make_signed_t<Sample>;
    const auto d = static_cast<Signed>(difference);  // modulo the samples' range
    constexpr int sign = 8 * sizeof(Sample) - 1;
    return static_cast<Sample>(static_cast<Sample>(d) << 1 ^ static_cast<Sample>(d >> sign));
}

inline int unfolded(std::uint32_t code) {
    return static_cast<int>(code >> 1) ^ -static_cast<int>(code & 1);
}

/// Whole numbers in groups of 3 bits, the lowest first; a fourth bit marks that another group follows.
class NibbleWriter {
public:
    explicit NibbleWriter(Packet& packet) : packet_(packet) { packet.clear(); }
    void put(std::uint32_t value) {
        do {
            const std::uint32_t rest = value >> 3;
            word_ |= ((value & 7) | (rest ? 8U : 0U)) << bits_;
            bits_ += 4;
            if (bits_ == 32) flush();
            value = rest;
        } while (value);
    }
    void flush() {
        const std::size_t at = packet_.size();
        packet_.resize(at + 4);
        std::memcpy(packet_.data() + at, &word_, 4);
        word_ = 0;
        bits_ = 0;
    }

private:
    Packet& packet_;
    std::uint32_t word_ = 0;
    int bits_ = 0;
};

class NibbleReader {
public:
    explicit NibbleReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    /// Returns 0 beyond the end; `good` is then false.
    std::uint32_t get() {
        std::uint32_t value = 0;
        for (int shift = 0;; shift += 3) {
            if (bits_ == 0 && !fetch()) return 0;
            value |= (word_ & 7) << shift;
            const bool more = word_ & 8;
            word_ >>= 4;
            bits_ -= 4;
            if (!more || shift > 27) return value;
        }
    }
    bool good() const { return good_; }

private:
    bool fetch() {
        good_ = good_ && bytes_.size() >= 4;
        if (!good_) return false;
        std::memcpy(&word_, bytes_.data(), 4);
        bytes_ = bytes_.subspan(4);
        bits_ = 32;
        return true;
    }

    std::span<const std::uint8_t> bytes_;
    std::uint32_t word_ = 0;
    int bits_ = 0;
    bool good_ = true;
};

template <class Sample>
class RvlCodec final : public ByteCodec {
public:
    explicit RvlCodec(const PlaneView& form) : ByteCodec(form), picture_(samples_.size() / sizeof(Sample)) {}

    Result<void> encode(const PlaneView& plane, Packet& packet) override {
        for (int y = 0; y < plane.height; ++y)
            std::memcpy(reinterpret_cast<std::uint8_t*>(picture_.data()) + form_.stride * y, plane.row(y),
                        row_bytes());
        NibbleWriter out(packet);
        int before = 0;
        const Sample *at = picture_.data(), *const end = at + picture_.size();
        while (at < end) {
            const Sample* run = at;
            while (at < end && *at == 0) ++at;
            out.put(static_cast<std::uint32_t>(at - run));
            run = at;
            while (at < end && *at != 0) ++at;
            out.put(static_cast<std::uint32_t>(at - run));
            for (; run < at; ++run) {
                const int difference = *run - before;
                out.put(static_cast<std::uint32_t>(difference * 2 ^ difference >> 31));
                before = *run;
            }
        }
        out.flush();
        return {};
    }

    Result<void> decode(const Packet& packet) override {
        NibbleReader in(packet);
        int before = 0;
        for (std::size_t at = 0; at < picture_.size();) {
            const std::size_t zeros = in.get(), others = in.get();
            if (!in.good() || zeros + others > picture_.size() - at) return damaged("RVL");
            std::memset(picture_.data() + at, 0, zeros * sizeof(Sample));
            at += zeros;
            for (const std::size_t stop = at + others; at < stop; ++at)
                picture_[at] = static_cast<Sample>(before += unfolded(in.get()));
        }
        if (!in.good()) return damaged("RVL");
        return {};
    }

    Result<PlaneView> plane() override {
        PlaneView plane = form_;
        plane.data = reinterpret_cast<const std::uint8_t*>(picture_.data());
        return plane;
    }

private:
    std::vector<Sample> picture_;
};

struct FreeZstd {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// A zstd frame at level 1.
class Zstd {
public:
    Result<void> compress(const std::vector<std::uint8_t>& bytes, Packet& packet) {
        packet.resize(ZSTD_compressBound(bytes.size()));
        const std::size_t size =
            ZSTD_compressCCtx(compressor_.get(), packet.data(), packet.size(), bytes.data(), bytes.size(), 1);
        if (ZSTD_isError(size)) return Error{ErrorKind::internal, "zstd: a packet cannot be made"};
        packet.resize(size);
        return {};
    }
    bool decompress(const Packet& packet, std::vector<std::uint8_t>& bytes) {
        return ZSTD_decompressDCtx(decompressor_.get(), bytes.data(), bytes.size(), packet.data(),
                                   packet.size()) == bytes.size();
    }

private:
    std::unique_ptr<ZSTD_CCtx, FreeZstd> compressor_{ZSTD_createCCtx()};
    std::unique_ptr<ZSTD_DCtx, FreeZstd> decompressor_{ZSTD_createDCtx()};
};

class PlainZstdCodec final : public ByteCodec {
public:
    explicit PlainZstdCodec(const PlaneView& form) : ByteCodec(form), bytes_(samples_.size()) {}
    Result<void> encode(const PlaneView& plane, Packet& packet) override {
        for (int y = 0; y < plane.height; ++y)
            std::memcpy(bytes_.data() + form_.stride * y, plane.row(y), row_bytes());
        return zstd_.compress(bytes_, packet);
    }
    Result<void> decode(const Packet& packet) override {
        return zstd_.decompress(packet, samples_) ? Result<void>() : damaged("zstd");
    }

private:
    std::vector<std::uint8_t> bytes_;
    Zstd zstd_;
};

template <class Sample, int channels, bool gradient>
class ZstdCodec final : public ByteCodec {
public:
    explicit ZstdCodec(const PlaneView& form)
        : ByteCodec(form),
          pixels_(static_cast<std::size_t>(form.width) * static_cast<std::size_t>(form.height)),
          bytes_(samples_.size()) {}

    Result<void> encode(const PlaneView& plane, Packet& packet) override {
        std::size_t at = 0;
        for (int y = 0; y < plane.height; ++y, at += static_cast<std::size_t>(plane.width)) {
            const auto* from = reinterpret_cast<const Sample*>(plane.row(y));
            const auto* above =
                gradient && y > 0 ? reinterpret_cast<const Sample*>(plane.row(y - 1)) : nullptr;
            for (int c = 0; c < channels; ++c) {
                int before = 0;
                for (int x = 0; x < plane.width; ++x) {
                    const int at_x = x * channels + c;
                    const int sample = above ? from[at_x] - above[at_x] : from[at_x];
                    put(c, at + static_cast<std::size_t>(x), folded<Sample>(sample - before));
                    before = sample;
                }
            }
        }
        return zstd_.compress(bytes_, packet);
    }

    Result<void> decode(const Packet& packet) override {
        if (!zstd_.decompress(packet, bytes_)) return damaged("zstd");
        std::size_t at = 0;
        for (int y = 0; y < form_.height; ++y, at += static_cast<std::size_t>(form_.width)) {
            auto* to = reinterpret_cast<Sample*>(row(y));
            const auto* above = gradient && y > 0 ? reinterpret_cast<const Sample*>(row(y - 1)) : nullptr;
            for (int c = 0; c < channels; ++c) {
                int before = 0;
                for (int x = 0; x < form_.width; ++x) {
                    before += unfolded(get(c, at + static_cast<std::size_t>(x)));
                    to[x * channels + c] = static_cast<Sample>(before);
                }
                if (!above) continue;
                for (int x = c; x < form_.width * channels; x += channels)
                    to[x] = static_cast<Sample>(to[x] + above[x]);
            }
        }
        return {};
    }

private:
    void put(int channel, std::size_t pixel, std::uint32_t code) {
        std::uint8_t* const low = bytes_.data() + static_cast<std::size_t>(channel) * pixels_;
        low[pixel] = static_cast<std::uint8_t>(code);
        if constexpr (sizeof(Sample) == 2)
            low[pixel + channels * pixels_] = static_cast<std::uint8_t>(code >> 8);
    }
    std::uint32_t get(int channel, std::size_t pixel) const {
        const std::uint8_t* const low = bytes_.data() + static_cast<std::size_t>(channel) * pixels_;
        if constexpr (sizeof(Sample) == 2)
            return low[pixel] | static_cast<std::uint32_t>(low[pixel + channels * pixels_]) << 8;
        return low[pixel];
    }

    std::size_t pixels_;
    std::vector<std::uint8_t> bytes_;  // codes: low bytes by channel, then high bytes
    Zstd zstd_;
};

/// As in clips: chooses its ranks anew at each access point.
class RankZstdCodec final : public ByteCodec {
public:
    using ByteCodec::ByteCodec;
    Result<void> encode(const PlaneView& plane, Packet& packet) override {
        const auto bytes = encoder_.encode(plane, encoded_++ % clip_tags::access_interval == 0);
        if (bytes.empty()) return Error{ErrorKind::internal, "zstd: a packet cannot be made"};
        packet.assign(bytes.begin(), bytes.end());
        return {};
    }
    Result<void> decode(const Packet& packet) override {
        auto* const samples = reinterpret_cast<std::uint16_t*>(row(0));
        if (!decoder_.decode(packet, form_.width, form_.height, samples, form_.width)) return damaged("t3d2");
        return {};
    }

private:
    RankZstdEncoder encoder_;
    RankZstdDecoder decoder_{RankZstdDecoder::Version::second};
    std::int64_t encoded_ = 0;
};

template <bool gradient>
std::unique_ptr<PlaneCodec> make_zstd(const PlaneView& form) {
    if (form.channels == 3) return std::make_unique<ZstdCodec<std::uint8_t, 3, gradient>>(form);
    if (form.bytes_per_sample == 1) return std::make_unique<ZstdCodec<std::uint8_t, 1, gradient>>(form);
    return std::make_unique<ZstdCodec<std::uint16_t, 1, gradient>>(form);
}

}  // namespace

std::unique_ptr<PlaneCodec> make_raw_codec(const PlaneView& form) {
    return std::make_unique<RawCodec>(form);
}

std::unique_ptr<PlaneCodec> make_rvl_codec(const PlaneView& form) {
    if (form.bytes_per_sample == 2) return std::make_unique<RvlCodec<std::uint16_t>>(form);
    return std::make_unique<RvlCodec<std::uint8_t>>(form);
}

std::unique_ptr<PlaneCodec> make_plain_zstd_codec(const PlaneView& form) {
    return std::make_unique<PlainZstdCodec>(form);
}

std::unique_ptr<PlaneCodec> make_zstd_codec(const PlaneView& form) {
    return make_zstd<false>(form);
}

std::unique_ptr<PlaneCodec> make_zstd_gradient_codec(const PlaneView& form) {
    return make_zstd<true>(form);
}

std::unique_ptr<PlaneCodec> make_rank_zstd_codec(const PlaneView& form) {
    return std::make_unique<RankZstdCodec>(form);
}

}  // namespace touchable
