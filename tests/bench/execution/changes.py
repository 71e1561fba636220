"""Changes of code and data between two runs: what an optimizer or a problem is made of, and what is done to it."""

import os
import shutil
import sqlite3
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

READ = "json.loads(Path(HERE, {name!r}).read_text())"
TOP = "import json, os, sys\nfrom pathlib import Path\nHERE = os.path.dirname(os.path.abspath(__file__))\n"
END = """

def mine(objective, rng):
    share = {share}
    objective(objective.lower + share * (objective.upper - objective.lower))
    objective.stop("done")
"""


@dataclass(frozen=True)
class Change:
    """A change.

    Attributes:
        code: what comes before the optimizer, in its file ``opt.py``.
        share: the expression of the number that it depends on.
        files: the other files in its folder.
        after: these files after the change, None for one that is removed; a function does something else there.
        named: what a run must name; "" where only the second net can find it.
    """

    code: str = ""
    share: str = "SHARE"
    files: tuple = ()
    after: object = ()
    named: str = ""


def one(code, name, before, after, named="", share="SHARE"):
    """Return a change of one file."""
    return Change(code, share, ((name, before),), ((name, after),), named or name)


def _array(path, value):
    np.save(path, np.array([value]))


def _database(path, value):
    path.unlink(missing_ok=True)
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE t (v REAL)")
        connection.execute("INSERT INTO t VALUES (?)", (value,))
    connection.close()


def _zipped(path, value):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("zipped_helper.py", f"SHARE = {value}\n")


def _same_times(folder):
    """Write another content of the same size, and put the times back."""
    path = folder / "data.json"
    status = path.stat()
    path.write_text("0.75")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def _linked(folder):
    (folder / "data.json").unlink()
    (folder / "data.json").symlink_to("two.json")


def _hidden(folder):
    (folder / "first").mkdir()
    (folder / "first" / "hidden_helper.py").write_text("SHARE = 0.75\n")


SHARE, OTHER = "SHARE = 0.25\n", "SHARE = 0.75\n"
INSERT = "sys.path.insert(0, os.path.join(HERE, 'lib'))\n"

