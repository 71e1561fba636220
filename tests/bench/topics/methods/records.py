"""What a run notes of itself and its machine."""

RECORD = {
    "packages": {"numpy": "2.4.6", "scipy": "1.17.1"}, "python": "3.11.7",
    "system": "Linux-6.1.0-x86_64-with-glibc2.36", "host": "one", "processor": "Xeon", "cores": 2, "memory_gb": 8.0,
    "blas": [{"library": "openblas", "version": "0.3.30", "threads": 1}],
    "git": {"commit": "6b3d6c0" + "0" * 33, "dirty": False}, "harness": "backlash-bench 0.1.0 (code 12ab34cd)",
    "started": "2026-01-02T03:04:05+00:00", "ended": "2026-01-02T04:00:00+00:00", "command": "bench run s", "jobs": 2,
    "backend": "local", "study": "abc", "data": {}, "code": {}, "timeout": None, "shard": None,
}  # fmt: skip
