"""The little Markdown that the report needs."""


def table(rows: list[dict], columns: dict[str, str]) -> str:
    """A Markdown table of dicts; columns: {name of the column: title}."""
    lines = ["| " + " | ".join(columns.values()) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(str(row.get(name, "")).replace("|", "\\|") for name in columns) + " |" for row in rows]
    return "\n".join(lines)


def literal(text: str) -> str:
    """Text in which an asterisk is an asterisk."""
    return text.replace("*", "\\*")
