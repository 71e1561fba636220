"""Tables as LaTeX: what they say, and that a real LaTeX takes them whatever they hold."""

import os
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.report.latex import ACCENTS, LAYOUTS, SYMBOLS, escape, to_latex
from bench.report.parts import Table, Typography

HOSTILE = [
    "&%$#_{}~^\\<>|\"'`", "[1] at a row's start", "*starred", "[", "]", "\\\\[2em]", "\\input{/etc/passwd}", "}{",
    "line\nbreak\r\n\ttab", "日本語 한국어", "emoji 👩\u200d👩\u200d👧 🦊", "e\u0301 q\u0328 z" + "\u0301" * 300,
    "עברית \u202eltr\u202c", "zero\u200bwidth\ufeff\u00ad", "bell\x07 null\x00", "a--b---c ?`!` ,, <<", "^^41", "$$",
    "", " ", "x" * 500, "Łódź Çelik Ægir ŠKODA naïve ő ů ḥ ḇ ﬁ Ω R² 10⁻⁵ x₁ → ≠ ½ “q” ‘s’ … € °", "%\n\\end{table}",
]  # fmt: skip


needs_pdflatex = pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")


PACKAGES = "\\usepackage{booktabs,graphicx}"


def compiled(folder, body, preamble=PACKAGES, options="", engine="pdflatex", name="article"):
    """Return the log of a document that must compile, its lines unbroken."""
    source = f"\\documentclass[{options}]{{{name}}}\n{preamble}\n\\begin{{document}}\n{body}\n\\end{{document}}\n"
    (folder / "document.tex").write_text(source, encoding="utf-8")
    command = [engine, "-halt-on-error", "-interaction=nonstopmode", "-no-shell-escape", "document.tex"]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=300, check=False,
        env=os.environ | {"max_print_line": "1000"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:]
    return done.stdout


def overfull(log):
    return [float(points) for points in re.findall(r"Overfull \\hbox \(([\d.]+)pt too wide\)", log)]


def comparison(problems=18, optimizers=5, **options):
    rng = np.random.default_rng(1)
    labels = ["cma-es", "alo", "goa", "gwo", "da", *(f"method-{i}" for i in range(optimizers))][:optimizers]
    index = pd.Index([f"signature-{i + 3:02}" for i in range(problems)], name="problem")
    frame = pd.DataFrame(rng.uniform(2, 40, (problems, optimizers)), index, labels)
    best = frame.eq(frame.min(axis=1), axis=0)
    note = "Bold: the lowest mean of the row. Italics: an exact test cannot separate the result from the best one’s."
    return Table(
        "comparison",
        "Mean of the best value.",
        frame,
        Typography(bold=best, italic=~best & (frame < 9)),
        note=note,
        **options,
    )


def checkpoints(rows):
    index = pd.MultiIndex.from_product(
        [[f"cec2022-f{i:02}-d10" for i in range(rows)], ["scipy:differential_evolution"]],
        names=["problem", "optimizer"],
    )
    frame = pd.DataFrame(4.7e9, index, [f"{0.01 * (i + 1):.2f}" for i in range(16)])
    return Table("checkpoints", "Median error.", frame, Typography(texts=frame.map("{:.1e}".format)))


class TestEscape:
    @pytest.mark.parametrize(
        ("text", "shown"),
        [
            ("a_1 & 50% #2", r"a\_1 \& 50\% \#2"), ("a  b\nc", "a b c"), ("Demšar", r"Dem\v{s}ar"),
            ("e\u0301", r"\'{e}"), ("ế", r"\'{\^{e}}"), ("−1 ≤ α", r"$-$1 $\leq$ $\alpha$"), ("日", "[U+65E5]"),
            ("\u200b", "[U+200B]"), ("ą", "a[U+0328]"), ("한", "[U+D55C]"), ("≠", r"$\neq$"), ("1–2", "1--2"),
            ("1--2", "1-{}-2"), ("---", "-{}-{}-"), ("?`", r"?\`{}"), ('"', "''"), ("\x00", "[U+0000]"),
            ("\ud800", "[U+D800]"),
        ],
    )  # fmt: skip
    def test_characters(self, text, shown):
        assert escape(text) == shown

    @given(st.text())
    def test_any_text_is_one_line_of_ascii_with_balanced_braces(self, text):
        shown = escape(text)
        assert shown.isascii()
        assert shown.isprintable()
        bare = re.sub(r"\\[{}]", "", shown)
        assert bare.count("{") == bare.count("}")


