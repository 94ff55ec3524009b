// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/mpeg4/node_types.hpp"

namespace touchable::mpeg4 {

namespace {

constexpr std::size_t most_values = 1 << 16, longest_text = std::size_t{1} << 20;

struct Token {
    enum class Kind { end, word, quoted, bracket };
    Kind kind = Kind::end;
    std::string text{};
    std::size_t at = 0;  // byte where it begins
    bool is(std::string_view wanted) const { return kind != Kind::quoted && text == wanted; }
};

/// Words, quoted strings and brackets; commas and comments are space.
class Tokens {
public:
    explicit Tokens(std::string_view text) : text_(text) {}

    Result<Token> next() {
        skip_space();
        if (at_ == text_.size()) return Token{Token::Kind::end, "the end", at_};
        if (text_[at_] == '"') return quoted();
        Token token{Token::Kind::word, {}, at_};
        if (is_bracket(text_[at_])) {
            token.kind = Token::Kind::bracket;
            token.text = text_[at_++];
            return token;
        }
        while (at_ < text_.size() && !is_space(text_[at_]) && !is_bracket(text_[at_]) && text_[at_] != '"' &&
               text_[at_] != '#')
            token.text += text_[at_++];
        return token;
    }

    Error wrong(std::size_t at, const std::string& what) const {
        const std::string_view before = text_.substr(0, at);
        const auto line = 1 + std::ranges::count(before, '\n');
        const auto begin = before.rfind('\n');
        const std::size_t column = begin == std::string_view::npos ? at + 1 : at - begin;
        return input_error("line " + std::to_string(line) + ", column " + std::to_string(column) + ": " +
                           what);
    }

private:
    static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }
    static bool is_bracket(char c) { return c == '{' || c == '}' || c == '[' || c == ']'; }
    void skip_space() {
        while (at_ < text_.size() && (is_space(text_[at_]) || text_[at_] == '#')) {
            if (text_[at_] == '#') at_ = std::min(text_.find('\n', at_), text_.size());
            if (at_ < text_.size()) ++at_;
        }
    }

    Result<Token> quoted() {
        Token token{Token::Kind::quoted, {}, at_};
        for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
            if (text_[at_] == '\\' && at_ + 1 < text_.size()) ++at_;
            token.text += text_[at_];
        }
        if (at_ == text_.size()) return wrong(token.at, "this string has no end");
        ++at_;
        return token;
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

class TextParser {
public:
    explicit TextParser(std::string_view text) : tokens_(text) {}
    Result<SceneTree> parse() {
        TRY(advance());
        while (token_.is("PROTO") || token_.is("EXTERNPROTO")) {
            TRY_ASSIGN(auto made, prototype(token_.is("EXTERNPROTO")));
            scene_.prototypes.push_back(std::move(made));
            if (scene_.prototypes.size() > most_prototypes) return wrong("more than 64 prototypes");
        }
        TRY_ASSIGN(scene_.root, node(0));
        if (!scene_.root) return wrong("the scene is NULL: must be a node");
        if (token_.kind != Token::Kind::end)
            return wrong("the scene is over, but " + in_quotes(token_.text) + " follows" +
                         (token_.is("}") ? ": there are more closing braces than opening ones" : ""));
        return std::move(scene_);
    }

private:
    Result<void> advance() {
        TRY_ASSIGN(token_, tokens_.next());
        return {};
    }

    Result<void> expect(std::string_view wanted, const std::string& of_what) {
        if (!token_.is(wanted)) return wrong(of_what + ": " + found() + ": must be " + in_quotes(wanted));
        return advance();
    }

    Error wrong(const std::string& what) const { return tokens_.wrong(token_.at, what); }
    std::string found() const {
        return token_.kind == Token::Kind::end ? "the text ends" : "found " + in_quotes(token_.text);
    }
    Result<std::string> name(const char* of_what) {
        if (token_.kind != Token::Kind::word)
            return wrong(std::string(of_what) + ": " + found() + ": must be a name");
        if (!is_name(token_.text))
            return wrong(std::string(of_what) + ": " + found() + ": must be a name of 1 to 256 letters");
        std::string word = std::move(token_.text);
        TRY(advance());
        return word;
    }

