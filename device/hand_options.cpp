#include "device/hand_options.hpp"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>

#include "engine/base/number_words.hpp"

namespace touchable {
namespace {

/// What a key takes, in words: "0.001 to 2 m/s".
std::string takes(const HandKey& key) {
    if (key.kind == HandKey::Kind::words) return std::string(key.unit);
    std::string text = key.kind == HandKey::Kind::whole ? "a whole number, " : "";
    text += exact_number(key.least) + " to " + exact_number(key.greatest);
    if (!key.unit.empty()) text.append(" ").append(key.unit);
    return text;
}

std::string list_keys(std::span<const HandKey> keys) {
    std::string list;
    for (const HandKey& key : keys) {
        if (!list.empty()) list += ", ";
        list.append(key.name).append(" (").append(takes(key)).append(")");
    }
    return list;
}

Error refusal(std::string_view of, const std::string& what) {
    return usage_error(std::string(of).append(": ").append(what));
}

}  // namespace

Result<HandOptions> HandOptions::parse(std::string_view of, std::string_view text,
                                       std::span<const HandKey> keys) {
    HandOptions options;
    options.keys_ = keys;
    while (!text.empty()) {
        const std::size_t comma = text.find(',');
        Result<Entry> next = options.entry(of, text.substr(0, comma));
        if (!next) return next.error();
        options.entries_.push_back(std::move(*next));
        if (comma == std::string_view::npos) break;
        text.remove_prefix(comma + 1);
        if (text.empty()) return refusal(of, "nothing follows the last comma; expected key=value");
    }
    return options;
}

Result<HandOptions::Entry> HandOptions::entry(std::string_view of, std::string_view item) const {
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos) {
        return refusal(
            of, std::string("'").append(item).append("' is not key=value; keys are ") + list_keys(keys_));
    }
    const std::string name(item.substr(0, equals));
    const std::string value(item.substr(equals + 1));
    const auto key =
        std::find_if(keys_.begin(), keys_.end(), [&](const HandKey& k) { return k.name == name; });
    if (key == keys_.end()) {
        return refusal(of, "unknown key '" + name + "'; keys are " + list_keys(keys_));
    }
    if (given(name)) return refusal(of, name + " is given twice; give it once");
    if (key->kind == HandKey::Kind::words) {
        if (value.empty()) return refusal(of, name + " is empty; it takes " + takes(*key));
        return Entry{&*key, 0, value};
    }
    double number = 0;
    const auto [end, fault] = std::from_chars(value.data(), value.data() + value.size(), number);
    const bool all = fault == std::errc() && end == value.data() + value.size();
    const bool inside = all && number >= key->least && number <= key->greatest;  // NaN is outside
    if (!inside || (key->kind == HandKey::Kind::whole && std::floor(number) != number)) {
        return refusal(of, name + "=" + value + " will not do; " + name + " takes " + takes(*key));
    }
    return Entry{&*key, number, {}};
}

const HandOptions::Entry* HandOptions::find(std::string_view name) const {
    const auto at =
        std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key->name == name; });
    return at == entries_.end() ? nullptr : &*at;
}

bool HandOptions::given(std::string_view name) const {
    return find(name) != nullptr;
}

double HandOptions::number(std::string_view name) const {
    if (const Entry* entry = find(name)) return entry->number;
    const auto key =
        std::find_if(keys_.begin(), keys_.end(), [&](const HandKey& k) { return k.name == name; });
    assert(key != keys_.end());
    return key->standard;
}

std::string HandOptions::words(std::string_view name) const {
    const Entry* entry = find(name);
    return entry ? entry->words : std::string();
}

}  // namespace touchable
