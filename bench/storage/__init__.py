"""Study folders: the trials in SQLite, the files beside them, and the tidy frame read from them."""
