"""What the README's reader types into Python: its blocks, joined.

usage: readme.py README.md
"""

import re
import sys
from pathlib import Path

_BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)

if __name__ == "__main__":
    print("\n".join(_BLOCK.findall(Path(sys.argv[1]).read_text(encoding="utf-8"))))
