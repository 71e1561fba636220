"""Names that no file, page or table expects."""

HOSTILE = [
    "../../etc/passwd",
    "a/b:c",
    "<script>alert(1)</script>",
    "x & y_1 100% $z$ {q} ~ ^ \\",
    "..",
    "",
    "con\nnew",
    "日本",
]
