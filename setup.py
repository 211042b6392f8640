"""README.md for pages that are not beside the files it names: its links made absolute. All else stands in setup.cfg."""

import re
from configparser import ConfigParser
from pathlib import Path

from setuptools import setup

HERE = Path(__file__).parent
config = ConfigParser()
config.read(HERE / "setup.cfg", encoding="utf-8")
url = config["metadata"]["url"]
version = re.search(r'^__version__ = "(.+)"', (HERE / "hpc_gfmd" / "__init__.py").read_text(encoding="utf-8"), re.MULTILINE)[1]


def absolute(match):
    """A link or a picture, as forges serve them at the release's tag."""
    picture, text, target = match.groups()
    return f"{picture}[{text}]({url}/{'raw' if picture else 'blob'}/v{version}/{target})"


readme = (HERE / "README.md").read_text(encoding="utf-8")
setup(long_description=re.sub(r"(!?)\[([^\]]*)\]\((?!https?:|#)([^)]+)\)", absolute, readme),
      long_description_content_type="text/markdown")
