"""Run plug-in code in a separate process, and detect and undo its side effects."""
