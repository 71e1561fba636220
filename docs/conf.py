"""The site's build: the pages of this folder, and those that the code writes about itself.

Before Sphinx reads a page, :mod:`extensions` writes the reference pages of commands, optimizers and problems, draws the
figures of ``figures/``, and runs the tutorials whose results the pages show.
"""

import pydoc
import re
import sys
from contextlib import suppress
from importlib.metadata import metadata
from importlib.metadata import version as version_of
from operator import attrgetter
from pathlib import Path

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx

Signature = tuple[object, object]

ICONS = {"Repository": "code-branch", "Issues": "circle-dot", "Documentation": "book"}
HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # the extensions, blocks.py and the figures

(HERE / "_generated" / "site").mkdir(parents=True, exist_ok=True)  # Sphinx looks for it before it runs the tutorials

project = "backlash-bench"
author = "The backlash-bench authors"
project_copyright = f"{author}. Licence: Apache-2.0"
version = release = version_of("backlash-bench")

extensions = [
    "myst_parser", "sphinx_copybutton", "sphinx_design", "sphinx.ext.autodoc", "sphinx.ext.napoleon",
    "extensions.api", "extensions.commands", "extensions.plugins", "extensions.drawings", "extensions.results",
    "extensions.pictures", "extensions.performance", "extensions.columns", "extensions.atlas",
]  # fmt: skip
exclude_patterns = ["_build", "_generated"]
smartquotes_action = "qe"  # quotes and ellipses; two hyphens stay an option
suppress_warnings = ["myst.strikethrough"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

nitpicky = True
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
napoleon_use_rtype = False
napoleon_attr_annotations = False

html_theme = "pydata_sphinx_theme"
html_title = f"backlash-bench {version}"
copybutton_selector = "div:not(.output):not(.printed) > div.highlight > pre"  # what a reader types, not what is printed
html_static_path = ["_static"]
html_extra_path = ["_generated/site"]  # the reports of the tutorials
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "show_toc_level": 2,
    "navbar_end": ["theme-switcher", "navbar-icon-links"],
    "icon_links": [  # of [project.urls] in pyproject.toml, where there are any
        {"name": name, "url": url, "icon": f"fa-solid fa-{ICONS.get(name, 'link')}"}
        for name, url in (each.split(", ", 1) for each in metadata("backlash-bench").get_all("Project-URL", []))
    ],
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": [], "gallery": [], "explanation/comparison": [], "explanation/atlas/*": []}

linkcheck_anchors = False
linkcheck_timeout = 20


def setup(app: Sphinx) -> None:
    """Shorten types in signatures, accept references to code without a page, leave the places of named tuples out."""
    app.connect("autodoc-process-signature", shortened)
    app.connect("missing-reference", without_page)
    app.connect("doctree-read", lambda _, page: dashed(page))
    app.connect(
        "autodoc-skip-member", lambda *given: True if str(given[3].__doc__).startswith("Alias for field") else None
    )


def dashed(page: nodes.document) -> None:
    """Set a dash between a parameter and what it means: Sphinx writes hyphens, which the page does not make dashes."""
    for text in list(page.findall(lambda node: isinstance(node, nodes.Text) and node.astext() == " -- ")):
        text.parent.replace(text, nodes.Text(" – "))


def shortened(*given: object) -> Signature:
    """Return the signature and the return annotation, the last two of what is given, with short names of types."""
    name = r"~?(?:\w+\.)*"
    long = rf"{name}ndarray\[{name}tuple\[{name}Any, \.\.\.\], {name}dtype\[{name}\w+\]\]"
    like = rf"{name}_Buffer \| .*?{name}_NestedSequence\[{name}complex \| {name}bytes \| {name}str\]"
    field = rf"{name}Checked\[([^\]]*)\]"  # of a study: readers see what it holds
    default = r"<(?:factory|function [\w.]*(?:<lambda>)?)>"  # which Sphinx cannot read
    signature, annotation = (
        each
        and re.sub(default, "...", re.sub(field, r"\1", re.sub(like, "ArrayLike", re.sub(long, "ndarray", str(each)))))
        for each in given[-2:]
    )
    return signature, annotation


def without_page(app: Sphinx, env: object, node: pending_xref, text: nodes.TextElement) -> nodes.TextElement | None:
    """Return the text of a reference to a name that exists, here or in another package, but has no page on this site.

    Other packages have sites of their own, and this build reads none. A name that does not exist stays a warning.
    """
    del app, env
    target = node["reftarget"]
    here = [each for name, each in list(sys.modules.items()) if name.startswith(("bench", "optimizers", "numpy"))]
    last = target.rpartition(".")[2]  # a function may hide the module of its name, as bench.analysis.cells does
    known = pydoc.locate(target) or any(has(each, target) or has(each, last) for each in here)
    return text if node["refdomain"] == "py" and known else None


def has(thing: object, path: str) -> bool:
    """Return whether an object has an attribute, such as ``pd.Series``."""
    with suppress(AttributeError):
        attrgetter(path)(thing)
        return True
    return False
