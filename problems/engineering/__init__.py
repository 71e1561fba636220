"""The family ``engineering``: the usual constrained design problems, with their best-known designs."""
