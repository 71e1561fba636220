"""The site's build: the pages of this folder, and those that the code writes about itself.

Before Sphinx reads a page, :mod:`extensions` writes the reference pages of commands, optimizers and problems, draws the
figures of ``figures/``, and runs the tutorials whose results the pages show.
"""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # the extensions, blocks.py and the figures

(HERE / "_generated" / "site").mkdir(parents=True, exist_ok=True)  # Sphinx looks for it before it runs the tutorials

project = "backlash-bench"
author = "The backlash-bench authors"
project_copyright = f"{author}. Licence: Apache-2.0"
version = release = version_of("backlash-bench")

extensions = [
    "myst_parser", "sphinx_design", "sphinx.ext.autodoc", "sphinx.ext.napoleon",
    "extensions.commands", "extensions.plugins", "extensions.drawings", "extensions.results",
]  # fmt: skip
exclude_patterns = ["_build", "_generated"]
suppress_warnings = ["myst.strikethrough"]

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

nitpicky = True
# Types of other packages: their documentation is on other sites, and this build reads none.
nitpick_ignore_regex = [
    ("py:.*", r"(numpy|pandas|matplotlib|scipy|collections|pathlib|typing|np|pd|abc|types|dataclasses|pytest)\b.*"),
    ("py:.*", r"(array_like|optional|callable|[A-Z][A-Za-z]*|_.*)"),
    ("py:.*", r"(bench|problems|optimizers)\..*"),
    ("py:.*", r"[a-z_]+(\.[a-z_A-Z]+)*"),
]
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
# Names of types stay names: an array's own type is a line long.
autodoc_type_aliases = {
    name: name for name in ("ArrayLike", "Budget", "Budgets", "Counts", "Floats", "Looks", "Source", "Traces")
}
napoleon_use_rtype = False

html_theme = "pydata_sphinx_theme"
html_title = "backlash-bench"
html_static_path = ["_static"]
html_extra_path = ["_generated/site"]  # the reports of the tutorials
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "show_toc_level": 2,
    "show_prev_next": False,
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": []}

linkcheck_anchors = False
linkcheck_timeout = 20
