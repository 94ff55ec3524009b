// SPDX-License-Identifier: Apache-2.0
#pragma once

// The settings that the user has changed in the window, based on the table of settings (session_settings, in
// player/session/touch_setup.hpp), as one set or two sets to compare (A and B).

#include <map>

#include "engine/base/result.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

/// The values set in the window, by name, as text. All other settings come from the command line and the
/// clip.
class SessionSettings {
public:
    /// Sets a value, such as "median", "5". "filters" sets all filters, and discards their single settings.
    /// Fails (ErrorKind::usage) with the allowed values.
    Result<void> set(const std::string& name, const std::string& value);
    /// Leaves the settings of that kind to the clip.
    void drop(SettingOf of) {
        std::erase_if(values_, [of](const auto& one) { return session_setting(one.first)->of == of; });
    }
    const std::map<std::string, std::string>& values() const { return values_; }
    /// "median 5, metric pixel", or a text that nothing was set.
    std::string in_words() const;
    bool operator==(const SessionSettings&) const = default;

private:
    std::map<std::string, std::string> values_;
};

/// Two sets of settings to compare; one is in effect.
struct TwoSettings {
    SessionSettings a;
    std::optional<SessionSettings> b;  ///< nullopt: not used yet
    bool b_is_on = false;

    SessionSettings& now() { return b_is_on ? *b : a; }
    const SessionSettings& now() const { return b_is_on ? *b : a; }
    /// Initially, B is A without filters.
    void turn_to(bool to_b);
    std::string in_words() const { return (b_is_on ? "B: " : "A: ") + now().in_words(); }
    bool operator==(const TwoSettings&) const = default;
};

/// The options of a run with these settings.
SessionOptions with_settings(SessionOptions options, const SessionSettings& settings);
/// The value of every setting of a run but "filters", by name, as text.
std::map<std::string, std::string> settings_in_effect(const TouchSetup& setup);

}  // namespace touchable
