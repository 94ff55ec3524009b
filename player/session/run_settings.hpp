// SPDX-License-Identifier: Apache-2.0
#pragma once

// The table of a run's settings that take a word or a number: a row for each, by which options, the window's
// panel, its commands and scripts, and saved settings go.

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "engine/scene/filter_codes.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

struct SessionOptions;
struct TouchSetup;

/// Group of a setting: the part of a window that shows it and what it affects.
enum class SettingOf {
    felt,     ///< how forces come about
    device,   ///< a device held by the user; no effect without one
    filters,  ///< how depth is cleaned: "filters", which sets all, and each of them
    relief,   ///< heights that are made of the clip's colour
    brush,    ///< what is painted in this window; never saved
    expert    ///< as felt, but set by options only
};

/// A row of the table. The filters' rows come from `filter_settings`.
struct SessionSetting {
    std::string name;       ///< in commands and saved settings; with "--" as an option
    const char* what = "";  ///< description for a first-time user
    SettingOf of = SettingOf::felt;
    SettingRange range{};  ///< in a window
    /// Sets a legal value (SettingRange::value_of) in the options of a run.
    std::function<void(double value, SessionOptions& options)> set{};
    /// The run's value; null: the setting has no value of its own, like "filters".
    std::function<std::string(const TouchSetup& setup)> get{};
    std::string usual{};  ///< a number's default; empty: see `what`
    /// Range of an option's number; by default any that `validate` allows.
    struct {
        double least = std::numeric_limits<double>::lowest(), most = std::numeric_limits<double>::max();
    } typed{};
};
std::span<const SessionSetting> run_settings();
/// The settings in a window: all but SettingOf::expert.
std::span<const SessionSetting> session_settings();
/// What the setting "detail" does, for a new user.
inline constexpr const char* detail_words =
    "How much relief filters keep of noisy depth: all as recorded, noise too (1), or smooth (0). Left out: "
    "as much as can be kept with hardly more noise than with the smoothest.";
/// The session setting with that name; null: none.
const SessionSetting* session_setting(std::string_view name);

}  // namespace touchable
