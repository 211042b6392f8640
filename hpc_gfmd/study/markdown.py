"""The little Markdown that the report needs."""


def table(rows, columns):
    """A Markdown table of dicts; columns: {name of the column: title}."""
    lines = ["| " + " | ".join(columns.values()) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(str(row.get(name, "")).replace("|", "\\|") for name in columns) + " |" for row in rows]
    return "\n".join(lines)


def literal(text):
    """Text in which an asterisk is an asterisk."""
    return text.replace("*", "\\*")
