# SPDX-License-Identifier: Apache-2.0
"""Where a C++ source may be changed by rule, and to what: places(text) reads the tokens of function bodies, by their statements.

A place is one small change behind the switch of mutant.hpp, where "@K@" stands for its number. What no test could see is left out as
far as the words tell: texts for people, sizes of reserved memory, tolerances, hints to a scheduler; and so is what could harm the
machine: kill, remove_all."""
import bisect
import collections
import re

Place = collections.namedtuple("Place", "rule line last start end text was now")  # replaces text[start:end]; was, now: for a person

TOKEN = re.compile(r"""
    (?P<space>\s+|//[^\n]*|/\*.*?\*/|\#(?:\\\n|[^\n])*)
  | (?P<string>(?:u8|[uUL])?R"(?P<mark>[^(\s]*)\(.*?\)(?P=mark)"|(?:u8|[uUL])?"(?:\\.|[^"\\\n])*")
  | (?P<char>'(?:\\.|[^'\\\n])+')
  | (?P<number>\.?\d(?:[eEpP][+-]|'?[\w.])*)
  | (?P<word>[A-Za-z_]\w*)
  | (?P<sign><=>|->\*|\.\.\.|::|->|\+\+|--|&&|\|\||[-+*/%&|^=!<>]=|.)""", re.X | re.S)

OPENS, CLOSES = "([{", ")]}"
BEGINS_DECLARATION = set("""void const auto static constexpr thread_local unsigned signed int double bool float char long short using
    typedef struct class enum union template static_assert typename extern volatile friend namespace inline""".split())
BEGINS_OTHER = set("throw break continue goto co_return delete new case default asm".split())
UNSEEN = re.compile(r"\b\w*(?:reserve|shrink_to_fit|assert|mlock|prctl|sched|nice|advise|prefetch|yield|sleep|setvbuf|log|warn|remark|"
                    r"message|label|title|tooltip|hint|kill|remove_all|pid|process_|abort|_exit|epsilon|tolerance|static_cast<void>|"
                    r"capacity|thread_name|static_assert|FAIL|unreachable)\w*", re.I)
SWAPPED = {"&&": "||", "||": "&&", "==": "!=", "!=": "==", "+": "-", "-": "+", "*": "/", "/": "*"}
RULE_OF = {"&&": "logic", "||": "logic", "==": "compare", "!=": "compare", "+": "sign", "-": "sign", "*": "product", "/": "product"}
TURNED = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}
EDGED = {"<": "<=", ">": ">=", "<=": "<", ">=": ">"}
PAIRS = {tuple(pair.split("-")) for pair in """width-height column-row row-column low-high from-to to-from begin-end first-last least-most
    near-far before-after left-right top-bottom before-now at-size offset-size columns-rows rows-columns middle-end one-other""".split()}
COMMUTATIVE = set("min max lesser greater swap dot hypot abs distance equal lcm gcd plus pixel_count exchange sort same_samples".split())


class Token:
    __slots__ = ("kind", "text", "start", "end")

    def __init__(self, match):
        self.kind, self.text, self.start, self.end = match.lastgroup, match.group(), match.start(), match.end()
        if self.kind == "mark":
            self.kind = "string"


