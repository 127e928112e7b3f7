"""Words that must not appear in the project's files."""

import re

# (pattern, why, files it applies to). Written in pieces so that this file passes its own check.
_ANY = re.compile(r".*")
_CPP = re.compile(r".*\.(h|cc)$")
_BUILD = re.compile(r"(.*/)?CMakeLists\.txt$|.*\.cmake$|CMakePresets\.json$")
_RULES = [
    (re.compile(r"(?<![\w.~$}])/(?:wo" r"rk|ro" r"ot|ho" r"me)/"), "path of one machine", _ANY),
    (re.compile(r"(?<![\w.~$}])/t" r"mp\b"), "fixed temporary folder", _ANY),
    (re.compile(r"\.\./sha" r"red\b"), "folder outside the project", _ANY),
    (re.compile(r"(?:py" r"pi\.org|pythonho" r"sted|deb\.deb" r"ian\.org|crat" r"es\.io)"),
     "package registry host", _ANY),
    (re.compile(r"\b(?:TO" r"DO|FIX" r"ME|XX" r"X)\b"), "unfinished work: file an issue", _ANY),
    (re.compile(r"-march=na" r"tive"), "binaries must run elsewhere", _BUILD),
    (re.compile(r"\b(?:std::)?(?:abort|terminate|_Exit|quick_exit)\s*\("), "never abort", _CPP),
    (re.compile(r"(?<![\w_])assert\s*\("), "use TVL_CHECK", _CPP),
    (re.compile(r"\busing\s+namespace\s+std\b"), "using namespace std", _CPP),
    (re.compile(r"^\s*// ?(?:[\w:<>]+\s+)?\w[\w.\->]*\s*(?:=[^=].*|\(.*\));\s*$"),
     "commented-out code", _CPP),
]
EXEMPT = {".ci/run": {"folder outside the project"}}


def errors(path, text):
    """One message a line and rule that is broken."""
    rules = [r for r in _RULES if r[2].match(path) and r[1] not in EXEMPT.get(path, ())]
    found = []
    for number, line in enumerate(text.split("\n"), 1):
        for pattern, why, _ in rules:
            match = pattern.search(line)
            if match:
                found.append(f"{path}:{number}: '{match.group(0).strip()}': {why}")
    return found
