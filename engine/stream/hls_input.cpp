#include "engine/stream/hls_input.hpp"

#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>

#include "engine/base/try.hpp"
#include "engine/stream/hls_levels.hpp"

namespace touchable {
namespace {

/// While a stream is opened: what is felt needs the rest of the time.
constexpr std::chrono::seconds longest_wait_for_colour{4};

class BothRenditions final : public HlsInput {
public:
    BothRenditions(std::unique_ptr<HlsLevels> touch, WaitIsOver is_over,
                   std::shared_ptr<HlsLevelReading> reading)
        : touch_(std::move(touch)),
          is_over_(std::move(is_over)),
          reading_(std::move(reading)),
          is_live_(!touch_->has_ended()) {}
    void add_colour(Result<std::unique_ptr<HlsLevels>> colour);
    Result<std::optional<Packet>> next() override;
    bool is_live() const override { return is_live_; }
    std::int64_t segments_lost() const override {
        return touch_->segments_lost() + (colour_ ? colour_->segments_lost() : 0);
    }
    std::optional<LevelFigures> levels() const override;
    const std::vector<std::string>& remarks() const override { return remarks_; }

private:
    Result<const AVPacket*> next_of_colour();
    void leave_out_colour(const Error& why);

    const std::unique_ptr<HlsLevels> touch_;
    const WaitIsOver is_over_;
    const std::shared_ptr<HlsLevelReading> reading_;  // null: there is one level
    const bool is_live_;
    std::unique_ptr<HlsLevels> colour_;  // null: there is none, or none any more
    std::vector<std::string> remarks_;
};

void BothRenditions::leave_out_colour(const Error& why) {
    remarks_.push_back("its colour cannot be had: " + why.message);
    colour_.reset();
    if (reading_) reading_->choice.leave_out_colour();
}

std::optional<LevelFigures> BothRenditions::levels() const {
    if (!reading_) return std::nullopt;
    const auto seconds = [this](bool of_low) {
        return static_cast<double>(touch_->fetched_ns(of_low)) * 1e-9;
    };
    return LevelFigures{seconds(false), seconds(true), touch_->changes(), touch_->is_low()};
}

void BothRenditions::add_colour(Result<std::unique_ptr<HlsLevels>> colour) {
    if (colour)
        colour_ = std::move(*colour);
    else
        leave_out_colour(colour.error());
}

/// Nothing is felt of colour: the stream goes on without it.
Result<const AVPacket*> BothRenditions::next_of_colour() {
    if (!colour_) return static_cast<const AVPacket*>(nullptr);
    auto packet = colour_->peek();
    if (packet || is_over_()) return packet;
    leave_out_colour(packet.error());
    return static_cast<const AVPacket*>(nullptr);
}

Result<std::optional<HlsInput::Packet>> BothRenditions::next() {
    TRY_ASSIGN(const auto touch, touch_->peek());
    TRY_ASSIGN(const auto colour, next_of_colour());
    if (!touch && !colour) return std::optional<Packet>();
    const bool is_touch = touch && (!colour || touch_->time_ns(*touch) <= colour_->time_ns(*colour));
    HlsLevels& of = is_touch ? *touch_ : *colour_;
    const AVStream* const stream = &of.stream_of(is_touch ? *touch : *colour);
    return std::optional(Packet{is_touch, of.is_low(), stream, of.take()});
}

/// As hls_playlist.hpp has places.
std::string place_of(const std::string& named) {
    if (named.starts_with("http://") || named.starts_with("https://")) {
        const auto plain = resolved_place(named, named);
        return plain ? *plain : named;
    }
    std::error_code ignored;
    return "file:" + std::filesystem::absolute(named, ignored).lexically_normal().string();
}

}  // namespace

Result<std::unique_ptr<HlsInput>> HlsInput::open(const std::string& named, WaitIsOver is_over, HlsHosts hosts,
                                                 std::function<std::int64_t()> now_ns) {
    const std::string place = place_of(named);
    auto text = fetch_place(place, largest_hls_playlist, is_over);
    if (!text) return error_at(named, text.error());
    const auto places = places_in_playlist(*text, place, hosts);
    if (!places) return error_at(named, places.error());
    // Colour first: of a live stream it then begins no later.
    const auto is_opening = std::make_shared<bool>(true);
    const auto without_colour = std::chrono::steady_clock::now() + longest_wait_for_colour;
    const WaitIsOver is_over_for_colour = [is_over, is_opening, without_colour] {
        return is_over() || (*is_opening && std::chrono::steady_clock::now() > without_colour);
    };
    std::shared_ptr<HlsLevelReading> reading;
    if (now_ns && !places->low_touch.empty()) {
        reading = std::make_shared<HlsLevelReading>();
        reading->now_ns = std::move(now_ns);
    }
    auto colour = places->colour.empty() ? Result<std::unique_ptr<HlsLevels>>(nullptr)
                                         : HlsLevels::open({places->colour, places->low_colour}, false,
                                                           is_over_for_colour, hosts, reading);
    *is_opening = false;
    const bool is_media = places->touch == place;
    TRY_ASSIGN(auto touch, HlsLevels::open({places->touch, places->low_touch}, true, is_over, hosts, reading,
                                           is_media ? std::optional(std::move(*text)) : std::nullopt));
    auto input = std::make_unique<BothRenditions>(std::move(touch), is_over, std::move(reading));
    input->add_colour(std::move(colour));
    return std::unique_ptr<HlsInput>(std::move(input));
}

}  // namespace touchable
