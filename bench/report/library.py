"""What the page needs to draw Vega-Lite specifications: the libraries, data that cannot end their element, hashes."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from importlib import resources

from markupsafe import Markup

SCRIPTS = {
    "vega-6.2.0.min.js": "ea6a5936381d06f912466354e2b6a20eb66c4d41f1ca9dff1e0236dfee6ee392",
    "vega-lite-6.4.1.min.js": "6d5035fdd429b4bc6f91f3754426c3f516f3dbd8e08b105cfc2496bed4ebd254",
    "vega-embed-7.0.2.min.js": "c7111a41190080938b14c1de00074d9bda16ef2199e2919dd038cddf97d87354",
}
"""SHA-256 of each script, in the order in which one needs the other: ``build/NAME.min.js`` of the npm package NAME."""


@cache
def library() -> Markup:
    """Return the libraries, with their licenses, as one script that defines ``vegaEmbed``."""
    folder = resources.files("bench.report").joinpath("vega")
    licenses, *scripts = (folder.joinpath(name).read_text(encoding="utf-8") for name in ("LICENSES", *SCRIPTS))
    text = "\n".join([f"/*\n{licenses}*/", *scripts])
    return Markup(text.replace("</script", "<\\/script").replace("<!--", "<\\!--"))  # cannot end its element


def as_json(data: object) -> Markup:
    """Return JSON for an element of HTML: in ASCII, and without a character that could end the element."""
    text = json.dumps(data, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))


def digest(script: str) -> str:
    """Return the SHA-256 of a script as a Content-Security-Policy has it."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
