"""The recordings that the thesis's authors published, which are no part of this package: fetched, checked and read."""
