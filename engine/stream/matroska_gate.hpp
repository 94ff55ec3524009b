#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/picture/ffmpeg_input.hpp"

namespace touchable {

/// What FFmpeg is given of a stream in Matroska: a header of which each part is there once and holds no more
/// than a clip's has (16 tracks), and clusters of blocks, each whole and of bounded size. FFmpeg has memory
/// for every element that it meets, before it looks at any. What else there is between and in clusters is
/// left out. Where something is missing or damaged it goes on with the next cluster.
class MatroskaGate final : public ByteFlow {
public:
    explicit MatroskaGate(std::shared_ptr<ByteFlow> source) : source_(std::move(source)) {}
    Result<std::size_t> read(std::uint8_t* to, std::size_t count) override;
    /// It has ended within an element, of which this is not given.
    bool is_cut() const { return has_ended_ && there() > 0; }

private:
    enum class Place { before, segment, clusters };
    struct Head {
        std::uint64_t id = 0, size = 0;
        std::size_t length = 0;  ///< of the head itself
        bool is_open = false;    ///< it does not say how long it is
    };
    Result<bool> step();
    Result<bool> pass_beginning(const Head& head);
    Result<bool> pass_header(const Head& head);
    Result<bool> pass_block(const Head& head);
    Result<bool> begin_cluster(const Head& head);
    Result<bool> find_cluster(std::size_t from);
    Result<bool> look_back();
    Result<bool> leave_out(const Head& head);
    Result<bool> fill(std::size_t bytes);
    std::size_t there() const { return in_.size() - at_; }
    std::optional<std::size_t> cluster_in(std::size_t from, std::size_t end) const;
    void give(std::size_t bytes);
    Result<std::optional<Head>> head();

    const std::shared_ptr<ByteFlow> source_;
    Place place_ = Place::before;
    std::vector<std::uint8_t> in_, out_;
    std::size_t at_ = 0, given_ = 0;  // of them, what is behind
    std::size_t cluster_at_ = 0;      // behind the head of the last cluster
    std::uint64_t header_bytes_ = 0;
    std::array<bool, 4> seen_{};  // of a header's parts
    bool has_ended_ = false;
};

}  // namespace touchable
