"""A topic of reports: who is best, by how much, how sure that is, and the first picture."""
