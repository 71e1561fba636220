"""Small helpers of the harness, which know nothing of benchmarking; not for plug-ins."""
