"""Study folders: the trials in SQLite, and the files beside them."""
