"""What the README's reader types: its Python blocks, or the commands of its command list, one a line.

usage: readme.py python|commands README.md
"""

import re
import sys
from pathlib import Path

_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_WORD = re.compile(r"[a-z][a-z0-9-]*")


def python_of(text: str) -> str:
    """All Python blocks, joined."""
    return "\n".join(code for language, code in _BLOCK.findall(text) if language == "python")


def commands_of(text: str) -> list[str]:
    """Commands and subcommands without their arguments: `mat info | verify FILE  what it does` gives two."""
    commands = []
    for line in text.partition("\n## Commands\n")[2].partition("\n## ")[0].splitlines():
        usage = re.match(r"    ((?:mat|tmm) .*?)(?:\s\s|$)", line)
        if usage is None:
            continue
        first, *others = (_leading_words(part) for part in usage[1].split(" | "))
        commands += [first, *([*first[:-1], *other] for other in others if other)]
    return [" ".join(words) for words in commands]


def _leading_words(text: str) -> list[str]:
    words = []
    for word in text.split():
        if not _WORD.fullmatch(word):
            break
        words.append(word)
    return words


if __name__ == "__main__":
    kind, file = sys.argv[1:]
    text = Path(file).read_text(encoding="utf-8")
    print(python_of(text) if kind == "python" else "\n".join(commands_of(text)))