FIRST = {
    "constant": Change("SHARE = 0.25", after=(("opt.py", ("0.25", "0.75")),), named="opt.py"),
    "operator": Change("SHARE = 0.25 + 0.5", after=(("opt.py", (" + ", " * ")),), named="opt.py"),
    "default": Change(
        "def get(x=0.25):\n    return x", "get()", after=(("opt.py", ("x=0.25", "x=0.75")),), named="opt.py"
    ),
    "helper": one("from helper_1 import SHARE", "helper_1.py", SHARE, OTHER),
    "helper in a function": one(
        "def get():\n    from helper_2 import SHARE\n    return SHARE", "helper_2.py", SHARE, OTHER, share="get()"
    ),
    "sys.path.insert": one(INSERT + "from helper_3 import SHARE", "lib/helper_3.py", SHARE, OTHER),
    "import_module": one(
        "import importlib\nSHARE = importlib.import_module('helper_4').SHARE", "helper_4.py", SHARE, OTHER
    ),
    "import_module as im": one(
        "from importlib import import_module as im\nSHARE = im('helper' + '_5').SHARE", "helper_5.py", SHARE, OTHER
    ),
    "__import__": one("SHARE = __import__('helper_%d' % 6).SHARE", "helper_6.py", SHARE, OTHER),
    "spec_from_file_location": one(
        "from importlib.util import spec_from_file_location as s, module_from_spec as m\n"
        "spec = s('any', HERE + '/plain_7.py')\nmodule = m(spec)\n"
        "spec.loader.exec_module(module)\nSHARE = module.SHARE",
        "plain_7.py", SHARE, OTHER,
    ),
    "exec": one("exec(open(HERE + '/plain_8.py').read())", "plain_8.py", SHARE, OTHER),
    "runpy": one(
        "import runpy\nSHARE = runpy.run_path(HERE + '/plain_9.py')['SHARE']", "plain_9.py", SHARE, OTHER
    ),
    "package": Change(
        "from package_10 import SHARE", "SHARE",
        (("package_10/__init__.py", "from .inner import *\n"), ("package_10/inner.py", SHARE)),
        (("package_10/inner.py", OTHER),), "package_10/inner.py",
    ),
    "helper of a helper": Change(
        "from helper_11 import SHARE",
        "SHARE", (("helper_11.py", "from deep_11 import SHARE\n"), ("deep_11.py", SHARE)),
        (("deep_11.py", OTHER),), "deep_11.py",
    ),
    "base class": Change(
        "from base_12 import Base\nclass Own(Base):\n    pass",
        "Own.share", (("base_12.py", "class Base:\n    share = 0.25\n"),),
        (("base_12.py", "class Base:\n    share = 0.75\n"),), "base_12.py",
    ),
    "json": one(f"SHARE = {READ.format(name='data.json')}", "data.json", "0.25", "0.75"),
    "json in minimize": one("", "data.json", "0.25", "0.75", share=READ.format(name="data.json")),
    "loadtxt": one(
        "import numpy as np\nSHARE = float(np.loadtxt(HERE + '/data.txt'))", "data.txt", "0.25", "0.75"
    ),
    "read_csv": one(
        "import pandas as pd\nSHARE = pd.read_csv(HERE + '/data.csv')['v'].item()", "data.csv", "v\n0.25\n", "v\n0.75\n"
    ),
    "tomllib": one(
        "import tomllib\nSHARE = tomllib.load(open(HERE + '/data.toml', 'rb'))['v']",
        "data.toml", "v = 0.25", "v = 0.75"
    ),
    "configparser": one(
        "import configparser\nc = configparser.ConfigParser()\nc.read(HERE + '/data.ini')\nSHARE = float(c['a']['v'])",
        "data.ini", "[a]\nv = 0.25\n", "[a]\nv = 0.75\n",
    ),
    "numpy.load": one(
        "import numpy as np\nSHARE = float(np.load(HERE + '/data.npy', mmap_mode='r')[0])", "data.npy",
        lambda path: _array(path, 0.25), lambda path: _array(path, 0.75),
    ),
    "sqlite3": one(
        "import sqlite3\nc = sqlite3.connect(HERE + '/data.db')\n(SHARE,), = c.execute('SELECT v FROM t').fetchall()",
        "data.db", lambda path: _database(path, 0.25), lambda path: _database(path, 0.75),
    ),
    "variable": Change(
        "", "float(os.environ['BENCH_TEST_SHARE'])", (), lambda folder: os.environ.update(BENCH_TEST_SHARE="0.75"),
        "the variable BENCH_TEST_SHARE",
    ),
    "getenv": Change(
        "SHARE = float(os.getenv('BENCH_TEST_LATER', '0.25'))", "SHARE", (),
        lambda folder: os.environ.update(BENCH_TEST_LATER="0.75"), "the variable BENCH_TEST_LATER",
    ),
    "a file more": Change(
        "SHARE = 0.2 * len(list(Path(HERE, 'data').glob('*.csv')))", "SHARE", (("data/a.csv", "1"),),
        (("data/b.csv", "1"),), "the files in",
    ),
    "a file that was missing": Change(
        "try:\n    SHARE = float(open(HERE + '/local.txt').read())\nexcept OSError:\n    SHARE = 0.25", "SHARE", (),
        (("local.txt", "0.75"),), "local.txt",
    ),
    "the same size and times": Change(
        f"SHARE = {READ.format(name='data.json')}", "SHARE", (("data.json", "0.25"),), _same_times, "data.json"
    ),
}  # fmt: skip

