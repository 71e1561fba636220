"""Fetch, check and read the recordings that the thesis's authors published, which are not part of this package."""
