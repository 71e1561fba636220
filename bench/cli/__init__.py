"""The command line, one file a command; each imports the harness only when it is called, so that `--help` is fast."""
