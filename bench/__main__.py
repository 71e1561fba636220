"""``python -m bench`` is the same as ``bench``, and imports nothing from the working folder either."""

import os
import sys

if __name__ == "__main__":
    if not sys.flags.safe_path and sys.path[:1] == [os.getcwd()]:  # noqa: PTH109 - pathlib could be a file there
        del sys.path[0]

    from bench.cli.app import main

    main()
