"""Plain tables of trials and of improvements: CSV read and written, Parquet written."""