class TestToLatex:
    def test_rules_marks_and_escapes(self):
        index = pd.Index(["p&q", "r"], name="problem")
        frame = pd.DataFrame({"a_1": [1.25, np.inf], "b": [2.0, np.nan]}, index)
        bold = pd.DataFrame({"a_1": [True, False]}, index)
        text = to_latex(
            Table(
                "t", "100% of it", frame, Typography(bold=bold, italic=~bold), decimals={"a_1": 2, "b": 1}, note="x_y"
            ),
            "t",
        )
        assert all(rule in text for rule in (r"\toprule", r"\midrule", r"\bottomrule", r"\label{tab:t}"))
        assert r"\caption{100\% of it}" in text
        assert r"p\&q & \textbf{1.25} & 2.0 \\" in text
        assert r"r & \textit{$\infty$} & -- \\" in text
        assert r"a\_1" in text
        assert r"x\_y" in text


@needs_pdflatex
class TestCompiled:
    def test_hostile_names_everywhere(self, tmp_path):
        values = np.linspace(-1e-9, 1e9, len(HOSTILE))
        names = [*HOSTILE[:-1], "last"]
        tables = [
            Table(
                names[0], " ".join(HOSTILE), pd.DataFrame({"text": HOSTILE, HOSTILE[0]: values}), note=" ".join(HOSTILE)
            ),
            Table("index", "c", pd.DataFrame(1.0, pd.Index(HOSTILE, name=HOSTILE[1]), ["a", *HOSTILE[:4]])),
            *(Table(name, name, pd.DataFrame({name: [name]}), note=name) for name in HOSTILE),
            Table("short", "c", pd.DataFrame({"x": [name[:30] for name in HOSTILE]})),
            Table("long", HOSTILE[0], pd.DataFrame({"x": HOSTILE * 5, "y": 1.0}), note=HOSTILE[0]),
            Table("titles", "日" * 5000, pd.DataFrame({"日" * 500: [1.0], "x" * 5000: [2], "y " * 1000: ["z"]})),
            Table("empty", "No rows.", pd.DataFrame({"x": []})),
            Table("nothing", "No columns.", pd.DataFrame()),
            Table("wide", "Too many columns.", pd.DataFrame(1.0, range(3), [f"column {i}" for i in range(60)])),
        ]
        for i, table in enumerate(tables):
            (tmp_path / f"{i}.tex").write_text(to_latex(table, f"{i}"), encoding="utf-8")
        compiled(tmp_path, "\n".join(f"\\input{{{i}}}\\clearpage" for i in range(len(tables))))

    @pytest.mark.parametrize("fonts", ["OT1", "T1"])
    def test_every_character_of_the_tables_of_characters(self, fonts, tmp_path):
        letters = [letter + mark for letter in "aAiIzZ" for mark in ACCENTS] + list(map(chr, range(0xA0, 0x250)))
        text = escape(" ".join([*SYMBOLS, *letters]))
        body = text if fonts == "T1" else f"{text} \\textbf{{\\boldmath {text}}} \\textit{{{text}}}"
        log = compiled(tmp_path, body, f"\\usepackage[{fonts}]{{fontenc}}")
        assert "Missing character" not in log

    @pytest.mark.slow
    @pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
    def test_tables_of_every_shape_fit_the_class_of_a_layout(self, layout, tmp_path):
        options, name = re.search(r"(?:\[(.*)\])?\{(\w+)\}", layout.document).groups()
        if subprocess.run(["kpsewhich", f"{name}.cls"], capture_output=True, check=False).returncode:
            pytest.skip(f"the class {name} is not installed (Debian: texlive-publishers)")
        shapes = [
            comparison(*shape) for shape in ((18, 5), (45, 5), (58, 4), (80, 3), (120, 9), (90, 20), (12, 16), (24, 96))
        ]
        tall = [
            replace(comparison(60, 9), note="A word of it. " * 150),
            replace(shapes[1], caption="Many words. " * 40),
        ]
        tables = [*shapes, *tall, checkpoints(40)]
        body = "\n\\clearpage\n".join(to_latex(table, f"t{number}", layout) for number, table in enumerate(tables))
        log = compiled(
            tmp_path, f"\\title{{T}}\\author{{A}}\\maketitle Text.\n{body}", options=options or "", name=name
        )
        assert "Float too large" not in log
        assert max(overfull(log), default=0) < 4
