"""The type of numeric arguments: 0.25, 1e-3 and 1/1024."""


def number(text: str) -> float:
    """A float from a decimal number or a ratio of two; ValueError otherwise."""
    top, slash, bottom = text.partition("/")
    try:
        return float(top) / float(bottom) if slash else float(top)
    except ZeroDivisionError:
        raise ValueError(text) from None