    Result<Prototype> prototype(bool is_external) {
        TRY(advance());
        const std::size_t at = token_.at;
        TRY_ASSIGN(auto called, name("PROTO"));
        if (prototype_named(scene_.prototypes, called))
            return tokens_.wrong(at, "PROTO " + printable(called) + " is there already");
        Prototype made{.name = std::move(called)};
        TRY(expect("[", "PROTO " + printable(made.name)));
        while (!token_.is("]")) {
            const std::size_t field_at = token_.at;
            TRY_ASSIGN(auto spec, prototype_field(is_external));
            if (field_named(made.fields, spec.name))
                return tokens_.wrong(field_at,
                                     "PROTO " + printable(made.name) + ": has " + spec.name + " twice");
            made.fields.push_back(std::move(spec));
            if (made.fields.size() > most_fields)
                return tokens_.wrong(field_at, "PROTO " + printable(made.name) + ": has more than 64 fields");
        }
        TRY(advance());
        if (is_external) {
            TRY_ASSIGN(auto urls, values({FieldType::url, true}, 0));
            for (FieldValue& each : urls) made.elsewhere.push_back(std::get<Url>(std::move(each)));
            if (made.elsewhere.empty())
                return wrong("EXTERNPROTO " + printable(made.name) + ": must say where it is");
            return made;
        }
        TRY(expect("{", "PROTO " + printable(made.name)));
        inside_ = &made;
        while (!token_.is("}")) {
            TRY_ASSIGN(auto part, node(1));
            if (!part) return wrong("PROTO " + printable(made.name) + ": NULL is no node of its body");
            made.body.push_back(std::move(part));
        }
        inside_ = nullptr;
        named_.clear();  // its own names end with it
        if (made.body.empty())
            return wrong("PROTO " + printable(made.name) + ": must have a node in its body");
        TRY(advance());
        return made;
    }

    Result<FieldSpec> prototype_field(bool is_external) {
        FieldSpec spec;
        if (!token_.is("field") && !token_.is("exposedField"))
            return wrong(found() + ": must be field, exposedField or ]");
        spec.event = token_.is("field") ? FieldEvent::field : FieldEvent::exposed;
        TRY(advance());
        const auto kind = kind_named(token_.text);
        if (!kind) return wrong(found() + ": must be the type of a field, such as SFFloat");
        spec.kind = *kind;
        TRY(advance());
        TRY_ASSIGN(spec.name, name("field"));
        if (is_external) return spec;
        TRY_ASSIGN(spec.initial, values(spec.kind, 1));
        return spec;
    }

    Result<NodePtr> node(int depth) {
        const auto too_deep = [&] {
            return wrong("nodes stand in each other more than " + std::to_string(deepest_node) + " deep");
        };
        if (depth > deepest_node) return too_deep();
        std::string called;
        if (token_.is("NULL")) {
            TRY(advance());
            return NodePtr();
        }
        if (token_.is("USE")) {
            TRY(advance());
            const auto known = named_.find(token_.text);
            if (known == named_.end())
                return wrong("USE: there is no node " + in_quotes(token_.text) + " before it");
            if (depth + known->second->levels - 1 > deepest_node) return too_deep();
            TRY(advance());
            return known->second;
        }
        if (token_.is("DEF")) {
            TRY(advance());
            TRY_ASSIGN(called, name("DEF"));
        }
        const std::size_t at = token_.at;
        TRY_ASSIGN(auto word, name("a node"));
        const auto* specs = fields_of(scene_.prototypes, word);
        if (!specs)
            return tokens_.wrong(
                at, in_quotes(word) + " is no node that a touchable clip has" +
                        (word == "ROUTE" || word == "Script" ? ": its scene has no behaviour" : ""));
        auto made = std::make_shared<Node>(Node{.type = std::move(word), .name = called});
        TRY(expect("{", made->type));
        while (!token_.is("}")) {
            TRY_ASSIGN(auto given, field(*specs, made->type, depth));
            if (made->field(given.name)) return wrong(made->type + ": has " + given.name + " twice");
            made->fields.push_back(std::move(given));
        }
        sort_fields(*made, *specs);
        made->levels = levels_of(*made);
        TRY(advance());
        if (!called.empty() && !named_.emplace(called, made).second)
            return tokens_.wrong(at, "DEF " + called + " is there already");
        return NodePtr(std::move(made));
    }

