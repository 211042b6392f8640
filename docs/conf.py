"""Sphinx configuration of the site: the pages of this folder and generated ones (_pages.py).

scripts/docs builds it.
"""

import sys
from pathlib import Path

from latex2mathml.converter import convert

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
import _pages  # noqa: E402

import hpc_gfmd  # noqa: E402

project = "hpc-gfmd"
author = "the hpc_gfmd developers"
copyright = author
version = release = hpc_gfmd.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "numpydoc"]
exclude_patterns = ["_build", "study/*.txt"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_timeout = 900  # seconds for a cell
nb_execution_raise_on_error = True
nb_output_stderr = "remove"  # that kernels are compiled
numpydoc_show_class_members = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the numpydoc sections have them

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = f"hpc-gfmd {version}"
html_math_renderer = "mathml"
html_show_copyright = False
html_copy_source = False


def _inline(writer, node):
    writer.body.append(convert(node.astext()))
    raise _skip()


def _display(writer, node):
    writer.body.append(convert(node.astext(), display="block"))
    raise _skip()


def _skip():
    from docutils.nodes import SkipNode

    return SkipNode()


def _plain_bars(app, what, name, thing, options, lines):
    lines[:] = [line.replace("|", "\\|") for line in lines]  # |q| is a formula, not a substitution


def setup(app):
    """Write formulas as MathML, which browsers render without scripts from the network.

    Bars in docstrings are escaped here, so that they stay readable in a terminal.
    """
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    app.connect("autodoc-process-docstring", _plain_bars, priority=100)
    _pages.write(HERE / "generated")
    _pages.copy_notebooks(HERE / "generated")
