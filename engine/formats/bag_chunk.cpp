#include "engine/formats/bag_chunk.hpp"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::uint32_t largest_chunk = 128 << 20;  // recorders begin another one after each MiB or ten
constexpr std::size_t step = 64 << 10;

/// Packed bytes of a file, piece by piece.
class Pieces {
public:
    Pieces(ByteSource& file, std::uint64_t at, std::uint32_t size) : file_(file), at_(at), left_(size) {}
    /// Empty after the last.
    Result<std::string_view> next() {
        const std::size_t count = std::min<std::size_t>(left_, step);
        TRY(file_.read(at_, piece_.data(), count));
        at_ += count;
        left_ -= static_cast<std::uint32_t>(count);
        return std::string_view(piece_.data(), count);
    }

private:
    ByteSource& file_;
    std::uint64_t at_;
    std::uint32_t left_;
    std::vector<char> piece_ = std::vector<char>(step);
};

Error damaged(const char* compression) {
    return input_error(std::string("is damaged: a chunk cannot be unpacked by ") + compression);
}

Result<void> unpack_bz2(Pieces& pieces, std::string& to) {
    bz_stream stream{};
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return damaged("bzip2");
    const std::unique_ptr<bz_stream, int (*)(bz_stream*)> closer(&stream, BZ2_bzDecompressEnd);
    stream.next_out = to.data();
    stream.avail_out = static_cast<unsigned>(to.size());
    for (int state = BZ_OK; state != BZ_STREAM_END;) {
        TRY_ASSIGN(const auto piece, pieces.next());
        stream.next_in = const_cast<char*>(piece.data());  // which bzip2 only reads
        stream.avail_in = static_cast<unsigned>(piece.size());
        do {
            const unsigned before = stream.avail_in + stream.avail_out;
            state = BZ2_bzDecompress(&stream);
            if (state != BZ_OK && state != BZ_STREAM_END) return damaged("bzip2");
            if (state == BZ_OK && before == stream.avail_in + stream.avail_out) {
                if (piece.empty() || stream.avail_in > 0) return damaged("bzip2");
                break;
            }
        } while (state == BZ_OK);
    }
    if (stream.avail_out > 0) return damaged("bzip2");
    return {};
}

Result<void> unpack_lz4(Pieces& pieces, std::string& to) {
    LZ4F_dctx* context = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return damaged("LZ4");
    const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> closer(
        context, LZ4F_freeDecompressionContext);
    std::size_t filled = 0, wanted = 1;
    while (wanted != 0) {
        TRY_ASSIGN(const auto piece, pieces.next());
        if (piece.empty()) return damaged("LZ4");
        for (std::string_view left = piece; !left.empty() && wanted != 0;) {
            std::size_t taken = left.size(), given = to.size() - filled;
            wanted = LZ4F_decompress(context, to.data() + filled, &given, left.data(), &taken, nullptr);
            if (LZ4F_isError(wanted) || (taken == 0 && given == 0)) return damaged("LZ4");
            filled += given;
            left.remove_prefix(taken);
        }
    }
    if (filled != to.size()) return damaged("LZ4");
    return {};
}

/// One frame or several, whose memory zstd does not take from what the frame says.
Result<void> unpack_zstd(Pieces& pieces, std::string& to) {
    const std::unique_ptr<ZSTD_DStream, decltype(&ZSTD_freeDStream)> stream(ZSTD_createDStream(),
                                                                            ZSTD_freeDStream);
    if (!stream) return damaged("zstd");
    ZSTD_outBuffer out{to.data(), to.size(), 0};
    for (std::size_t wanted = 1;;) {
        TRY_ASSIGN(const auto piece, pieces.next());
        if (piece.empty()) return wanted == 0 && out.pos == out.size ? Result<void>{} : damaged("zstd");
        ZSTD_inBuffer in{piece.data(), piece.size(), 0};
        while (in.pos < in.size) {
            const std::size_t before = in.pos + out.pos;
            wanted = ZSTD_decompressStream(stream.get(), &out, &in);
            if (ZSTD_isError(wanted) || in.pos + out.pos == before) return damaged("zstd");
        }
    }
}

}  // namespace

Result<std::string> unpack_bag_chunk(std::string_view compression, ByteSource& file, std::uint64_t at,
                                     std::uint32_t packed, std::uint32_t size) {
    if (size > largest_chunk)
        return input_error("has a chunk of " + std::to_string(size >> 20) + " MiB: at most " +
                           std::to_string(largest_chunk >> 20) + " are read");
    // LZ4 cannot make more of a byte; bzip2 and zstd make of one, at most, what no recording has.
    if (const std::uint32_t most = compression == "lz4" ? 255 : 4096; size / most > packed)
        return input_error("is damaged: has a chunk of " + std::to_string(size) + " bytes in " +
                           std::to_string(packed));
    std::string bytes(size, '\0');
    if (compression.empty()) {
        TRY(file.read(at, bytes.data(), bytes.size()));
        return bytes;
    }
    Pieces pieces(file, at, packed);
    TRY(compression == "bz2"    ? unpack_bz2(pieces, bytes)
        : compression == "zstd" ? unpack_zstd(pieces, bytes)
                                : unpack_lz4(pieces, bytes));
    return bytes;
}

}  // namespace touchable