    Result<Field> field(const std::vector<FieldSpec>& specs, const std::string& of_node, int depth) {
        const Token at = token_;
        if (at.kind != Token::Kind::word)
            return wrong(of_node + ": " + found() + ": must be a field's name or }");
        const FieldSpec* const spec = field_named(specs, at.text);
        if (!spec || !spec->has_value()) {
            std::vector<std::string> names;
            for (const FieldSpec& each : specs) names.push_back(each.name);
            const std::string nearest = nearest_word(at.text, names);
            return wrong(of_node + ": has no field " + in_quotes(at.text) +
                         (nearest.empty() ? "" : "; did you mean " + nearest + '?'));
        }
        TRY(advance());
        Field made{spec->name};
        if (!token_.is("IS")) {
            TRY_ASSIGN(made.values, values(spec->kind, depth + 1));
            return made;
        }
        if (!inside_) return wrong(of_node + ": IS stands in the body of a PROTO only");
        TRY(advance());
        const FieldSpec* const meant = field_named(inside_->fields, token_.text);
        if (!meant || !(meant->kind == spec->kind))
            return wrong("PROTO " + printable(inside_->name) + ": has no field " + in_quotes(token_.text) +
                         " of type " + std::string(kind_name(spec->kind)));
        made.is = meant->name;
        TRY(advance());
        return made;
    }

    /// One value; for a list, the values in brackets, or one without.
    Result<std::vector<FieldValue>> values(FieldKind kind, int depth) {
        std::vector<FieldValue> all;
        const bool in_brackets = kind.is_list && token_.is("[");
        if (in_brackets) TRY(advance());
        while (!in_brackets || !token_.is("]")) {
            TRY_ASSIGN(auto each, value(kind.type, depth));
            all.push_back(std::move(each));
            if (!in_brackets) return all;
            if (all.size() > most_values)
                return wrong("a list has more than " + std::to_string(most_values) + " values");
        }
        TRY(advance());
        return all;
    }

    template <class Number>
    Result<void> read_number(Number& into) {
        const auto value = parsed_as<Number>(token_.text);
        if (token_.kind != Token::Kind::word || !value || !std::isfinite(*value))
            return wrong(found() + ": must be a number");
        into = *value;
        return advance();
    }

    Result<FieldValue> value(FieldType type, int depth) {
        FieldValue made = zero_of(type);
        const auto read = [&](auto& each) -> Result<void> {
            using T = std::decay_t<decltype(each)>;
            if constexpr (std::is_same_v<T, bool>) {
                each = token_.is("TRUE") || token_.is("true");
                if (!each && !token_.is("FALSE") && !token_.is("false"))
                    return wrong(found() + ": must be TRUE or FALSE");
                return advance();
            } else if constexpr (std::is_same_v<T, std::string>) {
                if (token_.kind != Token::Kind::quoted)
                    return wrong(found() + ": must be a string in quotes");
                each = std::move(token_.text);
                return advance();
            } else if constexpr (std::is_same_v<T, std::int32_t>) {
                const auto whole = parsed_as<std::int32_t>(token_.text);
                if (token_.kind != Token::Kind::word || !whole)
                    return wrong(found() + ": must be a whole number");
                each = *whole;
                return advance();
            } else if constexpr (std::is_arithmetic_v<T>) {
                return read_number(each);
            } else if constexpr (std::is_same_v<T, NodePtr>) {
                return assign(each, node(depth));
            } else if constexpr (std::is_same_v<T, Url>) {
                return assign(each, url());
            } else {
                for (float& number_in : each) TRY(read_number(number_in));
                return {};
            }
        };
        TRY(std::visit(read, made));
        return made;
    }

    /// A file in quotes, or the number of an object descriptor: 10, "od:10".
    Result<Url> url() {
        const bool is_quoted = token_.kind == Token::Kind::quoted;
        auto made = is_quoted ? url_of(token_.text) : url_of("od:" + token_.text);
        if (!made)
            return wrong(found() +
                         ": must be a file in quotes, or the number of an object descriptor, 1 to 1023");
        TRY(advance());
        return std::move(*made);
    }

