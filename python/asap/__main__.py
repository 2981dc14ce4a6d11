"""``python -m asap`` is the command ``asap``."""

import sys

from asap.cli import main

if __name__ == "__main__":
    sys.exit(main())
