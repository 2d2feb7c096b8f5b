"""Numbers of things, as messages name them."""


def counted(number: int, thing: str) -> str:
    """``"1 piece"``, ``"2 pieces"``."""
    return f"{number} {thing}{'s' * (number != 1)}"
