"""pandas, which is optional."""


def pandas():
    """The module."""
    try:
        import pandas as module
    except ImportError:
        raise ImportError("pandas is missing: pip install './python[pandas]'") from None
    return module
