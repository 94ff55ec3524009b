#include "player/run/scene_cuts.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <utility>

#include "engine/scene/stored_code.hpp"

namespace touchable {
namespace {

constexpr int columns = 32, rows = 24;
constexpr std::size_t most_found = 4096;
/// A pixel is another one where its code is farther away than this share of the codes of both frames, and a
/// frame is a cut where so many of its pixels are.
constexpr double another = 1.0 / 12, cut_share = 0.4;

}  // namespace

void SceneCuts::look(const RawFrame& frame, const DepthCoding& coding) {
    std::swap(codes_, before_);
    codes_.clear();
    int least = std::numeric_limits<int>::max(), greatest = 0;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const std::uint16_t code =
                stored_code(frame.depth, coding, (2 * column + 1) * frame.depth.width / (2 * columns),
                            (2 * row + 1) * frame.depth.height / (2 * rows));
            codes_.push_back(coding.is_valid(code) ? int{code} : -1);
        }
    const bool follows = frame.epoch == epoch_ && frame.number > number_ && frame.number <= number_ + 2;
    epoch_ = frame.epoch;
    number_ = frame.number;
    if (!follows || before_.size() != codes_.size() || found_.size() == most_found) return;
    for (const auto* codes : {&codes_, &before_})
        for (const int code : *codes)
            if (code >= 0) {
                least = std::min(least, code);
                greatest = std::max(greatest, code);
            }
    const double far_away = another * std::max(0, greatest - least);  // none is valid: nothing is
    int others = 0;
    for (std::size_t k = 0; k < codes_.size(); ++k) {
        const bool same_state = (codes_[k] < 0) == (before_[k] < 0);
        others += !same_state || std::abs(codes_[k] - before_[k]) > far_away;
    }
    if (others > cut_share * columns * rows) found_.insert(frame.number);
}

}  // namespace touchable
