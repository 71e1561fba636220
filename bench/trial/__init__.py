"""One trial: its scores, its run and the columns of its row."""
