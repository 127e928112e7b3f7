"""Lengths of C++ functions, found by following braces (no compiler needed).

A function is as long as its lines from the first line of its signature to its closing brace;
lambdas count into the function around them.
"""

import dataclasses
import re

_STRING_OR_COMMENT = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<tag>[^()\s\\]{0,16})\(.*?\)(?P=tag)"'
    r'|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Za-z_])\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
_PREPROCESSOR = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.MULTILINE)
_TYPE_HEAD = re.compile(r"\b(class|struct|union|enum)\b")
_ACCESS = re.compile(r"\s*(public|private|protected)\s*")
_ATTRIBUTE = re.compile(r"\[\[.*?\]\]|\balignas\s*\([^()]*\)|\bnoexcept\s*\([^()]*\)", re.DOTALL)


@dataclasses.dataclass(frozen=True)
class Function:
    path: str
    line: int  # of the signature, from 1
    name: str
    lines: int


def _blank(match):
    """Keeps line breaks, so that line numbers stay right; a literal becomes one x."""
    text = match.group(0)
    filler = "" if text.startswith(("//", "/*", "#")) or text.lstrip().startswith("#") else "x"
    return filler + "\n" * text.count("\n")


def strip(text):
    """The code without comments, literals and preprocessor lines."""
    return _PREPROCESSOR.sub(_blank, _STRING_OR_COMMENT.sub(_blank, text))


def _drop_angles(head):
    """Removes <...> groups, template headers included."""
    head = re.sub(r"operator\s*(<<=?|>>=?|<=>|<=|>=|->\*?|<|>)", "operator_", head)
    head = head.replace("->", "  ")
    before = None
    while before != head:
        before = head
        head = re.sub(r"<[^<>]*>", " ", head)
    return head


def _top_level(head):
    """The head with everything inside parentheses removed (the pairs stay)."""
    out, depth = [], 0
    for c in head:
        if c == ")":
            depth -= 1
        if depth == 0:
            out.append(c)
        if c == "(":
            depth += 1
    return "".join(out)


def classify(head):
    """What a '{' after `head` opens at namespace or class scope: scope, function or other."""
    head = _drop_angles(_ATTRIBUTE.sub(" ", head)).strip()
    if re.search(r"\bnamespace\b", head) or re.fullmatch(r"extern\s+x", head):
        return "scope"
    top = _top_level(head)
    if _TYPE_HEAD.search(top) and "(" not in top:
        return "other" if re.search(r"\benum\b", top) else "scope"
    if "(" not in top:
        return "other"
    no_operators = re.sub(r"operator\s*(\(\)|[^\s\w(]+)", "operator_", top)
    if "=" in no_operators:
        return "other"
    initialisers = re.search(r"\)[^:]*(?<!:):(?!:)", no_operators)
    if initialisers and re.search(r"[\w>]$", head):
        return "other"  # a member initialiser a_{...}; the body is still to come
    return "function"


def _name(head):
    head = _drop_angles(head)
    test = re.match(r"\s*(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP)\s*\(\s*(\w+)\s*,\s*(\w+)", head)
    if test:
        return f"{test.group(1)}.{test.group(2)}"
    match = re.search(r"([~\w:]*operator\s*(?:\(\)|[^\s(]+)|[~\w:]+)\s*\(", head)
    return match.group(1) if match else "?"


def functions(path, text):
    """All functions of a file, in order."""
    code = strip(text)
    found, stack, start = [], [], 0  # stack of (kind, head, line of the head)
    inside = 0  # depth of braces within a function or an initialiser
    for i, c in enumerate(code):
        if c == "{":
            head = code[start:i]
            kind = "nested" if inside else classify(head)
            first = start + len(head) - len(head.lstrip())
            stack.append((kind, head.strip(), code.count("\n", 0, first) + 1, start))
            inside += kind != "scope"
            start = i + 1 if kind == "scope" else start
        elif c == "}" and stack:
            kind, head, line, head_start = stack.pop()
            inside -= kind != "scope"
            if kind == "function":
                lines = code.count("\n", 0, i) + 1 - line + 1
                found.append(Function(path, line, _name(head), lines))
            if not inside and kind != "nested":
                # After an initialiser the head goes on: `: a_{1}, b_{2} {`.
                start = head_start if kind == "other" else i + 1
        elif not inside and (c == ";" or c == ":" and _ACCESS.fullmatch(code, start, i)):
            start = i + 1
    return found