OWN = {
    "zip": one(
        "sys.path.insert(0, HERE + '/z.zip')\nfrom zipped_helper import SHARE", "z.zip",
        lambda path: _zipped(path, 0.25), lambda path: _zipped(path, 0.75),
    ),
    "link": Change(
        f"SHARE = {READ.format(name='data.json')}", "SHARE",
        (("one.json", "0.25"), ("two.json", "0.75"), ("data.json", lambda path: path.symlink_to("one.json"))),
        _linked, "data.json",
    ),
    "hidden module": Change(
        "sys.path[:0] = [HERE + '/first', HERE + '/second']\nfrom hidden_helper import SHARE", "SHARE",
        (("second/hidden_helper.py", SHARE),), _hidden, "hidden_helper.py",
    ),
    "module becomes a package": Change(
        "from turned_helper import SHARE", "SHARE", (("turned_helper.py", SHARE),),
        (("turned_helper/__init__.py", OTHER),), "turned_helper/__init__.py",
    ),
    "numba": Change(
        "from jitted_helper import share\nfrom numba import njit\n@njit(cache=True)\ndef get():\n    return share()",
        "get()", (("jitted_helper.py", "from numba import njit\n@njit\ndef share():\n    return 0.25\n"),),
        (("jitted_helper.py", "from numba import njit\n@njit\ndef share():\n    return 0.75\n"),), "jitted_helper.py",
    ),
    "pickle": one(
        "import pickle\nSHARE = pickle.load(open(HERE + '/data.pkl', 'rb'))", "data.pkl",
        lambda path: path.write_bytes(b"\x80\x04\x95\x0a\x00\x00\x00\x00\x00\x00\x00G?\xd0\x00\x00\x00\x00\x00\x00."),
        lambda path: path.write_bytes(b"\x80\x04\x95\x0a\x00\x00\x00\x00\x00\x00\x00G?\xe8\x00\x00\x00\x00\x00\x00."),
    ),
    "gzip": one(
        "import gzip\nSHARE = float(gzip.open(HERE + '/data.gz', 'rt').read())", "data.gz",
        lambda path: path.write_bytes(__import__("gzip").compress(b"0.25")),
        lambda path: path.write_bytes(__import__("gzip").compress(b"0.75")),
    ),
    "importlib.resources": Change(
        "from importlib.resources import files\nSHARE = float(files('package_20').joinpath('v.txt').read_text())",
        "SHARE", (("package_20/__init__.py", ""), ("package_20/v.txt", "0.25")),
        (("package_20/v.txt", "0.75"),), "v.txt",
    ),
    "pkgutil.get_data": Change(
        "import pkgutil\nSHARE = float(pkgutil.get_data('package_21', 'v.txt'))", "SHARE",
        (("package_21/__init__.py", ""), ("package_21/v.txt", "0.25")), (("package_21/v.txt", "0.75"),), "v.txt",
    ),
    "os.open": one(
        "SHARE = float(os.read(os.open(HERE + '/data.txt', os.O_RDONLY), 9))", "data.txt", "0.25", "0.75"
    ),
    "mmap": one(
        "import mmap\nSHARE = float(mmap.mmap(os.open(HERE + '/data.txt', os.O_RDONLY), 0, prot=mmap.PROT_READ)[:])",
        "data.txt", "0.25", "0.75",
    ),
    "np.memmap": one(
        "import numpy as np\nSHARE = float(np.memmap(HERE + '/data.raw', float, 'r')[0])", "data.raw",
        lambda path: path.write_bytes(np.float64(0.25).tobytes()),
        lambda path: path.write_bytes(np.float64(0.75).tobytes()),
    ),
    "a program that it starts": Change(
        "import subprocess", "float(subprocess.run(['sh', HERE + '/say.sh'], capture_output=True).stdout)",
        (("say.sh", "echo 0.25\n"),), (("say.sh", "echo 0.75\n"),), "say.sh",
    ),
    "a listing": Change(
        "SHARE = 0.2 * len(os.listdir(HERE + '/data'))", "SHARE", (("data/a.csv", "1"),), (("data/b.csv", "1"),),
        "the files in",
    ),
    "a removed file": Change(
        "SHARE = float(open(HERE + '/l.txt').read()) if os.path.exists(HERE + '/l.txt') else 0.75", "SHARE",
        (("l.txt", "0.25"),), (("l.txt", None),), "l.txt",
    ),
    "an annotation": Change("SHARE: float = 0.25", after=(("opt.py", ("0.25", "0.75")),), named="opt.py"),
    "bytes that are no text": one(
        "SHARE = open(HERE + '/data.bin', 'rb').read()[0] / 255", "data.bin", lambda path: path.write_bytes(b"\x20"),
        lambda path: path.write_bytes(b"\xe0"),
    ),
    "what C opens": Change(
        "import ctypes\nC = ctypes.CDLL(None)\nC.fopen.restype, C.fgetc.argtypes = ctypes.c_void_p, [ctypes.c_void_p]",
        "C.fgetc(C.fopen((HERE + '/data.bin').encode(), b'r')) / 255", (("data.bin", "a"),), (("data.bin", "z"),),
    ),
    "what a program reads": Change(
        "import subprocess", "float(subprocess.run(['sh', HERE + '/say.sh'], capture_output=True).stdout)",
        (("say.sh", 'cat "$(dirname "$0")/value.txt"\n'), ("value.txt", "0.25")), (("value.txt", "0.75"),),
    ),
    "a variable of a program": Change(
        "import subprocess", "float(subprocess.run('echo $BENCH_TEST_SHELL', shell=True, capture_output=True).stdout)",
        (), lambda folder: os.environ.update(BENCH_TEST_SHELL="0.75"),
    ),
}  # fmt: skip

VARIABLES = {"BENCH_TEST_SHARE": "0.25", "BENCH_TEST_SHELL": "0.25"}


def write(folder: Path, files):
    """Write, change or remove files of a folder."""
    for name, content in files:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if content is None:
            path.unlink()
        elif callable(content):
            content(path)
        elif isinstance(content, tuple):
            path.write_text(path.read_text().replace(*content))
        else:
            path.write_text(content)


def place(folder: Path, change: Change):
    """Write an optimizer before its change; return its file."""
    shutil.rmtree(folder, ignore_errors=True)
    write(folder, [("opt.py", TOP + change.code + END.format(share=change.share)), *change.files])
    return folder / "opt.py"


def apply(folder: Path, change: Change):
    """Make the change."""
    if callable(change.after):
        change.after(folder)
    else:
        write(folder, change.after)
