"""``python -m epicyclic``: the command line."""

from .cli.main import main

__all__: list[str] = []

if __name__ == "__main__":
    main()
