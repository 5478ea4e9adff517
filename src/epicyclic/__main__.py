"""``python -m epicyclic`` and the command ``epicyclic``, which hear Ctrl-C from the first import on."""

import gc
import sys


def main() -> None:
    """Run the command line; Ctrl-C while it is imported ends it as at any other time."""
    gc.disable()  # `cli.output` enables it
    try:
        from .cli.main import main as run
    except KeyboardInterrupt:
        sys.stderr.write("stopped\n")
        sys.exit(130)
    run()


if __name__ == "__main__":
    main()