class Source:
    def __init__(self, text):
        self.text, self.places = text, []
        self.lines = [0] + [at.end() for at in re.finditer("\n", text)]
        self.tokens = [token for token in map(Token, TOKEN.finditer(text)) if token.kind != "space"]
        self.pair, open_ones = {}, []
        for k, token in enumerate(self.tokens):
            if token.text in OPENS:
                open_ones.append(k)
            elif token.text in CLOSES:
                at = open_ones.pop()
                self.pair[at], self.pair[k] = k, at
        self.scope(0, len(self.tokens))

    def word(self, k):
        return self.tokens[k].text if 0 <= k < len(self.tokens) else ""

    def line(self, offset):
        return bisect.bisect_right(self.lines, offset)

    def top(self, a, b):
        """Tokens of [a, b) outside all brackets; opening ones included."""
        while a < b:
            yield a
            a = self.pair[a] + 1 if self.word(a) in OPENS else a + 1

    def angle(self, k):
        """The token after template arguments that begin at token k; k where none do."""
        if self.word(k) != "<" or self.tokens[k].start != self.tokens[k - 1].end:
            return k
        depth = 0
        for at in range(k, min(k + 60, len(self.tokens))):
            depth += {"<": 1, ">": -1}.get(self.word(at), 0)
            if self.word(at) in (";", "{", "}"):
                break
            if depth == 0:
                return at + 1
        return k

    def is_spaced(self, k):
        return self.tokens[k].start > self.tokens[k - 1].end and self.tokens[k + 1].start > self.tokens[k].end

    # Declarations.

    def scope(self, k, end):
        """Namespaces and classes: finds functions."""
        head = k
        while k < end:
            word = self.word(k)
            if word == ";" or (word == ":" and self.word(k - 1) in ("public", "private", "protected")):
                head = k + 1
            elif word == "{":
                kind = self.kind_of_braces(head, k)
                if kind == "scope":
                    self.scope(k + 1, self.pair[k])
                elif kind == "code":
                    self.statements(k + 1, self.pair[k])
                k = self.pair[k]
                if kind != "value":
                    head = k + 1
            elif word == "(":
                k = self.pair[k]
            k += 1

    def kind_of_braces(self, head, k):
        words, at = [], head
        while at < k:
            if words[-1:] == ["template"]:
                at = max(self.angle(at), at + 1) if self.tokens[at].start == self.tokens[at - 1].end else self.after_angle(at)
                words.append("<>")
                continue
            words.append(self.word(at))
            at = self.pair[at] + 1 if self.word(at) in OPENS else at + 1
        if "namespace" in words or "extern" in words:
            return "scope"
        if "consteval" in words or ("=" in words and "operator" not in words):
            return "value"
        if "(" not in words:
            return "scope" if {"class", "struct", "union"} & set(words) and "enum" not in words else "value"
        constructs = ":" in words[words.index("("):]
        if constructs and (self.tokens[k - 1].kind == "word" or self.word(k - 1) == ">"):
            return "value"
        return "code"

    def after_angle(self, k):
        depth = 0
        while True:
            depth += {"<": 1, ">": -1}.get(self.word(k), 0)
            k += 1
            if depth == 0:
                return k

    # Statements.

    def statements(self, k, end):
        while k < end:
            k = self.statement(k, end)

    def statement(self, k, end):
        word = self.word(k)
        if word == "{":
            self.statements(k + 1, self.pair[k])
            return self.pair[k] + 1
        if word in (";", "else", "do", "try"):
            return k + 1
        if word in ("if", "while", "for", "switch", "catch"):
            at = k + 1
            while self.word(at) != "(":
                at += 1
            if at == k + 1:
                self.condition(word, at + 1, self.pair[at])
            return self.pair[at] + 1
        if word in ("case", "default"):
            while self.word(k) != ":":
                k += 1
            return k + 1
        last = k
        for last in self.top(k, end):
            if self.word(last) == ";":
                break
        self.simple(k, last)
        return last + 1

    def lambdas(self, a, b):
        """Reads the bodies of lambdas in [a, b); whether there are some."""
        found, k = False, a
        while k < b:
            if self.word(k) == "{" and self.is_lambda(k):
                found = True
                self.statements(k + 1, self.pair[k])
                k = self.pair[k]
            k += 1
        return found

    def is_lambda(self, k):
        for at in range(k - 1, max(k - 12, 0), -1):
            word = self.word(at)
            if word == "]":
                return at == k - 1
            if word == ")":
                before = self.pair[at] - 1
                return self.word(before) == "]" or (self.word(before) == ">" and "]" in [self.word(n) for n in range(before - 8, before)])
            if not (self.tokens[at].kind == "word" or word in ("->", "::", "<", ">", "*", "&", ",")):
                return False
        return False

    def condition(self, kind, a, b):
        has_lambdas = self.lambdas(a, b)
        parts = [k for k in self.top(a, b) if self.word(k) == ";"]
        if kind == "for":
            if len(parts) != 2:
                return
            a, b = parts[0] + 1, parts[1]
        elif parts:
            a = parts[-1] + 1
        if a >= b or kind in ("switch", "catch") or any(self.word(k) == "=" for k in self.top(a, b)) or self.is_unseen(a, b):
            return
        if kind == "if":
            self.add("negate", a, b, f"bool({self.text[self.tokens[a].start:self.tokens[b - 1].end]}) != touchable_mutant(@K@)",
                     self.plain(a, b), f"!({self.plain(a, b)})")
        if not has_lambdas:
            self.edits(a, b, lambda new, old: f"(touchable_mutant(@K@) ? bool({new}) : bool({old}))", in_loop=kind != "if")

    def simple(self, a, b):
        has_lambdas = self.lambdas(a, b)
        first = self.word(a)
        if first in BEGINS_OTHER or a >= b or first.endswith("_ASSIGN") or self.is_unseen(a, b):
            return
        if any(self.tokens[k].kind == "string" for k in range(a, b)):
            return
        whole = lambda new, old: "{ if (touchable_mutant(@K@)) " + new + "; else " + old + "; }"
        if first == "return":
            if b > a + 1 and self.word(a + 1) != "{" and not has_lambdas:
                self.edits(a, b, whole, span=(a, b + 1))
            return
        equals = [k for k in self.top(a, b) if self.word(k) == "="]
        if self.is_declaration(a, b):
            begin = equals[0] + 1 if equals else b
            if begin < b and "constexpr" not in (first, self.word(a + 1)) and first != "using" and self.word(begin) != "{" and \
                    not has_lambdas and not any(self.word(k) == "," for k in self.top(begin, b)):
                self.edits(begin, b, lambda new, old: f"(touchable_mutant(@K@) ? ({new}) : ({old}))")
            return
        is_change = any(self.word(k) in ("=", "+=", "-=", "*=", "/=", "|=", "&=", "^=", "++", "--") for k in self.top(a, b))
        if is_change or self.word(b - 1) == ")":
            self.add("delete", a, b + 1, "{ if (!touchable_mutant(@K@)) " + self.text[self.tokens[a].start:self.tokens[b].end] + " }",
                     self.plain(a, b), "nothing")
            if not has_lambdas:
                self.edits(a, b, whole, span=(a, b + 1))

    def is_declaration(self, a, b):
        if self.word(a) in BEGINS_DECLARATION:
            return True
        k = a
        while k < b and (self.tokens[k].kind == "word" or self.word(k) == "::"):
            if self.tokens[k].kind == "word" and k + 1 < b and self.tokens[k + 1].kind == "word":
                return True
            after = self.angle(k + 1)
            if after > k + 1 and after < b and self.tokens[after].kind == "word":
                return True
            k = max(after, k + 1)
        if k > a and k < b and self.word(k) in ("*", "&", "&&"):
            k += self.word(k + 1) == "const"
            return k + 1 < b and self.tokens[k + 1].kind == "word" and self.word(k + 2) in ("=", "(", "{", ";", ":")
        return False

    # Changes.

    def plain(self, a, b, changed=None):
        """Tokens [a, b) on one line, without comments; `changed`: others for some."""
        out, before = [], None
        for k in range(a, b):
            if before is not None and self.tokens[k].start > before:
                out.append(" ")
            out.append((changed or {}).get(k, self.word(k)))
            before = self.tokens[k].end
        return "".join(out)

    def is_unseen(self, a, b):
        return UNSEEN.search(self.plain(a, b)) is not None

    def add(self, rule, a, b, text, was, now):
        start, end = self.tokens[a].start, self.tokens[b - 1].end
        self.places.append(Place(rule, self.line(start), self.line(end), start, end, text, was, now))

    def edits(self, a, b, switch, span=None, in_loop=False):
        old = self.text[self.tokens[a].start:self.tokens[b - 1].end]
        for k, rule, changed in self.changes(a, b, in_loop):
            near = range(max(a, k - 5), min(b, k + 6))
            self.add(rule, *(span or (a, b)), switch(self.plain(a, b, changed), old), self.plain(near[0], near[-1] + 1),
                     self.plain(near[0], near[-1] + 1, changed))

    def changes(self, a, b, in_loop):
        k = a
        while k < b:
            token, word = self.tokens[k], self.word(k)
            if self.angle(k) > k:
                k = self.angle(k)
                continue
            if token.kind == "string":
                return  # a sum of texts has no difference
            if token.kind == "number":
                changed = self.other_number(k)
                if changed:
                    yield k, "constant", {k: changed}
            elif word in ("true", "false"):
                yield k, "constant", {k: "false" if word == "true" else "true"}
            elif word in ("min", "max") and self.word(k - 1) == "::" and self.word(k - 2) in ("std", "glm", "ranges"):
                yield k, "minmax", {k: "max" if word == "min" else "min"}
            elif word == "(" and k > a and self.tokens[k - 1].kind == "word":
                yield from self.swaps(k)
            elif a < k < b - 1 and self.is_spaced(k) and (self.tokens[k - 1].kind in ("word", "number") or self.word(k - 1) in (")", "]")):
                if word in SWAPPED:
                    yield k, RULE_OF[word], {k: SWAPPED[word]}
                elif word in TURNED:
                    yield k, "order", {k: self.other_order(k, in_loop)}
            k += 1

    def other_number(self, k):
        word = self.word(k)
        if self.word(k - 1) == "-" and self.word(k - 2) in ("(", ",", "=", "return", "<", ">") and word == "1":
            return None  # -1 means none: a process, a descriptor
        digits = word.replace("'", "")
        is_hexadecimal = digits[:2] in ("0x", "0X")
        if "." in digits or (not is_hexadecimal and "e" in digits.lower()) or (is_hexadecimal and "p" in digits.lower()):
            value = float.fromhex(digits.rstrip("fF")) if is_hexadecimal else float(digits.rstrip("fFlL"))
            if value == 0:
                return word.replace("0", "1", 1)
            return f"(1.5{'f' if digits[-1] in 'fF' and not is_hexadecimal else ''} * {word})" if 1e-6 < value < 1e6 else None
        if is_hexadecimal or digits.startswith("0b"):
            return f"({word} + 1)"
        value = int(re.match(r"\d+", digits).group())
        return f"({word} + 1)" if value < 16 else f"({word} / 2)"

    def other_order(self, k, in_loop):
        word = self.word(k)
        if in_loop:
            return "+ 1 <" if word == "<" and self.tokens[k - 1].kind == "word" else TURNED[word]
        near = self.plain(k - 1, min(k + 8, len(self.tokens)))
        is_whole = any(re.fullmatch(r"[1-9]\d*[uUlL]*", self.word(n)) for n in (k - 1, k + 1))
        return EDGED[word] if is_whole or re.search(r"^\S*\s*\S+ [^&|]*\b(size|count)\(", near) else TURNED[word]

    @staticmethod
    def are_alike(one, other):
        """Whether values of such names probably have the same type."""
        if len(one) == len(other) == 1 or (one, other) in PAIRS:
            return True
        return not one.isupper() and (one[:3] == other[:3] or one.rstrip("_")[-3:] == other.rstrip("_")[-3:])

    def swaps(self, k):
        called = self.word(k - 1)
        if called in COMMUTATIVE or called.startswith("same_") or called in ("if", "while", "for", "switch", "sizeof", "decltype"):
            return
        end, parts, start = self.pair[k], [], k + 1
        for at in self.top(k + 1, end):
            if self.word(at) == ",":
                parts.append((start, at))
                start = at + 1
        parts.append((start, end))
        for (a1, b1), (a2, b2) in zip(parts, parts[1:]):
            shapes = [[t.kind if t.kind == "word" else t.text for t in self.tokens[a:b]] for a, b in ((a1, b1), (a2, b2))]
            if shapes[0] != shapes[1] or shapes[0][:1] != ["word"] or not set(shapes[0]) <= {"word", ".", "->"}:
                continue
            first, second = self.plain(a1, b1), self.plain(a2, b2)
            if first == second or not self.are_alike(first.split(".")[-1], second.split(".")[-1]):
                continue
            yield k, "swap", {**{n: "" for n in (*range(a1, b1), *range(a2, b2))}, a1: second, a2: first}


def places(text):
    return Source(text).places
