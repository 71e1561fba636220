"""Small helpers that know nothing of benchmarking; plug-ins may use those that are named here."""

from bench.helpers.atomic import replacing
from bench.helpers.bibtex import read
from bench.helpers.console import pairs, print_error, print_line
from bench.helpers.parsing import Json, JsonObject, parse_toml, read_text
from bench.helpers.programs import ProgramCommand, Talk, short
from bench.helpers.text import count, file_name, printable, unique

__all__ = [
    "Json", "JsonObject", "ProgramCommand", "Talk", "count", "file_name", "pairs", "parse_toml", "print_error",
    "print_line", "printable", "read", "read_text", "replacing", "short", "unique",
]  # fmt: skip