    Tokens tokens_;
    Token token_;  // the next one
    SceneTree scene_;
    std::map<std::string, NodePtr, std::less<>> named_;
    const Prototype* inside_ = nullptr;  // whose body is read
};

std::string quoted_text(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c;
    }
    return quoted + '"';
}

class TextWriter {
public:
    std::string write(const SceneTree& scene) {
        prototypes_ = scene.prototypes;
        for (const Prototype& each : scene.prototypes) prototype(each);
        node(scene.root, 0);
        text_ += '\n';
        return std::move(text_);
    }

private:
    void prototype(const Prototype& prototype) {
        text_ += (prototype.elsewhere.empty() ? "PROTO " : "EXTERNPROTO ") + prototype.name + " [";
        for (const FieldSpec& spec : prototype.fields) {
            line(1);
            text_ += spec.event == FieldEvent::field ? "field " : "exposedField ";
            text_ += std::string(kind_name(spec.kind)) + ' ' + spec.name;
            if (!prototype.elsewhere.empty()) continue;
            text_ += ' ';
            values(spec.kind, spec.initial, 1);
        }
        line(0);
        text_ += "] ";
        if (!prototype.elsewhere.empty()) {
            values({FieldType::url, true}, {prototype.elsewhere.begin(), prototype.elsewhere.end()}, 0);
        } else {
            text_ += '{';
            for (const NodePtr& part : prototype.body) {
                line(1);
                node(part, 1);
            }
            line(0);
            text_ += '}';
        }
        text_ += '\n';
    }

    void node(const NodePtr& node, int depth) {
        if (!node) {
            text_ += "NULL";
            return;
        }
        if (!node->name.empty()) {
            const bool is_new = written_.insert(node.get()).second;
            text_ += (is_new ? "DEF " : "USE ") + node->name;
            if (!is_new) return;
            text_ += ' ';
        }
        text_ += node->type + " {";
        const auto* specs = fields_of(prototypes_, node->type);
        for (const Field& field : node->fields) {
            line(depth + 1);
            text_ += field.name + ' ';
            if (!field.is.empty()) {
                text_ += "IS " + field.is;
                continue;
            }
            if (const FieldSpec* const spec = field_named(*specs, field.name))
                values(spec->kind, field.values, depth + 1);
        }
        if (!node->fields.empty()) line(depth);
        text_ += '}';
    }

    void values(FieldKind kind, const std::vector<FieldValue>& values, int depth) {
        if (!kind.is_list) {
            value(values.front(), depth);
            return;
        }
        const bool by_line =
            kind.type == FieldType::node || (kind.type == FieldType::string && values.size() > 1);
        text_ += '[';
        for (const FieldValue& each : values) {
            if (by_line)
                line(depth + 1);
            else if (&each != &values.front())
                text_ += ' ';
            value(each, depth + 1);
        }
        if (by_line) line(depth);
        text_ += ']';
    }

    void value(const FieldValue& value, int depth) {
        const auto say = [&](const auto& each) {
            using T = std::decay_t<decltype(each)>;
            if constexpr (std::is_same_v<T, bool>) {
                text_ += each ? "TRUE" : "FALSE";
            } else if constexpr (std::is_arithmetic_v<T>) {
                text_ += exact_number(each);
            } else if constexpr (std::is_same_v<T, std::string>) {
                text_ += quoted_text(each);
            } else if constexpr (std::is_same_v<T, NodePtr>) {
                node(each, depth);
            } else if constexpr (std::is_same_v<T, Url>) {
                text_ += each.object > 0 ? exact_number(each.object) : quoted_text(each.file);
            } else {
                for (const float& number : each)
                    text_ += (&number == each.data() ? "" : " ") + exact_number(number);
            }
        };
        std::visit(say, value);
    }

    void line(int depth) { text_ += '\n' + std::string(2 * static_cast<std::size_t>(depth), ' '); }

    std::span<const Prototype> prototypes_;
    std::set<const Node*> written_;  // named nodes, of which USE speaks from now on
    std::string text_;
};

}  // namespace

Result<SceneTree> parse_scene_text(std::string_view text) {
    if (text.size() > longest_text)
        return input_error("the scene's text has " + std::to_string(text.size()) +
                           " bytes: must be 1 MiB at most");
    return TextParser(text).parse();
}

std::string scene_text(const SceneTree& scene) {
    return TextWriter().write(scene);
}

}  // namespace touchable::mpeg4
